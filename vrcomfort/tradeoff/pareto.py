"""From costs and errors to statements: fronts, slopes, who beats whom."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike


class Point(NamedTuple):
    """A method: what it costs and how wrong it is (less is better)."""

    name: str
    cost: float
    error: float


class Verdict(NamedTuple):
    """How one of ours stands against the method of a source.

    Parameters
    ----------
    ours
        The one that comes nearest to beating it (or beats it by most).
    factor
        The larger of both ratios, ours / theirs, of cost and of error: below 1, ours is both
        faster and closer; above, it fails by this factor.
    """

    theirs: str
    ours: str
    cost_ratio: float
    error_ratio: float
    factor: float

    @property
    def beaten(self) -> bool:
        """Return whether ours is both faster and closer."""
        return self.factor < 1


def front(points: Sequence[Point]) -> list[Point]:
    """Return the points that no other beats in one way without losing in the other, by cost.

    Of points that are equal in both, all stay.
    """
    found = [p for p in points if not any(_dominates(q, p) for q in points)]
    return sorted(found, key=lambda point: point.cost)


def verdict(theirs: Point, ours: Sequence[Point]) -> Verdict | None:
    """Compare a method with ours; None where there is none of ours."""
    found = [
        Verdict(theirs.name, each.name, *ratios, max(ratios))
        for each in ours
        for ratios in [(_ratio(each.cost, theirs.cost), _ratio(each.error, theirs.error))]
    ]
    return min(found, key=lambda each: each.factor, default=None)


def undecided(theirs: Point, ours: Sequence[Point], again: tuple[float, float]) -> bool:
    """Return whether the noise of costs alone could turn a verdict.

    Parameters
    ----------
    again
        Ratios of cost, around 1, between which the same work lies when it is timed twice.
    """
    closer = [_ratio(each.cost, theirs.cost) for each in ours if each.error < theirs.error]
    return any(ratio <= again[1] for ratio in closer) and not any(
        ratio < again[0] for ratio in closer
    )


def log_slope(steps: ArrayLike, errors: ArrayLike) -> float | None:
    """Return the least-squares slope of log error against log step; None below two points."""
    x, y = np.asarray(steps, dtype=np.float64), np.asarray(errors, dtype=np.float64)
    usable = (x > 0) & (y > 0)
    if len(np.unique(x[usable])) < 2:
        return None
    return float(np.polyfit(np.log(x[usable]), np.log(y[usable]), 1)[0])


def falls(errors: Sequence[float]) -> bool:
    """Return whether each error is less than the one before."""
    return all(b < a for a, b in pairwise(errors))


def _dominates(a: Point, b: Point) -> bool:
    no_worse = a.cost <= b.cost and a.error <= b.error
    return no_worse and (a.cost < b.cost or a.error < b.error)


def _ratio(a: float, b: float) -> float:
    if b == 0:
        return 1.0 if a == 0 else float("inf")
    return a / b
