"""The interval of a mean: the wider of the t and the bootstrap-t interval, at each end.

Of skewed scores, t stops short on the side of the tail; bootstrap-t does so on the other side, and
of heavy tails on both. `docs/statistics.md` says how often each covers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import stdtrit

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
    """Return t* of every resample of n − 1 values, drawn as counts of the distinct ones."""
    distinct, counts = np.unique(centred, return_counts=True)
    random, n = np.random.default_rng(SEED), centred.size - 1
    found, block = [], max(1, _BLOCK // distinct.size)
    for first in range(0, RESAMPLES, block):
        drawn = random.multinomial(n, counts / (n + 1), size=min(block, RESAMPLES - first))
        means = drawn @ distinct / n
        squares = drawn @ distinct**2 / n - means**2
        constant = drawn.max(axis=1) == n
        errors = np.sqrt(np.where(constant, 1.0, np.abs(squares)) / (n - 1))
        infinite = np.where(means == 0, 0.0, np.copysign(np.inf, means))
        found.append(np.where(constant, infinite, means / errors))
    return np.concatenate(found)
