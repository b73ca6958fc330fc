"""Notices on the tests of the primary outcome: reasons why they give no answer, or another."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from vrcomfort.report.families import holds, is_shown
from vrcomfort.report.words import interval, p_equals, p_value
from vrcomfort.stats.mixed import MOST_LEVELS
from vrcomfort.stats.ranks import level_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from vrcomfort.report.analyses.comparisons import ComparisonRow
    from vrcomfort.report.analyses.signed_rank import SignedRankRow
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan

    Tested: TypeAlias = SignedRankRow | ComparisonRow
    _Pair: TypeAlias = Callable[[Tested], str]

MOST_NAMED = 3


def decision_notices(
    scored: Exposures, plan: Plan, tests: Sequence[Tested], labels: Mapping[str, str]
) -> list[str]:
    """Return the sentences, without their full stops, on the tests of the first outcome."""
    if not scored.outcomes:
        return []
    primary = scored.outcomes[0]
    mine = [test for test in tests if test.outcome == primary.name and test.p is not None]

    def pair(test: Tested) -> str:
        return " and ".join(labels.get(side, side) for side in (test.a, test.b))

    alike = [*_no_difference_at_all(mine, primary.title, pair)]
    many = [*_many_conditions(mine, scored, plan, primary.title)]
    return [
        *(alike or _not_possible(mine, primary.title, level_of(plan.confidence))),
        *(many or _changed_by_the_family(mine, plan, primary.title, pair)),
    ]


def _not_possible(tests: Sequence[Tested], outcome: str, level: float) -> Iterator[str]:
    """Yield that no answers of so few people could have shown a difference."""
    smallest = [t.decision.smallest_p for t in tests if t.decision.smallest_p is not None]
    if tests and smallest and all(t.decision.verdict == "not_possible" for t in tests):
        most = max(len(test.participants) for test in tests)
        alike = min(getattr(test.found, "zeros", None) or 0 for test in tests)
        people = f"{most} people, {most - alike} of whom differ," if alike else f"{most} people"
        these = "so many" if min(smallest) <= level else "these"
        yield (
            f"with {people} no p below {_exactly(min(smallest))} exists: whatever they "
            f"answered, no difference of {outcome} could be shown by {these} tests"
        )


def _no_difference_at_all(tests: Sequence[Tested], outcome: str, pair: _Pair) -> Iterator[str]:
    """Yield the pairs of conditions with equal scores for every participant."""
    alike = [
        test
        for test in tests
        if (zeros := getattr(test.found, "zeros", None)) is not None
        and zeros == len(test.participants) > 0
    ]
    if alike:
        yield (
            f"{outcome} is the same under {_listed([pair(test) for test in alike])} for every "
            "participant: were the answers of one copied to the other?"
        )


def _changed_by_the_family(
    tests: Sequence[Tested], plan: Plan, outcome: str, pair: _Pair
) -> Iterator[str]:
    """Yield the tests that would have shown a difference alone, but not within their family."""
    level = level_of(plan.confidence)
    lost = [
        t
        for t in tests
        if t.p is not None and t.p <= level and not is_shown(t.decision.verdict)
        and t.decision.p_holm is not None
    ]  # fmt: skip
    for test in lost[:MOST_NAMED]:
        shift = getattr(test.found, "shift", None)
        alone = ""
        if shift is not None and not holds(shift, 0.0):
            percent = f"{100 * plan.confidence:g}\u00a0%"
            alone = f", and its unadjusted {percent} interval {interval(shift)} excludes 0"
        yield (
            f"{outcome}, {pair(test)}: {p_equals(test.p)} alone, "
            f"{p_equals(test.decision.p_holm)} among the tests of its family (Holm), which "
            f"decides: not shown{alone}"
        )


def _many_conditions(
    tests: Sequence[Tested], scored: Exposures, plan: Plan, outcome: str
) -> Iterator[str]:
    """Yield the price of comparing all pairs of many conditions without planned contrasts."""
    conditions = scored.table["condition"].nunique()
    if conditions > MOST_LEVELS and len(tests) > conditions:
        level = (level_of(plan.confidence)) / len(tests)
        yield (
            f"{conditions} conditions make {len(tests)} comparisons of {outcome}: the smallest p "
            f"has to be at most {level:.2g} to show a difference; name the contrasts that matter "
            "in a plan"
        )


def _exactly(p: float) -> str:
    """Write p with the digits that it has, as of a few sign patterns: .0625, .5."""
    return f"{p:.3g}".removeprefix("0") if p >= 0.001 else p_value(p)


def _listed(pairs: Sequence[str]) -> str:
    shown = "; ".join(pairs[:MOST_NAMED])
    return f"{shown} and {len(pairs) - MOST_NAMED} more pairs" if pairs[MOST_NAMED:] else shown
