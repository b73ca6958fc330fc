"""The order that people really met, whatever was planned: positions, carry-over, sequences."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from vrcomfort.records.names import natural

if TYPE_CHECKING:
    from collections.abc import Iterable

    import pandas as pd


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
