"""The smallest effect that a study of its size could have found, where the plan asks for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vrcomfort.stats.power import PairedTest, smallest_effect

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vrcomfort.report.analyses.signed_rank import SignedRankRow
    from vrcomfort.report.plan import Plan

STUDIES = 1000
"""Simulated for each effect that is tried: power is then known to ± 2.5 %."""
SEED = 20150323


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
    return [_row(plan, plan.smallest_effect_power, test) for test in primary]


def _row(plan: Plan, power: float, test: SignedRankRow) -> SmallestEffectRow:
    tested = PairedTest(
        "signed_rank", test.alternative, 1 - plan.confidence, plan.zeros, plan.p_value
    )
    found = smallest_effect(tested, test.n, power=power, studies=STUDIES, seed=SEED)
    sd = test.found.descriptives["difference"].sd if test.found else None
    points = None if found is None or sd is None else found * sd
    return SmallestEffectRow(
        test.a, test.b, test.outcome, test.n, power, found, points, STUDIES, SEED
    )
