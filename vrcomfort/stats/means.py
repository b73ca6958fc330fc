"""The interval of a mean by bootstrap-t: it keeps its coverage where scores are skewed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

RESAMPLES = 1999
SEED = 19930101
"""Of every bootstrap here; a report says it, and the same data give the same interval."""
_BLOCK = 2_000_000


@dataclass(frozen=True)
class MeanInterval:
    """An interval of a mean; None where the sample sets no bound on that side."""

    low: float | None
    high: float | None


def mean_interval(values: ArrayLike, *, confidence: float = 0.95) -> MeanInterval:
    """Return the bootstrap-t interval (Efron & Tibshirani 1993, section 12.5) of a mean.

    Each resample gives t* = (its mean − the mean)/(its standard error); the interval is the mean
    minus the quantiles of t*, times the standard error. A resample of equal values has t* = ±∞, so
    a sample that is nearly constant may set no bound: then nothing in it says how far the mean
    may lie on that side.

    Returns
    -------
    MeanInterval
        Without bounds for fewer than two values, or where all are equal.
    """
    sample = np.asarray(values, dtype=np.float64)
    n = sample.size
    if n < 2 or np.ptp(sample) == 0:
        return MeanInterval(None, None)
    mean, error = float(sample.mean()), float(sample.std(ddof=1) / np.sqrt(n))
    quantiles = np.quantile(
        _studentised(sample - mean), [(1 + confidence) / 2, (1 - confidence) / 2], method="nearest"
    )
    low, high = (mean - t * error for t in map(float, quantiles))
    return MeanInterval(low if np.isfinite(low) else None, high if np.isfinite(high) else None)


def _studentised(centred: Floats) -> Floats:
    """Return t* of every resample, drawn as counts of the distinct values."""
    distinct, counts = np.unique(centred, return_counts=True)
    random, n = np.random.default_rng(SEED), centred.size
    found, block = [], max(1, _BLOCK // distinct.size)
    for first in range(0, RESAMPLES, block):
        drawn = random.multinomial(n, counts / n, size=min(block, RESAMPLES - first))
        means = drawn @ distinct / n
        squares = drawn @ distinct**2 / n - means**2
        constant = drawn.max(axis=1) == n
        errors = np.sqrt(np.where(constant, 1.0, np.abs(squares)) / (n - 1))
        infinite = np.where(means == 0, 0.0, np.copysign(np.inf, means))
        found.append(np.where(constant, infinite, means / errors))
    return np.concatenate(found)
