"""The Kruskal–Wallis test of several groups of different people."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2

from vrcomfort.errors import InputError
from vrcomfort.stats.ranks import doubled_midranks, tied_count

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike


@dataclass(frozen=True)
class KruskalWallis:
    """A test of several groups; ties are corrected for."""

    sizes: tuple[int, ...]
    ties: int
    h: float | None
    """None if all scores are alike."""
    df: int
    p: float | None
    """Asymptotic."""
    epsilon_squared: float | None
    """H / (N − 1): 0 without, 1 with complete separation (Tomczak & Tomczak 2014)."""


def kruskal_wallis(groups: Sequence[ArrayLike]) -> KruskalWallis:
    """Test whether integer scores of any group tend to be higher than those of the others.

    Raises
    ------
    InputError
        With fewer than two groups that have anybody, or fewer than three people.
    """
    values = [np.asarray(group, dtype=np.int64) for group in groups]
    values = [group for group in values if group.size]
    together = np.concatenate([*values, np.empty(0, dtype=np.int64)])
    if len(values) < 2 or together.size < 3:
        raise InputError("the Kruskal–Wallis test needs two groups and three people")
    ranks = doubled_midranks(together) / 2
    n, mean = together.size, (together.size + 1) / 2
    total = float(np.sum((ranks - mean) ** 2))
    df, sizes = len(values) - 1, tuple(int(group.size) for group in values)
    ties = tied_count(together)
    if total == 0:
        return KruskalWallis(sizes, ties, None, df, None, None)
    parts = np.split(ranks, np.cumsum(sizes)[:-1])
    between = sum(part.size * float(part.mean() - mean) ** 2 for part in parts)
    h = (n - 1) * between / total
    return KruskalWallis(sizes, ties, h, df, float(chi2.sf(h, df)), h / (n - 1))
