"""The order that people really met, whatever was planned: positions, carry-over, sequences.

Also whether nearly everybody met two conditions in one order, so that they are confounded.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from vrcomfort.records.names import natural
from vrcomfort.stats.proportions import sign_test

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable

    import pandas as pd

ALPHA = 0.05
# A single participant always has one order.
FEWEST = 2


@dataclass(frozen=True)
class CarryOver:
    """How often a condition was met right before another one."""

    before: str
    after: str
    n: int


@dataclass(frozen=True)
class OrderMet:
    """The conditions of each session in their order, and how many people met them so."""

    sessions: tuple[tuple[str, ...], ...]
    n: int


@dataclass(frozen=True)
class Counterbalancing:
    """The orders that were met.

    Parameters
    ----------
    positions
        Condition → count at each place of a session (of the study, if a session has one exposure).
    carry_over
        Within sessions.
    balanced
        Whether every condition stands equally often in every position.
    """

    positions: dict[str, list[int]]
    carry_over: tuple[CarryOver, ...]
    orders: tuple[OrderMet, ...]
    balanced: bool


def counterbalancing(
    table: pd.DataFrame, conditions: Iterable[str], analysed: Iterable[str]
) -> Counterbalancing | None:
    """Count positions and carry-over over the scored exposures of those analysed.

    None where the data do not say the order, or have no conditions.
    """
    part = table[table["participant"].isin(list(analysed)) & (table["position"] > 0)]
    names = [name for name in conditions if (part["condition"] == name).any()]
    if not names:
        return None
    runs = _runs(part)
    longest = max(len(run) for _, run in runs)
    places = Counter((name, place) for _, run in runs for place, name in enumerate(run))
    positions = {name: [places[name, place] for place in range(longest)] for name in names}
    carried = Counter(pair for _, run in runs for pair in pairwise(run))
    pairs = [(a, b) for a in names for b in names] if carried else []
    return Counterbalancing(
        positions,
        tuple(CarryOver(a, b, carried[a, b]) for a, b in pairs),
        _orders(runs),
        all(len(set(column)) == 1 for column in zip(*positions.values(), strict=True)),
    )


def _runs(part: pd.DataFrame) -> list[tuple[str, list[str]]]:
    """Return (participant, conditions in order) of each session, or of each person."""
    alone = not part.duplicated(["participant", "session"]).any()
    found: dict[tuple[str, ...], list[tuple[int, str]]] = defaultdict(list)
    columns = ["participant", "session", "position", "condition"]
    for who, session, position, condition in part[columns].itertuples(index=False):
        found[(who,) if alone else (who, session)].append((position, condition))
    ordered = sorted(found, key=lambda key: tuple(map(natural, key)))
    return [(key[0], [name for _, name in sorted(found[key])]) for key in ordered]


def _orders(runs: list[tuple[str, list[str]]]) -> tuple[OrderMet, ...]:
    met: dict[str, list[list[str]]] = defaultdict(list)
    for who, run in runs:
        met[who].append(run)
    counts = Counter(tuple(map(tuple, sessions)) for sessions in met.values())
    listed = sorted(counts.items(), key=lambda each: (-each[1], each[0]))
    return tuple(OrderMet(order, n) for order, n in listed)


@dataclass(frozen=True)
class OneOrder:
    """An order of two conditions for all participants, or for too many to be chance."""

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
    """Return 1 for each participant with a first, −1 with b, 0 for neither; of those with both."""
    met, people = defaultdict(list), {*participants}
    columns = ("session", "position", "participant", "condition")
    cells = zip(*(table[name] for name in columns), strict=True)
    rows = [row for row in cells if row[1] > 0 and row[2] in people]
    for *_, who, condition in sorted(rows, key=lambda row: (natural(row[0]), row[1])):
        met[who].append(condition)
    found = []
    for run in met.values():
        one, two = ([place for place, name in enumerate(run) if name == each] for each in (a, b))
        if one and two:
            even = sum(one) * len(two) == sum(two) * len(one)
            found.append(0 if even else 1 if one[0] < two[0] else -1)
    return found


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
