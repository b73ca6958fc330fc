"""Finds the place of what is wrong in a recording, once it is known that something is."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from vrcomfort.csv_table import CsvTable, plain_digits
from vrcomfort.errors import InputError
from vrcomfort.recordings.columns import NEEDED, Kind, kinds

_ROWS_AT_ONCE = 4096
_LARGEST = 2**63
TIME = "xr_time_ns"


def check_header(table: CsvTable) -> None:
    """Raise `InputError` if a table lacks what makes it a recording."""
    if not table.header:
        raise InputError("the file is empty; a recording starts with a header row", file=table.file)
    table.require(NEEDED[table.file.name])


def find_damage(file: Path) -> InputError | None:
    """Read a recording cell by cell and return what is wrong first; None if nothing is.

    A last row that is half-written is not wrong: the program that wrote it was ended.
    """
    before_ns: int | None = None
    try:
        for table in CsvTable.parts(file, appended=True, most_rows=_ROWS_AT_ONCE):
            check_header(table)
            if fault := _in_cells(table) or _in_time(table, before_ns):
                return fault
            if table.rows:
                before_ns = int(table.rows[-1][table.header.index(TIME)])
    except InputError as error:
        return error
    return None


def _in_cells(table: CsvTable) -> InputError | None:
    checks = [
        (place, name, _CHECKS[kind])
        for place, (name, kind) in enumerate(kinds(table.header).items())
        if kind in _CHECKS
    ]
    for line, row in zip(table.lines, table.rows, strict=True):
        for place, name, check in checks:
            if row[place].strip() and (what := check(row[place])):
                shown = repr(row[place] if len(row[place]) <= 40 else f"{row[place][:40]}…")
                return table.fault(f"{shown} is not {what}; mend it first", line, name)
    return None


def _in_time(table: CsvTable, before_ns: int | None) -> InputError | None:
    place = table.header.index(TIME)
    for line, row in zip(table.lines, table.rows, strict=True):
        if not row[place].strip():
            return table.fault("the time of this frame is missing; mend it first", line, TIME)
        now_ns = int(row[place])
        if before_ns is not None and now_ns <= before_ns:
            return table.fault("time does not go on from the row before; mend it first", line, TIME)
        before_ns = now_ns
    return None


def _not_whole(cell: str) -> str:
    try:
        return "" if abs(int(plain_digits(cell))) < _LARGEST else "a number of 64 bits"
    except ValueError:
        return "a whole number"


def _not_real(cell: str) -> str:
    try:
        return "" if math.isfinite(float(plain_digits(cell))) else "a finite number"
    except ValueError:
        return "a number"


_CHECKS: dict[Kind, Callable[[str], str]] = {"BIGINT": _not_whole, "DOUBLE": _not_real}
