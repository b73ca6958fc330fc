"""The decisions of all tests, with p values adjusted in the families of a plan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from vrcomfort.report.analyses import ANALYSES, with_intervals
from vrcomfort.report.analyses.anova import ANOVA, reported_p
from vrcomfort.report.families import Decision, decided
from vrcomfort.stats.multiplicity import holm
from vrcomfort.stats.ranks import level_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vrcomfort.report.analyses import AnalysisData
    from vrcomfort.report.analyses.anova import AnovaRow
    from vrcomfort.report.analyses.comparisons import ComparisonRow
    from vrcomfort.report.analyses.contract import Section
    from vrcomfort.report.analyses.signed_rank import SignedRankRow
    from vrcomfort.report.plan import Plan


@dataclass(frozen=True)
class AdjustedFamily:
    """A family, and how many p values it adjusts."""

    name: str
    method: str
    size: int


@dataclass(frozen=True)
class Decided:
    """The rows of all analyses, decided, and the families."""

    rows: dict[str, Sequence[Any]]
    families: list[AdjustedFamily]

    def of(self, *sections: Section) -> dict[str, Sequence[Any]]:
        """Return the rows of the analyses that stand in some sections of the page."""
        return {each.key: self.rows[each.key] for each in ANALYSES if each.section in sections}


def decide_all(data: AnalysisData, rows: Mapping[str, Sequence[Any]]) -> Decided:
    """Return all rows with the decision of each test and the intervals of its level."""
    alone = [each for each in ANALYSES if each.by_outcome and each is not ANOVA]
    compared = [(each, row) for each in alone for row in rows[each.key]]
    families, decisions, anovas = adjust(data.plan, [row for _, row in compared], ANOVA.of(rows))
    found: dict[str, list[Any]] = {each.key: [] for each in alone}
    for (analysis, row), decision in zip(compared, decisions, strict=True):
        decided_row = replace(row, decision=decision)
        found[analysis.key].append(with_intervals(data, analysis, decided_row))
    return Decided({**rows, **found, ANOVA.key: anovas}, families)


def adjust(
    plan: Plan, compared: Sequence[SignedRankRow | ComparisonRow], anovas: Sequence[AnovaRow]
) -> tuple[list[AdjustedFamily], list[Decision[Any]], list[AnovaRow]]:
    """Decide every test, and adjust p of those, and of ANOVA effects, that are in a family."""
    level, found, adjusted_rows = level_of(plan.confidence), [], list(anovas)
    decisions = [_decided(test.p, test.decision, level, [test.p], 0) for test in compared]
    for family in plan.families:
        of_tests = "tests" in family.analyses
        members = [i for i, t in enumerate(compared) if of_tests and t.outcome in family.outcomes]
        places = [
            (row, effect)
            for row, anova in enumerate(anovas)
            if "anova" in family.analyses and anova.fit and anova.outcome in family.outcomes
            for effect in range(len(anova.fit.effects))
        ]
        p_values = [compared[member].p for member in members]
        p_values += [_p_of_effect(adjusted_rows[row], effect) for row, effect in places]
        of_holm = family.method == "holm"
        adjusted = holm(p_values) if of_holm else [None] * len(p_values)
        for place, member in enumerate(members):
            p = adjusted[place]
            decision = replace(decisions[member], family=family.name, p_holm=p)
            if p is not None:
                decision = _decided(compared[member].p, decision, level, p_values, place)
            decisions[member] = decision
        for (row, effect), p in zip(places, adjusted[len(members) :], strict=True):
            adjusted_rows[row] = _with_p(adjusted_rows[row], effect, family.name, p, level)
        size = sum(p is not None for p in p_values)
        found.append(AdjustedFamily(family.name, family.method, size))
    return found, decisions, adjusted_rows


def _decided(
    p: float | None,
    decision: Decision[Any],
    level: float,
    p_values: Sequence[float | None],
    place: int,
) -> Decision[Any]:
    """Return a decision with the level at which a test decides among others, and its verdict."""
    if p is None or decision.smallest_p is None:
        return decision
    smallest, higher = decision.smallest_p, bool(decision.higher)
    own, verdict = decided(p, smallest, level, p_values, place, higher=higher)
    return replace(decision, level=own, verdict=verdict)


def _p_of_effect(row: AnovaRow, effect: int) -> float | None:
    return reported_p(row.fit.effects[effect].test) if row.fit else None


def _with_p(row: AnovaRow, place: int, family: str, p: float | None, level: float) -> AnovaRow:
    if row.fit is None:
        return row
    effects = list(row.fit.effects)
    deciding = reported_p(effects[place].test) if p is None else p
    shown = deciding is not None and deciding <= level
    effects[place] = replace(effects[place], family=family, p_holm=p, shown=shown)
    return replace(row, fit=replace(row.fit, effects=tuple(effects)))
