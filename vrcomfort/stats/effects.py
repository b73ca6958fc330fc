"""Effect sizes with confidence intervals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.optimize import brentq
from scipy.special import ncfdtr, stdtrit
from scipy.stats import norm

from vrcomfort.stats.normal_shift import largest_shift, superiority
from vrcomfort.stats.ranks import doubled_midranks, fewest_for_interval

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from vrcomfort.stats.ranks import Alternative, Integers


@dataclass(frozen=True)
class Effect:
    """An effect size and its interval, None where the sample is too small for one."""

    estimate: float
    low: float | None
    high: float | None
    confidence: float


RankBiserialInterval = Literal["normal_shift", "fisher_z"]


def rank_biserial(
    differences: ArrayLike,
    *,
    interval: RankBiserialInterval = "normal_shift",
    interval_n: int | None = None,
    alternative: Alternative = "two-sided",
    confidence: float = 0.95,
) -> Effect | None:
    """Matched-pairs rank-biserial correlation (Kerby 2014): (W+ − W−)/(W+ + W−).

    Ranks are those of the non-zero differences D, so it estimates P(D₁ + D₂ > 0) − P(D₁ + D₂ < 0).

    Parameters
    ----------
    differences
        Integer paired differences, shape (n,).
    interval
        ``normal_shift``: every value that the observed one is compatible with where D ~ N(δ, 1)
        (see `normal_shift`; ties between whole rank sums widen it), and what more the studentised
        interval holds (see `_studentised_ends`), which needs no normal D. ``fisher_z``: as in R's
        ``effectsize`` (Ben-Shachar et al. 2020), with the null standard error of the signed-rank
        sum, sqrt(n(n+1)(2n+1)/6) / (n(n+1)/2). That one is too narrow under a real effect, has no
        width at ±1, and is None with fewer differences than `ranks.fewest_for_interval`.
    interval_n
        The n of ``fisher_z``; the number of non-zero differences unless given. (``effectsize``
        counts the non-zero scores of the *first* condition: give that number to reproduce its
        intervals. There is none where it is 0.)
    alternative
        One-sided tests have one-sided bounds; the other end is ±1.

    Returns
    -------
    Effect or None
        None if every difference is zero.
    """
    values = np.asarray(differences, dtype=np.int64)
    values = values[values != 0]
    if values.size == 0:
        return None
    ranks = doubled_midranks(np.abs(values))
    doubled_plus, doubled_all = int(ranks[values > 0].sum()), int(ranks.sum())
    estimate = 2 * doubled_plus / doubled_all - 1
    level = (1 - confidence) / (2 if alternative == "two-sided" else 1)
    low, high = (
        _wider(
            _normal_shift_ends(values.size, doubled_plus, level),
            _studentised_ends(values, estimate, level),
        )
        if interval == "normal_shift"
        else _fisher_z_ends(estimate, values.size, interval_n, level, confidence)
    )
    if low is not None:
        low = -1.0 if alternative == "less" else low
        high = 1.0 if alternative == "greater" else high
    return Effect(estimate, low, high, confidence)


def _normal_shift_ends(n: int, doubled_plus: int, level: float) -> tuple[float, float]:
    """Return the smallest and largest ρ with P(W+ ≥ observed) and P(W+ ≤ observed) > level."""
    largest = n * (n + 1) // 2
    floor, ceiling = doubled_plus // 2, -(-doubled_plus // 2)
    low = -largest_shift(n, largest - floor, level)
    high = largest_shift(n, ceiling, level)
    return superiority(low), superiority(high)


def _studentised_ends(values: Integers, estimate: float, level: float) -> tuple[float, float]:
    """Return the ends on the scale of arcsin r, with the standard error that the sample shows.

    The rank-biserial is a U statistic of pairs, but for n of its n(n + 1)/2 terms: its error is
    that of the mean over i of 2 h_i, h_i = mean over j ≠ i of sign(D_i + D_j) (Sen 1960, Calcutta
    Statistical Association Bulletin 10), divided by (n − 2)/(n − 1) as a jackknife does. Without
    width where r is ±1 or n < 3.
    """
    n = values.size
    if n < 3 or abs(estimate) == 1:
        return estimate, estimate
    ordered = np.sort(values)
    above = n - np.searchsorted(ordered, -values, side="right")
    below = np.searchsorted(ordered, -values, side="left")
    shares = (above - below - np.sign(values)) / (n - 1)
    error = 2 * float(np.std(shares)) * (n - 1) / ((n - 2) * np.sqrt(n))
    half = float(stdtrit(n - 1, 1 - level)) * error / np.sqrt(1 - estimate**2)
    place = np.arcsin(estimate)
    low, high = max(place - half, -np.pi / 2), min(place + half, np.pi / 2)
    return float(np.sin(low)), float(np.sin(high))


def _wider(one: tuple[float, float], other: tuple[float, float]) -> tuple[float, float]:
    return min(one[0], other[0]), max(one[1], other[1])


def _fisher_z_ends(
    estimate: float, nonzero: int, interval_n: int | None, level: float, confidence: float
) -> tuple[float | None, float | None]:
    n = nonzero if interval_n is None else interval_n
    if nonzero < fewest_for_interval(confidence) or n < 1:
        return None, None
    if abs(estimate) == 1:
        return estimate, estimate
    error = np.sqrt(n * (n + 1) * (2 * n + 1) / 6) / (n * (n + 1) / 2)
    half = float(norm.ppf(1 - level)) * error
    z = np.arctanh(estimate)
    return float(np.tanh(z - half)), float(np.tanh(z + half))


def partial_eta_squared(
    f: float, df_effect: float, df_error: float, *, confidence: float = 0.90
) -> Effect:
    """Partial η² from F with a noncentral-F interval (Steiger 2004).

    90 % is the usual level: the interval then excludes zero exactly when the test rejects at 5 %.
    """
    if not np.isfinite(f):
        return Effect(1.0, 1.0, 1.0, confidence)
    tail = (1 - confidence) / 2
    total = df_effect + df_error + 1

    def bound(probability: float) -> float:
        ncp = _noncentrality(f, df_effect, df_error, probability)
        return ncp / (ncp + total)

    estimate = f * df_effect / (f * df_effect + df_error)
    return Effect(estimate, bound(1 - tail), bound(tail), confidence)


def _noncentrality(f: float, df_effect: float, df_error: float, probability: float) -> float:
    """Noncentrality at which P(F <= f) is `probability`; 0 where none is."""

    def excess(ncp: float) -> float:
        return float(ncfdtr(df_effect, df_error, ncp, f)) - probability

    if excess(0.0) <= 0:
        return 0.0
    return float(brentq(excess, 0.0, _upper_bracket(excess), xtol=1e-10))


def _upper_bracket(excess: Callable[[float], float]) -> float:
    """Smallest power of two at which the decreasing `excess` is negative."""
    high = 1.0
    while excess(high) > 0:
        high *= 2
    return high
