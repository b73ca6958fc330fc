"""The interval of a shift that a signed-rank test does not reject.

The test is made again of d − θ, ranked anew, for every θ that matters. Its result changes only
where θ is a Walsh average (there differences tie, or become zero) and is the same in between. With
integer differences all of these places are integers in quarters of a step, so nothing is rounded.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.stats.walsh import WalshSums

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Integers = NDArray[np.int64]

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
    """Return an accepted shift whose neighbour below is rejected."""
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
