"""Estimated marginal means of a mixed model, and their pairwise differences.

Each level's mean is that of the model with all levels of the other factors weighing alike and
covariates at their means (Searle, Speed & Milliken 1980), as R's ``lmerTest::ls_means`` has it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import t as t_distribution

from vrcomfort.stats.crossover import Estimate, t_estimate

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vrcomfort.stats.random_intercept import RandomIntercept

    Floats = NDArray[np.float64]

MOST_LEVELS = 12
"""Levels up to which all pairs are compared."""


@dataclass(frozen=True)
class Pairwise:
    """The difference of two marginal means, adjusted for the number of pairs (Bonferroni)."""

    estimate: float
    standard_error: float
    df: float
    t: float | None
    p: float | None
    """Unadjusted."""
    p_adjusted: float | None
    low: float | None
    """Adjusted: the interval holds 0 exactly where `p_adjusted` is above 1 − confidence."""
    high: float | None


def marginal_means(
    fit: RandomIntercept,
    factors: Mapping[str, tuple[str, ...]],
    covariates: int,
    confidence: float,
) -> tuple[dict[str, dict[str, Estimate]], dict[str, dict[str, Pairwise]]]:
    """Return means and pairwise differences by factor.

    A factor with more than `MOST_LEVELS` levels has no pairwise differences.

    Parameters
    ----------
    fit
        Of a design with a column of ones, the treatment-coded columns of the factors in order
        (each factor's first level is its reference), and centred covariates.
    factors
        Factor → levels, the reference first.
    covariates
        How many columns follow those of the factors.
    """
    means, pairs = {}, {}
    for name, levels in factors.items():
        rows = {level: _row(factors, name, level, covariates) for level in levels}
        means[name] = {level: _estimate(fit, row, confidence) for level, row in rows.items()}
        compared = [*combinations(levels, 2)] if len(levels) <= MOST_LEVELS else []
        pairs[name] = {
            f"{one} − {two}": _difference(fit, rows[one] - rows[two], len(compared), confidence)
            for one, two in compared
        }
    return means, pairs


def _row(factors: Mapping[str, tuple[str, ...]], name: str, level: str, covariates: int) -> Floats:
    """Return the coefficients' weights in the mean of a level."""
    parts = [np.ones(1)]
    for factor, levels in factors.items():
        others = levels[1:]
        if factor == name:
            parts.append(np.array([float(each == level) for each in others]))
        else:
            parts.append(np.full(len(others), 1 / len(levels)))
    return np.concatenate([*parts, np.zeros(covariates)])


def _estimate(fit: RandomIntercept, row: Floats, confidence: float) -> Estimate:
    error = float(np.sqrt(row @ fit.covariance @ row))
    return t_estimate(float(row @ fit.coefficients), error, fit.degrees_of_freedom(row), confidence)


def _difference(fit: RandomIntercept, row: Floats, count: int, confidence: float) -> Pairwise:
    found = _estimate(fit, row, confidence)
    if found.p is None:
        nothing = (None, None, None, None, None)
        return Pairwise(found.estimate, found.standard_error, found.df, *nothing)
    half = found.standard_error * float(
        t_distribution.isf((1 - confidence) / (2 * count), found.df)
    )
    return Pairwise(
        found.estimate, found.standard_error, found.df, found.t, found.p,
        min(1.0, count * found.p), found.estimate - half, found.estimate + half,
    )  # fmt: skip
