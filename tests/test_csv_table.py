"""Tables that people bring: traces, records and answers are refused in the same words."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.report import ITEMS, foreign
from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import score_file, shipped_instruments
from vrcomfort.report.study_data import read_study
from vrcomfort.traces.trace import read_trace

TRACE = "xr_time_ns,head_x_m,head_y_m,head_z_m,head_qx,head_qy,head_qz,head_qw"
TEXTS: dict[str, tuple[Callable[[Path], Any], str]] = {
    "trace.csv": (read_trace, f"{TRACE}\n1,0.5,1.6,0,0,0,0,1\n2,0.5,1.6,0,0,0,0,1\n"),
    "questionnaires.csv": (
        read_study,
        "participant,condition,item,response\nP1,a,nausea,1\nP1,a,fatigue,0\n",
    ),
    "answers.csv": (
        lambda file: score_file(file, shipped_instruments()["ssq"]),
        f"who,{','.join(ITEMS)}\nA{',1' * 16}\nB{',0' * 16}\n",
    ),
}


@pytest.fixture(params=TEXTS)
def table(request: pytest.FixtureRequest, tmp_path: Path) -> Any:
    """Return (what reads a file, the file's good text, the file)."""
    read, text = TEXTS[request.param]
    return read, text, tmp_path / request.param


def refusal(table: Any, content: bytes) -> InputError:
    read, _, file = table
    file.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read(file)
    assert caught.value.file == file
    return caught.value


def test_what_spreadsheets_write_is_read(table):
    read, text, file = table
    file.write_text(text, encoding="utf-8")
    plain = repr(read(file))
    windows = text.replace("\n", "\r\n").encode("utf-8")
    for content in (b"\xef\xbb\xbf" + windows, windows.replace(b"\r\n", b"\r")):
        file.write_bytes(content)
        assert repr(read(file)) == plain


@pytest.mark.parametrize(
    ("change", "says", "line"),
    [
        (lambda text: text.replace(",", ";").encode(), "separated by `;`; save it with", 1),
        (lambda text: text.replace(",", "\t").encode(), "separated by tabs; save it with", 1),
        (lambda text: text.encode("utf-16"), "UTF-16; save it as CSV in UTF-8", 1),
        (lambda text: text.replace("\n", "é\n", 2).encode("latin-1"), "not UTF-8; save", 1),
        (lambda text: text.replace("\n", "\0\n", 1).encode(), "not a text file; a CSV", None),
        (lambda text: _line(text, 2, "1,2").encode(), "2 cells, the header has", 2),
        (lambda text: _line(text, 2, text.split("\n")[1] + ",5").encode(), "decimals need", 2),
        (lambda text: _twice(text).encode(), "appears twice; keep one", 1),
    ],
)
def test_the_same_fault_is_told_in_the_same_words(table, change, says, line):
    error = refusal(table, change(table[1]))
    assert says in error.message
    assert error.line == line


def _line(text: str, number: int, new: str) -> str:
    lines = text.split("\n")
    return "\n".join([*lines[: number - 1], new, *lines[number:]])


def _twice(text: str) -> str:
    first = text.partition(",")[0]
    return "".join(f"{line},{first}\n" for line in text.splitlines())


def test_a_missing_column_and_a_text_among_numbers_have_their_place(table):
    _, text, _ = table
    last = text.split("\n")[0].rpartition(",")[2]
    error = refusal(table, text.replace(last, "other", 1).encode())
    assert (error.line, last in error.message) == (1, True)
    words = text.splitlines()
    words[1] = words[1].rpartition(",")[0] + ",many"
    error = refusal(table, "\n".join([*words, ""]).encode())
    assert (error.line, error.column, "many" in error.message) == (2, last, True)


def test_no_file_a_folder_and_an_empty_file_are_told_apart(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        CsvTable.read(tmp_path / "none.csv")
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        CsvTable.read(tmp_path)
    (tmp_path / "empty.csv").touch()
    assert CsvTable.read(tmp_path / "empty.csv").header == ()


def test_a_table_written_by_hand_needs_no_last_line_end(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text(' a , b\n1,"2\n3"\n,\n\n4,5', encoding="utf-8")
    table = CsvTable.read(file)
    assert table.header == ("a", "b")
    assert (table.rows, table.lines) == ((("1", "2\n3"), ("4", "5")), (3, 6))
    assert CsvTable.read(file, appended=True).lines == (3,)


@pytest.mark.parametrize(
    ("content", "rows", "warnings"),
    [
        (b"a,b\n1,2\n3,4\n", 2, 0),
        (b"\xef\xbb\xbfa,b\r\n1,2\r\n", 1, 0),
        (b"a,b\n1,2\n3,4", 1, 1),
        (b"a,b\n1,2\n3", 1, 1),
        (b"a,b\n1,2\n3\n", 1, 1),
        (b"a,b\n1,2\n3,\xc3", 1, 1),
        (b'a,b\n1,2\n"3', 1, 1),
        (b"a,b\n", 0, 0),
        (b"a,", 0, 1),
        (b"", 0, 0),
    ],
)
def test_a_half_written_last_row_is_reported_and_left_out(tmp_path, content, rows, warnings):
    file = tmp_path / "t.csv"
    file.write_bytes(content)
    found = CsvTable.read(file, appended=True)
    assert (len(found.rows), len(found.warnings)) == (rows, warnings)
    assert all("half-written" in warning and "t.csv, line" in warning for warning in found.warnings)


@given(st.integers(0, 60))
def test_every_cut_keeps_exactly_the_whole_rows(tmp_path_factory, cut):
    content = b"a,b\n1,22\n333,4\n5,66\n7,888\n99,0\n1,1\n22,333\n4,5555\n"
    file = tmp_path_factory.mktemp("cut") / "t.csv"
    file.write_bytes(content[:cut])
    found = CsvTable.read(file, appended=True)
    assert len(found.rows) == max(content[:cut].count(b"\n") - 1, 0)
    assert bool(found.warnings) == (bool(content[:cut]) and not content[:cut].endswith(b"\n"))


def test_a_broken_row_in_the_middle_is_an_error(tmp_path):
    file = tmp_path / "t.csv"
    file.write_bytes(b"a,b\n1\n3,4\n")
    with pytest.raises(InputError, match="1 cells, the header has 2") as caught:
        CsvTable.read(file, appended=True)
    assert caught.value.line == 2


def test_a_damaged_number_beside_the_answers_is_told(tmp_path):
    foreign(tmp_path / "questionnaires.csv", {"P1": {"on": 3, "off": 5}})
    trials = tmp_path / "trials.csv"
    columns = "participant,session,trial,condition,scene,status,start_s,end_s"
    trials.write_text(f"{columns}\nP1,1,1,on,x,completed,,\nP1,1,2,on,x,completed,0,1:30\n")
    with pytest.raises(InputError, match="'1:30' is not a number") as caught:
        read_study(tmp_path)
    assert (caught.value.file, caught.value.line, caught.value.column) == (trials, 3, "end_s")


@pytest.mark.parametrize("digits", ["1_0", "0_1", "\u0661", "\uff11", "1\u0660"])
def test_digits_that_only_python_reads_are_no_number(table, digits):
    _, text, _ = table
    line = text.index("\n") + 1
    for old in (",1.6,", ",nausea,1", ",1,1"):
        if old in text[line:]:
            new = f"{old[: old.rindex('1')]}{digits}{old[old.rindex('1') + 1 :]}"
            error = refusal(table, (text[:line] + text[line:].replace(old, new, 1)).encode())
            assert error.line == 2
            assert digits in error.message
            assert "not a" in error.message
            break
    else:
        pytest.fail("no number was replaced")


@pytest.mark.parametrize("time", ["1_000", "\u0661"])
def test_times_of_traces_are_plain_digits(tmp_path, time):
    file = tmp_path / "trace.csv"
    file.write_text(f"{TRACE}\n{time},0,1.6,0,0,0,0,1\n", encoding="utf-8")
    with pytest.raises(InputError, match="is not a whole number") as caught:
        read_trace(file)
    assert (caught.value.line, caught.value.column) == (2, "xr_time_ns")


@pytest.mark.parametrize("cell", ["1_0", "\u0661", "\u00b2"])
def test_numbers_of_records_are_plain_digits(tmp_path, cell):
    file = tmp_path / "trials.csv"
    file.write_text(f"trial,frames\n1,{cell}\n", encoding="utf-8")
    table = CsvTable.read(file)
    with pytest.raises(InputError, match="not a number; write digits, with a decimal point"):
        table.require_numbers(["frames"])
