"""Reads the rows of a session's file; what is no row is a finding, and the others are read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import plain_digits
from vrcomfort.exchange.verifying.findings import Verified
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.recorded_rows import RecordedRow, cell_value, columns_read, split_line
from vrcomfort.records.rows import Column, Row, declared
from vrcomfort.records.schema import (
    OPTIONAL_ROWS,
    SCHEMA_VERSION,
    SESSION_ROWS,
    columns_of_version,
    later_columns,
)

HALF = "this row is half-written; `vrcomfort run … --resume` moves it aside, or remove the line"


def note_version(folder: Path, version: int, found: Verified) -> None:
    """Say of a session of an older schema version which columns it is without."""
    files = (each.FILE for each in (*SESSION_ROWS, *OPTIONAL_ROWS))
    later = later_columns(version, [name for name in files if (folder / name).exists()])
    if later:
        named = "; ".join(f"{name}: {', '.join(columns)}" for name, columns in later.items())
        message = f"recorded in schema version {version} (now {SCHEMA_VERSION}), without {named}"
        found.note(folder / "manifest.json", message)


def read(folder: Path, row_type: type[Row], version: int, found: Verified) -> Iterator[RecordedRow]:
    """Yield the rows of a file that can be read.

    Parameters
    ----------
    version
        Of the schema, as the manifest says: an older one has fewer columns.
    """
    file = folder / row_type.FILE
    if file.is_symlink():
        found.fault(file, "is a symbolic link; put the file itself here")
        return
    if not file.exists():
        found.fault(file, "is missing; restore it from a copy")
        return
    with file.open("rb") as stream:
        header = _header(file, stream.readline(), row_type, version, found)
        if header is None:
            return
        columns = {name: of for name, of in columns_read(row_type).items() if name in header}
        numbers = _further_numbers(header, row_type)
        for number, line in enumerate(stream, start=2):
            values = _values(file, number, line, header, columns, found)
            if values is None:
                continue
            cells, known = values
            _check_numbers(file, number, cells, numbers, found)
            found.counts[f"rows of {row_type.FILE}"] += 1
            yield RecordedRow(file, number, known)


def _header(
    file: Path, line: bytes, row_type: type[Row], version: int, found: Verified
) -> tuple[str, ...] | None:
    """Return a file's columns; None, and a finding, where they are not those of its version."""
    try:
        there = tuple(split_line(line))
    except ValueError:  # also text that is no UTF-8
        there = ()
    columns = row_type.columns()
    wanted = columns_of_version(version, row_type.FILE, columns)
    if version < SCHEMA_VERSION and there == columns:
        wanted = columns  # a continuation has begun, and was killed before it wrote the manifest
    if not line.endswith(b"\n"):
        found.fault(file, "the header is half-written or missing; restore it from a copy", 1)
        return None
    if there != wanted:
        lacking = [name for name in wanted if name not in there]
        others = [name for name in there if name not in wanted]
        what = f"lacks {', '.join(lacking)}" if lacking else f"has {', '.join(others)} besides"
        what = what if lacking or others else "has its columns in another order"
        message = f"the header {what}, and schema version {version} wants the columns in "
        found.fault(file, f"{message}docs/data_dictionary.md; restore the file from a copy", 1)
        return None
    return there


def _values(
    file: Path,
    number: int,
    line: bytes,
    header: tuple[str, ...],
    columns: Mapping[str, Column],
    found: Verified,
) -> tuple[dict[str, str], dict[str, Any]] | None:
    """Return the cells of a line, and those of `columns` as values; None with a finding."""
    if not line.endswith(b"\n"):
        found.fault(file, HALF, number)
        return None
    try:
        row = split_line(line)
    except ValueError:  # also text that is no UTF-8
        found.fault(file, "this is no row of text; restore the file from a copy", number)
        return None
    if len(row) != len(header):
        message = f"this row has {len(row)} cells, the header {len(header)}"
        found.fault(file, f"{message}; restore the file from a copy", number)
        return None
    cells = dict(zip(header, row, strict=True))
    try:
        return cells, {name: cell_value(cells[name], of) for name, of in columns.items()}
    except ValueError as error:
        column, message = error.args
        found.fault(file, f"column {column}: {message}; restore the file from a copy", number)
        return None


def _further_numbers(header: tuple[str, ...], row_type: type[Row]) -> tuple[str, ...]:
    """Return the columns of frames and gaze that hold numbers or nothing."""
    if row_type not in (FrameRow, GazeRow):
        return ()
    numbers = {each.name for each in declared(row_type) if each.type is not str}
    return tuple(name for name in header if name in numbers)


def _check_numbers(
    file: Path, number: int, cells: Mapping[str, str], names: tuple[str, ...], found: Verified
) -> None:
    for name in names:
        cell = cells[name]
        if not cell:
            continue
        try:
            float(plain_digits(cell))
        except ValueError:
            message = f"column {name}: {cell[:40]!r} is not a number; restore the file from a copy"
            found.fault(file, message, number)
            return
