"""Whether the planned number of participants can balance a design."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from math import lcm

from vrcomfort.design.parts import Combined
from vrcomfort.design.pool import Design


def cannot_balance(design: Design, participants: int) -> str | None:
    """Say why so many people cannot fill all sequences of each group alike; None if they can."""
    sizes = {name: lcm(*map(len, each.pools)) for name, each in design.parts.items()}
    pools = sizes or Counter(sequence.group or "" for sequence in design.sequences)
    shares = dict(design.groups.shares) if design.groups else {"": 1}
    total = sum(shares.values())
    if participants % total:
        message = f"{participants} participants cannot be divided among {_groups(shares)}"
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


def _orders(parts: Iterable[Combined]) -> str:
    """Return how many orders there are of each part, of each group that has others."""
    sizes = dict.fromkeys(" and ".join(str(len(pool)) for pool in each.pools) for each in parts)
    return f"{', or '.join(sizes)} orders of the parts"


def _least_number(pools: Mapping[str, int], shares: dict[str, int]) -> int:
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
