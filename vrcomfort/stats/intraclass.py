"""Intraclass correlations: how much of the variance lies between people (Shrout & Fleiss 1979)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import f as f_distribution

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

ROUNDING = 1e-12
"""Share of the sum of squares below which an error is rounding."""


@dataclass(frozen=True)
class Intraclass:
    """One of the six forms, with its F test and interval (McGraw & Wong 1996)."""

    form: str
    """1,1 one-way; 2,1 two-way, agreement; 3,1 two-way, consistency; k: of the mean of k."""
    estimate: float
    low: float
    high: float
    f: float
    df_effect: int
    df_error: int
    p: float
    confidence: float


def intraclass(scores: ArrayLike, *, confidence: float = 0.95) -> tuple[Intraclass, ...]:
    """Return ICC(1,1), (2,1), (3,1), (1,k), (2,k) and (3,k) of people × occasions.

    Raises
    ------
    InputError
        With fewer than two people or occasions, or without any variance left for an error.
    """
    values = np.asarray(scores, dtype=np.float64)
    if values.ndim != 2 or min(values.shape) < 2:
        raise InputError("an intraclass correlation needs two people and two occasions")
    squares = _MeanSquares.of(values)
    return tuple(
        each(squares, mean=mean, confidence=confidence)
        for mean in (False, True)
        for each in (_one_way, _agreement, _consistency)
    )


@dataclass(frozen=True)
class _MeanSquares:
    n: int
    k: int
    people: float
    occasions: float
    within: float
    """Of people: occasions and error together."""
    error: float

    @classmethod
    def of(cls, values: NDArray[np.float64]) -> _MeanSquares:
        n, k = values.shape
        centred = values - values.mean()
        people = k * float(np.sum(centred.mean(axis=1) ** 2))
        occasions = n * float(np.sum(centred.mean(axis=0) ** 2))
        total = float(np.sum(centred**2))
        left = total - people - occasions
        if left <= ROUNDING * total:
            raise InputError("the scores leave no variance for an error")
        return cls(
            n, k, people / (n - 1), occasions / (k - 1), (total - people) / (n * (k - 1)),
            left / ((n - 1) * (k - 1)),
        )  # fmt: skip


def _one_way(squares: _MeanSquares, *, mean: bool, confidence: float) -> Intraclass:
    df = squares.n * (squares.k - 1)
    return _ratio("1", squares, squares.within, df, mean=mean, confidence=confidence)


def _consistency(squares: _MeanSquares, *, mean: bool, confidence: float) -> Intraclass:
    df = (squares.n - 1) * (squares.k - 1)
    return _ratio("3", squares, squares.error, df, mean=mean, confidence=confidence)


def _ratio(
    form: str, squares: _MeanSquares, error: float, df: int, *, mean: bool, confidence: float
) -> Intraclass:
    """Return the forms that follow from one F."""
    n, k, tail = squares.n, squares.k, (1 - confidence) / 2
    f = squares.people / error
    low = f / float(f_distribution.isf(tail, n - 1, df))
    high = f * float(f_distribution.isf(tail, df, n - 1))
    if mean:
        estimate, low, high = (1 - 1 / ratio if ratio else -np.inf for ratio in (f, low, high))
    else:
        estimate, low, high = ((ratio - 1) / (ratio + k - 1) for ratio in (f, low, high))
    p = float(f_distribution.sf(f, n - 1, df))
    name = f"{form},{'k' if mean else '1'}"
    return Intraclass(name, estimate, low, high, f, n - 1, df, p, confidence)


def _agreement(squares: _MeanSquares, *, mean: bool, confidence: float) -> Intraclass:
    """Return the form that counts differences between occasions as error."""
    n, k, tail = squares.n, squares.k, (1 - confidence) / 2
    people, occasions, error = squares.people, squares.occasions, squares.error
    df_error = (n - 1) * (k - 1)
    icc = (people - error) / (people + (k - 1) * error + k * (occasions - error) / n)
    a, b = k * icc / (n * (1 - icc)), 1 + k * icc * (n - 1) / (n * (1 - icc))
    mixed = a * occasions + b * error
    df = mixed**2 / ((a * occasions) ** 2 / (k - 1) + (b * error) ** 2 / df_error)
    above = float(f_distribution.isf(tail, n - 1, df))
    below = float(f_distribution.isf(tail, df, n - 1))
    rest = k * occasions + (k * n - k - n) * error
    low = n * (people - above * error) / (above * rest + n * people)
    high = n * (below * people - error) / (rest + n * below * people)
    f = people / error
    p = float(f_distribution.sf(f, n - 1, df_error))
    found = [k * each / (1 + (k - 1) * each) if mean else each for each in (icc, low, high)]
    name = f"2,{'k' if mean else '1'}"
    return Intraclass(name, found[0], found[1], found[2], f, n - 1, df_error, p, confidence)
