"""The aligned rank transform: an analysis of variance of ranks that can tell interactions.

For each effect, scores are stripped of everything that is estimated but this effect, ranked, and
analysed; of that analysis, this effect alone is read (Wobbrock, Findlater, Gergle & Higgins 2011).
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import rankdata

from vrcomfort.stats.anova import Anova, AnovaEffect, SumsOfSquares, anova

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

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
