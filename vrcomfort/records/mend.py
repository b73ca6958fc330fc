"""Cuts half-written last rows off files that are to be continued; what is cut off is kept."""

from __future__ import annotations

import csv
import os
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.records.disk import refused
from vrcomfort.records.rows import csv_line


def mend(file: Path, columns: tuple[str, ...]) -> str | None:
    """Leave the whole rows in a file, or a header where there is not even that.

    The half-written last row of a file is moved to the end of a file beside it, whose name has
    ``.cut`` appended.

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
        whole, lines = _whole_rows(file, columns)
        return _cut(file, whole, lines, columns) if whole < file.stat().st_size else None
    except OSError as error:
        raise refused(file, error) from error


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
