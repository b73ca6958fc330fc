"""The paired t test and its Bayes factor, beside the rank tests: what papers of means compare."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import stdtrit

from vrcomfort.stats.packages import pingouin, quiet

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vrcomfort.stats.ranks import Alternative

PRIOR_SCALE = 2**-0.5
"""Of the Cauchy prior on the standardised difference, as in R's ``BayesFactor`` ("medium"); the
default of pingouin, .707, differs from it in the fifth digit of the Bayes factor."""


@dataclass(frozen=True)
class PairedT:
    """A t test of paired differences."""

    n: int
    mean: float
    standard_error: float
    df: int
    t: float
    p: float
    low: float | None
    """None: no bound on that side, as with one-sided tests."""
    high: float | None
    confidence: float
    alternative: Alternative
    cohen_dz: float
    """Mean over the standard deviation of the differences."""
    bayes_factor_10: float
    """JZS (Rouder et al. 2009), two-sided: how much likelier a difference makes the data; infinite
    where it is larger than a float64 can be."""


def paired_t(
    differences: ArrayLike,
    unit: float = 1.0,
    *,
    alternative: Alternative = "two-sided",
    confidence: float = 0.95,
) -> PairedT | None:
    """Test whether the mean of paired differences is zero.

    t, p and the Bayes factor are pingouin's. Its interval is rounded to two decimals and its
    ``cohen-d`` is that of two groups, so those are ours.

    Parameters
    ----------
    differences
        First minus second, in steps of the scale, shape (n,).
    unit
        Points per step.

    Returns
    -------
    PairedT or None
        None with fewer than two differences, or if all are alike: there is no t then.
    """
    values = np.asarray(differences, dtype=np.float64)
    if values.size < 2 or np.ptp(values) == 0:
        return None
    with quiet(), np.errstate(over="ignore"):
        found = pingouin().ttest(values, 0.0, alternative=alternative).iloc[0]
        t, df = float(found["T"]), int(found["dof"])
    bayes = jzs_bayes_factor(t, values.size)
    mean, error = float(values.mean()), float(values.std(ddof=1) / np.sqrt(values.size))
    sides = 2 if alternative == "two-sided" else 1
    half = float(stdtrit(df, 1 - (1 - confidence) / sides)) * error
    return PairedT(
        n=values.size,
        mean=mean * unit,
        standard_error=error * unit,
        df=df,
        t=t,
        p=float(found["p_val"]),
        low=None if alternative == "less" else (mean - half) * unit,
        high=None if alternative == "greater" else (mean + half) * unit,
        confidence=confidence,
        alternative=alternative,
        cohen_dz=mean / float(values.std(ddof=1)),
        bayes_factor_10=bayes,
    )


def jzs_bayes_factor(t: float, n: int, m: int | None = None) -> float:
    """Return pingouin's, two-sided; it divides by a likelihood that underflows at a very large t.

    Parameters
    ----------
    n, m
        Sizes of both groups; `m` None for n differences.
    """
    try:
        with quiet(), np.errstate(over="ignore"):
            found = pingouin().bayesfactor_ttest(t, n, m, paired=m is None, r=PRIOR_SCALE)
        return float(found)
    except ZeroDivisionError:
        return math.inf
