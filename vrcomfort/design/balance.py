"""Whether the planned number of participants can balance a design."""

from __future__ import annotations

from collections import Counter
from math import lcm

from vrcomfort.design.parts import Combined
from vrcomfort.design.pool import Design


def cannot_balance(design: Design, participants: int) -> str | None:
    """Say why so many people cannot fill all sequences of each group alike; None if they can."""
    if design.parts is not None:
        return _of_parts(design.parts, participants)
    pools = Counter(sequence.group or "" for sequence in design.sequences)
    shares = dict(design.groups.shares) if design.groups else {"": 1}
    total = sum(shares.values())
    if participants % total:
        message = f"{participants} participants cannot be divided among {_groups(shares)}"
        return f"{message}; choose {_nearest(participants, total)}"
    step = _least_number(pools, shares)
    if not pools or not participants % step:
        return None
    of = f" of {len(pools)} groups" if design.groups else ""
    return (
        f"{participants} participants do not divide by {sum(pools.values())} sequences{of}, so "
        "that some orders are met by more people; choose "
        f"{_nearest(participants, step)}, or another rule"
    )


def _of_parts(parts: Combined, participants: int) -> str | None:
    sizes = [len(pool) for pool in parts.pools]
    step = lcm(*sizes)
    if not participants % step:
        return None
    orders = " and ".join(map(str, sizes))
    return (
        f"{participants} participants do not divide by the {orders} orders of the parts, so that "
        f"some orders are met by more people; choose {_nearest(participants, step)}"
    )


def _least_number(pools: Counter[str], shares: dict[str, int]) -> int:
    """Return the least number of people who fill all sequences alike."""
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
