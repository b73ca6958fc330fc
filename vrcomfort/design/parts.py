"""Orders of parts: every combination is a sequence, and each part's orders are dealt alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product

from vrcomfort.design.random_numbers import generator
from vrcomfort.protocol import Protocol, Trial
from vrcomfort.protocol import Sequence as TrialSequence
from vrcomfort.protocol.levels import part_trials
from vrcomfort.protocol.order import Group, Part, PartOrder, orders_of

_PARTS = 8

Rule = Callable[[int, int, int], list[list[int]]]
"""Takes a number of trials, the seed and the part's number; returns orders of indices."""


@dataclass(frozen=True)
class Combined:
    """The sequences of a study in parts.

    Parameters
    ----------
    pools
        Names of the orders of each part.
    orders
        Sequence → the name of its order in each part.
    group
        Whose they are; blank without groups.
    first
        Number of the first part among all that random numbers are drawn for.
    """

    pools: tuple[tuple[str, ...], ...]
    orders: dict[str, tuple[str, ...]]
    group: str = ""
    first: int = 0

    def filled(self, sequences: Iterable[str]) -> list[dict[str, int]]:
        """Return, for each part, how many of these sequences have each of its orders.

        Those of other groups do not count.
        """
        counts = [dict.fromkeys(pool, 0) for pool in self.pools]
        for name in sequences:
            for count, order in zip(counts, self.orders.get(name, ()), strict=False):
                count[order] += 1
        return counts

    def next(self, sequences: Iterable[str], *, seed: int, shuffled: bool) -> str:
        """Return the sequence of the next participant: of each part an order that fewest have."""
        wanted = []
        for number, count in enumerate(self.filled(sequences)):
            fewest, names = min(count.values()), list(count)
            if shuffled:
                rng = generator(seed, _PARTS, self.first + number, fewest)
                places = rng.permutation(len(names))
                names = [names[place] for place in places]
            wanted.append(next(name for name in names if count[name] == fewest))
        return self.name(self.group, wanted)

    def even(self, sequences: Iterable[str]) -> bool:
        """Return whether each part has all of its orders equally often."""
        return all(len(set(count.values())) == 1 for count in self.filled(sequences))

    @staticmethod
    def name(group: str, orders: Iterable[str]) -> str:
        """Return the name of a combination of orders."""
        return "-".join((group, *orders) if group else orders)


def combined(
    protocol: Protocol, seed: int, rules: dict[str, Rule], group: Group | None = None
) -> tuple[tuple[TrialSequence, ...], Combined]:
    """Return every combination of the orders that a group has of the parts, and how they are dealt.

    Without groups, `group` is None.
    """
    parts, whose = protocol.parts, group.name if group else ""
    first = len(parts) * protocol.groups.index(group) if group else 0
    orders = [
        _orders(protocol, part, n, seed, rules, group) for n, part in enumerate(parts, start=first)
    ]
    sequences, names = [], {}
    for chosen in product(*orders):
        sessions: list[list[Trial]] = [[] for _ in range(max(part.session for part in parts))]
        for part, order in zip(parts, chosen, strict=True):
            named = [trial.model_copy(update={"part": part.name}) for trial in order.trials]
            sessions[part.session - 1] += named * part.repeats
        key = tuple(order.name for order in chosen)
        name = Combined.name(whose, key)
        names[name] = key
        sequences.append(
            TrialSequence(name=name, group=whose or None, sessions=tuple(map(tuple, sessions)))
        )
    pools = tuple(tuple(order.name for order in each) for each in orders)
    return tuple(sequences), Combined(pools, names, whose, first)


def _orders(
    protocol: Protocol,
    part: Part,
    number: int,
    seed: int,
    rules: dict[str, Rule],
    group: Group | None,
) -> Sequence[PartOrder]:
    if part.rule == "explicit":
        return orders_of(part, group.name if group else "")
    trials = part_trials(protocol, part, group)
    rows = rules[part.rule](len(trials), seed, number)
    return [
        PartOrder(name=f"{part.name}_{index}", trials=tuple(trials[entry] for entry in row))
        for index, row in enumerate(rows, start=1)
    ]
