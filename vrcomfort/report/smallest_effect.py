"""The smallest effect that a study of its size could have found, where the plan asks for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vrcomfort.stats.power import PairedTest, smallest_effect

if TYPE_CHECKING:
    from vrcomfort.report.plan import Plan

STUDIES = 1000
"""Simulated for each effect that is tried: power is then known to ± 2.5 %."""
SEED = 20150323


def smallest_effects(plan: Plan, tests: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return, for each signed-rank test of the primary outcome, the effect it finds so often.

    It is that of the test as it was made: its number of pairs, its sides, its level. Power is
    what the plan's `smallest_effect_power` says.
    """
    if plan.smallest_effect_power is None:
        return []
    made = [test for test in tests if not test["not_tested"] and test["kind"] == "paired"]
    primary = [test for test in made if test["outcome"] == made[0]["outcome"]]
    return [_row(plan, plan.smallest_effect_power, test) for test in primary]


def _row(plan: Plan, power: float, test: dict[str, Any]) -> dict[str, Any]:
    tested = PairedTest(
        "signed_rank", test["alternative"], 1 - plan.confidence, plan.zeros, plan.p_value
    )
    found = smallest_effect(tested, test["n"], power=power, studies=STUDIES, seed=SEED)
    sd = test["descriptives"]["difference"]["sd"]
    return {
        "a": test["a"],
        "b": test["b"],
        "outcome": test["outcome"],
        "n": test["n"],
        "power": power,
        "effect_sd": found,
        "effect_points": None if found is None or sd is None else found * sd,
        "studies": STUDIES,
        "seed": SEED,
    }
