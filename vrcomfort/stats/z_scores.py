"""Scores standardised within each person (Mantiuk et al. 2011, Figure 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


class ZScore(NamedTuple):
    """Mean of a condition's z scores.

    Parameters
    ----------
    standard_error
        Of all values, as Mantiuk et al. print it: a person's values count as independent. None of
        a single value.
    n, people
        How many values, and of how many people.
    standard_error_of_people
        Of the people's means; None of a single person.
    """

    mean: float
    standard_error: float | None
    n: int
    people: int
    standard_error_of_people: float | None


def z_scored(
    people: Sequence[str], conditions: Sequence[str], values: Sequence[float]
) -> dict[str, ZScore]:
    """Return condition → mean and standard errors of values standardised within each person.

    Every value minus its person's mean, over that person's standard deviation (n − 1). Who has one
    value, or always the same, has no z score and is left out.
    """
    whose, shown = np.asarray(people), np.asarray(conditions)
    z = _standardised(whose, np.asarray(values, dtype=np.float64))
    found = {}
    for condition in dict.fromkeys(conditions):
        there = (shown == condition) & np.isfinite(z)
        if there.any():
            own = [z[there & (whose == person)].mean() for person in np.unique(whose[there])]
            found[condition] = ZScore(
                float(z[there].mean()), _error(z[there]), int(there.sum()), len(own),
                _error(np.array(own)),
            )  # fmt: skip
    return found


def _standardised(whose: NDArray[np.str_], values: Floats) -> Floats:
    z = np.full(values.shape, np.nan)
    for person in np.unique(whose):
        mine = whose == person
        if mine.sum() > 1 and np.ptp(values[mine]) > 0:
            z[mine] = (values[mine] - values[mine].mean()) / values[mine].std(ddof=1)
    return z


def _error(values: Floats) -> float | None:
    return float(values.std(ddof=1) / np.sqrt(values.size)) if values.size > 1 else None
