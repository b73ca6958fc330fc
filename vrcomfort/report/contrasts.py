"""The contrasts of a plan: their sides, as the data have them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

from vrcomfort.errors import InputError
from vrcomfort.records.names import natural
from vrcomfort.report.exposures import column_of
from vrcomfort.report.pairs import Side, sides_of
from vrcomfort.settings import did_you_mean

if TYPE_CHECKING:
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Contrast, Plan
    from vrcomfort.stats.ranks import Alternative


TAKEN = {"item": "a column of the table of symptoms", "difference": "a column of the tests"}
"""Reserved names → the column of that name."""


@dataclass(frozen=True)
class Compared:
    """A contrast as it is made with the data."""

    a: Side
    b: Side
    alternative: Alternative
    between: str = ""
    """The column that groups people; blank: the same people met both sides."""
    test: str = "signed_rank"

    @property
    def of_conditions(self) -> bool:
        """Whether both sides are conditions at the plan's moment after exposure."""
        return not (self.a.timepoint or self.b.timepoint or self.between)


def conditions_of(scored: Exposures, labels: dict[str, str]) -> list[str]:
    """Return the conditions in the data, in the protocol's order, then alphabetical.

    Raises
    ------
    InputError
        If one has the name of a column that stands beside those of the conditions.
    """
    order = {name: place for place, name in enumerate(labels)}
    found = {str(name) for name in scored.table["condition"].unique()} - {""}
    for name in sorted(found & TAKEN.keys()):
        message = f"a condition is called `{name}`, as {TAKEN[name]} is"
        raise InputError(f"{message}; give it another name")
    return sorted(found, key=lambda name: (order.get(name, len(order)), natural(name)))


def contrasts_of(plan: Plan, conditions: list[str], there: list[str]) -> list[Compared]:
    """Return the plan's contrasts, or every pair of the conditions in the data.

    A condition of the study (`there`) that nobody finished is compared all the same, so that the
    report says why there is no test.

    Raises
    ------
    InputError
        If the plan compares a condition that neither the data nor the study have.
    """
    for index, contrast in enumerate(plan.contrasts):
        groups = contrast.between and contrast.between != "condition"
        sides = [] if groups else [("a", contrast.a), ("b", contrast.b)]
        for key, name in (*sides, ("condition", contrast.condition)):
            if name and name not in there:
                hint = did_you_mean(name, there)
                hint = f"; {hint}" if hint.startswith("did") else ""
                message = (
                    f"the analysis plan compares condition `{name}`; the data have "
                    f"{', '.join(there)}{hint}"
                )
                raise plan.fault(message, "contrasts", index, key)
    pairs = [Compared(Side(a), Side(b), plan.alternative) for a, b in combinations(conditions, 2)]
    return [_compared(each, plan) for each in plan.contrasts] or pairs


def _compared(contrast: Contrast, plan: Plan) -> Compared:
    """Return the sides; those at one moment after exposure have the scores of the plan."""
    alternative = contrast.alternative or plan.alternative
    if contrast.between:
        sides = sides_of(contrast.between, contrast.a, contrast.b, contrast.condition)
        test = contrast.test or "mann_whitney"
        return Compared(*sides, alternative, contrast.between, test)
    test = contrast.test or "signed_rank"
    moments = [
        name or plan.exposure_timepoint for name in (contrast.a_timepoint, contrast.b_timepoint)
    ]
    if set(moments) == {plan.exposure_timepoint}:
        return Compared(Side(contrast.a), Side(contrast.b), alternative, test=test)
    sides = Side(contrast.a, moments[0]), Side(contrast.b, moments[1])
    return Compared(*sides, alternative, test=test)


def check_groups(plan: Plan, scored: Exposures) -> None:
    """Raise InputError where a contrast is between groups of a column that the data do not have."""
    for place, each in enumerate(plan.contrasts):
        if each.between:
            check_group(plan, scored, ("contrasts", place), each.between, each.a, each.b)


def check_group(
    plan: Plan, scored: Exposures, path: tuple[str, int], between: str, a: str, b: str
) -> None:
    """Raise InputError where the data do not have the column, or the groups, of an entry.

    Parameters
    ----------
    path
        Place of the entry in the plan.
    """
    said = {column for person in scored.people.values() for column in person}
    columns = {*said, "group", "sequence", "condition"} - {"status", "note", "enrolled_at"}
    if between not in columns:
        hint = did_you_mean(between, columns)
        message = f"`{between}` is not a column with groups of participants; {hint}"
        raise plan.fault(message, *path, "between")
    there = set(column_of(scored, scored.table, between).dropna().astype(str))
    for side, level in (("a", a), ("b", b)):
        if level not in there:
            known = ", ".join(sorted(there, key=natural)) or "nobody with a score"
            message = f"`{between}` is never `{level}`; the data have {known}"
            raise plan.fault(message, *path, side)
