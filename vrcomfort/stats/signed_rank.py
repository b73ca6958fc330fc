"""Wilcoxon's signed-rank test for scores with ties and zeros.

Everything is computed on integer differences (sums of ratings before any weight), because
weighted questionnaire scores are not exact in floating point and true ties would be lost.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.special import ndtr

from vrcomfort.stats.effects import (
    EffectSize,
    RankBiserialInterval,
    decided_at_zero,
    rank_biserial,
)
from vrcomfort.stats.ranks import (
    Alternative,
    ExactOrAsymptotic,
    doubled_midranks,
    level_of,
    sign_flip_lower_tail,
    tied_count,
)
from vrcomfort.stats.shift import Shift, hodges_lehmann, invert, with_hull

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vrcomfort.stats.ranks import Integers

Zeros = Literal["pratt", "wilcox"]
ShiftInterval = Literal["inverted_test", "order_statistics"]
PValue = Literal["exact", "asymptotic"]

EXACT_UP_TO = 500
"""Pairs up to which the exact distribution is computed: there a test with its intervals costs
0.2 s, and the asymptotic p was off by .02 % (``python -m bench.signed_rank``)."""


@dataclass(frozen=True)
class SignedRank(ExactOrAsymptotic):
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
    """None above `EXACT_UP_TO` pairs, and where it was not asked for."""
    p_asymptotic: float
    shift: Shift | None
    """Zeros included with ``pratt``, dropped with ``wilcox``."""
    effect: EffectSize | None
    """Matched rank-biserial correlation over the non-zero differences."""


@dataclass(frozen=True)
class _Sums:
    """The rank sums of one set of differences; all p values come from them."""

    doubled_plus: int
    ranks: Integers
    """Doubled ranks of the non-zero differences."""

    @classmethod
    def of(cls, values: Integers, zeros: Zeros) -> _Sums:
        ranks = _ranks(values, zeros)
        return cls(int(ranks[values[values != 0] > 0].sum()), ranks)

    @property
    def z(self) -> float | None:
        """Standardise the rank sum; the variance uses the midranks, so ties are corrected for."""
        if self.ranks.size == 0:
            return None
        total = int(self.ranks.sum())
        sd = np.sqrt(np.sum(self.ranks.astype(np.float64) ** 2))
        return float((2 * self.doubled_plus - total) / sd)

    def exact_p(self, alternative: Alternative) -> float:
        """Return p from the distribution of all sign patterns; W+ and W− are distributed alike."""
        minus = int(self.ranks.sum()) - self.doubled_plus
        if alternative == "two-sided":
            smaller = min(self.doubled_plus, minus)
            return min(1.0, 2 * sign_flip_lower_tail(self.ranks, smaller))
        bound = minus if alternative == "greater" else self.doubled_plus
        return sign_flip_lower_tail(self.ranks, bound)


def signed_rank(
    differences: ArrayLike,
    unit: float = 1.0,
    *,
    zeros: Zeros = "pratt",
    alternative: Alternative = "two-sided",
    p_value: PValue = "exact",
    intervals: bool = True,
    shift_interval: ShiftInterval = "inverted_test",
    effect_interval: RankBiserialInterval = "normal_shift",
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
    p_value
        ``exact``: up to `EXACT_UP_TO` pairs; ``asymptotic``: the normal approximation, always.
    intervals
        Without them `shift` and `effect` are None: the intervals cost dozens of tests.
    shift_interval
        ``inverted_test``: the hull of the shifts that this test does not reject (`inversion`), so
        that it agrees with p; ``order_statistics``: see `shift.hodges_lehmann`.
    effect_interval, interval_n
        See `effects.rank_biserial`. On 0, an interval of ``normal_shift`` says what p says.

    Examples
    --------
    >>> test = signed_rank([3, 1, 0, 2, -1, 4, 2, 5], unit=3.74)
    >>> test.zeros, test.w_plus, round(test.p, 4)
    (1, 32.5, 0.0312)
    """
    values = np.asarray(differences, dtype=np.int64)
    sums = _Sums.of(values, zeros)
    nonzero = values[values != 0]
    may = p_value == "exact" and values.size <= EXACT_UP_TO
    exact = sums.exact_p(alternative) if may else None
    test = SignedRank(
        n=int(values.size),
        zeros=int(values.size - nonzero.size),
        ties=tied_count(np.abs(nonzero)),
        zero_method=zeros,
        alternative=alternative,
        w_plus=sums.doubled_plus / 2,
        w_minus=(int(sums.ranks.sum()) - sums.doubled_plus) / 2,
        z=sums.z,
        p_exact=exact,
        p_asymptotic=_normal_p(sums.z, alternative),
        shift=None,
        effect=None,
    )
    if not intervals:
        return test
    shift = (
        _inverted(values, unit, test, confidence)
        if shift_interval == "inverted_test"
        else hodges_lehmann(values, unit, zeros_included=zeros == "pratt", confidence=confidence)
    )
    effect = rank_biserial(
        values,
        interval=effect_interval,
        interval_n=interval_n,
        alternative=alternative,
        confidence=confidence,
    )
    if effect is not None and effect_interval == "normal_shift":
        effect = decided_at_zero(effect, rejected=test.p <= level_of(confidence))
    return replace(test, shift=shift, effect=effect)


def worst_rank(
    differences: ArrayLike,
    lost: ArrayLike,
    *,
    zeros: Zeros = "pratt",
    alternative: Alternative = "two-sided",
    p_value: PValue = "exact",
) -> SignedRank:
    """Repeat a signed-rank test with unpaired participants at the worst rank.

    Each lost participant gets a difference larger than any observed, so only its rank and sign
    matter (Lachin 1999, worst-rank score). The result has neither shift nor
    effect size: they would be those of the assumption.

    Parameters
    ----------
    differences
        Observed integer differences, first minus second, shape (n,).
    lost
        Assumed sign of each lost participant: 1 where the first condition was worse, −1 where
        the second was, 0 for no difference. Shape (m,).
    """
    observed = np.asarray(differences, dtype=np.int64)
    signs = np.asarray(lost, dtype=np.int64)
    largest = int(np.max(np.abs(observed), initial=0))
    together = np.concatenate([observed, np.sign(signs) * (largest + 1)])
    return signed_rank(
        together, zeros=zeros, alternative=alternative, p_value=p_value, intervals=False
    )


def _inverted(values: Integers, unit: float, test: SignedRank, confidence: float) -> Shift | None:
    """Return the shift with the hull of the values that this very test does not reject."""
    if values.size == 0:
        return None
    rough = partial(_asymptotic, zeros=test.zero_method, alternative=test.alternative)
    exact = partial(_exact, zeros=test.zero_method, alternative=test.alternative)
    level = level_of(confidence)
    hull = invert(values, rough if test.p_exact is None else exact, rough, level=level)
    return with_hull(
        values,
        hull,
        unit,
        zeros_included=test.zero_method == "pratt",
        zero_rejected=test.p <= level,
        confidence=confidence,
    )


def _exact(values: Integers, zeros: Zeros, alternative: Alternative) -> float:
    return _Sums.of(values, zeros).exact_p(alternative)


def _asymptotic(values: Integers, zeros: Zeros, alternative: Alternative) -> float:
    return _normal_p(_Sums.of(values, zeros).z, alternative)


def _ranks(values: Integers, zeros: Zeros) -> Integers:
    """Doubled ranks of the sizes of the non-zero differences, in the order of the data."""
    keep = values != 0
    ranked = doubled_midranks(np.abs(values if zeros == "pratt" else values[keep]))
    return ranked[keep] if zeros == "pratt" else ranked


def _normal_p(z: float | None, alternative: Alternative) -> float:
    if z is None:
        return 1.0
    tails = {"greater": z, "less": -z}
    if alternative in tails:
        return float(ndtr(-tails[alternative]))
    return float(2 * ndtr(-abs(z)))
