"""Hodges-Lehmann shift with a distribution-free confidence interval."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import norm

from vrcomfort.stats.ranks import fewest_for_interval, sign_flip_distribution
from vrcomfort.stats.walsh import WalshSums

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vrcomfort.stats.inversion import Bound, Hull


@dataclass(frozen=True)
class Shift:
    """A location shift in the units of the scores."""

    estimate: float
    low: float | None
    """None: unbounded, or (if `high` is None too) no interval."""
    high: float | None
    low_closed: bool
    """Whether `low` itself is in the interval."""
    high_closed: bool
    confidence: float
    """Confidence asked for."""
    coverage: float | None
    """Coverage of an interval between order statistics where differences are continuous."""
    n: int
    zeros_included: bool
    """In the estimate."""
    holds_rejected_zero: bool = False
    """Whether 0 is in the interval although the test rejects it (p is not monotone with ties)."""


EXACT_ORDER_UP_TO = 300
"""Differences up to which the order statistic comes from the exact distribution."""


def _order_statistic(n: int, confidence: float) -> tuple[int, float]:
    """Return the 1-based order statistic that bounds the interval, and the coverage."""
    if n > EXACT_ORDER_UP_TO:
        sd = np.sqrt(n * (n + 1) * (2 * n + 1) / 24)
        rank = max(int(n * (n + 1) / 4 - norm.ppf((1 + confidence) / 2) * sd), 1)
        return rank, 1 - 2 * float(norm.cdf((rank - 0.5 - n * (n + 1) / 4) / sd))
    cumulative = np.cumsum(sign_flip_distribution(2 * np.arange(1, n + 1))[::2])
    rank = max(int(np.searchsorted(cumulative, (1 - confidence) / 2)), 1)
    return rank, 1 - 2 * float(cumulative[rank - 1])


def hodges_lehmann(
    differences: ArrayLike,
    unit: float = 1.0,
    *,
    zeros_included: bool = True,
    confidence: float = 0.95,
) -> Shift | None:
    """Estimate the shift as the median of the Walsh averages.

    Convention: the interval is bounded by the order statistics of the Walsh averages that the
    exact signed-rank distribution without ties gives, the conservative side taken. Without
    zeros this is what R's ``wilcox.test(conf.int = TRUE)`` approximates under ties. Where there are
    ties it may contradict a test that takes them into account; see `with_hull`.

    Parameters
    ----------
    differences
        Paired differences in integer steps of the scale, shape (n,).
    unit
        Points per step; applied last.
    zeros_included
        Whether pairs without a difference count (they do in a Pratt analysis).

    Returns
    -------
    Shift or None
        None without any difference to average. Below `ranks.fewest_for_interval` there is no
        interval.
    """
    values = np.asarray(differences, dtype=np.int64)
    values = values if zeros_included else values[values != 0]
    if values.size == 0:
        return None
    sums = WalshSums(values)
    rank, coverage = _order_statistic(values.size, confidence)
    wide_enough = values.size >= fewest_for_interval(confidence)
    ends = (sums.order_statistic(rank), sums.order_statistic(sums.count + 1 - rank))
    low, high = (end / 2 * unit for end in ends)
    return Shift(
        estimate=sums.median_of_four() / 4 * unit,
        low=low if wide_enough else None,
        high=high if wide_enough else None,
        low_closed=wide_enough,
        high_closed=wide_enough,
        confidence=confidence,
        coverage=coverage if wide_enough else None,
        n=int(values.size),
        zeros_included=zeros_included,
    )


def with_hull(
    differences: ArrayLike,
    hull: Hull,
    unit: float = 1.0,
    *,
    zeros_included: bool,
    zero_rejected: bool,
    confidence: float,
) -> Shift | None:
    """Return the same estimate with the interval of a test that was inverted (`inversion`)."""
    values = np.asarray(differences, dtype=np.int64)
    values = values if zeros_included else values[values != 0]
    if values.size == 0:
        return None
    low, low_closed = _end(hull.low, unit)
    high, high_closed = _end(hull.high, unit)
    return Shift(
        estimate=WalshSums(values).median_of_four() / 4 * unit,
        low=low,
        high=high,
        low_closed=low_closed,
        high_closed=high_closed,
        confidence=confidence,
        coverage=None,
        n=int(values.size),
        zeros_included=zeros_included,
        holds_rejected_zero=zero_rejected and hull.contains(0),
    )


def _end(bound: Bound | None, unit: float) -> tuple[float | None, bool]:
    return (None, False) if bound is None else (bound.value * unit, bound.closed)
