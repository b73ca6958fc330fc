"""What the tests of a plan become with other people in them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypedDict

from vrcomfort.report.pairs import pair_up
from vrcomfort.stats.signed_rank import signed_rank, worst_rank

if TYPE_CHECKING:
    from vrcomfort.report.contrasts import Compared
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.stats.ranks import Alternative
    from vrcomfort.stats.signed_rank import PValue, SignedRank, Zeros

    Test = dict[str, Any]

AVAILABLE = "all with a score in both conditions (means of unequal numbers)"
COMPLETE = "only those with a score of every planned exposure"
WORST_RANK = "withdrawal ranked as the worst outcome of its condition"
WORST_CASE = "worst case: every withdrawal counted against the observed direction"


def sensitivity(
    scored: Exposures, plan: Plan, test: Test, contrast: Compared, lost: dict[str, int]
) -> list[dict[str, Any]]:
    """Repeat one test on other sets of people.

    Parameters
    ----------
    lost
        Participants without a pair who withdrew: 1 if under a, −1 if under b, 0 if unknown.
    """
    if test["not_tested"]:
        return []
    a, b, outcome, chosen = contrast.a, contrast.b, test["outcome"], _options(plan, test)
    whole, any_number = (
        pair_up(scored, outcome, a, b, complete=complete) for complete in (True, False)
    )
    primary, other, what = (
        (whole, any_number, AVAILABLE) if plan.needs_every_score else (any_number, whole, COMPLETE)
    )
    found = {what: signed_rank(other.differences, **chosen, intervals=False)}
    gone = [sign for person, sign in lost.items() if person not in primary.participants]
    if gone:
        against = -1 if test["w_plus"] >= test["w_minus"] else 1
        assumed = {WORST_RANK: gone, WORST_CASE: [against] * len(gone)}
        found |= {
            name: worst_rank(primary.differences, signs, **chosen)
            for name, signs in assumed.items()
        }
    return [_line(name, result, test) for name, result in found.items()]


class _Options(TypedDict):
    zeros: Zeros
    alternative: Alternative
    p_value: PValue


def _options(plan: Plan, test: Test) -> _Options:
    return {"zeros": plan.zeros, "alternative": test["alternative"], "p_value": plan.p_value}


def _line(what: str, result: SignedRank, test: Test) -> dict[str, Any]:
    same = {key: test[key] for key in ("a", "b", "outcome")}
    return {**same, "analysis": what, "n": result.n, "z": result.z, "p": result.p}
