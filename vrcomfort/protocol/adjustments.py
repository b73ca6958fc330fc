"""Adjustments: settings and ratings that participants dial (method of adjustment)."""

from __future__ import annotations

import math
from typing import Annotated, Literal, TypeVar

from pydantic import BaseModel, Field

from vrcomfort.protocol.conditions import Condition
from vrcomfort.protocol.marks import live_settings
from vrcomfort.settings import Settings, Word


class Dial(Settings):
    """A dial: turned up and down on the right thumb-stick, or with the arrow keys."""

    name: Word
    """Of the dial, in ``dials.csv`` and in reports."""
    sweep_s: Annotated[float, Field(ge=0.1, le=3600)] = 5.0
    """Time from one end of the range to the other with the thumb-stick at its end."""
    conditions: tuple[str, ...] = ()
    """In which it is there; without it, in all in which it can be."""


class Slider(Dial):
    """A rating that is given all the time: the slider is moved whenever something has changed."""

    instrument: str = "fms"
    """A shipped instrument with one question by name, or a TOML file of one: its range."""
    stick: Literal["place", "rate"] = "place"
    """Effect of the thumb-stick. `place`: it is the slider; at rest that is the lowest answer, at
    its upper end the highest. `rate`: it moves the slider up and down, which then stays."""
    sample_hz: Annotated[float, Field(ge=0.1, le=100)] = 2.0
    """Rate at which the slider's place is recorded."""


Number = Annotated[float, Field(ge=-1e9, le=1e9)]
Table = TypeVar("Table", bound=BaseModel)

ADJUSTABLE = tuple(live_settings(Condition))
"""Settings that passes take up between two frames: those marked `LIVE`. The others decide which
passes, textures and shaders there are, and cannot change during an exposure. Passes are built for
the largest value of a dial's range."""


class Adjustment(Dial):
    """A setting of the condition that participants adjust during exposure, and confirm."""

    setting: str
    """As in a condition: `depth_of_field.full_blur_dioptre`."""
    range: tuple[Number, Number]
    """[lowest, highest] value; up on the dial is towards the second."""
    scale: Literal["linear", "log"] = "linear"
    """`log`: equal turns multiply equally."""
    steps: Annotated[int, Field(ge=1, le=10_000)] | None = None
    """Equal steps in the range, on its scale; without it the dial is continuous. An arrow key goes
    a step, or a hundredth of a continuous range."""
    start: Literal["random", "ascending", "descending", "alternating", "setting"] = "random"
    """`random`: anywhere in the range, by the seed; `ascending`: at its lowest value; `descending`:
    at its highest; `alternating`: one and the other by turns in the exposures of a session that
    have it, the first drawn for each participant; `setting`: at the condition's own."""

    def value_at(self, place: float) -> float:
        """Return the value at a place of the dial, 0 (lowest) to 1, in whole steps."""
        if self.steps is not None:
            place = round(place * self.steps) / self.steps
        low, high = self.range
        if place in (0.0, 1.0):
            return high if place else low
        if self.scale == "log":
            return float(f"{low * (high / low) ** place:.9g}")
        return float(f"{low + (high - low) * place:.9g}")

    def place_of(self, value: float) -> float:
        """Return the place of the dial, 0 to 1, that has a value."""
        low, high = self.range
        if self.scale == "log":
            return math.log(value / low) / math.log(high / low)
        return (value - low) / (high - low)


def value_of(condition: Condition, setting: str) -> float | None:
    """Return the number that a condition has there; None where it lacks the table, or the number.

    Raises
    ------
    AttributeError
        If no condition has such a setting.
    """
    found: object = condition
    for part in setting.split("."):
        if found is None:
            return None
        found = getattr(found, part)
    return float(found) if isinstance(found, int | float) else None


def adjusted(condition: Condition, setting: str, value: float) -> Condition:
    """Return a condition with another value of one setting, unchecked."""
    return _with(condition, setting.split("."), value)


def _with(table: Table, path: list[str], value: float) -> Table:
    name, *rest = path
    inner = _with(getattr(table, name), rest, value) if rest else value
    return table.model_copy(update={name: inner})
