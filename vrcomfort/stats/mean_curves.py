"""Means of conditions over time, with intervals that compare conditions within people.

At each time, ``value ~ condition + (1 | participant)`` is fitted to every exposure that is there.
Its means are those of conditions that the same people would have met, so a condition that a few
sensitive people met is not higher for that. Intervals are for the comparison of conditions: the
spread between people, which all conditions share, is taken out, as by Loftus & Masson (1994),
Cousineau (2005) and Morey (2008), whose intervals need everybody under every condition. In such
data they are those of Loftus & Masson; here, any exposure may be missing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import t as t_distribution

from vrcomfort.errors import InputError
from vrcomfort.stats.random_intercept import fit_random_intercept

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Integers = NDArray[np.int64]


@dataclass(frozen=True)
class MeanCurves:
    """Means of k conditions at m times."""

    times_s: Floats
    """Shape (m,)."""
    n: Integers
    """Exposures with a value, shape (k, m)."""
    mean: Floats
    """Shape (k, m); NaN where there is no exposure. Plain means where no model can be fitted."""
    half: Floats
    """Half of the interval, shape (k, m); NaN where there is none."""


def mean_curves(
    times_s: ArrayLike,
    values: ArrayLike,
    conditions: ArrayLike,
    people: ArrayLike,
    *,
    count: int,
    confidence: float = 0.95,
) -> MeanCurves:
    """Estimate the mean of each condition at each time.

    Parameters
    ----------
    values
        Of each exposure at each time, NaN where there is none; shape (n, m).
    conditions
        Number of each exposure's condition, from 0 to `count` − 1, shape (n,).
    people
        Who each exposure is of, shape (n,).
    """
    times = np.asarray(times_s, dtype=np.float64)
    table = np.asarray(values, dtype=np.float64)
    met = np.asarray(conditions, dtype=np.int64)
    who = np.unique(np.asarray(people), return_inverse=True)[1].ravel()
    shape = (count, times.size)
    n, mean, half = np.zeros(shape, dtype=np.int64), np.full(shape, np.nan), np.full(shape, np.nan)
    for place, column in enumerate(table.T):
        there = ~np.isnan(column)
        n[:, place] = np.bincount(met[there], minlength=count)
        shown = np.flatnonzero(n[:, place])
        if shown.size:
            codes = np.searchsorted(shown, met[there])
            found = _means(column[there], codes, who[there], confidence)
            mean[shown, place], half[shown, place] = found
    return MeanCurves(times, n, mean, half)


def _means(
    values: Floats, codes: Integers, people: Integers, confidence: float
) -> tuple[Floats, Floats]:
    """Return the mean of each condition and half of its interval."""
    count = int(codes.max()) + 1
    plain = np.bincount(codes, values) / np.bincount(codes)
    design = np.column_stack([np.ones(values.size), *(codes == c for c in range(1, count))])
    try:
        fit = fit_random_intercept(values, design, np.unique(people, return_inverse=True)[1])
    except InputError:
        return plain, np.full(count, np.nan)
    rows = np.eye(count)
    rows[:, 0] = 1.0
    covariance = rows @ fit.covariance @ rows.T
    if count == 1:
        df = np.array([fit.degrees_of_freedom(rows[0])])
    else:  # each mean against that of the others
        against = rows - (rows.sum(axis=0) - rows) / (count - 1)
        df = np.array([fit.degrees_of_freedom(row) for row in against])
    half = t_distribution.isf((1 - confidence) / 2, df) * np.sqrt(within_variances(covariance))
    return rows @ fit.coefficients, np.asarray(half, dtype=np.float64)


def within_variances(covariance: Floats) -> Floats:
    """Return the variance of each of k means without what all means share.

    It is k / (k − 1) times that of the mean's distance from the mean of all means: Cousineau's
    (2005) normalisation with Morey's (2008) correction. In complete data, that is the variance of a
    mean of residuals. Of one mean, it is its variance.
    """
    count = covariance.shape[0]
    if count == 1:
        return np.asarray(np.diag(covariance), dtype=np.float64)
    centred = np.eye(count) - 1 / count
    apart = np.diag(centred @ covariance @ centred)
    return np.asarray(np.maximum(apart, 0.0) * count / (count - 1), dtype=np.float64)
