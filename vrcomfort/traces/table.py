"""Turns tables of text into numbers, and says exactly where one is wrong."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from vrcomfort.csv_table import CsvTable, plain_digits
from vrcomfort.errors import InputError
from vrcomfort.geometry import FARTHEST_M, Array

Number = TypeVar("Number", int, float)


@dataclass(frozen=True)
class Table(CsvTable):
    """A table of numbers."""

    def has(self, columns: Sequence[str]) -> bool:
        """Return whether all `columns` are there."""
        return set(columns) <= set(self.header)

    def text(self, column: str) -> list[str]:
        """Return the cells of one column."""
        index = self.header.index(column)
        return [row[index] for row in self.rows]

    def integers(self, column: str) -> NDArray[np.int64]:
        """Return (n,) int64 of one column; raise InputError at the first cell that is none."""
        return np.array(self._numbers(column, _whole, "a whole number"), dtype=np.int64)

    def floats(self, columns: Sequence[str]) -> Array:
        """Return (n, columns) float64; raise InputError at the first cell that is not finite."""
        parsed = [self._numbers(column, _real, "a finite number") for column in columns]
        table = np.array(parsed, dtype=np.float64).T
        bad = np.argwhere(~np.isfinite(table))
        if len(bad):
            row, column = bad[0]
            raise self.error(
                row, columns[column], self._not_a("a finite number", row, columns[column])
            )
        return table

    def positions(self, columns: Sequence[str]) -> Array:
        """Return (n, columns) metres; raise InputError at the first that is nowhere near a scene.

        That is the limit of poses on the command line.
        """
        table = self.floats(columns)
        far = np.argwhere(np.abs(table) > FARTHEST_M)
        if len(far):
            row, column = far[0]
            message = f"{table[row, column]:g} m is more than {FARTHEST_M / 1e3:.0f} km away"
            raise self.error(row, columns[column], f"{message}; positions are metres")
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

    def rising(
        self, column: str, values: NDArray[np.int64], *, after: int | None = None
    ) -> NDArray[np.int64]:
        """Return `values` of `column`; raise InputError where they do not rise.

        Parameters
        ----------
        after
            The value in the row before this table's first.
        """
        start = [] if after is None else [after]
        numbers = [*start, *values.tolist()]
        for row, (before, now) in enumerate(pairwise(numbers), start=1 - len(start)):
            if now <= before:
                how = "stands still" if now == before else f"goes back by {before - now} ns"
                raise self.error(row, column, f"time {how}; samples must be in order, each later")
        return values

    def error(self, row: int, column: str, message: str) -> InputError:
        """Return the error of one cell (`row` counts from 0)."""
        return self.fault(message, self.lines[row], column)

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


def _real(cell: str) -> float:
    return float(plain_digits(cell))


def _whole(cell: str) -> int:
    return int64(int(plain_digits(cell)))


def int64(number: int) -> int:
    """Return a whole number; raise ValueError if it needs more than 64 bits."""
    if not -(2**63) <= number < 2**63:
        raise ValueError(f"{number} needs more than 64 bits")
    return number


def _converts(cell: str, convert: Callable[[str], Number]) -> bool:
    try:
        convert(cell)
    except ValueError:
        return False
    return True


ROWS_AT_ONCE = 4096
"""Text takes many times the memory of the numbers in it."""


def read_parts(path: str | Path, check_header: Callable[[Table], None]) -> Iterator[Table]:
    """Yield a table some rows at a time; `check_header` may refuse its header.

    No part is empty but the last, which tells what was left out.

    Raises
    ------
    InputError
        As `CsvTable.read`, or if there is no row.
    """
    parts = Table.parts(path, appended=True, most_rows=ROWS_AT_ONCE)
    for number, table in enumerate(parts):
        if number == 0:
            if not table.header:
                message = "the file is empty; a trace starts with a header row"
                raise InputError(message, file=table.file, line=1)
            check_header(table)
            if not table.rows:
                raise table.fault("there is a header but no complete row", 1)
        yield table
