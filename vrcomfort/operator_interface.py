"""The interface between a session and its operators: the session's state, and their commands."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeAlias

if TYPE_CHECKING:  # the console's server starts, and starts again, in a moment
    from vrcomfort.frame import Frame, RenderResult
    from vrcomfort.protocol.timeline import StepKind

_ALWAYS = {"note", "abort", "withdraw", "withdraw_surely", "withdraw_not"}
_TIMED = _ALWAYS | {"pause", "go_on", "skip", "recentre"}
ALLOWED: Mapping[StepKind, frozenset[str]] = {
    "session": frozenset(_ALWAYS),
    "ready": frozenset(_ALWAYS | {"start", "recentre"}),
    "training": frozenset(_TIMED | {"redo"}),
    "exposure": frozenset(_TIMED | {"redo", "rate"}),
    "questionnaire": frozenset(
        _ALWAYS | {"skip", "redo", "recentre", "answer", "confirm", "write", "decide"}
    ),
    "rest": frozenset(_TIMED),
    "instruction": frozenset(_ALWAYS | {"skip", "redo", "recentre"}),
}
"""What can be asked for in which step."""


@dataclass(frozen=True)
class OperatorStep:
    """A step of a session, as operators name it; numbers count up over a session's life."""

    number: int
    kind: StepKind
    words: str


@dataclass(frozen=True)
class RatedScale:
    """The scale of a question during exposure, and the answers that end one.

    Parameters
    ----------
    stop_at, in_a_row
        The stop rule: so many answers this high, one after the other; None: there is none.
    """

    instrument: str
    low: float
    high: float
    stop_at: float | None
    in_a_row: int


@dataclass(frozen=True)
class SessionOrder:
    """A session that begins: its participant and its timeline.

    Parameters
    ----------
    sequence
        Name of the participant's order of conditions.
    timeline
        The planned steps, by name.
    position
        Returns the number of planned steps that have begun.
    remaining_s
        Returns the estimated remaining time.
    scales
        Of the ratings during exposure.
    headset
        Returns the headset's facts, as the manifest has them so far.
    """

    participant: str
    session: int
    sequence: str
    timeline: tuple[str, ...]
    position: Callable[[], int]
    remaining_s: Callable[[], float]
    scales: tuple[RatedScale, ...] = ()
    headset: Callable[[], Mapping[str, Any]] = dict


@dataclass(frozen=True)
class Command:
    """A command of an operator.

    Parameters
    ----------
    id
        The page's own name of this message, which the answer repeats.
    action
        A word of `ALLOWED`; a page that wants pictures says ``watch``.
    step
        Number of the step that it is meant for.
    text
        The note, the reason, or (of an answer) the name of the item.
    value
        The answer; None is "rather not say".
    operator
        Who gave it.
    """

    id: str
    action: str
    step: int
    text: str = ""
    value: float | None = None
    operator: str = ""

    def content(self) -> dict[str, Any]:
        """Return it as plain JSON."""
        return {**vars(self)}


ProgressKind: TypeAlias = Literal[
    "session", "training", "exposure", "questionnaire", "rest", "instruction", "notice", "end"
]


@dataclass(frozen=True)
class SessionProgress:
    """Where a session is: `done` of `total` (frames, items or seconds, by `step`).

    The `text` of a notice is for the operator.
    """

    step: ProgressKind
    participant: str
    session: int
    trial: int = 0
    scene: str = ""
    condition: str = ""
    done: float = 0
    total: float = 0
    text: str = ""


ProgressCallback: TypeAlias = Callable[[SessionProgress], None]


class TrialSoFar(Protocol):
    """The timing of a trial's frames so far."""

    frames: int
    dropped: int
    untracked: int

    @property
    def frozen_so_far_s(self) -> float:
        """Return for how long the picture stood still."""


class OperatorInterface(Protocol):
    """Shows operators the session and returns their commands; never waits."""

    @property
    def starts_sessions(self) -> bool:
        """Return whether a session waits until an operator starts it."""

    def open(self, order: SessionOrder) -> None:
        """Show a session that begins."""

    def begin(self, step: OperatorStep) -> None:
        """Show a step that begins."""

    def see(self, frame: Frame, rendered: RenderResult | None, trial: TrialSoFar) -> None:
        """Look at a frame that was shown, if there is time and anybody to look."""

    def rated(self, instrument: str, elapsed_s: float, response: float | None) -> None:
        """Show a rating; None was missed."""

    def next_command(self) -> Command | None:
        """Return the next command, or None at once."""

    def reply(self, command: Command, refusal: str) -> None:
        """Report a command's refusal, or blank where it is done."""

    def ask_whether_to_withdraw(self, *, asked: bool) -> None:
        """Ask all operators whether the withdrawal is meant, or no longer."""

    def ask(self, question: Mapping[str, Any] | None) -> None:
        """Have operators ask a question aloud and enter the answer; None: no longer."""


class NoOperator:
    """Operators at the terminal alone: shows nothing, has no commands."""

    starts_sessions = False

    def open(self, order: SessionOrder) -> None:
        """Show nothing."""

    def begin(self, step: OperatorStep) -> None:
        """Show nothing."""

    def see(self, frame: Frame, rendered: RenderResult | None, trial: TrialSoFar) -> None:
        """Look away."""

    def rated(self, instrument: str, elapsed_s: float, response: float | None) -> None:
        """Show nothing."""

    def next_command(self) -> None:
        """Return None."""

    def reply(self, command: Command, refusal: str) -> None:
        """Do nothing."""

    def ask_whether_to_withdraw(self, *, asked: bool) -> None:
        """Do nothing."""

    def ask(self, question: Mapping[str, Any] | None) -> None:
        """Do nothing."""


def no_progress(progress: SessionProgress) -> None:
    """Show nothing."""
