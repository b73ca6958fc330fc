"""Asks questionnaires and keeps every answer."""

from __future__ import annotations

from vrcomfort.protocol import Ask
from vrcomfort.questionnaire import INSTRUMENTS
from vrcomfort.records import QuestionnaireRow
from vrcomfort.respondent import Form, Respondent
from vrcomfort.session.diary import Diary, Place


class Interview:
    """One questionnaire in the asking.

    Each answer is an event at once, on the disk; the rows are written when the last correction has
    been made, or when something cuts the questionnaire short.
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
        form = Form(self._instrument, self._ask.timepoint, after_withdrawal)
        try:
            respondent.ask(form, self._heard)
        finally:
            rows = sorted(self._rows.values(), key=lambda row: row.order)
            self._diary.recorder.write(*rows)

    def _heard(self, item: str, response: int | None, took_s: float) -> None:
        self._diary.clock.advance(took_s)
        answered_s = self._diary.clock.now_s()
        self._rows[item] = QuestionnaireRow(
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
            asked_s=round(max(answered_s - took_s, 0.0), 9),
            answered_s=answered_s,
            order=self._order[item],
        )
        said = "rather not say" if response is None else response
        detail = f"{self._ask.timepoint} {self._ask.instrument} {item}: {said}"
        self._diary.event("answer", detail=detail, sync=True)
        self._tell()

    def _tell(self) -> None:
        done, total = len(self._rows), len(self._order)
        self._diary.tell("questionnaire", self._place, done, total, self._ask.timepoint)
