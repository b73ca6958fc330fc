"""Continuous ratings: a slider that stands, all through an exposure, where it feels right."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.settings import Settings, Word


class Dial(Settings):
    """What participants turn: up and down on the right thumb-stick, or with the arrow keys."""

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
    """What the thumb-stick does. `place`: it is the slider; at rest that is the lowest answer, at
    its upper end the highest. `rate`: it moves the slider up and down, which then stays."""
    sample_hz: Annotated[float, Field(ge=0.1, le=100)] = 2.0
    """So often its place is kept."""
