"""What participants are asked: questionnaires at moments, and ratings during exposure."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from vrcomfort.protocol.conditions import Seconds
from vrcomfort.settings import Settings, Word

Rest = Annotated[float, Field(ge=0, le=86_400)]
"""Seconds, up to a day."""


class Ask(Settings):
    """A questionnaire and the moment at which it is asked."""

    instrument: str = "ssq"
    """A shipped instrument by name, or a TOML file relative to the protocol file."""
    language: Word | None = None
    """Of the wording, where the instrument has it in several; its own without it."""
    timepoint: Word
    """Of the answers in files: `baseline`, `post`, `recovery`, or a word of your own."""
    when: Literal["session_start", "before_trial", "after_trial", "session_end"]
    """`before_trial` and `after_trial`: of every exposure."""
    wait_s: Rest = 0.0
    """Rest without the headset before asking."""
    compares: Literal["pair", "session", "study"] | None = None
    """For instruments whose answers 1, 2, … are the first, the second, … way of rendering (0: no
    preference): `pair`, the two exposures before, asked after every second one of a session;
    `session` and `study`, the conditions of the session, or of all until then, as first met."""


Unfocused: TypeAlias = Literal["pause", "flag"]


class Ratings(Settings):
    """A single-item scale answered during exposure."""

    instrument: str = "fms"
    """A shipped instrument with one question by name, or a TOML file of one."""
    every_s: Seconds = 60.0
    """From one question to the next."""
    jitter_s: Annotated[float, Field(ge=0, le=7200)] = 0.0
    """Each question comes up to so much sooner or later, drawn from the study's seed."""
    timeout_s: Seconds = 15.0
    """An answer that has not come by then is recorded as missed."""
    missed_code: Annotated[int, Field(ge=1, le=9999)] = 1
    """What the column `missed` has then; 0 is an answer."""
    stop_at: Annotated[int, Field(ge=1, le=1000)] | None = None
    """The stop rule: answers this high end what `stop_ends` says."""
    stop_in_a_row: Annotated[int, Field(ge=1, le=100)] = 1
    """So many of an exposure's answers, one after the other; missed ones do not count."""
    stop_ends: Literal["exposure", "session", "study"] = "study"
    """`exposure`: the session goes on after its questions. `session`: the participant may come back
    for the next. `study`: the participant's study."""
