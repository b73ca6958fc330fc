"""Rests of a fixed length, and breaks that last as long as participants want, within limits."""

from __future__ import annotations

from vrcomfort.protocol.breaks import Breaks
from vrcomfort.records import Interrupted
from vrcomfort.respondent import Telling
from vrcomfort.session.context import SessionContext
from vrcomfort.session.event_log import EventLog, TrialPlace
from vrcomfort.session.instructor import Instructor
from vrcomfort.session.steering import Skipped

SLICE_S = 0.2
"""So often a rest looks up."""


class Rests:
    """The rests of one session.

    Parameters
    ----------
    interrupted
        How far an interrupted session came.
    """

    def __init__(
        self,
        context: SessionContext,
        events: EventLog,
        instructor: Instructor,
        interrupted: Interrupted | None,
    ) -> None:
        self._context = context
        self._events = events
        self._instructor = instructor
        self._before = interrupted
        self._began_s = interrupted.session_s if interrupted else 0.0

    def rest(self, duration_s: float) -> None:
        """Rest for so long; an operator may cut it short.

        Raises
        ------
        Withdrew
            If the participant stops here.
        """
        start_s = self._context.clock.now_s()
        self._context.steering.begin("rest", f"rest of {duration_s:g} s")
        try:
            self._wait(duration_s)
            self._context.respondent.rest(duration_s)
        except Skipped:
            self._context.respondent.rest(self._context.clock.now_s() - start_s)
        finally:
            self._events.event("rest", start_s)

    def between(self, place: TrialPlace, *, first: bool) -> bool:
        """Rest before a trial, where the protocol says so; return whether there was a rest.

        Parameters
        ----------
        first
            Whether it is the first trial since the program was started.
        """
        protocol, trial = self._context.protocol, place.trial or 0
        if trial > 1 and protocol.breaks is not None and protocol.breaks.is_due(trial - 1):
            return self._break(protocol.breaks, trial, self._passed_s(trial) if first else 0.0)
        if first or not protocol.break_s:
            return False
        self.rest(protocol.break_s)
        return True

    def _passed_s(self, trial: int) -> float | None:
        """Return how long ago the exposure before was; None where its break was over."""
        before = self._before
        if before is None or trial in before.attempts:
            return None
        since_s = before.exposure_ended_s_ago
        gap_s = self._context.clock.of_people(since_s) if since_s is not None else 0.0
        return gap_s + self._context.clock.now_s() - self._began_s

    def _break(self, settings: Breaks, trial: int, passed_s: float | None) -> bool:
        """Hold a break, of which a time may have passed before an interruption."""
        if passed_s is None:
            return False
        clock, respondent = self._context.clock, self._context.respondent
        start_s = clock.now_s()
        words = f"break after trial {trial - 1}"
        self._context.steering.begin("rest", f"{words}, at least {settings.min_s:g} s")
        ended = "interruption"
        try:
            ended = self._until_over(settings, words, start_s - passed_s)
            respondent.rest(clock.now_s() - start_s)
        finally:
            self._events.event("rest", start_s, detail=f"{words}; ended by {ended}")
        return True

    def _until_over(self, settings: Breaks, words: str, began_s: float) -> str:
        """Let a break pass; return who ended it."""
        clock = self._context.clock
        try:
            self._wait(settings.min_s - (clock.now_s() - began_s))
        except Skipped:
            lasted_s = clock.now_s() - began_s
            detail = f"{words}: {lasted_s:.1f} s, at least {settings.min_s:g} s were meant"
            self._events.event("break_cut_short", detail=detail)
            return "experimenter"
        rest = self._context.protocol.words
        telling = Telling(rest.rest, rest.rest_ready, away=True)
        late_s = None if settings.max_s is None else began_s + settings.max_s

        def tell() -> None:
            detail = f"{words}: longer than {settings.max_s:g} s"
            self._events.event("break_too_long", detail=detail)
            self._events.tell("notice", TrialPlace(), 0, 0, detail)

        return self._instructor.tell_until(telling, late_s, tell)

    def _wait(self, duration_s: float) -> None:
        """Wait; in slices, so that progress can be shown, and a wish to stop be heard."""
        clock = self._context.clock
        start_s, paused_s = clock.now_s(), 0.0
        while (left_s := duration_s - (clock.now_s() - start_s - paused_s)) > 1e-6:
            self._events.tell("rest", TrialPlace(), duration_s - left_s, duration_s)
            paused_s += self._a_moment(left_s)

    def _a_moment(self, left_s: float) -> float:
        """Let a slice of a rest pass; return how much of it was paused."""
        clock, steering = self._context.clock, self._context.steering
        steering.look()
        before_s, paused = clock.now_s(), steering.paused
        if not self._context.respondent.resting(left_s):
            clock.wait(left_s if self._context.jumps else min(left_s, SLICE_S))
        return clock.now_s() - before_s if paused else 0.0
