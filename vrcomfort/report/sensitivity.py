"""Sensitivity analyses: the planned tests on other analysis sets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypedDict

from vrcomfort.report.pairs import pair_up
from vrcomfort.report.withdrawals import lost_signs
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
