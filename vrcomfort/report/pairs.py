"""Pairs of integer scores, one per participant, for two conditions."""

from __future__ import annotations

from dataclasses import dataclass
from math import lcm
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.report.ordering import natural

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from vrcomfort.report.exposures import Exposures

    Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Pairs:
    """Scores of the same people under conditions a and b.

    Parameters
    ----------
    a, b
        Integer raw sums, shape (n,): over all exposures of a condition, brought to a common
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


def in_a_test(tests: list[dict[str, Any]], condition: str, outcome: str | None = None) -> set[str]:
    """Return who is in any test of a condition (of one outcome), whomever it compares with."""
    return {
        person
        for test in tests
        if condition in (test["a"], test["b"]) and outcome in (None, test["outcome"])
        for person in test["participants"]
    }


def pair_up(
    scored: Exposures, outcome: str, a: str, b: str, *, complete: dict[str, int] | None = None
) -> Pairs:
    """Pair each participant's scores under two conditions.

    Sums of integers stay exact: instead of dividing by the number of exposures, every sum is
    multiplied up to the common multiple of all numbers, and the unit divided by it.

    Parameters
    ----------
    complete
        Exposures per condition that a participant must have at least; any number will do
        otherwise.
    """
    people, sums, common = condition_sums(scored.table, outcome, [a, b], complete=complete)
    return Pairs(tuple(people), sums[:, 0], sums[:, 1], scored.weights[outcome] / common)


def condition_sums(
    table: pd.DataFrame, outcome: str, conditions: list[str], *, complete: dict[str, int] | None
) -> tuple[list[str], Integers, int]:
    """Return who has all conditions, their integer sums, and how many exposures each sum is of.

    The sums have shape (n, conditions); see `pair_up` for `complete`.
    """
    part = table[table["condition"].isin(conditions)]
    grouped = part.groupby(["participant", "condition"])[outcome]
    sums = grouped.sum().unstack().reindex(columns=conditions)  # noqa: PD010 - no values to pivot
    counts = grouped.size().unstack(fill_value=0)  # noqa: PD010
    counts = counts.reindex(columns=conditions, fill_value=0)
    needed = [1 if complete is None else complete.get(name, 1) for name in conditions]
    counts = counts[(counts >= needed).all(axis=1)]
    people = sorted(counts.index, key=natural)
    counted = counts.loc[people].to_numpy(dtype=np.int64)
    common = lcm(*map(int, np.unique(counted)))
    found = sums.loc[people].to_numpy(dtype=np.float64).astype(np.int64)
    return people, found * (common // counted), common
