"""Ranks of tied integers and the exact null distribution of a signed-rank sum.

Ranks are kept doubled, so that midranks are integers and sums of ranks compare exactly.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Integers = NDArray[np.int64]
    Floats = NDArray[np.float64]


Alternative = Literal["two-sided", "greater", "less"]
"""`greater`: the first of each pair tends to be larger."""


class ExactOrAsymptotic:
    """A rank test with two p values, of which the exact one counts where there is one."""

    p_exact: float | None
    p_asymptotic: float

    @property
    def p(self) -> float:
        """The exact p where there is one, else the asymptotic."""
        return self.p_asymptotic if self.p_exact is None else self.p_exact

    @property
    def method(self) -> Literal["exact", "asymptotic"]:
        """Which of the two `p` is."""
        return "asymptotic" if self.p_exact is None else "exact"


def as_integers(values: ArrayLike, unit: float = 1.0, *, tolerance: float = 1e-6) -> Integers:
    """Return `values` as whole multiples of `unit`, so that ties are exact.

    Parameters
    ----------
    values
        Numbers, shape (n,), that are multiples of `unit` up to rounding.
    unit
        The step of the scale: 1 for sums of ratings, 3.74 for SSQ totals, 0.1 for one decimal.
    tolerance
        Largest accepted distance from a multiple, in units.

    Raises
    ------
    InputError
        If a value is missing or is not a multiple: ranks of it would not be exact.
    """
    multiples = np.asarray(values, dtype=np.float64) / unit
    if not np.all(np.isfinite(multiples)):
        raise InputError("a missing or infinite value cannot be ranked; leave the pair out first")
    whole = np.rint(multiples)
    if multiples.size and np.max(np.abs(multiples - whole)) > tolerance:
        raise InputError(f"values are not multiples of {unit:g}; give the step of the scale")
    return whole.astype(np.int64)


def doubled_midranks(values: ArrayLike) -> Integers:
    """Return twice the midranks of `values`, shape (n,); ties share the mean of their ranks."""
    found = np.asarray(values)
    ordered = np.sort(found)
    below, up_to = (np.searchsorted(ordered, found, side=side) for side in ("left", "right"))
    doubled: Integers = below + up_to + 1
    return doubled


def tied_count(values: ArrayLike) -> int:
    """Return how many of `values` share their value with another."""
    _, sizes = np.unique(np.asarray(values), return_counts=True)
    return int(sizes[sizes > 1].sum())


def level_of(confidence: float) -> float:
    """Return 1 − confidence, without the rounding by which 1 − .9 is less than .1.

    Exact p values can be the level itself: that of three people against three others is .1.
    """
    return round(1 - confidence, 12)


def fewest_for_interval(confidence: float, sides: Literal[1, 2] = 2) -> int:
    """Return the fewest differences that allow an interval: six at 95 %, five of one side.

    Fewer cannot reject at 1 − `confidence` even if all have one sign (p = `sides` · 2^−n),
    so that no interval that agrees with the exact test has a bound (Hollander, Wolfe & Chicken
    2014, section 3.3).
    """
    return math.ceil(math.log2(sides) - math.log2(1 - confidence))


def sign_flip_lower_tail(doubled_ranks: ArrayLike, bound: int) -> float:
    """Return P(sum of positive doubled ranks ≤ `bound`) under the null hypothesis.

    As `sign_flip_distribution`, but no further than needed; numbers of sign patterns are exact
    (up to 2^53 of them) and divided last.
    """
    ranks = np.sort(np.asarray(doubled_ranks, dtype=np.int64))
    if bound < 0:
        return 0.0
    step = int(np.gcd.reduce(ranks)) if ranks.size else 1
    ranks, bound = ranks // step, min(bound, int(ranks.sum())) // step
    patterns = np.zeros(bound + 1)
    patterns[0] = 1.0
    reached = 0
    for rank in ranks[ranks <= bound]:
        reached = min(reached + int(rank), bound)
        patterns[rank : reached + 1] += patterns[: reached + 1 - rank].copy()
    return min(1.0, float(np.ldexp(patterns.sum(), -ranks.size)))


def sign_flip_distribution(doubled_ranks: ArrayLike) -> Floats:
    """Return the null probabilities of the sum of positive doubled ranks.

    Under the null hypothesis each rank is positive with probability 1/2, independently. The
    distribution is built by adding one rank at a time (dynamic programme; Streitberg & Röhmel
    1986), which is exact whatever the ties.

    Returns
    -------
    ndarray, shape (sum(doubled_ranks) + 1,)
        Element s is P(sum = s).
    """
    ranks = np.asarray(doubled_ranks, dtype=np.int64)
    probability = np.zeros(int(ranks.sum()) + 1)
    probability[0] = 1.0
    reached = 0
    for rank in np.sort(ranks):
        reached += int(rank)
        head: Any = probability[: reached + 1]
        shifted = np.zeros_like(head)
        shifted[rank:] = head[: head.size - rank]
        probability[: reached + 1] = 0.5 * (head + shifted)
    return probability
