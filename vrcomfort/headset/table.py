"""Reads tables of numbers from text and says exactly where one is wrong."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from vrcomfort.errors import InputError
from vrcomfort.geometry import Array

Number = TypeVar("Number", int, float)


@dataclass(frozen=True)
class Table:
    """Text cells of a table, with the line of its file that each row stands on.

    Parameters
    ----------
    file
        Where the table was read.
    header
        Column names.
    rows
        One list of cells per row, all as long as the header.
    lines
        The 1-based line of each row.
    warnings
        What was left out, and why.
    """

    file: Path
    header: list[str]
    rows: list[list[str]]
    lines: list[int]
    warnings: tuple[str, ...] = ()

    def has(self, columns: Sequence[str]) -> bool:
        """Return whether all `columns` are there."""
        return set(columns) <= set(self.header)

    def text(self, column: str) -> list[str]:
        """Return the cells of one column."""
        index = self.header.index(column)
        return [row[index] for row in self.rows]

    def integers(self, column: str) -> NDArray[np.int64]:
        """Return (n,) int64 of one column; raise InputError at the first cell that is none."""
        return np.array(self._numbers(column, int64, "a whole number"), dtype=np.int64)

    def floats(self, columns: Sequence[str]) -> Array:
        """Return (n, columns) float64; raise InputError at the first cell that is not finite."""
        parsed = [self._numbers(column, float, "a finite number") for column in columns]
        table = np.array(parsed, dtype=np.float64).T
        bad = np.argwhere(~np.isfinite(table))
        if len(bad):
            row, column = bad[0]
            raise self.error(
                row, columns[column], self._not_a("a finite number", row, columns[column])
            )
        return table

    def quaternions(self, columns: Sequence[str]) -> Array:
        """Return (n, 4) unit quaternions as written; raise InputError if one is 0.1 % off."""
        table = self.floats(columns)
        norms = np.linalg.norm(table, axis=1)
        bad = np.flatnonzero(np.abs(norms - 1) > 1e-3)
        if len(bad):
            raise self.error(
                bad[0],
                columns[0],
                f"the quaternion {columns[0]} … {columns[-1]} has length {norms[bad[0]]:.6g}; "
                "a rotation needs length 1",
            )
        return table

    def rising(self, column: str, values: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return `values` of `column`; raise InputError where they do not rise."""
        for row, (before, after) in enumerate(pairwise(values.tolist()), start=1):
            if after <= before:
                how = "stands still" if after == before else f"goes back by {before - after} ns"
                raise self.error(row, column, f"time {how}; samples must be in order, each later")
        return values

    def error(self, row: int, column: str, message: str) -> InputError:
        """Return the error of one cell (`row` counts from 0)."""
        return InputError(message, file=self.file, line=self.lines[row], column=column)

    def _numbers(self, column: str, convert: Callable[[str], Number], kind: str) -> list[Number]:
        cells = self.text(column)
        try:
            return [convert(cell) for cell in cells]
        except ValueError:
            row = next(i for i, cell in enumerate(cells) if not _converts(cell, convert))
            raise self.error(row, column, self._not_a(kind, row, column)) from None

    def _not_a(self, kind: str, row: int, column: str) -> str:
        cell = self.rows[row][self.header.index(column)]
        if not cell.strip():
            return f"this cell is empty; it needs {kind}"
        return f"{cell.strip()!r} is not {kind}"


def int64(cell: str | int) -> int:
    """Return a whole number; raise ValueError if it is none or needs more than 64 bits."""
    number = int(cell)
    if not -(2**63) <= number < 2**63:
        raise ValueError(f"{number} needs more than 64 bits")
    return number


def _converts(cell: str, convert: Callable[[str], Number]) -> bool:
    try:
        convert(cell)
    except ValueError:
        return False
    return True


def read_table(
    path: str | Path,
    check_header: Callable[[Path, list[str]], None],
    *,
    space_separated_header: bool = False,
) -> Table:
    """Read a comma-separated table with a header row, which `check_header` may refuse.

    A last line that is not closed by a line end, or that has too few cells, was cut off while it
    was written: it is left out and reported in `Table.warnings`, never guessed.

    Raises
    ------
    InputError
        If the file is missing, is not text, holds no rows, or a row has the wrong width.
    """
    file = Path(path)
    text = _read_text(file)
    lines = text.splitlines()
    if not lines or not lines[0].strip():
        raise InputError("the file is empty; a trace starts with a header row", file=file, line=1)
    header = lines[0].split() if space_separated_header else next(csv.reader(lines[:1]))
    check_header(file, header)
    rows = [(number, row) for number, row in _rows(lines) if row]
    warnings: tuple[str, ...] = ()
    if rows and (not text.endswith(("\n", "\r")) or len(rows[-1][1]) < len(header)):
        number = rows.pop()[0]
        warnings = (f"{file}, line {number}: the last line is half-written and was left out",)
    _check_shape(file, header, rows)
    return Table(file, header, [row for _, row in rows], [n for n, _ in rows], warnings)


def _rows(lines: list[str]) -> list[tuple[int, list[str]]]:
    reader = csv.reader(lines)
    next(reader)
    return [(reader.line_num, row) for row in reader]


def _check_shape(file: Path, header: list[str], rows: list[tuple[int, list[str]]]) -> None:
    twice = {name for name in header if header.count(name) > 1}
    if twice:
        raise InputError(f"column {min(twice)!r} appears twice", file=file, line=1)
    if not rows:
        raise InputError("there is a header but no complete row", file=file, line=1)
    for number, row in rows:
        if len(row) != len(header):
            raise InputError(
                f"this row has {len(row)} cells and the header {len(header)}",
                file=file,
                line=number,
            )


def _read_text(file: Path) -> str:
    try:
        text = file.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError("there is no such file", file=file) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=file) from None
    except UnicodeDecodeError:
        raise InputError("this is not a text file; a trace is a CSV table", file=file) from None
    if "\0" in text:
        raise InputError("this is not a text file; a trace is a CSV table", file=file)
    return text
