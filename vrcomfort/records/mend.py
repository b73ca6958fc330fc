"""Cuts half-written last rows off files that are to be continued; what is cut off is kept."""

from __future__ import annotations

import csv
import os
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.records.recorder import csv_line, refused, replace_text
from vrcomfort.records.schema import ADDED_COLUMNS


def mend(file: Path, columns: tuple[str, ...]) -> str | None:
    """Leave the whole rows in a file, or a header where there is not even that.

    The half-written last row of a file is moved to the end of a file beside it, whose name has
    ``.cut`` appended. A file of an older schema gets the columns that it lacks, blank; it stays as
    it was beside, with ``.schema1`` appended.

    Returns
    -------
    str or None
        What was cut off, in one sentence.

    Raises
    ------
    InputError
        If the header is another, a row before the last is broken, or the disk refuses.
    """
    try:
        if not file.exists() or not file.stat().st_size:
            file.write_text(csv_line(columns), encoding="utf-8", newline="")
            return None
        return _mended(file, columns)
    except OSError as error:
        raise refused(file, error) from error


def _mended(file: Path, columns: tuple[str, ...]) -> str | None:
    there = _columns_there(file, columns)
    whole, lines = _whole_rows(file, there)
    cut = _cut(file, whole, lines, there) if whole < file.stat().st_size else None
    if there != columns:
        _add_columns(file, there, columns)
    return cut


def _columns_there(file: Path, columns: tuple[str, ...]) -> tuple[str, ...]:
    """Return the columns of a file's own schema, if its header is of an older one."""
    added = ADDED_COLUMNS.get(file.name, ())
    older = tuple(column for column in columns if column not in added)
    with file.open("rb") as stream:
        return older if stream.readline() == csv_line(older).encode() else columns


def _add_columns(file: Path, there: tuple[str, ...], columns: tuple[str, ...]) -> None:
    """Put blank cells where `there` has no column."""
    with file.open(encoding="utf-8", newline="") as stream:
        rows = csv.reader(stream)
        next(rows)
        cells = (dict(zip(there, row, strict=True)) for row in rows)
        lines = [csv_line(row.get(column, "") for column in columns) for row in cells]
    kept = file.with_name(f"{file.name}.schema1")
    kept.unlink(missing_ok=True)
    kept.hardlink_to(file)
    replace_text(file, csv_line(columns) + "".join(lines))


def _whole_rows(file: Path, columns: tuple[str, ...]) -> tuple[int, int]:
    """Return how many bytes and lines are whole; at most one line is not."""
    whole = lines = 0
    broken = False
    with file.open("rb") as stream:
        for line in stream:
            if broken:
                raise InputError("this row is broken; mend it first", file=file, line=lines + 1)
            broken = not line.endswith(b"\n") or not _is_row(line, columns)
            if not broken and not lines and _cells(line) != list(columns):
                message = "this file has other columns: it is from another version of vrcomfort"
                raise InputError(f"{message}; resume the session with that one", file=file, line=1)
            whole += 0 if broken else len(line)
            lines += not broken
    return whole, lines


def _is_row(line: bytes, columns: tuple[str, ...]) -> bool:
    try:
        return len(_cells(line)) == len(columns)
    except UnicodeDecodeError:
        return False


def _cells(line: bytes) -> list[str]:
    return next(csv.reader([line.decode("utf-8-sig")]), [])


def _cut(file: Path, whole: int, lines: int, columns: tuple[str, ...]) -> str:
    beside = file.with_name(f"{file.name}.cut")
    with file.open("r+b") as stream, beside.open("ab") as rest:
        stream.seek(whole)
        rest.write(stream.read().rstrip(b"\n") + b"\n")
        rest.flush()
        os.fsync(rest.fileno())  # first: it must be somewhere
        stream.seek(whole)
        stream.truncate()
        stream.write(b"" if lines else csv_line(columns).encode())
    return f"{file}, line {lines + 1}: a half-written row was moved to {beside.name}"
