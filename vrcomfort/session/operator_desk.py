"""What a session needs of the place where operators are, by shape; and where there are none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from vrcomfort.frame import Frame
from vrcomfort.protocol.timeline import StepKind
from vrcomfort.session.interfaces import RenderedFrame


@dataclass(frozen=True)
class OperatedStep:
    """A step of a session, as operators name it; numbers count up over a session's life."""

    number: int
    kind: StepKind
    words: str


@dataclass(frozen=True)
class SessionOrder:
    """Who is run in which order.

    Parameters
    ----------
    trials
        Scene and condition of each exposure of the session.
    remaining_s
        Returns how much time the session is expected to take still.
    """

    participant: str
    session: int
    sequence: str
    trials: tuple[tuple[str, str], ...]
    remaining_s: Callable[[], float]


class Command(Protocol):
    """What an operator wants."""

    @property
    def action(self) -> str:
        """Return one of the words of `steering.ALLOWED`."""

    @property
    def step(self) -> int:
        """Return the number of the step that it is meant for."""

    @property
    def operator(self) -> str:
        """Return who wants it."""

    @property
    def text(self) -> str:
        """Return the note, the reason, or (of an answer) the name of the item."""

    @property
    def value(self) -> float | None:
        """Return the answer; None is "rather not say"."""


class OperatorDesk(Protocol):
    """Where operators are: shows them the session and passes on what they want; never waits."""

    @property
    def starts_sessions(self) -> bool:
        """Return whether a session waits until an operator starts it."""

    def open(self, order: SessionOrder) -> None:
        """Show a session that begins."""

    def begin(self, step: OperatedStep) -> None:
        """Show a step that begins."""

    def see(self, frame: Frame, rendered: RenderedFrame | None, trial: TrialSoFar) -> None:
        """Look at a frame that was shown, if there is time and anybody to look."""

    def rated(self, instrument: str, elapsed_s: float, response: float | None) -> None:
        """Show a rating; None was missed."""

    def next_command(self) -> Command | None:
        """Return what an operator wants, or None at once."""

    def reply(self, command: Command, refusal: str) -> None:
        """Tell whoever gave a command that it is refused, and why; blank: it is done."""

    def ask_whether_to_withdraw(self, *, asked: bool) -> None:
        """Ask all operators whether the withdrawal is meant, or no longer."""


class TrialSoFar(Protocol):
    """How regularly the frames of a trial have come."""

    frames: int
    dropped: int
    untracked: int

    @property
    def frozen_so_far_s(self) -> float:
        """Return for how long the picture stood still."""


class NoDesk:
    """Where there is no operator but at the terminal."""

    starts_sessions = False

    def open(self, order: SessionOrder) -> None:
        """Show nothing."""

    def begin(self, step: OperatedStep) -> None:
        """Show nothing."""

    def see(self, frame: Frame, rendered: RenderedFrame | None, trial: TrialSoFar) -> None:
        """Look away."""

    def rated(self, instrument: str, elapsed_s: float, response: float | None) -> None:
        """Show nothing."""

    def next_command(self) -> None:
        """Return that nobody wants anything."""

    def reply(self, command: Command, refusal: str) -> None:
        """Tell nobody."""

    def ask_whether_to_withdraw(self, *, asked: bool) -> None:
        """Ask nobody."""
