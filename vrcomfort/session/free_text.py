"""Asks questions that are answered in one's own words, and keeps the answers."""

from __future__ import annotations

from vrcomfort.protocol.free_texts import FreeText
from vrcomfort.protocol.timeline import FreeTextStep, TrialPlace
from vrcomfort.records import TextRow
from vrcomfort.records.recorded_rows import read_rows
from vrcomfort.records.session_rows import LONGEST_TEXT, one_line
from vrcomfort.respondent.base import Writes
from vrcomfort.session.context import SessionContext
from vrcomfort.session.event_log import EventLog
from vrcomfort.session.steering import Redone, Skipped


class FreeTexts:
    """The free texts of one session: each is asked once, also in a session that goes on."""

    def __init__(self, context: SessionContext, events: EventLog) -> None:
        self._context, self._events = context, events
        folder = events.recorder.folder
        there = (folder / TextRow.FILE).exists()
        rows = read_rows(folder, TextRow) if there else ()
        self._answered = {(row["trial"], row["question"]) for row in rows}

    def ask(self, step: FreeTextStep) -> None:
        """Ask a question, if it has no answer yet.

        Raises
        ------
        Withdrew
            If the participant stops at a question. And what operators raise.
        """
        respondent, question = self._context.respondent, step.question
        answered = (step.place.trial, question.name) in self._answered
        if answered or not isinstance(respondent, Writes):
            return
        asked_s = self._context.clock.now_s()
        while True:
            self._context.steering.begin("questionnaire", step.words)
            try:
                written = respondent.write(question.text)
            except Redone:
                continue
            except Skipped:
                self._events.event("free_text_skipped", detail=question.name)
                return
            break
        self._context.clock.advance(written.took_s)
        self._keep(question, step.place, written.text.strip(), asked_s)

    def _keep(self, question: FreeText, place: TrialPlace, text: str, asked_s: float) -> None:
        line = one_line(text[:LONGEST_TEXT])
        if len(text) > LONGEST_TEXT:
            detail = f"{question.name}: only the first {LONGEST_TEXT} of {len(text)} characters"
            self._events.event("free_text_cut", detail=f"{detail} are kept")
        row = TextRow(
            participant=self._context.participant,
            session=self._events.session,
            trial=place.trial,
            condition=place.condition,
            question=question.name,
            text=line,
            asked_s=round(asked_s, 9),
            answered_s=self._context.clock.now_s(),
        )
        self._events.recorder.write(row)
        self._answered.add((place.trial, question.name))
        self._events.event("free_text", detail=f"{question.name}: {len(text)} characters")
