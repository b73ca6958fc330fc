"""The two-period crossover: condition, period and sequence (carry-over) effects.

With one value per participant and period, the mixed model with a random participant has a
closed form: condition and period are tested on the differences between periods, the sequence
on the sums (Grizzle 1965; Jones & Kenward 2014, chapter 2). The estimates, standard errors and
degrees of freedom equal those of the mixed model with Satterthwaite's method.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import stdtr, stdtrit

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Estimate:
    """A fixed effect with its t test."""

    estimate: float
    standard_error: float
    df: float
    t: float | None
    p: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Crossover:
    """The three effects of an AB/BA crossover, in points of the score."""

    n_ab: int
    n_ba: int
    condition: Estimate
    """a minus b."""
    period: Estimate
    """Second period minus first."""
    sequence: Estimate
    """Sequence ba minus ab, of the participants' means; carry-over shows here."""


def crossover(
    first: ArrayLike, second: ArrayLike, a_first: ArrayLike, *, confidence: float = 0.95
) -> Crossover:
    """Analyse a two-period crossover.

    Parameters
    ----------
    first, second
        Scores in the first and second period, shape (n,).
    a_first
        Whether the participant had condition a in the first period, shape (n,).

    Raises
    ------
    InputError
        If a sequence has nobody, or there are fewer than three participants.
    """
    one, two = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    ab = np.asarray(a_first, dtype=bool)
    if not ab.any() or ab.all():
        raise InputError("a crossover analysis needs participants in both orders")
    if ab.size < 3:
        raise InputError("a crossover analysis needs at least three participants")
    half, mean = (one - two) / 2, (one + two) / 2
    return Crossover(
        n_ab=int(ab.sum()),
        n_ba=int((~ab).sum()),
        condition=_difference(half[ab], half[~ab], confidence),
        period=_difference(-half[ab], half[~ab], confidence),
        sequence=_difference(mean[~ab], mean[ab], confidence),
    )


def _difference(x: NDArray[np.float64], y: NDArray[np.float64], confidence: float) -> Estimate:
    """Estimate mean(x) − mean(y) with the pooled variance."""
    df = x.size + y.size - 2
    squares = np.sum((x - x.mean()) ** 2) + np.sum((y - y.mean()) ** 2)
    error = float(np.sqrt(squares / df * (1 / x.size + 1 / y.size)))
    return t_estimate(float(x.mean() - y.mean()), error, df, confidence)


def t_estimate(estimate: float, error: float, df: float, confidence: float) -> Estimate:
    """Return `estimate` with its two-sided t test; no test without error variance."""
    if not error > 0:
        return Estimate(estimate, error, df, None, None, None, None)
    t = estimate / error
    half = float(stdtrit(df, (1 + confidence) / 2)) * error
    p = float(2 * stdtr(df, -abs(t)))
    return Estimate(estimate, error, df, t, p, estimate - half, estimate + half)
