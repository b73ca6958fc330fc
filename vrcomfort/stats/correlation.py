"""Correlations of two outcomes of the same people, with intervals and the p of their own test."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import permutations
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.stats import kendalltau, norm
from scipy.stats import t as t_distribution

from vrcomfort.stats.ranks import doubled_midranks, tied_count

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

Method = Literal["pearson", "spearman", "kendall", "repeated_measures"]
EXACT_SPEARMAN_UP_TO = 8
"""Pairs up to which p comes from every order of the ranks."""


@dataclass(frozen=True)
class Correlation:
    """A correlation; estimate and p are None where one of both does not vary."""

    method: Method
    n: int
    """Pairs of values; of repeated measures, of several for each person."""
    people: int
    df: int | None
    """Of t (pearson, repeated measures, spearman above `EXACT_SPEARMAN_UP_TO`)."""
    estimate: float | None
    low: float | None
    """None with fewer than four pairs (five of Kendall), and where all lie on a line."""
    high: float | None
    confidence: float
    p: float | None
    p_method: Literal["exact", "asymptotic", "t"] | None


def correlation(
    x: ArrayLike, y: ArrayLike, *, method: Method = "pearson", confidence: float = 0.95
) -> Correlation:
    """Correlate two outcomes, one pair of values of each person.

    Intervals are Fisher's z, with the standard errors 1/√(n − 3) of Pearson's r, √((1 + r²/2)/(n −
    3)) of Spearman's (Bonett & Wright 2000) and √(.437/(n − 4)) of Kendall's (Fieller, Hartley &
    Pearson 1957). p of Spearman is exact up to `EXACT_SPEARMAN_UP_TO` pairs, ties or not, and
    from t above; Kendall's τ_b is exact without ties up to 33 pairs, else normal with ties.

    Parameters
    ----------
    x, y
        Shape (n,), without missing values.
    """
    one, two = (np.asarray(each, dtype=np.float64) for each in (x, y))
    n = one.size
    nothing = Correlation(method, n, n, None, None, None, None, confidence, None, None)
    if n < 3 or np.ptp(one) == 0 or np.ptp(two) == 0:
        return nothing
    if method == "kendall":
        found = kendalltau(one, two)
        exact = n <= 33 and not tied_count(one) and not tied_count(two)
        estimate = float(found.statistic)
        low, high = _fisher(estimate, math.sqrt(0.437 / (n - 4)) if n > 4 else None, confidence)
        return Correlation(method, n, n, None, estimate, low, high, confidence,
                           float(found.pvalue), "exact" if exact else "asymptotic")  # fmt: skip
    if method == "spearman":
        one, two = (doubled_midranks(each).astype(np.float64) for each in (one, two))
    r = _pearson(one, two)
    wide = 1 + r * r / 2 if method == "spearman" else 1.0
    low, high = _fisher(r, math.sqrt(wide / (n - 3)) if n > 3 else None, confidence)
    if method == "spearman" and n <= EXACT_SPEARMAN_UP_TO:
        p = _permutation_p(one, two)
        return Correlation(method, n, n, None, r, low, high, confidence, p, "exact")
    return Correlation(method, n, n, n - 2, r, low, high, confidence, _t_p(r, n - 2), "t")


def repeated_measures_correlation(
    x: ArrayLike, y: ArrayLike, people: ArrayLike, *, confidence: float = 0.95
) -> Correlation:
    """Correlate two outcomes within people: one slope for all, a level for each.

    After Bland & Altman (1995) and Bakdash & Marusich (2017). People with one pair of values say
    nothing and are left out.

    Parameters
    ----------
    x, y, people
        Shape (n,): several pairs of values of each person.
    """
    one, two = (np.asarray(each, dtype=np.float64) for each in (x, y))
    _, groups, sizes = np.unique(np.asarray(people), return_inverse=True, return_counts=True)
    kept = sizes[groups] > 1
    one, two, groups = one[kept], two[kept], groups[kept]
    n, k = one.size, int((sizes > 1).sum())
    df = n - k - 1
    one, two = _within(one, groups), _within(two, groups)
    rounding = 1e-12
    flat = [not each.size or float(np.abs(each).max()) <= rounding for each in (one, two)]
    if df < 1 or any(flat):
        return Correlation("repeated_measures", n, k, None, None, None, None, confidence, None,
                           None)  # fmt: skip
    r = float(one @ two / math.sqrt((one @ one) * (two @ two)))
    low, high = _fisher(r, 1 / math.sqrt(df - 1) if df > 1 else None, confidence)
    return Correlation("repeated_measures", n, k, df, r, low, high, confidence, _t_p(r, df), "t")


def _within(values: Floats, groups: NDArray[np.intp]) -> Floats:
    """Return values without the mean of their group."""
    counts = np.maximum(np.bincount(groups), 1)
    left: Floats = values - (np.bincount(groups, values) / counts)[groups]
    return left


def _pearson(x: Floats, y: Floats) -> float:
    one, two = x - x.mean(), y - y.mean()
    r = float(one @ two / math.sqrt((one @ one) * (two @ two)))
    return max(-1.0, min(1.0, r))


def _t_p(r: float, df: int) -> float:
    if abs(r) == 1:
        return 0.0
    return float(2 * t_distribution.sf(abs(r) * math.sqrt(df / (1 - r * r)), df))


def _fisher(r: float, error: float | None, confidence: float) -> tuple[float | None, float | None]:
    if error is None or abs(r) == 1:
        return None, None
    half = float(norm.isf((1 - confidence) / 2)) * error
    z = math.atanh(r)
    return math.tanh(z - half), math.tanh(z + half)


def _permutation_p(x: Floats, y: Floats) -> float:
    """Return the share of the orders of y that correlate at least as much; ranks are doubled."""
    orders = np.array(list(permutations(range(y.size))))
    mean = float(x.sum() * y.sum()) / x.size
    products = np.abs(y[orders] @ x - mean)
    return float(np.mean(products >= abs(float(x @ y) - mean) - 1e-9))
