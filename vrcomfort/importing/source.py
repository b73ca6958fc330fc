"""A table as a lab's file has it: headings, text cells, and the row that each came from."""

from __future__ import annotations

import datetime
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from vrcomfort.csv_table import MOST_CELLS
from vrcomfort.errors import InputError

RECORDS = frozenset([".json", ".jsonl", ".ndjson"])
"""Endings of files of records."""
LONGEST_TEXT = 131_072
"""Characters of a cell: the limit of Python's CSV reader."""


class Reading(NamedTuple):
    """How a file is read, as `Read` of a mapping says; None (or blank) is detected, and noted.

    Parameters
    ----------
    heading_rows
        Rows that make up the heading, counted from 1 as spreadsheets do; none where columns have
        no names.
    skip_rows
        Rows that hold no data, such as the question texts below a heading.
    """

    encoding: str | None = None
    separator: str | None = None
    decimal: str | None = None
    heading_rows: tuple[int, ...] | None = None
    skip_rows: tuple[int, ...] = ()
    transpose: bool = False
    stack: bool = False
    sections: bool = False
    marked: bool = False
    spread: tuple[str, ...] = ()


def require_room(rows: int, width: int, file: Path, longest: str) -> None:
    """Raise `InputError` if rows padded to a width are more than `MOST_CELLS`; see `longest`."""
    if rows * width > MOST_CELLS:
        message = f"{longest}: with it, {rows:,} rows have {rows * width:,} cells, and may have"
        raise InputError(f"{message} {MOST_CELLS:,}; delete what is no data", file=file)


@dataclass(frozen=True)
class Grid:
    """Cells of one sheet before anything is known of them; `numbers` are their rows from 1.

    Parameters
    ----------
    reading
        How it was read, with everything that was found out.
    notes
        What was found out that the user should know, one sentence each.
    named
        Whether the first row holds names for certain, as in JSON.
    """

    file: Path
    sheet: str
    rows: tuple[tuple[str, ...], ...]
    numbers: tuple[int, ...]
    reading: Reading
    notes: tuple[str, ...] = ()
    named: bool = False


@dataclass(frozen=True)
class SourceTable:
    """A table with headings.

    Parameters
    ----------
    headings
        One different name for each column.
    labels
        What skipped rows above the data say of each column, such as the text of its question.
    rows, numbers
        Text cells, all as many as headings, without spaces around them; and their row numbers.
    reading
        How it was read.
    meanings
        For each column, text of a cell → what a codebook or the heading says it means.
    """

    file: Path
    sheet: str
    headings: tuple[str, ...]
    labels: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numbers: tuple[int, ...]
    reading: Reading
    notes: tuple[str, ...] = field(default=())
    meanings: tuple[Mapping[str, str], ...] = ()

    @property
    def name(self) -> str:
        """Return file and sheet, for people."""
        return f"{self.file.name}, sheet {self.sheet}" if self.sheet else self.file.name

    @property
    def nested(self) -> bool:
        """Return whether headings are paths in records: ``outer.inner``."""
        return self.file.suffix.lower() in RECORDS

    @property
    def decimal(self) -> str:
        """Return the decimal sign of its numbers."""
        return self.reading.decimal or "."

    def column(self, index: int) -> list[str]:
        """Return the cells of a column."""
        return [row[index] for row in self.rows]

    @cached_property
    def texts(self) -> tuple[tuple[str, ...], ...]:
        """Return the different texts of each column, in the order of the file, without blanks."""
        columns = map(self.column, range(len(self.headings)))
        return tuple(tuple(text for text in dict.fromkeys(cells) if text) for cells in columns)

    def meaning(self, index: int, text: str) -> str:
        """Return what a text of a column is said to mean, or the text itself."""
        return self.meanings[index].get(text, text) if self.meanings else text

    def fault(
        self, message: str, row: int | None = None, column: int | str | None = None
    ) -> InputError:
        """Return the error of a row (as numbered in the file), a column, or a cell."""
        heading = self.headings[column] if isinstance(column, int) else column
        place = [f"sheet {self.sheet}"] if self.sheet else []
        place += [f"row {row}"] if row is not None else []
        place += [f"column {heading!r}"] if heading is not None else []
        place_text = ", ".join([str(self.file), *place])
        return InputError(f"{place_text}: {message}")


def unique(headings: Sequence[str]) -> tuple[str, ...]:
    """Name columns that share a heading ``Nausea``, ``Nausea (2)`` …; blank ones by their place."""
    seen: dict[str, int] = {}
    found = []
    taken = set(headings)
    for place, heading in enumerate(headings, start=1):
        name = heading or f"column {place}"
        seen[name] = seen.get(name, 0) + 1
        if seen[name] > 1:
            other = f"{name} ({seen[name]})"
            while other in taken:
                seen[name] += 1
                other = f"{name} ({seen[name]})"
            name = other
            taken.add(name)
        found.append(name)
    return tuple(found)


def cell_text(value: Any) -> str:
    """Return a cell's value as a text file would have it."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    if isinstance(value, datetime.datetime | datetime.date | datetime.time):
        return value.isoformat()
    return one_line(str(value))


def one_line(text: str) -> str:
    """Return a text with single spaces between its words, and without marks of byte order."""
    return " ".join(text.replace("\ufeff", "").split())
