"""Counts and shares: the sign test, exact intervals, preferences, Fisher's exact test."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import beta, binom, norm
from scipy.stats import fisher_exact as scipy_fisher_exact

from vrcomfort.stats.effects import EffectSize
from vrcomfort.stats.ranks import level_of
from vrcomfort.stats.shift import Shift

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vrcomfort.stats.ranks import Alternative


@dataclass(frozen=True)
class SignTest:
    """How many differences are positive, against a half of them."""

    positive: int
    negative: int
    zeros: int
    alternative: Alternative
    p: float
    """Exact; 1 where every difference is zero."""
    share: EffectSize | None
    """Share of positive ones among those that are not zero, with Clopper & Pearson's (1934)
    interval; None where there is none."""
    median: Shift | None
    """Median of all differences; its interval is between two of them (Conover 1999)."""


def sign_test(
    differences: ArrayLike,
    unit: float = 1.0,
    *,
    alternative: Alternative = "two-sided",
    confidence: float = 0.95,
) -> SignTest:
    """Test whether positive and negative differences are as likely; zeros are left out of p.

    Parameters
    ----------
    differences
        Integers, shape (n,).
    """
    values = np.asarray(differences, dtype=np.int64)
    positive, negative = int((values > 0).sum()), int((values < 0).sum())
    return SignTest(
        positive=positive,
        negative=negative,
        zeros=int(values.size) - positive - negative,
        alternative=alternative,
        p=_binomial_p(positive, positive + negative, alternative),
        share=clopper_pearson(positive, positive + negative, alternative, confidence),
        median=_median(values, unit, alternative, confidence),
    )


def _binomial_p(count: int, n: int, alternative: Alternative) -> float:
    if n == 0:
        return 1.0
    above, below = float(binom.sf(count - 1, n, 0.5)), float(binom.cdf(count, n, 0.5))
    if alternative == "two-sided":
        return min(1.0, 2 * min(above, below))
    return above if alternative == "greater" else below


def clopper_pearson(
    count: int, n: int, alternative: Alternative = "two-sided", confidence: float = 0.95
) -> EffectSize | None:
    """Return a share with its exact interval; None of nothing."""
    if n == 0:
        return None
    tail = (1 - confidence) / (2 if alternative == "two-sided" else 1)
    low = 0.0 if count == 0 else float(beta.ppf(tail, count, n - count + 1))
    high = 1.0 if count == n else float(beta.isf(tail, count + 1, n - count))
    low = 0.0 if alternative == "less" else low
    high = 1.0 if alternative == "greater" else high
    return EffectSize(count / n, low, high, confidence)


def _median(
    values: np.ndarray[tuple[int], np.dtype[np.int64]],
    unit: float,
    alternative: Alternative,
    confidence: float,
) -> Shift | None:
    if not values.size:
        return None
    n, ordered = values.size, np.sort(values)
    sides = 2 if alternative == "two-sided" else 1
    tail = (1 - confidence) / sides
    # The largest k with P(at most k − 1 of n below the median) ≤ tail.
    rank = int(binom.ppf(tail, n, 0.5))
    rank += int(binom.cdf(rank, n, 0.5) <= tail)
    has = rank > 0
    low = int(ordered[rank - 1]) if has and alternative != "less" else None
    high = int(ordered[n - rank]) if has and alternative != "greater" else None

    def kept(end: int | None) -> bool:
        """Return whether the test, without the differences at this end, does not reject it."""
        if end is None:
            return False
        above, below = int((values > end).sum()), int((values < end).sum())
        return _binomial_p(above, above + below, alternative) > level_of(confidence)

    return Shift(
        float(np.median(ordered)) * unit,
        None if low is None else low * unit,
        None if high is None else high * unit,
        kept(low),
        kept(high),
        confidence,
        1 - sides * float(binom.cdf(rank - 1, n, 0.5)) if has else None,
        int(n),
        zeros_included=True,
    )


def wilson(count: int, n: int, confidence: float = 0.95) -> EffectSize | None:
    """Return a share with Wilson's interval; None of nothing."""
    if n == 0:
        return None
    return EffectSize(count / n, *wilson_bounds(count, n, confidence), confidence)


def wilson_bounds(count: int, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return the interval of a share (Wilson 1927): never outside 0 and 1, and good near both."""
    z = float(norm.isf((1 - confidence) / 2))
    share, spread = count / n, z * z / n
    centre = (share + spread / 2) / (1 + spread)
    half = z / (1 + spread) * math.sqrt(share * (1 - share) / n + spread / (4 * n))
    low = 0.0 if count == 0 else max(0.0, centre - half)
    high = 1.0 if count == n else min(1.0, centre + half)
    return low, high


@dataclass(frozen=True)
class Preference:
    """How many preferred a, b or neither."""

    a: int
    b: int
    none: int
    shares: tuple[EffectSize | None, EffectSize | None, EffectSize | None]
    """Of a, b and neither among all, each with Wilson's interval."""
    p: float
    """Sign test of a against b, two-sided; those without a preference are left out of it."""
    share_of_a: EffectSize | None
    """Among those with a preference, with Clopper & Pearson's interval."""


def preference(a: int, b: int, none: int, *, confidence: float = 0.95) -> Preference:
    """Describe and test choices of two with the answer “neither”."""
    n = a + b + none
    return Preference(
        a, b, none,
        (wilson(a, n, confidence), wilson(b, n, confidence), wilson(none, n, confidence)),
        _binomial_p(a, a + b, "two-sided"),
        clopper_pearson(a, a + b, "two-sided", confidence),
    )  # fmt: skip


def fisher_exact(counts: ArrayLike) -> float:
    """Two-sided p of Fisher's exact test for a 2 × 2 table of counts."""
    return float(scipy_fisher_exact(np.asarray(counts, dtype=np.int64)).pvalue)
