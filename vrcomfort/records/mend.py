"""Cuts half-written last rows off files that are to be continued; what is cut off is kept."""

from __future__ import annotations

import os
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.records.appended_file import AppendedFile
from vrcomfort.records.disk import Access, open_new, refuse_links, refused, sync_folder
from vrcomfort.records.recorded_rows import is_header, split_line
from vrcomfort.records.rows import Row, csv_line


def mend(folder: Path, row_type: type[Row], access: Access) -> str | None:
    """Leave the whole rows in a file, or a header where there is not even that.

    The half-written last row of a file (NUL bytes, after a power cut) is moved to the end of a
    file beside it, whose name has ``.cut`` appended.

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
    file = folder / row_type.FILE
    try:
        refuse_links(folder, file)
        if not file.exists() or not file.stat().st_size:
            _begin(file, row_type, access)
            return None
        whole, lines = _whole_rows(file, row_type)
        return _cut(file, whole, lines, row_type, access) if whole < file.stat().st_size else None
    except OSError as error:
        raise refused(file, error) from error


def _begin(file: Path, row_type: type[Row], access: Access) -> None:
    again = AppendedFile(file, access, fresh=True)
    try:
        again.append(csv_line(row_type.columns()))
        again.sync()
        sync_folder(file.parent)
    finally:
        again.close()


def _whole_rows(file: Path, row_type: type[Row]) -> tuple[int, int]:
    """Return how many bytes and lines are whole; at most one line is not."""
    whole = lines = 0
    header: list[str] | None = None
    broken = False
    with file.open("rb") as stream:
        for line in stream:
            if broken:
                raise InputError("this row is broken; mend it first", file=file, line=lines + 1)
            cells = _cells(line)
            broken = cells is None or (header is not None and len(cells) != len(header))
            if header is None and cells is not None:
                header = cells
                if not is_header(header, row_type):
                    message = "this file has other columns: it is from another version of vrcomfort"
                    message = f"{message}; resume the session with that one"
                    raise InputError(message, file=file, line=1)
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


def _cut(file: Path, whole: int, lines: int, row_type: type[Row], access: Access) -> str:
    beside = file.with_name(f"{file.name}.cut")
    with (
        file.open("r+b") as stream,
        os.fdopen(open_new(beside, access, os.O_APPEND), "ab") as rest,
    ):
        stream.seek(whole)
        rest.write(stream.read().rstrip(b"\n") + b"\n")
        rest.flush()
        os.fsync(rest.fileno())  # first: it must be somewhere
        sync_folder(file.parent)
        stream.seek(whole)
        stream.truncate()
        stream.write(b"" if lines else csv_line(row_type.columns()).encode())
        stream.flush()
        os.fsync(stream.fileno())
    return f"{file}, line {lines + 1}: a half-written row was moved to {beside.name}"
