"""Rank tests of more than two conditions or groups: Friedman, Kruskal-Wallis, aligned ranks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.special import chdtrc
from scipy.stats import chi2, rankdata

from vrcomfort.errors import InputError
from vrcomfort.stats.anova import Anova, AnovaEffect, SumsOfSquares, anova
from vrcomfort.stats.ranks import doubled_midranks, tied_count

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from numpy.typing import ArrayLike, NDArray

    from vrcomfort.stats.ranks import Integers
    from vrcomfort.stats.signed_rank import PValue

    Floats = NDArray[np.float64]

# Friedman's test with Kendall's W, for ordinal scores under more than two conditions.


@dataclass(frozen=True)
class Friedman:
    """A Friedman test; ties within participants are corrected for."""

    n: int
    conditions: int
    ties: int
    """Scores that share their value with another of the same participant."""
    chi_square: float | None
    """None if no participant distinguishes the conditions."""
    df: int
    p: float | None
    kendall_w: float | None


def friedman(scores: ArrayLike) -> Friedman:
    """Test integer scores of n participants (rows) under k conditions (columns).

    Raises
    ------
    InputError
        With fewer than two participants or conditions.
    """
    values = np.asarray(scores, dtype=np.int64)
    if values.ndim != 2 or min(values.shape) < 2:
        raise InputError("Friedman's test needs at least two participants and two conditions")
    n, k = values.shape
    ranks = rankdata(values, axis=1)
    within = float(np.sum((ranks - (k + 1) / 2) ** 2))
    ties = _tied(values)
    if within == 0:
        return Friedman(n, k, ties, None, k - 1, None, None)
    between = float(np.sum((ranks.sum(axis=0) - n * (k + 1) / 2) ** 2))
    chi_square = (k - 1) * between / within
    p = float(chdtrc(k - 1, chi_square))
    return Friedman(n, k, ties, chi_square, k - 1, p, chi_square / (n * (k - 1)))


def _tied(values: NDArray[np.int64]) -> int:
    """Return how many values are equal to another of their row."""
    ordered = np.sort(values, axis=1)
    same = np.diff(ordered, axis=1) == 0
    edge = np.zeros((values.shape[0], 1), dtype=bool)
    return int((np.hstack([edge, same]) | np.hstack([same, edge])).sum())


# The Kruskal–Wallis test of several groups of different people, exact with ties.
#
# As in `mann_whitney`, everything is computed on integer scores, so that ties are ties.


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
    """Return the share of allocations of the ranks with at least the observed H.

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


# The aligned rank transform: an analysis of variance of ranks that can tell interactions.
#
# For each effect, scores are stripped of everything that is estimated but this effect, ranked,
# and analysed; of that analysis, this effect alone is read (Wobbrock, Findlater, Gergle & Higgins
# 2011).


DIGITS = 1e-9
"""Share of the range of aligned scores below which two of them are tied: they are sums of means."""


def aligned_ranks(
    table: pd.DataFrame,
    *,
    value: str,
    participant: str,
    within: Sequence[str] = (),
    between: Sequence[str] = (),
    sums_of_squares: SumsOfSquares = "III",
) -> tuple[Anova, tuple[AnovaEffect, ...]]:
    """Analyse a long table with at most one row per participant and cell.

    Participants without a value in every cell are left out before scores are aligned. Sums of
    squares, effect sizes and residuals of the effects are those of ranks.

    Returns
    -------
    Anova, tuple of AnovaEffect
        The analysis of the scores themselves (who is in it), and each effect of aligned ranks.

    Raises
    ------
    InputError
        As `anova`.
    """
    factors = [*between, *within]

    def analyse(rows: pd.DataFrame) -> Anova:
        return anova(
            rows,
            value=value,
            participant=participant,
            within=within,
            between=tuple(between),
            sums_of_squares=sums_of_squares,
        )

    plain = analyse(table)
    rows = table.dropna(subset=[value, *factors])
    rows = rows[~rows[participant].astype(str).isin(plain.excluded)]
    effects = []
    for effect in plain.effects:
        named = [name for name in factors if name in effect.effect.split(" × ")]
        ranked = rows.assign(**{value: _aligned(rows, value, factors, named)})
        made = analyse(ranked).effects
        effects.append(next(each for each in made if each.effect == effect.effect))
    return plain, tuple(effects)


def _aligned(rows: pd.DataFrame, value: str, factors: list[str], effect: list[str]) -> Floats:
    """Return the midranks of scores that are stripped of all effects but one."""
    scores = rows[value].to_numpy(dtype=np.float64)

    def mean_of(names: tuple[str, ...]) -> Floats:
        if not names:
            return np.full(scores.size, scores.mean())
        found: Floats = rows.groupby(list(names))[value].transform("mean").to_numpy(dtype=float)
        return found

    estimate = np.zeros(scores.size)
    for size in range(len(effect) + 1):
        sign = (-1) ** (len(effect) - size)
        for names in combinations(effect, size):
            estimate += sign * mean_of(names)
    aligned = scores - mean_of(tuple(factors)) + estimate
    step = float(np.ptp(aligned)) * DIGITS
    return np.asarray(rankdata(np.rint(aligned / step) if step else aligned), dtype=np.float64)
