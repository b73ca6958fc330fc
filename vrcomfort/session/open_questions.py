"""What a questionnaire still lacks when a session goes on, and whether it may still be asked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from vrcomfort.protocol import Ask
from vrcomfort.questionnaire import Instrument
from vrcomfort.records import Interrupted
from vrcomfort.session.compared import is_due
from vrcomfort.session.context import SessionContext
from vrcomfort.session.event_log import EventLog, TrialPlace
from vrcomfort.session.interview import Interview


@dataclass(frozen=True)
class OpenQuestions:
    """The questionnaires that a session owed when it was interrupted.

    Symptoms fade: an answer says something of an exposure only for a while. What is asked too
    late is not asked; an event says so, and which items are missing.
    """

    context: SessionContext
    events: EventLog
    before: Interrupted
    rest: Callable[[float], None]
    """Waits before a questionnaire that is to be asked some time after the exposure."""

    def ask(self, when: str, place: TrialPlace, *, after_withdrawal: bool = False) -> list[str]:
        """Ask what is open of one moment; return a sentence for each questionnaire that is missed.

        Raises
        ------
        Withdrew
            If the participant stops at a question.
        """
        missed = []
        for ask in self.context.protocol.asks(when):
            if not is_due(ask, place):
                continue
            form = self._open_items(ask, place)
            if not form.items:
                continue
            if (reason := self._too_late(ask)) is None:
                missed += self._go_on(ask, place, form, after_withdrawal=after_withdrawal)
            else:
                missed.append(self._miss(ask, form, place, reason))
        return missed

    def _open_items(self, ask: Ask, place: TrialPlace) -> Instrument:
        """Return the instrument with the items that have no row."""
        instrument = self.context.protocol.form(ask)
        answered = self.before.answered.get((place.trial, ask.timepoint, ask.instrument), ())
        items = tuple(item for item in instrument.items if item.name not in answered)
        return replace(instrument, items=items)

    @property
    def _gap_s(self) -> float | None:
        """Seconds from the end of the exposure to now; None where nothing tells."""
        since_s = self.before.exposure_ended_s_ago
        return None if since_s is None else self.context.clock.of_people(since_s)

    def _too_late(self, ask: Ask) -> str | None:
        limit_s = self.context.protocol.resumed_questions_within_s + ask.wait_s
        if self._gap_s is None:
            return "nothing tells how long ago the exposure was"
        if self._gap_s > limit_s:
            ago = f"the exposure was {self._gap_s / 60:.0f} min ago"
            return f"{ago}, and the protocol allows {limit_s / 60:g}"
        return None

    def _go_on(
        self, ask: Ask, place: TrialPlace, form: Instrument, *, after_withdrawal: bool
    ) -> list[str]:
        whole = len(self.context.protocol.form(ask).items)
        what = f"{ask.timepoint} {ask.instrument}: {len(form.items)} of {whole} items were open"
        gap = f"{self._gap_s:.0f} s after the exposure"
        self.events.event("questionnaire_resumed", detail=f"{what}, {gap}")
        if len(form.items) == whole and (left_s := ask.wait_s - (self._gap_s or 0.0)) > 0:
            self.rest(left_s)
        interview = Interview(self.context, self.events, ask, place, form)
        return interview.hold(after_withdrawal=after_withdrawal)

    def _miss(self, ask: Ask, form: Instrument, place: TrialPlace, reason: str) -> str:
        names = ", ".join(item.name for item in form.items)
        detail = f"{ask.timepoint} {ask.instrument}: {names}; {reason}"
        self.events.event("questionnaire_missed", detail=detail)
        of = f"trial {place.trial}" if place.trial else "the end of the session"
        whole = len(self.context.protocol.form(ask).items)
        return (
            f"{len(form.items)} of {whole} items of {ask.instrument} ({ask.timepoint}) after {of} "
            f"are missed: {reason}"
        )
