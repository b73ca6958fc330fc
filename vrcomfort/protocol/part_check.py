"""Whether the parts of a study can be met."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import prod

from vrcomfort.protocol.levels import part_trials
from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order import Group
from vrcomfort.protocol.order_check import MOST_TREATMENTS, unknown_name
from vrcomfort.protocol.parts import Part, orders_of
from vrcomfort.settings import KeyPath, Problem, repeated

MOST_COMBINATIONS = 10_000


def part_problems(protocol: Protocol) -> Iterator[Problem]:
    """Yield what is wrong with [[parts]]."""
    rule = protocol.order.rule
    if rule != "parts":
        if protocol.parts:
            message = f'[[parts]] do nothing with rule = "{rule}"; say `rule = "parts"`'
            yield Problem(("order", "rule"), message)
        return
    if not protocol.parts:
        message = "`parts` takes the orders of [[parts]], and there are none; add them"
        yield Problem(("order", "rule"), message)
        return
    yield from repeated(("parts",), [part.name for part in protocol.parts])
    for index, part in enumerate(protocol.parts):
        yield from _part(protocol, part, ("parts", index))
    if not set(range(1, max(p.session for p in protocol.parts) + 1)) <= {
        part.session for part in protocol.parts
    }:
        message = "a session before this one has no part; count sessions from 1, without gaps"
        yield Problem(("parts", len(protocol.parts) - 1, "session"), message)
    if any(_combinations(protocol, group) > MOST_COMBINATIONS for group in _groups(protocol)):
        message = f"the parts' orders have more than {MOST_COMBINATIONS} combinations"
        yield Problem(("parts",), f"{message}; give them fewer orders")


def _groups(protocol: Protocol) -> tuple[Group | None, ...]:
    return protocol.groups or (None,)


def _combinations(protocol: Protocol, group: Group | None) -> int:
    return prod(_orders(protocol, part, group) for part in protocol.parts)


def _orders(protocol: Protocol, part: Part, group: Group | None) -> int:
    """Return how many orders a group has of a part, or at least a number that is too large."""
    if part.rule == "explicit":
        return max(len(orders_of(part, group.name if group else "")), 1)
    count = min(len(part_trials(protocol, part, group)), MOST_TREATMENTS[part.rule])
    if part.rule == "all_orders":
        return prod(range(1, count + 1))
    return count * (2 if part.rule == "williams" and count % 2 else 1)


def _part(protocol: Protocol, part: Part, path: KeyPath) -> Iterator[Problem]:
    conditions = [condition.name for condition in protocol.conditions]
    if part.rule == "explicit":
        if not part.orders:
            message = "`explicit` needs at least one [[parts.orders]] table"
            yield Problem((*path, "rule"), message, missing=True)
        for key in sorted({"conditions", "scenes"} & part.model_fields_set):
            message = f'`{key}` does nothing with rule = "explicit"; remove it or change that'
            yield Problem((*path, key), message)
    elif part.orders:
        message = f"rule `{part.rule}` makes its own orders; remove these or say `explicit`"
        yield Problem((*path, "orders"), message)
    for name in part.conditions:
        yield from unknown_name((*path, "conditions"), "condition", name, conditions)
    for name in part.scenes:
        yield from unknown_name((*path, "scenes"), "scene", name, protocol.scenes)
    yield from repeated((*path, "orders"), [order.name for order in part.orders])
    for number, order in enumerate(part.orders):
        for place, trial in enumerate(order.trials):
            here = (*path, "orders", number, "trials", place)
            yield from unknown_name(here, "condition", trial.condition, conditions)
            yield from unknown_name(here, "scene", trial.scene, protocol.scenes)
    for group in _groups(protocol):
        yield from _of_group(protocol, part, path, group)
    yield from _whose(protocol, part, path)


def _of_group(
    protocol: Protocol, part: Part, path: KeyPath, group: Group | None
) -> Iterator[Problem]:
    """Yield what is wrong with the orders of a part that one group meets."""
    written = orders_of(part, group.name if group else "")
    whose = f" of group `{group.name}`" if group else ""
    for before, after in pairwise(written):
        if len(before.trials) != len(after.trials):
            message = f"orders `{before.name}` and `{after.name}` are not of the same length"
            yield Problem((*path, "orders"), f"{message}; all of a part{whose} need the same")
    if group and part.orders and not written:
        message = f"group `{group.name}` has no order of part `{part.name}`"
        yield Problem((*path, "orders"), f"{message}; add one, or leave `group` out of another")
    if part.rule == "explicit":
        return
    most, count = MOST_TREATMENTS[part.rule], len(part_trials(protocol, part, group))
    if count > most:
        message = f"`{part.rule}` takes at most {most} condition-scene pairs; there are {count}"
        yield Problem((*path, "rule"), f"{message}{whose}: choose another rule")
    if group and not count:
        message = f"group `{group.name}` meets no condition of part `{part.name}`"
        yield Problem((*path, "conditions"), f"{message}; name some of its conditions")


def _whose(protocol: Protocol, part: Part, path: KeyPath) -> Iterator[Problem]:
    """Yield what is wrong with the groups of written orders."""
    names = [group.name for group in protocol.groups]
    for number, order in enumerate(part.orders):
        here = (*path, "orders", number)
        if order.group is not None and not names:
            yield Problem((*here, "group"), "there are no [[groups]]; add them, or remove this")
        elif order.group is not None:
            yield from unknown_name((*here, "group"), "group", order.group, names)
        for group in protocol.groups:
            if order.group not in (None, group.name) or not group.conditions:
                continue
            others = [t.condition for t in order.trials if t.condition not in group.conditions]
            if others:
                message = f"group `{group.name}` does not meet condition `{others[0]}`"
                yield Problem((*here, "trials"), f"{message}; say whose order this is: `group`")
