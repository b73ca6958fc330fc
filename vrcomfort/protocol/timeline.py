"""The timeline of a session: its steps in their order, as data.

A session runs these steps one after the other; the remaining time is estimated from them, and the
operator's console lists them. Only what nobody can know beforehand is decided at run time: a step
that an operator skips or repeats, a withdrawal, a criterion that practice does not reach.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias

from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order import Sequence
from vrcomfort.protocol.questions import Ask, FreeText
from vrcomfort.protocol.session_steps import (
    Breaks,
    GazeValidation,
    Instruction,
    Posture,
    Practice,
    When,
)

# First guesses: `SessionTime` corrects each kind of step by the steps of the session so far.
ITEM_S = 4.0
"""Planned for each item of a questionnaire."""
FREE_TEXT_S = 30.0
"""Planned for each question that is answered in one's own words."""
WORDS_PER_S = 3.0
"""Planned reading speed of instructions."""

StepKind: TypeAlias = Literal[
    "session", "ready", "training", "exposure", "questionnaire", "rest", "instruction"
]


@dataclass(frozen=True)
class TrialPlace:
    """The trial that something belongs to; all blank where it belongs to the whole session."""

    period: int | None = None
    block: int | None = None
    trial: int | None = None
    condition: str | None = None
    scene: str = ""
    part: str | None = None


WHOLE_SESSION = TrialPlace()


@dataclass(frozen=True)
class PlannedStep:
    """A step as operators see it begin.

    Parameters
    ----------
    words
        The beginning of its name when it is run, which ends with the attempt and the like.
    planned_s
        Its planned length.
    shows
        The condition and scene of an exposure.
    """

    kind: StepKind
    words: str
    planned_s: float
    shows: str = ""

    @property
    def name(self) -> str:
        """Return its name before it begins."""
        return f"{self.words.strip()}: {self.shows}" if self.shows else self.words


@dataclass(frozen=True)
class TimelineStep:
    """A step of a session.

    Parameters
    ----------
    when
        The moment that it belongs to.
    planned
        Its parts, in the order in which operators see them.
    """

    when: When
    place: TrialPlace
    planned: tuple[PlannedStep, ...]

    @property
    def words(self) -> str:
        """Return the beginning of the names of its parts."""
        return self.planned[-1].words


@dataclass(frozen=True)
class ScreeningStep(TimelineStep):
    """A check of facts from before the session: IPD, or covariates."""

    of: Literal["ipd", "covariates"]


@dataclass(frozen=True)
class InstructionStep(TimelineStep):
    """An instruction."""

    instruction: Instruction


@dataclass(frozen=True)
class QuestionnaireStep(TimelineStep):
    """A questionnaire.

    Parameters
    ----------
    owed
        It was due before the session was interrupted: only open items are asked, and not too late.
    """

    ask: Ask
    owed: bool = False


@dataclass(frozen=True)
class FreeTextStep(TimelineStep):
    """A question that is answered in one's own words."""

    question: FreeText


@dataclass(frozen=True)
class RestStep(TimelineStep):
    """A rest of a fixed length."""

    duration_s: float


@dataclass(frozen=True)
class BreakStep(TimelineStep):
    """A break that lasts as long as the participant wants, within limits.

    Parameters
    ----------
    interrupted
        It may have begun before the session was interrupted.
    """

    breaks: Breaks
    interrupted: bool


@dataclass(frozen=True)
class EyeHeightStep(TimelineStep):
    """A measurement of the height of the eyes."""

    posture: Posture


@dataclass(frozen=True)
class GazeValidationStep(TimelineStep):
    """A validation of the eye tracker."""

    validation: GazeValidation


@dataclass(frozen=True)
class PracticeStep(TimelineStep):
    """A block of practice, with its repetitions."""

    practice: Practice


@dataclass(frozen=True)
class ExposureStep(TimelineStep):
    """An exposure; before the first of a session, its training."""


Step: TypeAlias = (
    ScreeningStep
    | InstructionStep
    | QuestionnaireStep
    | FreeTextStep
    | RestStep
    | BreakStep
    | EyeHeightStep
    | GazeValidationStep
    | PracticeStep
    | ExposureStep
)


@dataclass(frozen=True)
class Resumption:
    """The progress of an interrupted session.

    Parameters
    ----------
    done
        Exposures that are not shown again.
    last_trial
        The trial with open questions; None: there are none.
    begun
        Trials that were begun: the breaks before them are over.
    practised
        Practice that is over.
    ended
        The session, or the participant's study, ended with that trial: only questions are left.
    """

    done: int
    last_trial: int | None
    begun: Collection[int]
    practised: Collection[str]
    ended: bool = False


def trial_places(sequence: Sequence, session: int) -> list[TrialPlace]:
    """Return the trials of a session; periods count over the sessions before it."""
    before = sum(len(each) for each in sequence.sessions[: session - 1])
    return [
        TrialPlace(before + number, 1, number, trial.condition, trial.scene, trial.part)
        for number, trial in enumerate(sequence.sessions[session - 1], start=1)
    ]


@dataclass(frozen=True)
class SessionPlan:
    """Builds the timeline of one session.

    Parameters
    ----------
    exposure_s
        Maximum length of an exposure as shown: the protocol's, or less.
    resumption
        Of a session that goes on; it has the steps that are left.
    """

    protocol: Protocol
    sequence: Sequence
    session: int
    exposure_s: float
    resumption: Resumption | None = None

    def steps(self) -> Iterator[Step]:
        """Yield the steps of the session."""
        places, before = trial_places(self.sequence, self.session), self.resumption
        if before is not None and before.last_trial:
            yield from self._questions("after_trial", places[before.last_trial - 1], owed=True)
            if before.ended:
                return
        left = places[before.done if before else 0 :]
        if left:  # else there is nothing that a baseline would be for
            yield from self._screening()
            yield from self._instructions("session_start", WHOLE_SESSION)
            yield from self._questions("session_start", WHOLE_SESSION)
        for index, place in enumerate(left):
            yield from self._before_trial(place, first=index == 0)
            yield self._exposure(place)
            yield from self._instructions("after_trial", place)
            yield from self._questions("after_trial", place)
        owed = before is not None and not left
        yield from self._questions("session_end", WHOLE_SESSION, owed=owed)
        yield from self._instructions("session_end", WHOLE_SESSION)

    def _screening(self) -> Iterator[Step]:
        protocol = self.protocol
        if protocol.headset.ipd_range_m is not None:
            yield ScreeningStep("session_start", WHOLE_SESSION, (), "ipd")
        if self.session == 1 and any(rule.covariate for rule in protocol.screening):
            yield ScreeningStep("session_start", WHOLE_SESSION, (), "covariates")

    def _instructions(self, when: When, place: TrialPlace) -> Iterator[Step]:
        for each in self.protocol.tells(when, self.session, place.trial):
            longest_s = each.max_s or max(each.min_s, FREE_TEXT_S)
            read_s = len(each.text.split()) / WORDS_PER_S
            planned_s = min(max(read_s, each.min_s, 1.0), longest_s)
            planned = PlannedStep("instruction", f"instruction {each.name}", planned_s)
            yield InstructionStep(when, place, (planned,), each)

    def _questions(self, when: When, place: TrialPlace, *, owed: bool = False) -> Iterator[Step]:
        """Yield questionnaires, each with the rest before it, and free texts."""
        for ask in self.protocol.asks(when, self.session, place.trial):
            if ask.compares == "pair" and (place.trial or 0) % 2:
                continue  # asked after the second exposure of a pair
            if ask.wait_s and not owed:
                yield self._rest(when, place, ask.wait_s)
            items = len(self.protocol.instrument(ask.instrument).asked)
            words = f"questionnaire {ask.instrument} ({ask.timepoint})"
            planned = PlannedStep("questionnaire", words, items * ITEM_S)
            yield QuestionnaireStep(when, place, (planned,), ask, owed)
        for each in self.protocol.writes(when, self.session, place.trial):
            planned = PlannedStep("questionnaire", f"free text {each.name}", FREE_TEXT_S)
            yield FreeTextStep(when, place, (planned,), each)

    def _rest(self, when: When, place: TrialPlace, duration_s: float) -> Step:
        planned = PlannedStep("rest", f"rest of {duration_s:g} s", duration_s)
        return RestStep(when, place, (planned,), duration_s)

    def _before_trial(self, place: TrialPlace, *, first: bool) -> Iterator[Step]:
        """Yield the break, the measurements, the practice, and the words before a trial.

        Parameters
        ----------
        first
            The first trial since the program was started.
        """
        pause = self._break(place, first=first)
        if pause is not None:
            yield pause
        posture, gaze = self.protocol.posture, self.protocol.gaze_validation
        if posture is not None and (first or (posture.after_breaks and pause is not None)):
            planned = PlannedStep(
                "training", "height of the eyes", posture.settle_s + posture.measure_s
            )
            yield EyeHeightStep("before_trial", place, (planned,), posture)
        if gaze is not None and (first or (gaze.after_breaks and pause is not None)):
            length_s = len(gaze.points) * gaze.each_s
            planned = PlannedStep("training", "gaze validation", length_s)
            yield GazeValidationStep("before_trial", place, (planned,), gaze)
        yield from self._practice(place)
        yield from self._instructions("before_trial", place)
        yield from self._questions("before_trial", place)

    def _break(self, place: TrialPlace, *, first: bool) -> Step | None:
        protocol, trial = self.protocol, place.trial or 0
        if trial > 1 and protocol.breaks is not None and protocol.breaks.is_due(trial - 1):
            if first and self.resumption is not None and trial in self.resumption.begun:
                return None  # it was over before the interruption: its exposure had begun
            words = f"break after trial {trial - 1}"
            planned = PlannedStep("rest", words, protocol.breaks.min_s)
            return BreakStep("before_trial", place, (planned,), protocol.breaks, first)
        if first or not protocol.break_s:
            return None
        return self._rest("before_trial", place, protocol.break_s)

    def _practice(self, place: TrialPlace) -> Iterator[Step]:
        over = self.resumption.practised if self.resumption else ()
        for each in self.protocol.practice:
            if not each.is_due(self.session, place.trial or 0) or each.name in over:
                continue
            yield from self._instructions("before_practice", place)
            length_s = min(each.exposure_s or self.protocol.longest_s, self.exposure_s)
            planned = PlannedStep("training", f"practice {each.name}", length_s)
            exposures = each.draw or len(each.trials)
            yield PracticeStep("before_practice", place, (planned,) * exposures, each)

    def _exposure(self, place: TrialPlace) -> Step:
        planned = [
            PlannedStep(
                "exposure",
                f"exposure {place.trial} ",
                min(self.protocol.length_s(place.scene), self.exposure_s),
                f"{place.condition} in {place.scene}",
            )
        ]
        if place.trial == 1 and self.protocol.training_s:
            shortened = self.exposure_s / self.protocol.longest_s
            length_s = self.protocol.training_s * shortened
            planned.insert(0, PlannedStep("training", "training", length_s))
        return ExposureStep("before_trial", place, tuple(planned))
