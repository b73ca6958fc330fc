"""A dial in an exposure: what participants turn it to, what that changes, and its rows."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from vrcomfort.frame import Frame
from vrcomfort.headset.inputs import Inputs
from vrcomfort.protocol import Condition
from vrcomfort.protocol.adjustments import Adjustment, adjusted, value_of
from vrcomfort.records import DialRow
from vrcomfort.respondent.turning import Turn
from vrcomfort.session.context import SessionContext
from vrcomfort.session.event_log import EventLog, TrialPlace
from vrcomfort.session.task_run import HasInputs, task_random

KEY_STEPS = 100
"""Presses of an arrow key that take a continuous dial through its range."""
LEAST_PUSH = 0.15
"""A thumb-stick that is pushed less rests: no stick comes back to its middle exactly."""
LONGEST_S = 0.1
"""Nobody turns for longer in one frame: the picture stood still."""
_STREAM = 7
"""Which of a trial's random streams is the dial's."""


@runtime_checkable
class Adjusts(Protocol):
    """A respondent who adjusts without hands: a simulated participant."""

    def start_adjustment(self, trial: int, adjustment: Adjustment) -> None:
        """Begin to adjust."""

    def turn(self, place: float, time_s: float) -> Turn:
        """Return what they do to the dial, which is at a place (0 to 1) of its range."""


@runtime_checkable
class HasArrows(Protocol):
    """A headset with a window, whose arrow keys walk where nothing else wants them."""

    arrows_turn: bool
    """Whether they turn a dial."""


@dataclass
class AdjustmentRun:
    """The adjustment of one exposure: its dial changes the condition that is drawn.

    Parameters
    ----------
    attempt
        At this trial.
    """

    context: SessionContext
    events: EventLog
    place: TrialPlace
    adjustment: Adjustment
    attempt: int
    resumed: bool
    _before_s: float | None = field(default=None, init=False)
    """Seconds of the exposure at the frame before; None where none is under way."""
    _confirmed: bool = field(default=False, init=False)
    _keyboard: HasArrows | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self._condition = self.context.protocol.condition(self.place.condition or "")
        self._at = self._first_place()
        self._value = self.adjustment.value_at(self._at)

    @property
    def built_for(self) -> Condition:
        """Return the condition whose passes can show every value: at 0 there may be none."""
        return self._with(self.adjustment.range[1])

    @property
    def done(self) -> bool:
        """Whether it is confirmed and that ends the exposure; see `interfaces.Doing`."""
        return self._confirmed and self.context.protocol.exposure_ends == "adjustment"

    def demand(self, frame: Frame) -> None:
        """Return nothing: one may look anywhere."""
        del frame

    def show_start(self) -> None:
        """Show the value at which the dial begins, from the next frame on."""
        self.context.renderer.adjust(self._with(self._value))

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame before it is drawn: turn the dial, and draw by what it says."""
        del frame, scene_time_s
        if self._before_s is None:
            self._begin(headset)
        passed_s = min(elapsed_s - (self._before_s or 0.0), LONGEST_S)
        self._before_s = elapsed_s
        if self._confirmed:
            return
        turn = self._turn(headset, elapsed_s)
        self._at += turn.stick * passed_s / self.adjustment.sweep_s
        self._at += turn.steps / (self.adjustment.steps or KEY_STEPS)
        self._at = min(max(self._at, 0.0), 1.0)
        value = self.adjustment.value_at(self._at)
        if value != self._value:
            self._value = value
            self.context.renderer.adjust(self._with(value))
            self._write("change")
        if turn.confirm:
            self._confirmed = True
            self._write("confirmed")
            name = self.adjustment.name
            self.events.event_soon("adjusted", detail=f"{name} confirmed at {value:g}")

    def finish(self) -> None:
        """End with the exposure, however it ended; once."""
        if self._before_s is not None and not self._confirmed:
            self._write("end")
        self._before_s = None
        if self._keyboard is not None:
            self._keyboard.arrows_turn = False

    def _begin(self, headset: object) -> None:
        self._keyboard = headset if isinstance(headset, HasArrows) else None
        if self._keyboard is not None:
            self._keyboard.arrows_turn = True
        respondent = self.context.respondent
        if isinstance(respondent, Adjusts):
            respondent.start_adjustment(self.place.trial or 0, self.adjustment)
        self._write("start")

    def _turn(self, headset: object, elapsed_s: float) -> Turn:
        respondent = self.context.respondent
        if isinstance(respondent, Adjusts):
            return respondent.turn(self._at, elapsed_s)
        if isinstance(headset, HasInputs) and not self.context.panel_stands:
            return turned(headset.inputs())
        return Turn()

    def _with(self, value: float) -> Condition:
        return adjusted(self._condition, self.adjustment.setting, value)

    def _first_place(self) -> float:
        """Return where the dial stands when the exposure begins: the same at each attempt."""
        start = self.adjustment.start
        if start == "setting":
            own = value_of(self._condition, self.adjustment.setting)
            return 0.0 if own is None else self.adjustment.place_of(own)
        if start == "random":
            return float(self._random(self.place.trial or 0).random())
        if start == "alternating":
            first = int(self._random(0).integers(2))
            return float((first + self._before()) % 2)
        return float(start == "descending")

    def _random(self, trial: int) -> np.random.Generator:
        context = self.context
        session = self.events.session
        return task_random(context.seed, context.participant, session, trial, _STREAM)

    def _before(self) -> int:
        """Return how many exposures of the session before this one have the same adjustment."""
        trials = self.context.sequence.sessions[self.events.session - 1]
        before = trials[: (self.place.trial or 1) - 1]
        known = [self.context.protocol.adjustment_in(trial.condition) for trial in before]
        return sum(each is not None and each.name == self.adjustment.name for each in known)

    def _write(self, kind: str) -> None:
        row = DialRow(
            participant=self.context.participant,
            session=self.events.session,
            trial=self.place.trial or 0,
            condition=self.place.condition or "",
            attempt=self.attempt,
            dial=self.adjustment.name,
            setting=self.adjustment.setting,
            kind=kind,
            onset_s=round(self.context.clock.now_s(), 9),
            value=self._value,
            resumed=int(self.resumed),
        )
        self.events.recorder.write_soon(row)


def turned(inputs: Inputs) -> Turn:
    """Return what hands and keys do to a dial in a frame."""
    push = inputs.right.thumbstick[1]
    beyond = max(abs(push) - LEAST_PUSH, 0.0) / (1 - LEAST_PUSH)
    right, down = inputs.keys.arrow
    confirm = inputs.keys.enter or any(hand.select for hand in inputs.hands)
    return Turn(beyond if push > 0 else -beyond, right - down, confirm)
