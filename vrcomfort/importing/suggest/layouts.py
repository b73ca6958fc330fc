"""Finds answers that are not a column for each item: long tables, ratings, scores alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Literal, NamedTuple

import numpy as np

from vrcomfort.importing.answers import number, time_in_words_s
from vrcomfort.importing.files import is_number
from vrcomfort.importing.made_instruments import on_scale
from vrcomfort.importing.mapping import ScoreKind, scale_named
from vrcomfort.importing.source import Grid, SourceTable
from vrcomfort.importing.suggest.block_conditions import (
    fitting,
    number_in_words,
    numbered_conditions,
)
from vrcomfort.importing.suggest.evidence import texts
from vrcomfort.importing.suggest.items import FoundAnswers, How, mentions, named_item
from vrcomfort.importing.suggest.vocabulary import Known, LabVocabulary, tokens
from vrcomfort.questionnaire import Instrument, plain


@dataclass(frozen=True)
class Long(FoundAnswers):
    """A table with a row for each answer.

    Parameters
    ----------
    items
        Item → text in the item column.
    hows
        Item → how it was found.
    others
        Texts of the item column that are no item.
    instrument_column
        Where the questionnaire is named, and the text there.
    """

    item_column: int
    response_column: int
    items: dict[str, str]
    hows: dict[str, How]
    others: list[str]
    instrument_column: tuple[int, str] | None

    @property
    def row_keys(self) -> list[int]:
        """Return the columns that tell the answers of one questionnaire apart."""
        named = [self.instrument_column[0]] if self.instrument_column else []
        return [self.item_column, *named]

    @property
    def columns(self) -> list[int]:
        """Return the indices of the columns."""
        return [*self.row_keys, self.response_column]


def find_long(table: SourceTable, columns: Sequence[int], known: Known) -> list[Long]:
    """Return the questionnaires of a long table; none where it is not one."""
    found: list[Long] = []
    for column in columns:
        words = texts(table, column)
        # Fewer items make no questionnaire; more texts are ids or comments.
        if not (4 <= len(words) <= 200) or len(table.rows) < len(words):
            continue
        response = _response_column(table, column, known.vocabulary)
        if response is None:
            continue
        for instrument in known.instruments:
            named = _named_in_rows(table, column, words, instrument, known)
            if named is not None:
                items, hows = named
                others = [word for word in words if word not in items.values()]
                where = _instrument_column(table, instrument, column)
                long = Long(instrument, (), column, response, items, hows, others, where)
                found.append(long)
        if found:
            return _best_long(found)
    return []


def stands_on_its_side(grid: Grid, known: Known) -> bool:
    """Return whether items stand one below the other, and participants side by side."""
    width = max(map(len, grid.rows))
    responses = known.vocabulary.response_labels
    if grid.named or width < 3 or any(plain(cell) in responses for cell in grid.rows[0]):
        return False
    first = [row[0] for row in grid.rows if row[0]]
    others = {cell for row in grid.rows[1:] for cell in row[1:] if cell}
    if len(set(first)) < len(first) or len(others) > 30:
        return False
    for instrument in known.instruments:
        spellings = known.vocabulary.spellings(instrument)
        named = {spellings[plain(text)] for text in first if plain(text) in spellings}
        if len(named) >= 4 and len(named) * 2 >= len(first):
            return True
    return False


def _best_long(found: list[Long]) -> list[Long]:
    """Keep questionnaires that are named in a column of their own, or else those that fit.

    Several can fit, one after the other: each of the others has all its items among the texts that
    are no item of those before.
    """
    named = [long for long in found if long.instrument_column is not None]
    if named:
        return named
    ranked = sorted(found, key=lambda each: (-_share(each), len(each.others)))
    kept = ranked[:1]
    for long in ranked[1:]:
        taken = {text for each in kept for text in each.items.values()}
        if _share(long) == 1 and not taken & {*long.items.values()}:
            kept.append(long)
    taken = {text for each in kept for text in each.items.values()}
    return [
        replace(each, others=[text for text in each.others if text not in taken]) for each in kept
    ]


def _share(long: Long) -> float:
    return len(long.items) / len(long.instrument.asked)


def _named_in_rows(
    table: SourceTable,
    column: int,
    words: list[str],
    instrument: Instrument,
    known: Known,
) -> tuple[dict[str, str], dict[str, How]] | None:
    items: dict[str, str] = {}
    hows: dict[str, How] = {}
    for word in words:
        found = named_item(column, word, "", instrument, known.vocabulary)
        if found is not None and (
            found.item not in items or found.how == "name" != hows[found.item]
        ):
            items[found.item] = word
            hows[found.item] = found.how
    sure = sum(how == "name" for how in hows.values())
    if sure >= min(4, len(instrument.asked)) and len(instrument.asked) > 1:
        return items, hows
    return _numbered_in_rows(table, column, words, instrument, known)


def _numbered_in_rows(
    table: SourceTable,
    column: int,
    words: list[str],
    instrument: Instrument,
    known: Known,
) -> tuple[dict[str, str], dict[str, How]] | None:
    """Find items by numbers, ``1`` … ``16`` or ``SSQ1`` …, in a column that is called item."""
    heading = plain(table.headings[column])
    named = mentions(" ".join(words[:3]), known.instruments)
    if heading not in known.vocabulary.item_labels and not named:
        return None
    numbers: dict[int, str] = {}
    for word in words:
        digits = [token for token in tokens(word) if token.isdecimal()]
        named = mentions(word, known.instruments)
        if len(digits) == 1 and (not named or instrument.name in named):
            numbers.setdefault(int(digits[0]), word)
    count = len(instrument.asked)
    first = min(numbers, default=9)
    if first > 1 or sorted(numbers) != list(range(first, first + count)) or count < 4:
        return None
    items = {item.name: numbers[n] for n, item in enumerate(instrument.asked, start=first)}
    return items, dict.fromkeys(items, "number")


def _response_column(table: SourceTable, item_column: int, vocabulary: LabVocabulary) -> int | None:
    candidates = [
        column
        for column, heading in enumerate(table.headings)
        if column != item_column and _is_response(table, column, heading, vocabulary)
    ]
    named = [c for c in candidates if _last_word(table.headings[c]) in vocabulary.response_labels]
    if not named and not table.reading.heading_rows:
        # Without headings, answers are small numbers or words of severity: times and dates are not.
        named = [c for c in candidates if _are_few_and_short(texts(table, c))]
        named = named if len(named) == 1 else []
    return named[0] if named else None


def _are_few_and_short(words: Sequence[str]) -> bool:
    digits = (word for word in words if is_number(word))
    return len(words) <= _FEW_ANSWERS and all(len(each) <= _DIGITS for each in digits)


_FEW_ANSWERS, _DIGITS = 11, 3


def _last_word(heading: str) -> str:
    """Return a heading, or the inner one of ``outer.inner``."""
    return plain(heading.rsplit(".", 1)[-1])


def _is_response(table: SourceTable, column: int, heading: str, vocabulary: LabVocabulary) -> bool:
    words = texts(table, column)
    labelled = _last_word(heading) in vocabulary.response_labels
    if not words or (len(words) > 110 and not labelled):
        return False
    known = sum(is_number(word) or plain(word) in vocabulary.severity for word in words)
    return known * 2 >= len(words) or labelled


def _instrument_column(
    table: SourceTable, instrument: Instrument, item_column: int
) -> tuple[int, str] | None:
    for column in range(len(table.headings)):
        if column != item_column:
            words = texts(table, column)
            if len(words) <= 8:
                for word in words:
                    if plain(word) in {
                        plain(instrument.name),
                        plain(instrument.short),
                        plain(instrument.title),
                    }:
                        return column, word
    return None


@dataclass(frozen=True)
class FoundRating(FoundAnswers):
    """A column of ratings, and that of the seconds at which they were given."""

    column: int
    time: int | None

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
    ratings = _ratings(table, columns, known)
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
    time = _time_column(table, [c for c in columns if c not in totals], known.vocabulary)
    if not table.reading.heading_rows:
        return _beside_their_time(table, columns, time, known)
    found = []
    for instrument in known.instruments:
        if len(instrument.asked) == 1:
            named = [c for c in columns if _is_rating(table, c, instrument)]
            own = {plain(instrument.name), "score", "rating", *map(plain, instrument.title.split())}
            for column in named:
                rest = tuple(w for w in tokens(table.headings[column]) if w not in own)
                found.append(FoundRating(instrument, rest, column, time))
    return found


def _time_column(
    table: SourceTable, columns: Sequence[int], vocabulary: LabVocabulary
) -> int | None:
    """Return the column of the seconds of ratings: by its heading, or one of times that rise."""
    named = [c for c in columns if plain(table.headings[c]) in vocabulary.seconds]
    if named:
        return named[0]
    headed = bool(table.reading.heading_rows)
    rising = [
        c
        for c in columns
        if (not headed or {*tokens(table.headings[c])} & vocabulary.time_words) and _rises(table, c)
    ]
    return rising[0] if len(rising) == 1 or (rising and not headed) else None


def _rises(table: SourceTable, column: int) -> bool:
    """Return whether numbers rise from row to row, but where another exposure begins."""
    values = _values(table, column)
    whole = len(values) == len(table.rows) > _FEWEST_RISING
    steps = np.diff(values) if whole else np.zeros(1)
    return bool((steps > 0).mean() >= _RISING)


_FEWEST_RISING, _RISING = 5, 0.8
"""Rows, and the share of steps upwards, of a column of times."""


def _beside_their_time(
    table: SourceTable, columns: Sequence[int], time: int | None, known: Known
) -> list[FoundRating]:
    """Return the ratings of a log without headings, whose file names the scale: time and rating."""
    said = mentions(f"{table.file.stem} {table.sheet}", known.instruments)
    scales = [i for i in known.instruments if i.name in said and len(i.asked) == 1]
    others = [c for c in columns if c != time]
    if time is None or len(scales) != 1 or len(others) != 1:
        return []
    (scale,), (column,) = scales, others
    inside = all(map(scale.answers.has, _values(table, column)))
    return [FoundRating(scale, (), column, time)] if inside else []


def _is_rating(table: SourceTable, column: int, instrument: Instrument) -> bool:
    words = tokens(table.headings[column])
    keys = {plain(instrument.name), plain(instrument.title)}
    named = plain(table.headings[column]) in keys or (
        plain(instrument.name) in words and len(words) <= 5
    )
    if not named:
        return False
    cells = [cell.replace(",", ".") for cell in table.column(column) if cell]
    values = [number(cell, ".") for cell in cells]
    inside = [v for v in values if v is not None and instrument.low <= v <= instrument.high]
    # Means of ratings stand under the scale's name, too, and most are no answers of it.
    return bool(inside) and sum(map(instrument.answers.has, inside)) * 10 >= len(inside) * 7


FEWEST_TIMES = 3
"""Columns of one scale that differ in a number alone and are a time course of ratings."""


def _times_of(
    table: SourceTable, ratings: Sequence[FoundRating], vocabulary: LabVocabulary
) -> list[list[FoundRating]]:
    """Return the time courses, but for ratings whose numbers are those of conditions beside."""
    numbered = numbered_conditions(table, vocabulary)
    return [
        course
        for course in _courses_of(ratings, vocabulary.units)
        if not fitting([number_in_words(each.context) for each in course], numbered)
    ]


def _courses_of(ratings: Sequence[FoundRating], units: Set[str]) -> list[list[FoundRating]]:
    """Group ratings by headings that differ in one number alone, such as ``FMS_1 min``."""
    groups: dict[tuple[str, ...], list[FoundRating]] = {}
    for rating in ratings:
        place = _time_in(rating.context, units)
        if rating.time is None and place is not None:
            rest = tuple("#" if n == place else word for n, word in enumerate(rating.context))
            groups.setdefault((rating.instrument.name, *rest), []).append(rating)
    return [group for group in groups.values() if len(group) >= FEWEST_TIMES]


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
        and _values(table, column)
    ]
    if not found:
        return _left_in_words(table, columns, known.vocabulary)
    headings = [table.headings[column] for column in found]
    minutes = any({*tokens(heading)} & _MINUTES for heading in headings)
    unit: Literal["s", "min"] = "min" if minutes else "s"
    if len(found) == 1:
        return FoundLeaving({found[0]: ""}, headings[0], unit)
    start, end = _common_start(headings), _common_start([each[::-1] for each in headings])[::-1]
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


_MINUTES = frozenset(["min", "mins", "minute", "minutes", "minuten"])


def _within(label: Sequence[str], words: Sequence[str]) -> bool:
    return any([*words[n : n + len(label)]] == [*label] for n in range(len(words)))


def _common_start(texts: Sequence[str]) -> str:
    same = takewhile(lambda letters: len({*letters}) == 1, zip(*texts, strict=False))
    return "".join(letters[0] for letters in same)


@dataclass(frozen=True)
class FoundScores(FoundAnswers):
    """Columns that hold scores of one administration.

    Parameters
    ----------
    scales
        Scale → index of its column.
    """

    scales: dict[str, int]

    @property
    def columns(self) -> list[int]:
        """Return the indices of the columns."""
        return [*self.scales.values()]


def find_scores(table: SourceTable, columns: Sequence[int], known: Known) -> list[FoundScores]:
    """Return the columns of scores by the scales in their headings: a total, or at least two."""
    found: list[FoundScores] = []
    left = list(columns)
    named = mentions(
        f"{table.file.stem} {table.sheet} {' '.join(table.headings)}", known.instruments
    )
    for instrument in sorted(
        known.instruments, key=lambda each: (each.name not in named, each.name != "ssq")
    ):
        if len(instrument.asked) > 1:
            own = _of_instrument(table, left, instrument, known.vocabulary)
            left = [c for c in left if all(c not in each.scales.values() for each in own)]
            found += own
    return found


def _of_instrument(
    table: SourceTable, columns: Sequence[int], instrument: Instrument, vocabulary: LabVocabulary
) -> list[FoundScores]:
    words = _scale_words(instrument, vocabulary)
    fillers = vocabulary.scale_fillers
    groups: dict[tuple[str, ...], dict[str, int]] = {}
    for column in columns:
        named = _scale(table.headings[column], instrument, words, fillers)
        named = named or _bare_total(table, column, instrument)
        measured = {*tokens(table.headings[column])} & vocabulary.measures
        if named is not None and not measured and _numeric(table, column):
            scale, context = named
            groups.setdefault(context, {}).setdefault(scale, column)
    most = max(map(len, groups.values()), default=0)
    return [
        FoundScores(instrument, context, scales)
        for context, scales in groups.items()
        if _is_sure(table, instrument, scales) and _is_like(table, instrument, scales, most)
    ]


def _is_like(
    table: SourceTable, instrument: Instrument, scales: Mapping[str, int], most: int
) -> bool:
    """Return whether a group has the scales of the largest one, or names the instrument itself.

    Beside N, O, D and T, a single column called ``Overall …`` is something else.
    """
    names = " ".join(table.headings[column] for column in scales.values())
    return most < _WHOLE or len(scales) > 1 or instrument.name in mentions(names, [instrument])


_WHOLE = 3


def _scale_words(instrument: Instrument, vocabulary: LabVocabulary) -> dict[str, str]:
    """Return word → scale: its name, title and column, and the vocabulary's words for it."""
    words = {
        plain(word): scale.name
        for scale in instrument.scales
        if not scale.alone
        for word in (scale.name, scale.title, scale.column)
    }
    return {**vocabulary.scales.get(instrument.name, {}), **words}


def _scale(
    heading: str, instrument: Instrument, words: Mapping[str, str], fillers: Set[str]
) -> tuple[str, tuple[str, ...]] | None:
    """Return the scale that a heading names, and its other words."""
    own = {plain(instrument.name), *tokens(instrument.short)}
    rest = [word for word in tokens(heading) if word not in fillers and word not in own]
    if not rest:
        said = set(tokens(heading))
        return (instrument.primary, ()) if said & own and said & {*fillers, "total"} else None
    for word in sorted(rest, key=len, reverse=True):
        if word in words:
            others = list(rest)
            others.remove(word)
            return words[word], tuple(w for w in others if w != "total")
    return None


def _bare_total(
    table: SourceTable, column: int, instrument: Instrument
) -> tuple[str, tuple[str, ...]] | None:
    """Return the primary scale for ``SSQ 2`` or ``SSQ post`` whose values are scores of it."""
    words = tokens(table.headings[column])
    own = {plain(instrument.name), *tokens(instrument.short)}
    scale = scale_named(instrument, instrument.primary)
    if words[:1] != [plain(instrument.name)] or len(words) > _MOST_WORDS or scale is None:
        return None
    values = _values(table, column)
    steps = [on_scale(value, scale, "score") is not None for value in values]
    above = any(value > instrument.high and not value.is_integer() for value in values)
    if not above or not all(steps):
        return None
    return instrument.primary, tuple(word for word in words if word not in own)


_MOST_WORDS = 3
"""Of a heading that names an instrument and no scale."""


def _is_sure(table: SourceTable, instrument: Instrument, scales: Mapping[str, int]) -> bool:
    """Return whether these are scores, and not columns that happen to be called N or O."""
    names = [table.headings[column] for column in scales.values()]
    places = (*names, table.file.stem, table.sheet)
    said = any(instrument.name in mentions(name, [instrument]) for name in places)
    single = all(len("".join(tokens(name))) < 3 for name in names)
    if single:
        return len(scales) >= 3
    return said or len(scales) >= 2


def rise_from_first(table: SourceTable, found: Sequence[FoundScores]) -> bool:
    """Return whether scores of the first administration are half of the later ones, or less.

    So they are before exposure: the numbers in such headings are timepoints, no conditions.
    """
    numbered = sorted(found, key=lambda each: [int(w) for w in each.context if w.isdecimal()])
    values = [[v for c in each.columns for v in _values(table, c)] for each in numbered]
    if len(values) < 2 or not all(values):
        return False
    first, *later = (float(np.mean(each)) for each in values)
    return 2 * first <= max(later)


def _numeric(table: SourceTable, column: int) -> bool:
    cells = [cell for cell in table.column(column) if cell]
    values = [number(cell, table.reading.decimal or ".") for cell in cells]
    return sum(value is not None for value in values) * 10 >= len(values) * 8 > 0


def by_kind(table: SourceTable, found: FoundScores) -> dict[ScoreKind, FoundScores]:
    """Return the kind of scores: ``score``, ``raw_sum``, both in two parts, or else ``other``.

    Labs write raw sums of the subscales beside a weighted total.
    """
    whole = kind_of(table, found)
    if whole != "other":
        return {whole: found}
    kinds: dict[ScoreKind, dict[str, int]] = {}
    for scale, column in found.scales.items():
        kinds.setdefault(_likelier(table, found, scale), {})[scale] = column
    if "other" in kinds:
        return {whole: found}
    return {kind: replace(found, scales=scales) for kind, scales in kinds.items()}


def _likelier(table: SourceTable, found: FoundScores, scale: str) -> ScoreKind:
    return kind_of(table, replace(found, scales={scale: found.scales[scale]}))


def kind_of(table: SourceTable, found: FoundScores) -> ScoreKind:
    """Return ``score`` or ``raw_sum`` where all values can be that, else ``other``."""
    for kind in _KINDS:
        if all(
            on_scale(value, scale, kind) is not None
            for name, column in found.scales.items()
            if (scale := scale_named(found.instrument, name)) is not None
            for value in _values(table, column)
        ):
            return kind
    return "other"


_KINDS: tuple[ScoreKind, ...] = ("score", "raw_sum")


def _values(table: SourceTable, column: int) -> list[float]:
    read = [number(cell, table.reading.decimal or ".") for cell in table.column(column) if cell]
    return [value for value in read if value is not None]


def parts_of(
    values: Sequence[float | None], columns: Mapping[str, Sequence[float | None]]
) -> list[str] | None:
    """Return the columns of which another is exactly the (weighted) sum, None where it is none.

    Each part counts once or twice, times one weight for all. Rows with a blank are left out. The
    answer is None, too, where there are too few different rows to tell.
    """
    names = list(columns)
    rows = [
        (value, [columns[name][place] for name in names])
        for place, value in enumerate(values)
        if value is not None and all(columns[name][place] is not None for name in names)
    ]
    if len(rows) < 3 or not names:
        return None
    target = np.array([value for value, _ in rows], dtype=float)
    parts = np.array([cells for _, cells in rows], dtype=float)
    whole = parts.sum(axis=1)
    if len(names) > 2 and whole.any() and np.allclose(whole, target, atol=1e-6):
        return names
    used = [i for i in range(len(names)) if np.ptp(parts[:, i]) > 0]
    if len(used) < 2 or not target.any() or np.linalg.matrix_rank(parts[:, used]) < len(used):
        return None
    found, *_ = np.linalg.lstsq(parts[:, used], target, rcond=None)
    counted = found[np.abs(found) > 1e-6]
    if len(counted) < 2 or not np.allclose(parts[:, used] @ found, target, atol=0.02):
        return None
    # Raw sums count an item once or twice, in two subscales; other weights are chance fits.
    steps = counted / counted.min() if counted.min() > 0 else np.array([0.5])
    if not np.allclose(steps, np.round(steps), atol=0.02) or steps.max() > 2.1:
        return None
    return [names[used[i]] for i, each in enumerate(found) if abs(each) > 1e-6]
