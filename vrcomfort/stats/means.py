"""Means of conditions: bootstrap-t intervals, curves over time, z scores within people."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.special import stdtrit
from scipy.stats import t as t_distribution

from vrcomfort.errors import InputError
from vrcomfort.stats.random_intercept import fit_random_intercept

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Integers = NDArray[np.int64]

# The interval of a mean: the wider of the t and the bootstrap-t interval, at each end.
#
# Of skewed scores, t stops short on the side of the tail; bootstrap-t does so on the other side,
# and of heavy tails on both. `docs/statistics_checks.md` says how often each covers.


# One less than a multiple of 40: quantiles of 95 % intervals are order statistics.
RESAMPLES = 1999
SEED = 19930101
"""Of every bootstrap here; a report says it, and the same data give the same interval."""
KEPT_UP_TO = 200
"""Values up to which resamples are drawn once for samples of the same size; of more, which have few
distinct values, they are drawn as counts of those."""
ROUNDING = 1e-13
"""Of the largest value, or of its square: less is no mean, or the variance of equal values."""
# Numbers of resamples that are in memory at a time: 16 MB.
_BLOCK = 2_000_000


@dataclass(frozen=True)
class MeanInterval:
    """An interval of a mean; None where the sample sets no bound on that side."""

    low: float | None
    high: float | None


def mean_interval(values: ArrayLike, *, confidence: float = 0.95) -> MeanInterval:
    """Return the hull of the t interval and the bootstrap-t interval of a mean.

    Bootstrap-t (Efron & Tibshirani 1993, section 12.5): each resample gives t* = (its mean − the
    mean)/(its standard error); the interval is the mean minus the quantiles of t*, times the
    standard error. A resample has n − 1 values, as the sample has n − 1 degrees of freedom (Rao &
    Wu 1988, Journal of the American Statistical Association 83). One of equal values has t* = ±∞,
    so a sample that is nearly constant may set no bound: then nothing in it says how far the mean
    may lie on that side.

    Returns
    -------
    MeanInterval
        Without bounds for fewer than three values, or where all are equal.
    """
    sample = np.asarray(values, dtype=np.float64)
    n = sample.size
    if n < 3 or np.ptp(sample) == 0:
        return MeanInterval(None, None)
    mean, error = float(sample.mean()), float(sample.std(ddof=1) / np.sqrt(n))
    upper = (1 + confidence) / 2
    most, least = map(
        float, np.quantile(_studentised(sample - mean), [upper, 1 - upper], method="nearest")
    )
    t = float(stdtrit(n - 1, upper))
    low, high = mean - max(most, t) * error, mean - min(least, -t) * error
    return MeanInterval(low if np.isfinite(low) else None, high if np.isfinite(high) else None)


def _studentised(centred: Floats) -> Floats:
    """Return t* of every resample of n − 1 values."""
    random, n = np.random.default_rng(SEED), centred.size - 1
    if centred.size <= KEPT_UP_TO:
        return _t_of(_kept(centred.size), np.sort(centred), n)
    distinct, counts = np.unique(centred, return_counts=True)
    block = max(1, _BLOCK // distinct.size)
    blocks = [min(block, RESAMPLES - first) for first in range(0, RESAMPLES, block)]
    shares = counts / centred.size
    return np.concatenate(
        [_t_of(random.multinomial(n, shares, size=rows), distinct, n) for rows in blocks]
    )


@lru_cache(maxsize=8)
def _kept(size: int) -> Floats:
    """Return how often each resample has each value, shape (RESAMPLES, size)."""
    random = np.random.default_rng(SEED)
    drawn = random.multinomial(size - 1, np.full(size, 1 / size), size=RESAMPLES)
    return drawn.astype(np.float64)


def _t_of(drawn: NDArray[np.floating[Any] | np.integer[Any]], values: Floats, n: int) -> Floats:
    """Return the mean of each resample over its standard error; `drawn` counts its `values`."""
    sums = drawn @ np.stack([values, values**2], axis=1)
    means = sums[:, 0] / n
    squares = sums[:, 1] / n - means**2
    size = np.abs(values).max()
    constant = squares <= ROUNDING * size**2
    errors = np.sqrt(np.where(constant, 1.0, squares) / (n - 1))
    infinite = np.where(np.abs(means) <= ROUNDING * size, 0.0, np.copysign(np.inf, means))
    return np.where(constant, infinite, means / errors)


# Means of conditions over time, with intervals that compare conditions within people.
#
# At each time, ``value ~ condition + (1 | participant)`` is fitted to every exposure that is
# there. Its means are those of conditions that the same people would have met, so a condition
# that a few sensitive people met is not higher for that. Intervals are for the comparison of
# conditions: the spread between people, which all conditions share, is taken out, as by Loftus &
# Masson (1994), Cousineau (2005) and Morey (2008), whose intervals need everybody under every
# condition. In such data they are those of Loftus & Masson; here, any exposure may be missing.


@dataclass(frozen=True)
class MeanCurves:
    """Means of k conditions at m times."""

    times_s: Floats
    """Shape (m,)."""
    n: Integers
    """Exposures with a value, shape (k, m)."""
    mean: Floats
    """Shape (k, m); NaN where there is no exposure. Plain means where no model can be fitted, and
    where each person has one exposure."""
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
    of_each_mean = _plain_means if who.size == np.unique(who).size else _means
    n, mean, half = np.zeros(shape, dtype=np.int64), np.full(shape, np.nan), np.full(shape, np.nan)
    for place, column in enumerate(table.T):
        there = ~np.isnan(column)
        n[:, place] = np.bincount(met[there], minlength=count)
        shown = np.flatnonzero(n[:, place])
        if shown.size:
            codes = np.searchsorted(shown, met[there])
            found = of_each_mean(column[there], codes, who[there], confidence)
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


def _plain_means(
    values: Floats, codes: Integers, _people: Integers, confidence: float
) -> tuple[Floats, Floats]:
    """Return the mean of each condition and half of its t interval, of different people."""
    n = np.bincount(codes)
    mean = np.bincount(codes, values) / n
    squares = np.bincount(codes, (values - mean[codes]) ** 2)
    half = np.full(n.size, np.nan)
    two = n > 1
    error = np.sqrt(squares[two] / (n[two] - 1) / n[two])
    half[two] = t_distribution.isf((1 - confidence) / 2, n[two] - 1) * error
    return mean, half


def within_variances(covariance: Floats) -> Floats:
    """Return the variance of each of k means without the part that all means share.

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


# Scores standardised within each person (Mantiuk et al. 2011, Figure 4).


class ZScore(NamedTuple):
    """Mean of a condition's z scores.

    Parameters
    ----------
    standard_error
        Of all values, as Mantiuk et al. print it: a person's values count as independent. None of
        a single value.
    n, people
        How many values, and of how many people.
    standard_error_of_people
        Of the people's means; None of a single person.
    """

    mean: float
    standard_error: float | None
    n: int
    people: int
    standard_error_of_people: float | None


def z_scored(
    people: Sequence[str], conditions: Sequence[str], values: Sequence[float]
) -> dict[str, ZScore]:
    """Return condition → mean and standard errors of values standardised within each person.

    Every value minus its person's mean, over that person's standard deviation (n − 1). Who has one
    value, or always the same, has no z score and is left out.
    """
    whose, shown = np.asarray(people), np.asarray(conditions)
    z = _standardised(whose, np.asarray(values, dtype=np.float64))
    found = {}
    for condition in dict.fromkeys(conditions):
        there = (shown == condition) & np.isfinite(z)
        if there.any():
            own = [z[there & (whose == person)].mean() for person in np.unique(whose[there])]
            found[condition] = ZScore(
                float(z[there].mean()), _error(z[there]), int(there.sum()), len(own),
                _error(np.array(own)),
            )  # fmt: skip
    return found


def _standardised(whose: NDArray[np.str_], values: Floats) -> Floats:
    z = np.full(values.shape, np.nan)
    for person in np.unique(whose):
        mine = whose == person
        if mine.sum() > 1 and np.ptp(values[mine]) > 0:
            z[mine] = (values[mine] - values[mine].mean()) / values[mine].std(ddof=1)
    return z


def _error(values: Floats) -> float | None:
    return float(values.std(ddof=1) / np.sqrt(values.size)) if values.size > 1 else None
