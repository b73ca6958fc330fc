"""Reads the columns of a head log, some rows at a time."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Literal, NamedTuple

from vrcomfort.csv_table import require_few_columns
from vrcomfort.errors import InputError
from vrcomfort.files import open_file
from vrcomfort.importing.files import is_number
from vrcomfort.importing.head_logs.mapping import LogRead
from vrcomfort.importing.source import unique
from vrcomfort.importing.text_files import (
    content_of,
    decimal_of,
    declared,
    encoding_of,
    separator_of,
)
from vrcomfort.settings import did_you_mean

SAMPLE_BYTES = 2**18
"""From the start of a log, by which it is understood."""
ROWS_AT_ONCE = 4096
_PARTS = ("x", "y", "z", "w")
Decimals = Literal[".", ","]
Row = tuple[int, list[str]]
"""Line, and cells."""


class LogSample(NamedTuple):
    """The first rows of a log, and how they are read.

    Parameters
    ----------
    headings
        One name for each cell; those of a cell ``(1, 2, 3)`` under ``Head`` are ``Head.x`` …
    rows
        Cells, all as many as headings, decimals with a point.
    read
        Every key is set.
    """

    file: Path
    headings: tuple[str, ...]
    rows: list[list[str]]
    read: LogRead


def sample_of(file: Path, read: LogRead) -> LogSample:
    """Read the first rows of a log, and find out what `read` leaves open.

    Raises
    ------
    InputError
        If the file cannot be read, or holds no table.
    """
    content = content_of(file, first=SAMPLE_BYTES)
    encoding = read.encoding or encoding_of(content)
    text = content.decode(encoding, errors="replace").removeprefix("\ufeff")
    separator, text = declared(text)
    separator = read.separator or separator or _separator(text)
    rows = [cells for _, cells in _rows(io.StringIO(text, newline=""), separator, file)]
    if not rows:
        raise InputError("this file has no row of a table", file=file)
    if len(content) == SAMPLE_BYTES and len(rows) > 1:
        rows.pop()  # it may be cut
    decimal: Decimals = read.decimal or ("," if decimal_of(rows, separator) == "," else ".")
    found = LogRead(
        encoding=encoding, separator=separator, decimal=decimal, heading_row=read.heading_row
    )
    heading_row = _heading_row(rows) if read.heading_row is None else read.heading_row
    found = found.model_copy(update={"heading_row": heading_row})
    headings = headings_of(rows, heading_row, file)
    body = [_flat(cells, decimal) for cells in rows[heading_row:]]
    return LogSample(file, headings, [c for c in body if len(c) == len(headings)], found)


def _separator(text: str) -> str:
    """Return the separator of a log; spaces where no other sign divides its rows."""
    found = separator_of(text)
    rows = text.splitlines()[1:50]
    divided = sum(found in row for row in rows) * 2 > len(rows)
    return found if divided or not all(" " in row.strip() for row in rows) else " "


def _rows(lines: Iterator[str] | io.TextIOBase, separator: str, file: Path) -> Iterator[Row]:
    """Yield line and trimmed cells of the rows that hold anything."""
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=separator == " ")
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells) and not (reader.line_num == 1 and row[0].startswith("sep=")):
                while len(cells) > 1 and not cells[-1]:
                    cells.pop()  # a separator ends the line
                require_few_columns(len(cells), file, "this row")
                yield reader.line_num, cells
    except csv.Error as error:
        raise InputError(f"not a table: {error}", file=file, line=reader.line_num) from None
    except UnicodeDecodeError:
        message = "the line after this one is not in the encoding of the first ones; give another"
        raise InputError(message, file=file, line=reader.line_num) from None


def _heading_row(rows: Sequence[Sequence[str]]) -> int:
    """Return the row of the headings: the last one before the numbers; 0 if there is none."""
    for place, cells in enumerate(rows[:40]):
        if sum(map(_is_numeric, cells)) * 2 > len(cells) > 1:
            return place
    return 1 if len(rows) > 1 else 0


def _is_numeric(cell: str) -> bool:
    return (
        is_number(cell.strip("()")) or re.fullmatch(r"[-+]?\d[\d.,]*[eE][-+]?\d+", cell) is not None
    )


def headings_of(rows: Sequence[Sequence[str]], heading_row: int, file: Path) -> tuple[str, ...]:
    """Return a name for each cell of the rows below the headings.

    Raises
    ------
    InputError
        If there are no rows below.
    """
    below = rows[heading_row:]
    if not below:
        raise InputError("there is a header but no row of a sample below it", file=file)
    groups = _grouped(below[0])
    names = list(rows[heading_row - 1]) if heading_row else []
    if len(names) == 1 and len(names[0].split()) == len(groups):
        names = names[0].split()  # spaces between the names, another sign between the numbers
    names += [""] * (len(groups) - len(names))
    flat = []
    for name, cells in zip(unique(names[: len(groups)]), groups, strict=True):
        parts = _PARTS if len(cells) > 1 else ("",)
        flat += [f"{name}.{part}" if part else name for part, _ in zip(parts, cells, strict=False)]
    more = [name for name in names[len(groups) :] if name]
    return unique([*flat, *more])


def _grouped(cells: Sequence[str]) -> list[list[str]]:
    """Group the cells of vectors such as ``(0.1, 1.6, 0.2)``, in one cell or in several."""
    groups: list[list[str]] = []
    inside = False
    for cell in cells:
        if not inside and cell.startswith("("):
            whole = cell.endswith(")")
            parts = cell.strip("()").replace(";", ",").split(",") if whole else [cell.strip("(")]
            groups.append([part.strip() for part in parts])
            inside = not whole
        elif inside:
            groups[-1].append(cell.strip(") "))
            inside = not cell.endswith(")")
        else:
            groups.append([cell])
    return groups


def _flat(cells: Sequence[str], decimal: str | None) -> list[str]:
    """Return the cells with vectors taken apart, and decimals with a point."""
    if any("(" in cell for cell in cells):
        cells = [part for group in _grouped(cells) for part in group]
    if decimal == ",":
        return [cell.replace(",", ".") for cell in cells]
    return [*cells]


class LogPart(NamedTuple):
    """Some rows of a log.

    Parameters
    ----------
    lines
        The line of each row in the file.
    cells
        Column → its cells.
    """

    lines: list[int]
    cells: dict[str, list[str]]


def parts_of(file: Path, read: LogRead, names: Sequence[str]) -> Iterator[LogPart]:
    """Yield the named columns of a log, some rows at a time.

    A last row that is shorter than the others was cut off while it was written; it is left out.

    Raises
    ------
    InputError
        If a column is not there, or a row has another number of cells; with the line.
    """
    sample = sample_of(file, read)
    places = {name: _place(name, sample) for name in names}
    width = len(sample.headings)
    with open_file(file) as stream:
        text = io.TextIOWrapper(stream, encoding=sample.read.encoding, newline="")
        rows = _rows(text, sample.read.separator or ",", file)
        for _ in range(sample.read.heading_row or 0):
            next(rows, None)
        whole = _whole_rows(rows, width, sample.read.decimal, file)
        while part := list(islice(whole, ROWS_AT_ONCE)):
            lines = [line for line, _ in part]
            yield LogPart(lines, {n: [cells[i] for _, cells in part] for n, i in places.items()})


def _place(name: str, sample: LogSample) -> int:
    if name not in sample.headings:
        hint = did_you_mean(name, sample.headings)
        message = f"the mapping names a column {name!r} that is not there; {hint}"
        raise InputError(message, file=sample.file, line=sample.read.heading_row or 1)
    return sample.headings.index(name)


def _whole_rows(rows: Iterator[Row], width: int, decimal: str | None, file: Path) -> Iterator[Row]:
    short: tuple[int, int] | None = None
    for line, row in rows:
        if short is not None:
            message = f"this row has {short[1]} cells, the others have {width}; mend or remove it"
            raise InputError(message, file=file, line=short[0])
        cells = _flat(row, decimal)
        if len(cells) > width:
            message = f"this row has {len(cells)} cells, the others have {width}; mend or remove it"
            raise InputError(message, file=file, line=line)
        if len(cells) < width and len(cells) * 2 < width:
            short = line, len(cells)
            continue
        yield line, [*cells, *[""] * (width - len(cells))]
