"""Shipped protocols of the sources: variants differ in what they say, studies are as printed."""

from __future__ import annotations

import json
from collections import Counter
from itertools import pairwise

import pytest

from vrcomfort.csv_table import CsvTable
from vrcomfort.design import build_design
from vrcomfort.protocol.load import load_protocol

NOT_COMPARED = {"name", "title", "text", "source", "path"}


def settings(name, *without):
    """Return what a protocol sets, but for its names and some paths like `conditions.1.focus`."""
    data = load_protocol(name).model_dump(mode="json", exclude=NOT_COMPARED)
    for path in without:
        *parts, last = path.split(".")
        table = data
        for part in parts:
            table = table[int(part) if part.isdigit() else part]
        table.pop(last)
    return data


@pytest.mark.parametrize(
    ("variant", "differences"),
    [
        ("hillaire_2008_strong", ["conditions.1.depth_of_field.aperture_m"]),
        ("carnegie_2015_sessions", ["order"]),
        (
            "carnegie_2015_as_printed",
            [
                "hours_between_sessions",
                "covariates",
                "screening",
                "instructions",
                "stop",
                "questionnaires",
                "simulation",
            ],
        ),
        ("carnegie_2015_scatter", ["conditions.1.depth_of_field.kernel"]),
        (
            "carnegie_2015_dioptre",
            [
                "conditions.1.depth_of_field.law",
                "conditions.1.depth_of_field.full_blur_m",
                "conditions.1.depth_of_field.full_blur_dioptre",
            ],
        ),
    ],
)
def test_a_variant_differs_in_what_it_says_and_in_nothing_else(variant, differences):
    base = "_".join(variant.split("_")[:2])
    assert settings(variant, *differences) == settings(base, *differences)
    for path in differences:
        others = [each for each in differences if each != path]
        if path.endswith(("full_blur_m", "full_blur_dioptre")):
            continue  # each says what the law of its own file needs
        assert settings(variant, *others) != settings(base, *others)


def test_blur_by_session_has_one_condition_a_session_and_each_first_equally_often():
    first = Counter()
    for participant in build_design(load_protocol("carnegie_2015_sessions"), seed=5).plan(20):
        kinds = [{trial.condition for trial in session} for session in participant.sessions]
        assert sorted(map(sorted, kinds)) == [["dof_off"], ["dof_on"]]
        one, two = ([trial.scene for trial in session] for session in participant.sessions)
        assert one == two[::-1]
        first[(*kinds[0], one[0])] += 1
    assert set(first.values()) == {5}


def test_mantiuk_practises_two_trials_of_the_participants_own():
    (practice,) = load_protocol("mantiuk_2011").practice
    assert (practice.before_trial, practice.draw, practice.has_criterion) == (1, 2, False)


def test_mantiuk_shows_each_of_four_views_in_four_ways_and_none_twice_in_a_row():
    protocol = load_protocol("mantiuk_2011")
    length_s = {view.name: view.exposure_s or protocol.exposure_s for view in protocol.views}
    assert sorted(length_s.values()) == [8, 8, 15, 15]
    for participant in build_design(protocol, seed=3).plan(21):
        (trials,) = participant.sessions
        pairs = Counter((trial.condition, trial.scene) for trial in trials)
        assert len(pairs) == 16
        assert set(pairs.values()) == {1}
        assert all(a.scene != b.scene for a, b in pairwise(trials))


def test_the_factorial_example_crosses_both_factors_and_both_scenes():
    protocol = load_protocol("factorial_example")
    assert {tuple(each.levels.values()) for each in protocol.conditions} == {
        (lens, motion) for lens in ("sharp", "dof") for motion in ("still", "streaks")
    }
    for participant in build_design(protocol, seed=1).plan(16):
        trials = [trial for session in participant.sessions for trial in session]
        assert len({(trial.condition, trial.scene) for trial in trials}) == len(trials) == 8


def test_hillaires_groups_of_six_begin_each_part_three_and_three():
    people = build_design(load_protocol("hillaire_2008"), seed=2).plan(30)
    for start in range(0, 30, 6):
        orders = [[trial.condition for trial in each.trials] for each in people[start : start + 6]]
        for first in (0, 2):  # of the first part, of the second
            assert Counter(each[first] for each in orders) == {"blur_on": 3, "blur_off": 3}
        assert all(a != b for each in orders for a, b in (each[:2], *pairwise(each[2:])))


def test_hillaires_situations_have_their_lengths_and_tasks():
    protocol = load_protocol("hillaire_2008_gaze")
    (person,) = build_design(protocol).plan(1)
    lengths_s = [protocol.length_s(trial.scene) for trial in person.trials]
    assert lengths_s == [180, 300, 300, 300]
    assert person.trials[0].task == "none"
    assert len({trial.task for trial in person.trials}) == 4


def test_carnegie_as_printed_asks_for_eyes_closed_and_lets_people_come_back():
    protocol = load_protocol("carnegie_2015_as_printed")
    (closed,) = protocol.tells("before_trial", 1, 2)
    assert "close your eyes" in closed.text
    assert protocol.stop.participant == "session"
    assert protocol.hours_between_sessions
    forms = [protocol.form(ask) for ask in protocol.questionnaires]
    assert [len(form.items) for form in forms] == [18, 18, 18]


@pytest.mark.slow
def test_volunteers_are_excluded_and_who_withdrew_comes_back(tmp_path, run):
    """As 14 of 34 were, and three of the six who withdrew."""
    code, _, err = run(
        "simulate", "carnegie_2015_as_printed", "-n", 34, "--no-draw", "--seed", 3,
        "--out", tmp_path / "s",
    )  # fmt: skip
    assert code == 0, err
    rows = list(CsvTable.read(tmp_path / "s" / "participants.csv").dicts())
    screened = [row for row in rows if "screened out" in row["note"]]
    assert 8 <= len(screened) <= 20
    assert all("1" in (row["hmd_experience"], row["visual_abnormality"]) for row in screened)
    ended = [row["participant"] for row in rows if "felt too sick" in row["note"]]
    assert any((tmp_path / "s" / f"sub-{each}" / "ses-2").is_dir() for each in ended)


def test_hillaires_forms_come_after_their_parts():
    protocol = load_protocol("hillaire_2008")
    of_trial = {
        trial: [ask.instrument for ask in protocol.asks("after_trial", 1, trial)]
        for trial in range(1, 9)
    }
    assert [k for k, names in of_trial.items() if "noticed_difference" in names] == [2]
    assert [each.name for each in protocol.writes("after_trial", 1, 2)] == ["explained_difference"]
    assert list(protocol.writes("after_trial", 1, 3)) == []
    assert [each.name for each in protocol.tells("before_trial", 1, 3)] == ["in_turn"]


def test_mantiuk_knows_age_and_sight_and_asks_for_opinions():
    protocol = load_protocol("mantiuk_2011")
    assert [each.name for each in protocol.covariates] == ["age", "acuity", "colour_vision"]
    asked = [each.name for each in protocol.writes("session_end", 1, None)]
    assert asked == ["sight", "opinion"]
    assert "realistic" in next(iter(protocol.tells("session_start", 1, None))).text


@pytest.mark.slow
def test_the_printed_anova_of_thirty_players_has_29_degrees_of_freedom(run, tmp_path):
    study, out = tmp_path / "s", tmp_path / "r"
    code, _, err = run(
        "simulate", "hillaire_2008", "-n", 30, "--no-draw", "--exposure-s", 10, "--out", study
    )
    assert code == 0, err
    told = ("--plan", "hillaire_2008_as_printed", "--figures", "none", "--out", out)
    code, _, err = run("report", study, *told)
    assert code == 0, err
    rows = json.loads((out / "results.json").read_text())["anova"]
    assert [row["outcome"] for row in rows] == [
        "tasks.hits", "tasks.deaths", "tasks.shots", "tasks.shots_hit_percent",
    ]  # fmt: skip
    for row in rows:
        (effect,) = row["effects"]
        assert (effect["df_effect"], effect["df_error"]) == (1, 29)
