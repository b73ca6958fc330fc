"""Other devices that are told what happens in a session: LabStreamingLayer, a serial port."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vrcomfort.cli.terminal import warn

if TYPE_CHECKING:
    from vrcomfort.frame import Frame
    from vrcomfort.records import EventRow, RatingRow
    from vrcomfort.session.interfaces import Relay


@dataclass(frozen=True)
class Relays:
    """Several that are told the same; the first clock there is counts."""

    each: tuple[Relay, ...]

    def now_s(self) -> float | None:
        """Return the first one's clock."""
        return next((now_s for one in self.each if (now_s := one.now_s()) is not None), None)

    def mark(self, row: EventRow) -> None:
        """Pass on an event."""
        for one in self.each:
            one.mark(row)

    def rate(self, row: RatingRow) -> None:
        """Pass on a rating."""
        for one in self.each:
            one.rate(row)

    def show(self, frame: Frame, monotonic_ns: int | None) -> None:
        """Pass on a frame."""
        for one in self.each:
            one.show(frame, monotonic_ns)

    def begin_exposure(self, trial: int, condition: str, monotonic_ns: int | None) -> None:
        """Pass on that an exposure begins."""
        for one in self.each:
            one.begin_exposure(trial, condition, monotonic_ns)

    def end_exposure(self, trial: int) -> None:
        """Pass on that an exposure is over."""
        for one in self.each:
            one.end_exposure(trial)

    def take_left_out(self) -> int:
        """Return how much could not be passed on."""
        return sum(one.take_left_out() for one in self.each)


@contextmanager
def open_relays(
    study: str, participant: str, *, lsl: bool, ttl: str | None, simulated: bool
) -> Iterator[Relays]:
    """Open what was asked for.

    Raises
    ------
    InputError
        If a library or a port is missing.
    """
    with ExitStack() as owned:
        opened: list[Relay] = []
        if lsl:
            from vrcomfort.exchange.lsl import LslRelay

            opened.append(owned.enter_context(LslRelay(study, participant)))
        if ttl is not None:
            from vrcomfort.exchange.ttl import TtlRelay

            opened.append(owned.enter_context(TtlRelay(ttl)))
        if opened and simulated:
            warn(
                "a simulated participant lives faster than the clock: what other devices are told "
                "comes as fast, and no clocks are recorded"
            )
        yield Relays(tuple(opened))
