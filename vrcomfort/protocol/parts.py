"""Parts of a study, each with an order of its own that does not depend on those of the others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.protocol.order import Trial
from vrcomfort.settings import Name, Settings, Word


class PartOrder(Settings):
    """One order of the trials of a part."""

    name: Name
    """Within the part; names of sequences are put together from these."""
    group: Name | None = None
    """Who meets it, where the protocol has [[groups]]; without it, every group."""
    trials: Annotated[tuple[Trial, ...], Field(min_length=1)]
    """What is shown, in this order."""


class Part(Settings):
    """Trials that belong together, for `[order] rule = "parts"`.

    Everybody meets each part in one of its orders, dealt evenly and without regard to those of the
    other parts.
    """

    name: Word
    """In the column `part` of files and reports."""
    session: Annotated[int, Field(ge=1, le=1000)] = 1
    """Number of the session that it is in; parts of one session follow each other as written."""
    rule: Literal["explicit", "latin_square", "williams", "all_orders"] = "explicit"
    """How its orders are made; see [order]."""
    conditions: tuple[str, ...] = ()
    """Of orders that a rule makes; without it, all."""
    scenes: tuple[str, ...] = ()
    """The same."""
    orders: tuple[PartOrder, ...] = ()
    """Those of `explicit`."""
    repeats: Annotated[int, Field(ge=1, le=100)] = 1
    """So many times an order is met, one after the other."""


def orders_of(part: Part, group: str) -> tuple[PartOrder, ...]:
    """Return the written orders that a group meets; `group` is blank without groups."""
    return tuple(order for order in part.orders if not group or order.group in (None, group))


def written_orders(parts: tuple[Part, ...]) -> Iterator[tuple[int, int, PartOrder]]:
    """Yield the indices of part and order, and the order, of all that are written down."""
    for index, part in enumerate(parts):
        for number, order in enumerate(part.orders):
            yield index, number, order
