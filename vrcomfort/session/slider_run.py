"""A continuous rating in an exposure: where its slider stands, again and again."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from vrcomfort.frame import Frame
from vrcomfort.protocol.sliders import Slider
from vrcomfort.questionnaire import Instrument
from vrcomfort.respondent.turning import Turn
from vrcomfort.session.dial_run import DialRun

KEY_STEPS = 20
"""Presses of an arrow key that take a slider through its range."""
RIGHT = 1
DIGITS = 3
"""Of a place on the scale."""


@runtime_checkable
class Slides(Protocol):
    """A respondent who moves a slider without hands: a simulated participant."""

    def start_slider(self, trial: int) -> None:
        """Begin to rate."""

    def slide(self, place: float) -> float:
        """Return where they put the slider, which is at a place (0 to 1) of its range."""


@runtime_checkable
class Ticks(Protocol):
    """A headset whose controllers can be felt."""

    def tick(self, hand: int) -> None:
        """Let a controller tick (0 left, 1 right)."""


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
        return round(self._low + (self._high - self._low) * self.at, DIGITS)

    def begin(self) -> None:
        """Let a simulated participant begin."""
        self._next_s = 1 / self.dial.sample_hz
        if isinstance(self.context.respondent, Slides):
            self.context.respondent.start_slider(self.place.trial or 0)

    def simulated(self, elapsed_s: float) -> Turn | None:
        """Return that nobody turns it: a simulated participant puts it somewhere."""
        del elapsed_s
        respondent = self.context.respondent
        if not isinstance(respondent, Slides):
            return None
        self.at = respondent.slide(self.at)
        return Turn(self._stick)

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame before it is drawn; a slider that is moved ticks at each whole answer."""
        before = round(self.value)
        super().step(frame, headset, elapsed_s, scene_time_s)
        moves = self.dial.stick == "rate" and round(self.value) != before
        if moves and isinstance(headset, Ticks):
            headset.tick(RIGHT)

    def turned(self, turn: Turn, elapsed_s: float, passed_s: float) -> None:
        """Move the slider, and keep where it is when it is time."""
        if self.dial.stick == "rate":
            self.at = self.moved(turn, passed_s, KEY_STEPS)
        else:
            if turn.stick != self._stick:  # else the keys may have put it elsewhere
                self.at = max(turn.stick, 0.0)
            self._stick = turn.stick
            self.at = self.moved(Turn(steps=turn.steps), passed_s, KEY_STEPS)
        if elapsed_s >= self._next_s - 1e-9:
            self.write("sample")
            while self._next_s <= elapsed_s + 1e-9:
                self._next_s += 1 / self.dial.sample_hz
