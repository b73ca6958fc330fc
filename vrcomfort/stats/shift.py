"""Hodges-Lehmann shift: Walsh averages, and intervals by order statistics or test inversion."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import norm

from vrcomfort.stats.ranks import fewest_for_interval, sign_flip_distribution

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    Integers = NDArray[np.int64]

# Order statistics of Walsh averages, without making the n(n+1)/2 of them.
#
# A Walsh average is the mean of two differences, or one of them. Of integers, twice the average
# is an integer as well: the sums of pairs. They are counted by a binary search for each
# difference, so one order statistic costs O(n log n) for each bit of the range (after Johnson &
# Mizoguchi 1978).


class WalshSums:
    """The sums d_i + d_j, i ≤ j, of integers: twice the Walsh averages."""

    def __init__(self, differences: ArrayLike) -> None:
        self._values: NDArray[np.int64] = np.sort(np.asarray(differences, dtype=np.int64))
        self.count = self._values.size * (self._values.size + 1) // 2

    def at_most(self, bound: int) -> int:
        """Return how many sums are ≤ `bound`."""
        ordered = int(np.searchsorted(self._values, bound - self._values, side="right").sum())
        own = int(np.searchsorted(2 * self._values, bound, side="right"))
        return (ordered + own) // 2  # pairs were counted twice, a difference with itself once

    def order_statistic(self, rank: int) -> int:
        """Return the sum of a 1-based rank from below."""
        low, high = 2 * int(self._values[0]), 2 * int(self._values[-1])
        while low < high:
            middle = (low + high) // 2
            if self.at_most(middle) >= rank:
                high = middle
            else:
                low = middle + 1
        return low

    def median_of_four(self) -> int:
        """Return four times the median Walsh average, which is an integer."""
        below, above = (self.count + 1) // 2, self.count // 2 + 1
        first = self.order_statistic(below)
        return first + (first if above == below else self.order_statistic(above))

    def below(self, bound: int) -> int | None:
        """Return the largest sum < `bound`."""
        places = np.searchsorted(self._values, bound - self._values, side="left") - 1
        first = np.flatnonzero(places >= 0)
        sums = self._values[first] + self._values[places[first]]
        return int(sums.max()) if sums.size else None


# The interval of a shift that a signed-rank test does not reject.
#
# The test is made again of d − θ, ranked anew, for every θ that matters. Its result changes only
# where θ is a Walsh average (there differences tie, or become zero) and is the same in between.
# With integer differences all of these places are integers in quarters of a step, so nothing is
# rounded.


# Walsh averages lie on half steps; a quarter is between any two of them.
QUARTERS = 4
DOUBT = 0.5
"""Share of the level down to which the asymptotic p is not trusted to say that the test rejects."""
PLACES = 12
"""Walsh averages on either side of the median at which an accepted shift is looked for."""
MOST_STEPS = 400
"""Walsh averages looked at beyond the first that is rejected; reached with n > 100 alone."""


@dataclass(frozen=True)
class Bound:
    """One end of a hull, in steps of the scale."""

    value: float
    closed: bool
    """Whether the end itself is not rejected."""


@dataclass(frozen=True)
class Hull:
    """The smallest interval with every shift that the test does not reject; None: no bound."""

    low: Bound | None
    high: Bound | None

    def contains(self, value: float) -> bool:
        """Return whether a shift lies in the hull."""
        low = self.low is None or _inside(value - self.low.value, self.low)
        return low and (self.high is None or _inside(self.high.value - value, self.high))


def _inside(distance: float, bound: Bound) -> bool:
    return distance > 0 or (distance == 0 and bound.closed)


def invert(
    differences: Integers,
    p_of: Callable[[Integers], float],
    rough_p_of: Callable[[Integers], float],
    *,
    level: float,
) -> Hull:
    """Return the hull of the shifts θ with p(d − θ) > `level`.

    p is not quite monotone in θ with ties, so the search goes on outwards from the first rejected
    shift as long as a rougher p, that is cheaper, is above `DOUBT` times the level.

    Parameters
    ----------
    differences
        Integers, shape (n,), n ≥ 1.
    p_of, rough_p_of
        p of integer differences, exact (or what is printed), and asymptotic.
    """
    low = _lower_end(differences, p_of, rough_p_of, level)
    mirrored = _lower_end(-differences, _mirror(p_of), _mirror(rough_p_of), level)
    high = None if mirrored is None else Bound(0.0 - mirrored.value, mirrored.closed)
    return Hull(low, high)


def _mirror(p_of: Callable[[Integers], float]) -> Callable[[Integers], float]:
    return lambda values: p_of(-values)


def _lower_end(
    differences: Integers,
    p_of: Callable[[Integers], float],
    rough_p_of: Callable[[Integers], float],
    level: float,
) -> Bound | None:
    """Return the lower end, or None where no shift is too low; θ counts in quarters of a step."""
    sums, scaled = WalshSums(differences), QUARTERS * differences

    @cache
    def accepted(theta: int) -> bool:
        return p_of(scaled - theta) > level

    outside = int(scaled.min()) - 1
    if accepted(outside):
        return None
    middle = sums.median_of_four()
    near = _places_near(middle, differences)
    inside = next(filter(accepted, near), None)
    if inside is None:  # so many ties that p jumps from one side's rejection to the other's
        return Bound(middle / QUARTERS, closed=True)
    lowest = _first_accepted(accepted, outside, inside)
    theta = lowest
    for _ in range(MOST_STEPS):
        theta = _next_below(theta, sums, outside)
        if theta == outside or rough_p_of(scaled - theta) <= DOUBT * level:
            break
        if accepted(theta):
            lowest = theta
    if _is_average(lowest, sums):
        return Bound(lowest / QUARTERS, closed=True)
    return Bound(_next_below(lowest, sums, outside) / QUARTERS, closed=False)


def _places_near(middle: int, differences: Integers) -> list[int]:
    """Return shifts of different results around the median Walsh average, the nearest first."""
    found = [middle]
    for sign in (1, -1):
        sums, theta = WalshSums(sign * differences), sign * middle
        outside = QUARTERS * int((sign * differences).min()) - 1
        for _ in range(PLACES):
            theta = _next_below(theta, sums, outside)
            if theta == outside:
                break
            found.append(sign * theta)
    return sorted(found, key=lambda theta: abs(theta - middle))


def _first_accepted(accepted: Callable[[int], bool], outside: int, inside: int) -> int:
    """Return an accepted shift next above a rejected one."""
    low, high = outside, inside
    while high - low > 1:
        between = (low + high) // 2
        low, high = (low, between) if accepted(between) else (between, high)
    return high


def _is_average(theta: int, sums: WalshSums) -> bool:
    return theta % 2 == 0 and sums.below(theta // 2 + 1) == theta // 2


def _next_below(theta: int, sums: WalshSums, outside: int) -> int:
    """Return the next lower shift of another result: a Walsh average, or a place just below one."""
    if _is_average(theta, sums):
        return theta - 1
    edge = sums.below((theta + 1) // 2)
    return outside if edge is None else 2 * edge


@dataclass(frozen=True)
class Shift:
    """A location shift in the units of the scores."""

    estimate: float
    low: float | None
    """None: unbounded, or (if `high` is None too) no interval."""
    high: float | None
    low_closed: bool
    """Whether `low` itself is in the interval."""
    high_closed: bool
    confidence: float
    """Confidence asked for."""
    coverage: float | None
    """Coverage of an interval between order statistics where differences are continuous."""
    n: int
    zeros_included: bool
    """In the estimate."""
    holds_rejected_zero: bool = False
    """Whether 0 is in the interval although the test rejects it (p is not monotone with ties)."""


EXACT_ORDER_UP_TO = 300
"""Differences up to which the order statistic comes from the exact distribution."""


def _order_statistic(n: int, confidence: float) -> tuple[int, float]:
    """Return the 1-based order statistic that bounds the interval, and the coverage."""
    if n > EXACT_ORDER_UP_TO:
        sd = np.sqrt(n * (n + 1) * (2 * n + 1) / 24)
        rank = max(int(n * (n + 1) / 4 - norm.ppf((1 + confidence) / 2) * sd), 1)
        return rank, 1 - 2 * float(norm.cdf((rank - 0.5 - n * (n + 1) / 4) / sd))
    cumulative = np.cumsum(sign_flip_distribution(2 * np.arange(1, n + 1))[::2])
    rank = max(int(np.searchsorted(cumulative, (1 - confidence) / 2)), 1)
    return rank, 1 - 2 * float(cumulative[rank - 1])


def hodges_lehmann(
    differences: ArrayLike,
    unit: float = 1.0,
    *,
    zeros_included: bool = True,
    confidence: float = 0.95,
) -> Shift | None:
    """Estimate the shift as the median of the Walsh averages.

    Convention: the interval is bounded by the order statistics of the Walsh averages that the
    exact signed-rank distribution without ties gives, the conservative side taken. Without
    zeros this is what R's ``wilcox.test(conf.int = TRUE)`` approximates under ties. Where there are
    ties it may contradict a test that takes them into account; see `with_hull`.

    Parameters
    ----------
    differences
        Paired differences in integer steps of the scale, shape (n,).
    unit
        Points per step; applied last.
    zeros_included
        Whether pairs without a difference count (they do in a Pratt analysis).

    Returns
    -------
    Shift or None
        None without any difference to average. Below `ranks.fewest_for_interval` there is no
        interval.
    """
    values = np.asarray(differences, dtype=np.int64)
    values = values if zeros_included else values[values != 0]
    if values.size == 0:
        return None
    sums = WalshSums(values)
    rank, coverage = _order_statistic(values.size, confidence)
    wide_enough = values.size >= fewest_for_interval(confidence)
    ends = (sums.order_statistic(rank), sums.order_statistic(sums.count + 1 - rank))
    low, high = (end / 2 * unit for end in ends)
    return Shift(
        estimate=sums.median_of_four() / 4 * unit,
        low=low if wide_enough else None,
        high=high if wide_enough else None,
        low_closed=wide_enough,
        high_closed=wide_enough,
        confidence=confidence,
        coverage=coverage if wide_enough else None,
        n=int(values.size),
        zeros_included=zeros_included,
    )


def with_hull(
    differences: ArrayLike,
    hull: Hull,
    unit: float = 1.0,
    *,
    zeros_included: bool,
    zero_rejected: bool,
    confidence: float,
) -> Shift | None:
    """Return the same estimate with the interval of a test that was inverted (`inversion`)."""
    values = np.asarray(differences, dtype=np.int64)
    values = values if zeros_included else values[values != 0]
    if values.size == 0:
        return None
    low, low_closed = _end(hull.low, unit)
    high, high_closed = _end(hull.high, unit)
    return Shift(
        estimate=WalshSums(values).median_of_four() / 4 * unit,
        low=low,
        high=high,
        low_closed=low_closed,
        high_closed=high_closed,
        confidence=confidence,
        coverage=None,
        n=int(values.size),
        zeros_included=zeros_included,
        holds_rejected_zero=zero_rejected and hull.contains(0),
    )


def _end(bound: Bound | None, unit: float) -> tuple[float | None, bool]:
    return (None, False) if bound is None else (bound.value * unit, bound.closed)
