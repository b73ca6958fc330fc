"""Cuts half-written last rows off files that are to be continued; what is cut off is kept."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.records.appended_file import AppendedFile
from vrcomfort.records.disk import (
    Access,
    open_new,
    refuse_links,
    refused,
    replace_text,
    sync_folder,
)
from vrcomfort.records.rows import Row, csv_line
from vrcomfort.records.schema import SCHEMA_VERSION, columns_of_version
from vrcomfort.records.tables import split_line, text_rows


def mend(folder: Path, row_type: type[Row], access: Access) -> str | None:
    """Leave the whole rows in a file, or a header where there is not even that.

    The half-written last row of a file (NUL bytes, after a power cut) is moved to the end of a
    file beside it, whose name has ``.cut`` appended. A file of an older schema gets the columns
    that it lacks, blank; it stays as it was beside, with ``.schema1`` (its version) appended.

    Returns
    -------
    str or None
        What was cut off, in one sentence.

    Raises
    ------
    InputError
        If the header is another, a row before the last is broken, the file is a symbolic link, or
        the disk refuses.
    """
    file, columns = folder / row_type.FILE, row_type.columns()
    try:
        refuse_links(folder, file)
        if not file.exists() or not file.stat().st_size:
            _begin(file, columns, access)
            return None
        written = file.stat()
        cut = _mended(file, columns, access)
        os.utime(file, ns=(written.st_atime_ns, written.st_mtime_ns))  # when its last row came
    except OSError as error:
        raise refused(file, error) from error
    return cut


def _begin(file: Path, columns: tuple[str, ...], access: Access) -> None:
    again = AppendedFile(file, access, fresh=True, header=csv_line(columns))
    try:
        again.sync()
        sync_folder(file.parent)
    finally:
        again.close()


def _mended(file: Path, columns: tuple[str, ...], access: Access) -> str | None:
    version, there = _schema_of(file, columns)
    whole, lines = _whole_rows(file, there)
    cut = _cut(file, whole, lines, there, access) if whole < file.stat().st_size else None
    if there != columns:
        _add_columns(file, columns, access, kept=f"{file.name}.schema{version}")
    return cut


def _schema_of(file: Path, columns: tuple[str, ...]) -> tuple[int, tuple[str, ...]]:
    """Return the newest version whose columns a file's header has, and those; else the present."""
    with file.open("rb") as stream:
        header = stream.readline()
    for version in range(SCHEMA_VERSION, 0, -1):
        older = columns_of_version(version, file.name, columns)
        if header == csv_line(older).encode():
            return version, older
    return SCHEMA_VERSION, columns


def _add_columns(file: Path, columns: tuple[str, ...], access: Access, *, kept: str) -> None:
    """Put blank cells where a file is without a column; as it was, it is called `kept`."""
    lines = [csv_line(row.get(column, "") for column in columns) for row in text_rows(file)]
    beside = file.with_name(kept)
    beside.unlink(missing_ok=True)
    try:
        beside.hardlink_to(file)
    except OSError:  # a file system without links
        shutil.copyfile(file, beside)
    replace_text(file, csv_line(columns) + "".join(lines), access)


def _whole_rows(file: Path, columns: tuple[str, ...]) -> tuple[int, int]:
    """Return how many bytes and lines are whole; at most one line is not."""
    whole = lines = 0
    broken = False
    with file.open("rb") as stream:
        for line in stream:
            if broken:
                raise InputError("this row is broken; mend it first", file=file, line=lines + 1)
            cells = _cells(line)
            broken = cells is None or (lines > 0 and len(cells) != len(columns))
            if not broken and not lines and cells != list(columns):
                message = "this file has other columns: it is from another version of vrcomfort"
                raise InputError(f"{message}; resume the session with that one", file=file, line=1)
            whole += 0 if broken else len(line)
            lines += not broken
    return whole, lines


def _cells(line: bytes) -> list[str] | None:
    """Return the cells of a whole line."""
    if not line.endswith(b"\n"):
        return None
    try:
        return split_line(line)
    except ValueError:
        return None


def _cut(file: Path, whole: int, lines: int, columns: tuple[str, ...], access: Access) -> str:
    beside = file.with_name(f"{file.name}.cut")
    with (
        file.open("r+b") as stream,
        os.fdopen(open_new(beside, access, os.O_WRONLY | os.O_APPEND), "ab") as rest,
    ):
        stream.seek(whole)
        rest.write(stream.read().rstrip(b"\n") + b"\n")
        rest.flush()
        os.fsync(rest.fileno())  # first: it must be somewhere
        sync_folder(file.parent)
        stream.seek(whole)
        stream.truncate()
        stream.write(b"" if lines else csv_line(columns).encode())
        stream.flush()
        os.fsync(stream.fileno())
    return f"{file}, line {lines + 1}: a half-written row was moved to {beside.name}"
