"""What counts as a number in a cell is decided in one place, for every table that is read."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import vrcomfort
from tests.support.report import Study, build_report, foreign
from vrcomfort.csv_table import CsvTable, number_in, number_or_none, whole_or_none
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import score_file, shipped_instruments
from vrcomfort.recordings import read_ratings
from vrcomfort.recordings.exposures import measure
from vrcomfort.records.recording import Memory
from vrcomfort.report.measures.model import number_of
from vrcomfort.report.study_data import trial_s

NONE = ("x", "1_000", "\u0661", "inf", "-Infinity", "nan", "NA", "1,5", "0x1", "1e999", "--1")
"""What Python, or other programs, take for a number, and what is none."""
READERS = ("report", "questionnaire", "exchange", "recordings", "importing", "records", "traces")
OPTIONS = {"report/power.py"}
"""Reads words of the command line, not cells."""
PARSERS = {"float", "int", "Fraction", "Decimal"}
COUNT_DIGITS = (".isdigit()", ".isdecimal()")


@pytest.mark.parametrize(
    ("cell", "number"), [("", None), (" ", None), (" 1.5 ", 1.5), ("-2e3", -2e3)]
)
def test_a_cell_is_blank_or_a_finite_number(cell, number):
    assert number_in(cell) == number_or_none(cell) == number


@pytest.mark.parametrize("cell", NONE)
def test_anything_else_is_no_number(cell):
    assert number_or_none(cell) is None
    with pytest.raises(ValueError, match=r"number|plain digits|could not convert"):
        number_in(cell)


@pytest.mark.parametrize("cell", [*NONE, "", "\u2028", "1.5", "1e3", "²", "9" * 30, "9" * 5000])
def test_a_cell_is_a_whole_number_or_none(cell):
    assert whole_or_none(cell) is None
    assert whole_or_none(" -12 ") == -12


@pytest.mark.parametrize("cell", ["x", "\u2028", "", "1.5", "9" * 5000])
@pytest.mark.parametrize("column", ["trial", "start_s", "end_s", "attempt"])
def test_frames_of_an_exposure_whose_row_has_no_number_are_told(tmp_path, column, cell):
    rows = {"participant": "P1", "session": "1", "trial": "1", "start_s": "0", "end_s": "9"}
    rows |= {"attempt": "1"}
    good = [",".join(rows), ",".join(rows.values())]
    rows[column] = cell
    (tmp_path / "trials.csv").write_text("\n".join([*good, ",".join(rows.values()), ""]), "utf-8")
    frames = tmp_path / "frames.csv"
    frames.write_text("session_s\n", "utf-8")
    found = measure(Memory(), frames)
    means_something = (column, cell) in {("attempt", ""), ("attempt", "\u2028"),
                                         ("start_s", "1.5"), ("end_s", "1.5")}  # fmt: skip
    (note,) = found.notes
    assert (f"trials.csv, line 3, column {column}: " in note) != means_something


def test_a_column_is_read_as_numbers_or_refused_with_its_place(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text("a,b\n1,\n-2,2.5\n", "utf-8")
    table = CsvTable.read(file)
    assert table.whole_numbers("a") == [1, -2]
    assert table.numbers("b", blank=0.5) == [0.5, 2.5]
    with pytest.raises(InputError, match=r"t\.csv, line 2, column b: '' is not a number"):
        table.numbers("b")
    with pytest.raises(InputError, match=r"line 3, column b: '2\.5' is not a whole number"):
        table.whole_numbers("b", blank=1)


def rating(folder, cell):
    file = folder / "ratings.csv"
    file.write_text(f"participant,onset_s,response,missed\nP1,1,{cell},0\n", "utf-8")
    (series,) = read_ratings([file]).series
    return series.response[0]


@pytest.mark.parametrize("cell", ["NA", "nan", " N/A "])
def test_the_words_of_other_programs_for_nothing_are_blank_in_tables_of_measures(tmp_path, cell):
    assert number_in(cell, words=True) is None
    assert number_of(cell) is None
    assert np.isnan(rating(tmp_path, cell))


@pytest.mark.parametrize("cell", ["x", "1_000", "\u0661", "inf"])
def test_every_reader_refuses_or_passes_over_the_same(tmp_path, cell):
    with pytest.raises(ValueError, match=r"number|plain digits|could not convert"):
        number_of(cell)
    with pytest.raises(InputError, match=r"ratings\.csv, line 2, column response: .* is not a num"):
        rating(tmp_path, cell)
    assert trial_s({"start_s": "1", "end_s": cell}) is None
    file = foreign(tmp_path / "q.csv", {"P1": {"a": 3, "b": 4}})
    answered = file.read_text("utf-8").replace(
        "general_discomfort,3", f"general_discomfort,{cell}", 1
    )
    file.write_text(answered, "utf-8")
    with pytest.raises(InputError, match="is not a whole number"):
        score_file(file, shipped_instruments()["ssq"])


def test_an_exclusion_by_a_column_passes_over_what_is_no_number(tmp_path):
    study = Study(tmp_path / "s")
    ages = ["30", "1_0", "inf", "nan", "", "12"]
    for i, _ in enumerate(ages):
        study.session(f"P{i}", 1, 1, [("a", "x", 3 + i), ("b", "x", 2)])
    people = [f"P{i},{age}" for i, age in enumerate(ages)]
    (tmp_path / "s" / "participants.csv").write_text("\n".join(["participant,age", *people]) + "\n")
    plan = tmp_path / "plan.toml"
    rule = '[[exclusions]]\nname = "young"\ncolumn = "age"\nbelow = 18\n'
    plan.write_text(f'name = "p"\ntitle = "P"\noutcomes = ["T"]\n{rule}', "utf-8")
    summary = build_report(tmp_path / "s", plan=plan, out=tmp_path / "o")
    assert summary.analysed == 5


@pytest.mark.parametrize("folder", READERS)
def test_no_other_place_decides_what_a_number_is(folder):
    """A parse whose failure is caught or looked out for is a rule of its own.

    Unless it is of `plain_digits`.
    """
    root = Path(vrcomfort.__file__).parent
    found = [
        f"{file.relative_to(root)}, line {call.lineno}: {ast.unparse(call)}"
        for file in sorted((root / folder).rglob("*.py"))
        if file.relative_to(root).as_posix() not in OPTIONS
        for call in _guarded(file.read_text("utf-8"))
        if "plain_digits" not in ast.unparse(call)
    ]
    assert found == []


@pytest.mark.parametrize(
    "text",
    [
        "try:\n    x = float(cell)\nexcept ValueError:\n    x = None",
        "x = float(cell) if cell.isdigit() else None",
        "x = sum(float(cell) for cell in cells if cell.isdecimal())",
    ],
)
def test_a_rule_of_its_own_would_be_found(text):
    assert [ast.unparse(call) for call in _guarded(text)] == ["float(cell)"]


def _guarded(text: str) -> list[ast.Call]:
    """Return the calls that parse a number where ``ValueError`` is caught, or digits counted."""
    if not any(word in text for word in ("ValueError", *COUNT_DIGITS)):
        return []  # parsing takes long
    tree = ast.parse(text)
    caught = [
        ast.Module(node.body, [])
        for node in ast.walk(tree)
        if isinstance(node, ast.Try)
        if any(each.type and "ValueError" in ast.unparse(each.type) for each in node.handlers)
    ]
    looked_at = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.IfExp | ast.GeneratorExp | ast.ListComp)
        if any(test in ast.unparse(node) for test in COUNT_DIGITS)
    ]
    return [
        call
        for node in (*caught, *looked_at)
        for call in ast.walk(node)
        if isinstance(call, ast.Call)
        if isinstance(call.func, ast.Name)
        if call.func.id in PARSERS
    ]
