"""Finds ratings during exposure: a column of them, or one for each time; and their times."""

from __future__ import annotations

import re
from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vrcomfort.importing.answers import number
from vrcomfort.importing.files import JOIN
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.block_conditions import (
    fitting,
    number_in_words,
    numbered_conditions,
)
from vrcomfort.importing.suggest.cells import texts, values_of
from vrcomfort.importing.suggest.evidence import is_identifier
from vrcomfort.importing.suggest.found_answers import FoundAnswers, named_by_file
from vrcomfort.importing.suggest.scores import find_scores
from vrcomfort.importing.suggest.vocabulary import Known, LabVocabulary, tokens, words_of
from vrcomfort.questionnaire import Instrument, plain


@dataclass(frozen=True)
class FoundRating(FoundAnswers):
    """A column of ratings, and that of the seconds at which they were given.

    Parameters
    ----------
    event
        In logs, the column of what happened, and the text that is a rating.
    counts
        The times count on from 1, as minutes do.
    """

    column: int
    time: int | None
    event: tuple[int, str] | None = None
    counts: bool = False

    @property
    def columns(self) -> list[int]:
        """Return the index of the column of ratings."""
        return [self.column]


@dataclass(frozen=True)
class FoundCourse(FoundAnswers):
    """Columns of a rating time course, one for each time."""

    ratings: tuple[FoundRating, ...]

    @property
    def columns(self) -> list[int]:
        """Return the indices of the columns, in the order of the file."""
        return [rating.column for rating in self.ratings]


def find_ratings(table: SourceTable, columns: Sequence[int], known: Known) -> list[FoundRating]:
    """Return the columns of ratings that are in no time course."""
    ratings = _ratings(table, columns, known) or _among_events(table, known)
    courses = _times_of(table, ratings, known.vocabulary)
    in_courses = [rating for course in courses for rating in course]
    return [rating for rating in ratings if rating not in in_courses]


def find_courses(table: SourceTable, columns: Sequence[int], known: Known) -> list[FoundCourse]:
    """Return the rating time courses that have a column for each time."""
    units = known.vocabulary.units
    found = []
    for course in _times_of(table, _ratings(table, columns, known), known.vocabulary):
        first = course[0].context
        time = _time_in(first, units)
        context = (w for n, w in enumerate(first) if n != time and w not in units)
        found.append(FoundCourse(course[0].instrument, tuple(context), tuple(course)))
    return found


def _time_in(context: Sequence[str], units: Set[str]) -> int | None:
    """Return the place of the one number that is a time: before a unit, where there are others."""
    numbers = [n for n, word in enumerate(context) if word.isdecimal()]
    if len(numbers) > 1:
        numbers = [n for n in numbers if {*context[n + 1 : n + 2]} & units]
    return numbers[0] if len(numbers) == 1 else None


def _ratings(table: SourceTable, columns: Sequence[int], known: Known) -> list[FoundRating]:
    """Return the columns that are called by the name of a scale of one item."""
    totals = {c for each in find_scores(table, columns, known) for c in each.columns}
    time = time_column(table, [c for c in columns if c not in totals], known)
    if not table.reading.heading_rows:
        return _beside_their_time(table, columns, time, known) or _in_columns(table, columns, known)
    found = []
    for instrument in known.instruments:
        if len(instrument.asked) == 1:
            named = [c for c in columns if _is_rating(table, c, instrument)]
            if len(named) > 1 and time in named and not any(map(str.isdigit, table.headings[time])):
                named.remove(time)  # fms.t beside fms.score
            own = {plain(instrument.name), "score", "rating", *map(plain, instrument.title.split())}
            for column in named:
                words = _words_of_rating(table.headings[column], instrument)
                titled = _title_of(instrument) in plain(table.headings[column])
                words = words if titled or plain(instrument.name) in words else []
                rest = tuple(word for word in words if word not in own)
                found.append(FoundRating(instrument, rest, column, time))
    return found or _numbered_columns(table, columns, known)


def _among_events(table: SourceTable, known: Known) -> list[FoundRating]:
    """Return ratings among the events of a log: their scale's name, a time, and a value."""
    scales = {
        key: each
        for each in known.instruments
        if len(each.asked) == 1
        for key in (plain(each.name), plain(each.short), plain(each.title))
    }
    for column in range(len(table.headings) if table.reading.heading_rows else 0):
        words = texts(table, column)
        named = [word for word in words if plain(word) in scales]
        if len(named) != 1 or not 1 < len(words) <= _MOST_EVENTS:
            continue
        scale = scales[plain(named[0])]
        rows = tuple(row for row in table.rows if row[column] == named[0])
        own = replace(table, rows=rows)
        others = [c for c in range(len(table.headings)) if c != column and all(own.column(c))]
        numbers = [c for c in others if len(values_of(own, c)) == len(rows)]
        counts = [c for c in numbers if _counts_anew(own, c)]
        time = counts[0] if counts else time_column(own, numbers, known)
        rated = [c for c in numbers if c != time and all(map(scale.answers.has, values_of(own, c)))]
        rated = [c for c in rated if not is_identifier(own, c, known.vocabulary)]
        if time is not None and len(rated) == 1 and len(rows) >= _FEWEST_RISING:
            return [FoundRating(scale, (), rated[0], time, (column, named[0]), bool(counts))]
    return []


_MOST_EVENTS = 100


def _counts_anew(table: SourceTable, column: int) -> bool:
    """Return whether numbers count on from 1, over and over."""
    values = values_of(table, column)
    steps = all(b in {a + 1, 1} for a, b in pairwise(values))
    return len({*values}) >= FEWEST_TIMES and values[0] == 1 and steps


def _numbered_columns(
    table: SourceTable, columns: Sequence[int], known: Known
) -> list[FoundRating]:
    """Return columns such as ``t1`` to ``t8``, in a file that is called after a scale."""
    said = named_by_file(table, known.instruments)
    scales = [i for i in known.instruments if i.name in said and len(i.asked) == 1]
    if len(scales) != 1:
        return []
    groups: dict[tuple[str, ...], list[tuple[int, int, tuple[str, ...]]]] = {}
    for column in columns:
        words = tokens(table.headings[column])
        numbers = [place for place, word in enumerate(words) if word.isdecimal()]
        values = values_of(table, column)
        if len(numbers) == 1 and values and all(map(scales[0].answers.has, values)):
            key = tuple("#" if n == numbers[0] else word for n, word in enumerate(words))
            groups.setdefault(key, []).append((int(words[numbers[0]]), column, tuple(words)))
    return [
        FoundRating(scales[0], words, column, None)
        for group in groups.values()
        if len(group) >= FEWEST_TIMES and [*group] == sorted(group)
        for _, column, words in group
    ]


def time_column(table: SourceTable, columns: Sequence[int], known: Known) -> int | None:
    """Return the column of the seconds of ratings: by its heading, or one of times that rise."""
    vocabulary, scales = known.vocabulary, {plain(i.name) for i in known.instruments}
    inner = [h.rpartition(".")[2] if table.nested else h for h in table.headings]
    rest = ["".join(word for word in tokens(h) if word not in scales) for h in inner]
    named = [c for c in columns if {plain(table.headings[c]), rest[c]} & vocabulary.seconds]
    if named:
        return named[0]
    headed = bool(table.reading.heading_rows)
    rising = [
        c
        for c in columns
        if not headed or {*tokens(table.headings[c])} & (vocabulary.time_words | vocabulary.minutes)
        if rises(table, c)
    ]
    clocks = {re.sub(r"\d", "", table.headings[c]) for c in rising}
    if headed and len(clocks) == len(rising):  # that of the exposure begins anew in each
        rising.sort(key=lambda c: max(values_of(table, c)))
    told_apart = len(clocks) == len(rising) or not headed
    return rising[0] if rising and told_apart else None


def rises(table: SourceTable, column: int) -> bool:
    """Return whether numbers rise from row to row, but where another exposure begins."""
    values = values_of(table, column)
    whole = len(values) == len(table.rows) > _FEWEST_RISING
    steps = np.diff(values) if whole else np.zeros(1)
    return bool((steps > 0).mean() >= _RISING)


_FEWEST_RISING, _RISING = 5, 0.8
"""Rows, and the share of steps upwards, of a column of times."""


def _beside_their_time(
    table: SourceTable, columns: Sequence[int], time: int | None, known: Known
) -> list[FoundRating]:
    """Return the ratings of a log without headings, whose file names the scale: time and rating."""
    said = named_by_file(table, known.instruments)
    scales = [i for i in known.instruments if i.name in said and len(i.asked) == 1]
    others = [c for c in columns if c != time]
    if time is None or len(scales) != 1 or len(others) != 1:
        return []
    (scale,), (column,) = scales, others
    inside = all(map(scale.answers.has, values_of(table, column)))
    return [FoundRating(scale, (), column, time)] if inside else []


def _in_columns(table: SourceTable, columns: Sequence[int], known: Known) -> list[FoundRating]:
    """Return ratings in the order asked, without headings, behind the column of the people."""
    first = next(iter(columns), None)
    if first is None or not is_identifier(table, first, known.vocabulary):
        return []
    rest = [c for c in columns if c != first and any(table.column(c))]
    found = _numbered_columns(table, rest, known)
    return found if len(found) == len(rest) else []


def _words_of_rating(heading: str, instrument: Instrument) -> list[str]:
    """Return the words of a heading, with the name of the scale in front as one: ``mis_cpre``.

    Programs that clean headings put signs where capital letters end.
    """
    name, letters = plain(instrument.name), 0
    if name in tokens(heading) or not plain(heading).startswith(name):
        return tokens(heading)
    for place, letter in enumerate(heading):
        letters += len(plain(letter))
        if letters == len(name):
            return [name, *tokens(heading[place + 1 :])]
    return tokens(heading)


def _is_rating(table: SourceTable, column: int, instrument: Instrument) -> bool:
    words = _words_of_rating(table.headings[column], instrument)
    if instrument.short in words_of(table.labels[column]):
        words = [plain(instrument.name)]
    heading = table.headings[column]
    short = instrument.short.isupper() and instrument.short in words_of(heading)
    named = (
        short
        or _title_of(instrument) in plain(heading)
        or (plain(instrument.name) in words and (len(words) <= 5 or JOIN in table.headings[column]))
    )
    if not named or _NO_ANSWERS & {*words}:
        return False
    cells = [cell.replace(",", ".") for cell in table.column(column) if cell]
    values = [number(cell, ".") for cell in cells]
    inside = [v for v in values if v is not None and instrument.low <= v <= instrument.high]
    # Means of ratings stand under the scale's name, too, and most are no answers of it.
    return bool(inside) and sum(map(instrument.answers.has, inside)) * 10 >= len(inside) * 7


def _title_of(instrument: Instrument) -> str:
    """Return an instrument's title as headings have it: *Fast motion sickness (0-20)*."""
    return plain(instrument.title.removesuffix("scale"))


_NO_ANSWERS = frozenset(["complete", "rt"])
"""Words of headings for whether a form was filled in, and for how long an answer took."""
FEWEST_TIMES = 3
"""Columns of one scale that differ in a number alone and are a time course of ratings."""


def _times_of(
    table: SourceTable, ratings: Sequence[FoundRating], vocabulary: LabVocabulary
) -> list[list[FoundRating]]:
    """Return the time courses, but for ratings whose numbers are those of conditions beside."""
    numbered = numbered_conditions(table, vocabulary)
    groups: dict[tuple[str, ...], list[FoundRating]] = {}
    for rating in ratings:  # headings of a course differ in one number alone: FMS_1 min
        place = _time_in(rating.context, vocabulary.units)
        if rating.time is None and place is not None:
            rest = tuple("#" if n == place else word for n, word in enumerate(rating.context))
            groups.setdefault((rating.instrument.name, *rest), []).append(rating)
    return [
        course
        for course in groups.values()
        if len(course) >= FEWEST_TIMES
        if not fitting([number_in_words(each.context) for each in course], numbered)
    ]
