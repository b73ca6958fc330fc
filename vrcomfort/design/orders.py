"""Orders of conditions: squares, block randomisation, and the orders of parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, Trial
from vrcomfort.protocol import Sequence as TrialSequence
from vrcomfort.protocol.model import part_trials
from vrcomfort.protocol.order import Group, Part, PartOrder, orders_of

_DESIGN_STREAM = 1  # first spawn key of every random choice made here
# The second: one for each kind of choice. Orders of participants to come are drawn from them, so
# another number would give a study that is under way other orders than it was planned with.
BLOCKS, MINIMISATION, SIMPLE, LATIN, BLOCK_RANDOM, COVARIATES, PARTS = range(2, 9)


def generator(seed: int, *key: int) -> np.random.Generator:
    """Return the generator of one choice; the same seed and key give the same numbers."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_DESIGN_STREAM, *key)))


def latin_square(n: int, rng: np.random.Generator) -> list[list[int]]:
    """Return n orders of 0 … n−1 in which each stands once at each position.

    The cyclic square with its rows, columns and symbols in random order: what follows what is left
    to chance. `williams` balances that, too.
    """
    rows, columns, symbols = (rng.permutation(n) for _ in range(3))
    return [[int(symbols[(row + column) % n]) for column in columns] for row in rows]


def williams(n: int) -> list[list[int]]:
    """Return a Latin square of 0 … n−1 in which every ordered pair follows equally often.

    For even `n` the square has n rows; for odd `n` it takes 2n: the square and its mirror image.

    Notes
    -----
    Williams, E. J. (1949). Experimental designs balanced for the estimation of residual effects
    of treatments. Australian Journal of Scientific Research A 2, 149-168.
    """
    # The first row zigzags, 0, 1, n−1, 2, n−2, …: all differences of neighbours are distinct.
    zigzag = [(index + 1) // 2 if index % 2 else (n - index // 2) % n for index in range(n)]
    square = [[(entry + row) % n for entry in zigzag] for row in range(n)]
    return square if n % 2 == 0 or n == 1 else square + [row[::-1] for row in square]


def all_orders(n: int) -> list[list[int]]:
    """Return every order of 0 … n−1 once."""
    return [list(order) for order in permutations(range(n))]


# A search that went wrong early would go through millions of orders: begin again instead.
TRIES = 50
STEPS = 4_000
"""Of one try, after which another begins: limits that can be kept are kept long before."""


@dataclass(frozen=True)
class OrderConstraints:
    """Constraints on a random order.

    Parameters
    ----------
    levels
        Factor → the level of each item.
    max_run
        Factor → how many items in a row may have the same level.
    strata
        Factor of which every round of a block has each level once, or None.
    """

    levels: Mapping[str, Sequence[str]]
    max_run: Mapping[str, int]
    strata: str | None = None


def block_random(
    items: int, blocks: int, limits: OrderConstraints, rng: np.random.Generator
) -> list[list[int]]:
    """Return blocks, each a random order of 0 … items−1, that keep the limits across all of them.

    Items are drawn one by one among those that may come next; where nothing may, what was drawn
    last is taken back.

    Raises
    ------
    InputError
        If no order was found that keeps the limits.
    """
    for _ in range(TRIES):
        order = _Search(items, blocks, limits, rng).find()
        if order is not None:
            return [order[start : start + items] for start in range(0, items * blocks, items)]
    said = ", ".join(f"{name} = {most}" for name, most in limits.max_run.items())
    raise InputError(
        f"no order of {items * blocks} trials was found that keeps max_run ({said}); allow longer "
        "runs, or show the trials in another rule's order"
    )


class _Search:
    def __init__(
        self, items: int, blocks: int, limits: OrderConstraints, rng: np.random.Generator
    ) -> None:
        self._items, self._length, self._rng = items, items * blocks, rng
        self._max_run = [(limits.levels[name], most) for name, most in limits.max_run.items()]
        self._strata = limits.levels[limits.strata] if limits.strata else None
        self._round = len(set(self._strata)) if self._strata else 1
        self._order: list[int] = []

    def find(self) -> list[int] | None:
        """Return an order that keeps the limits, None where too many steps did not find one."""
        choices = [self._next()]
        for _ in range(STEPS + self._length):
            if len(self._order) == self._length:
                return self._order
            if choices[-1]:
                self._order.append(choices[-1].pop())
                choices.append(self._next())
            elif len(choices) == 1:
                return None
            else:
                choices.pop()
                self._order.pop()
        return self._order if len(self._order) == self._length else None

    def _next(self) -> list[int]:
        """Return the items that may come next, in random order."""
        there = len(self._order)
        in_block = self._order[there - there % self._items :]
        left = set(range(self._items)) - set(in_block)
        if self._strata is not None:
            in_round = in_block[len(in_block) - len(in_block) % self._round :]
            shown = {self._strata[item] for item in in_round}
            left = {item for item in left if self._strata[item] not in shown}
        # Sorted: a set has no order of its own, and the same seed must draw the same item.
        allowed = [item for item in sorted(left) if not self._runs_on(item)]
        return [int(item) for item in self._rng.permutation(np.array(allowed, dtype=int))]

    def _runs_on(self, item: int) -> bool:
        for levels, most in self._max_run:
            before = self._order[-most:]
            if len(before) == most and all(levels[each] == levels[item] for each in before):
                return True
        return False


Rule = Callable[[int, int, int], list[list[int]]]
"""Takes a number of trials, the seed and the part's number; returns orders of indices."""


@dataclass(frozen=True)
class CombinedOrders:
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
                rng = generator(seed, PARTS, self.first + number, fewest)
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
) -> tuple[tuple[TrialSequence, ...], CombinedOrders]:
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
        name = CombinedOrders.name(whose, key)
        names[name] = key
        sequences.append(
            TrialSequence(name=name, group=whose or None, sessions=tuple(map(tuple, sessions)))
        )
    pools = tuple(tuple(order.name for order in each) for each in orders)
    return tuple(sequences), CombinedOrders(pools, names, whose, first)


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
