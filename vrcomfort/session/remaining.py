"""How much time a session will still take: as it was planned, corrected by what its steps took."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from vrcomfort.session.compared import is_due
from vrcomfort.session.context import SessionContext
from vrcomfort.session.event_log import TrialPlace
from vrcomfort.session.operator_desk import StepKind

AN_ITEM_S = 4.0
"""Planned for each item of a questionnaire."""
A_TEXT_S = 30.0
"""Planned for each question that is answered in one's own words."""
WORDS_PER_S = 3.0
"""At which instructions are planned to be read."""
_BELIEVED_S = 60.0
"""So much planned time of a kind of step is believed as much as what its steps have taken."""


@dataclass(frozen=True)
class PlannedStep:
    """A step that is to come.

    Parameters
    ----------
    words
        With which its own words begin.
    planned_s
        How long it is planned to be.
    """

    kind: StepKind
    words: str
    planned_s: float


class SessionTime:
    """Follows a session through its planned steps.

    Each kind of step has a factor, which begins at 1: the time that its steps have taken over the
    time that was planned for them, where `_BELIEVED_S` of the plan count as taken. A pause is in
    none of them, and neither is a step that an operator has ended.

    Parameters
    ----------
    steps
        In their order.
    now_s
        Returns the session clock.
    """

    def __init__(self, steps: Sequence[PlannedStep], now_s: Callable[[], float]) -> None:
        self._steps, self._now_s = tuple(steps), now_s
        self._at = -1
        self._current: PlannedStep | None = None
        self._planned_s: defaultdict[StepKind, float] = defaultdict(float)
        self._taken_s: defaultdict[StepKind, float] = defaultdict(float)
        self._began_s = self._paused_s = 0.0
        self._pause_began_s: float | None = None
        self._share: float | None = None

    def begin(
        self, kind: StepKind, words: str, *, again: bool = False, cut_short: bool = False
    ) -> None:
        """Take note that a step begins.

        Parameters
        ----------
        again
            It is the one before, once more.
        cut_short
            An operator has ended the one before: how long it took says nothing of others.
        """
        self.end_pause()
        if not cut_short:
            self._learn()
        self._began_s, self._paused_s, self._share = self._now_s(), 0.0, None
        if again and self._current is not None:
            return
        index = self._next(kind, words)
        self._current = None if index is None else self._steps[index]
        self._at = self._at if index is None else index

    def come(self, share: float) -> None:
        """Take note of how much of the step is done, 0 to 1."""
        self._share = share

    def pause(self) -> None:
        """Stop to count the step's time."""
        if self._pause_began_s is None:
            self._pause_began_s = self._now_s()

    def end_pause(self) -> None:
        """Go on."""
        began_s, self._pause_began_s = self._pause_began_s, None
        if began_s is not None:
            self._paused_s += self._now_s() - began_s

    def remaining_s(self) -> float:
        """Return the time that is expected to be left."""
        later_s = sum(self._expected_s(step) for step in self._steps[self._at + 1 :])
        if self._current is None:
            return later_s
        expected_s = self._expected_s(self._current)
        if self._share is not None:
            return later_s + expected_s * (1 - self._share)
        return later_s + max(expected_s - self._elapsed_s(), 0.0)

    def _next(self, kind: StepKind, words: str) -> int | None:
        """Return which step begins: none where it is not planned before the next exposure."""
        for index in range(self._at + 1, len(self._steps)):
            step = self._steps[index]
            if step.kind == kind and words.startswith(step.words):
                return index
            if step.kind == "exposure":
                return None
        return None

    def _learn(self) -> None:
        if self._current is not None:
            self._planned_s[self._current.kind] += self._current.planned_s
            self._taken_s[self._current.kind] += self._elapsed_s()

    def _elapsed_s(self) -> float:
        paused_s, began_s = self._paused_s, self._pause_began_s
        now_s = self._now_s() if began_s is None else began_s
        return now_s - self._began_s - paused_s

    def _expected_s(self, step: PlannedStep) -> float:
        taken_s = self._taken_s[step.kind] + _BELIEVED_S
        return step.planned_s * taken_s / (self._planned_s[step.kind] + _BELIEVED_S)


def planned_steps(
    context: SessionContext, places: Sequence[TrialPlace], session: int
) -> Iterator[PlannedStep]:
    """Yield the steps of a session, or of what is left of one, for whom nothing goes wrong."""
    if places:
        yield from _words(context, "session_start", TrialPlace(), session)
    for index, place in enumerate(places):
        yield from _before(context, place, session, first=index == 0)
        yield from _words(context, "before_trial", place, session)
        if place.trial == 1 and context.protocol.training_s:
            length_s = context.protocol.training_s / context.stretch
            yield PlannedStep("training", "training", length_s)
        yield PlannedStep("exposure", f"exposure {place.trial} ", context.shown_s(place.scene))
        yield from _words(context, "after_trial", place, session)
    yield from _words(context, "session_end", TrialPlace(), session)


def _before(
    context: SessionContext, place: TrialPlace, session: int, *, first: bool
) -> Iterator[PlannedStep]:
    """Yield the rest, what is measured, and the practice before a trial."""
    protocol, trial = context.protocol, place.trial or 0
    rest_s = 0.0 if first else protocol.break_s
    if trial > 1 and protocol.breaks is not None and protocol.breaks.is_due(trial - 1):
        rest_s = protocol.breaks.min_s
    if rest_s:
        yield PlannedStep("rest", "", rest_s)
    posture = protocol.posture
    if posture is not None and (first or (posture.after_breaks and rest_s)):
        length_s = posture.settle_s + posture.measure_s
        yield PlannedStep("training", "height of the eyes", length_s)
    gaze = protocol.gaze_validation
    if gaze is not None and (first or (gaze.after_breaks and rest_s)):
        yield PlannedStep("training", "gaze validation", len(gaze.points) * gaze.each_s)
    for each in protocol.practice:
        if each.is_due(session, trial):
            yield from _told(context, "before_practice", place, session)
            length_s = min(each.exposure_s or protocol.longest_s, context.exposure_s)
            for _ in range(each.draw or len(each.trials)):
                yield PlannedStep("training", f"practice {each.name}", length_s)


def _words(
    context: SessionContext, when: str, place: TrialPlace, session: int
) -> Iterator[PlannedStep]:
    """Yield what is told and asked at a moment."""
    if when != "session_end":
        yield from _told(context, when, place, session)
    for ask in context.protocol.asks(when):
        if is_due(ask, place):
            if ask.wait_s:
                yield PlannedStep("rest", "", ask.wait_s)
            items = len(context.protocol.instrument(ask.instrument).asked)
            words = f"questionnaire {ask.instrument} ({ask.timepoint})"
            yield PlannedStep("questionnaire", words, items * AN_ITEM_S)
    for each in context.protocol.writes(when):
        yield PlannedStep("questionnaire", f"free text {each.name}", A_TEXT_S)
    if when == "session_end":
        yield from _told(context, when, place, session)


def _told(
    context: SessionContext, when: str, place: TrialPlace, session: int
) -> Iterator[PlannedStep]:
    for each in context.protocol.tells(when, session, place.trial):
        longest_s = each.max_s or max(each.min_s, A_TEXT_S)
        read_s = len(each.text.split()) / WORDS_PER_S
        yield PlannedStep(
            "instruction", f"instruction {each.name}", min(max(read_s, each.min_s, 1.0), longest_s)
        )
