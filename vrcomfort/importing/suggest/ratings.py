"""Finds ratings on scales of one item: asked after exposure, or again and again during it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vrcomfort.importing.answers import number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.headings import tokens
from vrcomfort.importing.suggest.vocabulary import ELAPSED_S
from vrcomfort.questionnaire import Instrument, plain


@dataclass(frozen=True)
class FoundRating:
    """A column of ratings, and that of the seconds at which they were given."""

    instrument: Instrument
    column: int
    time: int | None
    context: tuple[str, ...] = ()
    """The words of its heading that do not name the scale."""


def find_ratings(
    table: SourceTable, columns: Sequence[int], known: Sequence[Instrument]
) -> list[FoundRating]:
    """Return the columns that are called by the name of a scale of one item."""
    time = next((c for c in columns if plain(table.headings[c]) in ELAPSED_S), None)
    found = []
    for instrument in known:
        if len(instrument.asked) == 1:
            named = [c for c in columns if _is_named(table, c, instrument)]
            own = {plain(instrument.name), "score", "rating", *map(plain, instrument.title.split())}
            for column in named:
                rest = tuple(w for w in tokens(table.headings[column]) if w not in own)
                found.append(FoundRating(instrument, column, time, rest))
    return found


def _is_named(table: SourceTable, column: int, instrument: Instrument) -> bool:
    words = tokens(table.headings[column])
    keys = {plain(instrument.name), plain(instrument.title)}
    named = plain(table.headings[column]) in keys or (
        plain(instrument.name) in words and len(words) <= 5
    )
    values = [number(t, table.reading.decimal or ".") for t in set(table.column(column)) if t]
    high = instrument.high
    return named and any(v is not None and instrument.low <= v <= high for v in values)


FEWEST = 3
"""So many columns of one scale that differ in a number alone are a course of ratings."""


def courses_of(ratings: Sequence[FoundRating]) -> list[list[FoundRating]]:
    """Return ratings whose headings differ in one number alone, such as ``FMS_1 min``."""
    groups: dict[tuple[str, ...], list[FoundRating]] = {}
    for rating in ratings:
        digits = [word for word in rating.context if word.isdecimal()]
        if rating.time is None and len(digits) == 1:
            rest = tuple("#" if word.isdecimal() else word for word in rating.context)
            groups.setdefault((rating.instrument.name, *rest), []).append(rating)
    return [group for group in groups.values() if len(group) >= FEWEST]
