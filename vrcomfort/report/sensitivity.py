"""Sensitivity: the planned tests on other analysis sets, and the effect that they would find."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypedDict

from vrcomfort.report.pairs import pair_up
from vrcomfort.report.withdrawals import lost_signs
from vrcomfort.stats.power import PairedTest, smallest_effect
from vrcomfort.stats.ranks import level_of
from vrcomfort.stats.signed_rank import signed_rank, worst_rank

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vrcomfort.report.analyses import AnalysisData
    from vrcomfort.report.analyses.signed_rank import SignedRankRow
    from vrcomfort.report.plan import Plan
    from vrcomfort.stats.ranks import Alternative
    from vrcomfort.stats.signed_rank import PValue, Zeros

AVAILABLE = "all with a score in both conditions (means of unequal numbers)"
COMPLETE = "only those with a score of every planned exposure"
WORST_RANK = "withdrawal ranked as the worst outcome of its condition"
WORST_CASE = "worst case: every withdrawal counted against the observed direction"
STUDIES = 1000
"""Simulated for each effect that is tried: power is then known to ± 2.5 %."""
SEED = 20150323


@dataclass(frozen=True)
class RepeatedTest:
    """A test, repeated on another analysis set."""

    a: str
    b: str
    outcome: str
    analysis: str
    n: int
    z: float | None
    p: float


def sensitivity(data: AnalysisData, tests: Sequence[SignedRankRow]) -> list[RepeatedTest]:
    """Repeat the tests on other analysis sets."""
    return [line for test in tests for line in _of_test(data, test)]


def _of_test(data: AnalysisData, test: SignedRankRow) -> list[RepeatedTest]:
    if test.found is None:
        return []
    plan, chosen = data.plan, _options(data.plan, test)
    whole, any_number = (
        pair_up(data.scored, test.outcome, *test.sides, complete=complete)
        for complete in (True, False)
    )
    primary, other, what = (
        (whole, any_number, AVAILABLE) if plan.needs_every_score else (any_number, whole, COMPLETE)
    )
    found = {what: signed_rank(other.differences, **chosen, intervals=False)}
    lost = lost_signs(data.withdrawals, test.a, test.b)
    gone = [sign for person, sign in lost.items() if person not in primary.participants]
    if gone:
        against = -1 if test.found.w_plus >= test.found.w_minus else 1
        assumed = {WORST_RANK: gone, WORST_CASE: [against] * len(gone)}
        found |= {
            name: worst_rank(primary.differences, signs, **chosen)
            for name, signs in assumed.items()
        }
    return [
        RepeatedTest(test.a, test.b, test.outcome, name, result.n, result.z, result.p)
        for name, result in found.items()
    ]


class _Options(TypedDict):
    zeros: Zeros
    alternative: Alternative
    p_value: PValue


def _options(plan: Plan, test: SignedRankRow) -> _Options:
    return {"zeros": plan.zeros, "alternative": test.alternative, "p_value": plan.p_value}


@dataclass(frozen=True)
class SmallestEffectRow:
    """The effect that a test finds with a power; `effect_sd` in SDs of the differences."""

    a: str
    b: str
    outcome: str
    n: int
    power: float
    effect_sd: float | None
    effect_points: float | None
    studies: int
    seed: int


def smallest_effects(plan: Plan, tests: Sequence[SignedRankRow]) -> list[SmallestEffectRow]:
    """Return, for each signed-rank test of the primary outcome, the effect it finds so often.

    It is that of the test as it was made: its number of pairs, its sides, its level. Power is
    that of the plan's `smallest_effect_power`.
    """
    if plan.smallest_effect_power is None:
        return []
    made = [test for test in tests if test.found]
    primary = [test for test in made if test.outcome == made[0].outcome]
    return [_smallest_effect(plan, plan.smallest_effect_power, test) for test in primary]


def _smallest_effect(plan: Plan, power: float, test: SignedRankRow) -> SmallestEffectRow:
    tested = PairedTest(
        "signed_rank", test.alternative, level_of(plan.confidence), plan.zeros, plan.p_value
    )
    found = smallest_effect(tested, test.n, power=power, studies=STUDIES, seed=SEED)
    sd = test.found.difference.sd if test.found else None
    points = None if found is None or sd is None else found * sd
    return SmallestEffectRow(
        test.a, test.b, test.outcome, test.n, power, found, points, STUDIES, SEED
    )
