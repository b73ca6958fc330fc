"""Adjustments and continuous ratings in an exposure: how their dial is turned, and its rows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from vrcomfort.frame import Frame
from vrcomfort.headset.base import HasArrowKeys, HasHaptics, HasInputs
from vrcomfort.headset.inputs import Inputs
from vrcomfort.protocol import Condition
from vrcomfort.protocol.adjustments import Adjustment, Dial, Slider, adjusted, value_of
from vrcomfort.protocol.timeline import TrialPlace
from vrcomfort.questionnaire import Instrument
from vrcomfort.records import DialRow
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.respondent.simulated_hands import Turn
from vrcomfort.scene.markers import Shown
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.session.interfaces import Activity
from vrcomfort.session.task_run import task_random
from vrcomfort.tasks import Demand

KEY_STEPS = 100
"""Presses of an arrow key that take a continuous dial through its range."""
LEAST_PUSH = 0.15
"""A thumb-stick that is pushed less rests: no stick comes back to its middle exactly."""
LONGEST_S = 0.1
"""Longest turn in one frame: in a longer one the picture stood still."""
_STREAM = 7
"""Which of a trial's random streams is the dial's."""
SLIDER_KEY_STEPS = 20
"""Presses of an arrow key that take a slider through its range."""
RIGHT_HAND = 1
SLIDER_DIGITS = 3
"""Of a place on the scale."""


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
    _keyboard: HasArrowKeys | None = field(default=None, init=False)

    @property
    @abstractmethod
    def value(self) -> float:
        """Return the current value."""

    @property
    def ended(self) -> bool:
        """Return whether the dial is locked."""
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
        """Apply a frame's turn, and the time that it took."""

    @abstractmethod
    def simulated(self, elapsed_s: float) -> Turn | None:
        """Return a simulated participant's turn; None for others."""

    def demand(self, frame: Frame) -> None:
        """Return nothing: one may look anywhere."""
        del frame

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame before it is drawn."""
        del frame, scene_time_s
        if self._before_s is None:
            self._keyboard = headset if isinstance(headset, HasArrowKeys) else None
            if self._keyboard is not None:
                self._keyboard.arrows_turn = True
            self.begin()
            self.write("start")
        passed_s = min(elapsed_s - (self._before_s or 0.0), LONGEST_S)
        self._before_s = elapsed_s
        if not self.ended:
            self.turned(self._turn(headset, elapsed_s), elapsed_s, passed_s)

    def next_s(self) -> float | None:
        """Return None: every frame counts."""
        return None

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
        """Return the dial's place after a turn, by stick and by steps."""
        at = self.at + turn.stick * passed_s / self.dial.sweep_s + turn.steps / steps
        return min(max(at, 0.0), 1.0)

    def random(self, trial: int) -> np.random.Generator:
        """Return the trial's random generator, the same at each attempt."""
        context = self.context
        session = self.events.session
        return task_random(context.seed, context.participant, session, trial, _STREAM)

    def write(self, kind: str) -> None:
        """Record the dial's place."""
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
    """Return the turn by hands and keys in a frame."""
    push = inputs.right.thumbstick[1]
    beyond = max(abs(push) - LEAST_PUSH, 0.0) / (1 - LEAST_PUSH)
    right, down = inputs.keys.arrow
    confirm = inputs.keys.enter or any(hand.select for hand in inputs.hands)
    return Turn(beyond if push > 0 else -beyond, right - down, confirm)


@dataclass
class AdjustmentRun(DialRun):
    """The adjustment of one exposure; made before the scene is drawn."""

    dial: Adjustment
    _confirmed: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        place, protocol = self.place, self.context.protocol
        self._condition = protocol.condition(place.condition or "", place.scene)
        self.at = self._first_place()
        self._value = self.dial.value_at(self.at)

    @property
    def value(self) -> float:
        """Return the value that is drawn."""
        return self._value

    @property
    def built_for(self) -> Condition:
        """Return the condition at the dial's maximum: its passes can show every value."""
        return self._with(self.dial.range[1])

    @property
    def ended(self) -> bool:
        """Return whether it is confirmed."""
        return self._confirmed

    @property
    def done(self) -> bool:
        """Return whether it is confirmed, and that ends the exposure."""
        return self._confirmed and self.context.protocol.exposure_ends == "adjustment"

    def show_start(self) -> None:
        """Show the value at which the dial begins, from the next frame on."""
        self.context.renderer.adjust(self._with(self.value))

    def begin(self) -> None:
        """Let a simulated participant begin."""
        if isinstance(self.context.respondent, SimulatedRespondent):
            self.context.respondent.start_adjustment(self.place.trial or 0, self.dial)

    def simulated(self, elapsed_s: float) -> Turn | None:
        """Return a simulated participant's turn; None for others."""
        respondent = self.context.respondent
        return (
            respondent.turn(self.at, elapsed_s)
            if isinstance(respondent, SimulatedRespondent)
            else None
        )

    def turned(self, turn: Turn, elapsed_s: float, passed_s: float) -> None:
        """Draw with the new value from this frame on, and record it."""
        del elapsed_s
        self.at = self.moved(turn, passed_s, self.dial.steps or KEY_STEPS)
        value = self.dial.value_at(self.at)
        if value != self.value:
            self._value = value
            self.context.renderer.adjust(self._with(value))
            self.write("change")
        if turn.confirm:
            self._confirmed = True
            self.write("confirmed")
            self.events.event_soon("adjusted", detail=f"{self.dial.name} confirmed at {value:g}")

    def _with(self, value: float) -> Condition:
        return adjusted(self._condition, self.dial.setting, value)

    def _first_place(self) -> float:
        """Return the dial's place at the start of the exposure, the same at each attempt."""
        start = self.dial.start
        if start == "setting":
            own = value_of(self._condition, self.dial.setting)
            return 0.0 if own is None else self.dial.place_of(own)
        if start == "random":
            return float(self.random(self.place.trial or 0).random())
        if start == "alternating":
            first = int(self.random(0).integers(2))
            return float((first + self._before()) % 2)
        return float(start == "descending")

    def _before(self) -> int:
        """Count the earlier exposures of the session with the same adjustment."""
        trials = self.context.sequence.sessions[self.events.session - 1]
        before = trials[: (self.place.trial or 1) - 1]
        known = [self.context.protocol.adjustment_in(trial.condition) for trial in before]
        return sum(each is not None and each.name == self.dial.name for each in known)


@dataclass
class SliderRun(DialRun):
    """The continuous rating of one exposure."""

    dial: Slider
    _next_s: float = field(default=0.0, init=False)
    _stick: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        instrument: Instrument = self.context.protocol.rated(self.dial)
        answers = instrument.asked[0].answers
        self._low, self._high = float(answers.low), float(answers.high)

    @property
    def value(self) -> float:
        """Return the rating."""
        return round(self._low + (self._high - self._low) * self.at, SLIDER_DIGITS)

    def begin(self) -> None:
        """Let a simulated participant begin."""
        self._next_s = 1 / self.dial.sample_hz
        if isinstance(self.context.respondent, SimulatedRespondent):
            self.context.respondent.start_slider(self.place.trial or 0)

    def simulated(self, elapsed_s: float) -> Turn | None:
        """Return no turn: a simulated participant sets the place itself."""
        del elapsed_s
        respondent = self.context.respondent
        if not isinstance(respondent, SimulatedRespondent):
            return None
        self.at = respondent.slide(self.at)
        return Turn(self._stick)

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame before it is drawn; a slider that is moved ticks at each whole answer."""
        before = round(self.value)
        super().step(frame, headset, elapsed_s, scene_time_s)
        moves = self.dial.stick == "rate" and round(self.value) != before
        if moves and isinstance(headset, HasHaptics):
            headset.tick(RIGHT_HAND)

    def turned(self, turn: Turn, elapsed_s: float, passed_s: float) -> None:
        """Move the slider, and record its place at the sampling rate."""
        if self.dial.stick == "rate":
            self.at = self.moved(turn, passed_s, SLIDER_KEY_STEPS)
        else:
            if turn.stick != self._stick:  # else the keys may have put it elsewhere
                self.at = max(turn.stick, 0.0)
            self._stick = turn.stick
            self.at = self.moved(Turn(steps=turn.steps), passed_s, SLIDER_KEY_STEPS)
        if elapsed_s >= self._next_s - 1e-9:
            self.write("sample")
            while self._next_s <= elapsed_s + 1e-9:
                self._next_s += 1 / self.dial.sample_hz


@dataclass
class Several:
    """Things that are done at once in an exposure."""

    parts: Sequence[Activity]

    @property
    def done(self) -> bool:
        """Return whether the exposure ends with one of them."""
        return any(part.done for part in self.parts)

    def demand(self, frame: Frame) -> Demand | None:
        """Return the first demand of the parts."""
        return next((found for part in self.parts if (found := part.demand(frame))), None)

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame before it is drawn."""
        for part in self.parts:
            part.step(frame, headset, elapsed_s, scene_time_s)

    def next_s(self) -> float | None:
        """Return when something happens next in one of them; None: in every frame."""
        times = [part.next_s() for part in self.parts]
        return None if None in times else min(each for each in times if each is not None)

    def changed(self) -> tuple[Shown, ...]:
        """Return the balls that are drawn otherwise than at the last call."""
        return tuple(ball for part in self.parts for ball in part.changed())

    def finish(self) -> None:
        """End with the exposure, however it ended."""
        for part in self.parts:
            part.finish()
