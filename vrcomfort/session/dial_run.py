"""A dial in an exposure: how it is turned, and its rows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from vrcomfort.frame import Frame
from vrcomfort.headset.inputs import Inputs
from vrcomfort.protocol.sliders import Dial
from vrcomfort.protocol.timeline import TrialPlace
from vrcomfort.records import DialRow
from vrcomfort.respondent.turning import Turn
from vrcomfort.scene.markers import Shown
from vrcomfort.session.context import SessionContext
from vrcomfort.session.event_log import EventLog
from vrcomfort.session.interfaces import Doing
from vrcomfort.session.task_run import HasInputs, task_random
from vrcomfort.tasks import Demand

KEY_STEPS = 100
"""Presses of an arrow key that take a continuous dial through its range."""
LEAST_PUSH = 0.15
"""A thumb-stick that is pushed less rests: no stick comes back to its middle exactly."""
LONGEST_S = 0.1
"""Nobody turns for longer in one frame: the picture stood still."""
_STREAM = 7
"""Which of a trial's random streams is the dial's."""


@runtime_checkable
class HasArrows(Protocol):
    """A headset with a window, whose arrow keys walk where nothing else wants them."""

    arrows_turn: bool
    """Whether they turn a dial."""


@dataclass
class DialRun(ABC):
    """A dial in one exposure.

    Parameters
    ----------
    attempt
        At this trial.
    """

    context: SessionContext
    events: EventLog
    place: TrialPlace
    attempt: int
    resumed: bool
    dial: Dial
    at: float = field(default=0.0, init=False)
    """Where it stands: 0 (lowest) to 1."""
    _before_s: float | None = field(default=None, init=False)
    """Seconds of the exposure at the frame before; None where none is under way."""
    _keyboard: HasArrows | None = field(default=None, init=False)

    @property
    @abstractmethod
    def value(self) -> float:
        """Return what it says now."""

    @property
    def ended(self) -> bool:
        """Return whether nobody can turn it any more."""
        return False

    @property
    def done(self) -> bool:
        """Return whether the exposure ends with it; see `interfaces.Doing`."""
        return False

    @abstractmethod
    def begin(self) -> None:
        """Take note that the exposure begins, with its first frame."""

    @abstractmethod
    def turned(self, turn: Turn, elapsed_s: float, passed_s: float) -> None:
        """Take what was done to it in a frame, and in how much time."""

    @abstractmethod
    def simulated(self, elapsed_s: float) -> Turn | None:
        """Return what a simulated participant does to it; None of others."""

    def demand(self, frame: Frame) -> None:
        """Return nothing: one may look anywhere."""
        del frame

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame before it is drawn."""
        del frame, scene_time_s
        if self._before_s is None:
            self._keyboard = headset if isinstance(headset, HasArrows) else None
            if self._keyboard is not None:
                self._keyboard.arrows_turn = True
            self.begin()
            self.write("start")
        passed_s = min(elapsed_s - (self._before_s or 0.0), LONGEST_S)
        self._before_s = elapsed_s
        if not self.ended:
            self.turned(self._turn(headset, elapsed_s), elapsed_s, passed_s)

    def changed(self) -> tuple[Shown, ...]:
        """Return nothing: it shows no balls."""
        return ()

    def finish(self) -> None:
        """End with the exposure, however it ended; once."""
        if self._before_s is not None and not self.ended:
            self.write("end")
        self._before_s = None
        if self._keyboard is not None:
            self._keyboard.arrows_turn = False

    def moved(self, turn: Turn, passed_s: float, steps: int) -> float:
        """Return where it stands after a turn: pushed at a rate, and so many steps on."""
        at = self.at + turn.stick * passed_s / self.dial.sweep_s + turn.steps / steps
        return min(max(at, 0.0), 1.0)

    def random(self, trial: int) -> np.random.Generator:
        """Return what is drawn from: the same at each attempt at a trial."""
        context = self.context
        session = self.events.session
        return task_random(context.seed, context.participant, session, trial, _STREAM)

    def write(self, kind: str) -> None:
        """Keep where it stands."""
        row = DialRow(
            participant=self.context.participant,
            session=self.events.session,
            trial=self.place.trial or 0,
            condition=self.place.condition or "",
            attempt=self.attempt,
            dial=self.dial.name,
            setting=str(getattr(self.dial, "setting", "")),
            instrument=str(getattr(self.dial, "instrument", "")),
            kind=kind,
            onset_s=round(self.context.clock.now_s(), 9),
            value=self.value,
            resumed=int(self.resumed),
        )
        self.events.recorder.write_soon(row)

    def _turn(self, headset: object, elapsed_s: float) -> Turn:
        turn = self.simulated(elapsed_s)
        if turn is not None:
            return turn
        if isinstance(headset, HasInputs) and not self.context.panel_stands:
            return turn_of(headset.inputs())
        return Turn()


def turn_of(inputs: Inputs) -> Turn:
    """Return what hands and keys do to a dial in a frame."""
    push = inputs.right.thumbstick[1]
    beyond = max(abs(push) - LEAST_PUSH, 0.0) / (1 - LEAST_PUSH)
    right, down = inputs.keys.arrow
    confirm = inputs.keys.enter or any(hand.select for hand in inputs.hands)
    return Turn(beyond if push > 0 else -beyond, right - down, confirm)


@dataclass
class Several:
    """Things that are done at once in an exposure."""

    parts: Sequence[Doing]

    @property
    def done(self) -> bool:
        """Return whether the exposure ends with one of them."""
        return any(part.done for part in self.parts)

    def demand(self, frame: Frame) -> Demand | None:
        """Return what is to be looked at for the first that wants something."""
        return next((found for part in self.parts if (found := part.demand(frame))), None)

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame before it is drawn."""
        for part in self.parts:
            part.step(frame, headset, elapsed_s, scene_time_s)

    def changed(self) -> tuple[Shown, ...]:
        """Return the balls that are drawn otherwise than at the last call."""
        return tuple(ball for part in self.parts for ball in part.changed())

    def finish(self) -> None:
        """End with the exposure, however it ended."""
        for part in self.parts:
            part.finish()
