"""Pairs of integer scores, one per participant, for two conditions."""

from __future__ import annotations

from dataclasses import dataclass
from math import lcm
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.questionnaire import WEIGHTS
from vrcomfort.report.ordering import natural

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

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


def planned_exposures(table: pd.DataFrame) -> dict[str, int]:
    """Return how many exposures a condition has for those who had the most."""
    counts = table.groupby(["participant", "condition"]).size().groupby("condition").max()
    return {str(name): int(count) for name, count in counts.items()}


def in_a_test(tests: list[dict[str, Any]], condition: str, outcome: str | None = None) -> set[str]:
    """Return who is in any test of a condition (of one outcome), whomever it compares with."""
    return {
        person
        for test in tests
        if condition in (test["a"], test["b"]) and outcome in (None, test["outcome"])
        for person in test["participants"]
    }


def pair_up(
    table: pd.DataFrame, outcome: str, a: str, b: str, *, complete: dict[str, int] | None = None
) -> Pairs:
    """Pair each participant's scores under two conditions.

    Sums of integers stay exact: instead of dividing by the number of exposures, every sum is
    multiplied up to the common multiple of all numbers, and the unit divided by it.

    Parameters
    ----------
    complete
        Exposures per condition that a participant must have; any number will do otherwise.
    """
    grouped = table.groupby(["participant", "condition"])[outcome]
    sums, counts = grouped.sum().to_dict(), grouped.size().to_dict()
    people = sorted(table["participant"].unique(), key=natural)
    needed = [(c, 1 if complete is None else complete.get(c, 1)) for c in (a, b)]
    people = [p for p in people if all(counts.get((p, c), 0) >= n for c, n in needed)]
    common = lcm(*(counts[p, c] for p in people for c in (a, b)))
    scaled = {
        c: np.array([sums[p, c] * (common // counts[p, c]) for p in people], dtype=np.int64)
        for c in (a, b)
    }
    return Pairs(tuple(people), scaled[a], scaled[b], WEIGHTS[outcome] / common)
