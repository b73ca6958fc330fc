"""Asks questionnaires and keeps every answer."""

from __future__ import annotations

from vrcomfort.errors import InputError
from vrcomfort.protocol import Ask
from vrcomfort.questionnaire import Instrument
from vrcomfort.records import QuestionnaireRow
from vrcomfort.respondent import Form
from vrcomfort.session.compared import compared
from vrcomfort.session.context import SessionContext
from vrcomfort.session.event_log import EventLog, TrialPlace
from vrcomfort.session.steering import Redone, Skipped


class Interview:
    """One questionnaire in the asking.

    Each answer is a row at once, on the disk before the next is asked; a correction takes the place
    of the row before. Every answer as it was given is an event.

    Parameters
    ----------
    open_items
        The instrument with those of its items that are still open; all of them without it.
    """

    def __init__(
        self,
        context: SessionContext,
        events: EventLog,
        ask: Ask,
        place: TrialPlace,
        open_items: Instrument | None = None,
    ) -> None:
        self._context = context
        self._events = events
        self._ask = ask
        self._place = place
        whole = context.protocol.form(ask)
        self._instrument = open_items or whole
        self._order = {item.name: n for n, item in enumerate(whole.items, start=1)}
        self._rows: dict[str, QuestionnaireRow] = {}

    def hold(self, *, after_withdrawal: bool) -> list[str]:
        """Let the respondent answer, again where an operator wants it so.

        Returns
        -------
        list of str
            A sentence about the items that an operator has skipped; none where all were asked.

        Raises
        ------
        Withdrew
            If the participant stops at a question.
        """
        form = Form(self._instrument, self._ask.timepoint, after_withdrawal, self._compared())
        while True:
            words = f"questionnaire {self._ask.instrument} ({self._ask.timepoint})"
            self._context.steering.begin("questionnaire", words)
            self._tell()
            try:
                self._context.respondent.ask(form, self._heard)
            except Redone:
                continue
            except Skipped:
                return self._skipped()
            return []

    @property
    def answers(self) -> dict[str, int | None]:
        """Return item → answer, of what was asked here."""
        return {item: row.response for item, row in self._rows.items()}

    def _compared(self) -> tuple[str, ...]:
        """Return the conditions that answers mean.

        Raises
        ------
        InputError
            If there are not as many as answers.
        """
        ask, place = self._ask, self._place
        found = compared(ask, self._context.sequence, self._events.session, place)
        for item in self._instrument.items if ask.compares else ():
            if len(found) != item.answers.high:
                message = f"{self._instrument.short} asks which of {item.answers.high} ways of"
                raise InputError(
                    f"{message} rendering, and in order `{self._context.sequence.name}` there are "
                    f"{len(found)} until then; choose an instrument with as many answers"
                )
        return found

    def _skipped(self) -> list[str]:
        names = [item.name for item in self._instrument.items if item.name not in self._rows]
        if not names:
            return []
        ask, trial = self._ask, self._place.trial
        detail = f"{ask.timepoint} {ask.instrument}: {', '.join(names)}"
        self._events.event("questionnaire_skipped", detail=detail)
        whole = len(self._order)
        of = f"of trial {trial}" if trial else "of the session"
        what = f"{len(names)} of {whole} items of {ask.instrument} ({ask.timepoint}) {of}"
        return [f"{what} are missed: skipped by an operator"]

    def _heard(self, item: str, response: int | None, took_s: float) -> None:
        self._context.clock.advance(took_s)
        answered_s = self._context.clock.now_s()
        row = self._row(item, response, answered_s, round(max(answered_s - took_s, 0.0), 9))
        before = self._rows.get(item)
        if before is None:
            self._events.recorder.write(row)
        else:
            self._events.recorder.replace(before, row)
        self._rows[item] = row
        said = "rather not say" if response is None else response
        detail = f"{self._ask.timepoint} {self._ask.instrument} {item}: {said}"
        self._events.event("answer", detail=detail)
        self._tell()
        self._context.steering.look()

    def _row(
        self, item: str, response: int | None, answered_s: float, asked_s: float
    ) -> QuestionnaireRow:
        return QuestionnaireRow(
            participant=self._context.participant,
            session=self._events.session,
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
            part=self._place.part if self._place.trial else self._part_of_session(),
        )

    def _part_of_session(self) -> str | None:
        """Return the part of the session's exposures, if all belong to one."""
        trials = self._context.sequence.sessions[self._events.session - 1]
        parts = {trial.part for trial in trials}
        return parts.pop() if len(parts) == 1 else None

    def _tell(self) -> None:
        done, total = len(self._rows), len(self._instrument.items)
        self._events.tell("questionnaire", self._place, done, total, self._ask.timepoint)
