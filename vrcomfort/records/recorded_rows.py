"""Reads the rows of a session back, and says of each cell that cannot be where it stands."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import plain_digits
from vrcomfort.errors import InputError
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.manifest_shape import LONGEST_S
from vrcomfort.records.rows import Column, Row, declared, single
from vrcomfort.records.schema import SCHEMA_VERSION, columns_of_version

_LARGEST = 2**62
"""What int64 holds with room for a sum."""


@dataclass(frozen=True)
class RecordedRow:
    """One row: column → number, text, or None where it is blank."""

    file: Path
    line: int
    values: Mapping[str, Any]

    def __getitem__(self, column: str) -> Any:
        """Return the value in a column."""
        return self.values[column]

    def fault(self, message: str, column: str) -> InputError:
        """Return the error of one cell."""
        message = f"{message}; mend it first"
        return InputError(message, file=self.file, line=self.line, column=column)


def split_line(line: bytes) -> list[str]:
    """Return the cells of one line of a recorded file.

    Raises
    ------
    ValueError
        If this is no line that a recorder writes.
    """
    if b"\0" in line:
        raise ValueError("it has bytes that are no text")
    try:
        return next(csv.reader([line.decode("utf-8-sig")], strict=True), [])
    except csv.Error as error:
        raise ValueError(str(error)) from error


def read_rows(
    folder: Path, row_type: type[Row], *, version: int = SCHEMA_VERSION, cut: bool = False
) -> Iterator[RecordedRow]:
    """Yield the rows of a file.

    Parameters
    ----------
    version
        Of the schema that it was written in; columns that came later are None.
    cut
        The last row may be half-written, by a program that was killed; it is left out then. Else
        the file has been mended.

    Raises
    ------
    InputError
        If a line is no row, a column is missing, or a cell is not what its column holds.
    """
    file, columns = folder / row_type.FILE, columns_read(row_type)
    there = columns_of_version(version, row_type.FILE, row_type.columns())
    with file.open("rb") as stream:
        header = _cells(file, 1, stream.readline())
        if missing := [name for name in columns if name in there and name not in header]:
            message = f"the column is missing; it has: {', '.join(header)}"
            raise InputError(message, file=file, line=1, column=missing[0])
        known = {name: kind for name, kind in columns.items() if name in header}
        for number, line in enumerate(stream, start=2):
            if cut and not line.endswith(b"\n"):
                return
            yield RecordedRow(file, number, _values(file, number, line, header, known, columns))


def _cells(file: Path, number: int, line: bytes) -> list[str]:
    """Return the cells of a file's line, its header too; raise InputError with its place."""
    try:
        return split_line(line)
    except ValueError as error:
        raise InputError(f"is no row: {error}; mend it first", file=file, line=number) from None


def _values(
    file: Path,
    number: int,
    line: bytes,
    header: Sequence[str],
    known: Mapping[str, Column],
    columns: Mapping[str, Column],
) -> Mapping[str, Any]:
    """Return column → value of one line."""
    there = _cells(file, number, line)
    if len(there) != len(header):
        message = f"is no row: {len(there)} cells under {len(header)} columns; mend it first"
        raise InputError(message, file=file, line=number)
    cells = dict(zip(header, there, strict=True))
    values: dict[str, Any] = dict.fromkeys(columns)
    try:
        values.update((name, cell_value(cells[name], known[name])) for name in known)
    except ValueError as error:
        column, message = error.args
        message = f"{message}; mend it first"
        raise InputError(message, file=file, line=number, column=column) from None
    return values


def columns_read(row_type: type[Row]) -> Mapping[str, Column]:
    """Return the columns whose cells are read as values: of frames and gaze the least.

    These files are large. Whoever plays frames back checks the rest.
    """
    if row_type in (FrameRow, GazeRow):
        return {each.name: each for each in single(row_type) if not each.blank and not each.needs}
    return {each.name: each for each in declared(row_type)}


def cell_value(cell: str, column: Column) -> Any:
    """Return a cell's value; raise `ValueError` with the column and what is wrong."""
    if column.type is str:
        return cell
    if not cell.strip() and column.blank:
        return None
    shown = repr(cell if len(cell) <= 40 else f"{cell[:40]}…")
    try:
        value = (int if column.type is int else float)(plain_digits(cell))
    except ValueError:
        raise ValueError(column.name, f"{shown} is not a number") from None
    largest = LONGEST_S if column.type is float and column.unit else _LARGEST
    if abs(value) > largest or math.isnan(value):
        raise ValueError(column.name, f"{shown} is larger than anything recorded")
    if value < 0 and not column.signed:
        raise ValueError(column.name, f"{shown} is less than 0")
    if column.name == "resumed" and value > 1:
        raise ValueError(column.name, f"{shown} is neither 0 nor 1")
    return value
