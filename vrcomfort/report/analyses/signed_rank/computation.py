"""Computation of the signed-rank tests: rows, intervals, and t tests of the same pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.plurals import counted
from vrcomfort.report.analyses.contract import AnalysisData
from vrcomfort.report.descriptives import Description, describe
from vrcomfort.report.exposures import with_scores
from vrcomfort.report.families import Decision
from vrcomfort.report.orders import OneOrder, one_order
from vrcomfort.report.pairs import Pairs, Side, needed_of, pair_up, possible_difference
from vrcomfort.report.possible import limited
from vrcomfort.report.rows import HIDDEN, INLINE
from vrcomfort.report.withdrawals import lost_signs
from vrcomfort.stats.signed_rank import SignedRank, signed_rank, worst_rank
from vrcomfort.stats.t_tests import paired_t

if TYPE_CHECKING:
    from typing import TypeVar

    from vrcomfort.report.contrasts import Compared
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.possible import Possible
    from vrcomfort.stats.effects import EffectSize
    from vrcomfort.stats.ranks import Alternative
    from vrcomfort.stats.shift import Shift
    from vrcomfort.stats.signed_rank import Zeros

    Estimate = TypeVar("Estimate", Shift, EffectSize)

FEWEST_PAIRS = 2
"""One pair can be tested exactly, but a single sign is no result."""
_DIFFERENCE = "difference"
"""Key of the description of the differences, beside the names of both sides."""


@dataclass(frozen=True)
class SignedRankIntervals:
    """The estimates with intervals of one level."""

    shift: Shift | None
    effect: EffectSize | None


@dataclass(frozen=True)
class OtherZeros:
    """The test with the other rule for pairs without a difference."""

    test: SignedRank = field(metadata=INLINE)
    p: float
    method: str


@dataclass(frozen=True)
class PairedTTest:
    """The t test of the same pairs."""

    n: int
    mean: float
    standard_error: float
    df: int
    t: float
    p: float
    low: float | None
    high: float | None
    confidence: float
    alternative: str
    cohen_dz: float
    cohen_dz_low: float | None
    cohen_dz_high: float | None
    bayes_factor_10: float


@dataclass(frozen=True)
class SignedRankFound:
    """The numbers of a test.

    Parameters
    ----------
    descriptives
        Of both sides, by name, and of the difference.
    t_test
        None where no difference varies.
    """

    zeros: int
    ties: int
    zero_method: str
    w_plus: float
    w_minus: float
    z: float | None
    p_exact: float | None
    p_asymptotic: float
    shift: Shift | None
    effect: EffectSize | None
    method: str
    descriptives: dict[str, Description]
    other_zeros: OtherZeros
    t_test: PairedTTest | None

    @property
    def difference(self) -> Description:
        """Return the description of the differences."""
        return self.descriptives[_DIFFERENCE]


@dataclass(frozen=True)
class SignedRankRow:
    """One contrast, tested on one outcome.

    Parameters
    ----------
    ranked_worst
        Participants who withdrew, and are ranked as worst.
    confounded
        The order in which nearly all met the two conditions, if it is one.
    needed, confidence, shift_interval
        Scores of each side that a participant needs; the plan's choices.
    """

    a: str
    b: str
    outcome: str
    kind: str
    sides: tuple[Side, Side]
    n: int
    participants: tuple[str, ...]
    ranked_worst: tuple[str, ...]
    exposures_per_condition: dict[str, int]
    alternative: Alternative
    p: float | None
    not_tested: str | None
    confounded: OneOrder | None
    decision: Decision[SignedRankIntervals] = field(metadata=INLINE)
    found: SignedRankFound | None = field(metadata=INLINE)
    needed: tuple[int, int] = field(metadata=HIDDEN)
    confidence: float = field(metadata=HIDDEN)
    shift_interval: str = field(metadata=HIDDEN)

    @property
    def reported(self) -> SignedRankIntervals | SignedRankFound | None:
        """Return the estimates with the intervals that belong to the p that decides."""
        return self.decision.simultaneous or self.found


def compute(data: AnalysisData, _: Sequence[object]) -> list[SignedRankRow]:
    """Test each contrast of pairs that names no other test, on each outcome."""
    return [
        _row(data, contrast, outcome.name)
        for contrast in data.contrasts
        if contrast.test == "signed_rank"
        for outcome in data.scored.outcomes
    ]


def _row(data: AnalysisData, contrast: Compared, outcome: str) -> SignedRankRow:
    scored, plan, a, b = data.scored, data.plan, contrast.a, contrast.b
    pairs = pair_up(scored, outcome, a, b, complete=data.complete)
    signs = _ranked_worst(pairs, plan, lost_signs(data.withdrawals, a.name, b.name))
    planned = {side.name: needed_of(scored, outcome, side) for side in (a, b)}
    needed = (planned[a.name], planned[b.name]) if data.complete else (1, 1)
    confounded = None
    if contrast.of_conditions:
        people = pairs.participants
        confounded = scored.looked_up(
            ("confounded", a, b, people),
            lambda: one_order(scored.table, a.name, b.name, people),
        )
    row = SignedRankRow(
        a.name, b.name, outcome, "paired", (a, b), len(pairs.participants) + len(signs),
        (*pairs.participants, *signs), tuple(signs), planned, contrast.alternative, None, None,
        confounded, Decision(), None, needed, plan.confidence, plan.shift_interval,
    )  # fmt: skip
    if len(pairs.participants) < FEWEST_PAIRS:
        return replace(row, not_tested=_too_few(scored, outcome, contrast, len(pairs.participants)))
    possible = possible_difference(scored, outcome, a, b)
    return _tested(row, pairs, plan, list(signs.values()), possible)


def _tested(
    row: SignedRankRow, pairs: Pairs, plan: Plan, signs: list[int], possible: Possible
) -> SignedRankRow:
    """Return a row with its test; shift and r leave out withdrawals that are ranked as worst."""
    test = _signed_rank(pairs, plan, row.alternative, plan.confidence)
    ranked = test
    if signs:
        ranked = worst_rank(
            pairs.differences, signs, zeros=plan.zeros, alternative=row.alternative,
            p_value=plan.p_value,
        )  # fmt: skip
        # Whoever left has a rank beyond all others, but no score: shift, effect and means are of
        # those who stayed, and their intervals would be those of another test.
        test = replace(test, shift=_without_ends(test.shift), effect=_without_ends(test.effect))
    t_test = limited(_t_test(pairs, plan, row.alternative), possible)
    found = SignedRankFound(
        ranked.zeros, ranked.ties, test.zero_method, ranked.w_plus, ranked.w_minus, ranked.z,
        ranked.p_exact, ranked.p_asymptotic, test.shift, test.effect, ranked.method,
        describe_pairs(pairs, (row.a, row.b)),
        _other_zeros(pairs, plan, row.alternative), t_test,
    )  # fmt: skip
    decision: Decision[SignedRankIntervals] = Decision(
        smallest_p=_smallest_p(pairs, len(signs), plan, row.alternative),
        higher=ranked.w_plus > ranked.w_minus,
    )
    return replace(row, p=ranked.p, decision=decision, found=found)


def intervals(data: AnalysisData, row: SignedRankRow, level: float) -> SignedRankIntervals:
    """Return the estimates with the intervals of a level."""
    pairs = pair_up(data.scored, row.outcome, *row.sides, complete=data.complete)
    test = _signed_rank(pairs, data.plan, row.alternative, 1 - level)
    if row.ranked_worst:
        return SignedRankIntervals(_without_ends(test.shift), _without_ends(test.effect))
    return SignedRankIntervals(test.shift, test.effect)


def _without_ends(found: Estimate | None) -> Estimate | None:
    """Return an estimate without its interval."""
    return None if found is None else replace(found, low=None, high=None)


def _too_few(scored: Exposures, outcome: str, contrast: Compared, n: int) -> str:
    """Return the reason for having no test, and what to write instead."""
    said = f"{counted(n, 'complete pairs')}: too few for a test"
    rows = [with_scores(side.rows(scored), outcome) for side in (contrast.a, contrast.b)]
    one, two = (set(table["participant"]) for table in rows)
    if one and two and one.isdisjoint(two):
        said += '; different people met them: write between = "condition" into this contrast'
    return said


def _ranked_worst(pairs: Pairs, plan: Plan, lost: dict[str, int]) -> dict[str, int]:
    if plan.withdrawals != "worst_rank":
        return {}
    return {who: sign for who, sign in lost.items() if who not in pairs.participants}


def _signed_rank(
    pairs: Pairs, plan: Plan, alternative: Alternative, confidence: float
) -> SignedRank:
    return signed_rank(
        pairs.differences,
        pairs.unit,
        zeros=plan.zeros,
        alternative=alternative,
        p_value=plan.p_value,
        confidence=confidence,
        shift_interval=plan.shift_interval,
        effect_interval=(
            "normal_shift" if plan.rank_biserial_interval == "normal_shift" else "fisher_z"
        ),
        interval_n=_interval_n(pairs, plan),
    )


def _smallest_p(pairs: Pairs, withdrawn: int, plan: Plan, alternative: Alternative) -> float:
    """Return the smallest p of these differences: all in one direction."""
    one_way = np.abs(pairs.differences) * (-1 if alternative == "less" else 1)
    signs = [-1 if alternative == "less" else 1] * withdrawn
    if withdrawn:
        return worst_rank(
            one_way, signs, zeros=plan.zeros, alternative=alternative, p_value=plan.p_value
        ).p
    return signed_rank(
        one_way, zeros=plan.zeros, alternative=alternative, p_value=plan.p_value, intervals=False
    ).p


def _interval_n(pairs: Pairs, plan: Plan) -> int | None:
    # R's effectsize counts scores of the first condition where its formula means differences.
    return int(np.count_nonzero(pairs.a)) if plan.rank_biserial_interval == "effectsize" else None


def _other_zeros(pairs: Pairs, plan: Plan, alternative: Alternative) -> OtherZeros:
    other: Zeros = "wilcox" if plan.zeros == "pratt" else "pratt"
    test = signed_rank(
        pairs.differences,
        zeros=other,
        alternative=alternative,
        p_value=plan.p_value,
        intervals=False,
    )
    return OtherZeros(test, test.p, test.method)


def _t_test(pairs: Pairs, plan: Plan, alternative: Alternative) -> PairedTTest | None:
    found = paired_t(
        pairs.differences, pairs.unit, alternative=alternative, confidence=plan.confidence
    )
    if found is None:
        return None
    d = found.cohen_d_interval
    return PairedTTest(
        found.n, found.mean, found.standard_error, int(found.df), found.t, found.p, found.low,
        found.high, found.confidence, found.alternative, d.estimate, d.low, d.high,
        found.bayes_factor_10,
    )  # fmt: skip


def describe_pairs(pairs: Pairs, names: tuple[str, str]) -> dict[str, Description]:
    """Return mean, spread and quartiles of both conditions and of the differences, in points.

    The interval of a mean difference stands beside its t test alone: beside the verdict of a test
    of ranks, at its family's level, it could say another thing.
    """
    return {
        names[0]: describe(pairs.a * pairs.unit),
        names[1]: describe(pairs.b * pairs.unit),
        _DIFFERENCE: describe(pairs.differences * pairs.unit),
    }
