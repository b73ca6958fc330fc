"""Tables, JSON and TOML made to take all memory or time are read, or refused in one sentence.

Each is small enough to be written in a moment; `python -m torture --only commands` has others.
"""

from __future__ import annotations

import json
import time
import tracemalloc
from collections.abc import Callable

import pytest

from tests.support.workbooks import with_sheet
from vrcomfort import csv_table
from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.importing import text_files, workbooks
from vrcomfort.importing.answers import number
from vrcomfort.importing.files import read_tables
from vrcomfort.importing.suggest import suggest_mapping
from vrcomfort.protocol import load_protocol
from vrcomfort.records.json_file import ManifestShape, read_json
from vrcomfort.settings.reading import MOST_TOLD

MOST_MEMORY, MOST_S = 50e6, 20.0
TOML: dict[str, tuple[Callable[[], str], str]] = {
    "a key of 20,000 parts": (lambda: ".".join("a" * 20_000) + " = 1", "nested too deep"),
    "a table of 20,000 parts": (lambda: f"[{'.'.join('a' * 20_000)}]", "nested too deep"),
    "quoted parts": (lambda: " . ".join(['"a b"'] * 101) + " = 1", "nested too deep"),
    "parts in an inline table": (lambda: f"a = {{ {'.'.join('a' * 101)} = 1 }}", "nested too deep"),
    "150 lists in each other": (lambda: "a = " + "[" * 150 + "]" * 150, "nested too deep"),
    "10,000 lists in each other": (lambda: "a = " + "[" * 10_000, "nested too deep"),
    "5 MB": (lambda: "# x\n" * 1_250_000, "has 5,000,000 characters, and may have 4,194,304"),
    "20,000 unknown keys": (
        lambda: "".join(f"k{n} = {n}\n" for n in range(20_000)), "100 more problems"
    ),
    "a text of 1.5 MB": (lambda: f'title = "{"x" * 1_500_000}"', "`name` is missing"),
    "100,000 lists": (lambda: f"a = [{'[],' * 100_000}]", "unknown key `a`"),
}  # fmt: skip
LAB: dict[str, tuple[str, Callable[[], str], str]] = {
    "5 million values": ("a.json", lambda: f"[{'[],' * 5_000_000}[]]", "more than 4,194,304 val"),
    "5 million lines": ("a.jsonl", lambda: "1\n" * 5_000_000, "more than 4,194,304 values"),
    "repeated values": (
        "a.json",
        lambda: json.dumps({f"a{n}": n for n in range(3000)} | {"rows": [{"x": 1}] * 3000}),
        "more than 1,000,000 cells",
    ),
    "long names": (
        "a.json",
        lambda: json.dumps({"n" * 100_000: {f"a{n}": n for n in range(2000)}}),
        "more than 1,000,000 cells",
    ),
    "names of 20,000 columns": (
        "a.json", lambda: json.dumps([{f"a{n}": n for n in range(20_000)}]), "20,000 columns"
    ),
    "20,000 columns": ("a.csv", lambda: ",".join("a" * 20_000) + "\n", "row 1 has 20,000 columns"),
    "20,000 answers in cells": (
        "a.csv",
        lambda: "a,response\n" + "".join(
            f"1,{json.dumps({f'a{row}_{n}': n for n in range(4000)})}\n".replace('"', '""')
            .replace(",", ',"', 1).replace("\n", '"\n') for row in range(5)
        ),
        "the answers in its cells has 20,002 columns",
    ),
    "blank rows": ("a.csv", lambda: "a,b\n" + "\n" * 300_000, "more than 1,000,000 cells"),
    "a long text": ("a.csv", lambda: f"a,b\n1,{'x' * 1_500_000}\n", "field larger than"),
}  # fmt: skip
BOOKS = {
    "many cells of a row": (f"<row>{'<c/>' * 90_000}</row>", "", "16,385 columns"),
    "many rows": ("<row/>" * 110_000, "", "more than 100,000 cells"),
    "many parts of a text": (
        f"<row><c><is>{'<r/>' * 26_000}</is></c></row>", "", "more than 100,000 cells"
    ),
    "many merged cells": (
        "<row/>", f"<mergeCells>{'<mergeCell/>' * 21_000}</mergeCells>", "more than 20,000 styles"
    ),
}  # fmt: skip


@pytest.fixture(autouse=True)
def _within_limits():
    began_s = time.process_time()
    yield
    assert time.process_time() - began_s < MOST_S


def refused(read: Callable[[], object], says: str) -> None:
    with pytest.raises(InputError) as said:
        read()
    assert says in str(said.value)
    assert "\n" not in str(said.value)


@pytest.mark.parametrize("name", TOML)
def test_toml(tmp_path, name):
    text, says = TOML[name]
    file = tmp_path / "p.toml"
    file.write_text(text())
    refused(lambda: load_protocol(file), says)


def test_no_more_faults_of_a_file_are_told_than_anybody_reads(tmp_path):
    file = tmp_path / "p.toml"
    file.write_text("".join(f"k{n} = {n}\n" for n in range(3000)))
    with pytest.raises(InputError) as said:
        load_protocol(file)
    assert len(said.value.others) == MOST_TOLD
    assert [each.line for each in said.value.others[:3]] == [2, 3, 4]


@pytest.mark.parametrize("name", LAB)
def test_tables_of_labs(tmp_path, monkeypatch, name):
    monkeypatch.setattr(text_files, "MOST_CELLS", 1_000_000)
    ending, text, says = LAB[name]
    file = tmp_path / ending
    file.write_text(text())
    refused(lambda: read_tables(file), says)


@pytest.mark.parametrize("name", BOOKS)
def test_workbooks(tmp_path, monkeypatch, name):
    monkeypatch.setattr(workbooks, "MOST_CELLS_READ", 100_000)
    monkeypatch.setattr(workbooks, "MOST_OTHERS", 20_000)
    rows, after, says = BOOKS[name]
    file = tmp_path / "a.xlsx"
    file.write_bytes(with_sheet(rows, after))
    tracemalloc.start()
    try:
        refused(lambda: read_tables(file), says)
        assert tracemalloc.get_traced_memory()[1] < MOST_MEMORY
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('{"a": [' + "[]," * 5_000_000 + "[]]}", "this manifest has more than 4,194,304 values"),
        ('{"a":' * 120 + "1" + "}" * 120, "nested too deep: this manifest is damaged"),
        (" " * (2**26 + 1), "has 67,108,865 bytes, and at most 67,108,864 are read"),
    ],
    ids=["values", "nested", "bytes"],
)
def test_stored_json(tmp_path, text, says):
    file = tmp_path / "manifest.json"
    file.write_text(text)
    refused(lambda: read_json(file, ManifestShape, "manifest"), says)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (",".join(f"a{n}" for n in range(20_000)) + "\n", "this row has 20,000 columns"),
        ("a" * (2**24 + 2**16), "a line has more than 16,777,216 bytes: this is not a table"),
        ("a\n" + "1\n" * 101, "line 102: a table of 1 columns may have 100 rows to here"),
    ],
    ids=["columns", "a line", "rows"],
)
def test_tables_of_studies(tmp_path, monkeypatch, text, says):
    monkeypatch.setattr(csv_table, "MOST_CELLS", 500)
    file = tmp_path / "a.csv"
    file.write_text(text)
    refused(lambda: CsvTable.read(file), says)


def test_a_table_that_is_read_in_parts_may_be_of_any_length(tmp_path, monkeypatch):
    monkeypatch.setattr(csv_table, "MOST_CELLS", 500)
    file = tmp_path / "a.csv"
    file.write_text("a\n" + "1\n" * 300)
    assert sum(len(part.rows) for part in CsvTable.parts(file, most_rows=7)) == 300


def test_a_number_that_no_program_can_hold_is_none(tmp_path):
    assert number("9" * 400, ".") is None
    assert number("1e999", ",") is None
    file = tmp_path / "scores.csv"
    lines = [f"P{n},{'9' * 400},1" for n in range(6)]
    file.write_text("\n".join(["participant,SSQ_N,SSQ_T", *lines]))
    suggest_mapping([file])
