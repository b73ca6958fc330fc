"""Finds rows that are no person's: totals, legends, repeated headings, and trial runs.

Labs leave trial runs in their exports: previews, tests, admins.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Sequence
from statistics import fmean

from vrcomfort.importing.answers import number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.cells import texts
from vrcomfort.importing.suggest.heading_roles import inner_names, names_fact
from vrcomfort.importing.suggest.vocabulary import LabVocabulary, tokens
from vrcomfort.questionnaire import plain

_FEWEST_PEOPLE = 5
"""Codes that tell what stands between them from one of them."""


def repeated_headings(table: SourceTable, column: int) -> list[str]:
    """Return the texts of a column in rows that repeat headings, between groups of people."""
    headings = [*map(plain, table.headings)]

    def repeats(row: tuple[str, ...]) -> bool:
        alike = (plain(cell) == name for cell, name in zip(row, headings, strict=True))
        words = (not (name == "" or name.isdecimal()) for name in headings)
        return (
            sum(same and word for same, word in zip(alike, words, strict=True)) >= _FEWEST_REPEATED
        )

    return list(dict.fromkeys(row[column] for row in table.rows if row[column] and repeats(row)))


_FEWEST_REPEATED = 3


def total_rows(table: SourceTable, column: int, totals: Collection[str]) -> list[str]:
    """Return the texts of a column that name means, sums and the like, of the last rows."""
    cells = table.column(column)
    # Eight rows hold the mean, SD, n, min and max that labs put below their participants.
    found = [
        text
        for text in dict.fromkeys(cells[-8:])
        if _is_total(text, totals) and cells.count(text) == 1
    ]
    found = found if len(cells) >= 2 * len(found) else []
    return found + _between_codes(cells)


def means_below(table: SourceTable) -> tuple[int, ...]:
    """Return the numbers of the last rows, from one on that has no name, but the others' means."""
    for place in range(max(len(table.rows) - _MOST_BELOW, _FEWEST_PEOPLE), len(table.rows)):
        cells = [(c, text) for c, text in enumerate(table.rows[place]) if text]
        found = [number(text, table.decimal) for _, text in cells]
        exact = all(value is None or value.is_integer() for value in found)
        if len(cells) < 2 or None in found or exact:
            continue
        if all(_is_mean(table, place, column, text) for column, text in cells):
            return table.numbers[place:]
    return ()


_MOST_BELOW = 8
"""Rows of mean, SD, n, minimum and maximum."""


def _is_mean(table: SourceTable, place: int, column: int, text: str) -> bool:
    """Return whether a number is the mean of those above it, as it is rounded."""
    above = [number(row[column], table.decimal) for row in table.rows[:place] if row[column]]
    values = [value for value in above if value is not None]
    digits = len(re.split(r"[.,]", text)[-1]) if re.search(r"[.,]", text) else 0
    value = number(text, table.decimal) or 0.0
    return len(values) > 1 and abs(value - fmean(values)) < 0.6 * 10.0**-digits + 1e-9


def notes_below(table: SourceTable, column: int) -> list[str]:
    """Return the texts of the last rows that stand alone there and are no codes: a legend.

    A cell that spans a row is read as the same text in each column.
    """
    width = len(table.headings)
    cells = table.column(column)
    found: list[str] = []
    for row, cell in zip(reversed(table.rows), reversed(cells), strict=True):
        spans = all(each == cell for each in row)
        alone = cell and (spans or sum(map(bool, row)) <= _FEW_CELLS) and width > _FEW_CELLS
        if not alone or cells.count(cell) > 1 or _shape(cell) in {*map(_shape, cells[:2])}:
            break
        found.append(cell)
    return found[::-1] if len(found) * 2 < len(cells) + _LINES_OF_LEGEND else []


_FEW_CELLS, _LINES_OF_LEGEND = 2, 20


def _shape(text: str) -> str:
    """Return a code with ``a`` for letters and ``0`` for numbers."""
    return re.sub(r"[^\W\d_]+", "a", re.sub(r"\d+", "0", text))


def scores_of_others(table: SourceTable, column: int, vocabulary: LabVocabulary) -> list[str]:
    """Return the texts such as ``Score P01``, which name what was computed for another text."""
    cells = texts(table, column)
    bare = {plain(cell) for cell in cells}
    words = vocabulary.scale_fillers | {plain(word) for word in vocabulary.totals if len(word) > 2}

    def rest(text: str) -> str:
        return plain(" ".join(word for word in text.split() if plain(word) not in words))

    return [text for text in cells if rest(text) != plain(text) and rest(text) in bare]


def _is_total(text: str, totals: Collection[str]) -> bool:
    """Return whether a text is ``SD``, or ``Average SUS score``."""
    words = tokens(text)
    named = 1 < len(words) <= 4 and words[0] in totals and not any(map(str.isdecimal, words))
    return text.casefold().strip(" :.") in totals or (named and len(words[0]) > 1)


def _between_codes(cells: Sequence[str]) -> list[str]:
    """Return the text that recurs between codes of people, each of them once."""
    counts = Counter(cell for cell in cells if cell)
    codes = [text for text in counts if re.fullmatch(r"[^\W\d_]+ ?\d+", text)]
    again = [text for text, count in counts.items() if count > 1]
    once = len(codes) >= _FEWEST_PEOPLE and not {*again} & {*codes}
    return again if once and len(again) == 1 else []


def rows_of_trial_runs(table: SourceTable, vocabulary: LabVocabulary) -> dict[int, list[str]]:
    """Return column → its texts in rows that are no person's, each row by one column.

    A survey program says so, or the code in place of the person's is a word such as ``test``.
    """
    found: dict[int, list[str]] = {}
    kept = table.rows
    for column, (heading, label) in enumerate(zip(table.headings, table.labels, strict=True)):
        words = vocabulary.trial_runs.get(plain(heading), frozenset())
        words |= vocabulary.trial_runs.get(plain(label), frozenset())
        names = inner_names(heading) if table.nested else (heading,)
        person = any(names_fact(name, "participant", vocabulary) for name in names)
        if person:
            words |= vocabulary.trial_runs.get("participant", frozenset())
        said = {row[column] for row in kept if plain(row[column]) in words}
        if person:
            said |= {row[column] for row in kept if {*tokens(row[column])} & words}  # test123
        rest = tuple(row for row in kept if row[column] not in said)
        if said and len(rest) * 2 > len(table.rows):
            found[column] = [text for text in texts(table, column) if text in said]
            kept = rest
    return found
