"""Scales: how answers become scores, in whole numbers.

Every score is a whole number (`raw`) of steps of one size (`unit`), an exact fraction. Weighted
sums in floating point break ties that the answers have: rank the raw numbers, and multiply by the
unit afterwards. Where no item is missing, raw is the raw sum of the papers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import gcd, lcm
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Integers = NDArray[np.int64]
    Booleans = NDArray[np.bool_]


@dataclass(frozen=True)
class Term:
    """The term of an item in a raw sum: `slope` for each step of its answer, and `intercept`."""

    item: str
    slope: int
    intercept: int


@dataclass(frozen=True)
class Scale:
    """A score of an instrument; see `vrcomfort.questionnaire.scale_file` for how one is written.

    Parameters
    ----------
    name
        As plans call it: T, N.
    title
        As readers know it: Nausea.
    column
        Its heading in tables of scores: nausea.
    unit
        Points per raw step.
    low, high
        The lowest and the highest score.
    terms
        What its items add, if it is a sum of answers.
    parts
        What it is made of otherwise: scale → raw steps per raw step of that scale.
    min_valid
        How many items must be answered; the mean of the others stands for what is missing.
    weights
        Item → the item that says how much it counts for this person.
    weights_sum
        What those add up to; 0 where they may add up to anything.
    alone
        An item that no other scale counts.
    """

    name: str
    title: str
    column: str
    unit: Fraction
    low: Fraction
    high: Fraction
    terms: tuple[Term, ...] = ()
    parts: tuple[tuple[str, int], ...] = ()
    min_valid: int = 0
    weights: tuple[tuple[str, str], ...] = ()
    weights_sum: int = 0
    alone: bool = False

    @cached_property
    def weight(self) -> float:
        """Return the points per raw step."""
        return float(self.unit)

    def points(self, raw: int) -> float:
        """Return the score of a raw number: the float64 nearest to the exact product."""
        return float(raw * self.unit)

    @property
    def stretch(self) -> dict[int, int]:
        """Return number of answered items → factor of their sum."""
        return stretch(len(self.terms), self.min_valid)


def stretch(items: int, min_valid: int) -> dict[int, int]:
    """Return number of answered items → whole number in the proportion of items / answered.

    1 for all items where all are needed.
    """
    counts = range(min_valid, items + 1)
    whole = lcm(*counts)
    found = {count: items * whole // count for count in counts}
    shared = gcd(*found.values())
    return {count: number // shared for count, number in found.items()}


@dataclass(frozen=True)
class RawScores:
    """Raw numbers of many questionnaires.

    Parameters
    ----------
    raw
        Scale → shape (n,); 0 where it is not known.
    known
        Scale → shape (n,): whether enough was answered.
    """

    raw: Mapping[str, Integers]
    known: Mapping[str, Booleans]


@dataclass(frozen=True)
class AnswerTable:
    """Answers of many questionnaires, in steps.

    Parameters
    ----------
    steps
        Item → answers in steps, shape (n,); 0 where there is none.
    given
        Item → shape (n,): whether there is one.
    """

    steps: Mapping[str, Integers]
    given: Mapping[str, Booleans]


def raw_scores(scales: Iterable[Scale], table: AnswerTable) -> RawScores:
    """Score every scale; a scale of others comes after them."""
    raw: dict[str, Integers] = {}
    known: dict[str, Booleans] = {}
    for scale in scales:
        if scale.parts:
            raw[scale.name] = _total([raw[name] * n for name, n in scale.parts])
            known[scale.name] = np.logical_and.reduce([known[name] for name, _ in scale.parts])
        elif scale.weights:
            raw[scale.name], known[scale.name] = _weighted(scale, table)
        else:
            raw[scale.name], known[scale.name] = _sum(scale, table)
        raw[scale.name] = np.where(known[scale.name], raw[scale.name], 0)
    return RawScores(raw, known)


def _sum(scale: Scale, table: AnswerTable) -> tuple[Integers, Booleans]:
    answered = _total([table.given[term.item].astype(np.int64) for term in scale.terms])
    added = _total([_added(term, table) for term in scale.terms])
    enough = answered >= scale.min_valid
    factors = np.zeros(len(scale.terms) + 1, dtype=np.int64)
    for count, factor in scale.stretch.items():
        factors[count] = factor
    return added * factors[answered], enough


def _weighted(scale: Scale, table: AnswerTable) -> tuple[Integers, Booleans]:
    by = dict(scale.weights)
    products = [_added(term, table) * table.steps[by[term.item]] for term in scale.terms]
    needed = [name for term in scale.terms for name in (term.item, by[term.item])]
    return _total(products), np.logical_and.reduce([table.given[name] for name in needed])


def _added(term: Term, table: AnswerTable) -> Integers:
    added: Any = table.steps[term.item] * term.slope + term.intercept
    return np.asarray(np.where(table.given[term.item], added, 0), dtype=np.int64)


def _total(columns: Sequence[Integers]) -> Integers:
    return np.asarray(np.add.reduce(columns, dtype=np.int64))
