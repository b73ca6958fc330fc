"""Finds columns of scores whose answers may not be there, and sums of others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np

from vrcomfort.importing.made_instruments import on_scale
from vrcomfort.importing.mapping import ScoreKind, scale_named
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.block_conditions import numbers_in_words
from vrcomfort.importing.suggest.cells import texts, values_of
from vrcomfort.importing.suggest.found_answers import FoundAnswers, mentions, named_by_file
from vrcomfort.importing.suggest.heading_roles import roles_of
from vrcomfort.importing.suggest.vocabulary import Known, LabVocabulary, tokens
from vrcomfort.questionnaire import Instrument, plain


@dataclass(frozen=True)
class FoundScores(FoundAnswers):
    """Columns that hold scores of one administration.

    Parameters
    ----------
    scales
        Scale → index of its column.
    where
        In tables with a row for each scale: the column that names the scale, and the text there.
    """

    scales: dict[str, int]
    where: tuple[int, str] | None = None

    @property
    def columns(self) -> list[int]:
        """Return the indices of the columns."""
        return [*self.scales.values(), *([] if self.where is None else self.where[:1])]

    def rows(self, table: SourceTable) -> SourceTable:
        """Return the table with the rows of these scores alone."""
        if self.where is None:
            return table
        column, text = self.where
        return replace(table, rows=tuple(row for row in table.rows if row[column] == text))


def find_scores(table: SourceTable, columns: Sequence[int], known: Known) -> list[FoundScores]:
    """Return the columns of scores by the scales in their headings: a total, or at least two."""
    if tidy := _in_rows(table, columns, known):
        return tidy
    found: list[FoundScores] = []
    left = list(columns)
    named = named_by_file(table, known.instruments, *table.headings)
    for instrument in sorted(
        known.instruments, key=lambda each: (each.name not in named, each.name != "ssq")
    ):
        if len(instrument.asked) > 1:
            own = _of_instrument(table, left, instrument, known.vocabulary)
            left = [c for c in left if all(c not in each.scales.values() for each in own)]
            found += own
    return found or _by_condition(table, left, known)


def _in_rows(table: SourceTable, columns: Sequence[int], known: Known) -> list[FoundScores]:
    """Return the scores of a table with a row for each scale, which a column names."""
    labels = known.vocabulary.response_labels
    values = [c for c in columns if plain(table.headings[c]) in labels and _numeric(table, c)]
    named = named_by_file(table, known.instruments, *table.headings)
    for column in columns if len(values) == 1 else ():
        names = texts(table, column)
        if column in values or not _FEWEST_NAMED <= len(names) <= _MOST_SCALES:
            continue
        for instrument in known.instruments:
            words = _scale_words(instrument, known.vocabulary)
            of = {t: _scale(t, instrument, words, known.vocabulary.scale_fillers) for t in names}
            scales = {text: found[0] for text, found in of.items() if found and not found[1]}
            said = instrument.name in named or any(mentions(text, [instrument]) for text in names)
            sure = said or all(len(text) > 2 for text in names)
            if sure and len({*scales.values()}) == len(names):
                return [
                    FoundScores(instrument, (), {scale: values[0]}, (column, text))
                    for text, scale in scales.items()
                ]
    return []


_MOST_SCALES = 8


def _by_condition(table: SourceTable, columns: Sequence[int], known: Known) -> list[FoundScores]:
    """Return columns of totals that are called after their conditions, in a file called ``SUS``.

    None is called after a person, a covariate or a measure, and all numbers can be totals.
    """
    said = named_by_file(table, known.instruments)
    named = [each for each in known.instruments if each.name in said and len(each.asked) > 1]
    words = {word for heading in table.headings for word in (plain(heading), *tokens(heading))}
    if {word for word in words if len(word) > 1} & {*map(plain, known.vocabulary.totals)}:
        return []  # means and deviations
    for instrument in named if len(named) == 1 else ():
        free = [c for c in roles_of(table, columns, known.vocabulary).unknown if texts(table, c)]
        free = [c for c in free if not {*tokens(table.headings[c])} & known.vocabulary.performance]
        totals = [c for c in free if _are_totals(table, c, instrument)]
        if len(totals) < len(free) and instrument.answers.step < 1:
            return []  # any number can be a total: these may be anything
        values = [value for column in totals for value in values_of(table, column)]
        above = sum(value > instrument.high or not value.is_integer() for value in values)
        contexts = [tuple(tokens(table.headings[column])) for column in totals]
        if _has_items_in_rows(table, instrument, known.vocabulary):
            return []
        if len(totals) > 1 and above * 2 > len(values) and all(contexts):
            scale = instrument.primary
            return [
                FoundScores(instrument, context, {scale: column})
                for context, column in zip(contexts, totals, strict=True)
            ]
    return []


def _has_items_in_rows(
    table: SourceTable, instrument: Instrument, vocabulary: LabVocabulary
) -> bool:
    """Return whether the rows are items or scales, and not people."""
    known = {*vocabulary.spellings(instrument), *_scale_words(instrument, vocabulary)}
    columns = (texts(table, column) for column in range(len(table.headings)))
    return any(sum(plain(text) in known for text in each) >= _FEWEST_NAMED for each in columns)


_FEWEST_NAMED = 3


def _are_totals(table: SourceTable, column: int, instrument: Instrument) -> bool:
    """Return whether all cells of a column are numbers that a total can be."""
    count, cells = len(values_of(table, column)), table.column(column)
    whole = count >= max(2, len(cells) - cells.count(""))
    return whole and _scored(table, column, instrument.primary, instrument) == 1


def _of_instrument(
    table: SourceTable, columns: Sequence[int], instrument: Instrument, vocabulary: LabVocabulary
) -> list[FoundScores]:
    words = _scale_words(instrument, vocabulary)
    fillers, measures = vocabulary.scale_fillers, vocabulary.measures | vocabulary.performance
    groups: dict[tuple[str, ...], dict[str, int]] = {}
    for column in columns:
        named = _scale(table.headings[column], instrument, words, fillers)
        named = named or _bare_total(table, column, instrument)
        named = named or _of_file(table, column, instrument, fillers)
        measured = {*tokens(table.headings[column])} & measures
        if named is not None and not measured and _numeric(table, column):
            scale, context = named
            there = groups.setdefault(context, {})
            if _scored(table, column, scale, instrument) > _scored(
                table, there.get(scale), scale, instrument
            ):
                there[scale] = column
    most = max(map(len, groups.values()), default=0)
    return [
        FoundScores(instrument, context, scales)
        for context, scales in groups.items()
        if _is_sure(table, instrument, scales) and _is_like(table, instrument, scales, most)
    ]


def _scored(table: SourceTable, column: int | None, name: str, instrument: Instrument) -> float:
    """Return the share of a column's numbers that are scores of a scale; −1 of no column."""
    scale = scale_named(instrument, name)
    values = values_of(table, column) if column is not None else []
    if column is None or scale is None:
        return -1.0
    return sum(on_scale(v, scale, "score") is not None for v in values) / max(len(values), 1)


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
    for word in sorted(rest, key=lambda word: (word not in _WHOLES, -len(word))):
        if word in words:
            others = list(rest)
            others.remove(word)
            return words[word], tuple(w for w in others if w != "total")
    return None


_WHOLES = frozenset(["total", "overall"])
"""Words for the total, which win over words for other scales."""


def _bare_total(
    table: SourceTable, column: int, instrument: Instrument
) -> tuple[str, tuple[str, ...]] | None:
    """Return the primary scale for ``SSQ 2`` or ``Tunnel / SUS`` whose values are its scores."""
    words = tokens(table.headings[column])
    own = {plain(instrument.name), *tokens(instrument.short)}
    if plain(instrument.name) not in {*words[:1], *words[-1:]} or len(words) > _MOST_WORDS:
        return None
    values = values_of(table, column)
    above = any(value > instrument.high and not value.is_integer() for value in values)
    if not above or _scored(table, column, instrument.primary, instrument) < 1:
        return None
    return instrument.primary, tuple(word for word in words if word not in own)


def _of_file(
    table: SourceTable, column: int, instrument: Instrument, fillers: Set[str]
) -> tuple[str, tuple[str, ...]] | None:
    """Return the primary scale for ``Score`` alone in a file that is called ``SUS``."""
    bare = {*tokens(table.headings[column])} <= {*fillers, "total"} - {"value"}
    said = instrument.name in named_by_file(table, [instrument])
    if not bare or not said:
        return None
    above = any(value > instrument.high for value in values_of(table, column))
    scored = _scored(table, column, instrument.primary, instrument)
    return (instrument.primary, ()) if above and scored >= _MOST_SCORED else None


_MOST_WORDS, _MOST_SCORED = 3, 0.8
"""Of a heading that names an instrument and no scale."""


def _is_sure(table: SourceTable, instrument: Instrument, scales: Mapping[str, int]) -> bool:
    """Return whether these are scores, and not columns that happen to be called N or O."""
    names = [table.headings[column] for column in scales.values()]
    said = bool(named_by_file(table, [instrument], *names))
    single = all(len("".join(tokens(name))) < 3 for name in names)
    if single:
        return len(scales) >= 3
    several = sum(not each.alone for each in instrument.scales)
    return said or (len(scales) >= 2 and 2 * len(scales) >= several)


def rise_from_first(table: SourceTable, found: Sequence[FoundScores]) -> bool:
    """Return whether scores of the first administration are half of the later ones, or less.

    So they are before exposure: the numbers in such headings are timepoints, no conditions.
    """
    numbered = sorted(found, key=lambda each: numbers_in_words(each.context))
    values = [[v for c in each.columns for v in values_of(table, c)] for each in numbered]
    if len(values) < 2 or not all(values):
        return False
    first, *later = (float(np.mean(each)) for each in values)
    return 2 * first <= max(later)


def weighted(found: FoundScores) -> FoundScores:
    """Return scores beside products of answers and weights: their totals are weighted ones."""
    names = {scale.name for scale in found.instrument.scales if scale.weights_sum}
    if not names or {*found.scales} != {found.instrument.primary}:
        return found
    return replace(found, scales={min(names): column for column in found.columns})


def _numeric(table: SourceTable, column: int) -> bool:
    filled = sum(map(bool, table.column(column)))
    return len(values_of(table, column)) * 10 >= filled * 8 > 0


def by_kind(table: SourceTable, found: FoundScores) -> dict[ScoreKind, FoundScores]:
    """Return the kind of scores: ``score``, ``raw_sum``, both in two parts, or else ``other``.

    Labs write raw sums of the subscales beside a weighted total.
    """
    whole = kind_of(table, found)
    if whole != "other":
        return {whole: found}
    kinds: dict[ScoreKind, dict[str, int]] = {}
    for scale, column in found.scales.items():
        kind = kind_of(table, replace(found, scales={scale: column}))
        kinds.setdefault(kind, {})[scale] = column
    if "other" in kinds:
        return {whole: found}
    return {kind: replace(found, scales=scales) for kind, scales in kinds.items()}


def kind_of(table: SourceTable, found: FoundScores) -> ScoreKind:
    """Return ``score`` or ``raw_sum`` where all values can be that, else ``other``."""
    own = found.rows(table)
    for kind in _KINDS:
        if all(
            on_scale(value, scale, kind) is not None
            for name, column in found.scales.items()
            if (scale := scale_named(found.instrument, name)) is not None
            for value in values_of(own, column)
        ):
            return kind
    return "other"


_KINDS: tuple[ScoreKind, ...] = ("score", "raw_sum")


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
