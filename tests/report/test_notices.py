"""What a report says before any number, and what does not change one."""

from types import SimpleNamespace

import pandas as pd
import pytest

from tests.report.test_study import total_raw
from tests.support.report import (
    ITEMS,
    ONE_SCORE,
    WITHOUT_MODELS,
    Study,
    analysed,
    build_report,
    foreign,
    manifest,
    planned_report,
)
from vrcomfort.errors import InputError
from vrcomfort.report import notices
from vrcomfort.report.orders import in_words, one_order
from vrcomfort.report.stimulus_time import _frame_ms


def repeated(folder, people: int, who_repeats: tuple[int, ...], who_lacks: tuple[int, ...] = ()):
    """A study of one exposure of each condition; some repeat the first, some lack the second."""
    study = Study(folder)
    for i in range(people):
        exposures = [("a", "x", 4 + i % 5), ("b", "x", None if i in who_lacks else 3 + i % 3)]
        study.session(f"P{i:02d}", 1, 0, exposures + [("a", "x", 5)] * (i in who_repeats))
    return folder


def notices_of(source, lines=ONE_SCORE):
    return analysed(source, lines)["notices"]


def test_an_exposure_more_of_two_people_takes_nobody_out(tmp_path):
    results = analysed(repeated(tmp_path / "s", 12, (3, 7)), ONE_SCORE)
    assert len(results["participants"]["analysed"]) == 12
    notice, order = results["notices"]
    assert notice.startswith("P03, P07 have more exposures of a condition than are planned")
    assert order.startswith("10 of 12 participants met a before b")  # these two: a, b, a


def test_an_exposure_more_of_two_people_leaves_them_out_of_the_crossover_alone(tmp_path):
    folder = Study(tmp_path / "s")
    for i in range(12):
        order = [("a", "x", 4 + i % 5), ("b", "x", 3 + i % 3)][:: 1 if i % 2 else -1]
        folder.session(f"P{i:02d}", 1, 0, order + [("a", "x", 5)] * (i in (2, 5)))
    (found,) = analysed(tmp_path / "s", ONE_SCORE)["crossover"]
    assert (found["n_ab"], found["n_ba"], found["left_out"]) == (5, 5, ["P02", "P05"])


@pytest.mark.slow
def test_an_exposure_more_is_averaged_with_the_planned(tmp_path):
    results = analysed(repeated(tmp_path / "s", 12, (0,)), ONE_SCORE)
    plain = analysed(repeated(tmp_path / "t", 12, ()), ONE_SCORE)
    assert results["participants"]["exposures_per_condition"] == {"a": 1, "b": 1}
    means = [r["tests"][0]["descriptives"]["a"]["mean"] for r in (results, plain)]
    first, added = total_raw(4), total_raw(5)
    assert means[0] - means[1] == pytest.approx(3.74 * (added - first) / 2 / 12)


@pytest.mark.parametrize("lacking", [1, 2])
def test_a_loss_of_more_than_a_tenth_is_told_first(tmp_path, lacking):
    lost = tuple(range(lacking))
    summary = planned_report(repeated(tmp_path / "s", 10, (), lost), out=tmp_path / "o")
    notices = [w for w in summary.warnings if "are not in the tests of a and b" in w]
    assert len(notices) == (lacking == 2)
    for each in notices:
        assert each.startswith("2 of 10 participants")
        assert each.endswith("P00, P01")
        page = summary.index.read_text("utf-8")
        assert page.index(each) < page.index('id="answers"')


def test_the_protocol_says_how_many_exposures_are_planned(tmp_path):
    """All lost the second exposure of a: no mode can know that there was to be one."""
    study = Study(tmp_path / "s")
    for i in range(6):
        folder = study.session(f"P{i}", 1, 0, [("a", "x", 4), ("b", "x", 3), ("b", "y", 2)])
        settings = {
            "scenes": ["x", "y"], "conditions": [{"name": "a"}, {"name": "b"}],
            "order": {"rule": "williams"},
            "questionnaires": [
                {"instrument": "ssq", "timepoint": "post", "when": "after_trial", "wait_s": 0}
            ],
        }  # fmt: skip
        (folder / "manifest.json").write_text(manifest(f"P{i}", settings=settings))
    results = analysed(tmp_path / "s", ONE_SCORE)
    assert results["participants"]["exposures_per_condition"] == {"a": 2, "b": 2}
    assert "of every planned exposure (2 of a, 2 of b)" in results["notices"][0]


def test_who_met_neither_condition_is_not_lost(tmp_path):
    scores = {f"P{i}": {"a": 3, "b": 2 + i} for i in range(8)} | {"Q1": {"c": 1}, "Q2": {"c": 2}}
    notices = notices_of(foreign(tmp_path / "questionnaires.csv", scores))
    assert not any("of a and b" in notice for notice in notices)


@pytest.mark.parametrize(("group", "told"), [("far", False), ("near", True)])
def test_whose_group_never_meets_a_condition_is_not_lost(tmp_path, group, told):
    """Half of the people meet a and b, the others a and c; grouped by that, or all together."""
    study = Study(tmp_path / "s")
    rows = ["participant,sequence,status,enrolled_at,note,group"]
    for i in range(12):
        second = "bc"[i % 2]
        study.session(f"P{i:02d}", 1, 0, [("a", "x", 4 + i % 5), (second, "x", 3 + i % 3)])
        rows.append(f"P{i:02d},s,completed,,,{'near' if i % 2 else group}")
    (tmp_path / "s" / "participants.csv").write_text("\n".join(rows) + "\n")
    notices = notices_of(tmp_path / "s")
    assert any("participants are not in the tests of a and b" in each for each in notices) == told


@pytest.mark.parametrize(
    ("shown_s", "told"),
    [
        ([None, None], None),
        ([1.0, None], "Exposures of 1 session were shortened to 1 s at most (--exposure-s)"),
        ([4, 0.5], "Exposures of 2 sessions were shortened to 0.5 s and 4 s at most"),
    ],
)
def test_shortened_exposures_are_told_of(tmp_path, shown_s, told):
    study = Study(tmp_path / "s")
    for number, each in enumerate(shown_s):
        folder = study.session(f"P{number}", 1, 0, [("a", "x", 4), ("b", "x", 3)])
        text = manifest(f"P{number}", exposure_override_s=each)
        (folder / "manifest.json").write_text(text)
    found = [each for each in notices_of(tmp_path / "s") if "short" in each]
    assert len(found) == (told is not None)
    assert all(told in each for each in found)


@pytest.mark.parametrize("allowed", [True, False])
def test_orders_that_need_not_balance_are_told_of(tmp_path, allowed):
    folder = Study(tmp_path / "s").session("P0", 1, 0, [("a", "x", 4), ("b", "x", 3)])
    settings = {"order": {"rule": "williams", "unbalanced": allowed}}
    (folder / "manifest.json").write_text(manifest("P0", settings=settings))
    notices = notices_of(tmp_path / "s")
    assert any("lets orders be unbalanced" in each for each in notices) == allowed


def test_names_that_may_be_one_person_are_told_and_stay_two(tmp_path):
    names = ["P9", "P09", "p 10", "P10", "P1", "Q1"]
    scores = {name: {"a": 3 + i, "b": 2 * i} for i, name in enumerate(names)}
    results = analysed(foreign(tmp_path / "questionnaires.csv", scores), ONE_SCORE)
    notice = results["notices"][-1]
    assert notice.startswith("`P09` and `P9`; `P10` and `p 10` may be one participant each")
    assert len(results["participants"]["analysed"]) == 6


def test_zeros_inside_a_number_tell_people_apart(tmp_path):
    scores = {f"P{i:03d}": {"a": 3 + i % 7, "b": 2 * (i % 5)} for i in range(8, 22)}
    scores["P100"] = {"a": 4, "b": 1}
    assert not notices_of(foreign(tmp_path / "questionnaires.csv", scores))


def test_a_participant_in_two_sequences_is_an_error(tmp_path):
    scores = {f"P{i}": {"a": 3 + i, "b": 2 * i} for i in range(4)}
    file = foreign(tmp_path / "questionnaires.csv", scores, sequence="ab")
    text = file.read_text().replace("P2,b,nausea,0,ab", "P2,b,nausea,0,ba")
    file.write_text(text)
    with pytest.raises(InputError, match=r"P2 is in sequence `ab` .* and in `ba`"):
        build_report(file, out=tmp_path / "o")


@pytest.mark.parametrize(("lowest", "asked"), [(1, True), (0, False)])
def test_answers_that_may_be_coded_from_one_are_asked_about(tmp_path, lowest, asked):
    rows = [
        f"P{i},{c},{item},{max(lowest, (i + k) % 4)}"
        for i in range(6)
        for c in "ab"
        for k, item in enumerate(ITEMS)
    ]
    file = tmp_path / "questionnaires.csv"
    file.write_text("\n".join(["participant,condition,item,response", *rows]) + "\n")
    said = "none of 192 answers to the SSQ is 0"
    assert any(said in each for each in notices_of(file)) == asked


@pytest.mark.parametrize("turned", [False, True])
def test_a_condition_that_is_its_position_is_told_beside_the_result(tmp_path, turned):
    study = Study(tmp_path / "s")
    for i in range(8):
        order = [("a", "x", 4 + i % 5), ("b", "x", 3 + i % 3)]
        study.session(f"P{i}", 1, 0, order[:: -1 if turned and i % 2 else 1])
    summary = planned_report(tmp_path / "s", out=tmp_path / "o")
    told = (
        "all 8 participants met a before b, so that their difference cannot be told from one of "
        "order"
    )
    assert (told in summary.headlines[0]) != turned
    assert (told in summary.warnings) != turned


@pytest.mark.parametrize(
    ("orders", "told"),
    [
        (["ab"] * 12, "all 12 participants met a before b, so that their difference cannot be"),
        (["ba"] * 2, "both participants met b before a, so that"),
        (["ab"] * 9 + ["ba"], "9 of 10 participants met a before b, so that their difference may"),
        (["ab"] * 8 + ["ba"] * 2, None),  # p = .109
        (["ab"], None),
        (["aab", "aab", "ba", "ba"], None),
        (["ab"] * 3 + ["baabb"] * 3, None),  # a is in the earlier mean place for all of them
        (["abba"] * 6, None),
        (["ab"] * 6 + ["abba"], "6 of 7 participants met a before b"),
        (["ab"] * 3 + ["a"] * 9, "all 3 participants met a before b"),
    ],
)
def test_one_order_is_one_of_people(orders, told):
    rows = [
        {"participant": f"P{i}", "session": "1", "position": place, "condition": condition}
        for i, order in enumerate(orders)
        for place, condition in enumerate(order, start=1)
    ]
    people = [f"P{i}" for i in range(len(orders))]
    found = one_order(pd.DataFrame(rows), "a", "b", people)
    assert (found is None) == (told is None)
    assert found is None or in_words(found, str).startswith(told)


@pytest.mark.slow
def test_positions_are_told_over_all_sessions(tmp_path):
    """Everybody met x and a in the first session, b and y in the second."""
    study = Study(tmp_path / "s")
    for i in range(8):
        study.session(f"P{i}", 1, 0, [("x", "s", 4 + i % 5), ("a", "s", 3 + i % 3)])
        study.session(f"P{i}", 2, 0, [("b", "s", 2 + i % 4), ("y", "s", 1 + i % 5)])
    told = " ".join(notices_of(tmp_path / "s"))
    for first, second in (("x", "a"), ("x", "b"), ("x", "y"), ("a", "b"), ("a", "y"), ("b", "y")):
        assert f"all 8 participants met {first} before {second}" in told
        assert f"participants met {second} before {first}" not in told


def test_an_outcome_without_a_difference_has_its_row_whatever_zeros_count(tmp_path):
    rows = [
        f"P{i},{c},{item},{int(item == 'eyestrain' and i % 4 > n)}"
        for i in range(8)
        for n, c in enumerate("ab")
        for item in ITEMS
    ]
    file = tmp_path / "questionnaires.csv"
    file.write_text("\n".join(["participant,condition,item,response", *rows]) + "\n")
    lines = f'outcomes = ["N", "O"]\nzeros = "wilcox"\n{WITHOUT_MODELS}'
    page = planned_report(file, out=tmp_path / "o", lines=lines).index.read_text("utf-8")
    assert "Nausea" in page


def test_what_has_no_condition_is_left_out_with_its_place(tmp_path):
    scores = {f"P{i}": {"a": 3, "b": i, "": 2} for i in range(6)}
    results = analysed(foreign(tmp_path / "questionnaires.csv", scores), ONE_SCORE)
    assert [c["name"] for c in results["conditions"]] == ["a", "b"]
    reasons = {row["reason"] for row in results["quality"]["excluded_questionnaires"]}
    assert reasons == {"no condition is given"}


def test_exact_is_written_only_where_it_was(tmp_path, monkeypatch):
    scores = {f"P{i}": {"a": 3 + i, "b": 2 * i} for i in range(8)}
    source = foreign(tmp_path / "questionnaires.csv", scores)
    exact = planned_report(source, out=tmp_path / "o").index.read_text("utf-8")
    assert "The p value is from the exact permutation distribution" in exact
    monkeypatch.setattr("vrcomfort.stats.signed_rank.EXACT_UP_TO", 5)
    summary = planned_report(source, out=tmp_path / "p")
    assert "Asymptotic signed-rank test" in summary.headlines[0]
    assert "exact permutation distribution" not in summary.index.read_text("utf-8")


@pytest.mark.parametrize(
    ("left", "withdrawals", "told"),
    [
        ("bbb", "complete_pairs", "all 3 ; the comparison is of those who stayed"),
        ("bbba", "complete_pairs", "3 of 4 ; the comparison is of those who stayed"),
        ("bbb", "worst_rank", "all 3 ; they are ranked as worst"),
        ("bbaa", "complete_pairs", ""),
        ("b", "complete_pairs", ""),
    ],
)  # fmt: skip
def test_people_who_left_under_one_condition_are_told_first(tmp_path, left, withdrawals, told):
    study = Study(tmp_path / "s")
    for i in range(12):
        other = "b" if i < len(left) and left[i] == "a" else "a"
        exposures = [(other, "x", 4 + i % 5), ("ab"[other == "a"], "x", 3 + i % 3)]
        if i < len(left):
            exposures[1] = (left[i], "x", None)
        status = "withdrawn" if i < len(left) else "completed"
        study.session(f"P{i:02d}", 1, 0, exposures, status)
        study.person(f"P{i:02d}", "a", status)
    notices = notices_of(tmp_path / "s", f'{ONE_SCORE}withdrawals = "{withdrawals}"\n')
    found = [line for line in notices if "who left did so under" in line]
    share, _, of_whom = told.partition(" ; ")
    told = f"{share} participants who left did so under b: {of_whom}"
    assert [line.partition(";")[0] for line in found] == ([told] if share else [])
    assert found == notices[: len(found)]
    assert all("time to leaving: log-rank within people p" in line for line in found)
    ranked = [line for line in found if "with those who left ranked as worst p" in line]
    assert len(ranked) == (bool(share) and withdrawals != "worst_rank")


def shown(condition, scene, frames, dropped):
    return {"condition": condition, "scene": scene, "frames": frames, "dropped": dropped}


@pytest.mark.parametrize(
    ("trials", "said"),
    [
        ([shown("off", "a", "900", "0"), shown("dof", "a", "900", "9")],
         ["dropped frames go with the condition (1.0 % in dof, 0.0 % in Off)"]),
        ([shown("off", "a", "900", "0"), shown("off", "b", "900", "90")],
         ["dropped frames go with the scene (10.0 % in b, 0.0 % in a)"]),
        ([shown("off", "a", "900", "40"), shown("dof", "a", "900", "45")], []),
        ([shown("off", "a", "900", "0"), shown("dof", "a", "", "")], []),
        ([shown("off", "a", "900", "90")], []),
        ([], []),
    ],
)  # fmt: skip
def test_dropped_frames_that_go_with_condition_or_scene_are_told(trials, said):
    study = SimpleNamespace(trials=trials, labels={"off": "Off"})
    found = notices._dropped_with(study)
    assert [each.partition(":")[0] for each in found] == said


def test_frame_times_by_condition_are_those_of_people_in_a_headset():
    row = {"session": "1", "gpu_median_ms": "", "gpu_p95_ms": ""}
    timing = [
        {**row, "participant": who, "condition": c, "cpu_median_ms": a, "cpu_p95_ms": b}
        for who, c, a, b in (
            ("P1", "off", "2.0", "3.0"), ("P2", "off", "4.0", "5.0"),
            ("P1", "dof", "6.0", "8.0"), ("S1", "off", "90.0", "90.0"),
        )
    ]  # fmt: skip
    people = [
        SimpleNamespace(participant=who, session=1, respondent=kind)
        for who, kind in (("P1", "panel"), ("P2", "panel"), ("S1", "simulated"))
    ]
    study = SimpleNamespace(timing=timing, manifests=people)
    blank = {"gpu_median_ms": None, "gpu_p95_ms": None}
    assert _frame_ms(study, "off") == {"cpu_median_ms": 3.0, "cpu_p95_ms": 4.0, **blank}
    assert _frame_ms(study, "dof") == {"cpu_median_ms": 6.0, "cpu_p95_ms": 8.0, **blank}
    assert _frame_ms(SimpleNamespace(timing=timing, manifests=people[2:]), "off") == {}
