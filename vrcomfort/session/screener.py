"""Tells the experimenter of a number beyond a screening rule, and keeps what they decide."""

from __future__ import annotations

from collections.abc import Mapping

from vrcomfort.protocol import Ask
from vrcomfort.protocol.screening import Screening
from vrcomfort.questionnaire import score
from vrcomfort.questionnaire.answers import Answer
from vrcomfort.records import ScreeningRow, enrolled
from vrcomfort.records.session_rows import IPD_RULE
from vrcomfort.records.tables import read_rows
from vrcomfort.respondent.base import Decides
from vrcomfort.session.context import SessionContext
from vrcomfort.session.event_log import EventLog
from vrcomfort.session.operator_control import Redone, Skipped
from vrcomfort.session.stop_rules import StopRule


class Screener:
    """The screening of one session."""

    def __init__(self, context: SessionContext, events: EventLog) -> None:
        self._context, self._events = context, events
        folder = events.recorder.folder
        there = (folder / ScreeningRow.FILE).exists()
        self._decided = {row["rule"] for row in read_rows(folder, ScreeningRow)} if there else set()

    def look_at_covariates(self) -> None:
        """Tell of what was entered at the enrolment, before the first session, once.

        Raises
        ------
        StopRule
            If the experimenter stops. And what operators raise.
        """
        row = enrolled(self._context.study, self._context.participant)
        if row is None or self._events.session > 1:
            return
        for rule in self._context.protocol.screening:
            if rule.covariate is None:
                continue
            value = row.covariates.get(rule.covariate, "")
            if value:
                self._decide(rule, rule.covariate, float(value), once=True)

    def look_at_ipd(self) -> None:
        """Tell of a distance between the pupils that the headset cannot be fitted to.

        Raises
        ------
        StopRule
            If the experimenter stops. And what operators raise.
        """
        limits_m = self._context.protocol.headset.ipd_range_m
        measured_m = self._context.ipd_measured_m
        if limits_m is None or measured_m is None:
            return
        low_mm, high_mm = (round(1000 * each, 3) for each in limits_m)
        rule = Screening(covariate=IPD_RULE, below=low_mm, above=high_mm, ends="session")
        self._decide(rule, IPD_RULE, round(1000 * measured_m, 3))

    def hear(self, ask: Ask, answers: Mapping[str, Answer | None]) -> None:
        """Tell of a score of the session's start.

        Raises
        ------
        StopRule
            If the experimenter stops. And what operators raise.
        """
        for rule in self._context.protocol.screening:
            if rule.instrument != ask.instrument or ask.when != "session_start":
                continue
            instrument = self._context.protocol.instrument(ask.instrument)
            scale = rule.scale or instrument.primary
            found = score(instrument, answers).get(scale)
            if found is not None:  # else too few answers
                self._decide(rule, f"{instrument.short} {scale}", float(found.points))

    def _decide(self, rule: Screening, what: str, value: float, *, once: bool = False) -> None:
        bound = rule.broken(value)
        words = f"{what} {bound}"
        if bound is None or (once and words in self._decided):
            return
        goes_on = self._asked(f"{what} is {value:g}, {bound}. Go on with this participant?")
        row = ScreeningRow(
            participant=self._context.participant,
            session=self._events.session,
            rule=words,
            value=value,
            decision="go_on" if goes_on else "stop",
            decided_s=self._context.clock.now_s(),
        )
        self._events.recorder.write(row)
        self._events.event("screening", detail=f"{words} ({value:g}): {row.decision}")
        if not goes_on:
            raise StopRule(f"screened out: {words} ({value:g})", rule.ends, "screening")

    def _asked(self, question: str) -> bool:
        respondent = self._context.respondent
        while isinstance(respondent, Decides):
            self._context.operators.begin("questionnaire", "screening")
            try:
                return respondent.decide(question)
            except (Redone, Skipped):  # it is a decision, which nobody can leave out
                continue
        return True
