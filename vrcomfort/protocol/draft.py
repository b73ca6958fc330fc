"""Writes a commented protocol for a new study from a few answers."""

from __future__ import annotations

import re
from dataclasses import dataclass

from vrcomfort.errors import InputError
from vrcomfort.protocol.conditions import EFFECTS
from vrcomfort.questionnaire import Instrument
from vrcomfort.settings import did_you_mean, toml_value

BOTH, EACH = "both", "each"
"""Depth of field and motion blur: as two crossed factors, or as a condition each."""
BLURS = ("depth_of_field", "motion_blur")

_HEAD = """\
# {title}
#
# Written by `vrcomfort new`. Change what you like. Every key: `vrcomfort docs protocol_reference`.
# `vrcomfort check {file}` tells what is wrong, how long a session takes, and whether the blur can
# be seen.

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
label = {label}
"""

_CONDITION = """\

[[conditions]]
name = {name}
label = {label}
"""

_RAMPS = """\
speed_of = "avatar"            # locomotion alone; "head" or "both" as well
turning = { from_deg_s = 10.0, to_deg_s = 60.0 }
moving = { from_m_s = 0.2, to_m_s = 1.5 }
"""

_ON = {
    "depth_of_field": """\
[conditions.focus]
method = "nine_ray"    # what is sharp lies where the head points: `vrcomfort docs focus`
law = "linear_dioptre" # how focus moves to something new
[conditions.depth_of_field]
law = "dioptre"        # blur grows with the defocus in dioptres: `vrcomfort docs depth_of_field`
""",
    "motion_blur": """\
[conditions.motion_blur]
mode = "rotation_cancelled"   # turning the head blurs nothing: `vrcomfort docs motion_blur`
""",
    "vignette": """\
[conditions.vignette]          # a field of view that closes with speed: `vrcomfort docs effects`
"""
    + _RAMPS,
    "speed_blur": """\
[conditions.speed_blur]        # blur of the image that grows with speed: `vrcomfort docs effects`
"""
    + _RAMPS,
    "relocation_blur": """\
[conditions.relocation_blur]   # blur at cuts that sharpens with time: `vrcomfort docs effects`
snap_turns = true
""",
}
"""Effect → the settings that a new condition begins with."""


def _as_level(effect: str) -> str:
    """Return the settings of an effect as those of a factor's level."""
    return _ON[effect].replace("[conditions.", "[factors.levels.")


_BOTH = f"""\

# What is compared: two factors, crossed. They make the conditions sharp_still, sharp_moving, …
[[factors]]
name = "depth_of_field"
[[factors.levels]]
name = "sharp"
[[factors.levels]]
name = "dof"
{_as_level("depth_of_field")}
[[factors]]
name = "motion_blur"
[[factors.levels]]
name = "still"
[[factors.levels]]
name = "moving"
{_as_level("motion_blur")}"""

_ORDER = """\

# Who meets what in which order: each condition at each position, and after each other, equally
# often (`vrcomfort docs design`). `vrcomfort design {file}` prints the table.
[order]
rule = "williams"
sessions = {sessions}
"""

_ORDER_OF_DAYS = """\

# Who meets what in which order: in each session each condition at each position, and after each
# other, equally often (`vrcomfort docs design`). Exposures do not divide over the sessions: each
# shows all, in orders of its own. `vrcomfort design {file}` prints the table.
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

_QUESTIONNAIRE = """\

# {title}: before, and after each exposure.
[[questionnaires]]
instrument = {instrument}
timepoint = "baseline"
when = "session_start"

[[questionnaires]]
instrument = {instrument}
timepoint = "post"
when = "after_trial"
"""

_SCORE_RISE = """\

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
HIGH_SHARE = 0.75
"""Share of a rating scale from which on answers end an exposure."""


@dataclass(frozen=True)
class DraftCondition:
    """A condition besides the one without effects.

    Parameters
    ----------
    effects
        Effect → its settings besides those that every new condition has, as lines of TOML.
    """

    name: str
    label: str
    effects: dict[str, list[str]]

    @classmethod
    def of_text(cls, text: str) -> DraftCondition:
        """Read ``EFFECT``, ``EFFECT.SETTING=VALUE``, or several of them joined by ``+``.

        Raises
        ------
        InputError
            If there is no such effect.
        """
        effects: dict[str, list[str]] = {}
        for part in text.split("+"):
            path, equals, value = (each.strip() for each in part.partition("="))
            effect, _, setting = path.partition(".")
            if effect not in EFFECTS:
                known = did_you_mean(effect, [*EFFECTS, BOTH, EACH])
                raise InputError(f"--compare {text}: there is no effect `{effect}`; {known}")
            if bool(setting) != bool(equals and value):
                raise InputError(f"--compare {text}: a setting is EFFECT.SETTING=VALUE")
            effects.setdefault(effect, [])
            if setting:
                effects[effect].append(f"{setting} = {_toml(value)}")
        label = ", ".join(
            f"{effect.replace('_', ' ')}{' (' * bool(lines)}{', '.join(lines)}{')' * bool(lines)}"
            for effect, lines in effects.items()
        )
        name = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
        return cls(name, f"{label[0].upper()}{label[1:]}", effects)

    def toml(self) -> str:
        """Return its table."""
        parts = [_CONDITION.format(name=toml_value(self.name), label=toml_value(self.label))]
        for effect, lines in self.effects.items():
            written = {line.partition(" = ")[0] for line in lines}
            begun = _ON[effect].splitlines()
            kept = [each for each in begun if each.partition(" = ")[0].strip() not in written]
            parts.append("\n".join([*kept, *lines]) + "\n")
        return "".join(parts)


def _toml(value: str) -> str:
    """Return a value as TOML has it: numbers, booleans, tables and texts in quotes stay."""
    is_toml = re.fullmatch(r"[+-]?[\d.]+(e[+-]?\d+)?|true|false|[\[{\"'].*", value)
    return value if is_toml else toml_value(value)


@dataclass(frozen=True)
class ProtocolDraft:
    """The answers given to `vrcomfort new`.

    Parameters
    ----------
    compared
        The conditions besides the one without effects; none: depth of field and motion blur as
        crossed factors.
    break_s
        Between two exposures of a session.
    questionnaires
        Name or file, as the protocol calls it, and instrument.
    sessions
        Over which each participant's exposures are distributed.
    rating
        Name or file, and instrument, of the question during exposure; None for none.
    languages
        Blank where instruments keep their own.
    unbalanced
        Whether the number of participants stays, though it does not balance the orders.
    """

    name: str
    title: str
    compared: tuple[DraftCondition, ...]
    scenes: tuple[str, ...]
    participants: int
    exposure_s: float
    break_s: float
    sessions: int
    questionnaires: tuple[tuple[str, Instrument], ...]
    rating: tuple[str, Instrument] | None
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
        return len(self.compared) + 1 if self.compared else 4

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
                break_s=self.break_s if in_a_day > 1 else 0.0,
                scenes=toml_value(self.scenes),
            )
        ]
        if self.languages:
            given = toml_value(self.languages)
            parts.append(_LANGUAGES.format(last=self.languages[-1], languages=given))
        parts.append(self._conditions())
        parts += self._order(file)
        parts += [
            _QUESTIONNAIRE.format(title=each.title, instrument=toml_value(called))
            for called, each in self.questionnaires
        ]
        if any(each.name == "ssq" for _, each in self.questionnaires):
            parts.append(_SCORE_RISE)
        if self.rating and self.has_time_for_ratings:
            called, asked = self.rating
            every_s, timeout_s = self.rating_times_s
            parts.append(
                _RATING.format(
                    instrument=toml_value(called),
                    every_s=every_s,
                    timeout_s=timeout_s,
                    stop_at=high_answer(asked),
                )
            )
        return "".join([*parts, _SIMULATION])

    def _order(self, file: str) -> list[str]:
        unbalanced = _UNBALANCED if self.unbalanced else ""
        if self.divides:
            return [_ORDER.format(file=file, sessions=self.sessions), unbalanced]
        days = [_DAY.format(number=number) for number in range(1, self.sessions + 1)]
        return [_ORDER_OF_DAYS.format(file=file), unbalanced, *days]

    def _conditions(self) -> str:
        if not self.compared:
            return _BOTH
        of_blur = all(set(each.effects) <= {*BLURS} for each in self.compared)
        off = _OFF.format(label=toml_value("No blur" if of_blur else "No effect"))
        return off + "".join(each.toml() for each in self.compared)


def high_answer(rating: Instrument) -> int:
    """Return the answer from which on an exposure ends."""
    return int(rating.low + HIGH_SHARE * (rating.high - rating.low))
