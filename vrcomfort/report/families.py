"""Which tests are adjusted together: the families of a plan, over tests and ANOVA."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vrcomfort.stats.multiplicity import holm

if TYPE_CHECKING:
    from vrcomfort.report.plan import Family, Plan

Row = dict[str, Any]


def adjust(plan: Plan, tests: list[Row], anovas: list[Row]) -> list[Row]:
    """Set `family` and `p_holm` of every test and ANOVA effect that is in a family.

    Returns
    -------
    list of dict
        One row per family: name, method, and how many p values it adjusts.
    """
    for test in tests:
        test["family"] = None
    found = []
    for family in plan.families:
        members = _members(family, tests, anovas)
        p_values = [reported_p(member) for member in members]
        adjusted = holm(p_values) if family.method == "holm" else [None] * len(members)
        for member, p in zip(members, adjusted, strict=True):
            member["family"], member["p_holm"] = family.name, p
        size = sum(p is not None for p in p_values)
        found.append({"name": family.name, "method": family.method, "size": size})
    return found


def _members(family: Family, tests: list[Row], anovas: list[Row]) -> list[Row]:
    members: list[Row] = []
    if "tests" in family.analyses:
        members += [test for test in tests if test["outcome"] in family.outcomes]
    if "anova" in family.analyses:
        made = [found for found in anovas if not found["not_tested"]]
        members += [e for found in made if found["outcome"] in family.outcomes
                    for e in found["effects"]]  # fmt: skip
    return members


def reported_p(row: Row) -> float | None:
    """Return the p that counts: of an effect without sphericity, Greenhouse and Geisser's."""
    corrected: float | None = row.get("p_greenhouse_geisser")
    p: float | None = row["p"]
    return p if corrected is None else corrected
