"""t tests of pairs and of two groups, with Hedges' g, Bayes factors and tests of equivalence."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import gammaln, nctdtr
from scipy.stats import chi2
from scipy.stats import t as t_distribution

from vrcomfort.stats.effects import EffectSize, decided_at_zero
from vrcomfort.stats.ranks import level_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from vrcomfort.stats.ranks import Alternative

    Floats = NDArray[np.float64]

# The JZS Bayes factor of a t test (Rouder et al. 2009).


PRIOR_SCALE = 2**-0.5
"""Of the Cauchy prior on the standardised difference, as in R's ``BayesFactor`` ("medium"); the
default of pingouin, .707, differs from it in the fifth digit of the Bayes factor."""


def jzs_bayes_factor(t: float, n: int, m: int | None = None) -> float:
    """Return how much likelier a difference makes the data (Rouder et al. 2009, eq. 1), two-sided.

    Parameters
    ----------
    n, m
        Sizes of both groups; `m` None for n differences.

    Returns
    -------
    float
        Infinite where it is larger than a float64 can be.
    """
    size, df = (n, n - 1) if m is None else (n * m / (n + m), n + m - 2)

    def log_density(log_g: float) -> float:
        spread = 1 + size * PRIOR_SCALE**2 * math.exp(log_g)
        likelihood = -math.log(spread) / 2 - (df + 1) / 2 * math.log1p(t * t / (spread * df))
        return likelihood - (math.log(2 * math.pi) + log_g + math.exp(-log_g)) / 2

    # Over log g, relative to the highest point of a grid: over g itself, as it is printed, the
    # integral is lost at a large t, where all its weight lies at a g of about t².
    ends = -8.0, 2 * math.log1p(abs(t)) + 60
    highest = max(np.linspace(*ends, 400), key=log_density)
    top = log_density(highest)
    area = quad(lambda g: math.exp(log_density(g) - top), *ends, points=[highest], limit=500)[0]
    try:
        return math.exp(top + (df + 1) / 2 * math.log1p(t * t / df)) * float(area)
    except OverflowError:
        return math.inf


ROUNDING = 1e-12
"""Share of the sum of squares below which what is left is rounding."""
Variances = Literal["welch", "pooled"]


@dataclass(frozen=True)
class TTest:
    """A t test of a difference of means, in points."""

    n: int
    """Pairs, or people of both groups together."""
    mean: float
    standard_error: float
    df: float
    t: float
    p: float
    low: float | None
    """None: no bound on that side, as with one-sided tests."""
    high: float | None
    confidence: float
    alternative: Alternative
    cohen_d: float
    """Of pairs, over the standard deviation of the differences (d_z); of groups, the pooled one."""
    cohen_d_interval: EffectSize
    """That of the noncentral t; of pairs, with what more the jackknife's holds."""
    hedges_g: EffectSize
    """The same without its bias."""
    bayes_factor_10: float
    """JZS (Rouder et al. 2009), two-sided: how much likelier a difference makes the data; infinite
    where it is larger than a float64 can be."""


@dataclass(frozen=True)
class Equivalence:
    """Two one-sided t tests of a difference within bounds (Schuirmann 1987)."""

    mean: float
    df: float
    t_low: float
    """Against the lower bound: is the difference above it?"""
    t_high: float
    p_low: float
    p_high: float
    p: float
    """The larger of both: at most α where the difference is shown to lie within the bounds."""
    low: float
    """Interval of 1 − 2 α, which lies within the bounds exactly where p ≤ α."""
    high: float
    confidence: float


def paired_t(
    differences: ArrayLike,
    unit: float = 1.0,
    *,
    alternative: Alternative = "two-sided",
    confidence: float = 0.95,
) -> TTest | None:
    """Test whether the mean of paired differences is zero (Student 1908).

    Parameters
    ----------
    differences
        First minus second, in steps of the scale, shape (n,).
    unit
        Points per step.

    Returns
    -------
    TTest or None
        None with fewer than two differences, or if all are alike: there is no t then.
    """
    values = np.asarray(differences, dtype=np.float64)
    if values.size < 2 or np.ptp(values) == 0:
        return None
    deviation, n = float(values.std(ddof=1)), values.size
    found = _t_test(
        float(values.mean()), deviation / math.sqrt(n), n - 1, unit, alternative, confidence,
        g=(float(values.mean()) / deviation, n - 1, 1 / math.sqrt(n)), sizes=(n, None),
    )  # fmt: skip
    wider = _with_jackknife(found.cohen_d_interval, values, alternative)
    return _decided(replace(found, cohen_d_interval=wider))


def _decided(found: TTest) -> TTest:
    """Return a test with standardised effects that agree with p about 0.

    Welch's p is not that of the pooled deviation that they are in units of.
    """
    rejected = found.p <= level_of(found.confidence)
    d, g = (decided_at_zero(e, rejected=rejected) for e in (found.cohen_d_interval, found.hedges_g))
    return replace(found, cohen_d_interval=d, hedges_g=g)


def _with_jackknife(d: EffectSize, values: Floats, alternative: Alternative) -> EffectSize:
    """Return d_z with the wider of two intervals at each end; on 0 its t test decides.

    That of the noncentral t takes differences for normal, and covers .84 of d_z = 0.5 where tails
    are heavy (n = 40). The jackknife's is one of t on the scale of arsinh(d/√2), on which the
    variance (1 + d²/2)/n of normal differences does not grow with d; there is none where the rest
    of the differences are alike without one of them.
    """
    n = values.size
    if n < 4:
        return d
    centred = values - values.mean()
    squares = float(centred @ centred) - n / (n - 1) * centred**2
    if (squares <= ROUNDING * float(centred @ centred)).any():
        return d
    without = (values.mean() - centred / (n - 1)) / np.sqrt(squares / (n - 2))
    places = np.arcsinh(without / math.sqrt(2))
    error = math.sqrt((n - 1) / n * float(np.sum((places - places.mean()) ** 2)))
    sides = 2 if alternative == "two-sided" else 1
    half = float(t_distribution.isf((1 - d.confidence) / sides, n - 1)) * error
    place = math.asinh(d.estimate / math.sqrt(2))
    low, high = (math.sqrt(2) * math.sinh(end) for end in (place - half, place + half))
    return replace(
        d,
        low=None if d.low is None else min(d.low, low),
        high=None if d.high is None else max(d.high, high),
    )


def two_sample_t(
    a: ArrayLike,
    b: ArrayLike,
    unit: float = 1.0,
    *,
    variances: Variances = "welch",
    alternative: Alternative = "two-sided",
    confidence: float = 0.95,
) -> TTest | None:
    """Test whether the means of two groups differ.

    Parameters
    ----------
    variances
        ``welch``: each group has its own (Welch 1947); ``pooled``: Student's, both alike.

    Returns
    -------
    TTest or None
        None with fewer than two values in a group, or where none varies in either.
    """
    found = _two_samples(a, b, variances)
    if found is None:
        return None
    mean, error, df, pooled, n, m = found
    test = _t_test(
        mean, error, df, unit, alternative, confidence,
        g=(mean / pooled, n + m - 2, math.sqrt(1 / n + 1 / m)), sizes=(n, m),
    )  # fmt: skip
    return _decided(test)


def equivalence_of_pairs(
    differences: ArrayLike, bounds: tuple[float, float], unit: float = 1.0, *, level: float = 0.05
) -> Equivalence | None:
    """Test whether the mean difference lies within bounds, in points; None without variance."""
    values = np.asarray(differences, dtype=np.float64)
    if values.size < 2 or np.ptp(values) == 0:
        return None
    error = float(values.std(ddof=1)) / math.sqrt(values.size)
    return _equivalence(float(values.mean()) * unit, error * unit, values.size - 1, bounds, level)


def equivalence_of_groups(
    a: ArrayLike,
    b: ArrayLike,
    bounds: tuple[float, float],
    unit: float = 1.0,
    *,
    variances: Variances = "welch",
    level: float = 0.05,
) -> Equivalence | None:
    """Test whether the difference of two groups' means lies within bounds, in points."""
    found = _two_samples(a, b, variances)
    if found is None:
        return None
    mean, error, df, *_ = found
    return _equivalence(mean * unit, error * unit, df, bounds, level)


def _two_samples(
    a: ArrayLike, b: ArrayLike, variances: Variances
) -> tuple[float, float, float, float, int, int] | None:
    """Return mean difference, its error and degrees of freedom, the pooled SD and both sizes."""
    first, second = (np.asarray(each, dtype=np.float64) for each in (a, b))
    n, m = first.size, second.size
    if min(n, m) < 2 or (np.ptp(first) == 0 and np.ptp(second) == 0):
        return None
    one, two = float(first.var(ddof=1)), float(second.var(ddof=1))
    pooled = math.sqrt(((n - 1) * one + (m - 1) * two) / (n + m - 2))
    mean = float(first.mean() - second.mean())
    if variances == "pooled":
        return mean, pooled * math.sqrt(1 / n + 1 / m), n + m - 2, pooled, n, m
    u, v = one / n, two / m
    df = (u + v) ** 2 / (u**2 / (n - 1) + v**2 / (m - 1))
    return mean, math.sqrt(u + v), df, pooled, n, m


def _t_test(
    mean: float,
    error: float,
    df: float,
    unit: float,
    alternative: Alternative,
    confidence: float,
    *,
    g: tuple[float, int, float],
    sizes: tuple[int, int | None],
) -> TTest:
    t = mean / error
    sides = 2 if alternative == "two-sided" else 1
    half = float(t_distribution.isf((1 - confidence) / sides, df)) * error
    return TTest(
        n=sizes[0] + (sizes[1] or 0),
        mean=mean * unit,
        standard_error=error * unit,
        df=df,
        t=t,
        p=p_of_t(t, df, alternative),
        low=None if alternative == "less" else (mean - half) * unit,
        high=None if alternative == "greater" else (mean + half) * unit,
        confidence=confidence,
        alternative=alternative,
        cohen_d=g[0],
        cohen_d_interval=_standardised(*g, 1.0, alternative, confidence),
        hedges_g=_hedges_g(*g, alternative, confidence),
        bayes_factor_10=jzs_bayes_factor(g[0] / g[2], *sizes),
    )


def p_of_t(t: float, df: float, alternative: Alternative) -> float:
    """Return the p value of a t statistic."""
    if alternative == "two-sided":
        return float(2 * t_distribution.sf(abs(t), df))
    return float(t_distribution.sf(t if alternative == "greater" else -t, df))


def _hedges_g(
    d: float, df: int, scale: float, alternative: Alternative, confidence: float
) -> EffectSize:
    """Return d without its bias (Hedges 1981), and the interval of the noncentral t."""
    if df == 1:  # the correction of one degree of freedom is zero: there is no unbiased g
        return EffectSize(math.nan, None, None, confidence)
    correction = math.exp(gammaln(df / 2) - gammaln((df - 1) / 2)) / math.sqrt(df / 2)
    return _standardised(d, df, scale, correction, alternative, confidence)


def _standardised(
    d: float, df: int, scale: float, correction: float, alternative: Alternative, confidence: float
) -> EffectSize:
    """Return d times a correction, with the interval of the noncentral t; `scale` is d over t."""
    sides = 2 if alternative == "two-sided" else 1
    tail = (1 - confidence) / sides
    t = d / scale
    low = None if alternative == "less" else _noncentrality(t, df, 1 - tail) * scale * correction
    high = None if alternative == "greater" else _noncentrality(t, df, tail) * scale * correction
    return EffectSize(d * correction, low, high, confidence)


def _noncentrality(t: float, df: int, probability: float) -> float:
    """Return the noncentrality at which P(T ≤ t) is `probability`."""
    # nctdtr has no value for noncentralities beyond 1e5. There the normal part of T has no weight:
    # T is the noncentrality over χ; at the limit both agree to 1e-6 at confidence 95 %.
    if abs(t) > 1e4:
        upper = probability if t > 0 else 1 - probability
        return t * math.sqrt(float(chi2.isf(upper, df)) / df)

    def excess(centre: float) -> float:
        found = float(nctdtr(df, centre, t))
        if math.isnan(found):  # far out in a tail, where its series underflows
            found = 1.0 if centre < t else 0.0
        return found - probability

    width = 4.0
    while excess(t - width) < 0 or excess(t + width) > 0:
        width *= 2
    return float(brentq(excess, t - width, t + width, xtol=1e-12))


def _equivalence(
    mean: float, error: float, df: float, bounds: tuple[float, float], level: float
) -> Equivalence:
    t_low, t_high = ((mean - bound) / error for bound in bounds)
    p_low = float(t_distribution.sf(t_low, df))
    p_high = float(t_distribution.cdf(t_high, df))
    half = float(t_distribution.isf(level, df)) * error
    return Equivalence(
        mean, df, t_low, t_high, p_low, p_high, max(p_low, p_high), mean - half, mean + half,
        1 - 2 * level,
    )  # fmt: skip
