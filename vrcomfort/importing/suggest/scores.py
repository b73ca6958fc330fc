"""Finds columns of sums and scores: by their headings, and by what they are the sum of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vrcomfort.importing.answers import number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.headings import tokens
from vrcomfort.importing.suggest.vocabulary import SCALE_WORDS

_NOISE = frozenset(
    ["score", "scores", "scored", "weighted", "raw", "sum", "sums", "subscale", "scale", "symptoms",
     "symptom", "value", "subscore", "factor", "cluster"]
)  # fmt: skip
_WEIGHTS: Mapping[str, Mapping[str, float]] = {"ssq": {"N": 9.54, "O": 7.58, "D": 13.92, "T": 3.74}}


@dataclass(frozen=True)
class FoundScores:
    """Columns that hold scores of one moment.

    Parameters
    ----------
    scales
        Scale → index of its column.
    """

    instrument: str
    context: tuple[str, ...]
    scales: dict[str, int]


def find_scores(table: SourceTable, columns: Sequence[int]) -> list[FoundScores]:
    """Return the columns whose headings name scales: a total, or at least two."""
    groups: dict[tuple[str, tuple[str, ...]], dict[str, int]] = {}
    for column in columns:
        for instrument, words in SCALE_WORDS.items():
            named = _scale(table.headings[column], instrument, words)
            if named is not None and _numeric(table, column):
                scale, context = named
                groups.setdefault((instrument, context), {}).setdefault(scale, column)
    return [
        FoundScores(instrument, context, scales)
        for (instrument, context), scales in groups.items()
        if _is_sure(table, instrument, scales)
    ]


def _scale(
    heading: str, instrument: str, words: Mapping[str, str]
) -> tuple[str, tuple[str, ...]] | None:
    """Return the scale that a heading names, and its other words."""
    rest = [word for word in tokens(heading) if word not in _NOISE and word != instrument]
    if not rest:
        said = set(tokens(heading))
        return ("T", ()) if instrument in said and said & _NOISE else None
    for word in sorted(rest, key=len, reverse=True):
        if word in words:
            others = list(rest)
            others.remove(word)
            return words[word], tuple(w for w in others if w not in {"total", "ssq"})
    return None


def _is_sure(table: SourceTable, instrument: str, scales: Mapping[str, int]) -> bool:
    """Return whether these are scores, and not columns that happen to be called N or O."""
    names = [table.headings[column] for column in scales.values()]
    said = any(instrument in tokens(name) for name in (*names, table.file.stem, table.sheet))
    single = all(len("".join(tokens(name))) < 3 for name in names)
    if single:
        return len(scales) >= 3
    return said or len(scales) >= 2


def _numeric(table: SourceTable, column: int) -> bool:
    cells = [cell for cell in table.column(column) if cell]
    values = [number(cell, table.reading.decimal or ".") for cell in cells]
    return sum(value is not None for value in values) * 10 >= len(values) * 8 > 0


def kind_of(table: SourceTable, found: FoundScores) -> str:
    """Return ``score`` where values are multiples of the weights, ``raw_sum`` where whole."""
    weights = _WEIGHTS[found.instrument]
    weighted = whole = 0
    for scale, column in found.scales.items():
        for value in _values(table, column):
            if value:
                steps = value / weights[scale]
                weighted += abs(steps - round(steps)) * weights[scale] < 0.0251
                whole += value.is_integer()
    return "score" if weighted >= whole else "raw_sum"


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
