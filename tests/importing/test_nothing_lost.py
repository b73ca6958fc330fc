"""What a draft does not read is asked about: cells, rows, columns and people."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.layouts import CONDITIONS, ENGLISH, PEOPLE, study, write
from vrcomfort.errors import InputError
from vrcomfort.importing.files import as_table, read_grids
from vrcomfort.importing.source import Reading
from vrcomfort.importing.suggest import suggest_mapping

ANSWERS = study(times=("post",))


def records(folder: Path, *more: int) -> Path:
    """Write answers as lists in cells, each with some more numbers, and a rating of comfort."""
    each = [
        {"Participant": p, "Condition": c, "How comfortable was it?": 1 + n % 7}
        | {"SSQ": " ".join(map(str, (*ANSWERS[p, c, "post"], *more)))}
        for n, p in enumerate(PEOPLE)
        for c in CONDITIONS
    ]
    file = folder / "answers.json"
    file.write_text(json.dumps(each), encoding="utf-8")
    return file


def test_a_list_with_a_number_for_each_item_is_read_as_the_items(tmp_path: Path) -> None:
    found = suggest_mapping([records(tmp_path)])
    assert found.imported is not None
    answers = {
        (m.participant, m.condition, "post"): tuple(response.answers.values())
        for (instrument, m), response in found.imported.responses.items()
        if instrument == "ssq"
    }
    assert answers == ANSWERS
    assert "'SSQ' the answers to all items" in found.doubts[0]


def test_answers_that_share_a_cell_are_asked_about(tmp_path: Path) -> None:
    doubts = suggest_mapping([records(tmp_path, 3)]).doubts
    asked = next(doubt for doubt in doubts if "'SSQ' hold several numbers each" in doubt)
    assert "answers to SSQ would be missing" in asked


def test_a_column_of_lists_is_refused_with_its_row_where_a_cell_is_none(tmp_path: Path) -> None:
    file = write(tmp_path / "a.csv", [["ID", "SSQ"], ["P1", "1 2 3 0"], ["P2"], ["P3", "1 2"]])
    (grid,) = read_grids(file, Reading(spread=("SSQ",)))
    with pytest.raises(InputError, match="row 4: '1 2' in 'SSQ' must be a list of 4 numbers"):
        as_table(grid)
    table = as_table(replace(grid, rows=grid.rows[:3], numbers=grid.numbers[:3]))
    assert table.headings == ("ID", "SSQ_1", "SSQ_2", "SSQ_3", "SSQ_4")
    assert table.rows == (("P1", "1", "2", "3", "0"), ("P2", "", "", "", ""))
    other = replace(grid, reading=Reading(spread=("IPQ",)))
    with pytest.raises(InputError, match="no column 'IPQ', which is to be spread"):
        as_table(other)
    with pytest.raises(InputError, match="no cell of 'ID' is a list of numbers"):
        as_table(replace(grid, reading=Reading(spread=("ID",))))


@pytest.mark.parametrize("written", [repr, json.dumps])
def test_an_object_of_answers_in_a_cell_is_read_as_a_column_for_each_name(
    written: Callable[[object], str], tmp_path: Path
) -> None:
    said = [{f"q{k}": str(1 + (n * k + k) % 5) for k in range(1, 5)} for n in range(12)]
    rows = [[f"P{n:02}", "ab"[n % 2], written(each)] for n, each in enumerate(said)]
    file = write(tmp_path / "a.csv", [["participant", "group", "feedback_answers"], *rows])
    found = suggest_mapping([file]).imported
    assert found is not None
    answers = {m.participant: [*r.answers.values()] for (_, m), r in found.responses.items()}
    assert answers == {f"P{n:02}": [*map(int, each.values())] for n, each in enumerate(said)}


def test_rows_that_no_questionnaire_takes_are_asked_about_with_their_number(tmp_path: Path) -> None:
    rows = [
        [p, c, question, (3 * n + k) % (7 if k < 2 else 90)]
        for n, p in enumerate(PEOPLE)
        for c in CONDITIONS
        for k, question in enumerate(("comfort", "liked overall", "errors"))
    ]
    file = write(tmp_path / "long.csv", [["person", "condition", "question", "rating"], *rows])
    found = suggest_mapping([file])
    assert "May 20 of 60 rows of long.csv ('errors') be left out?" in found.doubts[0]
    assert found.imported is not None
    items = {item for each in found.imported.responses.values() for item in each.answers}
    assert items == {"comfort", "liked_overall"}


def test_people_without_answers_are_asked_about_with_their_number(tmp_path: Path) -> None:
    answers = [[p, *answers] for (p, c, _), answers in ANSWERS.items() if c == "blur"]
    files = [
        write(tmp_path / "ssq.csv", [["ID", *ENGLISH], *answers[:-2]]),
        write(tmp_path / "people.csv", [["ID", "Age"], *([p, 30] for p in PEOPLE)]),
    ]
    assert "Have 2 of 10 participants no answers (P09, P10)?" in suggest_mapping(files).doubts[0]


def test_numbers_of_a_form_before_the_exposures_are_facts_of_people(tmp_path: Path) -> None:
    rows: list[list[object]] = []
    for n, p in enumerate(PEOPLE):
        rows.append([p, "", 10 * n, *[""] * 16, ""])
        for c in CONDITIONS:
            rows.append([p, c, "", *ANSWERS[p, c, "post"], n % 2])
    head = ["record_id", "condition", "vr_hours", *ENGLISH, "Stopped by the participant?"]
    found = suggest_mapping([write(tmp_path / "form.csv", [head, *rows])])
    assert found.imported is not None
    assert found.imported.participants["P03"]["vr_hours"] == "20"
    assert any("'vr_hours', said once of each person" in each for each in found.doubts)


@pytest.mark.parametrize(
    "words",
    [
        ("1 - not at all", "4 - moderately", "7 - extremely"),
        ("not at all (1)", "moderately (4)", "extremely (7)"),
    ],
)
def test_an_answer_in_words_with_its_number_is_that_number(
    tmp_path: Path, words: tuple[str, ...]
) -> None:
    imported = suggest_mapping([ride(tmp_path, words)]).imported
    assert imported is not None
    own = [each for (name, _), each in imported.responses.items() if name != "ssq"]
    assert {answer for each in own for answer in each.answers.values()} == {1, 4, 7}


def ride(folder: Path, words: Sequence[str]) -> Path:
    """Write answers to the SSQ, and how comfortable it was, in words."""
    rows = [
        [p, c, words[(n // 2 + k) % 3], *ANSWERS[p, c, "post"]]
        for n, p in enumerate(PEOPLE)
        for k, c in enumerate(CONDITIONS)
    ]
    head = ["ID", "Condition", "How comfortable was it?", *ENGLISH]
    return write(folder / "ride.csv", [head, *rows])


def test_answers_of_which_some_alone_say_a_number_are_no_numbers(tmp_path: Path) -> None:
    words = ("1 - not at all", "moderately", "7 - extremely")
    imported = suggest_mapping([ride(tmp_path, words)]).imported
    assert imported is not None
    assert {instrument for instrument, _ in imported.responses} == {"ssq"}


def test_numbers_that_contradict_the_words_beside_them_are_asked_about(tmp_path: Path) -> None:
    words = ("3 - none", "2 - slight", "1 - moderate", "0 - severe")
    rows = [[*key[:2], *(words[a] for a in answers)] for key, answers in ANSWERS.items()]
    file = write(tmp_path / "ssq.csv", [["ID", "Condition", *ENGLISH], *rows])
    doubts = suggest_mapping([file]).doubts
    assert any("words of answers say different things" in each for each in doubts)


def test_times_and_counters_of_an_experiment_library_are_no_ratings(tmp_path: Path) -> None:
    head = ["rt", "trial_type", "trial_index", "time_elapsed", "subject_id", "display", *ENGLISH]
    rows: list[list[object]] = []
    for n, p in enumerate(PEOPLE):
        for k, c in enumerate(CONDITIONS):
            rows.append(["null", "preload", 2 * k, 1000 * k, p, c, *[""] * 16])
            rt = 25000 + 977 * n + 31 * k
            rows.append([rt, "survey", 2 * k + 1, 1000 * k + rt, p, c, *ANSWERS[p, c, "post"]])
    found = suggest_mapping([write(tmp_path / "log.csv", [head, *rows])])
    assert found.imported is not None
    assert not found.imported.ratings
    assert {name for name, _ in found.imported.responses} <= {"ssq", "own_measures"}
    assert [*dict.fromkeys(found.imported.conditions)] == [*CONDITIONS]


OWNER = "flies a machine of this kind at least once a week"


def people_and_answers(folder: Path, *more: Sequence[object]) -> list[Path]:
    """Write answers, and a table of people with their experience in words, and some more rows."""
    answers = [[p, c, *answers] for (p, c, _), answers in ANSWERS.items()]
    rows = [[p, 20 + n, ("East", "West")[n % 2], OWNER] for n, p in enumerate(PEOPLE)]
    rows[0][3] = rows[1][3] = "pilot"
    return [
        write(folder / "ssq.csv", [["ID", "Condition", *ENGLISH], *answers]),
        write(folder / "people.csv", [["ID", "Age", "culture", "exp_drone"], *rows, *more]),
    ]


def test_words_of_people_are_facts_of_theirs_and_asked_about(tmp_path: Path) -> None:
    found = suggest_mapping(people_and_answers(tmp_path))
    assert found.imported is not None
    facts = {"age": "21", "culture": "West", "exp_drone": "pilot"}
    assert found.imported.participants["P02"] == facts
    assert any("'culture', 'exp_drone', said once" in each for each in found.doubts)


def test_a_code_that_stands_twice_in_a_table_of_people_is_asked_about(tmp_path: Path) -> None:
    found = suggest_mapping(people_and_answers(tmp_path, ["P01", 20, "East", OWNER]))
    assert found.imported is not None
    assert found.imported.participants["P02"] == {"age": "21", "culture": "West"}
    assert "P01 has several rows in people.csv: is it one person?" in found.doubts[0]
    assert "'exp_drone' differ there, and are left out" in found.doubts[0]


def test_a_code_with_two_records_of_answers_is_asked_about(tmp_path: Path) -> None:
    rows = [[p, *ANSWERS[p, "blur", "post"]] for p in PEOPLE]
    file = write(tmp_path / "ssq.csv", [["ID", *ENGLISH], *rows, ["P01", *rows[5][1:]]])
    assert "Has P01 several rows of one condition" in suggest_mapping([file]).doubts[0]


def test_numbers_under_a_heading_for_responses_that_are_ignored_are_asked_about(
    tmp_path: Path,
) -> None:
    rows: list[list[object]] = []
    for n, p in enumerate(PEOPLE):
        for c in CONDITIONS:
            rows.append([p, c, "<p>How was it?</p>", 7 * n, *[""] * 16])
            rows.append([p, c, "", "{...}", *ANSWERS[p, c, "post"]])
    head = ["ID", "display", "stimulus", "response", *ENGLISH]
    doubts = suggest_mapping([write(tmp_path / "log.csv", [head, *rows])]).doubts
    assert any("Are 20 numbers in 'response' no answers" in doubt for doubt in doubts)


@pytest.mark.parametrize(("first", "taken"), [(100_000, True), (171_000_000, False)])
def test_numbers_beyond_a_million_are_measures_unless_all_are_about_as_large(
    first: int, taken: bool, tmp_path: Path
) -> None:
    rows = [
        [p, c, first + 977_003 * (n + 8 * k), *ANSWERS[p, c, "post"]]
        for n, p in enumerate(PEOPLE)
        for k, c in enumerate(CONDITIONS)
    ]
    file = write(tmp_path / "ssq.csv", [["ID", "Condition", "path", *ENGLISH], *rows])
    words = tmp_path / "words.toml"
    words.write_text('[outcomes]\nlabels = ["path"]\n')
    assert ('path = "path"' in suggest_mapping([file]).text) is taken
    assert 'path = "path"' in suggest_mapping([file], vocabularies=[words]).text


def test_years_time_zones_and_versions_are_no_outcomes(tmp_path: Path) -> None:
    head = ["ID", "Condition", "Local Timezone", "Experiment Version", "last use", *ENGLISH]
    rows = [
        [p, c, (n + k) % 3, 8 + (n + k) % 2, 2001 + (n * 7 + k) % 19, *ANSWERS[p, c, "post"]]
        for n, p in enumerate(PEOPLE)
        for k, c in enumerate(CONDITIONS)
    ]
    found = suggest_mapping([write(tmp_path / "ssq.csv", [head, *rows])])
    assert found.imported is not None
    assert {name for name, _ in found.imported.responses} == {"ssq"}
    assert "May 'last use' be left out (calendar years)" in found.text


def test_words_that_are_left_out_are_counted_and_asked_about(tmp_path: Path) -> None:
    words = ("car", "boat", "train", "plane", "bicycle")
    rows = [
        [p, c, *ANSWERS[p, c, "post"], words[(n + k) % 5], words[(n * 2 + k) % 4]]
        for n, p in enumerate(PEOPLE)
        for k, c in enumerate(CONDITIONS)
    ]
    head = ["ID", "Condition", *ENGLISH, "fastest", "slowest"]
    found = suggest_mapping([write(tmp_path / "ssq.csv", [head, *rows])])
    assert any(
        "May 2 columns of words be left out: 'fastest', 'slowest'?" in each for each in found.doubts
    )
