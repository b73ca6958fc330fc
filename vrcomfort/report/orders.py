"""Whether two conditions were met in one order by nearly everybody, so that they are confounded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vrcomfort.records.names import natural
from vrcomfort.stats.proportions import sign_test

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    import pandas as pd

ALPHA = 0.05
FEWEST = 2


@dataclass(frozen=True)
class OneOrder:
    """An order of two conditions that all met, or so many that it is no accident."""

    first: str
    second: str
    people: int
    """How many met `first` before `second`."""
    of: int
    """How many met both."""


def one_order(
    table: pd.DataFrame, a: str, b: str, participants: Collection[str]
) -> OneOrder | None:
    """Return the order in which people met two conditions, if it is one.

    A person met a before b if their first exposure to a was before their first to b. Who met both
    in the same mean place of their exposures (a, b, b, a) is counted for neither order, for a
    drift over time has no part in their difference. It is one order if all met it, or if an exact
    two-sided sign test of those who met either has p below .05.

    Parameters
    ----------
    table
        Scored exposures with participant, session, position (from 1; 0: not known), condition.
    participants
        Who is in the test.
    """
    signs = _first_of(table, a, b, participants)
    test = sign_test(signs)
    people = max(test.positive, test.negative)
    if len(signs) < FEWEST or (people < len(signs) and test.p >= ALPHA):
        return None
    first, second = (a, b) if test.positive > test.negative else (b, a)
    return OneOrder(first, second, people, len(signs))


def _first_of(table: pd.DataFrame, a: str, b: str, participants: Collection[str]) -> list[int]:
    """Return 1 for each person who met a first, −1 for b, 0 for neither; who met both alone."""
    part = table[table["participant"].isin(participants) & (table["position"] > 0)]
    part = part.sort_values(
        ["session", "position"],
        key=lambda column: column.map(natural) if column.name == "session" else column,
    )
    part = part.assign(place=part.groupby("participant").cumcount())
    part = part[part["condition"].isin([a, b])]
    places = part.groupby(["participant", "condition"])["place"].agg(["min", "mean"]).unstack()  # noqa: PD010
    if not {a, b} <= set(part["condition"]):
        return []
    places = places.dropna()
    ahead = (places["min", a] < places["min", b]) * 2 - 1
    return list(ahead.where(places["mean", a] != places["mean", b], 0).astype(int))


def in_words(order: OneOrder, name: Callable[[str], str]) -> str:
    """Say that the order of two conditions may be their difference; `name` returns their labels."""
    people, of = order.people, order.of
    first, second = name(order.first), name(order.second)
    if people < of:
        return (
            f"{people} of {of} participants met {first} before {second}, so that their difference "
            "may partly be one of order"
        )
    all_of_them = "both" if of == FEWEST else f"all {of}"
    return (
        f"{all_of_them} participants met {first} before {second}, so that their difference cannot "
        "be told from one of order"
    )
