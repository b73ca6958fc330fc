"""Operator control: commands, pauses, and the estimate of the remaining time.

A command names its step: one for a step that is over is refused. All commands and refusals are in
``events.csv``.
"""

from __future__ import annotations

import time
from collections import defaultdict, deque
from collections.abc import Callable, Sequence
from typing import Protocol

from vrcomfort.headset.base import CanRecenter
from vrcomfort.operator_interface import ALLOWED, Command, OperatorInterface, OperatorStep
from vrcomfort.protocol.texts import ENGLISH, Words
from vrcomfort.protocol.timeline import PlannedStep, StepKind
from vrcomfort.respondent import Withdrew
from vrcomfort.session.panel_screen import PanelScreen

_BELIEVED_S = 60.0
"""Weight of the plan: this much planned time of a kind of step counts as measured."""
IDLE_S = 0.02
"""Length of an idle moment."""


class Skipped(Exception):  # noqa: N818 - a decision of the operator, not an error
    """The operator ends the step here."""


class Redone(Exception):  # noqa: N818
    """The operator wants the step from its beginning."""


class AbortedByOperator(KeyboardInterrupt):
    """The operator ends the session, as Ctrl-C does; the message is the reason."""


NEEDS_TEXT = {"note": "a note", "abort": "the reason"}
_ENTRIES = {"answer", "confirm", "rate", "write", "decide"}


class Events(Protocol):
    """Where events go: the log of one session."""

    def now_s(self) -> float:
        """Return the session clock."""

    def event_soon(self, name: str, start_s: float | None = None, *, detail: str = "") -> None:
        """Write an event that ends now, without waiting."""


def nothing_asked(command: Command) -> str:
    """Refuse an answer where no question is open."""
    return f"nothing is asked that is answered on a console; {command.action} has no meaning now"


class OperatorControl:
    """Hears the operators; the session asks it once a frame, and never waits for it.

    Parameters
    ----------
    interface
        Shows operators the session, and takes their commands.

    Attributes
    ----------
    interface
        The same.
    step
        The one under way.
    paused
        Whether its clock stands still.
    entries
        Answers that operators have entered, for whoever asked the question.
    entry_fault
        Returns why such an answer cannot be taken, blank where it can; set by whoever asks.
    """

    def __init__(self, interface: OperatorInterface) -> None:
        self.interface = interface
        self.step = OperatorStep(0, "session", "")
        self.entries: deque[Command] = deque()
        self.entry_fault: Callable[[Command], str] = nothing_asked
        self._events: Events | None = None
        self._screen: PanelScreen | None = None
        self._headset: object = None
        self._paused_at_s: float | None = None
        self._leaving = self._started = False
        self._words = ENGLISH
        self._time: SessionTime | None = None
        self._ended_by = ""

    @property
    def paused(self) -> bool:
        """Whether the clock of the step stands still."""
        return self._paused_at_s is not None

    def attach(
        self,
        events: Events,
        screen: PanelScreen | None = None,
        *,
        words: Words = ENGLISH,
        time: SessionTime | None = None,
    ) -> None:
        """Steer this session from now on.

        Parameters
        ----------
        words
            In the participant's language.
        time
            Is told how far the session has come.
        """
        self._events, self._screen = events, screen
        self._words, self._time = words, time
        self._headset, self._started, self._leaving = None, False, False

    def use(self, headset: object) -> None:
        """Take note of the headset that is worn."""
        self._headset = headset

    def begin(self, kind: StepKind, words: str) -> None:
        """Begin a step; commands for the one before are stale from now on."""
        self._end_pause()
        self.entries.clear()
        ended_by, self._ended_by = self._ended_by, ""
        if self._time is not None:
            again = ended_by == "redo" and kind == self.step.kind
            self._time.begin(kind, words, again=again, cut_short=bool(ended_by))
        self.step = OperatorStep(self.step.number + 1, kind, words)
        self.interface.begin(self.step)

    def come(self, done: float, total: float) -> None:
        """Take note of how much of the step is done."""
        if self._time is not None and total > 0:
            self._time.come(min(max(done / total, 0.0), 1.0))

    def await_start(self) -> None:
        """Wait until an operator starts the session, where operators do.

        Raises
        ------
        Withdrew, AbortedByOperator
            If they end it instead.
        """
        if not self.interface.starts_sessions:
            return
        self.begin("ready", "waiting for the start")
        self._rest_on(self._words.paused)  # drawn now: a pause need not, between two frames
        self._rest_on(self._words.ready)
        try:
            while not self._started:
                self.look()
                self.idle()
        finally:
            self._rest_on(None)

    def idle(self) -> None:
        """Let a moment pass in which nothing is to be done."""
        if self._screen is not None:
            self._screen.next_frame()
        else:
            time.sleep(IDLE_S)

    def look(self) -> None:
        """Carry out the commands since the last call; returns at once.

        Raises
        ------
        Skipped, Redone, Withdrew, AbortedByOperator
            If that ends the step, the participant's study or the session.
        """
        while (command := self.interface.next_command()) is not None:
            refusal = self._refusal(command)
            self._note(command, refusal)
            self.interface.reply(command, refusal)
            if not refusal:
                self._do(command)

    def _refusal(self, command: Command) -> str:
        """Return why a wish is not granted, in a sentence; blank where it is."""
        action, step = command.action, self.step
        if action not in frozenset().union(*ALLOWED.values()):
            return f"there is no action {action[:40]!r}"
        if command.step != step.number and action != "note":
            here = f"now it is step {step.number}, {step.words}"
            return f"{action} was meant for step {command.step}, which is over; {here}"
        if action not in ALLOWED[step.kind]:
            return f"{action} has no meaning in this step: {step.words}"
        if action in NEEDS_TEXT and not command.text.strip():
            return f"{action} needs {NEEDS_TEXT[action]}; enter it"
        return self._refusal_of_state(command)

    def _refusal_of_state(self, command: Command) -> str:
        action = command.action
        if action == "pause" and self.paused:
            return "it is paused already"
        if action == "go_on" and not self.paused:
            return "nothing is paused"
        if action in {"withdraw_surely", "withdraw_not"} and not self._leaving:
            return "nobody has asked for a withdrawal, or it was taken back"
        if action in _ENTRIES:
            return self.entry_fault(command)
        if action == "recentre" and not isinstance(self._headset, CanRecenter):
            return "this headset cannot be recentred"
        return ""

    def _note(self, command: Command, refusal: str) -> None:
        words = f"{command.operator}, step {command.step}"
        if command.step == self.step.number:
            words = f"{words} ({self.step.words})"
        if refusal:
            detail = f"{words}, {command.action}: {refusal}"
            self._write("operator_refused", detail=detail)
            return
        said = command.text if command.action != "write" else f"{len(command.text)} characters"
        if command.action in {"answer", "rate", "decide"}:
            value = "rather not say" if command.value is None else f"{command.value:g}"
            said = f"{said} {value}".strip()
        detail = f"{words}: {said}" if said else words
        self._write(f"operator_{command.action}", detail=detail)

    def _write(self, name: str, start_s: float | None = None, *, detail: str) -> None:
        if self._events is not None:
            self._events.event_soon(name, start_s, detail=detail)

    def _do(self, command: Command) -> None:
        """Carry out a command that was not refused."""
        said = f": {command.text}" if command.text else ""
        match command.action:
            case "start":
                self._started = True
            case "pause":
                self._paused_at_s = self._events.now_s() if self._events else 0.0
                self._rest_on(self._words.paused)
                if self._time is not None:
                    self._time.pause()
            case "go_on":
                self._end_pause()
            case "skip":
                self._ended_by = "skip"
                raise Skipped
            case "redo":
                self._ended_by = "redo"
                raise Redone
            case "recentre":
                if isinstance(self._headset, CanRecenter):
                    self._headset.recenter()
            case "abort":
                raise AbortedByOperator(f"stopped by {command.operator}{said}")
            case "withdraw" | "withdraw_not":
                self._leaving = command.action == "withdraw"
                self.interface.ask_whether_to_withdraw(asked=self._leaving)
            case "withdraw_surely":
                self._leaving = False
                self.interface.ask_whether_to_withdraw(asked=False)
                raise Withdrew(f"withdrawn by {command.operator}{said}")
            case "answer" | "confirm" | "rate" | "write" | "decide":
                self.entries.append(command)

    def _end_pause(self) -> None:
        began_s, self._paused_at_s = self._paused_at_s, None
        if began_s is not None:
            if self._time is not None:
                self._time.end_pause()
            self._rest_on(None)
            self._write("pause", began_s, detail=self.step.words)

    def _rest_on(self, words: str | None) -> None:
        if self._screen is not None:
            self._screen.rest_on(words)


class SessionTime:
    """Follows a session through its planned steps.

    Each kind of step has a factor, which begins at 1: the time that its steps have taken over the
    time that was planned for them, where `_BELIEVED_S` of the plan count as taken. A pause is in
    none of them, and neither is a step that an operator has ended.

    Parameters
    ----------
    steps
        In their order.
    now_s
        Returns the session clock.
    """

    def __init__(self, steps: Sequence[PlannedStep], now_s: Callable[[], float]) -> None:
        self._steps, self._now_s = tuple(steps), now_s
        self._at = -1
        self._current: PlannedStep | None = None
        self._planned_s: defaultdict[StepKind, float] = defaultdict(float)
        self._taken_s: defaultdict[StepKind, float] = defaultdict(float)
        self._began_s = self._paused_s = 0.0
        self._pause_began_s: float | None = None
        self._share: float | None = None

    def begin(
        self, kind: StepKind, words: str, *, again: bool = False, cut_short: bool = False
    ) -> None:
        """Take note that a step begins.

        Parameters
        ----------
        again
            It is the one before, once more.
        cut_short
            An operator has ended the one before: how long it took says nothing of others.
        """
        self.end_pause()
        if not cut_short:
            self._learn()
        self._began_s, self._paused_s, self._share = self._now_s(), 0.0, None
        if again and self._current is not None:
            return
        index = self._next(kind, words)
        self._current = None if index is None else self._steps[index]
        self._at = self._at if index is None else index

    def come(self, share: float) -> None:
        """Take note of how much of the step is done, 0 to 1."""
        self._share = share

    def pause(self) -> None:
        """Stop to count the step's time."""
        if self._pause_began_s is None:
            self._pause_began_s = self._now_s()

    def end_pause(self) -> None:
        """Go on."""
        began_s, self._pause_began_s = self._pause_began_s, None
        if began_s is not None:
            self._paused_s += self._now_s() - began_s

    @property
    def position(self) -> int:
        """Return the number of planned steps that have begun, or were passed over."""
        return self._at + 1

    def remaining_s(self) -> float:
        """Return the time that is expected to be left."""
        later_s = sum(self._expected_s(step) for step in self._steps[self._at + 1 :])
        if self._current is None:
            return later_s
        expected_s = self._expected_s(self._current)
        if self._share is not None:
            return later_s + expected_s * (1 - self._share)
        return later_s + max(expected_s - self._elapsed_s(), 0.0)

    def _next(self, kind: StepKind, words: str) -> int | None:
        """Return which step begins: none where it is not planned before the next exposure."""
        for index in range(self._at + 1, len(self._steps)):
            step = self._steps[index]
            if step.kind == kind and words.startswith(step.words):
                return index
            if step.kind == "exposure":
                return None
        return None

    def _learn(self) -> None:
        if self._current is not None:
            self._planned_s[self._current.kind] += self._current.planned_s
            self._taken_s[self._current.kind] += self._elapsed_s()

    def _elapsed_s(self) -> float:
        paused_s, began_s = self._paused_s, self._pause_began_s
        now_s = self._now_s() if began_s is None else began_s
        return now_s - self._began_s - paused_s

    def _expected_s(self, step: PlannedStep) -> float:
        taken_s = self._taken_s[step.kind] + _BELIEVED_S
        return step.planned_s * taken_s / (self._planned_s[step.kind] + _BELIEVED_S)
