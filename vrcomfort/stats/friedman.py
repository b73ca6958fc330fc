"""Friedman's test with Kendall's W, for ordinal scores under more than two conditions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc
from scipy.stats import rankdata

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Friedman:
    """A Friedman test; ties within participants are corrected for."""

    n: int
    conditions: int
    ties: int
    """Scores that share their value with another of the same participant."""
    chi_square: float | None
    """None if no participant distinguishes the conditions."""
    df: int
    p: float | None
    kendall_w: float | None


def friedman(scores: ArrayLike) -> Friedman:
    """Test integer scores of n participants (rows) under k conditions (columns).

    Raises
    ------
    InputError
        With fewer than two participants or conditions.
    """
    values = np.asarray(scores, dtype=np.int64)
    if values.ndim != 2 or min(values.shape) < 2:
        raise InputError("Friedman's test needs at least two participants and two conditions")
    n, k = values.shape
    ranks = rankdata(values, axis=1)
    within = float(np.sum((ranks - (k + 1) / 2) ** 2))
    ties = _tied(values)
    if within == 0:
        return Friedman(n, k, ties, None, k - 1, None, None)
    between = float(np.sum((ranks.sum(axis=0) - n * (k + 1) / 2) ** 2))
    chi_square = (k - 1) * between / within
    p = float(chdtrc(k - 1, chi_square))
    return Friedman(n, k, ties, chi_square, k - 1, p, chi_square / (n * (k - 1)))


def _tied(values: NDArray[np.int64]) -> int:
    """Return how many values are equal to another of their row."""
    ordered = np.sort(values, axis=1)
    same = np.diff(ordered, axis=1) == 0
    edge = np.zeros((values.shape[0], 1), dtype=bool)
    return int((np.hstack([edge, same]) | np.hstack([same, edge])).sum())
