"""Whether the parts of a study can be met."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import prod

from vrcomfort.protocol.levels import part_trials
from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order_check import MOST_TREATMENTS, unknown_name
from vrcomfort.protocol.parts import Part
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
    if protocol.groups:
        message = "[[groups]] and [[parts]] exclude each other; write the sequences of each group"
        yield Problem(("groups",), message)
    yield from repeated(("parts",), [part.name for part in protocol.parts])
    for index, part in enumerate(protocol.parts):
        yield from _part(protocol, part, ("parts", index))
    if not set(range(1, max(p.session for p in protocol.parts) + 1)) <= {
        part.session for part in protocol.parts
    }:
        message = "a session before this one has no part; count sessions from 1, without gaps"
        yield Problem(("parts", len(protocol.parts) - 1, "session"), message)
    if prod(_orders(protocol, part) for part in protocol.parts) > MOST_COMBINATIONS:
        message = f"the parts' orders have more than {MOST_COMBINATIONS} combinations"
        yield Problem(("parts",), f"{message}; give them fewer orders")


def _orders(protocol: Protocol, part: Part) -> int:
    """Return how many orders a part has, or at least a number that is too large."""
    if part.rule == "explicit":
        return max(len(part.orders), 1)
    count = min(len(part_trials(protocol, part)), MOST_TREATMENTS[part.rule])
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
    for before, after in pairwise(part.orders):
        if len(before.trials) != len(after.trials):
            message = f"orders `{before.name}` and `{after.name}` are not of the same length"
            yield Problem((*path, "orders"), f"{message}; all of a part need the same")
    if part.rule != "explicit":
        most, count = MOST_TREATMENTS[part.rule], len(part_trials(protocol, part))
        if count > most:
            message = f"`{part.rule}` takes at most {most} condition-scene pairs; there are {count}"
            yield Problem((*path, "rule"), f"{message}: choose another rule")
