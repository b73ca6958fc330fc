"""An adjustment in an exposure: its dial changes the condition that is drawn."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from vrcomfort.protocol import Condition
from vrcomfort.protocol.adjustments import Adjustment, adjusted, value_of
from vrcomfort.respondent.turning import Turn
from vrcomfort.session.dial_run import KEY_STEPS, DialRun


@runtime_checkable
class Adjusts(Protocol):
    """A respondent who adjusts without hands: a simulated participant."""

    def start_adjustment(self, trial: int, adjustment: Adjustment) -> None:
        """Begin to adjust."""

    def turn(self, place: float, time_s: float) -> Turn:
        """Return what they do to the dial, which is at a place (0 to 1) of its range."""


@dataclass
class AdjustmentRun(DialRun):
    """The adjustment of one exposure; made before the scene is drawn."""

    dial: Adjustment
    _confirmed: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        self._condition = self.context.protocol.condition(self.place.condition or "")
        self.at = self._first_place()
        self._value = self.dial.value_at(self.at)

    @property
    def value(self) -> float:
        """Return the value that is drawn."""
        return self._value

    @property
    def built_for(self) -> Condition:
        """Return the condition whose passes can show every value: at 0 there may be none."""
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
        if isinstance(self.context.respondent, Adjusts):
            self.context.respondent.start_adjustment(self.place.trial or 0, self.dial)

    def simulated(self, elapsed_s: float) -> Turn | None:
        """Return what a simulated participant does to it; None of others."""
        respondent = self.context.respondent
        return respondent.turn(self.at, elapsed_s) if isinstance(respondent, Adjusts) else None

    def turned(self, turn: Turn, elapsed_s: float, passed_s: float) -> None:
        """Draw by what the dial says from this frame on, and keep it."""
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
        """Return where the dial stands when the exposure begins: the same at each attempt."""
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
        """Return how many exposures of the session before this one have the same adjustment."""
        trials = self.context.sequence.sessions[self.events.session - 1]
        before = trials[: (self.place.trial or 1) - 1]
        known = [self.context.protocol.adjustment_in(trial.condition) for trial in before]
        return sum(each is not None and each.name == self.dial.name for each in known)
