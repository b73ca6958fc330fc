"""Pairs of integer scores, one per participant, for two sides of a contrast."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import lcm
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import pandas as pd

from vrcomfort.plurals import counted
from vrcomfort.records.names import natural
from vrcomfort.report.exposures import column_of, with_scores

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.possible import Possible

    Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Side:
    """One side of a contrast: a condition, a timepoint, or both; or a group of participants."""

    condition: str = ""
    timepoint: str = ""
    """Blank: that of exposure, with scores as the plan has them; else raw scores at it."""
    column: str = ""
    level: str = ""
    """People with this value of a column; see `column_of`."""

    @property
    def name(self) -> str:
        """Return how results call it."""
        moment = " at ".join(part for part in (self.condition, self.timepoint) if part)
        return " in ".join(part for part in (self.level, moment) if part)

    def rows(self, scored: Exposures) -> pd.DataFrame:
        """Return the exposures, or the moments, of this side."""
        return scored.looked_up(("rows", self), lambda: self._rows(scored))

    def _rows(self, scored: Exposures) -> pd.DataFrame:
        table = scored.moments if self.timepoint else scored.table
        if self.timepoint:
            table = table[table["timepoint"] == self.timepoint]
        if self.column:
            table = table[(column_of(scored, table, self.column) == self.level).fillna(False)]
        return table[table["condition"] == self.condition] if self.condition else table


def possible_difference(scored: Exposures, outcome: str, *sides: Side) -> Possible:
    """Return the range of the difference of two sides; of moments, that of raw scores."""
    raw = all(side.timepoint for side in sides)
    return (scored.possible[outcome] if raw else scored.possible_scores(outcome)).difference


def sides_of(between: str, a: str, b: str, condition: str) -> tuple[Side, Side]:
    """Return the sides of a contrast between groups."""
    if between == "condition":
        return Side(a), Side(b)
    one, two = (Side(condition, column=between, level=level) for level in (a, b))
    return one, two


@dataclass(frozen=True)
class Pairs:
    """Scores of the same people under sides a and b.

    Parameters
    ----------
    a, b
        Integer raw sums, shape (n,): over all exposures of a side, brought to a common
        number of exposures.
    unit
        Points per step, per exposure: ``a * unit`` is the mean score over exposures.
    """

    participants: tuple[str, ...]
    a: Integers
    b: Integers
    unit: float

    @property
    def differences(self) -> Integers:
        """Return a minus b, shape (n,)."""
        return self.a - self.b


class Tested(Protocol):
    """A row of a test or a comparison: its sides, its outcome, its participants."""

    @property
    def a(self) -> str:
        """Name of the first side."""

    @property
    def b(self) -> str:
        """Name of the second side."""

    @property
    def outcome(self) -> str:
        """Name of the outcome."""

    @property
    def participants(self) -> tuple[str, ...]:
        """The participants in the test."""


def in_a_test(tests: Sequence[Tested], condition: str, outcome: str | None = None) -> set[str]:
    """Return the participants in any test of a condition (of one outcome)."""
    return {
        person
        for test in tests
        if condition in (test.a, test.b) and outcome in (None, test.outcome)
        for person in test.participants
    }


def pair_up(
    scored: Exposures, outcome: str, a: Side | str, b: Side | str, *, complete: bool = True
) -> Pairs:
    """Pair each participant's scores under two sides; a name is that of a condition.

    Sums of integers stay exact: instead of dividing by the number of exposures, every sum is
    multiplied up to the common multiple of all numbers, and the unit divided by it.

    Parameters
    ----------
    complete
        Whether a participant must have every planned exposure of both sides; any number will do
        otherwise.
    """
    sides = [Side(each) if isinstance(each, str) else each for each in (a, b)]
    people, sums, common = side_sums(scored, outcome, sides, complete=complete)
    return Pairs(tuple(people), sums[:, 0], sums[:, 1], scored.units[outcome] / common)


def side_sums(
    scored: Exposures, outcome: str, sides: list[Side], *, complete: bool
) -> tuple[list[str], Integers, int]:
    """Return participants with all sides, their integer sums, and the exposures per sum.

    The sums have shape (n, sides); see `pair_up` for `complete`.
    """
    totals = [_totals(scored, outcome, side) for side in sides]
    needed = [needed_of(scored, outcome, side) if complete else 1 for side in sides]
    sums = np.stack([found for found, _ in totals], axis=1)
    counts = np.stack([count for _, count in totals], axis=1)
    there = np.flatnonzero((counts >= needed).all(axis=1))
    people, counted = _people(scored), counts[there]
    common = lcm(*map(int, np.unique(counted)))
    return [people[place] for place in there], sums[there] * (common // counted), common


@dataclass(frozen=True)
class Groups:
    """Scores of two groups of different people.

    Parameters
    ----------
    a, b
        Integer sums, shapes (n,) and (m,), brought to a common number of exposures.
    unit
        Points per step, per exposure.
    """

    people_a: tuple[str, ...]
    people_b: tuple[str, ...]
    a: Integers
    b: Integers
    unit: float
    in_both: tuple[str, ...]
    """Who has scores in both, and is in neither here."""


def groups_of(scored: Exposures, outcome: str, a: Side, b: Side, *, complete: bool) -> Groups:
    """Return everybody's score in one of two groups; see `pair_up` for `complete`."""
    totals = [_totals(scored, outcome, side) for side in (a, b)]
    needed = [needed_of(scored, outcome, side) if complete else 1 for side in (a, b)]
    there = [counts >= max(need, 1) for (_, counts), need in zip(totals, needed, strict=True)]
    both = (totals[0][1] > 0) & (totals[1][1] > 0)
    places = [np.flatnonzero(each & ~both) for each in there]
    counted = [counts[place] for (_, counts), place in zip(totals, places, strict=True)]
    common = lcm(*map(int, np.unique(np.concatenate(counted))))
    sums = [
        found[place] * (common // count)
        for (found, _), place, count in zip(totals, places, counted, strict=True)
    ]
    people = _people(scored)
    names = [tuple(people[place] for place in each) for each in (*places, np.flatnonzero(both))]
    return Groups(names[0], names[1], sums[0], sums[1], scored.units[outcome] / common, names[2])


NO_VARIANCE = "nothing varies, so that there is no t"


def too_few(samples: Pairs | Groups) -> str | None:
    """Say why samples cannot be compared; None where they can."""
    if isinstance(samples, Pairs):
        n = len(samples.participants)
        return f"{counted(n, 'complete pairs')}: too few for a test" if n < 2 else None
    if samples.in_both and min(samples.a.size, samples.b.size) < 2:
        return "the same people are on both sides: leave `between` away to compare pairs"
    if min(samples.a.size, samples.b.size) < 2:
        return f"{samples.a.size} and {samples.b.size} people: too few for a test"
    return None


def _people(scored: Exposures) -> list[str]:
    """Return everybody in the tables, in order."""
    tables = (scored.table, scored.moments)
    return scored.looked_up(
        ("people",),
        lambda: sorted({who for table in tables for who in table["participant"]}, key=natural),
    )


def _totals(scored: Exposures, outcome: str, side: Side) -> tuple[Integers, Integers]:
    """Return the sum of each of `_people` under a side, and of how many scores it is."""

    def places() -> Integers:
        place = {who: number for number, who in enumerate(_people(scored))}
        return np.array([place[who] for who in side.rows(scored)["participant"]], dtype=np.int64)

    def totals() -> tuple[Integers, Integers]:
        whose = scored.looked_up(("places", side), places)
        values = side.rows(scored)[outcome].to_numpy(dtype=np.float64)
        there, size = ~np.isnan(values), len(_people(scored))
        sums = np.bincount(whose[there], values[there], minlength=size)
        return sums.astype(np.int64), np.bincount(whose[there], minlength=size)

    return scored.looked_up(("totals", outcome, side), totals)


def needed_of(scored: Exposures, outcome: str, side: Side) -> int:
    """Return how many scores of a side a participant is to have."""
    if not side.timepoint and side.condition:
        return scored.planned_of.get(outcome, {}).get(side.condition, 1)
    return usual(Counter(with_scores(side.rows(scored), outcome)["participant"]).values())


def usual(counts: Iterable[int]) -> int:
    """Return the most frequent number; of two, the larger: a score is lost more easily than won."""
    found = Counter(counts)
    return max(found, key=lambda count: (found[count], count), default=1)


def with_every_score(
    rows: pd.DataFrame, cells: Sequence[str], planned: Mapping[Any, int] | None = None
) -> pd.DataFrame:
    """Return the rows of participants and cells with every planned score: the rule of `needed_of`.

    Parameters
    ----------
    rows
        One score each, with the participant and the columns of `cells`.
    cells
        Columns whose levels make a cell.
    planned
        Cell (a level, or a tuple of them) → scores that a participant is to have in it; the most
        frequent number in each cell without it.
    """
    if rows.empty:
        return rows
    by = ["participant", *cells]
    counts = rows.groupby(by).size()
    needed = (
        counts.groupby(list(cells)).transform(usual)
        if planned is None
        else counts.droplevel("participant").index.map(planned)
    )
    whole = counts.index[counts >= needed]
    return rows[pd.MultiIndex.from_frame(rows[by]).isin(whole)]
