"""What a row of a CSV file is, and how it is written."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import fields
from functools import cache
from typing import Any, ClassVar, Protocol, TypeAlias

from vrcomfort.escaping import escape_unprintable

LONGEST_CELL = 120_000
"""Characters; `csv` reads cells of up to 131,072."""

Cell: TypeAlias = str | int | float | None


class Row(Protocol):
    """A row that knows its file."""

    FILE: ClassVar[str]

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header; None is missing."""


@cache
def _names(row_type: Any) -> tuple[str, ...]:
    """Return the names of a dataclass's fields: they are asked for with every row."""
    return tuple(field.name for field in fields(row_type))


class FlatRow:
    """A row whose dataclass fields are its columns."""

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""
        return _names(cls)  # type: ignore[arg-type]

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header."""
        return [getattr(self, name) for name in self.columns()]


def cell_text(value: Cell) -> str:
    """Write a cell: blank for None and for numbers that are none, shortest exact text for floats.

    Line ends inside a text become spaces, so that a row is a line and a cut one is seen. Other
    unprintable characters are escaped, and texts are cut at `LONGEST_CELL`.
    """
    if isinstance(value, float):  # most are
        return repr(float(value)) if math.isfinite(value) else ""
    if value is None:
        return ""
    if not isinstance(value, str):
        return str(int(value))
    text = escape_unprintable(" ".join(value.splitlines()))
    return text if len(text) <= LONGEST_CELL else f"{text[:LONGEST_CELL]}…"


def csv_line(cells: Iterable[Cell]) -> str:
    """Return one CSV line with its line end; cells are written by `cell_text`."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(map(cell_text, cells))
    return line.getvalue()
