"""The JZS Bayes factor of a t test (Rouder et al. 2009)."""

from __future__ import annotations

import math

import numpy as np

from vrcomfort.stats.packages import pingouin, quiet

PRIOR_SCALE = 2**-0.5
"""Of the Cauchy prior on the standardised difference, as in R's ``BayesFactor`` ("medium"); the
default of pingouin, .707, differs from it in the fifth digit of the Bayes factor."""


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
