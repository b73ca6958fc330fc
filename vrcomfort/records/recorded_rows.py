"""Reads the rows of a session back, and says of each cell that cannot be where it stands."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from types import NoneType
from typing import Any, NamedTuple, get_args, get_type_hints

from vrcomfort.csv_table import plain_digits
from vrcomfort.errors import InputError
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.manifest_shape import LONGEST_S
from vrcomfort.records.rows import Row
from vrcomfort.records.schema import SCHEMA_VERSION, columns_of_version


class Kind(NamedTuple):
    """What the cells of a column are."""

    of: type
    may_be_blank: bool = False


_OF_FRAMES: Mapping[str, Kind] = {
    "session_s": Kind(float),
    **dict.fromkeys(
        ("xr_time_ns", "period_ns", "trial", "should_render", "dropped", "discontinuity"),
        Kind(int),
    ),
    "resumed": Kind(int),
}
"""When and for what: whoever plays frames back checks the rest."""

_OF_GAZE: Mapping[str, Kind] = {
    "session_s": Kind(float),
    **dict.fromkeys(("xr_time_ns", "valid", "resumed"), Kind(int)),
}

_MAY_BE_NEGATIVE = {
    "xr_time_ns", "response", "x_m", "y_m", "z_m", "score", "right_deg", "up_deg", "value",
}  # fmt: skip
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
    file, kinds = folder / row_type.FILE, kinds_of(row_type)
    there = columns_of_version(version, row_type.FILE, row_type.columns())
    with file.open("rb") as stream:
        header = split_line(stream.readline())
        if missing := [name for name in kinds if name in there and name not in header]:
            message = f"the column is missing; it has: {', '.join(header)}"
            raise InputError(message, file=file, line=1, column=missing[0])
        known = {name: kind for name, kind in kinds.items() if name in header}
        for number, line in enumerate(stream, start=2):
            if cut and not line.endswith(b"\n"):
                return
            yield RecordedRow(file, number, _values(file, number, line, header, known, kinds))


def _values(
    file: Path,
    number: int,
    line: bytes,
    header: Sequence[str],
    known: Mapping[str, Kind],
    kinds: Mapping[str, Kind],
) -> Mapping[str, Any]:
    """Return column → value of one line."""
    try:
        cells = dict(zip(header, split_line(line), strict=True))
    except ValueError as error:
        raise InputError(f"is no row: {error}; mend it first", file=file, line=number) from None
    values: dict[str, Any] = dict.fromkeys(kinds)
    try:
        values.update((name, cell_value(cells[name], name, known[name])) for name in known)
    except ValueError as error:
        column, message = error.args
        message = f"{message}; mend it first"
        raise InputError(message, file=file, line=number, column=column) from None
    return values


def kinds_of(row_type: type[Row]) -> Mapping[str, Kind]:
    """Return what the cells of each column are, as the row's type says."""
    if row_type is FrameRow:
        return _OF_FRAMES
    if row_type is GazeRow:
        return _OF_GAZE
    hints = get_type_hints(row_type)
    kinds = {}
    for field in fields(row_type):  # type: ignore[arg-type]
        of = [each for each in get_args(hints[field.name]) if each is not NoneType]
        kinds[field.name] = Kind(*((of[0], True) if of else (hints[field.name], False)))
    return kinds


def cell_value(cell: str, column: str, kind: Kind) -> Any:
    """Return a cell's value; raise `ValueError` with the column and what is wrong."""
    if kind.of is str:
        return cell
    if not cell.strip() and kind.may_be_blank:
        return None
    shown = repr(cell if len(cell) <= 40 else f"{cell[:40]}…")
    try:
        value = kind.of(plain_digits(cell))
    except ValueError:
        raise ValueError(column, f"{shown} is not a number") from None
    largest = LONGEST_S if kind.of is float and column != "value" else _LARGEST
    if abs(value) > largest or math.isnan(value):
        raise ValueError(column, f"{shown} is larger than anything recorded")
    if value < 0 and column not in _MAY_BE_NEGATIVE:
        raise ValueError(column, f"{shown} is less than 0")
    if column == "resumed" and value > 1:
        raise ValueError(column, f"{shown} is neither 0 nor 1")
    return value
