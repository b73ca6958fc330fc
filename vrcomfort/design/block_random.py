"""A random order in blocks, with limits on what may follow what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vrcomfort.errors import InputError

TRIES = 50
STEPS = 4_000
"""Of one try, after which another begins: limits that can be kept are kept long before."""


@dataclass(frozen=True)
class Limits:
    """What an order must keep.

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
    items: int, blocks: int, limits: Limits, rng: np.random.Generator
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
    def __init__(self, items: int, blocks: int, limits: Limits, rng: np.random.Generator) -> None:
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
        """Return what may come next, in random order."""
        there = len(self._order)
        in_block = self._order[there - there % self._items :]
        left = set(range(self._items)) - set(in_block)
        if self._strata is not None:
            in_round = in_block[len(in_block) - len(in_block) % self._round :]
            shown = {self._strata[item] for item in in_round}
            left = {item for item in left if self._strata[item] not in shown}
        allowed = [item for item in sorted(left) if not self._runs_on(item)]
        return [int(item) for item in self._rng.permutation(np.array(allowed, dtype=int))]

    def _runs_on(self, item: int) -> bool:
        for levels, most in self._max_run:
            before = self._order[-most:]
            if len(before) == most and all(levels[each] == levels[item] for each in before):
                return True
        return False
