"""Splits a sheet with several tables, one below the other, into its parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from vrcomfort.importing.files import is_heading, is_number, repeated_runs
from vrcomfort.importing.source import Grid
from vrcomfort.questionnaire import plain

JOIN = ": "
"""Between the name of a sheet and the title of a part of it."""
_FEWEST_WORDS, _FEWEST_ROWS = 3, 2
"""Words of a row of headings, and rows below it."""


@dataclass
class _Part:
    """A table in a sheet: where its headings stand, its end, and the title above it."""

    start: int
    end: int
    title: str


def sections(grid: Grid) -> list[Grid]:
    """Return the parts of a sheet, named after their titles; the sheet itself where it has none.

    A part begins with headings below a blank row or below a title, which is a text alone in its
    row. Parts with the same headings need titles, which tell them apart: the title can also stand
    in place of the first heading.
    """
    if grid.named:
        return [grid]
    if beside := _side_by_side(grid):
        return beside
    parts = _parts(grid)
    headings = [[*map(plain, grid.rows[part.start])] for part in parts]
    if len(parts) > 1 and all(row[1:] == headings[0][1:] for row in headings):
        firsts = [grid.rows[part.start][0] for part in parts]
        told = len({part.title for part in parts} - {""}) == len(parts)
        if not told and len({*firsts}) == len(parts) and all(firsts):
            rows = [*grid.rows]
            for part, first in zip(parts, firsts, strict=True):
                part.title = first
                rows[part.start] = ("", *rows[part.start][1:])
            grid = replace(grid, rows=tuple(rows))
        elif not all(part.title for part in parts):
            return [grid]
    if len(parts) < 2:
        return [grid]
    names = _names(grid.sheet, parts)
    return [
        replace(
            grid,
            sheet=name,
            rows=grid.rows[part.start : part.end],
            numbers=grid.numbers[part.start : part.end],
        )
        for name, part in zip(names, parts, strict=True)
    ]


def _side_by_side(grid: Grid) -> list[Grid]:
    """Return tables with the same headings side by side, each below its title; or nothing.

    People who are the same from row to row make one table of them.
    """
    for index, row in enumerate(grid.rows[1:_MOST_ABOVE], start=1):
        starts = repeated_runs(row)
        above = grid.rows[index - 1]
        if len(starts) < 2 or [place for place, cell in enumerate(above) if cell] != starts:
            continue
        if len({above[start] for start in starts}) < len(starts) or not _begins(grid.rows[index:]):
            continue
        ends = [*starts[1:], max(map(len, grid.rows))]
        parts = [_Part(index, len(grid.rows), above[start]) for start in starts]
        cut = [
            _columns(grid, index, (a, b), name)
            for name, a, b in zip(_names(grid.sheet, parts), starts, ends, strict=True)
        ]
        people = [[cells[0] for cells in part.rows] for part in cut]
        return [] if all(each == people[0] for each in people) else cut
    return []


_MOST_ABOVE = 6
"""Rows above and with the headings of tables side by side."""


def _columns(grid: Grid, first: int, between: tuple[int, int], name: str) -> Grid:
    """Return some columns of a grid, from a row on; blank rows are left out."""
    start, end = between
    rows = [
        (number, tuple(row[start:end]))
        for number, row in zip(grid.numbers[first:], grid.rows[first:], strict=True)
        if any(row[start:end])
    ]
    cells, numbers = tuple(row for _, row in rows), tuple(number for number, _ in rows)
    return replace(grid, sheet=name, rows=cells, numbers=numbers)


def _names(sheet: str, parts: Sequence[_Part]) -> list[str]:
    names: list[str] = []
    for number, part in enumerate(parts, start=1):
        title = part.title or f"part {number}"
        name = f"{sheet}{JOIN}{title}" if sheet else title
        names.append(name if name not in names else f"{name} ({number})")
    return names


def _parts(grid: Grid) -> list[_Part]:
    rows, found = grid.rows, list[_Part]()
    for index, row in enumerate(rows):
        title = _title(rows[index - 1]) if index else ""
        gap = index == 0 or bool(title) or grid.numbers[index] > grid.numbers[index - 1] + 1
        again = bool(found) and _alike(row, rows[found[0].start])
        if (gap or again) and _begins(rows[index : index + 60]):
            if found:
                found[-1].end = index - 1 if title else index
            found.append(_Part(index, len(rows), title))
    return found


def _title(row: Sequence[str]) -> str:
    """Return the text that stands alone in a row, perhaps merged over cells; or nothing."""
    texts = {cell for cell in row if cell}
    text = min(texts, default="")
    return text if len(texts) == 1 and not is_number(text) else ""


def _alike(row: Sequence[str], heading: Sequence[str]) -> bool:
    """Return whether a row repeats headings, but perhaps for the first one."""
    return [*map(plain, row[1:])] == [*map(plain, heading[1:])] and any(row[1:])


def _begins(rows: Sequence[Sequence[str]]) -> bool:
    """Return whether rows are headings and data below them."""
    words = [cell for cell in rows[0] if cell]
    named = len({*words}) >= _FEWEST_WORDS and not any(map(is_number, words))
    numbers = sum(is_number(cell) for row in rows[1 : 1 + _FEWEST_ROWS] for cell in row)
    return named and len(rows) > _FEWEST_ROWS and numbers >= _FEWEST_ROWS and is_heading(rows)
