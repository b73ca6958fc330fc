"""Devices beside a session: the operator's console, outlets (LSL, serial port), sound."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vrcomfort.cli.terminal import dialogue, warn
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol

if TYPE_CHECKING:
    from vrcomfort.console import OperatorConsole
    from vrcomfort.frame import Frame
    from vrcomfort.headset.sound import SystemSpeaker
    from vrcomfort.operator_interface import ProgressCallback
    from vrcomfort.protocol.texts import Words
    from vrcomfort.records import EventRow, RatingRow
    from vrcomfort.session.interfaces import Outlet
    from vrcomfort.session.operator_control import OperatorControl
    from vrcomfort.session.panel_screen import PanelScreen
    from vrcomfort.session.verbal import VerbalRespondent


# The operator's console.


@dataclass(frozen=True)
class ConsoleSetup:
    """A page that shows the session and steers it."""

    desk: OperatorConsole
    operators: OperatorControl

    @property
    def progress(self) -> ProgressCallback:
        """Return the callback that shows the progress of a step."""
        return self.desk.tell

    def respondent(self, screen: PanelScreen | None, words: Words) -> VerbalRespondent:
        """Return a respondent for answers on the page; `words` stand in a headset."""
        from vrcomfort.session.verbal import VerbalRespondent

        return VerbalRespondent(self.desk, self.operators, screen, words=words)


@contextmanager
def open_console() -> Iterator[ConsoleSetup]:
    """Start the page's server and print its address; it ends with the session.

    Raises
    ------
    InputError
        If it does not start.
    """
    from vrcomfort.console import OperatorConsole, ServerProcess
    from vrcomfort.headset.eye_painter import EyePictures
    from vrcomfort.session.operator_control import OperatorControl

    terminal = dialogue()

    def tell_address(address: str) -> None:
        terminal.print(f"console, for the next operator, once: {address}", soft_wrap=True)

    with ServerProcess(warn, tell_address) as server:
        pictures = EyePictures()
        desk = OperatorConsole(server, say=terminal.print, pictures=pictures)
        try:
            yield ConsoleSetup(desk, OperatorControl(desk))
        finally:
            pictures.release()


# Outlets pass events, ratings and frames on to other devices: LabStreamingLayer, a serial port.


@dataclass(frozen=True)
class Outlets:
    """Several that are told the same; the first clock there is counts."""

    each: tuple[Outlet, ...]

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
def open_outlets(
    study: str, participant: str, *, lsl: bool, ttl: str | None, simulated: bool
) -> Iterator[Outlets]:
    """Open the outlets that were asked for.

    Raises
    ------
    InputError
        If a library or a port is missing.
    """
    with ExitStack() as owned:
        opened: list[Outlet] = []
        if lsl:
            from vrcomfort.exchange.lsl import LslOutlet

            opened.append(owned.enter_context(LslOutlet(study, participant)))
        if ttl is not None:
            from vrcomfort.exchange.ttl import TtlOutlet

            opened.append(owned.enter_context(TtlOutlet(ttl)))
        if opened and simulated:
            warn(
                "a simulated participant lives faster than the clock: what other devices are told "
                "comes as fast, and no clocks are recorded"
            )
        yield Outlets(tuple(opened))


# The sound device of instructions.


@contextmanager
def open_speaker(protocol: Protocol) -> Iterator[SystemSpeaker | None]:
    """Open the sound device, where the protocol needs one; None where texts stand in for it.

    Raises
    ------
    InputError
        If there is none, and an instruction has nothing but its sound.
    """
    heard = [each for each in protocol.told if each.sound]
    if not heard:
        yield None
        return
    from vrcomfort.headset.sound import SystemSpeaker
    from vrcomfort.session.instructor import sounds_of

    try:
        speaker = SystemSpeaker()
    except InputError as error:
        alone = [each.name for each in heard if not each.text]
        if alone:
            message = f"{error.message}; or give instruction `{alone[0]}` a text to be read instead"
            raise InputError(message, file=protocol.file) from error
        names = ", ".join(each.name for each in heard)
        warn(f"{error.message}; until then texts stand in for the sounds of {names}")
        speaker = None
    if speaker is None:
        yield None
        return
    with speaker:
        for sound in sounds_of(protocol).values():
            speaker.prepare(sound)
        yield speaker
