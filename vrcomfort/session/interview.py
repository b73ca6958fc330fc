"""Asks questionnaires and keeps every answer."""

from __future__ import annotations

from vrcomfort.protocol import Ask
from vrcomfort.questionnaire import INSTRUMENTS
from vrcomfort.records import QuestionnaireRow
from vrcomfort.respondent import Form, Respondent
from vrcomfort.session.event_log import Diary, Place


class Interview:
    """One questionnaire in the asking.

    Each answer is a row at once, on the disk before the next is asked; a correction takes the place
    of the row before. Every answer as it was given is an event.
    """

    def __init__(self, diary: Diary, ask: Ask, place: Place) -> None:
        self._diary = diary
        self._ask = ask
        self._place = place
        self._instrument = INSTRUMENTS[ask.instrument]
        self._order = {item.name: n for n, item in enumerate(self._instrument.items, start=1)}
        self._rows: dict[str, QuestionnaireRow] = {}

    def hold(self, respondent: Respondent, *, after_withdrawal: bool) -> None:
        """Let the respondent answer.

        Raises
        ------
        Withdrew
            If the participant stops at a question.
        """
        self._tell()
        respondent.ask(Form(self._instrument, self._ask.timepoint, after_withdrawal), self._heard)

    def _heard(self, item: str, response: int | None, took_s: float) -> None:
        self._diary.clock.advance(took_s)
        answered_s = self._diary.clock.now_s()
        row = self._row(item, response, answered_s, round(max(answered_s - took_s, 0.0), 9))
        before = self._rows.get(item)
        if before is None:
            self._diary.recorder.write(row)
        else:
            self._diary.recorder.replace(before, row)
        self._rows[item] = row
        said = "rather not say" if response is None else response
        detail = f"{self._ask.timepoint} {self._ask.instrument} {item}: {said}"
        self._diary.event("answer", detail=detail)
        self._tell()

    def _row(
        self, item: str, response: int | None, answered_s: float, asked_s: float
    ) -> QuestionnaireRow:
        return QuestionnaireRow(
            participant=self._diary.participant,
            session=self._diary.session,
            period=self._place.period,
            block=self._place.block,
            trial=self._place.trial,
            condition=self._place.condition,
            timepoint=self._ask.timepoint,
            instrument=self._ask.instrument,
            item=item,
            response=response,
            asked_s=asked_s,
            answered_s=answered_s,
            order=self._order[item],
        )

    def _tell(self) -> None:
        done, total = len(self._rows), len(self._order)
        self._diary.tell("questionnaire", self._place, done, total, self._ask.timepoint)
