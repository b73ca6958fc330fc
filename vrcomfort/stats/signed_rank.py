"""Wilcoxon's signed-rank test for scores with ties and zeros.

Everything is computed on integer differences (sums of ratings before any weight), because
weighted questionnaire scores are not exact in floating point and true ties would be lost.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.stats import norm

from vrcomfort.stats.effects import Effect, rank_biserial
from vrcomfort.stats.ranks import doubled_midranks, sign_flip_distribution, tied_count
from vrcomfort.stats.shift import Shift, hodges_lehmann

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vrcomfort.stats.ranks import Floats, Integers

Zeros = Literal["pratt", "wilcox"]
Alternative = Literal["two-sided", "greater", "less"]

EXACT_UP_TO = 500
"""Pairs up to which the exact distribution is computed (under a second)."""


@dataclass(frozen=True)
class SignedRank:
    """One signed-rank test, with everything a paper reports about it."""

    n: int
    """Pairs, those without a difference included."""
    zeros: int
    ties: int
    """Non-zero differences that share their size with another."""
    zero_method: Zeros
    alternative: Alternative
    w_plus: float
    w_minus: float
    z: float | None
    """Tie-corrected, without continuity correction; None if every difference is zero."""
    p_exact: float | None
    """None above `EXACT_UP_TO` pairs."""
    p_asymptotic: float
    shift: Shift | None
    """Zeros included with ``pratt``, dropped with ``wilcox``."""
    effect: Effect | None
    """Matched rank-biserial correlation over the non-zero differences."""

    @property
    def p(self) -> float:
        """The exact p where there is one, else the asymptotic."""
        return self.p_asymptotic if self.p_exact is None else self.p_exact

    @property
    def method(self) -> Literal["exact", "asymptotic"]:
        """Which of the two `p` is."""
        return "asymptotic" if self.p_exact is None else "exact"


def signed_rank(
    differences: ArrayLike,
    unit: float = 1.0,
    *,
    zeros: Zeros = "pratt",
    alternative: Alternative = "two-sided",
    interval_n: int | None = None,
    confidence: float = 0.95,
) -> SignedRank:
    """Test whether paired differences are symmetric about zero.

    Parameters
    ----------
    differences
        Integer differences first minus second, shape (n,); see `ranks.as_integers`.
    unit
        Points of the questionnaire per integer step; used for the shift only.
    zeros
        ``pratt``: zeros are ranked, then dropped (Pratt 1959); ``wilcox``: dropped, then ranked.
    alternative
        ``greater``: the first tends to be larger.
    interval_n
        See `effects.rank_biserial`.

    Examples
    --------
    >>> test = signed_rank([3, 1, 0, 2, -1, 4, 2, 5], unit=3.74)
    >>> test.zeros, test.w_plus, round(test.p, 4)
    (1, 32.5, 0.0312)
    """
    values = np.asarray(differences, dtype=np.int64)
    ranks = _ranks(values, zeros)
    nonzero = values[values != 0]
    doubled_plus = int(ranks[nonzero > 0].sum())
    z = _z(doubled_plus, ranks)
    exact = _exact_p(doubled_plus, ranks, alternative) if values.size <= EXACT_UP_TO else None
    return SignedRank(
        n=int(values.size),
        zeros=int(values.size - nonzero.size),
        ties=tied_count(np.abs(nonzero)),
        zero_method=zeros,
        alternative=alternative,
        w_plus=doubled_plus / 2,
        w_minus=int(ranks[nonzero < 0].sum()) / 2,
        z=z,
        p_exact=exact,
        p_asymptotic=_normal_p(z, alternative),
        shift=hodges_lehmann(values, unit, zeros_included=zeros == "pratt", confidence=confidence),
        effect=rank_biserial(values, interval_n=interval_n, confidence=confidence),
    )


def _ranks(values: Integers, zeros: Zeros) -> Integers:
    """Doubled ranks of the sizes of the non-zero differences, in the order of the data."""
    keep = values != 0
    ranked = doubled_midranks(np.abs(values if zeros == "pratt" else values[keep]))
    return ranked[keep] if zeros == "pratt" else ranked


def _z(doubled_plus: int, ranks: Integers) -> float | None:
    """Standardise the rank sum; the variance uses the midranks, so ties are corrected for."""
    if ranks.size == 0:
        return None
    total = int(ranks.sum())
    return float((2 * doubled_plus - total) / np.sqrt(np.sum(ranks.astype(np.float64) ** 2)))


def _exact_p(doubled_plus: int, ranks: Integers, alternative: Alternative) -> float:
    probability = sign_flip_distribution(ranks)
    upper = _clip(probability[doubled_plus:])
    lower = _clip(probability[: doubled_plus + 1])
    return {"greater": upper, "less": lower, "two-sided": min(1.0, 2 * min(upper, lower))}[
        alternative
    ]


def _clip(probability: Floats) -> float:
    return min(1.0, float(probability.sum()))


def _normal_p(z: float | None, alternative: Alternative) -> float:
    if z is None:
        return 1.0
    tails = {"greater": z, "less": -z}
    if alternative in tails:
        return float(norm.sf(tails[alternative]))
    return float(2 * norm.sf(abs(z)))
