"""Reads the cells of a column: its texts and numbers, and how people have them."""

from __future__ import annotations

import re
from collections import Counter, defaultdict

from vrcomfort.importing.answers import number
from vrcomfort.importing.files import is_number
from vrcomfort.importing.source import SourceTable

MOST_CONDITIONS = 12
"""A column with more different texts holds names, or answers in own words."""
LONGEST_CODE = 24
"""Letters of a participant's code at most."""
LONGEST_CONDITION = 40
"""Letters of a condition's name at most."""
DATE_OR_TIME = re.compile(r"\d{1,4}[/.\-]\d{1,2}[/.\-]\d{1,4}(?!\d)|\d{1,2}:\d{2}")


def texts_of_people(table: SourceTable, column: int, participant: int) -> list[Counter[str]]:
    """Return for each participant how often each text is in a column."""
    people: dict[str, Counter[str]] = defaultdict(Counter)
    for row in table.rows:
        if row[column]:
            people[row[participant]][row[column]] += 1
    return [*people.values()]


def counts_of_people(table: SourceTable, column: int, participant: int) -> list[Counter[str]]:
    """Return how often each participant of several rows has each text."""
    return [each for each in texts_of_people(table, column, participant) if each.total() > 1]


def is_balanced(table: SourceTable, column: int, participant: int | None) -> bool:
    """Return whether most participants have each text of a column, or as many, equally often."""
    if participant is None:
        return False
    people = counts_of_people(table, column, participant)
    usual = Counter(len(counts) for counts in people).most_common(1)
    even = [len(c) == usual[0][0] > 1 and max(c.values()) == min(c.values()) for c in people]
    return sum(even) * 4 >= len(even) * 3 > 0


def measures(table: SourceTable, column: int) -> bool:
    """Return whether a column holds decimals, dates, sentences or headings: no conditions."""
    words = texts(table, column)
    if words and {*words} <= {*table.headings}:
        return True  # which of two items weighs more
    decimals = all(map(is_number, words)) and any("." in word or "," in word for word in words)
    dates = bool(words) and all(map(DATE_OR_TIME.match, words))
    return decimals or dates or any(len(word) > LONGEST_CONDITION for word in words)


def texts(table: SourceTable, column: int) -> list[str]:
    """Return the different texts of a column, in the order of the file, without blanks."""
    return [*table.texts[column]]


def values_of(table: SourceTable, column: int) -> list[float]:
    """Return the numbers of a column; other cells are passed over."""
    read = [number(cell, table.decimal) for cell in table.column(column) if cell]
    return [value for value in read if value is not None]


def varies_within(table: SourceTable, column: int, participant: int | None) -> bool:
    """Return whether a participant has more than one text in a column."""
    if participant is None:
        return len(texts(table, column)) > 1
    return any(len(each) > 1 for each in texts_of_people(table, column, participant))


def few_texts(table: SourceTable, column: int, most: int = MOST_CONDITIONS) -> bool:
    """Return whether a column has few different texts, each of them more than once."""
    found = texts(table, column)
    return 2 <= len(found) <= most and len(table.rows) >= 2 * len(found)


def is_numeric(table: SourceTable, column: int) -> bool:
    """Return whether all texts of a column are numbers."""
    found = texts(table, column)
    return bool(found) and all(map(is_number, found))
