"""Reads a file of any kind into tables, and tells their headings from data."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from vrcomfort.csv_table import whole_or_none
from vrcomfort.errors import InputError
from vrcomfort.importing.source import RECORDS, Grid, Reading, SourceTable, require_room, unique
from vrcomfort.importing.text_files import read_json_table, read_text_table
from vrcomfort.importing.workbooks import read_workbook

JOIN = " / "
"""Between the rows of a heading that has several."""

_IMPORT_ID = re.compile(r"\{\s*['\"]ImportId['\"]")
_NUMBER = re.compile(r"[-+]?\d+([.,]\d+)?( ?%)?")
_UNREAD = {
    ".xls": "Excel's former format; save it as .xlsx",
    ".xlsb": "a binary workbook; save it as .xlsx",
    ".ods": "an OpenDocument table; save it as .xlsx or CSV",
    ".sav": "an SPSS file; export it as CSV with value labels or codes",
    ".dta": "a Stata file; export it as CSV",
    ".rds": "an R object; write it with write.csv",
    ".rdata": "R objects; write them with write.csv",
    ".parquet": "a Parquet file; write it as CSV",
    ".zip": "an archive; unpack it first",
    ".pdf": "a PDF; export the answers as CSV",
    ".html": "a web page; export the answers as CSV",
}


def read_grids(file: Path, reading: Reading) -> list[Grid]:
    """Read a file without telling headings from data: one grid, or one for each sheet.

    Raises
    ------
    InputError
        If the file cannot be read, or is of a kind that is not.
    """
    ending = file.suffix.lower()
    if ending in _UNREAD:
        raise InputError(f"this is {_UNREAD[ending]}", file=file)
    if ending in {".xlsx", ".xlsm"}:
        return read_workbook(file, reading)
    if ending in RECORDS:
        return [read_json_table(file, reading)]
    return [read_text_table(file, reading)]


def read_tables(file: Path, reading: Reading | None = None) -> list[SourceTable]:
    """Read the tables of a file.

    Raises
    ------
    InputError
        If the file, or a table of it, cannot be read; with the row.
    """
    return [as_table(grid) for grid in read_grids(file, reading or Reading())]


def as_table(grid: Grid) -> SourceTable:
    """Tell headings from data, as the reading says or else by the look of the rows.

    Raises
    ------
    InputError
        If a row that is to be a heading is not there, a data row is wider than the headings, or
        nothing is below the headings.
    """
    if not grid.rows:
        raise _fault(grid, "there is no row with anything in it")
    _width(grid)
    if grid.reading.transpose:
        grid = transposed(grid)
    found = _detected(grid) if grid.reading.heading_rows is None else grid.reading
    heading_rows = found.heading_rows or ()
    by_number = dict(zip(grid.numbers, grid.rows, strict=True))
    for number in heading_rows:
        if number not in by_number:
            raise _fault(grid, f"row {number} is to be a heading, and is blank or not there")
    skipped = {*heading_rows, *found.skip_rows}
    last_heading = max(heading_rows, default=-1)
    data: list[tuple[int, Sequence[str]]] = [
        (n, row) for n, row in by_number.items() if n not in skipped and n > last_heading
    ]
    if not data:
        raise _fault(grid, "there is no row of data below the headings")
    headings = _joined([by_number[number] for number in heading_rows])
    if grid.reading.stack:
        headings, data = _stacked(headings, data, grid)
    width = len(headings)
    if grid.sheet or not width:  # cells of a workbook stand where they are; a separator may stray
        width = max(width, *(len(row) for _, row in data))
    headings = [*headings, *[""] * (width - len(headings))]
    if grid.reading.marked:
        headings, data = _marked(headings, data)
    for name in grid.reading.spread:
        headings, data = _spread(headings, data, name, grid)
    width = max(width, len(headings))
    used = max(
        [i + 1 for _, row in data for i, cell in enumerate(row) if cell]
        + [i + 1 for i, heading in enumerate(headings) if heading],
    )
    if used > width:
        number = next(n for n, row in data if any(row[width:]))
        message = "this row has cells beyond the last heading; texts with a separator need quotes"
        raise _fault(grid, f"row {number}: {message}")
    return SourceTable(
        grid.file,
        grid.sheet,
        unique(headings[:used]),
        tuple(_labels(grid, found, used)),
        tuple((*row[:used], *[""] * (used - len(row))) for _, row in data),
        tuple(number for number, _ in data),
        found,
        grid.notes,
    )


def repeated_runs(headings: Sequence[str]) -> list[int]:
    """Return where runs of the same headings begin, side by side; one place where none repeats."""
    first = headings[0] if headings else ""
    starts = [place for place, heading in enumerate(headings) if first and heading == first]
    if not starts:
        return [0]
    ends = [*starts[1:], len(headings)]
    runs = [[*headings[a:b]] for a, b in zip(starts, ends, strict=True)]
    for run in runs:
        while run and not run[-1]:
            run.pop()
    same = len(runs) > 1 and all(run == runs[0] for run in runs) and len(runs[0]) > 1
    return starts if same else [0]


def _stacked(
    headings: Sequence[str], data: Sequence[tuple[int, Sequence[str]]], grid: Grid
) -> tuple[list[str], list[tuple[int, Sequence[str]]]]:
    """Put what stands below each run of the same headings below what is left of it.

    The only word in the first column of a run names its other rows as well.
    """
    starts = repeated_runs(headings)
    if len(starts) < 2:
        raise _fault(grid, "`stack` is for headings that repeat in the row, and these do not")
    width = starts[1]
    rows: list[tuple[int, Sequence[str]]] = []
    for start in starts:
        run = [(n, row[start : start + width]) for n, row in data]
        run = [(n, row) for n, row in run if any(row)]
        names = {row[0] for _, row in run} - {""}
        rows += [(n, (*names, *row[1:])) for n, row in run] if len(names) == 1 else run
    return [*headings[:width]], rows


_MARKS = frozenset(["x", "✓", "✔", "✗", "•", "*"])
_FEWEST_MARKED = 3
"""Columns of which a row marks one."""


def marked_runs(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> list[range]:
    """Return runs of columns of which each row marks one, and no more, with nothing else there."""
    cells = [{row[c].casefold() for row in rows if c < len(row)} for c in range(len(headings))]
    marks = [len(each - {""}) < 2 and each - {""} <= _MARKS for each in cells]
    outer = [heading.rpartition(JOIN)[0] for heading in headings]
    found: list[range] = []
    start = 0
    for end in range(1, len(headings) + 1):
        if end < len(headings) and marks[end] and marks[start] and outer[end] == outer[start]:
            continue
        count = [sum(bool(cell) for cell in row[start:end]) for row in rows]
        if end - start >= _FEWEST_MARKED and marks[start] and {1} <= {*count} <= {0, 1}:
            found.append(range(start, end))
        start = end
    return found


def _marked(
    headings: Sequence[str], data: Sequence[tuple[int, Sequence[str]]]
) -> tuple[list[str], list[tuple[int, Sequence[str]]]]:
    """Put the heading of the marked column of each run into one column in its place."""
    runs = {run.start: run for run in marked_runs(headings, [row for _, row in data])}
    inside = {c for run in runs.values() for c in run}
    kept = [c for c in range(len(headings)) if c in runs or c not in inside]

    def cell(row: Sequence[str], column: int) -> str:
        if column not in runs:
            return row[column] if column < len(row) else ""
        marked = (c for c in runs[column] if c < len(row) and row[c])
        return next((headings[c].rpartition(JOIN)[2] for c in marked), "")

    names = [
        headings[c].rpartition(JOIN)[0] or "answer" if c in runs else headings[c] for c in kept
    ]
    return names, [(n, [cell(row, c) for c in kept]) for n, row in data]


_NUMBER_OF_LIST = r"-?\d{1,3}(?:\.\d+)?"
_LIST = re.compile(rf"[\[(]?{_NUMBER_OF_LIST}(?:[\s,;|]+{_NUMBER_OF_LIST}){{3,}}[\])]?")


def numbers_in(cell: str) -> list[str]:
    """Return the numbers of a cell that holds a list of them: ``1 2 1 3``, ``[0, 2, 1, 1]``."""
    return re.findall(_NUMBER_OF_LIST, cell) if _LIST.fullmatch(cell) else []


def _spread(
    headings: Sequence[str], data: Sequence[tuple[int, Sequence[str]]], name: str, grid: Grid
) -> tuple[list[str], list[tuple[int, Sequence[str]]]]:
    """Put each number of a column's cells into a column of its own."""
    if name not in headings:
        raise _fault(grid, f"there is no column {name!r}, which is to be spread")
    place = headings.index(name)
    lists = [numbers_in(row[place]) if place < len(row) else [] for _, row in data]
    count = max(map(len, lists))
    if not count:
        raise _fault(grid, f"no cell of {name!r} is a list of numbers, and it cannot be spread")
    rows: list[tuple[int, Sequence[str]]] = []
    for (number, row), found in zip(data, lists, strict=True):
        if len(row) > place and row[place] and len(found) != count:
            message = f"{row[place]!r} in {name!r} must be a list of {count} numbers"
            raise _fault(grid, f"row {number}: {message}")
        cells = found or [""] * count
        rows.append(
            (number, [*row[:place], *cells, *row[place + 1 :]] if len(row) > place else row)
        )
    names = [f"{name}_{n}" for n in range(1, count + 1)]
    return [*headings[:place], *names, *headings[place + 1 :]], rows


def transposed(grid: Grid) -> Grid:
    """Return the columns of a grid as rows, numbered from 1; blank ones are left out."""
    width = _width(grid)
    filled = [(*row, *[""] * (width - len(row))) for row in under_titles(grid.rows)]
    kept = [(n, row) for n, row in enumerate(zip(*filled, strict=True), start=1) if any(row)]
    rows, numbers = tuple(row for _, row in kept), tuple(number for number, _ in kept)
    return replace(grid, rows=rows, numbers=numbers, named=False)


def under_titles(rows: Sequence[Sequence[str]]) -> Sequence[Sequence[str]]:
    """Put titles, which are alone in their rows, before the names of the rows below them.

    Rows stay as they are where each has a name of its own. A title of the whole is left out.
    """
    names = [row[0] for row in rows if any(row[1:])]
    if len({*names}) == len(names):
        return rows
    title, found = "", list[Sequence[str]]()
    for row in rows:
        if any(row[1:]):
            found.append((f"{title}{JOIN}{row[0]}" if title else row[0], *row[1:]))
        elif found:
            title = row[0]
    return found


def _width(grid: Grid) -> int:
    """Return the length of the longest row.

    Raises
    ------
    InputError
        If padding all rows to it would take more than `MOST_CELLS`.
    """
    number, row = max(zip(grid.numbers, grid.rows, strict=True), key=lambda each: len(each[1]))
    sheet = f"sheet {grid.sheet}, " if grid.sheet else ""
    require_room(len(grid.rows), len(row), grid.file, f"{sheet}row {number} is the longest")
    return len(row)


def _fault(grid: Grid, message: str) -> InputError:
    sheet = f"sheet {grid.sheet}: " if grid.sheet else ""
    return InputError(f"{sheet}{message}", file=grid.file)


def _joined(rows: Sequence[Sequence[str]]) -> list[str]:
    """Join the rows of a heading; in all but the last, a text holds until the next one."""
    if len(rows) < 2:
        return [*rows[0]] if rows else []
    width = max(map(len, rows))
    filled = []
    for row in rows[:-1]:
        text, out = "", []
        for cell in [*row, *[""] * (width - len(row))]:
            text = cell or text
            out.append(text)
        filled.append(out)
    last = [*rows[-1], *[""] * (width - len(rows[-1]))]
    return [
        JOIN.join(dict.fromkeys(part for part in (*above, below) if part))
        for *above, below in zip(*filled, last, strict=True)
    ]


def _labels(grid: Grid, reading: Reading, width: int) -> list[str]:
    """Return the texts of skipped rows below the heading by column, without Qualtrics' ids."""
    first = max(reading.heading_rows or (), default=0)
    data = min((n for n in grid.numbers if n > first and n not in reading.skip_rows), default=0)
    rows = [
        row
        for number, row in zip(grid.numbers, grid.rows, strict=True)
        if number in reading.skip_rows and first < number < data and not _is_import_ids(row)
    ]
    columns = [[row[i] for row in rows if i < len(row) and row[i]] for i in range(width)]
    return [" ".join(texts) for texts in columns]


def _detected(grid: Grid) -> Reading:
    """Return which rows are headings: none, or one, below up to two that span several columns.

    Titles above and labels below are skipped.
    """
    rows, numbers = grid.rows, grid.numbers
    reading = grid.reading
    if grid.named:
        return reading._replace(heading_rows=(numbers[0],))
    ids = next((i for i, row in enumerate(rows[:4]) if _is_import_ids(row)), None)
    if ids is not None:  # Qualtrics: names, question texts, import ids, in any order
        above = [number for n, number in enumerate(numbers[: ids + 1]) if n != ids]
        name = (above or numbers[1:2])[0]
        skipped = tuple(n for n in numbers[: max(ids, numbers.index(name)) + 1] if n != name)
        return reading._replace(heading_rows=(name,), skip_rows=skipped)
    first = _first_of_the_table(rows)
    titles = tuple(numbers[:first])
    rest = rows[first:]
    upper = _upper_headings(rest)
    aside = reading.transpose and bool(rest[0][0]) and not is_number(rest[0][0])
    if not upper and not aside and not is_heading(rest):  # times in front, once on their side
        return reading._replace(heading_rows=(), skip_rows=titles)
    last = first + upper + 1
    below = tuple(numbers[last : last + 1]) if _labels_below(rest[upper:]) else ()
    return reading._replace(heading_rows=tuple(numbers[first:last]), skip_rows=(*titles, *below))


def _labels_below(rows: Sequence[Sequence[str]]) -> bool:
    """Return whether the second row says the headings in other words, or what answers mean.

    Survey programs write codes and question texts, one below the other. Such a row differs from
    the data below it as headings do: in nearly all columns whose cells are numbers, or recur.
    """
    if len(rows) < _FEWEST_BELOW:
        return False
    told: list[bool] = []
    for column, label in enumerate(rows[1]):
        below = [row[column] for row in rows[2:60] if column < len(row) and row[column]]
        if not label or not below:
            continue
        if sum(map(is_number, below)) * 2 > len(below):
            told.append(not is_number(label) and any(map(str.isalpha, label)))
        elif len({*below}) * 2 <= len(below):
            told.append(label not in below)
    heading = [cell for cell in rows[0] if cell]
    several = len(told) >= 3 and _filled(rows[1]) * 2 > len(heading)
    return several and sum(told) * 10 >= len(told) * 9


_FEWEST_BELOW = 5
"""Rows with headings and labels that tell labels from a first row of data."""


def _is_import_ids(row: Sequence[str]) -> bool:
    return sum(_IMPORT_ID.match(cell) is not None for cell in row) * 2 > sum(map(bool, row))


def _first_of_the_table(rows: Sequence[Sequence[str]]) -> int:
    """Return where the table begins below lines of title: they fill few of its columns."""
    # At most 20 rows of titles and notes stand above; the next 30 tell the table's width.
    width = max(_filled(row) for row in rows[:50])
    for index, row in enumerate(rows[:20]):
        if _is_title(rows[index:]) and width > 2:
            continue
        if _filled(row) * 2 > width or (width <= 2 and _filled(row) == width):
            return index
        below = rows[index + 1 : index + 2]
        if below and _filled(row) > 1 and _upper_headings(rows[index:]):
            return index
    return 0


def _is_title(rows: Sequence[Sequence[str]]) -> bool:
    """Return whether the first row is one text, perhaps merged over cells, and nowhere below."""
    first, *below = rows
    texts = {cell for cell in first if cell}
    return bool(first[0]) and len(texts) == 1 and not any(first[0] in row for row in below)


def _filled(row: Sequence[str]) -> int:
    return sum(map(bool, row))


def is_number(cell: str) -> bool:
    """Return whether a cell looks like a number, with a point or a comma."""
    return _NUMBER.fullmatch(cell) is not None


def is_heading(rows: Sequence[Sequence[str]]) -> bool:
    """Return whether the first row names columns: it differs from the rows below it."""
    first, below = rows[0], rows[1:60]
    if not below:  # alone, a row with numbers is one of data
        return not any(map(is_number, first))
    count = [number for number in map(whole_or_none, first) if number is not None and number >= 0]
    if len(count) >= 3 and all(b - a == 1 for a, b in pairwise(count)):
        return True  # the numbers of items
    numeric_below = [
        index
        for index in range(len(first))
        if (cells := [row[index] for row in below if index < len(row) and row[index]])
        and sum(map(is_number, cells)) * 2 > len(cells)
    ]
    if any(first[index] for index in numeric_below):  # row numbers alone may have no heading
        named = [i for i in numeric_below if first[i] and not is_number(first[i])]
        some = len(named) >= _FEWEST_NAMED and not any(map(is_number, first))
        return some or len(named) * 2 >= len(numeric_below)
    # All are words: a row of data has words that stand in its column again.
    again = [
        index
        for index, cell in enumerate(first)
        if cell and any(index < len(row) and row[index] == cell for row in below)
    ]
    return len(again) * 2 < _filled(first)


_FEWEST_NAMED = 3
"""Columns of numbers that words stand above, where others have no heading."""


def _upper_headings(rows: Sequence[Sequence[str]]) -> int:
    """Return how many rows stand over several columns of the row of headings below them."""
    if len(rows) > 3 and any(rows[0]) and _is_upper_heading(rows[1:]):
        first = [row[0] if row else "" for row in rows[:3]]
        if all(cell in {"", first[2]} for cell in first):  # blank, or merged, above the last one
            return 2
    return int(_is_upper_heading(rows))


def _is_upper_heading(rows: Sequence[Sequence[str]]) -> bool:
    """Return whether the first row stands over several columns of a second row of headings."""
    if len(rows) < 3:
        return False
    upper, lower = rows[0], rows[1]
    texts = [cell for cell in upper if cell]
    # Names of rows in front have no heading, and span nothing.
    spans = _filled(upper[1:]) < _filled(lower[1:]) or len(set(texts)) < len(texts)
    words = [cell for cell in lower if cell]
    no_data = sum(map(is_number, words)) * 2 < len(words) or _counts_up(words)
    repeats = len(set(words)) < len(words)
    return bool(spans and no_data and texts and repeats and is_heading(rows[1:]))


def _counts_up(words: Sequence[str]) -> bool:
    return [*words[-3:]] == sorted(set(words[-3:]), key=words.index) and all(
        is_number(word) for word in words[-3:]
    )
