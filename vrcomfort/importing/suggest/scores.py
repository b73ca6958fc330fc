"""Finds columns of sums and scores: by their headings, and by what they are the sum of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vrcomfort.importing.answers import number
from vrcomfort.importing.mapping import ScoreKind, scale_named
from vrcomfort.importing.score_instruments import on_scale
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.headings import mentions, tokens
from vrcomfort.importing.suggest.vocabulary import SCALE_WORDS
from vrcomfort.questionnaire import Instrument, plain

_NOISE = frozenset(
    ["score", "scores", "scored", "weighted", "raw", "sum", "sums", "subscale", "scale", "symptoms",
     "symptom", "value", "subscore", "factor", "cluster"]
)  # fmt: skip


@dataclass(frozen=True)
class FoundScores:
    """Columns that hold scores of one moment.

    Parameters
    ----------
    scales
        Scale → index of its column.
    """

    instrument: Instrument
    context: tuple[str, ...]
    scales: dict[str, int]


def find_scores(
    table: SourceTable, columns: Sequence[int], known: Sequence[Instrument]
) -> list[FoundScores]:
    """Return the columns whose headings name scales: a total, or at least two."""
    found: list[FoundScores] = []
    left = list(columns)
    named = mentions(f"{table.file.stem} {table.sheet} {' '.join(table.headings)}", known)
    for instrument in sorted(known, key=lambda each: (each.name not in named, each.name != "ssq")):
        if len(instrument.asked) > 1:
            own = _of_instrument(table, left, instrument)
            left = [c for c in left if all(c not in each.scales.values() for each in own)]
            found += own
    return found


def _of_instrument(
    table: SourceTable, columns: Sequence[int], instrument: Instrument
) -> list[FoundScores]:
    words = _scale_words(instrument)
    groups: dict[tuple[str, ...], dict[str, int]] = {}
    for column in columns:
        named = _scale(table.headings[column], instrument, words)
        if named is not None and _numeric(table, column):
            scale, context = named
            groups.setdefault(context, {}).setdefault(scale, column)
    return [
        FoundScores(instrument, context, scales)
        for context, scales in groups.items()
        if _is_sure(table, instrument, scales)
    ]


def _scale_words(instrument: Instrument) -> dict[str, str]:
    """Return word → scale: its name, title and column, and what labs call it else."""
    words = {
        plain(word): scale.name
        for scale in instrument.scales
        if not scale.alone
        for word in (scale.name, scale.title, scale.column)
    }
    return {**SCALE_WORDS.get(instrument.name, {}), **words}


def _scale(
    heading: str, instrument: Instrument, words: Mapping[str, str]
) -> tuple[str, tuple[str, ...]] | None:
    """Return the scale that a heading names, and its other words."""
    own = {plain(instrument.name), *tokens(instrument.short)}
    rest = [word for word in tokens(heading) if word not in _NOISE and word not in own]
    if not rest:
        said = set(tokens(heading))
        return (instrument.primary, ()) if said & own and said & {*_NOISE, "total"} else None
    for word in sorted(rest, key=len, reverse=True):
        if word in words:
            others = list(rest)
            others.remove(word)
            return words[word], tuple(w for w in others if w != "total")
    return None


def _is_sure(table: SourceTable, instrument: Instrument, scales: Mapping[str, int]) -> bool:
    """Return whether these are scores, and not columns that happen to be called N or O."""
    names = [table.headings[column] for column in scales.values()]
    places = (*names, table.file.stem, table.sheet)
    said = any(instrument.name in mentions(name, [instrument]) for name in places)
    single = all(len("".join(tokens(name))) < 3 for name in names)
    if single:
        return len(scales) >= 3
    return said or len(scales) >= 2


def _numeric(table: SourceTable, column: int) -> bool:
    cells = [cell for cell in table.column(column) if cell]
    values = [number(cell, table.reading.decimal or ".") for cell in cells]
    return sum(value is not None for value in values) * 10 >= len(values) * 8 > 0


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
    steps = counted / counted.min() if counted.min() > 0 else np.array([0.5])
    if not np.allclose(steps, np.round(steps), atol=0.02) or steps.max() > 2.1:
        return None
    return [names[used[i]] for i, each in enumerate(found) if abs(each) > 1e-6]
