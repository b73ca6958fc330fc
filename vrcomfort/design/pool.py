"""The sequences of a study and the rules that hand them out.

A sequence is the whole order of one participant. Participants are assigned to the sequence of
their group that the fewest enrolled or completed participants have, so the place of a participant
who withdrew or was excluded goes to the next who is enrolled, unless the protocol keeps it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from math import ceil, floor

import numpy as np

from vrcomfort.design.groups import GroupAllocation, Person
from vrcomfort.design.orders import (
    BLOCK_RANDOM,
    COVARIATES,
    LATIN,
    CombinedOrders,
    OrderConstraints,
    all_orders,
    block_random,
    combined,
    generator,
    latin_square,
    williams,
)
from vrcomfort.errors import InputError
from vrcomfort.protocol import Allocation, Covariate, Protocol, Sequence, Trial
from vrcomfort.protocol.model import factor_names, level_of, trials_of
from vrcomfort.settings import did_you_mean

COUNTING_STATUSES = frozenset({"enrolled", "completed"})


@dataclass(frozen=True)
class Enrolment:
    """An enrolled participant's sequence, status and covariates, for the assignment."""

    sequence: str
    status: str = "enrolled"
    covariates: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class IndividualOrders:
    """Individual randomisation: an order for each participant, by `random` or `block_random`."""

    trials: tuple[Trial, ...]
    blocks: int
    limits: OrderConstraints | None


@dataclass(frozen=True)
class Design:
    """The sequences of a study and the rules that hand them out.

    Parameters
    ----------
    sequences
        The pool; empty where every participant has an order of their own.
    own_orders
        Group ("" without groups) → what is ordered for each of its participants.
    groups, covariates
        How people come into groups; None without groups.
    parts
        Group ("" without groups) → how the orders of its parts are dealt; empty without parts.
    return_places
        Whether those who withdrew or were excluded leave their places to others.
    """

    rule: str
    assignment: str
    sessions: int
    seed: int
    sequences: tuple[Sequence, ...]
    own_orders: Mapping[str, IndividualOrders] = field(default_factory=dict)
    groups: GroupAllocation | None = None
    covariates: tuple[Covariate, ...] = ()
    return_places: bool = True
    parts: Mapping[str, CombinedOrders] = field(default_factory=dict)

    def sequence(self, name: str) -> Sequence:
        """Return a sequence by name.

        Raises
        ------
        InputError
            If the design has no such sequence.
        """
        group, _, last = name.rpartition("-")
        if group in self.own_orders and last[:1] == "r" and last[1:].isdecimal():
            return self._own_order(group, int(last[1:]))
        for sequence in self.sequences:
            if sequence.name == name:
                return sequence
        raise InputError(f"this protocol has no sequence `{name}`; was the study made with it?")

    def assign(
        self, enrolments: Iterable[Enrolment], covariates: Mapping[str, str] | None = None
    ) -> Sequence:
        """Return the sequence of the next participant, given all earlier ones.

        Parameters
        ----------
        covariates
            The next one's; those that groups are divided by must be there.
        """
        before = list(enrolments)
        group = self._group(before, covariates or {})
        if group in self.own_orders:
            return self._own_order(group, len(before) + 1)
        if group in self.parts:
            taken = [each.sequence for each in before if self.counts(each)]
            shuffled = self.assignment == "shuffled"
            return self.sequence(self.parts[group].next(taken, seed=self.seed, shuffled=shuffled))
        pool = [each for each in self.sequences if (each.group or "") == group]
        filled = Counter(each.sequence for each in before if self.counts(each))
        fewest = min(filled[sequence.name] for sequence in pool)
        order = self._round(pool, fewest)
        return next(each for each in order if filled[each.name] == fewest)

    def plan(
        self, participants: int, *, covariates: Iterable[Mapping[str, str]] | None = None
    ) -> list[Sequence]:
        """Return the sequences of the first participants, without withdrawals.

        Parameters
        ----------
        covariates
            Of each; without it, they are drawn with the study's seed (`simulated_covariates`).
        """
        return self.continued([], participants, covariates=covariates)

    def continued(
        self,
        enrolments: Iterable[Enrolment],
        participants: int,
        *,
        covariates: Iterable[Mapping[str, str]] | None = None,
    ) -> list[Sequence]:
        """Return the sequences of the next participants after the enrolled ones."""
        before = list(enrolments)
        people = iter(covariates) if covariates is not None else None
        plan: list[Sequence] = []
        for _ in range(participants):
            known = next(people) if people else self.simulated_covariates(len(before) + 1)
            plan.append(self.assign(before, known))
            before.append(Enrolment(plan[-1].name, covariates=known))
        return plan

    def checked(self, covariates: Mapping[str, str]) -> dict[str, str]:
        """Return covariates, in the protocol's order.

        Raises
        ------
        InputError
            If one is missing, unknown or impossible.
        """
        declared = {each.name: each for each in self.covariates}
        for name in covariates:
            if name not in declared:
                hint = did_you_mean(name, declared)
                raise InputError(f"this protocol has no covariate `{name}`; {hint}")
        for name, each in declared.items():
            if name not in covariates:
                choice = "|".join(each.levels) or "NUMBER"
                message = f"every participant needs the covariate `{name}`"
                raise InputError(f"{message}; add --covariate {name}={choice}")
            if (fault := each.fault(covariates[name])) is not None:
                raise InputError(f"covariate `{name}` {fault}, got `{covariates[name]}`")
        return {name: covariates[name] for name in declared}

    def simulated_covariates(self, number: int) -> dict[str, str]:
        """Return simulated covariates: levels, and whole numbers, with equal probability."""
        return {
            each.name: _simulated(each, generator(self.seed, COVARIATES, number, index))
            for index, each in enumerate(self.covariates)
        }

    def people(self, enrolments: Iterable[Enrolment]) -> list[Person]:
        """Return enrolled participants with their strata, for allocation."""
        return [self._person(each) for each in enrolments]

    def counts(self, each: Enrolment) -> bool:
        """Return whether a participant takes a place."""
        return not self.return_places or each.status in COUNTING_STATUSES

    def group_of(self, sequence: str) -> str:
        """Return the group of a sequence; blank without groups."""
        group = sequence.rpartition("-")[0]
        return group if group in self.own_orders else self.sequence(sequence).group or ""

    def _group(self, before: list[Enrolment], covariates: Mapping[str, str]) -> str:
        if self.groups is None:
            return ""
        return self.groups.assign(self.people(before), self._bands(covariates))

    def _person(self, each: Enrolment) -> Person:
        group = self.group_of(each.sequence)
        if self.groups and self.groups.bands and each.status == "erased":
            return Person(group, {}, counts=False)  # of whom nothing is known that divides groups
        bands = self._bands(each.covariates) if self.groups else {}
        return Person(group, bands, self.counts(each))

    def _bands(self, covariates: Mapping[str, str]) -> dict[str, str]:
        wanted = self.groups.bands if self.groups else {}
        known = {each.name: each for each in self.covariates}
        missing = [name for name in wanted if name not in covariates]
        if missing:
            raise InputError(
                f"groups are divided by {missing[0]}, which is not known of every participant"
            )
        return {name: known[name].band(covariates[name]) for name in wanted}

    def _round(self, pool: list[Sequence], number: int) -> list[Sequence]:
        """Return the order in which equally filled sequences are taken."""
        if self.assignment == "in_turn":
            return pool
        order = generator(self.seed, number).permutation(len(pool))
        return [pool[index] for index in order]

    def _own_order(self, group: str, number: int) -> Sequence:
        own = self.own_orders[group]
        if own.limits is None:
            order = [int(i) for i in generator(self.seed, number).permutation(len(own.trials))]
        else:
            rng = generator(self.seed, BLOCK_RANDOM, number)
            blocks = block_random(len(own.trials), own.blocks, own.limits, rng)
            order = [index for block in blocks for index in block]
        name = f"{group}-r{number}" if group else f"r{number}"
        return _deal(name, group, [own.trials[index] for index in order], self.sessions)


def _simulated(covariate: Covariate, rng: np.random.Generator) -> str:
    if covariate.levels:
        return covariate.levels[rng.integers(len(covariate.levels))]
    least, most = ceil(covariate.low), floor(covariate.high)
    if least <= most:
        return str(rng.integers(least, most, endpoint=True))
    return f"{rng.uniform(covariate.low, covariate.high):.6g}"


def build_design(protocol: Protocol, *, seed: int = 0) -> Design:
    """Return the design that a protocol's [order], [[groups]] and [allocation] tables describe.

    Raises
    ------
    InputError
        If no random order keeps the limits of `max_run`.
    """
    order = protocol.order
    sequences: tuple[Sequence, ...] = ()
    own: dict[str, IndividualOrders] = {}
    parts: dict[str, CombinedOrders] = {}
    for number, group in enumerate(protocol.groups or (None,)):
        name, trials = group.name if group else "", trials_of(protocol, group)
        if order.rule == "parts":
            made, parts[name] = combined(protocol, seed, _RULES, group)
            sequences += made
        elif order.rule == "random":
            own[name] = IndividualOrders(trials, 1, None)
        elif order.rule == "block_random":
            own[name] = IndividualOrders(trials, order.blocks, _limits(protocol, trials))
        elif order.rule in _RULES:
            rows = _RULES[order.rule](len(trials), seed, number)
            sequences += tuple(_rows(name, trials, rows, order.sessions))
    sequences = order.sequences or sequences
    return Design(
        rule=order.rule,
        assignment=order.assignment,
        sessions=len(sequences[0].sessions) if sequences else order.sessions,
        seed=seed,
        sequences=sequences,
        own_orders=own,
        groups=_groups(protocol, seed) if protocol.groups else None,
        covariates=protocol.covariates,
        return_places=order.return_places,
        parts=parts,
    )


_RULES: dict[str, Callable[[int, int, int], list[list[int]]]] = {
    "latin_square": lambda n, seed, group: latin_square(n, generator(seed, LATIN, group)),
    "williams": lambda n, _seed, _group: williams(n),
    "all_orders": lambda n, _seed, _group: all_orders(n),
}


def _rows(
    group: str, trials: tuple[Trial, ...], rows: list[list[int]], sessions: int
) -> Iterable[Sequence]:
    for index, row in enumerate(rows, start=1):
        name = f"{group}-s{index}" if group else f"s{index}"
        yield _deal(name, group, [trials[entry] for entry in row], sessions)


def _deal(name: str, group: str, trials: list[Trial], sessions: int) -> Sequence:
    """Divide trials into sessions; the first ones have one more where they do not divide evenly."""
    size, more = divmod(len(trials), sessions)
    ends = [size * each + min(each, more) for each in range(sessions + 1)]
    dealt = tuple(tuple(trials[start:end]) for start, end in pairwise(ends))
    return Sequence(name=name, group=group or None, sessions=dealt)


def _limits(protocol: Protocol, trials: tuple[Trial, ...]) -> OrderConstraints:
    order = protocol.order
    words = ["trial", "condition", "scene", *factor_names(protocol)]
    levels = {word: [level_of(protocol, trial, word) for trial in trials] for word in words}
    alone = {} if len(trials) == 1 else {"trial": 1}
    return OrderConstraints(levels, {**alone, **order.max_run}, order.strata)


def _groups(protocol: Protocol, seed: int) -> GroupAllocation:
    allocation = protocol.allocation or Allocation()
    covariates = {each.name: each for each in protocol.covariates}
    return GroupAllocation(
        method=allocation.method,
        shares={group.name: group.share for group in protocol.groups},
        bands={name: covariates[name].bands for name in allocation.by},
        rounds=allocation.rounds,
        p_best=allocation.p_best,
        seed=seed,
    )
