"""Correlations of two outcomes, and intraclass correlations of repeated measures."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import permutations
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.stats import f as f_distribution
from scipy.stats import kendalltau, norm
from scipy.stats import t as t_distribution

from vrcomfort.errors import InputError
from vrcomfort.stats.effects import EffectSize, decided_at_zero
from vrcomfort.stats.ranks import doubled_midranks, level_of, tied_count

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Ends = tuple[float | None, float | None]

# Correlations of two outcomes of the same people, with intervals and the p of their own test.


Method = Literal["pearson", "spearman", "kendall", "repeated_measures"]
ENDS = ("low", "high", "low_closed", "high_closed")
ROUNDING = 1e-12
"""Share of the sum of squares below which what is left is rounding."""
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
    low_closed: bool = True
    """Whether the end itself is in the interval."""
    high_closed: bool = True


def correlation(
    x: ArrayLike, y: ArrayLike, *, method: Method = "spearman", confidence: float = 0.95
) -> Correlation:
    """Correlate two outcomes, one pair of values of each person.

    Intervals are Fisher's z, with the standard errors √((1 + r²/2)/(n − 3)) of Spearman's ρ (Bonett
    & Wright 2000) and √(.437/(n − 4)) of Kendall's τ (Fieller, Hartley & Pearson 1957). Of
    Pearson's r it is the larger of 1/√(n − 3) and the jackknife's error of z, with t of n − 2 df:
    Fisher's alone covers .71 to .89 of skewed or heavy-tailed scores. Each says of 0 what p says.
    Spearman's p is exact up to `EXACT_SPEARMAN_UP_TO` pairs, ties or not, and from t above; that of
    Kendall's τ_b is exact without ties up to 33 pairs, else normal with ties.

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
        tau = kendalltau(one, two)
        exact = n <= 33 and not tied_count(one) and not tied_count(two)
        estimate = float(tau.statistic)
        ends = _fisher(estimate, math.sqrt(0.437 / (n - 4)) if n > 4 else None, confidence)
        p = float(tau.pvalue)
        found = Correlation(method, n, n, None, estimate, *ends, confidence, p,
                            "exact" if exact else "asymptotic")  # fmt: skip
        return _decided(found)
    if method == "spearman":
        one, two = (doubled_midranks(each).astype(np.float64) for each in (one, two))
    r = _pearson(one, two)
    if method == "pearson":
        ends = _pearson_ends(one, two, r, confidence)
    else:
        ends = _fisher(r, math.sqrt((1 + r * r / 2) / (n - 3)) if n > 3 else None, confidence)
    if method == "spearman" and n <= EXACT_SPEARMAN_UP_TO:
        p = _permutation_p(one, two)
        return _decided(Correlation(method, n, n, None, r, *ends, confidence, p, "exact"))
    p = _t_p(r, n - 2)
    return _decided(Correlation(method, n, n, n - 2, r, *ends, confidence, p, "t"))


def _decided(found: Correlation) -> Correlation:
    """Return a correlation with an interval that agrees with p about 0."""
    if found.estimate is None or found.p is None:
        return found
    ends = EffectSize(found.estimate, found.low, found.high, found.confidence)
    ends = decided_at_zero(ends, rejected=found.p <= level_of(found.confidence))
    return replace(found, **{key: value for key, value in vars(ends).items() if key in ENDS})


def _pearson_ends(x: Floats, y: Floats, r: float, confidence: float) -> Ends:
    """Return Fisher's z with the larger of its own and the jackknife's error, and t."""
    n = x.size
    if n < 4 or abs(r) == 1:
        return None, None
    error = max(1 / math.sqrt(n - 3), _jackknife_error(x - x.mean(), y - y.mean()))
    half = float(t_distribution.isf((1 - confidence) / 2, n - 2)) * error
    z = math.atanh(r)
    return math.tanh(z - half), math.tanh(z + half)


def _jackknife_error(x: Floats, y: Floats) -> float:
    """Return the jackknife's standard error of atanh r; inf where r is ±1, or none, without one."""
    n = x.size
    without = n / (n - 1)  # the sums of squares and products without a pair, both means anew
    of_x, of_y, both = x @ x, y @ y, x @ y
    xx, yy, xy = of_x - without * x * x, of_y - without * y * y, both - without * x * y
    if (xx <= ROUNDING * of_x).any() or (yy <= ROUNDING * of_y).any():
        return math.inf
    r = xy / np.sqrt(xx * yy)
    if (np.abs(r) >= 1 - ROUNDING).any():
        return math.inf
    z = np.arctanh(r)
    return math.sqrt((n - 1) / n * float(np.sum((z - z.mean()) ** 2)))


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
    r = _cosine(one, two)
    ends = _fisher(r, 1 / math.sqrt(df - 1) if df > 1 else None, confidence)
    p = _t_p(r, df)
    return _decided(Correlation("repeated_measures", n, k, df, r, *ends, confidence, p, "t"))


def _within(values: Floats, groups: NDArray[np.intp]) -> Floats:
    """Return values without the mean of their group."""
    counts = np.maximum(np.bincount(groups), 1)
    left: Floats = values - (np.bincount(groups, values) / counts)[groups]
    return left


def _pearson(x: Floats, y: Floats) -> float:
    return _cosine(x - x.mean(), y - y.mean())


def _cosine(one: Floats, two: Floats) -> float:
    """Return the correlation of centred values, which no rounding takes beyond ±1."""
    r = float(one @ two / math.sqrt((one @ one) * (two @ two)))
    return max(-1.0, min(1.0, r))


def _t_p(r: float, df: int) -> float:
    if abs(r) == 1:
        return 0.0
    return float(2 * t_distribution.sf(abs(r) * math.sqrt(df / (1 - r * r)), df))


def _fisher(r: float, error: float | None, confidence: float) -> Ends:
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


# Intraclass correlations: how much of the variance lies between people (Shrout & Fleiss 1979).


@dataclass(frozen=True)
class Intraclass:
    """One of the six forms, with its F test and interval (McGraw & Wong 1996)."""

    form: str
    """1,1 one-way; 2,1 two-way, agreement; 3,1 two-way, consistency; k: of the mean of k."""
    estimate: float
    low: float
    high: float
    f: float
    df_effect: int
    df_error: int
    p: float
    confidence: float


def intraclass(scores: ArrayLike, *, confidence: float = 0.95) -> tuple[Intraclass, ...]:
    """Return ICC(1,1), (2,1), (3,1), (1,k), (2,k) and (3,k) of people × occasions.

    Raises
    ------
    InputError
        With fewer than two people or occasions, or without any variance left for an error.
    """
    values = np.asarray(scores, dtype=np.float64)
    if values.ndim != 2 or min(values.shape) < 2:
        raise InputError("an intraclass correlation needs two people and two occasions")
    squares = _MeanSquares.of(values)
    return tuple(
        each(squares, mean=mean, confidence=confidence)
        for mean in (False, True)
        for each in (_one_way, _agreement, _consistency)
    )


@dataclass(frozen=True)
class _MeanSquares:
    n: int
    k: int
    people: float
    occasions: float
    within: float
    """Of people: occasions and error together."""
    error: float

    @classmethod
    def of(cls, values: NDArray[np.float64]) -> _MeanSquares:
        n, k = values.shape
        centred = values - values.mean()
        people = k * float(np.sum(centred.mean(axis=1) ** 2))
        occasions = n * float(np.sum(centred.mean(axis=0) ** 2))
        total = float(np.sum(centred**2))
        left = total - people - occasions
        if left <= ROUNDING * total:
            raise InputError("the scores leave no variance for an error")
        people, occasions = (x if x > ROUNDING * total else 0.0 for x in (people, occasions))
        return cls(
            n, k, people / (n - 1), occasions / (k - 1), (total - people) / (n * (k - 1)),
            left / ((n - 1) * (k - 1)),
        )  # fmt: skip


def _one_way(squares: _MeanSquares, *, mean: bool, confidence: float) -> Intraclass:
    df = squares.n * (squares.k - 1)
    return _ratio("1", squares, squares.within, df, mean=mean, confidence=confidence)


def _consistency(squares: _MeanSquares, *, mean: bool, confidence: float) -> Intraclass:
    df = (squares.n - 1) * (squares.k - 1)
    return _ratio("3", squares, squares.error, df, mean=mean, confidence=confidence)


def _ratio(
    form: str, squares: _MeanSquares, error: float, df: int, *, mean: bool, confidence: float
) -> Intraclass:
    """Return the forms that follow from one F."""
    n, k, tail = squares.n, squares.k, (1 - confidence) / 2
    f = squares.people / error
    low = f / float(f_distribution.isf(tail, n - 1, df))
    high = f * float(f_distribution.isf(tail, df, n - 1))
    if mean:
        estimate, low, high = (1 - 1 / ratio if ratio else -np.inf for ratio in (f, low, high))
    else:
        estimate, low, high = ((ratio - 1) / (ratio + k - 1) for ratio in (f, low, high))
    p = float(f_distribution.sf(f, n - 1, df))
    name = f"{form},{'k' if mean else '1'}"
    return Intraclass(name, estimate, low, high, f, n - 1, df, p, confidence)


def _agreement(squares: _MeanSquares, *, mean: bool, confidence: float) -> Intraclass:
    """Return the form that counts differences between occasions as error."""
    n, k, tail = squares.n, squares.k, (1 - confidence) / 2
    people, occasions, error = squares.people, squares.occasions, squares.error
    df_error = (n - 1) * (k - 1)
    least = -1 / (k - 1)  # the answers of one person cannot be more unlike
    variance = people + (k - 1) * error + k * (occasions - error) / n
    # Of two people on two occasions, with equal means of both, no variance is estimated.
    icc = max((people - error) / variance, least) if variance else least
    a, b = k * icc / (n * (1 - icc)), 1 + k * icc * (n - 1) / (n * (1 - icc))
    mixed = a * occasions + b * error
    df = mixed**2 / ((a * occasions) ** 2 / (k - 1) + (b * error) ** 2 / df_error)
    above = float(f_distribution.isf(tail, n - 1, df))
    below = float(f_distribution.isf(tail, df, n - 1))
    rest = k * occasions + (k * n - k - n) * error
    low, high = -math.inf, math.inf
    if rest or people:
        low = n * (people - above * error) / (above * rest + n * people)
        high = n * (below * people - error) / (rest + n * below * people)
    f = people / error
    p = float(f_distribution.sf(f, n - 1, df_error))
    # The approximate df can be so few that the ends change their places.
    low = min(max(low, least), icc) if np.isfinite(low) else least
    high = max(high, icc) if np.isfinite(high) else 1.0
    if mean:
        icc, low, high = (_of_the_mean(each, k) for each in (icc, low, high))
    name = f"2,{'k' if mean else '1'}"
    return Intraclass(name, icc, low, high, f, n - 1, df_error, p, confidence)


def _of_the_mean(icc: float, k: int) -> float:
    """Return the correlation of the mean of k (Spearman–Brown); that of −1/(k − 1) has no end."""
    return k * icc / (1 + (k - 1) * icc) if icc > -1 / (k - 1) else -np.inf
