"""Allocates participants to groups: permuted blocks, minimisation, or chance alone.

Nothing is stored but groups and covariates: the draw for the next participant derives from the
study's seed and from the enrolled ones.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vrcomfort.design.orders import BLOCKS, MINIMISATION, SIMPLE, generator


@dataclass(frozen=True)
class Person:
    """One participant's group and strata, for allocation.

    Parameters
    ----------
    group
        Blank for a participant who is to get one.
    bands
        Covariate → level or band.
    counts
        Whether they take a place: not those who withdrew, where their places return.
    """

    group: str
    bands: Mapping[str, str]
    counts: bool = True


@dataclass(frozen=True)
class GroupAllocation:
    """The groups of a study and how people come into them.

    Parameters
    ----------
    shares
        Group → how many of them are in each round of a block.
    bands
        Covariate → its levels or bands: strata, or margins.
    """

    method: str
    shares: Mapping[str, int]
    bands: Mapping[str, Sequence[str]]
    rounds: tuple[int, ...]
    p_best: float
    seed: int

    def assign(self, before: Iterable[Person], bands: Mapping[str, str]) -> str:
        """Return the group of the next participant, given all earlier ones."""
        people = list(before)
        if self.method == "permuted_blocks":
            return self._next_in_blocks(people, bands)
        if self.method == "minimisation":
            return self._minimised(people, bands)
        return self._drawn(generator(self.seed, SIMPLE, len(people)), list(self.shares))

    def stratum(self, bands: Mapping[str, str]) -> int:
        """Return the number of a stratum, from 0."""
        number = 0
        for name, levels in self.bands.items():
            number = number * len(levels) + list(levels).index(bands[name])
        return number

    def _next_in_blocks(self, people: list[Person], bands: Mapping[str, str]) -> str:
        """Return the first free place of the stratum's list."""
        stratum = self.stratum(bands)
        filled = Counter(
            each.group for each in people if each.counts and self.stratum(each.bands) == stratum
        )
        for group in self._places(stratum):
            if not filled[group]:
                return group
            filled[group] -= 1
        raise AssertionError("a list of places has no end")  # pragma: no cover

    def _places(self, stratum: int) -> Iterator[str]:
        """Yield the groups of a stratum's places, block after block."""
        # Drawn from the beginning each time, so the list is the same however often it is asked for.
        rng = generator(self.seed, BLOCKS, stratum)
        while True:
            rounds = self.rounds[rng.integers(len(self.rounds))]
            block = [name for name, share in self.shares.items() for _ in range(share * rounds)]
            yield from (block[index] for index in rng.permutation(len(block)))

    def _minimised(self, people: list[Person], bands: Mapping[str, str]) -> str:
        rng = generator(self.seed, MINIMISATION, len(people))
        margins = [
            Counter(p.group for p in people if p.counts and p.bands[name] == bands[name])
            for name in self.bands
        ]
        differences = {
            name: sum(self._difference(margin, name) for margin in margins) for name in self.shares
        }
        least = min(differences.values())
        # Sums of squares of the same counts in another order may differ in their last digit.
        best = [name for name, each in differences.items() if each <= least + 1e-9]
        others = [name for name in self.shares if name not in best]
        take_best = not others or rng.random() < self.p_best
        return self._drawn(rng, best if take_best else others)

    def _difference(self, margin: Counter[str], group: str) -> float:
        """Return how unlike a level's groups would be, were the next one in this group.

        Pocock, S. J. & Simon, R. (1975). Sequential treatment assignment with balancing for
        prognostic factors in the controlled clinical trial. Biometrics 31, 103-115: their variance
        over groups (which, unlike the range, does not let one margin grow while others shrink), of
        people per share, where shares differ.
        """
        filled = [(margin[each] + (each == group)) / share for each, share in self.shares.items()]
        mean = sum(filled) / len(filled)
        return sum((each - mean) ** 2 for each in filled) / len(filled)

    def _drawn(self, rng: np.random.Generator, names: list[str]) -> str:
        weights = np.array([self.shares[name] for name in names], dtype=float)
        return names[int(rng.choice(len(names), p=weights / weights.sum()))]


def margins(
    people: Iterable[Person], groups: GroupAllocation
) -> dict[str, dict[str, dict[str, int]]]:
    """Count the participants that take a place: covariate → level → group → count."""
    counting = [each for each in people if each.counts]
    return {
        name: {
            level: {
                group: sum(each.group == group and each.bands[name] == level for each in counting)
                for group in groups.shares
            }
            for level in levels
        }
        for name, levels in groups.bands.items()
    }
