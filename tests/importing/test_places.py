"""Answers known by their place, conditions beside them or in their order, words in file names."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.layouts import ENGLISH, ITEMS, write
from vrcomfort.errors import InputError
from vrcomfort.importing import import_files, load_mapping, parse_mapping, write_study
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.suggest import suggest_mapping
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.report.rated_exposures import rated_exposures
from vrcomfort.report.ratings.survival import times_to_withdrawal
from vrcomfort.report.study_data import read_study


def imported(
    folder: Path, rows: list[list[object]], keys: str, names: Sequence[str] = ("P07_SSQ",)
) -> Imported:
    """Import files of the same rows with a mapping of these keys."""
    files = [write(folder / f"{name}.csv", rows) for name in names]
    text = f'format_version = 1\n[[tables]]\nfiles = ["*.csv"]\n{keys}'
    return import_files(files, parse_mapping(text, None))


ANSWERS = [*range(4)] * 4
BY_PLACE = """
read = { heading_rows = [] }
participant = { column = "column 1" }
[[tables.questionnaires]]
instrument = "ssq"
"""


def test_answers_are_known_by_their_place_and_conditions_beside_them(tmp_path: Path) -> None:
    rows: list[list[object]] = [["P1", "a", *ANSWERS, "b", *ANSWERS[::-1]]]
    keys = BY_PLACE + (
        'first_columns = ["column 3", "column 20"]\n'
        'beside = { condition = ["column 2", "column 19"] }\n'
    )
    found = imported(tmp_path, rows, keys)
    said = {m.condition: [*r.answers.values()] for (_, m), r in found.responses.items()}
    assert said == {"a": ANSWERS, "b": ANSWERS[::-1]}
    assert not found.not_asked


def test_an_order_of_items_says_which_were_asked(tmp_path: Path) -> None:
    rows: list[list[object]] = [["P1", 1, 2, 9, 3]]
    keys = BY_PLACE + (
        'condition = "a"\nfirst_columns = ["column 2"]\n'
        'item_order = ["nausea", "vertigo", "", "burping"]\n'
    )
    found = imported(tmp_path, rows, keys)
    (response,) = found.responses.values()
    assert response.answers == {"nausea": 1, "vertigo": 2, "burping": 3}
    assert len(found.not_asked["ssq"]) == 13


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ('first_columns = ["column 9"]', "has only"),
        ('item_order = ["nausea"]', "needs first_columns"),
        ('first_columns = ["column 2"]\nitem_order = ["nausae"]', "did you mean `nausea`"),
        ('first_columns = ["column 2"]\nheading = "x{item}"', "leave out heading"),
        ('beside = { mood = "column 1" }', "`mood` is not a fact"),
        ('first_columns = ["column 2"]\nbeside = { trial = ["a", "b"] }', "name one for each"),
    ],
)
def test_places_that_cannot_be_are_refused(keys: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=re.escape(says)):
        imported(tmp_path, [["P1", *ANSWERS]], BY_PLACE + keys)


ORDERED = """
participant = { column = "id" }
condition = { order = "order", values = { A = "blur", B = "plain" } }
[[tables.questionnaires]]
instrument = "ssq"
heading = "{trial}_{item}"
"""


def test_an_order_of_conditions_numbers_them(tmp_path: Path) -> None:
    items = [i.name for i in shipped_instruments()["ssq"].items]
    head: list[object] = ["id", "order", *(f"{n}_{item}" for n in (1, 2) for item in items)]
    rows = [head, ["P1", "BA", *ANSWERS, *[0] * 16]]
    found = imported(tmp_path, rows, ORDERED)
    assert [(m.trial, m.condition) for _, m in found.responses] == [("1", "plain"), ("2", "blur")]
    for order, says in (("B", "has no condition number 2"), ("BC", "'C' is not among the values")):
        rows[1][1] = order
        with pytest.raises(InputError, match=says):
            imported(tmp_path, rows, ORDERED)


def test_an_order_numbers_what_is_counted_and_needs_a_number(tmp_path: Path) -> None:
    items = [i.name for i in shipped_instruments()["ssq"].items]
    head: list[object] = ["id", "order", *items]
    rows = [head, ["P1", "BA", *ANSWERS], ["P2", "AB", *ANSWERS], ["P1", "BA", *[0] * 16]]
    keys = ORDERED.replace("{trial}_", "")
    found = imported(tmp_path, rows, "trial = { count = true }" + keys)
    assert [(m.participant, m.trial, m.condition) for _, m in found.responses] == [
        ("P1", "1", "plain"), ("P2", "1", "blur"), ("P1", "2", "blur"),
    ]  # fmt: skip
    with pytest.raises(InputError, match="nothing says `trial`; write trial = "):
        imported(tmp_path, rows, keys)


DRAFTED = """
participant = { column = "id" }
ignore = ["q2", "q3 … q5"]
[[tables.questionnaires]]
instrument = "own"
items = { a = "q1", b = "extra" }
[[tables.questionnaires]]
instrument = "ssq"
first_columns = ["q1", "q17"]
condition = ["blur", "plain"]
[[instruments]]
name = "own"
short = "own"
title = "Own"
answers = { low = 0, high = 3 }
items = [{ name = "a", text = "a" }, { name = "b", text = "b" }]
"""


def test_first_columns_have_their_columns_and_a_condition_each(tmp_path: Path) -> None:
    rows: list[list[object]] = [
        ["id", *(f"q{n}" for n in range(1, 33)), "extra"],
        ["P1", *ANSWERS, *[0] * 16, 3],
    ]
    found = imported(tmp_path, rows, DRAFTED)
    said = {(name, m.condition): r.answers for (name, m), r in found.responses.items()}
    assert {*said} == {("own", ""), ("ssq", "blur"), ("ssq", "plain")}
    assert said["own", ""] == {"b": 3}
    assert [*said["ssq", "blur"].values()] == ANSWERS
    with pytest.raises(InputError, match="has 3 texts for 2 first_columns"):
        imported(tmp_path, rows, DRAFTED.replace('"plain"]', '"plain", "c"]'))


def test_columns_are_ignored_by_range_by_pattern_or_all_others(tmp_path: Path) -> None:
    items = [i.name for i in shipped_instruments()["ssq"].items]
    head: list[object] = ["id", *items, *(f"x{n}" for n in range(4)), "rt_a", "rt_b", "else"]
    rows = [head, ["P1", *ANSWERS, *range(7)]]
    rest = 'participant = { column = "id" }\n[[tables.questionnaires]]\ninstrument = "ssq"\n'
    for ignored in ('"x0 … x3", "rt_*", "else"', '"*"'):
        assert imported(tmp_path, rows, f"ignore = [{ignored}]\n{rest}").responses
    with pytest.raises(InputError, match="'rt_a': is neither mapped"):
        imported(tmp_path, rows, f'ignore = ["x0 … x3", "else"]\n{rest}')


def test_numbers_for_items_are_of_the_published_order(tmp_path: Path) -> None:
    head: list[object] = ["id", *(f"{c}_SSQ{n}" for c in "AB" for n in range(1, 17))]
    keys = 'participant = { column = "id" }\n[[tables.questionnaires]]\n'
    keys += 'instrument = "ssq"\nheading = "{condition}_SSQ{item}"\n'
    found = imported(tmp_path, [head, ["P1", *ANSWERS, *[0] * 16]], keys)
    first = next(iter(found.responses.values()))
    assert [*first.answers.values()] == ANSWERS


def test_a_pattern_of_file_names_may_lack_words(tmp_path: Path) -> None:
    items: list[object] = [i.name for i in shipped_instruments()["ssq"].items]
    keys = (
        "file_pattern = '(?P<participant>P\\d+)_SSQ(_(?P<timepoint>PRE))?'\n"
        'timepoint = { values = { "" = "post", PRE = "baseline" } }\n'
        '[[tables.questionnaires]]\ninstrument = "ssq"\ncondition = "a"\n'
    )
    found = imported(tmp_path, [items, [*ANSWERS]], keys, ("P07_SSQ", "P07_SSQ_PRE"))
    assert {(m.participant, m.timepoint) for _, m in found.responses} == {
        ("P07", "post"), ("P07", "baseline"),
    }  # fmt: skip
    with pytest.raises(InputError, match="is not made as"):
        imported(tmp_path, [items, [*ANSWERS]], keys, ("other",))


MISSPELT = [text.replace("Fullness", "Fullnes").replace("Vertigo", "Vertgo") for text in ENGLISH]


def test_a_misspelt_heading_is_named_and_never_dropped(tmp_path: Path) -> None:
    rows: list[list[object]] = [["id", *MISSPELT], ["P1", *ANSWERS]]
    keys = 'participant = { column = "id" }\n[[tables.questionnaires]]\ninstrument = "ssq"\n'
    with pytest.raises(InputError, match="'Vertgo' looks like vertigo; give them under items"):
        imported(tmp_path, rows, keys)
    ignored = 'ignore = ["Fullnes of head", "Vertgo"]\n' + keys
    found = imported(tmp_path, rows, ignored + 'not_asked = ["fullness_of_head", "vertigo"]\n')
    assert sum("looks like it" in note for note in found.notes) == 2


def test_a_misspelt_text_of_a_long_file_is_told(tmp_path: Path) -> None:
    rows: list[list[object]] = [["id", "item", "answer"]]
    rows += [["P1", text, 1] for text in MISSPELT]
    keys = (
        'participant = { column = "id" }\n[[tables.questionnaires]]\ninstrument = "ssq"\n'
        'item_column = "item"\nresponse_column = "answer"\n'
        'not_asked = ["fullness_of_head", "vertigo"]\n'
    )
    notes = imported(tmp_path, rows, keys).notes
    assert any("'Vertgo' looks like vertigo, which was not asked" in note for note in notes)


def leaving_times(folder: Path) -> Path:
    """A crossover of six people: P1 and P3 left under blur, P3 under plain as well."""
    rows: list[list[object]] = [["ID", "Condition", "left_at_s", *ITEMS]]
    gone = {("P1", "blur"): 120, ("P3", "blur"): 300.5, ("P3", "plain"): 45}
    for n in range(1, 7):
        for condition in ("blur", "plain"):
            time = gone.get((f"P{n}", condition), 600 if n % 2 else "")
            rows.append([f"P{n}", condition, time, *ANSWERS])
    return write(folder / "lab.csv", rows)


def write_as_suggested(study: Path, file: Path, draft: str) -> None:
    """Import a file with the draft's doubts answered yes."""
    mapping = file.parent / "map.toml"
    mapping.write_text(draft.replace('answer = ""', 'answer = "yes"'), encoding="utf-8")
    loaded = load_mapping(mapping)
    write_study(study, import_files([file], loaded.mapping), loaded, [file])


def test_leaving_times_become_ends_of_exposures_in_the_report(tmp_path: Path) -> None:
    file, study = leaving_times(tmp_path), tmp_path / "study"
    suggested = suggest_mapping([file])
    assert any("600 s long" in doubt for doubt in suggested.doubts)
    write_as_suggested(study, file, suggested.text)
    trials = read_study(study).trials
    ends = {(t["participant"], t["condition"]): (float(t["end_s"]), t["status"]) for t in trials}
    assert ends["P3", "blur"] == (300.5, "withdrawn")
    assert ends["P2", "plain"] == ends["P5", "blur"] == (600.0, "completed")
    assert sum(status == "withdrawn" for _, status in ends.values()) == 3


def test_no_leaving_time_is_the_length_of_an_exposure_that_nobody_left(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", "Condition", "left_at_s", *ITEMS]]
    gone = {2: 728, 4: 83.5, 5: 270}
    rows += [[f"P{n}", "ab"[n % 2], gone.get(n, ""), *ANSWERS] for n in range(9)]
    file, study = write(tmp_path / "a.csv", rows), tmp_path / "study"
    suggested = suggest_mapping([file])
    assert any("How long was an exposure" in doubt for doubt in suggested.doubts)
    write_as_suggested(study, file, suggested.text)
    trials = read_study(study).trials
    ends = {t["participant"]: (t["end_s"], t["status"]) for t in trials}
    assert ends["P2"] == ("728.0", "withdrawn")
    assert ends["P0"] == ends["P8"] == ("", "completed")
    exposures = rated_exposures(read_study(study), "")
    assert not times_to_withdrawal(exposures)
    one_known = [replace(e, ended_s=900.0) if e.participant == "P0" else e for e in exposures]
    assert not times_to_withdrawal(one_known), "others would be at risk for 0 s"


def test_leaving_times_of_zero_are_no_length(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", "Condition", "left_at_s", *ITEMS]]
    rows += [[f"P{n}", "ab"[n % 2], 0, *ANSWERS] for n in range(12)]
    suggested = suggest_mapping([write(tmp_path / "a.csv", rows)])
    assert not re.search(r"planned_s = \d", suggested.text)
    assert any("How long was an exposure" in doubt for doubt in suggested.doubts)


def test_leaving_times_of_several_conditions_stand_side_by_side(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", "Abbruch nach blur (min)", "Abbruch nach plain (min)"]]
    rows += [["P1", "2.5", ""], ["P2", "", "10"], ["P3", "-", "1"]]
    found = suggest_mapping([write(tmp_path / "abbruch.csv", rows)])
    assert 'heading = "Abbruch nach {condition} (min)"' in found.text
    keys = (
        'participant = { column = "ID" }\n'
        'left_at = { heading = "Abbruch nach {condition} (min)", unit = "min", planned_s = 600, '
        'missing = ["-"] }\n'
    )
    ends = imported(tmp_path, rows, keys).ends
    left = {
        (e.administration.participant, e.administration.condition, e.end_s) for e in ends if e.left
    }
    assert left == {("P1", "blur", 150.0), ("P3", "plain", 60.0)}
    assert len(ends) == 6


def test_a_text_that_is_no_leaving_time_is_refused(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", "left"], ["P1", "early"]]
    keys = 'participant = { column = "ID" }\nleft_at = { heading = "left", planned_s = 600 }\n'
    with pytest.raises(InputError, match="row 2, column 'left': 'early' is not a time"):
        imported(tmp_path, rows, keys)
