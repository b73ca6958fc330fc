"""Effect sizes with confidence intervals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq
from scipy.special import ncfdtr
from scipy.stats import norm

from vrcomfort.stats.ranks import doubled_midranks, fewest_for_interval

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Effect:
    """An effect size and its interval, None where the sample is too small for one."""

    estimate: float
    low: float | None
    high: float | None
    confidence: float


def rank_biserial(
    differences: ArrayLike, *, interval_n: int | None = None, confidence: float = 0.95
) -> Effect | None:
    """Matched-pairs rank-biserial correlation (Kerby 2014): (W+ − W−)/(W+ + W−).

    Ranks are those of the non-zero differences. The interval is Fisher-z with the null standard
    error of the signed-rank sum, as in R's ``effectsize`` (Ben-Shachar et al. 2020):
    SE = sqrt(n(n+1)(2n+1)/6) / (n(n+1)/2).

    It is approximate, and narrower than the exact test: where the null hypothesis holds, the 95 %
    interval leaves out 0 in 16 % of samples of 6 differences, in 8 % of 12 (without ties). So it
    says how large an effect is, and p whether there is one. Where the exact test can never reject
    (fewer non-zero differences than `ranks.fewest_for_interval`) there is no interval.

    Parameters
    ----------
    differences
        Integer paired differences, shape (n,).
    interval_n
        The n of that standard error; the number of non-zero differences unless given.
        (``effectsize`` counts the non-zero scores of the *first* condition: give that number to
        reproduce its intervals.)

    Returns
    -------
    Effect or None
        None if every difference is zero. At ±1 the interval has no width, which says nothing of
        the precision. There is none where `interval_n` is 0.
    """
    values = np.asarray(differences, dtype=np.int64)
    values = values[values != 0]
    n = values.size if interval_n is None else interval_n
    if values.size == 0:
        return None
    ranks = doubled_midranks(np.abs(values))
    estimate = float(np.sum(np.sign(values) * ranks) / ranks.sum())
    if values.size < fewest_for_interval(confidence) or n < 1:
        return Effect(estimate, None, None, confidence)
    if abs(estimate) == 1:
        return Effect(estimate, estimate, estimate, confidence)
    error = np.sqrt(n * (n + 1) * (2 * n + 1) / 6) / (n * (n + 1) / 2)
    half = float(norm.ppf((1 + confidence) / 2)) * error
    z = np.arctanh(estimate)
    return Effect(estimate, float(np.tanh(z - half)), float(np.tanh(z + half)), confidence)


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
