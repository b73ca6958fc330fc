"""Hodges-Lehmann shift with a distribution-free confidence interval."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.stats.ranks import fewest_for_interval, sign_flip_distribution

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Shift:
    """A location shift in the units of the scores."""

    estimate: float
    low: float | None
    high: float | None
    confidence: float
    """Confidence asked for."""
    coverage: float | None
    """Coverage of the interval (at least `confidence`) where differences are continuous."""
    n: int
    zeros_included: bool


def walsh_averages(differences: ArrayLike) -> NDArray[np.float64]:
    """Return the sorted n(n+1)/2 means of all pairs (a difference with itself included)."""
    values = np.asarray(differences, dtype=np.float64)
    first, second = np.triu_indices(values.size)
    return np.sort((values[first] + values[second]) / 2)


def _order_statistic(n: int, confidence: float) -> tuple[int, float]:
    """Return the 1-based order statistic that bounds the interval, and the coverage."""
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
    zeros this is what R's ``wilcox.test(conf.int = TRUE)`` approximates under ties.

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
    averages = walsh_averages(values) * unit
    rank, coverage = _order_statistic(values.size, confidence)
    wide_enough = values.size >= fewest_for_interval(confidence)
    return Shift(
        estimate=float(np.median(averages)),
        low=float(averages[rank - 1]) if wide_enough else None,
        high=float(averages[-rank]) if wide_enough else None,
        confidence=confidence,
        coverage=coverage if wide_enough else None,
        n=int(values.size),
        zeros_included=zeros_included,
    )
