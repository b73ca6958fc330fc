"""Who meets the trials in which order, and how balanced that is.

A sequence is the whole order of one participant. Participants are assigned to the sequence that
the fewest enrolled or completed participants have, so the place of somebody who withdrew or was
excluded goes to the next who is enrolled.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise, permutations

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, Sequence, Trial

COUNTING_STATUSES = frozenset({"enrolled", "completed"})

_DESIGN_STREAM = 1  # first spawn key of every random choice made here


@dataclass(frozen=True)
class Enrolment:
    """What the assignment needs to know of a participant who is already there."""

    sequence: str
    status: str = "enrolled"


@dataclass(frozen=True)
class Design:
    """The sequences of a study and the rule that hands them out.

    Parameters
    ----------
    sequences
        The pool; empty for rule `random`, where every participant has a sequence of their own.
    trials
        Every condition-scene pair (generated rules).
    """

    rule: str
    assignment: str
    sessions: int
    seed: int
    sequences: tuple[Sequence, ...]
    trials: tuple[Trial, ...] = ()

    def sequence(self, name: str) -> Sequence:
        """Return a sequence by name.

        Raises
        ------
        InputError
            If the design has no such sequence.
        """
        if self.rule == "random" and name[:1] == "r" and name[1:].isdigit():
            return self._random(int(name[1:]))
        for sequence in self.sequences:
            if sequence.name == name:
                return sequence
        raise InputError(f"this protocol has no sequence `{name}`; was the study made with it?")

    def assign(self, enrolments: Iterable[Enrolment]) -> Sequence:
        """Return the sequence of the next participant, given all who were enrolled before."""
        before = list(enrolments)
        if self.rule == "random":
            return self._random(len(before) + 1)
        filled = Counter(each.sequence for each in before if each.status in COUNTING_STATUSES)
        fewest = min(filled[sequence.name] for sequence in self.sequences)
        order = self._round(fewest)
        return next(each for each in order if filled[each.name] == fewest)

    def plan(self, participants: int) -> list[Sequence]:
        """Return the sequences of the first `participants` people if nobody withdraws."""
        plan: list[Sequence] = []
        for _ in range(participants):
            plan.append(self.assign(Enrolment(sequence.name) for sequence in plan))
        return plan

    def _round(self, number: int) -> list[Sequence]:
        """Return the order in which equally filled sequences are taken."""
        if self.assignment == "in_turn":
            return list(self.sequences)
        order = _generator(self.seed, number).permutation(len(self.sequences))
        return [self.sequences[index] for index in order]

    def _random(self, number: int) -> Sequence:
        order = _generator(self.seed, number).permutation(len(self.trials))
        return _deal(f"r{number}", [self.trials[index] for index in order], self.sessions)


def build_design(protocol: Protocol, *, seed: int = 0) -> Design:
    """Return the design that a protocol's [order] table describes."""
    order = protocol.order
    trials = tuple(
        Trial(scene=scene, condition=condition.name)
        for condition in protocol.conditions
        for scene in protocol.scenes
    )
    if order.rule == "explicit":
        sequences, trials = order.sequences, ()
    else:
        rows = _RULES[order.rule](len(trials))
        sequences = tuple(
            _deal(f"s{index + 1}", [trials[entry] for entry in row], order.sessions)
            for index, row in enumerate(rows)
        )
    sessions = len(sequences[0].sessions) if sequences else order.sessions
    return Design(order.rule, order.assignment, sessions, seed, sequences, trials)


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


def _every_order(n: int) -> list[list[int]]:
    return [list(order) for order in permutations(range(n))]


_RULES: dict[str, Callable[[int], list[list[int]]]] = {
    "williams": williams,
    "full": _every_order,
    "random": lambda _: [],
}


def _generator(seed: int, number: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_DESIGN_STREAM, number)))


def _deal(name: str, trials: list[Trial], sessions: int) -> Sequence:
    size = len(trials) // sessions
    dealt = tuple(tuple(trials[start : start + size]) for start in range(0, len(trials), size))
    return Sequence(name=name, sessions=dealt)


@dataclass(frozen=True)
class FactorAudit:
    """How often each level of a factor stood where.

    Parameters
    ----------
    positions
        level → count at each position of a session, first position first.
    first
        level → number of participants whose first exposure of the study had it.
    carry_over
        (level before, level after) → count, within sessions.
    """

    positions: dict[str, tuple[int, ...]]
    first: dict[str, int]
    carry_over: dict[tuple[str, str], int]


@dataclass(frozen=True)
class Audit:
    """The balance of a list of sequences, planned or actually run.

    Parameters
    ----------
    sequences
        sequence name → participants.
    crossing
        (condition, scene) of the first exposure → participants.
    remainder
        One sentence: what happens when the number of participants does not divide.
    """

    participants: int
    sequences: dict[str, int]
    conditions: FactorAudit
    scenes: FactorAudit
    treatments: FactorAudit
    crossing: dict[tuple[str, str], int]
    remainder: str


def audit(design: Design, plan: list[Sequence]) -> Audit:
    """Count positions, first exposures, carry-over and crossing over a list of sequences."""
    names = [sequence.name for sequence in design.sequences] or [each.name for each in plan]
    used = Counter(sequence.name for sequence in plan)
    first = Counter((sequence.trials[0].condition, sequence.trials[0].scene) for sequence in plan)
    pool = list(design.sequences) or plan
    return Audit(
        participants=len(plan),
        sequences={name: used[name] for name in names},
        conditions=_audit_factor(plan, pool, lambda trial: trial.condition),
        scenes=_audit_factor(plan, pool, lambda trial: trial.scene),
        treatments=_audit_factor(plan, pool, lambda trial: f"{trial.condition} in {trial.scene}"),
        crossing=dict(sorted(first.items())),
        remainder=_remainder(design, used, len(plan)),
    )


def _audit_factor(
    plan: list[Sequence], pool: list[Sequence], level: Callable[[Trial], str]
) -> FactorAudit:
    levels = sorted({level(trial) for sequence in pool for trial in sequence.trials})
    sessions = [[level(trial) for trial in session] for each in plan for session in each.sessions]
    longest = max((len(session) for each in pool for session in each.sessions), default=0)
    places = Counter((name, place) for session in sessions for place, name in enumerate(session))
    first = Counter(level(sequence.trials[0]) for sequence in plan)
    return FactorAudit(
        positions={name: tuple(places[name, place] for place in range(longest)) for name in levels},
        first={name: first[name] for name in levels},
        carry_over=dict(Counter(pair for session in sessions for pair in pairwise(session))),
    )


def _remainder(design: Design, used: Counter[str], participants: int) -> str:
    pool = len(design.sequences)
    if not pool:
        return "Each participant has a random order of their own, so no number has to divide."
    each, left = divmod(participants, pool)
    if not left:
        return f"{participants} participants divide evenly: {each} for each of {pool} sequences."
    lacking = "participant" if pool - left == 1 else "participants"
    more = [sequence.name for sequence in design.sequences if used[sequence.name] > each]
    return (
        f"{participants} participants do not divide by {pool} sequences: each has {each}, "
        f"{_some(more)} one more, and {pool - left} further {lacking} would balance them."
    )


def _some(names: list[str], shown: int = 6) -> str:
    verb = "has" if len(names) == 1 else "have"
    if len(names) > shown:
        return f"{len(names)} of them {verb}"
    return f"{' and '.join([', '.join(names[:-1]), names[-1]] if names[1:] else names)} {verb}"
