"""Audits counterbalancing, of a design and of a study as it was run.

It also tells which numbers of participants a design can balance.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import lcm

from vrcomfort.design.groups import margins
from vrcomfort.design.orders import CombinedOrders
from vrcomfort.design.pool import COUNTING_STATUSES, Design, Enrolment
from vrcomfort.plurals import counted, counted_doing
from vrcomfort.protocol import Sequence, Trial


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

    @property
    def even_positions(self) -> bool:
        """Return whether every level stood equally often at each position."""
        return all(len(set(column)) == 1 for column in zip(*self.positions.values(), strict=True))

    @property
    def even_carry_over(self) -> bool:
        """Return whether every level followed every other equally often."""
        levels = list(self.positions)
        pairs = {(a, b) for a in levels for b in levels if a != b}
        return len({self.carry_over.get(pair, 0) for pair in pairs}) <= 1


@dataclass(frozen=True)
class Audit:
    """The balance of a list of sequences, planned or actually run.

    Parameters
    ----------
    sequences
        sequence name → participants.
    crossing
        (condition, scene) of the first exposure → participants.
    groups
        group → participants; empty without groups.
    remainder
        One sentence: what happens when the number of participants does not divide.
    """

    participants: int
    sequences: dict[str, int]
    conditions: FactorAudit
    scenes: FactorAudit
    treatments: FactorAudit
    crossing: dict[tuple[str, str], int]
    groups: dict[str, int]
    remainder: str


def audit(design: Design, plan: list[Sequence]) -> Audit:
    """Count positions, first exposures, carry-over and crossing over a list of sequences."""
    names = [sequence.name for sequence in design.sequences] or [each.name for each in plan]
    used = Counter(sequence.name for sequence in plan)
    begun = [sequence.trials[0] for sequence in plan if sequence.trials]
    first = Counter((trial.condition, trial.scene) for trial in begun)
    pool = list(design.sequences) or plan
    shares = design.groups.shares if design.groups else {}
    in_group = Counter(sequence.group for sequence in plan)
    return Audit(
        participants=len(plan),
        sequences={name: used[name] for name in names},
        conditions=_audit_factor(plan, pool, lambda trial: trial.condition),
        scenes=_audit_factor(plan, pool, lambda trial: trial.scene),
        treatments=_audit_factor(plan, pool, lambda trial: f"{trial.condition} in {trial.scene}"),
        crossing=dict(sorted(first.items())),
        groups={name: in_group[name] for name in shares},
        remainder=_remainder(design, used, len(plan)),
    )


def _audit_factor(
    plan: list[Sequence], pool: list[Sequence], level: Callable[[Trial], str]
) -> FactorAudit:
    levels = sorted({level(trial) for sequence in pool for trial in sequence.trials})
    sessions = [[level(trial) for trial in session] for each in plan for session in each.sessions]
    longest = max((len(session) for each in pool for session in each.sessions), default=0)
    places = Counter((name, place) for session in sessions for place, name in enumerate(session))
    first = Counter(level(sequence.trials[0]) for sequence in plan if sequence.trials)
    return FactorAudit(
        positions={name: tuple(places[name, place] for place in range(longest)) for name in levels},
        first={name: first[name] for name in levels},
        carry_over=dict(Counter(pair for session in sessions for pair in pairwise(session))),
    )


def _remainder(design: Design, used: Counter[str], participants: int) -> str:
    pool = len(design.sequences)
    if design.parts:
        names = list(used.elements())
        return " ".join(_of_parts(each, names) for each in design.parts.values())
    if not pool:
        return "Each participant has a random order of their own, so no number has to divide."
    each, left = divmod(participants, pool)
    if {used[sequence.name] for sequence in design.sequences} == {each}:
        divide = counted_doing(participants, "participants", "divide")
        return f"{divide} evenly: {each} for each of {counted(pool, 'sequences')}."
    if not left:
        return (
            f"{participants} participants would divide by {pool} sequences, but groups are filled "
            "by chance: some sequences have more people than others."
        )
    more = [sequence.name for sequence in design.sequences if used[sequence.name] > each]
    do = counted_doing(participants, "participants", "do")
    return (
        f"{do} not divide by {pool} sequences: each has {each}, {_some(more)} one more, "
        f"and {counted(pool - left, 'further participants')} would balance them."
    )


def _of_parts(parts: CombinedOrders, sequences: list[str]) -> str:
    """Say how often the orders of each part are there."""
    counts = "; ".join(
        ", ".join(f"{name} × {count}" for name, count in each.items())
        for each in parts.filled(sequences)
    )
    how = "evenly" if parts.even(sequences) else "not evenly"
    whose = f" of group {parts.group}" if parts.group else ""
    return f"The parts' orders{whose} are dealt by themselves, {how}: {counts}."


def _some(names: list[str], shown: int = 6) -> str:
    verb = "has" if len(names) == 1 else "have"
    if len(names) > shown:
        return f"{len(names)} of them {verb}"
    return f"{' and '.join([', '.join(names[:-1]), names[-1]] if names[1:] else names)} {verb}"


@dataclass(frozen=True)
class AdministeredOrder:
    """The exposures that one participant was really given.

    Parameters
    ----------
    run
        The exposures that were shown whole, session by session, under the name of the sequence.
    """

    participant: str
    enrolment: Enrolment
    run: Sequence


@dataclass(frozen=True)
class StudyAudit:
    """The balance of a study as it was run.

    Parameters
    ----------
    counted
        Those who take a place: enrolled or completed, and, where places do not return, all.
    gone
        Sequence → those who withdrew or were excluded.
    margins
        Covariate → level → group → people; empty without groups.
    next_orders
        Sequences of the next participants until all are filled alike.
    after
        The audit with those, as if all sessions were then run whole.
    """

    participants: int
    counted: Audit
    gone: dict[str, int]
    margins: dict[str, dict[str, dict[str, int]]]
    next_orders: tuple[str, ...]
    after: Audit
    mending: str


def audit_study(design: Design, met: Iterable[AdministeredOrder]) -> StudyAudit:
    """Audit a study as it was run, and return orders for its next participants."""
    everybody = list(met)
    enrolments = [each.enrolment for each in everybody]
    counting = [each for each in everybody if design.counts(each.enrolment)]
    gone = Counter(
        e.sequence for e in enrolments if not design.counts(e) or e.status not in COUNTING_STATUSES
    )
    wanted = _wanted(design, [each.enrolment for each in counting])
    added = [design.sequence(name) for name in wanted]
    whole = [design.sequence(each.enrolment.sequence) for each in counting]
    return StudyAudit(
        participants=len(everybody),
        counted=audit(design, [each.run for each in counting]),
        gone=dict(gone),
        margins=margins(design.people(enrolments), design.groups) if design.groups else {},
        next_orders=tuple(wanted),
        after=audit(design, [*whole, *added]),
        mending=_mending(design, wanted, len(counting), sum(gone.values())),
    )


def _wanted(design: Design, counting: list[Enrolment]) -> list[str]:
    """Return the sequences of the next participants until all orders are met alike."""
    names = [each.sequence for each in counting]
    if not design.parts:
        return _lacking(design, Counter(names))
    wanted: list[str] = []
    shuffled = design.assignment == "shuffled"
    for parts in design.parts.values():
        while not parts.even([*names, *wanted]):
            wanted.append(parts.next([*names, *wanted], seed=design.seed, shuffled=shuffled))
    return wanted


def _lacking(design: Design, filled: Counter[str]) -> list[str]:
    """Return the sequences that would make all of a group's alike, the emptiest first."""
    wanted: list[str] = []
    for group in dict.fromkeys(each.group for each in design.sequences):
        names = [each.name for each in design.sequences if each.group == group]
        most = max(filled[name] for name in names)
        wanted += [name for n in range(most) for name in names if filled[name] <= n]
    return wanted


def _mending(design: Design, wanted: list[str], counting: int, gone: int) -> str:
    if not design.sequences:
        return "Every participant has a random order of their own: there is nothing to mend."
    if not wanted:
        return f"Nothing has to be mended: all sequences have as many of {counting} people."
    kept = (
        ""
        if design.return_places or not gone
        else f" ({gone} who are gone keep their places; return_places = true would give them back)"
    )
    people = "participant gets" if len(wanted) == 1 else "participants get"
    orders = _listed(wanted)
    return f"All sequences are filled alike once the next {len(wanted)} {people} {orders}{kept}."


def _listed(names: list[str]) -> str:
    counted = Counter(names)
    return ", ".join(f"{name} × {n}" if n > 1 else name for name, n in counted.items())


def cannot_balance(design: Design, participants: int) -> str | None:
    """Return why a number of participants cannot balance a design; None if it can."""
    sizes = {name: lcm(*map(len, each.pools)) for name, each in design.parts.items()}
    pools = sizes or Counter(sequence.group or "" for sequence in design.sequences)
    shares = dict(design.groups.shares) if design.groups else {"": 1}
    total = sum(shares.values())
    if participants % total:
        message = (
            f"{counted(participants, 'participants')} cannot be divided among {_groups(shares)}"
        )
        return f"{message}; choose {_nearest(participants, total)}"
    step = _least_number(pools, shares)
    if not pools or not participants % step:
        return None
    of = f" of {len(pools)} groups" if design.groups else ""
    some = f"some orders are met by more people; choose {_nearest(participants, step)}"
    if design.parts:
        orders = _orders(design.parts.values())
        return f"{participants} participants do not divide by the {orders}{of}, so that {some}"
    return (
        f"{participants} participants do not divide by {sum(pools.values())} sequences{of}, so "
        f"that {some}, or another rule"
    )


def _orders(parts: Iterable[CombinedOrders]) -> str:
    """Return how many orders there are of each part, of each group that has others."""
    sizes = dict.fromkeys(" and ".join(str(len(pool)) for pool in each.pools) for each in parts)
    return f"{', or '.join(sizes)} orders of the parts"


def _least_number(pools: Mapping[str, int], shares: dict[str, int]) -> int:
    """Return the least number of participants that fills all sequences alike."""
    total, people = sum(shares.values()), 0
    while True:
        people += total
        if all(people * shares[group] // total % size == 0 for group, size in pools.items()):
            return people


def _nearest(participants: int, step: int) -> str:
    below = participants // step * step
    return f"{below} or {below + step}" if below else str(step)


def _groups(shares: dict[str, int]) -> str:
    if len(set(shares.values())) == 1:
        return f"{len(shares)} equal groups"
    return f"groups of shares {' : '.join(map(str, shares.values()))}"
