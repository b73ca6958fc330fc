"""A lab's own questions: found among other columns, declared in the mapping, and reported."""

from __future__ import annotations

import json
import random
import re
from pathlib import Path

import pytest

from tests.importing.test_layouts import suggested_import
from tests.support.layouts import ENGLISH, PEOPLE, write
from tests.support.report import build_report
from vrcomfort.errors import InputError
from vrcomfort.importing import import_files, load_mapping, write_study
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.suggest import suggest_mapping

RANDOM = random.Random(27)  # noqa: S311
AGREE = ["Strongly disagree", "Disagree", "Neither agree nor disagree", "Agree", "Strongly agree"]
LIKELY = ["Very unlikely", "Unlikely", "Neutral", "Likely", "Very likely"]
Cells = dict[tuple[str, str, str], float]


def ssq() -> list[int]:
    return [RANDOM.choice((0, 0, 1, 2, 3)) for _ in ENGLISH]


def imported_from(*files: Path) -> Imported:
    found = suggest_mapping(files).imported
    assert found is not None
    return found


def answers(imported: Imported, item: str) -> Cells:
    return {
        (m.participant, m.condition, m.timepoint): response.answers[item]
        for (_, m), response in imported.responses.items()
        if response.answers.get(item) is not None
    }


def own_items(imported: Imported) -> dict[str, tuple[float, float]]:
    return {
        item.name: (item.answers.low, item.answers.high)
        for each in imported.instruments.values()
        for item in each.items
    }


def test_statements_beside_a_questionnaire_are_reported_each_under_its_own_name(
    tmp_path: Path,
) -> None:
    head = [
        "Participant",
        "Condition",
        *ENGLISH,
        "I felt present in the scene",
        "Eye strain now (0-10)",
    ]
    rows = [
        [f"P{n}", condition, *ssq(), 1 + (n * k) % 6, (3 * n + k) % 9]
        for n in range(1, 13)
        for k, condition in enumerate(("sharp", "blurred"), start=1)
    ]
    file = write(tmp_path / "answers.csv", [head, *rows])
    mapping = tmp_path / "map.toml"
    text = suggest_mapping([file]).text
    mapping.write_text(re.sub('answer = ""', 'answer = "yes"', text), encoding="utf-8")
    loaded = load_mapping(mapping)
    imported = import_files([file], loaded.mapping, loaded.instruments)
    assert own_items(imported) == {
        "i_felt_present_in_the_scene": (1, 7),
        "eye_strain_now": (0, 10),
    }
    assert answers(imported, "i_felt_present_in_the_scene") == {
        (f"P{n}", c, "post"): 1 + (n * k) % 6
        for n in range(1, 13)
        for k, c in enumerate(("sharp", "blurred"), start=1)
    }
    study = tmp_path / "study"
    write_study(study, imported, loaded, [file])
    build_report(study, out=tmp_path / "report")
    results = json.loads((tmp_path / "report" / "results.json").read_text(encoding="utf-8"))
    outcomes = {row["outcome"] for row in results["tests"]}
    assert {"T", "own_questions.i_felt_present_in_the_scene"} <= outcomes
    assert [(each["name"], each["size"]) for each in results["families"]] == [
        ("total", 1),
        ("subscales", 3),
        ("own_questions", 2),
    ]
    page = (tmp_path / "report" / "index.html").read_text(encoding="utf-8")
    assert "I felt present in the scene" in page


def test_words_of_agreement_before_and_after_side_by_side(tmp_path: Path) -> None:
    asked = ["presence", "wellbeing"]
    head = ["id", *(f"{when}_{each}" for when in ("pre", "post") for each in (*ENGLISH, *asked))]
    given = {n: [RANDOM.choice(AGREE) for _ in range(4)] for n in range(1, 11)}
    rows = [[f"S{n}", *ssq(), *own[:2], *ssq(), *own[2:]] for n, own in given.items()]
    found = imported_from(write(tmp_path / "study.csv", [head, *rows]))
    assert own_items(found) == {"presence": (1, 5), "wellbeing": (1, 5)}
    assert {(p, t): value for (p, _, t), value in answers(found, "wellbeing").items()} == {
        (f"S{n}", when): 1 + AGREE.index(own[place])
        for n, own in given.items()
        for when, place in (("baseline", 1), ("post", 3))
    }


def test_questions_in_rows_stand_under_the_name_of_their_questionnaire(tmp_path: Path) -> None:
    rows: list[list[object]] = []
    for n in range(1, 9):
        for condition in ("a", "b"):
            rows += [[f"P{n}", condition, "SSQ", i, v] for i, v in zip(ENGLISH, ssq(), strict=True)]
            rows += [
                [f"P{n}", condition, "Comfort", f"comfort_{k}", 1 + (n + k) % 9] for k in (1, 2)
            ]
            rows.append([f"P{n}", condition, "Comfort", "age", 20 + n])
    head = ["participant", "condition", "questionnaire", "item", "response"]
    found = imported_from(write(tmp_path / "long.csv", [head, *rows]))
    assert own_items(found) == {"comfort_1": (1, 9), "comfort_2": (1, 9)}
    assert {name for name, _ in found.responses} == {"ssq", "comfort"}


def test_discomfort_in_a_column_for_each_minute_is_rated_during_exposure(tmp_path: Path) -> None:
    head = [
        "participant",
        "condition",
        *(f"discomfort_{m}min" for m in range(0, 10, 2)),
        "speed_2min",
    ]
    rows = [
        [n, c, *(min(10, m * k // 2) for m in range(5)), 3]
        for n in range(1, 9)
        for k, c in enumerate(("snap", "smooth"), start=1)
    ]
    found = imported_from(write(tmp_path / "ratings.csv", [head, *rows]))
    assert len(found.ratings) == 8 * 2 * 5
    assert {rating.instrument for rating in found.ratings} == {"discomfort"}
    assert {rating.onset_s for rating in found.ratings} == {0, 120, 240, 360, 480}


def test_numbers_that_nobody_answered_are_measurements_and_are_asked_about(tmp_path: Path) -> None:
    head = ["id", "condition", "Timestamp", *ENGLISH, "mean HR", "errors", "Completion time (s)"]
    head += ["How many years have you played?", "score", *(f"collisions_{n}" for n in (1, 2, 3))]
    rows = [
        [
            n,
            c,
            f"2024-01-0{n} 10:00",
            *ssq(),
            *(70 + n + k, (n + k) % 5, 30 + n * k, (n * k) % 7),
            *(n + k, (n + k) % 4, (n * k) % 4, (n + 2 * k) % 3),
        ]
        for n in range(1, 9)
        for k, c in enumerate(("a", "b"))
    ]
    found = suggest_mapping([write(tmp_path / "x.csv", [head, *rows])])
    assert found.imported is not None
    assert {*found.imported.instruments} == {"own_measures", "own_questions", "collisions"}
    told = " ".join(found.doubts)
    assert "No rule knows 'mean HR' (71 to 79), 'errors' (0 to 4), 'Completion time (s)'" in told
    assert "are these measurements of the lab's own? Assumed: they are, as they stand" in told
    assert answers(found.imported, "mean_hr")["3", "b", "post"] == 74
    assert 'ignore = ["Timestamp"]' in found.text


def test_levels_of_a_factor_and_means_of_questions_are_none(tmp_path: Path) -> None:
    head = ["id", "condition", "effort", "comfort_1", "comfort_2", "comfort_mean"]
    rows = [
        [f"P{n}", c, level, 1 + (n * level) % 7, 1 + (n + level) % 7, (n * level) % 7 / 2]
        for n in range(1, 9)
        for c in ("a", "b")
        for level in (1, 2, 3)
    ]
    found = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert own_items(found) == {"comfort_1": (1, 7), "comfort_2": (1, 7)}


def test_one_questionnaire_in_two_files_is_declared_once_with_the_answers_of_both(
    tmp_path: Path,
) -> None:
    files = [
        write(
            tmp_path / f"{name}.csv",
            [["id", "How present did you feel?", note], *([n, low + n % 5, 7] for n in range(9))],
        )
        for name, low, note in (("vr", 0, "room"), ("ar", 6, "seat"))
    ]
    found = suggest_mapping(files)
    assert found.text.count("[[instruments]]") == 1
    assert found.imported is not None
    assert own_items(found.imported) == {"how_present_did_you_feel": (0, 10)}


MAPPING = """\
format_version = 1
[[instruments]]
name = "comfort"
title = "Comfort"
answers = { low = 1, high = 7 }
items = [{ name = "felt", text = "I felt well" }]
[[tables]]
files = ["x.csv"]
participant = { column = "id" }
[[tables.questionnaires]]
instrument = "comfort"
items = { felt = "How" }
"""


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("high = 7", "high = 0", 5, "the lowest answer, 1, is not below the highest, 0"),
        ("high = 7", "heigh = 7", 5, "unknown key `heigh`"),
        ('"comfort"\ntitle', '"ssq"\ntitle', 3, "`ssq` is a shipped instrument"),
        ('name = "felt"', 'name = "response"', 6, "an item cannot be called `response`"),
        ("items = { felt", "items = { fell", 12, "`fell` is not an item of comfort"),
    ],
)
def test_faults_of_a_declared_instrument_have_their_place(
    tmp_path: Path, old: str, new: str, place: int, words: str
) -> None:
    file = tmp_path / "map.toml"
    file.write_text(MAPPING.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(words)) as found:
        load_mapping(file)
    assert found.value.line == place


def test_seven_degrees_of_agreement_in_words(tmp_path: Path) -> None:
    seven = [*AGREE[:2], "Somewhat disagree", AGREE[2], "Somewhat agree", *AGREE[3:]]
    rows = [[f"P{n}", c, seven[(n + k) % 7]] for n in range(9) for k, c in enumerate("ab")]
    head = ["participant", "condition", "I felt present in the scene"]
    found = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert own_items(found) == {"i_felt_present_in_the_scene": (1, 7)}
    assert answers(found, "i_felt_present_in_the_scene") == {
        (f"P{n}", c, "post"): 1 + (n + k) % 7 for n in range(9) for k, c in enumerate("ab")
    }


def test_a_word_between_two_questions_on_their_scale_is_a_question_and_their_mean_none(
    tmp_path: Path,
) -> None:
    head = ["ID", "Display", "Realism", "Artifacts", "Comfort", "Quality", "errors"]
    rows = []
    for n in range(1, 13):
        for k, display in enumerate(("a", "b"), start=1):
            given = [1 + (n + 2 * k) % 7, 1 + (n * k) % 7, 1 + (n + k) % 7]
            rows.append([f"P{n}", display, *given, round(sum(given) / 3, 3), n % 3])
    found = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert {*own_items(found)} == {"realism", "artifacts", "comfort"}


def test_words_of_agreement_are_answers_whatever_the_heading_asks(tmp_path: Path) -> None:
    """A group in words is the condition, though a column before it has its word too."""
    head = ["id", "support_group", "vr_exp", "group", "angry", "heart_efficacy", "plan"]
    groups = ("control", "intervention")
    rows = [
        [n, 0, ("Some", "Limited")[n % 3 % 2], groups[n % 2], AGREE[n % 4], AGREE[n % 3], n % 2]
        for n in range(1, 21)
    ]
    found = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert own_items(found) == {"angry": (1, 5), "heart_efficacy": (1, 5), "plan": (0, 1)}
    assert answers(found, "heart_efficacy") == {
        (str(n), groups[n % 2], "post"): 1 + n % 3 for n in range(1, 21)
    }


@pytest.mark.parametrize(
    ("head", "asked"),
    [
        (["Realism", "Comfort", "Artifacts", "Colours"], 2),
        (["Comfort", "Artifacts", "Colours", "Shape"], 1),
        (["I felt at ease", "The lens meets all needs"], 1),
        (["bad_good", "slow_fast", "dull_vivid", "odd_usual", "weak_strong"], 0),
        (["bad_good", "slow_fast", "dull_vivid", "odd_usual"], 0),
        (["1/2 The robot [It is loud]", "1/2 The robot [It is kind]"], 2),
        (["Q_near", "Q_far", "Q_text"], 0),
        (["column 1", "Comfort"], 1),
        (["I felt sure", "It was easy to drive the whole distance", "I felt at ease"], 3),
    ],
)
def test_columns_beside_questions_are_asked_about(
    tmp_path: Path, head: list[str], asked: int
) -> None:
    """No rule knows those that ask nothing: a doubt of their own asks about them."""
    each = [[f"P{n}", *(1 + (n * k) % 7 for k in range(1, 1 + len(head))), n % 3] for n in range(9)]
    file = write(tmp_path / "x.csv", [["ID", *head, "Wins"], *each])
    found = suggest_mapping([file])
    assert found.imported is not None
    whole = len([name for name in head if name != "column 1"]) + 1
    assert len(own_items(found.imported)) == whole
    left = re.search(r"No rule knows (.*?): are these questions", found.text)
    assert (left[1].count("(") if left else 0) == whole - asked


def test_a_rating_beside_the_number_of_its_scale_is_an_answer(tmp_path: Path) -> None:
    rows = [
        [f"P{n}", 3 + 4 * (n % 2), c, (n + k) % 7 - 3] for n in range(9) for k, c in enumerate("ab")
    ]
    head = ["subject", "rating_type", "condition", "rating"]
    found = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert own_items(found) == {"rating": (-3, 3)}
    assert found.conditions == ["a", "b"]


def test_moments_inside_headings_and_a_condition_beside_them(tmp_path: Path) -> None:
    """Words before the same questions are no conditions where a column says the condition."""
    head = [
        "code",
        "condition",
        *(f"mood_{when}_{each}" for when in ("pre", "post") for each in "ab"),
    ]
    head += [f"{what}_{each}" for what in ("door", "shelf") for each in ("valence", "arousal")]
    rows = [
        [f"k{n:02}", "plain" if n % 2 else "rich", *(1 + (n + k * k) % 5 for k in range(1, 9))]
        for n in range(1, 15)
    ]
    found = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert found.conditions == ["plain", "rich"]
    assert {when for _, _, when in answers(found, "mood_a")} == {"baseline", "post"}
    assert {*own_items(found)} >= {"door_valence", "shelf_valence"}


def test_a_sum_beside_questions_does_not_widen_their_scale(tmp_path: Path) -> None:
    rows = [[n % 2, *(1 + (n * k) % 5 for k in range(1, 5)), 8 + n % 9] for n in range(20)]
    head = ["factor", "Q1", "Q2", "Q3", "Q4", "social_presence"]
    found = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert own_items(found)["q_1"] == (1, 5)
    assert own_items(found)["social_presence"] == (0, 20)
    assert found.conditions == ["0", "1"]


def test_three_columns_of_a_questionnaire_beside_ranks_and_scores_of_items(tmp_path: Path) -> None:
    """Columns of an order, several of them, rank something and are no sequence of conditions."""
    head = ["id", "order_sound", "order_light", "order_colour", "there", "place", "vivid", "Sum A"]
    rows = []
    for n in range(1, 20):
        order = [1 + (n + k) % 3 for k in range(3)]
        given = [1 + (n * k) % 7 for k in (1, 2, 3)]
        rows.append([n, *order, *given, round(sum(given) / 3, 2)])
    found = imported_from(write(tmp_path / "presence_questionnaire.csv", [head, *rows]))
    ranks = {"order_sound", "order_light", "order_colour"}
    assert {*own_items(found)} == {"there", "place", "vivid"} | ranks
    assert found.conditions == ["all"]
    items = [f"Item{n}" for n in range(1, 7)]
    rows = [[n, *(1 + (n + k * k) % 7 for k in range(6)), 1 + n % 6 + 0.25] for n in range(20)]
    file = write(tmp_path / "imi.csv", [["UserID", *items, "Perceived enjoyment"], *rows])
    assert len(own_items(imported_from(file))) == len(items) + 1


def test_a_setting_drawn_for_each_person_is_no_condition(tmp_path: Path) -> None:
    rows = [[30 + 2 * n, n % 3, 40 + (7 * n) % 50] for n in range(30)]
    file = write(tmp_path / "x.csv", [["fov", "locomotion", "immersion"], *rows])
    assert imported_from(file).conditions == ["0", "1", "2"]


def test_questions_that_repeat_belong_to_the_conditions_beside_their_numbers(
    tmp_path: Path,
) -> None:
    asked = ["I was in control", "I find this system", "I find this system"]
    head = ["Participant", "MISC_1", "Condition_1", *asked, "MISC_2", "Condition_2", *asked]
    rows = [
        [n, n % 4, "ab"[n % 2], *(1 + (n + k) % 5 for k in range(3)),
         n % 5, "ba"[n % 2], *(1 + (n + k) % 5 for k in (3, 4, 5))]
        for n in range(1, 13)
    ]  # fmt: skip
    found = imported_from(write(tmp_path / "x.csv", [head, *rows]))
    assert answers(found, "i_find_this_system_2") == {
        (str(n), c, "post"): 1 + (n + k) % 5
        for n in range(1, 13)
        for c, k in (("ab"[n % 2], 2), ("ba"[n % 2], 5))
    }


def test_discomfort_beside_rising_times_is_rated_during_exposure(tmp_path: Path) -> None:
    rows = [
        [p, c, t, t // 60 + p % 2] for p in range(1, 9) for c in "ab" for t in range(0, 300, 30)
    ]
    head = ["pid", "condition", "time_s", "discomfort"]
    found = suggest_mapping([write(tmp_path / "x.csv", [head, *rows])])
    assert found.imported is not None
    assert {r.instrument for r in found.imported.ratings} == {"discomfort"}
    assert len(found.imported.ratings) == len(rows)
    assert any("own questions: 'discomfort'" in doubt for doubt in found.doubts)


@pytest.mark.parametrize("wide", [False, True])
def test_a_mark_in_one_of_several_columns_is_its_answer(tmp_path: Path, *, wide: bool) -> None:
    words = ["None", "Slight", "Moderate", "Severe"]
    given = {(f"P{n}", c): ssq() for n in range(1, 9) for c in "ab"}
    marks = {
        k: [["x" if v == n else "" for n in range(4)] for v in each] for k, each in given.items()
    }
    if wide:
        head = [["id", "condition", *(t for e in ENGLISH for t in (e, "", "", ""))]]
        head += [["", "", *words * len(ENGLISH)]]
        rows = [[*key, *(cell for four in each for cell in four)] for key, each in marks.items()]
    else:
        head = [["id", "condition", "Symptom", *words]]
        rows = [
            [*key, e, *four]
            for key, each in marks.items()
            for e, four in zip(ENGLISH, each, strict=True)
        ]
    found = suggest_mapping([write(tmp_path / "x.csv", [*head, *rows])])
    assert found.imported is not None
    assert any("Is a mark in one of several columns" in doubt for doubt in found.doubts)
    assert {
        (m.participant, m.condition): [*response.answers.values()]
        for (_, m), response in found.imported.responses.items()
    } == given


def test_a_block_is_called_after_the_only_word_of_its_headings(tmp_path: Path) -> None:
    asked = ["Mental Demand", "Physical Demand", "Temporal Demand", "Performance", "Effort"]
    head = ["ID", *asked, *(f"VR {each}" for each in asked)]
    rows = [[n, *(5 * ((n + k) % 20) for k in range(10))] for n in range(1, 9)]
    found = imported_from(write(tmp_path / "tlx.csv", [head, *rows]))
    assert found.conditions == ["questionnaire_1", "VR"]


def test_a_word_that_tells_one_question_apart_from_others_is_no_condition(tmp_path: Path) -> None:
    felt = [f"I felt {each}" for each in ("bored", "calm", "tired")]
    scales = [f"{each} VAS (0-100)" for each in ("Fear", "Anger", "Sadness")]
    rows = [
        [
            f"P{n}",
            seen,
            place,
            *(1 + (n * k + place) % 5 for k in (1, 2, 3)),
            *(7 * n + k * place for k in (1, 2, 3)),
        ]
        for n in range(1, 13)
        for place, seen in enumerate(("hand", "scene")[:: 1 - 2 * (n % 2)], start=1)
    ]
    head = ["Participant", "Condition", "Condition Position", *felt, *scales]
    found = imported_from(write(tmp_path / "answers.csv", [head, *rows]))
    assert {key.condition for _, key in found.responses} == {"hand", "scene"}
    assert {"i_felt_bored", "i_felt_calm", "i_felt_tired", "fear_vas"} <= {*own_items(found)}


def test_codes_before_questions_bring_in_the_others_behind_them(tmp_path: Path) -> None:
    head = ["ID", "CTRL_move", "CTRL_natural", "CTRL_gesture", "PRE_realistic", "PRE_delay"]
    head += ["PRE_natural", "CS_dizzy", "CS_nausea", "CS_trigger"]
    rows = [
        [f"A{n}", *(1 + (n * k) % (5 + 2 * (3 < k < 7)) for k in range(1, 10))] for n in range(1, 9)
    ]
    found = imported_from(write(tmp_path / "walking.csv", [head, *rows]))
    assert {key.timepoint for _, key in found.responses} == {"post"}
    assert {name: len(each.items) for name, each in found.instruments.items()} == {
        "ctrl": 3, "pre": 3, "cs": 3,
    }  # fmt: skip


def test_a_moment_before_own_questions_stays_one_where_others_are_named(tmp_path: Path) -> None:
    asked = ["fatigue", "comfort", "presence"]
    head = ["ID", *(f"{when}_{each}" for when in ("pre", "post") for each in asked)]
    rows = [[f"A{n}", *(1 + (n * k) % 5 for k in range(1, 7))] for n in range(1, 9)]
    found = imported_from(write(tmp_path / "moments.csv", [head, *rows]))
    assert {key.timepoint for _, key in found.responses} == {"baseline", "post"}


@pytest.mark.parametrize("headings", [True, False])
def test_fourteen_numbers_without_a_name_are_no_presence_questionnaire(
    headings: bool, tmp_path: Path
) -> None:
    head = ["id", "setup", *(f"Q{n}" for n in range(1, 15))]
    rows: list[list[object]] = [
        [f"P{n}", ("hands", "pad")[n % 2], *(RANDOM.randint(1, 5) for _ in range(14))]
        for n in range(1, 21)
    ]
    found = imported_from(write(tmp_path / "survey.csv", [head, *rows] if headings else rows))
    assert {*own_items(found).values()} == {(1, 5)}
    assert len(own_items(found)) == 14
    assert "ipq" not in {name for name, _ in found.responses}


def test_a_file_that_lacks_some_questions_is_of_the_same_instrument_and_of_its_condition(
    tmp_path: Path,
) -> None:
    asked = [
        "I liked this condition very much",
        "I would show this condition to my friends",
        "The exercise made me feel tired",
    ]
    often = "How often would you like this condition?"
    files = [
        write(
            tmp_path / f"Condition {number}.csv",
            [
                ["Participant ID", *asked[:count], often],
                *(
                    [n, *(RANDOM.randint(1, 5) for _ in range(count)), ("Rarely", "Daily")[n % 2]]
                    for n in range(1, 9)
                ),
            ],
        )
        for number, count in ((1, 3), (2, 3), (3, 2))
    ]
    found = imported_from(*files)
    assert {name for name, _ in found.responses} == {"own_questions"}
    assert {m.condition for _, m in found.responses} == {"1", "2", "3"}
    assert not found.not_asked
    tired = answers(found, "the_exercise_made_me_feel_tired")
    assert {condition for _, condition, _ in tired} == {"1", "2"}


def test_names_of_files_that_are_conditions_alone_say_none_of_another_file(tmp_path: Path) -> None:
    asked = ["I felt tired", "I felt present", "I felt in control"]
    files = [
        write(
            tmp_path / f"{name}.csv",
            [
                ["Participant", *asked],
                *([f"{name[0]}{n}", *(RANDOM.randint(1, 5) for _ in asked)] for n in range(1, 7)),
            ],
        )
        for name in ("VR", "Desktop")
    ]
    drawn = [*(f"V{n}" for n in range(1, 7)), *(f"D{n}" for n in range(1, 7))]
    rows = [[who, RANDOM.randint(0, 40) * 2.5] for who in drawn]
    files.append(write(tmp_path / "SUS.csv", [["Participant", "Score_SUS"], *rows]))
    found = imported_from(*files)
    assert {m.condition for _, m in found.responses} >= {"VR", "Desktop"}
    assert not any(m.condition == "SUS" for _, m in found.responses)


def test_symptoms_of_a_record_are_asked_again_where_nobody_had_them(tmp_path: Path) -> None:
    people = {
        f"t{n}": {
            where: {**dict(zip(ENGLISH, ssq(), strict=True)), "boredom": n % 3 * (where == "walk")}
            for where in ("sit", "walk", "run")
        }
        for n in range(1, 13)
    }
    file = tmp_path / "answers.json"
    file.write_text(json.dumps(people), encoding="utf-8")
    found = imported_from(file)
    assert {c for _, c, _ in answers(found, "boredom")} == {"sit", "walk", "run"}
    assert len({name for name, _ in found.responses}) == 2


@pytest.mark.parametrize(
    "items",
    [
        ["GEQ_Imm1", "GEQ_Imm2", "GEQ_PosAff1", "GEQ_PosAff2", "GEQ_PosAff3"],
        ["I felt content", "I felt good", "I felt nauseous", "I was interested in the task"],
    ],
)
def test_questions_under_one_code_or_as_sentences_are_one_instrument(
    items: list[str], tmp_path: Path
) -> None:
    rows: list[list[object]] = [
        [f"P{n}", c, *(RANDOM.randint(1, 5) for _ in items)]
        for n in range(1, 13)
        for c in ("a", "b")
    ]
    found = imported_from(write(tmp_path / "games.csv", [["id", "Condition", *items], *rows]))
    assert len({name for name, _ in found.responses}) == 1
    assert len(own_items(found)) == len(items)


def test_a_column_that_no_rule_knows_is_left_out_by_one_line(tmp_path: Path) -> None:
    rows = [
        [f"P{n}", c, (3 * n + k) % 9, 20 + n * 1.25 + k, LIKELY[(n + 2 * k) % 5]]
        for n in range(1, 13)
        for k, c in enumerate("ab")
    ]
    file = write(tmp_path / "x.csv", [["ID", "lens", "glare", "secs", "buy again"], *rows])
    text = suggest_mapping([file]).text
    assert "'secs' (21 to 36): are these measurements" in text
    mapping = tmp_path / "map.toml"
    mapping.write_text(text.replace('answer = ""', 'answer = "yes"'), encoding="utf-8")
    found = import_files([file], load_mapping(mapping).mapping)
    assert own_items(found) == {"glare": (0, 10), "secs": (21, 36), "buy_again": (0, 4)}
    assert answers(found, "secs")["P3", "b", "post"] == 24.75
    assert answers(found, "buy_again")["P1", "a", "post"] == 1
    line = 'participant = { column = "ID" }\n'
    edited = mapping.read_text(encoding="utf-8").replace(line, f'{line}ignore = ["secs"]\n')
    mapping.write_text(edited, encoding="utf-8")
    without = import_files([file], load_mapping(mapping).mapping)
    left = {item for each in without.responses.values() for item in each.answers}
    assert left == {"glare", "buy_again"}


def test_levels_and_numbers_of_rows_are_left_out_and_asked_about(tmp_path: Path) -> None:
    rows = [
        [f"P{n}", c, trial, (n * trial) % 8, 1690479000 + n * trial]
        for n in range(1, 9)
        for c in "ab"
        for trial in (1, 2, 3)
    ]
    file = write(tmp_path / "x.csv", [["ID", "display", "repeat", "misses", "unix"], *rows])
    found = suggest_mapping([file])
    assert found.imported is not None
    assert own_items(found.imported) == {"misses": (0, 7)}
    assert "May 'repeat' be left out (each person has the same numbers" in found.text
    assert 'ignore = ["repeat", "unix"]' in found.text


def test_what_is_said_once_beside_conditions_in_headings_is_a_fact_of_people(
    tmp_path: Path,
) -> None:
    head = ["ID", *(f"{lens}_{item}" for lens in ("near", "far") for item in ENGLISH), "span_cm"]
    rows = [[f"P{n}", *ssq(), *ssq(), 160 + (7 * n) % 23] for n in range(1, 10)]
    found = suggest_mapping([write(tmp_path / "x.csv", [head, *rows])])
    assert found.imported is not None
    assert found.imported.participants["P2"]["span_cm"] == "174"
    assert (
        "No rule knows 'span_cm', said once of each person: are these facts of people?"
        in found.text
    )


def test_measurements_of_each_condition_stand_side_by_side(tmp_path: Path) -> None:
    head = ["ID", "Walk Time", "Fly Time", "Walk Score", "Fly Score"]
    given = {n: [20 + n * 1.5, 31 - n * 0.25, n % 8, (3 * n) % 8] for n in range(1, 13)}
    file = write(tmp_path / "x.csv", [head, *([f"P{n}", *each] for n, each in given.items())])
    found = imported_from(file)
    assert found.conditions == ["Walk", "Fly"]
    assert answers(found, "time")["P4", "Fly", "post"] == 30
    assert answers(found, "score_2")["P5", "Walk", "post"] == 5


def test_what_is_asked_of_each_numbered_condition_belongs_to_the_word_beside_it(
    tmp_path: Path,
) -> None:
    head = [f"Treatment{n}{asked}" for n in (1, 2) for asked in ("", "WaitMin", "ExitLikelihood")]
    rows = []
    for n in range(1, 13):
        first, second = ("with", "without")[:: 1 if n % 2 else -1]
        likely = LIKELY[n % 5], LIKELY[(2 * n) % 5]
        rows.append([f"P{n}", first, 2 + n % 7, likely[0], second, 1.5 + n % 5, likely[1]])
    found = imported_from(write(tmp_path / "x.csv", [["Participant ID", *head], *rows]))
    assert {*found.conditions} == {"with", "without"}
    assert answers(found, "wait_min")["P2", "with", "post"] == 3.5
    assert answers(found, "exit_likelihood")["P3", "with", "post"] == 3


def test_a_remark_among_numbers_is_no_answer(tmp_path: Path) -> None:
    rows = [[f"P{n}", c, (n + k) % 6] for n in range(1, 13) for k, c in enumerate("ab")]
    rows[5][2] = "2 or 3"
    found = suggest_mapping([write(tmp_path / "x.csv", [["ID", "lens", "glare"], *rows])])
    assert found.imported is not None
    assert "Do '2 or 3' among numbers stand for no answer?" in found.text
    assert len(answers(found.imported, "glare")) == len(rows) - 1


def test_means_over_conditions_are_no_condition_of_measurements(tmp_path: Path) -> None:
    head = [f"{when} {what}" for when in ("Sea", "Lake", "Overall") for what in ("HR", "Speed")]
    rows = []
    for n in range(1, 13):
        sea, lake = (70 + n % 5, 1.5 + n % 4), (80 + n % 7, 2.25 + n % 3)
        rows.append([n, *sea, *lake, *((a + b) / 2 for a, b in zip(sea, lake, strict=True))])
    found = imported_from(write(tmp_path / "x.csv", [["ID", *head], *rows]))
    assert [each for each in found.conditions if each] == ["Sea", "Lake"]
    assert answers(found, "speed")["3", "Lake", "post"] == 2.25


def test_columns_that_no_rule_knows_refuse_no_file(tmp_path: Path) -> None:
    """Two files give a person another number at one moment."""
    people = range(1, 13)
    files = [
        write(
            tmp_path / "ssq.csv", [["ID", *ENGLISH, "secs"], *([n, *ssq(), n % 7] for n in people)]
        ),
        write(tmp_path / "fun.csv", [["ID", "fun", "secs"], *([n, n % 5, n % 3] for n in people)]),
    ]
    found = suggest_mapping(files)
    assert found.imported is not None
    assert own_items(found.imported) == {"fun": (0, 4)}
    assert "May 'secs' be left out (with such columns as outcomes the import refuses" in found.text


def test_the_mean_of_columns_that_no_rule_knows_is_no_question(tmp_path: Path) -> None:
    parts = ["BeingThere", "Reality", "Visiting"]
    rows: list[list[object]] = [["id", "condition", "Sickness", *parts, "Presence"]]
    for n in range(12):
        for shown in "ab":
            said = [RANDOM.randint(1, 7) for _ in parts]
            rows.append([f"P{n}", shown, RANDOM.randint(1, 7), *said, round(sum(said) / 3, 2)])
    imported = imported_from(write(tmp_path / "presence.csv", rows))
    assert {*own_items(imported)} == {"sickness", "being_there", "reality", "visiting"}


def test_what_is_measured_in_one_condition_is_measured_in_all_and_means_are_none(
    tmp_path: Path,
) -> None:
    rows: list[list[object]] = [["ID", "P_FP", "P_H", "P_AVG", "E_SP_FP", "E_SP_H"]]
    rows[0] += ["SSQ_TS_FP", "SSQ_TS_H"]
    for n in range(1, 9):
        a, b = 90 + 7 * n % 31, 64 + 37 * n % 95
        rows.append(
            [f"P{n}", a, b, (a + b) / 2, 4 + n * n % 13, 3 + 5 * n * n % 17, 3.74 * n, 7.48 * n]
        )
    imported, _ = suggested_import([write(tmp_path / "scores.csv", rows)], tmp_path)
    assert imported.conditions == ["FP", "H"]
    own = [each for (name, _), each in imported.responses.items() if name == "own_measures"]
    assert [len(each.answers) for each in own] == [2] * 16


def test_forms_of_the_same_questions_that_nobody_answered_together_are_no_conditions(
    tmp_path: Path,
) -> None:
    rows: list[list[object]] = [["ID", "Order"]]
    rows[0] += [f"VR{form}_0{k}" for form in ("02", "13") for k in range(1, 5)]
    for n in range(1, 13):
        answers: list[object] = [1 + (n + k) % 4 for k in range(4)]
        form = [*answers, "", "", "", ""] if n % 2 else ["", "", "", "", *answers]
        rows.append([f"P{n}", "0123" if n % 3 else "3210", *form])
    imported, _ = suggested_import([write(tmp_path / "forms.csv", rows)], tmp_path)
    assert not {"02", "13"} & {*imported.conditions}
    assert {moment.timepoint for _, moment in imported.responses} == {"post"}


def test_three_items_whose_headings_are_made_in_three_ways_are_no_questionnaire(
    tmp_path: Path,
) -> None:
    names = ["o_p", "Physical_Demand", "First_Mental", "Second_Mental", "First_HR", "Second_HR"]
    rows: list[list[object]] = [["ID", *names]]
    rows += [[f"P{n}", n, 1 + n % 9, 1 + n % 5, 2 + n % 7, 60 + n, 70 + n] for n in range(1, 9)]
    imported, _ = suggested_import([write(tmp_path / "NASA.csv", rows)], tmp_path)
    assert "nasa_tlx" not in {instrument for instrument, _ in imported.responses}


def test_means_of_answers_are_not_rounded_and_have_a_scale_of_their_own(tmp_path: Path) -> None:
    rows: list[list[object]] = [["participant", "arousal", "presence", "sickness"]]
    rows += [[f"P{n:02}", 1 + n % 9, 1 + n % 12 / 3, 1 + n % 9 / 2] for n in range(18)]
    found = imported_from(write(tmp_path / "scores.csv", rows))
    assert own_items(found) == {"arousal": (1, 9), "presence": (1, 5), "sickness": (1, 5)}
    presence = {who: value for (who, *_), value in answers(found, "presence").items()}
    assert presence == pytest.approx({str(row[0]): row[2] for row in rows[1:]}, abs=1e-8)


def test_a_lone_number_below_0_is_a_missing_answer_but_not_on_a_scale_around_0(
    tmp_path: Path,
) -> None:
    def answers(high: int) -> set[object]:
        rows = [[p, -1 if p == "P03" else n % (high + 1)] for n, p in enumerate(PEOPLE)]
        file = write(tmp_path / f"to_{high}.csv", [["ID", "comfort"], *rows])
        imported = suggest_mapping([file]).imported
        assert imported is not None
        return {r.answers["comfort"] for r in imported.responses.values()}

    assert answers(6) == {*range(7)}
    assert -1 in answers(2)


def test_percentages_and_lists_in_cells_of_python_are_read(tmp_path: Path) -> None:
    rows = [[p, f"{50 + n}.5 %", {"calm": [n % 5, n % 3]}] for n, p in enumerate(PEOPLE)]
    file = write(tmp_path / "x.csv", [["ID", "accuracy", "page"], *rows])
    imported = suggest_mapping([file]).imported
    assert imported is not None
    said = {name: v for r in imported.responses.values() for name, v in r.answers.items()}
    assert said["accuracy"] == 59.5
    assert len(said) == 3


def test_a_sentence_with_a_moment_is_asked_of_that_moment_only_where_another_is_asked_too(
    tmp_path: Path,
) -> None:
    rows = [[p, 1 + n % 7, 1 + n % 5] for n, p in enumerate(PEOPLE)]
    head = ["ID", "J'avais l'impression d'aller de l'avant", "Je me suis senti présent"]
    found = suggest_mapping([write(tmp_path / "x.csv", [head, *rows])])
    assert found.imported is not None
    assert {who.timepoint for _, who in found.imported.responses} == {"post"}
    assert any("another moment" in doubt for doubt in found.doubts)


def test_what_is_answered_in_the_words_of_other_questions_is_a_question_too(tmp_path: Path) -> None:
    """T01 and O02 are no moments or levels, but codes of questions as XAI01 is."""
    heads = ["XAI01", "XAI02", "XAI03", "AIpT01", "AIpT02", "O01", "O02", "O03"]
    rows = [[str(n + 3), *(f"A{RANDOM.randint(1, 5)}" for _ in heads)] for n in range(48)]
    for n, row in enumerate(rows):
        row[-1] = f"because of reason {n}"
    found = imported_from(write(tmp_path / "survey.csv", [["id", *heads], *rows]))
    assert len(own_items(found)) == len(heads) - 1
    assert {moment.timepoint for _, moment in found.responses} == {"post"}


def test_the_same_questions_behind_two_numbers_are_asked_twice(tmp_path: Path) -> None:
    """Two drives each; six questions before, and again after; none is lost."""
    asked = ["positive1", "positive2", "satisfaction1", "trust1", "wellbeing", "perception"]
    rows: list[list[object]] = [
        ["subID", "drive_index", *(f"{n}_{a}" for n in "13" for a in asked)]
    ]
    for n in range(20):
        for drive in (0, 1):
            rows.append([f"{n + 7}", drive, *(1 + RANDOM.randint(0, 6) for _ in range(12))])
    found = imported_from(write(tmp_path / "drives.csv", rows))
    assert len(found.participants) == 20
    given = [a for r in found.responses.values() for a in r.answers.values() if a is not None]
    assert sorted(given) == sorted(a for row in rows[1:] for a in row[2:])


def test_remarks_among_numbers_are_no_answers_and_a_person_can_agree(tmp_path: Path) -> None:
    words = ["I strongly disagree", "I disagree", "I can't say", "I agree", "I strongly agree"]
    rows: list[list[object]] = [["ID", "The system is useful.", "edges", "minutes"]]
    rows += [[f"P{n}", words[n % 5], 1 + n % 9, 11 + n * 7 % 30] for n in range(42)]
    rows[4][2], rows[9][2] = "I can not tell", "I could not find it"
    found = imported_from(write(tmp_path / "quiz.csv", rows))
    given = {
        n: next(a for a in answers(found, n).values())
        for n in ("the_system_is_useful", "edges", "minutes")
    }
    assert given == {"the_system_is_useful": 1, "edges": 1, "minutes": 11}
    assert len(answers(found, "edges")) == 40


def test_a_sum_of_measurements_is_left_out_with_a_doubt(tmp_path: Path) -> None:
    heads = ["ID", "Condition", "clicks left", "clicks right", "clicks", "ease"]
    rows = [
        [f"P{n // 2}", "ab"[n % 2], a := n * 5 % 9, b := n * 7 % 8, a + b, 1 + n * 3 % 7]
        for n in range(24)
    ]
    found = suggest_mapping([write(tmp_path / "log.csv", [heads, *rows])])
    assert "May 'clicks' be left out (an exact sum" in found.text


def test_words_of_two_scales_are_two_instruments_and_none_is_missing(tmp_path: Path) -> None:
    agreed = ("Strongly disagree", "Disagree", "Neither agree nor disagree", "Agree")
    likely = ("Not at all", "Moderately unlikely", "Neither likely nor unlikely", "Very likely")
    much = ("Not at all", "Slightly", "Moderately", "Very")
    rows = [
        [p, c, *(words[(n + k + m) % 4] for m, words in enumerate((agreed, agreed, likely, much)))]
        for n, p in enumerate(PEOPLE)
        for k, c in enumerate(("near", "far"))
    ]
    head = [
        "ID",
        "Condition",
        "I felt angry there",
        "It was useful to me",
        "cancer",
        "I am confident",
    ]
    found = suggest_mapping([write(tmp_path / "x.csv", [head, *rows])])
    assert found.imported is not None
    assert "missing = " not in found.text
    given = [a for each in found.imported.responses.values() for a in each.answers.values()]
    assert len(given) == 4 * len(rows)
    assert None not in given
