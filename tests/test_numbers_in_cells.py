"""What counts as a number in a cell is decided in one place, for every table that is read."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import vrcomfort
from tests.support.report import Study, build_report, foreign
from vrcomfort.csv_table import number_in, number_or_none
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import score_file, shipped_instruments
from vrcomfort.report.courses.exposures import _rating
from vrcomfort.report.measures.model import number_of
from vrcomfort.report.study_data import trial_s

NONE = ("x", "1_000", "\u0661", "inf", "-Infinity", "nan", "NA", "1,5", "0x1", "1e999", "--1")
"""What Python, or other programs, take for a number, and what is none."""
READERS = ("report", "questionnaire", "exchange", "recordings", "importing", "records", "traces")
OPTIONS = {"report/power.py"}
"""Reads words of the command line, not cells."""
PARSERS = {"float", "int", "Fraction", "Decimal"}


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


@pytest.mark.parametrize("cell", ["NA", "nan", " N/A "])
def test_the_words_of_other_programs_for_nothing_are_blank_in_tables_of_measures(cell):
    assert number_in(cell, words=True) is None
    assert number_of(cell) is None
    assert np.isnan(_rating({"onset_s": "1", "response": cell})[1])


@pytest.mark.parametrize("cell", ["x", "1_000", "\u0661", "inf"])
def test_every_reader_refuses_or_passes_over_the_same(tmp_path, cell):
    with pytest.raises(ValueError, match=r"number|plain digits|could not convert"):
        number_of(cell)
    with pytest.raises(InputError, match="give a number"):
        _rating({"onset_s": "1", "response": cell})
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
    """A parse whose failure is caught is a rule of its own, unless it is of `plain_digits`."""
    root = Path(vrcomfort.__file__).parent
    found = [
        f"{file.relative_to(root)}, line {call.lineno}: {ast.unparse(call)}"
        for file in sorted((root / folder).rglob("*.py"))
        if file.relative_to(root).as_posix() not in OPTIONS
        for call in _guarded(ast.parse(file.read_text("utf-8")))
        if "plain_digits" not in ast.unparse(call)
    ]
    assert found == []


def test_a_rule_of_its_own_would_be_found():
    calls = _guarded(ast.parse("try:\n    x = float(cell)\nexcept ValueError:\n    x = None"))
    assert [ast.unparse(call) for call in calls] == ["float(cell)"]


def _guarded(tree: ast.Module) -> list[ast.Call]:
    """Return the calls that parse a number within ``try … except ValueError``."""
    return [
        call
        for node in ast.walk(tree)
        if isinstance(node, ast.Try)
        if any(each.type and "ValueError" in ast.unparse(each.type) for each in node.handlers)
        for call in ast.walk(ast.Module(node.body, []))
        if isinstance(call, ast.Call)
        if isinstance(call.func, ast.Name)
        if call.func.id in PARSERS
    ]
