"""Scores and answers described by condition: n, mean, SD, quartiles and range."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.records.names import natural
from vrcomfort.report.asked import timepoints_of
from vrcomfort.report.exposures import with_scores
from vrcomfort.report.pairs import in_a_test
from vrcomfort.report.possible import limited
from vrcomfort.report.rows import INLINE
from vrcomfort.stats.means import MeanInterval, mean_interval

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from numpy.typing import NDArray

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.pairs import Tested
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.possible import Possible

PRIMARY, ALL, TIMEPOINT = "primary", "all", "timepoint"


@dataclass(frozen=True)
class Description:
    """Size, mean, SD, quartiles and range; one value has no SD."""

    n: int
    mean: float
    sd: float | None
    median: float
    q1: float
    q3: float
    minimum: float
    maximum: float


@dataclass(frozen=True)
class DescriptionWithInterval(Description):
    """A description with the interval of the mean; None where there is none."""

    mean_low: float | None
    mean_high: float | None

    @property
    def interval(self) -> MeanInterval:
        """Return the interval of the mean."""
        return MeanInterval(self.mean_low, self.mean_high)

    @property
    def is_beyond_scores(self) -> bool:
        """Return whether the interval of the mean goes beyond the range, or has one end alone."""
        low, high = self.mean_low, self.mean_high
        if low is None or high is None:
            return low is not high
        return low < self.minimum or high > self.maximum


@dataclass(frozen=True)
class DescribedRow:
    """The scores of a condition; None for the difference of two.

    Parameters
    ----------
    by
        ``primary``, the participants in any test of the condition, each with the mean over
        exposures; ``all``, every scored exposure, whoever's; ``scene``, ``position`` and
        ``session``, those of one `level` of it; ``timepoint``, the raw scores at one.
    """

    outcome: str
    by: str
    level: str
    condition: str | None
    found: Description = field(metadata=INLINE)


@dataclass(frozen=True)
class RecoveryScores:
    """All scores after recovery."""

    outcome: str
    found: Description = field(metadata=INLINE)


def describe(values: NDArray[np.floating[Any]]) -> Description:
    """Return a description of values."""
    q1, median, q3 = np.percentile(values, [25, 50, 75])
    return Description(
        n=int(values.size),
        mean=float(values.mean()),
        sd=float(np.std(values, ddof=1)) if values.size > 1 else None,
        median=float(median),
        q1=float(q1),
        q3=float(q3),
        minimum=float(values.min()),
        maximum=float(values.max()),
    )


def describe_with_interval(
    values: NDArray[np.floating[Any]], confidence: float, possible: Possible
) -> DescriptionWithInterval:
    """Return a description with the interval of the mean."""
    found = mean_interval(values, confidence=confidence)
    if (found.low is None) != (found.high is None):  # on one side, the scale alone sets a bound
        low, high = possible
        found = MeanInterval(
            low if found.low is None else found.low, high if found.high is None else found.high
        )
    found = limited(found, possible)
    return DescriptionWithInterval(
        **vars(describe(values)), mean_low=found.low, mean_high=found.high
    )


def describe_all(
    scored: Exposures, plan: Plan, conditions: Sequence[str], tests: Sequence[Tested]
) -> list[DescribedRow]:
    """Describe the scores of each condition, in points; see `DescribedRow`."""
    return [
        DescribedRow(outcome, by, level, condition, found)
        for outcome in scored.units
        for by, level, condition, found in (
            *_primary(scored, plan, outcome, conditions, tests),
            *_exposures(scored, outcome, conditions),
            *_moments(scored, plan, outcome, conditions),
        )
    ]


_Described = list[tuple[str, str, str, Description]]


def _primary(
    scored: Exposures,
    plan: Plan,
    outcome: str,
    conditions: Sequence[str],
    tests: Sequence[Tested],
) -> _Described:
    found: _Described = []
    for condition in conditions:
        part = with_scores(of_the_tested(scored.table, tests, condition, outcome), outcome)
        if len(part):
            means = part.groupby("participant")[outcome].mean() * scored.units[outcome]
            described = describe_with_interval(
                means.to_numpy(dtype=float), plan.confidence, scored.possible_scores(outcome)
            )
            found.append((PRIMARY, "", condition, described))
    return found


def _exposures(scored: Exposures, outcome: str, conditions: Sequence[str]) -> _Described:
    values = scored.table[outcome].to_numpy(dtype=float) * scored.units[outcome]
    there = ~np.isnan(values)
    cells = scored.looked_up(("cells",), lambda: _cells(scored.table, conditions))
    filled = [(by, level, condition, there & rows) for by, level, condition, rows in cells]
    filled = [cell for cell in filled if cell[3].any()]
    levels = {by: {level for other, level, *_ in filled if other == by} for by, *_ in filled}
    return [
        (by, level, condition, describe(values[rows]))
        for by, level, condition, rows in filled
        if by == ALL or len(levels[by]) > 1
    ]


def _moments(scored: Exposures, plan: Plan, outcome: str, conditions: Sequence[str]) -> _Described:
    """Describe the raw scores at each timepoint of the plan, in the order of time."""
    table, unit = with_scores(scored.moments, outcome), scored.units[outcome]
    cells = dict(list(table.groupby(["timepoint", "condition"])[outcome]))
    return [
        (TIMEPOINT, timepoint, condition, describe(cells[timepoint, condition].to_numpy() * unit))
        for timepoint in timepoints_of(plan)
        for condition in conditions or [""]
        if (timepoint, condition) in cells
    ]


_Cells = list[tuple[str, str, str, "NDArray[np.bool_]"]]


def _cells(table: pd.DataFrame, conditions: Sequence[str]) -> _Cells:
    """Return grouping, level, condition and rows of each description."""
    parts = [(ALL, "", np.ones(len(table), dtype=bool))]
    for by in ("scene", "position", "session"):
        levels = sorted(table[by].unique(), key=lambda level: natural(str(level)))
        parts += [(by, str(level), (table[by] == level).to_numpy()) for level in levels]
    met = {condition: (table["condition"] == condition).to_numpy() for condition in conditions}
    return [
        (by, level, condition, rows & met[condition])
        for by, level, rows in parts
        for condition in conditions
    ]


def of_the_tested(
    table: pd.DataFrame, tests: Sequence[Tested], condition: str, outcome: str | None = None
) -> pd.DataFrame:
    """Return a condition's exposures of the participants in its tests."""
    people = in_a_test(tests, condition, outcome)
    return table[(table["condition"] == condition) & table["participant"].isin(people)]


def describe_recovery(scored: Exposures) -> list[RecoveryScores]:
    """Describe all scores after recovery."""
    tables = {outcome: with_scores(scored.recovery, outcome) for outcome in scored.units}
    return [
        RecoveryScores(outcome, _in_points(table, outcome, scored.units[outcome]))
        for outcome, table in tables.items()
        if len(table)
    ]


def _in_points(part: pd.DataFrame, outcome: str, unit: float) -> Description:
    return describe(part[outcome].to_numpy(dtype=float) * unit)
