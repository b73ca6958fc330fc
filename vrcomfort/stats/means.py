"""The interval of a mean: the wider of the t and the bootstrap-t interval, at each end.

Of skewed scores, t stops short on the side of the tail; bootstrap-t does so on the other side, and
of heavy tails on both. `docs/statistics.md` says how often each covers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import stdtrit

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

RESAMPLES = 1999
SEED = 19930101
"""Of every bootstrap here; a report says it, and the same data give the same interval."""
KEPT_UP_TO = 200
"""Values up to which resamples are drawn once for samples of the same size; of more, which have few
distinct values, they are drawn as counts of those."""
ROUNDING = 1e-13
"""Of the largest value, or of its square: less is no mean, or the variance of equal values."""
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
