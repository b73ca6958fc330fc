"""The Mann–Whitney test of two groups of different people, exact with ties.

As in `signed_rank`, everything is computed on integer scores, so that ties are ties.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq
from scipy.stats import norm

from vrcomfort.stats.effects import EffectSize, decided_at_zero
from vrcomfort.stats.ranks import ExactOrAsymptotic, doubled_midranks, level_of, tied_count
from vrcomfort.stats.shift import Shift

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from vrcomfort.stats.ranks import Alternative, Integers
    from vrcomfort.stats.signed_rank import PValue

EXACT_UP_TO = 100
"""People up to whom the exact distribution is computed, both groups together: there a test with
its interval costs less than half a second, and the asymptotic p is off by 3 % of itself
(``python -m bench.p_values``)."""
OUTWARDS = 12
"""Places looked at beyond the first shift that is rejected: p may rise again with ties."""
DOUBT = 0.2
"""Share of the level down to which the asymptotic p is not trusted far outside to say that the test
rejects."""
# Brackets of the other root end before 0 and 1, which are roots themselves.
ALMOST = 1 - 1e-9
NEAR = 12
"""Differences on either side of the median at which a shift that is not rejected is looked for."""


@dataclass(frozen=True)
class MannWhitney(ExactOrAsymptotic):
    """One test of two groups, with everything a paper reports about it."""

    n_a: int
    n_b: int
    ties: int
    """Scores that share their value with another, of either group."""
    alternative: Alternative
    u: float
    """Pairs of people in which a is higher, ties counting a half."""
    z: float | None
    """Tie-corrected, without continuity correction; None if all scores are alike."""
    p_exact: float | None
    p_asymptotic: float
    shift: Shift | None
    """Hodges–Lehmann: median of the differences between everybody of a and everybody of b."""
    effect: EffectSize | None
    """Rank-biserial correlation: 2 P(a > b) − 1, a tie counting a half."""


def mann_whitney(
    a: ArrayLike,
    b: ArrayLike,
    unit: float = 1.0,
    *,
    alternative: Alternative = "two-sided",
    p_value: PValue = "exact",
    confidence: float = 0.95,
    intervals: bool = True,
) -> MannWhitney | None:
    """Test whether scores of one group tend to be higher than those of another.

    Parameters
    ----------
    a, b
        Integer scores, shapes (n,) and (m,).
    unit
        Points per step; used for the shift only.
    p_value
        ``exact``: given the ties, up to `EXACT_UP_TO` people; two-sided it is the probability of
        a rank sum at least as far from its expectation (as R's ``coin`` has it).

    Returns
    -------
    MannWhitney or None
        None where a group is empty. The interval of the shift is the closed hull of the shifts that
        this very test, ranked anew, does not reject (without 0 where it rejects that); that of the
        effect is Newcombe's (2006, method 5), which has a width with complete separation as well,
        and says of 0 what p says.

    Examples
    --------
    >>> test = mann_whitney([3, 4, 2, 6, 2, 5], [9, 7, 5, 10, 6, 8])
    >>> test.u, round(test.p, 4), test.shift.estimate
    (2.0, 0.0108, -4.0)
    """
    first, second = (np.asarray(each, dtype=np.int64) for each in (a, b))
    if not first.size or not second.size:
        return None
    sums = _RankSum.of(first, second)
    exact = p_value == "exact" and first.size + second.size <= EXACT_UP_TO
    test = MannWhitney(
        n_a=first.size,
        n_b=second.size,
        ties=tied_count(np.concatenate([first, second])),
        alternative=alternative,
        u=sums.u,
        z=sums.z,
        p_exact=sums.exact_p(alternative) if exact else None,
        p_asymptotic=sums.normal_p(alternative),
        shift=None,
        effect=None,
    )
    if not intervals:
        return test
    shift = _shift(first, second, unit, test, confidence)
    effect = superiority_interval(sums.u, first.size, second.size, alternative, confidence)
    effect = decided_at_zero(effect, rejected=test.p <= level_of(confidence))
    return replace(test, shift=shift, effect=effect)


@dataclass(frozen=True)
class _RankSum:
    """The doubled rank sum of a, and the doubled midranks of both groups."""

    total: int
    n_a: int
    ranks: Integers

    @classmethod
    def of(cls, a: Integers, b: Integers) -> _RankSum:
        ranks = doubled_midranks(np.concatenate([a, b]))
        return cls(int(ranks[: a.size].sum()), int(a.size), ranks)

    @property
    def u(self) -> float:
        return (self.total - self.n_a * (self.n_a + 1)) / 2

    @property
    def expected(self) -> int:
        """Twice the expected doubled sum over n: n_a (N + 1) is the expectation of `total`."""
        return self.n_a * (self.ranks.size + 1)

    @property
    def z(self) -> float | None:
        n, m = self.n_a, self.ranks.size - self.n_a
        spread = float(np.sum((self.ranks - (self.ranks.size + 1.0)) ** 2))
        if spread == 0:
            return None
        return (self.total - self.expected) / math.sqrt(n * m / (n + m) * spread / (n + m - 1))

    def normal_p(self, alternative: Alternative) -> float:
        if self.z is None:
            return 1.0
        if alternative == "two-sided":
            return float(2 * norm.sf(abs(self.z)))
        return float(norm.sf(self.z if alternative == "greater" else -self.z))

    def exact_p(self, alternative: Alternative) -> float:
        step = int(np.gcd.reduce(self.ranks))
        sums = rank_sum_distribution(self.ranks // step, self.n_a)
        place = step * np.arange(sums.size)
        if alternative == "two-sided":
            far = np.abs(place - self.expected) >= abs(self.total - self.expected)
        else:
            far = place >= self.total if alternative == "greater" else place <= self.total
        return min(1.0, float(sums[far].sum()))


def rank_sum_distribution(doubled_ranks: Integers, n: int) -> np.ndarray[tuple[int], np.dtype]:
    """Return the null probabilities of the doubled rank sum of n of the people.

    Every choice of n is as likely. Ranks are added one at a time to tables of (people chosen,
    sum), as Streitberg & Röhmel (1986) do; exact whatever the ties.

    Returns
    -------
    ndarray, shape (sum(doubled_ranks) + 1,)
        Element s is P(sum = s).
    """
    ranks = np.sort(np.asarray(doubled_ranks, dtype=np.int64))
    size, whole = ranks.size, int(ranks.sum())
    if 2 * n > size:  # the others are fewer, and their sum is what is left
        return rank_sum_distribution(ranks, size - n)[::-1]
    top = int(ranks[size - n :].sum())
    ways = np.zeros((n + 1, top + 1))
    ways[0, 0] = 1.0
    reached = 0
    for place, rank in enumerate(ranks.tolist()):
        chosen = min(place + 1, n)
        reached = min(reached + rank, top)
        ways[1 : chosen + 1, rank : reached + 1] += ways[:chosen, : reached + 1 - rank].copy()
    found = np.zeros(whole + 1)
    found[: top + 1] = ways[n] / math.comb(size, n)
    return found


def superiority_interval(
    u: float, n: int, m: int, alternative: Alternative, confidence: float
) -> EffectSize:
    """Return 2 P(a > b) − 1 with Newcombe's (2006) interval of P, his method 5.

    Its ends are the θ with (θ̂ − θ)² = z² V(θ), V that of Hanley & McNeil (1982) with both groups
    as large as their mean.
    """
    theta = u / (n * m)
    sides = 2 if alternative == "two-sided" else 1
    z = float(norm.isf((1 - confidence) / sides))
    half = (n + m) / 2 - 1

    def variance(x: float) -> float:
        more = half * ((1 - x) / (2 - x) + x / (1 + x))
        return x * (1 - x) * (1 + more) / (n * m)

    def excess(x: float) -> float:
        return (theta - x) ** 2 - z * z * variance(x)

    # 0 and 1 have no variance and are roots themselves where θ̂ is there: the other one is meant.
    low = 0.0 if theta == 0 else float(brentq(excess, 0.0, min(theta, ALMOST), xtol=1e-14))
    high = 1.0 if theta == 1 else float(brentq(excess, max(theta, 1 - ALMOST), 1.0, xtol=1e-14))
    low = -1.0 if alternative == "less" else 2 * low - 1
    high = 1.0 if alternative == "greater" else 2 * high - 1
    return EffectSize(2 * theta - 1, low, high, confidence)


def _shift(
    a: Integers, b: Integers, unit: float, test: MannWhitney, confidence: float
) -> Shift | None:
    """Return the median difference with the hull of the shifts that the test does not reject."""
    exact, level = test.p_exact is not None, level_of(confidence)

    def accepts(side: Alternative) -> Callable[[Integers, Integers, bool], bool]:
        def accepted(first: Integers, second: Integers, far: bool) -> bool:
            sums = _RankSum.of(first, second)
            if not exact:
                return sums.normal_p(side) > level
            if far and sums.normal_p(side) <= DOUBT * level:
                return False
            return sums.exact_p(side) > level

        return accepted

    mirrored: dict[Alternative, Alternative] = {"greater": "less", "less": "greater"}
    other = mirrored.get(test.alternative, test.alternative)
    low = _lower_end(a, b, accepts(test.alternative))
    high = _lower_end(-a, -b, accepts(other))
    end = None if high is None else -high[0]
    found = Shift(
        estimate=float(np.median(np.subtract.outer(a, b))) * unit,
        low=None if low is None else low[0] * unit,
        high=None if end is None else (end + 0.0) * unit,
        # On a grid of scores the median difference lies on the grid, and there, with ties, the test
        # asks for something else: an end is left out alone where it is 0, of which p has decided.
        low_closed=low is not None and (low[1] or low[0] != 0),
        high_closed=high is not None and (high[1] or high[0] != 0),
        confidence=confidence,
        coverage=None,
        n=test.n_a + test.n_b,
        zeros_included=True,
    )
    return replace(found, holds_rejected_zero=test.p <= level and _holds_zero(found))


def _holds_zero(shift: Shift) -> bool:
    above = shift.low is None or shift.low < 0 or (shift.low == 0 and shift.low_closed)
    return above and (
        shift.high is None or shift.high > 0 or (shift.high == 0 and shift.high_closed)
    )


def _lower_end(
    a: Integers, b: Integers, accepts: Callable[[Integers, Integers, bool], bool]
) -> tuple[float, bool] | None:
    """Return the lowest shift of a that is not rejected, and whether it is so itself.

    The test changes at the differences of a and b alone, and is the same between two of them:
    place 2 k + 1 is the difference number k, place 2 k just below it. None: no bound.
    """
    differences = np.unique(np.subtract.outer(a, b))
    ends = differences.size

    @cache
    def accepted(place: int, far: bool = False) -> bool:
        at, between = divmod(place, 2)
        if between:
            theta2 = 2 * int(differences[at])
        elif at == ends:
            theta2 = 2 * int(differences[-1]) + 1
        else:
            theta2 = 2 * int(differences[at]) - 1
        return accepts(2 * a - theta2, 2 * b, far)

    if accepted(0):
        return None
    middle = int(np.searchsorted(differences, np.median(np.subtract.outer(a, b))))
    start = 2 * min(middle, ends - 1) + 1
    near = sorted(range(max(0, start - 2 * NEAR), min(2 * ends, start + 2 * NEAR) + 1),
                  key=lambda place: abs(place - start))  # fmt: skip
    inside = next(filter(accepted, near), None)
    if inside is None:  # so many ties that p jumps from one side's rejection to the other's
        return float(differences[min(middle, ends - 1)]), True
    low, high = 0, inside
    while high - low > 1:
        between = (low + high) // 2
        low, high = (low, between) if accepted(between) else (between, high)
    for place in range(high - 1, max(0, high - OUTWARDS), -1):
        high = place if accepted(place, True) else high
    at, on = divmod(high, 2)
    if on:
        return float(differences[at]), True
    return float(differences[at - 1]), False
