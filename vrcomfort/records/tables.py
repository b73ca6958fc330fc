"""Opens the tables of a study: as text, or as values of the columns that the schema declares.

Every module that reads a CSV file of a study reads it through `read_table` (text, whole),
`text_rows` (text, row by row) or `read_rows` (values, row by row), mostly by way of
`vrcomfort.records.reader`. Each says exactly where a file is wrong.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import LARGEST_WHOLE, CsvTable, are_numbers, plain_digits, shortened
from vrcomfort.errors import InputError
from vrcomfort.files import open_file
from vrcomfort.plurals import counted
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.json_file import LONGEST_S
from vrcomfort.records.rows import Column, Row, declared, single
from vrcomfort.records.schema import SCHEMA_VERSION, columns_of_version
from vrcomfort.seen_time import FRAME_COLUMNS

_HALF = "this row is half-written; `vrcomfort run … --resume` moves it aside, or remove the line"
# Rows of frames have 77 cells: a part of 4096 takes about 20 MB as text, a whole file may take GBs.
_ROWS_AT_ONCE = 4096


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


class _RowError(ValueError):
    """A fault of a line, or of one of its cells."""

    def __init__(self, message: str, column: str | None = None) -> None:
        super().__init__(message)
        self.column = column

    def at(self, file: Path, line: int, remedy: str) -> InputError:
        """Return the error with its place."""
        return InputError(f"{self}; {remedy}", file=file, line=line, column=self.column)


def read_table(file: Path, *, appended: bool = True) -> CsvTable:
    """Read a table of a study as text.

    Parameters
    ----------
    appended
        The recorder adds row by row to it: a half-written last row is left out, with a warning.
        Else it was written as a whole, or by hand, and its last line may have no end.

    Raises
    ------
    InputError
        If the file cannot be read, is no table, or a row is of another width.
    """
    return CsvTable.read(file, appended=appended)


def read_header(file: Path) -> tuple[str, ...]:
    """Return the columns of a table of any length.

    Raises
    ------
    InputError
        If the file cannot be read or is no table.
    """
    return next(CsvTable.parts(file, appended=True, most_rows=1)).header


def text_rows(file: Path) -> Iterator[dict[str, str]]:
    """Yield the rows of a table of any length as text, but for a half-written last one.

    Raises
    ------
    InputError
        As `read_table`, when the row that is wrong is reached.
    """
    for part in CsvTable.parts(file, appended=True, most_rows=_ROWS_AT_ONCE):
        yield from part.dicts()


def read_rows(
    folder: Path,
    row_type: type[Row],
    *,
    version: int = SCHEMA_VERSION,
    cut: bool = False,
    until_bytes: float = math.inf,
    told: Callable[[InputError], None] | None = None,
) -> Iterator[RecordedRow]:
    """Yield the rows of a session's table as values.

    Parameters
    ----------
    version
        Of the schema that it was written in; columns that came later are None.
    cut
        The last row may be half-written, by a program that was killed; it is left out then. Else
        the file has been repaired.
    until_bytes
        Where the rows end that are read: the session is going on.
    told
        Is called with every fault, and the other rows are yielded; the columns have to be those of
        the version then, in their order. Without it the first fault is raised, and columns that
        are not declared are passed over.

    Raises
    ------
    InputError
        If a line is no row, a column is missing, or a cell is not what its column holds.
    """
    file, columns = folder / row_type.FILE, columns_read(row_type)
    with open_file(file) as stream:
        first = stream.readline()
        if told is None:
            header = _header(file, first, row_type, version)
        else:
            try:
                header = _header_of_version(file, first, row_type, version)
            except InputError as error:
                told(error)
                return
        known = {name: columns[name] for name in columns if name in header}
        blank = {name: None for name in columns if name not in header}
        numbers = () if told is None else _further_numbers(header, row_type)
        at_bytes = len(first)
        for number, line in enumerate(stream, start=2):
            at_bytes += len(line)
            if at_bytes > until_bytes:
                return
            if not line.endswith(b"\n") and cut:
                return
            if not line.endswith(b"\n") and told is not None:
                told(InputError(_HALF, file=file, line=number))
                return
            try:
                cells = _cells(line, header)
                values = {name: cell_value(cells[name], of) for name, of in known.items()}
            except _RowError as fault:
                if told is None:
                    raise fault.at(file, number, "mend it first") from None
                told(fault.at(file, number, _RESTORE))
                continue
            if told is not None and (wrong := _not_a_number(cells, numbers)):
                told(wrong.at(file, number, _RESTORE))
            yield RecordedRow(file, number, {**blank, **values} if blank else values)


_RESTORE = "restore the file from a copy"


def _header(file: Path, line: bytes, row_type: type[Row], version: int) -> tuple[str, ...]:
    """Return the columns of a file, which has all that its version declares."""
    there = columns_of_version(version, row_type.FILE, row_type.columns())
    try:
        header = tuple(split_line(line))
    except ValueError as error:
        raise _RowError(f"is no row: {error}").at(file, 1, "mend it first") from None
    if missing := [name for name in columns_read(row_type) if name in there and name not in header]:
        message = f"the column is missing; it has: {', '.join(header)}"
        raise InputError(message, file=file, line=1, column=missing[0])
    return header


def _header_of_version(
    file: Path, line: bytes, row_type: type[Row], version: int
) -> tuple[str, ...]:
    """Return the columns of a file, which are those of its version."""
    try:
        there = tuple(split_line(line))
    except ValueError:  # also text that is no UTF-8
        there = ()
    columns = row_type.columns()
    wanted = columns_of_version(version, row_type.FILE, columns)
    if version < SCHEMA_VERSION and there == columns:
        wanted = columns  # a continuation has begun, and was killed before it wrote the manifest
    if not line.endswith(b"\n"):
        message = "the header is half-written or missing; restore it from a copy"
        raise InputError(message, file=file, line=1)
    if there != wanted:
        lacking = [name for name in wanted if name not in there]
        others = [name for name in there if name not in wanted]
        what = f"lacks {', '.join(lacking)}" if lacking else f"has {', '.join(others)} besides"
        what = what if lacking or others else "has its columns in another order"
        message = f"the header {what}, and schema version {version} wants the columns in "
        raise InputError(
            f"{message}`vrcomfort docs data_dictionary`; {_RESTORE}", file=file, line=1
        )
    return there


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


def _cells(line: bytes, header: Sequence[str]) -> dict[str, str]:
    """Return column → cell of a line."""
    try:
        row = split_line(line)
    except ValueError as error:  # also text that is no UTF-8
        raise _RowError(f"is no row: {error}") from None
    if len(row) != len(header):
        raise _RowError(f"is no row: {counted(len(row), 'cells')} under {len(header)} columns")
    return dict(zip(header, row, strict=True))


def columns_read(row_type: type[Row]) -> Mapping[str, Column]:
    """Return the columns that are read as values: of frames and gaze the fewest.

    These files are large: `vrcomfort.records.recording` reads their other columns.
    """
    if row_type in (FrameRow, GazeRow):
        return {
            each.name: each
            for each in single(row_type)
            if each.name in FRAME_COLUMNS or not (each.blank or each.needs)
        }
    return {each.name: each for each in declared(row_type)}


def cell_value(cell: str, column: Column) -> Any:
    """Return a cell's value; raise a `ValueError` that names the fault."""
    if column.type is str:
        return cell
    if not cell.strip() and column.blank:
        return None
    try:
        value = (int if column.type is int else float)(plain_digits(cell))
    except ValueError:
        raise _RowError(f"{shortened(cell)} is not a number", column.name) from None
    # A time is bounded more tightly than a count: sums of times have to stay finite.
    largest = LONGEST_S if column.type is float and column.unit else LARGEST_WHOLE
    if abs(value) > largest or math.isnan(value):
        raise _RowError(f"{shortened(cell)} is larger than anything recorded", column.name)
    if value < 0 and not column.signed:
        raise _RowError(f"{shortened(cell)} is less than 0", column.name)
    if column.name == "resumed" and value > 1:
        raise _RowError(f"{shortened(cell)} is neither 0 nor 1", column.name)
    return value


def _further_numbers(header: Sequence[str], row_type: type[Row]) -> tuple[str, ...]:
    """Return the columns of frames and gaze that hold numbers or nothing."""
    if row_type not in (FrameRow, GazeRow):
        return ()
    numbers = {each.name for each in declared(row_type) if each.type is not str}
    return tuple(name for name in header if name in numbers)


def _not_a_number(cells: Mapping[str, str], names: Sequence[str]) -> _RowError | None:
    """Return the fault of the first cell that is neither a number nor blank."""
    if are_numbers([cells[name] for name in names]):
        return None
    for name in names:
        if cells[name]:
            try:
                float(plain_digits(cells[name]))
            except ValueError:
                return _RowError(f"{shortened(cells[name])} is not a number", name)
    return None
