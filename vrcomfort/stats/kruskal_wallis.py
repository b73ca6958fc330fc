"""The Kruskal–Wallis test of several groups of different people, exact with ties.

As in `mann_whitney`, everything is computed on integer scores, so that ties are ties.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.stats import chi2

from vrcomfort.errors import InputError
from vrcomfort.stats.ranks import doubled_midranks, tied_count

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from vrcomfort.stats.ranks import Floats, Integers
    from vrcomfort.stats.signed_rank import PValue

EXACT_UP_TO = {2: 30, 3: 27, 4: 16, 5: 13, 6: 12}
"""Number of groups → people up to whom the exact distribution is computed: there it takes at most a
second or so, and the asymptotic p can be off by half of itself (``python -m bench.p_values``)."""


@dataclass(frozen=True)
class KruskalWallis:
    """A test of several groups; ties are corrected for."""

    sizes: tuple[int, ...]
    ties: int
    h: float | None
    """None if all scores are alike."""
    df: int
    p: float | None
    """Exact where it was computed."""
    method: Literal["exact", "asymptotic"]
    p_asymptotic: float | None
    epsilon_squared: float | None
    """H / (N − 1): 0 without, 1 with complete separation (Tomczak & Tomczak 2014)."""


def kruskal_wallis(groups: Sequence[ArrayLike], *, p_value: PValue = "exact") -> KruskalWallis:
    """Test whether integer scores of any group tend to be higher than those of the others.

    Parameters
    ----------
    p_value
        ``exact``: the share of all ways to deal the scores to the groups that have as high an H or
        a higher one, given the ties, up to `EXACT_UP_TO` people.

    Raises
    ------
    InputError
        With fewer than two groups that have anybody, or fewer than three people.

    Examples
    --------
    >>> test = kruskal_wallis([[1, 2, 3], [4, 5, 6], [7, 8, 9]])
    >>> round(test.h, 2), round(test.p, 4), test.method
    (7.2, 0.0036, 'exact')
    """
    values = [np.asarray(group, dtype=np.int64) for group in groups]
    values = [group for group in values if group.size]
    together = np.concatenate([*values, np.empty(0, dtype=np.int64)])
    if len(values) < 2 or together.size < 3:
        raise InputError("the Kruskal–Wallis test needs two groups and three people")
    ranks = doubled_midranks(together)
    n, mean = together.size, (together.size + 1) / 2
    total = float(np.sum((ranks / 2 - mean) ** 2))
    df, sizes = len(values) - 1, tuple(int(group.size) for group in values)
    ties = tied_count(together)
    if total == 0:
        return KruskalWallis(sizes, ties, None, df, None, "asymptotic", None, None)
    parts = np.split(ranks, np.cumsum(sizes)[:-1])
    between = sum(part.size * float(part.mean() / 2 - mean) ** 2 for part in parts)
    h = (n - 1) * between / total
    asymptotic = float(chi2.sf(h, df))
    exact = p_value == "exact" and n <= EXACT_UP_TO.get(len(sizes), 0)
    p = exact_p(ranks, [int(part.sum()) for part in parts], sizes) if exact else asymptotic
    method: Literal["exact", "asymptotic"] = "exact" if exact else "asymptotic"
    return KruskalWallis(sizes, ties, h, df, p, method, asymptotic, h / (n - 1))


def exact_p(ranks: Integers, observed: Sequence[int], sizes: Sequence[int]) -> float:
    """Return the share of ways to deal the ranks whose H is at least that observed.

    Parameters
    ----------
    ranks
        Doubled midranks of everybody.
    observed
        Their sums in each group.
    sizes
        People in each group.

    Notes
    -----
    People are dealt one after the other; ways that gave each group as many people and as high a sum
    are one state with a count. Groups of one size are exchangeable, so their states are sorted.
    """
    order = np.argsort(sizes, kind="stable")
    goal = np.asarray(sizes, dtype=np.int64)[order]
    base = int(ranks.sum()) + 1
    states, ways = np.zeros((1, goal.size), dtype=np.int64), np.ones(1)
    for rank in np.sort(ranks):
        states, ways = _dealt(states, ways, int(rank) + base, goal, base)
    common = math.lcm(*map(int, goal))
    weights = common // goal
    reached = ((states % base) ** 2) @ weights
    sums = np.asarray(observed, dtype=np.int64)[order]
    return float(ways[reached >= int((sums**2) @ weights)].sum() / ways.sum())


def _dealt(
    states: Integers, ways: Floats, step: int, goal: Integers, base: int
) -> tuple[Integers, Floats]:
    """Deal one more person to each group with room; a state is people × base + sum of ranks."""
    found, counts = [], []
    for place, size in enumerate(goal):
        room = states[:, place] // base < size
        moved = states[room].copy()
        moved[:, place] += step
        found.append(moved)
        counts.append(ways[room])
    every, count = np.concatenate(found), np.concatenate(counts)
    for size in np.unique(goal):
        alike = np.flatnonzero(goal == size)
        every[:, alike] = np.sort(every[:, alike], axis=1)
    # The last group has what the others do not: it needs no place in the key.
    keys = np.zeros(len(every), dtype=np.int64)
    for place, size in enumerate(goal[:-1]):
        keys = keys * ((int(size) + 1) * base) + every[:, place]
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    return every[first], np.bincount(inverse, count).astype(np.float64)
