"""Questions to participants, and rules on their answers: the tables of a protocol."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Literal, Protocol, Self, TypeAlias

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from vrcomfort.protocol.conditions import Seconds
from vrcomfort.protocol.order import Covariate
from vrcomfort.questionnaire import Instrument
from vrcomfort.settings import KeyPath, Problem, Settings, Word, did_you_mean

Rest = Annotated[float, Field(ge=0, le=86_400)]
"""Seconds, up to a day."""


Number = Annotated[int, Field(ge=1, le=1000)]


class HasMoment(Protocol):
    """A question or an instruction, in some of the sessions and after some of their trials."""

    @property
    def when(self) -> str:
        """Return the moment."""

    @property
    def sessions(self) -> tuple[int, ...]:
        """Return the numbers of its sessions; none: all."""

    @property
    def trials(self) -> tuple[int, ...]:
        """Return the numbers of its trials within a session; none: all."""


def is_due(each: HasMoment, when: str, session: int, trial: int | None) -> bool:
    """Return whether a moment of a session is that of a question or an instruction."""
    here = each.when == when and (not each.sessions or session in each.sessions)
    return here and (not each.trials or trial in each.trials)


def moment_problems(key: str, questions: Sequence[HasMoment]) -> Iterator[Problem]:
    """Yield numbers of trials at moments that belong to no trial."""
    for index, each in enumerate(questions):
        if each.trials and each.when.startswith("session"):
            message = f'`trials` does nothing with when = "{each.when}"; remove it or change that'
            yield Problem((key, index, "trials"), message)


class Ask(Settings):
    """A questionnaire and the moment at which it is asked."""

    instrument: str = "ssq"
    """A shipped instrument by name, or a TOML file relative to the protocol file."""
    language: Word | None = None
    """Of the wording, where the instrument has it in several; its own without it."""
    timepoint: Word
    """Of the answers in files: `baseline`, `post`, `recovery`, or a word of your own."""
    when: Literal["session_start", "before_trial", "after_trial", "session_end"]
    """`before_trial` and `after_trial`: of every exposure, or of those in `trials`."""
    sessions: tuple[Number, ...] = ()
    """Numbers of the sessions in which it is asked; without it, all."""
    trials: tuple[Number, ...] = ()
    """Numbers, within the session, of the trials that it belongs to; without it, all."""
    wait_s: Rest = 0.0
    """Rest without the headset before asking."""
    compares: Literal["pair", "session", "study"] | None = None
    """For instruments whose answers 1, 2, … are the first, the second, … way of rendering (0: no
    preference): `pair`, the two exposures before, asked after every second one of a session;
    `session` and `study`, the conditions of the session, or of all until then, in the order of
    their first exposure."""


Unfocused: TypeAlias = Literal["pause", "flag"]


class Ratings(Settings):
    """A single-item scale answered during exposure."""

    instrument: str = "fms"
    """A shipped instrument with one question by name, or a TOML file of one."""
    every_s: Seconds = 60.0
    """From one question to the next."""
    jitter_s: Annotated[float, Field(ge=0, le=7200)] = 0.0
    """Largest shift of each question, sooner or later, drawn from the study's seed."""
    timeout_s: Seconds = 15.0
    """An answer that has not come by then is recorded as missed."""
    at_start: bool = False
    """Whether a question comes with the beginning of the exposure, too."""
    at_end: bool = False
    """Whether a last question comes when only the time to answer it is left."""
    missed_code: Annotated[int, Field(ge=1, le=9999)] = 1
    """Code of a missed rating in the column `missed`; 0 is an answer."""
    stop_at: Annotated[int, Field(ge=1, le=1000)] | None = None
    """The stop rule: answers this high end the exposure, session or study (`stop_ends`)."""
    stop_in_a_row: Annotated[int, Field(ge=1, le=100)] = 1
    """Number of such answers in an exposure, one after the other; missed ones do not count."""
    stop_ends: Literal["exposure", "session", "study"] = "study"
    """`exposure`: the session goes on after its questions. `session`: the participant may come back
    for the next. `study`: the participant's study."""

    def due_times(self, duration_s: float, rng: np.random.Generator) -> list[float]:
        """Return when a question is due: as long as the time to answer lies within an exposure."""
        last_s = duration_s - self.timeout_s
        count = max(int(last_s / self.every_s + 1e-9), 0)
        shifts = rng.uniform(-self.jitter_s, self.jitter_s, count + 1).round(3)
        times = [self.every_s * (n + 1) + float(shift) for n, shift in enumerate(shifts)]
        asked = [due for due in times if due <= last_s]
        if self.at_end and last_s > 0:
            asked = [*(due for due in asked if due + self.timeout_s <= last_s), last_s]
        return [0.0, *asked] if self.at_start else asked

    def problems(self, longest_s: float) -> Iterator[Problem]:
        """Yield keys that do not go with each other, or with the longest exposure."""
        if self.every_s + self.timeout_s > longest_s:
            message = "no rating fits into an exposure: every_s + timeout_s is more than exposure_s"
            yield Problem((), f"{message}; shorten them, or remove [[ratings]]")
        if self.jitter_s > self.every_s / 2:
            message = "two questions could change places: `jitter_s` is more than half of `every_s`"
            yield Problem(("jitter_s",), f"{message}; make it smaller")
        if self.at_start and self.every_s - self.jitter_s < self.timeout_s:
            message = "the second question could come while the first is still open"
            yield Problem(("at_start",), f"{message}; make `every_s` longer, or `jitter_s` shorter")
        for key in sorted({"stop_in_a_row", "stop_ends"} & self.model_fields_set):
            if self.stop_at is None:
                message = f"`{key}` does nothing without `stop_at`; remove it or add that"
                yield Problem((key,), message)


def asked_at_least(ratings: Sequence[Ratings], duration_s: float) -> list[tuple[int, int]]:
    """Return how often each question is due in an exposure, and how often it is asked at least.

    A question waits until the one before it is answered. At worst that takes its whole
    `timeout_s`; what still waits when the exposure ends is never asked.
    """
    rng = np.random.default_rng(0)
    due = [each.due_times(duration_s, rng) for each in ratings]
    asked, free_s = [0] * len(due), 0.0
    while waiting := [(times[asked[n]], n) for n, times in enumerate(due) if asked[n] < len(times)]:
        due_s, n = min(waiting)
        begins_s = max(due_s, free_s)
        if begins_s >= duration_s:
            break
        asked[n] += 1
        free_s = begins_s + ratings[n].timeout_s
    return [(len(times), count) for times, count in zip(due, asked, strict=True)]


Asked = Annotated[str, Field(min_length=1, max_length=300)]


class FreeText(Settings):
    """A question that is answered in one's own words, which an experimenter types."""

    name: Word
    """As ``texts.csv`` has it."""
    text: Asked
    """The question, in the usual language."""
    when: Literal["session_start", "before_trial", "after_trial", "session_end"]
    """After the questionnaires of that moment; `before_trial` and `after_trial`: of every
    exposure, or of those in `trials`."""
    sessions: tuple[Number, ...] = ()
    """Numbers of the sessions in which it is asked; without it, all."""
    trials: tuple[Number, ...] = ()
    """Numbers, within the session, of the trials that it belongs to; without it, all."""


def free_text_problems(
    questions: tuple[FreeText, ...],
    languages: tuple[str, ...],
    wordings: Mapping[str, Mapping[str, str]],
) -> Iterator[Problem]:
    """Yield faults of free texts: blank questions, missing wordings, wordings of nothing.

    Parameters
    ----------
    languages
        In which participants are asked, the usual one first.
    wordings
        Language → name → what is asked in it.
    """
    names = [each.name for each in questions]
    for index, each in enumerate(questions):
        if not each.text.strip():
            path: KeyPath = ("free_texts", index, "text")
            yield Problem(path, f"`{each.name}` has an empty question; write its `text`")
    for language in languages[1:]:
        for index, name in enumerate(names):
            if name not in wordings.get(language, {}):
                message = f"`{name}` is not worded in `{language}`"
                path = ("free_texts", index, "text")
                yield Problem(path, f"{message}; write it into [text.{language}.free_texts]")
    for language, given in wordings.items():
        for name in given:
            if name not in names:
                hint = did_you_mean(name, names) if names else "remove it"
                message = f"there is no free text `{name}`; {hint}"
                yield Problem(("text", language, "free_texts", name), message)


Bound = Annotated[float, Field(ge=-1e6, le=1e6)]


class Screening(Settings):
    """A number that is told before the first exposure, and decided upon by the experimenter."""

    instrument: str | None = None
    """Asked at the session's start: its score."""
    scale: str | None = None
    """Of the instrument; without it, the one that is reported first."""
    covariate: str | None = None
    """Instead of an instrument: a number that was entered at the enrolment."""
    above: Bound | None = None
    """Told where the number is more."""
    below: Bound | None = None
    """Told where it is less."""
    ends: Literal["session", "study"] = "study"
    """Scope of a stop by the experimenter; after `session` they may come back for the next."""

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if (self.instrument is None) == (self.covariate is None):
            message = "needs an `instrument` or a `covariate`, one of the two"
            raise PydanticCustomError("screening_what", message)
        if self.above is None and self.below is None:
            message = "needs a bound; give `above` or `below`"
            raise PydanticCustomError("screening_bounds", message)
        if self.above is not None and self.below is not None and self.below > self.above:
            message = "every number is above the one or below the other; swap `above` and `below`"
            raise PydanticCustomError("screening_bounds", message)
        return self

    def broken(self, number: float) -> str | None:
        """Return the bound that a number is beyond, in words; None where it is within."""
        if self.above is not None and number > self.above:
            return f"above {self.above:g}"
        if self.below is not None and number < self.below:
            return f"below {self.below:g}"
        return None


def screening_problems(
    rules: tuple[Screening, ...],
    at_start: set[str],
    instruments: Mapping[str, Instrument],
    covariates: tuple[Covariate, ...],
) -> Iterator[Problem]:
    """Yield faults of screening rules that cannot be evaluated.

    Parameters
    ----------
    at_start
        Instruments that are asked at the session's start.
    """
    for index, rule in enumerate(rules):
        path: KeyPath = ("screening", index)
        if rule.instrument is not None:
            yield from _of_instrument(rule, rule.instrument, path, at_start, instruments)
        else:
            yield from _of_covariate(str(rule.covariate), path, covariates)


def _of_instrument(
    rule: Screening,
    name: str,
    path: KeyPath,
    at_start: set[str],
    instruments: Mapping[str, Instrument],
) -> Iterator[Problem]:
    if name not in at_start:
        message = f"`{name}` is not asked at session_start; ask it in [[questionnaires]]"
        yield Problem((*path, "instrument"), message)
        return
    scales = [scale.name for scale in instruments[name].scales]
    if rule.scale is not None and rule.scale not in scales:
        message = f"the {instruments[name].short} has no scale `{rule.scale}`"
        yield Problem((*path, "scale"), f"{message}; {did_you_mean(rule.scale, scales)}")


def _of_covariate(name: str, path: KeyPath, covariates: tuple[Covariate, ...]) -> Iterator[Problem]:
    known = {each.name: each for each in covariates}
    if name not in known:
        hint = did_you_mean(name, known) if known else "declare it in [[covariates]]"
        yield Problem((*path, "covariate"), f"there is no covariate `{name}`; {hint}")
    elif known[name].levels:
        message = f"`{name}` is one of {', '.join(known[name].levels)}, and no number"
        yield Problem((*path, "covariate"), f"{message}; screen by one that is")


class ScoreRise(Settings):
    """A score that has risen too far over that of the session's start."""

    instrument: str = "ssq"
    """Asked at the session's start and after exposures."""
    scale: str = "T"
    """Of the instrument."""
    by: Annotated[float, Field(gt=0, le=1e6)]
    """Rise over the first score of the session, after a trial, at which session or study end
    (`ends`)."""
    ends: Literal["session", "study"] = "session"
    """`session`: the participant may come back for the next. `study`: the participant's study."""


class Stopping(Settings):
    """Rules that end a session, or a participant's study; [[ratings]] have rules of their own."""

    participant: Literal["session", "study"] = "study"
    """Scope of a participant's wish to stop; after `session` they may come back for the next."""
    score_rise: tuple[ScoreRise, ...] = ()
    """Rules on scores of questionnaires."""


def rise_problems(
    stop: Stopping, whens: Mapping[str, set[str]], instruments: Mapping[str, Instrument]
) -> list[Problem]:
    """Return the faults of rules on scores.

    Parameters
    ----------
    whens
        Instrument → when it is asked.
    """
    found: list[Problem] = []
    for index, rule in enumerate(stop.score_rise):
        path = ("stop", "score_rise", index)
        asked = whens.get(rule.instrument, set())
        if not {"session_start", "after_trial"} <= asked:
            message = f"`{rule.instrument}` is not asked both at session_start and after_trial"
            found.append(Problem((*path, "instrument"), f"{message}; ask it in [[questionnaires]]"))
            continue
        scales = [scale.name for scale in instruments[rule.instrument].scales]
        if rule.scale not in scales:
            message = f"the {instruments[rule.instrument].short} has no scale `{rule.scale}`"
            hint = did_you_mean(rule.scale, scales)
            found.append(Problem((*path, "scale"), f"{message}; {hint}"))
    return found
