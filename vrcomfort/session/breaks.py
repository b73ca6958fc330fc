"""Rests of a fixed length, and breaks that last as long as participants want, within limits."""

from __future__ import annotations

from vrcomfort.protocol.session_steps import Breaks
from vrcomfort.protocol.timeline import WHOLE_SESSION, BreakStep
from vrcomfort.records import Interrupted
from vrcomfort.respondent import InstructionContent
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.session.instructor import Instructor
from vrcomfort.session.operator_control import Skipped

SLICE_S = 0.2
"""Interval at which a rest handles commands and progress."""


class BreakRunner:
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
        """Rest for a fixed time; an operator may cut it short.

        Raises
        ------
        Withdrew
            If the participant stops here.
        """
        start_s = self._context.clock.now_s()
        self._context.operators.begin("rest", f"rest of {duration_s:g} s")
        try:
            self._wait(duration_s)
            self._context.respondent.rest(duration_s)
        except Skipped:
            self._context.respondent.rest(self._context.clock.now_s() - start_s)
        finally:
            self._events.event("rest", start_s)

    def _passed_s(self) -> float:
        """Return the time since the last exposure before the interruption."""
        since_s = self._before.exposure_ended_s_ago if self._before else None
        gap_s = self._context.clock.of_people(since_s) if since_s is not None else 0.0
        return gap_s + self._context.clock.now_s() - self._began_s

    def hold_break(self, step: BreakStep) -> None:
        """Hold a break; time that has passed since an interrupted one began counts.

        Raises
        ------
        Withdrew
            If the participant stops here.
        """
        clock, respondent = self._context.clock, self._context.respondent
        passed_s = self._passed_s() if step.interrupted else 0.0
        start_s = clock.now_s()
        settings, words = step.breaks, step.words
        self._context.operators.begin("rest", f"{words}, at least {settings.min_s:g} s")
        ended = "interruption"
        try:
            ended = self._until_over(settings, words, start_s - passed_s)
            respondent.rest(clock.now_s() - start_s)
        finally:
            self._events.event("rest", start_s, detail=f"{words}; ended by {ended}")

    def _until_over(self, settings: Breaks, words: str, began_s: float) -> str:
        """Let a break pass; return the cause of its end."""
        clock = self._context.clock
        try:
            self._wait(settings.min_s - (clock.now_s() - began_s))
        except Skipped:
            lasted_s = clock.now_s() - began_s
            detail = f"{words}: {lasted_s:.1f} s, at least {settings.min_s:g} s were meant"
            self._events.event("break_cut_short", detail=detail)
            return "experimenter"
        rest = self._context.protocol.words
        content = InstructionContent(rest.rest, rest.rest_ready, away=True)
        late_s = None if settings.max_s is None else began_s + settings.max_s

        def tell() -> None:
            detail = f"{words}: longer than {settings.max_s:g} s"
            self._events.event("break_too_long", detail=detail)
            self._events.tell("notice", WHOLE_SESSION, 0, 0, detail)

        return self._instructor.tell_until(content, late_s, tell)

    def _wait(self, duration_s: float) -> None:
        """Wait; in slices, so that progress can be shown, and a wish to stop be heard."""
        clock = self._context.clock
        start_s, paused_s = clock.now_s(), 0.0
        while (left_s := duration_s - (clock.now_s() - start_s - paused_s)) > 1e-6:
            self._events.tell("rest", WHOLE_SESSION, duration_s - left_s, duration_s)
            paused_s += self._a_moment(left_s)

    def _a_moment(self, left_s: float) -> float:
        """Let a slice of a rest pass; return how much of it was paused."""
        clock, operators = self._context.clock, self._context.operators
        operators.look()
        before_s, paused = clock.now_s(), operators.paused
        if not self._context.respondent.resting(left_s):
            clock.wait(left_s if self._context.jumps else min(left_s, SLICE_S))
        return clock.now_s() - before_s if paused else 0.0
