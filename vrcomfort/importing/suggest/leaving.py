"""Finds the times at which participants left exposures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

from vrcomfort.importing.answers import time_in_words_s
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.cells import texts, values_of
from vrcomfort.importing.suggest.heading_facts import common_start
from vrcomfort.importing.suggest.vocabulary import Known, LabVocabulary, tokens
from vrcomfort.questionnaire import plain


class FoundLeaving(NamedTuple):
    """Columns of the times at which participants left.

    Parameters
    ----------
    columns
        Index of the column → the condition that its heading says, or nothing.
    heading
        How the headings are made.
    """

    columns: dict[int, str]
    heading: str
    unit: Literal["s", "min"]
    stayed: tuple[str, ...] = ()
    """Texts of those who stayed."""


def find_leaving(table: SourceTable, columns: Sequence[int], known: Known) -> FoundLeaving | None:
    """Return the columns of leaving times; None where there are none."""
    found = [
        column
        for column in columns
        if any(_within(each, tokens(table.headings[column])) for each in known.vocabulary.leaving)
        and values_of(table, column)
    ]
    if not found:
        return _left_in_words(table, columns, known.vocabulary)
    headings = [table.headings[column] for column in found]
    minutes = any({*tokens(heading)} & known.vocabulary.minutes for heading in headings)
    unit: Literal["s", "min"] = "min" if minutes else "s"
    if len(found) == 1:
        return FoundLeaving({found[0]: ""}, headings[0], unit)
    start, end = common_start(headings), common_start([each[::-1] for each in headings])[::-1]
    said = {
        column: heading.removeprefix(start).removesuffix(end)
        for column, heading in zip(found, headings, strict=True)
    }
    return FoundLeaving(said, f"{start}{{condition}}{end}", unit)


def _left_in_words(
    table: SourceTable, columns: Sequence[int], vocabulary: LabVocabulary
) -> FoundLeaving | None:
    """Return a column of ``N`` and ``Yes - 11m 56s`` under a heading for leaving."""
    for column in columns:
        if not {*tokens(table.headings[column])} & vocabulary.leaving_words:
            continue
        heading = table.headings[column]
        # Labs repeat the row of headings between groups of people.
        words = [word for word in texts(table, column) if plain(word) != plain(heading)]
        stayed = tuple(word for word in words if time_in_words_s(word) is None)
        said_no = all(plain(word) in vocabulary.yes_no for word in stayed)
        if len(words) - len(stayed) >= _FEWEST_LEFT and said_no:
            return FoundLeaving({column: ""}, heading, "s", stayed)
    return None


_FEWEST_LEFT = 2


def _within(label: Sequence[str], words: Sequence[str]) -> bool:
    return any([*words[n : n + len(label)]] == [*label] for n in range(len(words)))
