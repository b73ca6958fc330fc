"""Writes a commented protocol for a new study from a few answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from vrcomfort.settings import toml_value

Compared: TypeAlias = Literal["depth_of_field", "motion_blur", "both", "each"]

_HEAD = """\
# {title}
#
# Written by `vrcomfort new`. Change what you like: every key is in docs/protocol_reference.md, and
# `vrcomfort check {file}` tells what is wrong, how long a session takes, and
# whether the blur can be seen.

name = {name}
title = {title_text}
participants = {participants}     # planned; `check` says whether they balance the orders

exposure_s = {exposure_s:.1f}   # each scene, under each condition, is shown so long
training_s = 60.0     # before the first exposure: to learn the controls
break_s = {break_s:.1f}       # between two exposures of a session

scenes = {scenes}
"""

_LANGUAGES = """\

# In which participants can be asked, the usual one first: `vrcomfort run … --language {last}`.
languages = {languages}
"""

_OFF = """\

# What is compared. Participants meet every condition in every scene.
[[conditions]]
name = "off"
label = "No blur"
"""

_ON = {
    "depth_of_field": """\

[[conditions]]
name = "depth_of_field"
label = "Depth of field"
[conditions.focus]
method = "nine_ray"    # what is sharp lies where the head points: docs/focus.md
law = "linear_dioptre" # how focus moves to something new
[conditions.depth_of_field]
law = "dioptre"        # blur grows with the defocus in dioptres: docs/depth_of_field.md
""",
    "motion_blur": """\

[[conditions]]
name = "motion_blur"
label = "Motion blur"
[conditions.motion_blur]
mode = "rotation_cancelled"   # turning the head blurs nothing: docs/motion_blur.md
""",
}

_BOTH = """\

# What is compared: two factors, crossed. They make the conditions sharp_still, sharp_moving, …
[[factors]]
name = "depth_of_field"
[[factors.levels]]
name = "sharp"
[[factors.levels]]
name = "dof"
[factors.levels.focus]
method = "nine_ray"    # what is sharp lies where the head points: docs/focus.md
law = "linear_dioptre" # how focus moves to something new
[factors.levels.depth_of_field]
law = "dioptre"        # blur grows with the defocus in dioptres: docs/depth_of_field.md

[[factors]]
name = "motion_blur"
[[factors.levels]]
name = "still"
[[factors.levels]]
name = "moving"
[factors.levels.motion_blur]
mode = "rotation_cancelled"   # turning the head blurs nothing: docs/motion_blur.md
"""

_ORDER = """\

# Who meets what in which order: each condition at each position, and after each other, equally
# often (docs/design.md). `vrcomfort design {file}` prints the table.
[order]
rule = "williams"
sessions = {sessions}
"""

_ORDER_OF_DAYS = """\

# Who meets what in which order: in each session each condition at each position, and after each
# other, equally often (docs/design.md). Exposures do not divide over the sessions: each shows all,
# in orders of its own. `vrcomfort design {file}` prints the table.
[order]
rule = "parts"
"""

_DAY = """\

[[parts]]
name = "session_{number}"
session = {number}
rule = "williams"
"""

_UNBALANCED = """\
unbalanced = true     # meant: the number of participants does not balance the orders
"""

_QUESTIONS = """\

# The Simulator Sickness Questionnaire: before, after each exposure, and at the end.
[[questionnaires]]
instrument = "ssq"
timepoint = "baseline"
when = "session_start"

[[questionnaires]]
instrument = "ssq"
timepoint = "post"
when = "after_trial"

# Whose score has risen so far goes home, and may come back another day.
[[stop.score_rise]]
instrument = "ssq"
scale = "T"
by = 60.0
ends = "session"
"""

_RATING = """\

# One question during exposure, again and again. Two answers this high end the exposure.
[[ratings]]
instrument = {instrument}
every_s = {every_s:.1f}
timeout_s = {timeout_s:.1f}
stop_at = {stop_at}
stop_in_a_row = 2
stop_ends = "exposure"
"""

_SIMULATION = """\

# How simulated participants feel (`vrcomfort simulate`): assumptions, for trying the analysis.
[simulation]
rate_per_min = 0.06
"""

ANSWER_S = (10.0, 15.0)
"""Time to answer a rating: at least, and usually."""
EVERY_S = (20.0, 60.0)
"""From one rating to the next: at least, and usually."""
HIGH = {"fms": 15, "misc": 7}
"""Rating instrument → the answer that ends an exposure."""


@dataclass(frozen=True)
class ProtocolDraft:
    """The answers given to `vrcomfort new`.

    Parameters
    ----------
    sessions
        Over which each participant's exposures are dealt.
    rating
        Instrument of the question during exposure; blank for none.
    languages
        Blank where instruments keep their own.
    unbalanced
        Whether the number of participants stays, though it does not balance the orders.
    """

    name: str
    title: str
    compared: Compared
    scenes: tuple[str, ...]
    participants: int
    exposure_s: float
    sessions: int
    rating: str
    languages: tuple[str, ...]
    unbalanced: bool = False

    @property
    def rating_times_s(self) -> tuple[float, float]:
        """Return from one rating to the next, and how long there is to answer it."""
        every_s = min(max(self.exposure_s / 4, EVERY_S[0]), EVERY_S[1])
        return every_s, min(max(every_s / 4, ANSWER_S[0]), ANSWER_S[1])

    @property
    def has_time_for_ratings(self) -> bool:
        """Return whether an exposure is long enough for one rating and its answer."""
        return sum(self.rating_times_s) <= self.exposure_s

    @property
    def conditions(self) -> int:
        """Return how many conditions are compared."""
        return {"both": 4, "each": 3}.get(self.compared, 2)

    @property
    def exposures(self) -> int:
        """Return how many pairs of condition and scene there are."""
        return self.conditions * len(self.scenes)

    @property
    def divides(self) -> bool:
        """Return whether the pairs divide over the sessions; else each session shows all."""
        return self.exposures % self.sessions == 0

    def toml(self) -> str:
        """Return the commented text."""
        file = f"{self.name}.toml"
        in_a_day = self.exposures // self.sessions if self.divides else self.exposures
        parts = [
            _HEAD.format(
                title=self.title,
                file=file,
                name=toml_value(self.name),
                title_text=toml_value(self.title),
                participants=self.participants,
                exposure_s=self.exposure_s,
                break_s=600.0 if in_a_day > 1 else 0.0,
                scenes=toml_value(self.scenes),
            )
        ]
        if self.languages:
            given = toml_value(self.languages)
            parts.append(_LANGUAGES.format(last=self.languages[-1], languages=given))
        parts += [self._compared(), *self._order(file), _QUESTIONS]
        if self.rating and self.has_time_for_ratings:
            every_s, timeout_s = self.rating_times_s
            parts.append(
                _RATING.format(
                    instrument=toml_value(self.rating),
                    every_s=every_s,
                    timeout_s=timeout_s,
                    stop_at=HIGH[self.rating],
                )
            )
        return "".join([*parts, _SIMULATION])

    def _compared(self) -> str:
        if self.compared == "both":
            return _BOTH
        return _OFF + "".join(_ON.values() if self.compared == "each" else [_ON[self.compared]])

    def _order(self, file: str) -> list[str]:
        unbalanced = _UNBALANCED if self.unbalanced else ""
        if self.divides:
            return [_ORDER.format(file=file, sessions=self.sessions), unbalanced]
        days = [_DAY.format(number=number) for number in range(1, self.sessions + 1)]
        return [_ORDER_OF_DAYS.format(file=file), unbalanced, *days]
