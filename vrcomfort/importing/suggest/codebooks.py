"""Reads codebooks: tables that describe the columns of other tables."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise, permutations

from vrcomfort.importing.files import is_number
from vrcomfort.importing.source import SourceTable
from vrcomfort.questionnaire import plain

_FEWEST = 4
"""Columns that a codebook explains at least."""
_MOST_OF_PART = 12
"""Rows that a codebook has for each part of a question: one for each answer."""
_RANGE = re.compile(r"(\S+) ?(?:bis|to|through|thru|until|à|al|tot|[-–—…]|\.\.\.?) ?(\S+)")
"""The columns from one to another, in one row of a codebook."""
_PAIR = re.compile(
    r"(?<![\w.])(-?\d+) ?[=:,–-] ?([^\d\s=;|()][^=;|()]*?)(?=[;|,)]? ?-?\d+ ?[=:,–-]|[;|()]|$)"
)
"""``1 = not at all``, with others behind it."""


_TITLES = frozenset(map(plain, ["form name", "question"]))
"""Headings of the forms, and of the questions above several columns, that a codebook names."""
TITLE = ":"
"""Behind the title of a form, before the texts of its questions."""
BESIDE = " | "
"""Between the texts of a label that stand in cells of their own."""


def with_codebooks(tables: Sequence[SourceTable]) -> list[SourceTable]:
    """Return the tables with what codebooks among them say of columns and of their answers."""
    found = []
    for table in tables:
        said: dict[str, list[str]] = {}
        meanings: dict[str, dict[str, str]] = {}
        for book in tables:
            if book is table:
                continue
            explained = [*_explained(book, table)]
            rows = Counter(name for name, _ in explained)
            always: dict[str, list[str]] = {}
            for name, row in explained:
                kept = always.setdefault(name, [*filter(None, row)])
                always[name] = [text for text in kept if text in row]
            for name, texts in always.items():
                said[name] = [*said.get(name, ()), *(texts if rows[name] > 1 else ())]
            for name, row in explained:
                own = meanings.setdefault(name, {})
                codes = [cell for cell in row if is_number(cell)]
                if rows[name] > 1 and codes:  # a row for each answer, its meaning last
                    own.setdefault(codes[0], [cell for cell in row if cell][-1])
                elif rows[name] == 1:
                    said[name] = [*said.get(name, ()), *row]
                    for text in row:
                        own.update(legend(text))
        labels, values = [], []
        often = _often(said)
        for heading, label in zip(table.headings, table.labels, strict=True):
            texts = [
                text
                for text in said.get(heading, ())
                if text and (text not in often or text.endswith(TITLE))
            ]
            labels.append(BESIDE.join(dict.fromkeys([*filter(None, [label]), *texts])))
            values.append({**legend(f"{heading} {label}"), **meanings.get(heading, {})})
        found.append(replace(table, labels=tuple(labels), meanings=tuple(values)))
    return found


def _often(said: Mapping[str, Sequence[str]]) -> set[str]:
    """Return texts that a codebook says of one column and the next, such as their type."""
    texts = {text for each in said.values() for text in each if is_number(text)}
    return texts.union(*({*one} & {*other} for one, other in pairwise(said.values())))


def legend(text: str) -> dict[str, str]:
    """Return number → meaning of ``1 = not at all, 2 = slightly``; nothing of other texts."""
    found = {code: words.strip(" ,;|") for code, words in _PAIR.findall(text)}
    return found if len(found) > 1 and all(found.values()) else {}


def _explained(book: SourceTable, table: SourceTable) -> Iterator[tuple[str, list[str]]]:
    """Yield each heading of a table that a codebook explains, with the other cells of its row."""
    places = {heading: place for place, heading in enumerate(table.headings)}
    if sidecar := _sidecar(book, places):
        yield from sidecar.items()
        return
    titles = [n for n, heading in enumerate(book.headings) if plain(heading) in _TITLES]
    for column in range(len(book.headings)):
        cells = [cell for cell in book.column(column) if cell]
        rows = [(_range(cell, places), cell) for cell in dict.fromkeys(cells)]
        named = {cell: found for found, cell in rows if found}
        count = len({place for found in named.values() for place in found})
        if count < _FEWEST or len(named) * 2 < len(rows):
            continue
        if len(book.rows) > len(table.headings) * 30:
            continue  # answers in long form, beside the same ones in a row each
        for row in book.rows:
            others = [cell for n, cell in enumerate(row) if n != column]
            if title := " ".join(row[n].replace("_", " ") for n in titles if row[n]):
                others.insert(0, title + TITLE)
            for place in named.get(row[column], ()):
                yield table.headings[place], others
        return
    yield from _joined_codes(book, places)


def _joined_codes(book: SourceTable, places: Mapping[str, int]) -> Iterator[tuple[str, list[str]]]:
    """Yield headings made of the codes of a question and of its part: ``Q1[SQ003]``, ``Q1_3``."""
    keys = {plain(heading): heading for heading in places}
    for one, two in permutations(range(len(book.headings)), 2):
        names = [keys.get(plain(row[one] + row[two]), "") for row in book.rows]
        parts = {n for n, row in zip(names, book.rows, strict=True) if n and row[one] and row[two]}
        if len(parts) >= _FEWEST and len(book.rows) <= len(parts) * _MOST_OF_PART:
            for name, row in zip(names, book.rows, strict=True):
                if name:
                    yield name, [cell for n, cell in enumerate(row) if n not in {one, two}]
            return


def _sidecar(book: SourceTable, places: Mapping[str, int]) -> dict[str, list[str]]:
    """Return heading → what a JSON file says of it, as BIDS has it: texts, and levels."""
    split = [heading.split(".", 1) for heading in book.headings]
    named = {name for name, *inner in split if inner and name in places}
    if len(book.rows) != 1 or len(named) < _FEWEST_OF_SIDECAR:
        return {}
    said: dict[str, list[str]] = {name: [] for name in places if name in named}
    levels: dict[str, list[str]] = {name: [] for name in said}
    for (name, *inner), cell in zip(split, book.rows[0], strict=True):
        if name in said and cell and inner:
            key, _, code = inner[0].rpartition(".")
            (levels if key else said)[name].append(f"{code} = {cell}" if key else cell)
    return {name: [*said[name], "; ".join(levels[name])] for name in said}


_FEWEST_OF_SIDECAR = 2


def is_codebook(book: SourceTable, tables: Sequence[SourceTable], *, people: bool) -> bool:
    """Return whether a file says of the columns of another table what they, or numbers, are.

    One that seems to have people is none, unless it joins codes.
    """
    for table in (table for table in tables if table.file != book.file):
        if any(_joined_codes(book, dict.fromkeys(table.headings, 0))):
            return True
        if people:
            continue
        if _sidecar(book, dict.fromkeys(table.headings, 0)):
            return True
        said = [(name, next(filter(is_number, row), "")) for name, row in _explained(book, table)]
        if len({*said}) == len(said) >= _FEWEST:
            return True
    return False


def _range(cell: str, places: Mapping[str, int]) -> list[int]:
    """Return the places of the headings that a cell names: one, or those from one to another."""
    if cell in places:
        return [places[cell]]
    ends = _RANGE.fullmatch(cell)
    if ends is None or ends[1] not in places or ends[2] not in places:
        return []
    return [*range(places[ends[1]], places[ends[2]] + 1)]
