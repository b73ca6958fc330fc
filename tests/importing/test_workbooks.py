"""Workbooks of any kind are read, or refused in one sentence, within little memory."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from tests.support.workbooks import SHEET, archive_of, good_workbook, parts_of, with_sheet
from torture.mutate import worse
from vrcomfort.errors import InputError
from vrcomfort.importing import source, workbooks
from vrcomfort.importing.files import read_tables
from vrcomfort.importing.source import Grid, Reading
from vrcomfort.importing.workbooks import read_workbook

GOOD = good_workbook()
CELLS = '<row r="1"><c r="A1" t="inlineStr"><is><t>code</t></is></c><c r="B1"><v>1</v></c></row>'


def grids(folder: Path, content: bytes) -> list[Grid]:
    file = folder / "answers.xlsx"
    file.write_bytes(content)
    return read_workbook(file, Reading())


def test_cells_are_text_and_merged_ones_are_filled(tmp_path):
    answers, more = grids(tmp_path, GOOD)
    assert answers.rows == (
        ("code", "day", "before", "before", "after", "after"),
        ("code", "", "nausea", "fatigue", "nausea", "fatigue"),
        ("P01", "2026-03-01T00:00:00", "0", "1.5", "none", "true"),
        ("P02", "2026-03-02T09:30:00", "2", "0", "slight", "false"),
    )
    assert answers.numbers == (1, 2, 3, 4)
    assert (more.sheet, more.rows) == ("more", (("code", "age"), ("P01", "31")))


def test_a_workbook_that_takes_too_long_is_refused(tmp_path):
    file = tmp_path / "slow.xlsx"
    file.write_bytes(GOOD)
    with pytest.raises(InputError, match=r"slow\.xlsx: .*takes more than 0 s; .* as CSV"):
        read_workbook(file, Reading(), most_s=0.0)


@pytest.mark.parametrize("first", range(0, 120, 20))
def test_a_damaged_workbook_is_read_or_refused_in_one_sentence(tmp_path, first):
    refused = []
    for seed in range(first, first + 20):
        try:
            grids(tmp_path, worse(GOOD, ".xlsx", np.random.default_rng(seed)))
        except InputError as error:
            refused.append(str(error))
    assert len(refused) > 5
    assert all(each.startswith(f"{tmp_path / 'answers.xlsx'}") for each in refused)
    assert not any("\n" in each for each in refused)


@pytest.mark.parametrize(
    ("rows", "after", "before"),
    [
        (CELLS, "", '<dimension ref="A1:XFD1048576"/>'),
        (CELLS, '<mergeCells><mergeCell ref="A1:XFD1048576"/></mergeCells>', ""),
        (f'{CELLS}<row r="1048576"><c r="XFD1048576"><v>1</v></c></row>', "", ""),
        ('<row r="99999999999"><c r="A99999999999"><v>1</v></c></row>', "", ""),
    ],
    ids=["dimension", "merged", "far", "no row of Excel"],
)
def test_a_small_workbook_takes_little_memory(tmp_path, rows, after, before):
    content = with_sheet(rows, after, before)
    assert len(content) < 10_000
    grids(tmp_path, GOOD)  # openpyxl is loaded by now
    tracemalloc.start()
    try:
        assert grids(tmp_path, content)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


def test_merged_cells_below_and_beside_all_others_are_left_alone(tmp_path):
    answers, _ = grids(
        tmp_path, with_sheet(CELLS, '<mergeCells><mergeCell ref="A1:XFD1048576"/></mergeCells>')
    )
    assert answers.rows == (("code", "code"),)


MANY = "".join(f'<mergeCell ref="A1:B{n}"/>' for n in range(1000, 1100))


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"\xd0\xcf\x11\xe0 and so on", "has a password, or is of Excel's former format; save"),
        (archive_of({"a.txt": b"x"}), "this is not a workbook that can be read; save it as .xlsx"),
        (
            archive_of({**parts_of(GOOD), SHEET: b"<worksheet><row></worksheet>"}),
            rf"{SHEET} of this workbook is damaged \(ExpatError: mismatched tag: line 1, column 18",
        ),
        (
            archive_of({**parts_of(GOOD), SHEET: b'<!DOCTYPE x [<!ENTITY a "ha">]><worksheet>&a;'}),
            f"{SHEET} of this workbook has a document type, as no spreadsheet",
        ),
        (
            with_sheet('<row r="7"><c r="A7" t="s"><v>99999</v></c></row>'),
            r"sheet answers, row 7 is damaged \(IndexError: list index out of range",
        ),
        (
            with_sheet(f"{CELLS}<row><c t='n'><v>{'9' * 5000}</v></c></row>"),
            r"sheet answers, row 2 is damaged \(ValueError: ",
        ),
        (
            with_sheet('<row r="2"><c r="B2"><f>1+1</f></c></row>'),
            "sheet answers, cell B2: this formula has no saved value; open the workbook",
        ),
        (
            with_sheet(f'<row><c t="inlineStr"><is><t>{"x" * 200_000}</t></is></c></row>'),
            "sheet answers, cell A1: this text has 200,000 characters; a cell of a table has at",
        ),
        (with_sheet("")[:-200], "this is not a workbook that can be read"),
    ],
)
def test_what_cannot_be_read_is_told_with_its_place(tmp_path, content, says):
    with pytest.raises(InputError, match=says):
        grids(tmp_path, content)


def test_a_formula_whose_saved_value_is_no_text_is_blank(tmp_path):
    cell = '<c r="B1" t="str"><f>IF(A2="","",1)</f><v></v></c>'
    answers, _ = grids(tmp_path, with_sheet(CELLS.replace('<c r="B1"><v>1</v></c>', cell)))
    assert answers.rows == (("code",),)


@pytest.mark.parametrize(
    ("limit", "value", "rows", "after", "says"),
    [
        ("MOST_BYTES", 10_000, CELLS * 200, "", "workbook unpacks to more than 10,000 bytes"),
        ("MOST_ELEMENTS", 300, CELLS * 100, "", "unpacks to more than 300 elements; delete"),
        ("MOST_CELLS", 90, CELLS * 40, "", "sheet answers, row 1: the workbook has more than 90"),
        ("MOST_CELLS", 300, f'{CELLS}<row r="999"><c r="A999"><v>1</v></c></row>',
         f"<mergeCells>{MANY}</mergeCells>",
         "sheet answers, the merged cells from row 1 to 1000: the workbook has more than 300"),
        ("MOST_CELLS", 300, '<row><c r="ZZ1"><v>1</v></c></row>', "",
         "sheet answers, row 1: the workbook has more than 300 cells up to here; delete what"),
    ],
)  # fmt: skip
def test_more_than_a_table_of_answers_is_refused_before_it_is_made(
    tmp_path, monkeypatch, limit, value, rows, after, says
):
    monkeypatch.setattr(workbooks, limit, value)
    with pytest.raises(InputError, match=says):
        grids(tmp_path, with_sheet(rows, after))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "code,x\n" + ",1" * 40 + "\n" + "P1,1\n" * 40),
        ("a.json", "[" + ",".join(f'{{"k{n}": 1}}' for n in range(40)) + "]"),
    ],
)
def test_rows_are_not_made_as_long_as_the_longest_where_that_is_too_much(
    tmp_path, monkeypatch, name, text
):
    file = tmp_path / name
    file.write_text(text, "utf-8")
    monkeypatch.setattr(source, "MOST_CELLS", 500)
    with pytest.raises(InputError, match=rf"{name}: .* rows have 1,\d+ cells, and may have 500; "):
        read_tables(file)
