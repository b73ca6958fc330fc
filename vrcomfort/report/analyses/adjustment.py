"""Adjustment of p values in the families of a plan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from vrcomfort.report.families import decide
from vrcomfort.stats.multiplicity import holm

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vrcomfort.report.analyses.anova import AnovaRow
    from vrcomfort.report.plan import Plan
    from vrcomfort.stats.anova import AnovaEffect


@dataclass(frozen=True)
class AdjustedFamily:
    """A family, and how many p values it adjusts."""

    name: str
    method: str
    size: int


def adjust(
    plan: Plan, tests: Sequence[dict[str, Any]], anovas: Sequence[AnovaRow]
) -> tuple[list[AdjustedFamily], list[AnovaRow]]:
    """Set `family`, `p_holm`, `level` and `verdict` of every test that was made.

    Returns
    -------
    list of AdjustedFamily, list of AnovaRow
        The latter with the adjusted p of each effect.
    """
    level, found, adjusted_rows = 1 - plan.confidence, [], list(anovas)
    for test in tests:
        if not test["not_tested"]:
            decide(test, level, [test["p"]], 0)
    for family in plan.families:
        of_tests = "tests" in family.analyses
        members = [t for t in tests if of_tests and t["outcome"] in family.outcomes]
        places = [
            (row, effect)
            for row, anova in enumerate(anovas)
            if "anova" in family.analyses and anova.fit and anova.outcome in family.outcomes
            for effect in range(len(anova.fit.effects))
        ]
        p_values = [test["p"] for test in members]
        p_values += [_p_of_effect(adjusted_rows[row], effect) for row, effect in places]
        of_holm = family.method == "holm"
        adjusted = holm(p_values) if of_holm else [None] * len(p_values)
        for place, (member, p) in enumerate(zip(members, adjusted, strict=False)):
            member["family"], member["p_holm"] = family.name, p
            if p is not None:
                decide(member, level, p_values, place)
        for (row, effect), p in zip(places, adjusted[len(members) :], strict=True):
            adjusted_rows[row] = _with_p(adjusted_rows[row], effect, family.name, p)
        size = sum(p is not None for p in p_values)
        found.append(AdjustedFamily(family.name, family.method, size))
    return found, adjusted_rows


def _p_of_effect(row: AnovaRow, effect: int) -> float | None:
    return reported_p(row.fit.effects[effect].test) if row.fit else None


def reported_p(effect: AnovaEffect) -> float | None:
    """Return the p that counts: of an effect without sphericity, Greenhouse and Geisser's."""
    corrected = effect.p_greenhouse_geisser
    return effect.p if corrected is None else corrected


def _with_p(row: AnovaRow, place: int, family: str, p: float | None) -> AnovaRow:
    if row.fit is None:
        return row
    effects = list(row.fit.effects)
    effects[place] = replace(effects[place], family=family, p_holm=p)
    return replace(row, fit=replace(row.fit, effects=tuple(effects)))
