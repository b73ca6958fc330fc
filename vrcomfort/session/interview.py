"""Questionnaires, questions in one's own words, and screening."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from vrcomfort.errors import InputError
from vrcomfort.protocol import Ask, Sequence
from vrcomfort.protocol.questions import FreeText, Screening
from vrcomfort.protocol.timeline import FreeTextStep, QuestionnaireStep, TrialPlace
from vrcomfort.questionnaire import Instrument, score
from vrcomfort.questionnaire.answers import Answer
from vrcomfort.records import Interrupted, QuestionnaireRow, ScreeningRow, TextRow, enrolled
from vrcomfort.records.reader import Session
from vrcomfort.records.session_rows import IPD_RULE, LONGEST_TEXT, one_line
from vrcomfort.respondent import Form
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.session.operator_control import Redone, Skipped
from vrcomfort.session.ratings import StopRule


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
        step: QuestionnaireStep,
        open_items: Instrument | None = None,
    ) -> None:
        self._context = context
        self._events = events
        self._words = step.words
        self._ask = step.ask
        self._place = step.place
        whole = context.protocol.form(step.ask)
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
            self._context.operators.begin("questionnaire", self._words)
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
        """Return item → answer."""
        return {item: row.response for item, row in self._rows.items()}

    def _compared(self) -> tuple[str, ...]:
        """Return the conditions that answers mean.

        Raises
        ------
        InputError
            If there are not as many as answers.
        """
        ask, place = self._ask, self._place
        found = compared_conditions(ask, self._context.sequence, self._events.session, place)
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
        said = "rather not say" if response is None else response
        detail = f"{self._ask.timepoint} {self._ask.instrument} {item}: {said}"
        if before is None:
            self._events.event("answer", detail=detail, after=(row,))
        else:
            self._events.recorder.replace(before, row)
            self._events.event("answer", detail=detail)
        self._rows[item] = row
        self._tell()
        self._context.operators.look()

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

    def ask(self, step: QuestionnaireStep, *, after_withdrawal: bool) -> list[str]:
        """Ask the open items of a questionnaire; return a sentence where they are missed.

        Raises
        ------
        Withdrew
            If the participant stops at a question.
        """
        form = self._open_items(step.ask, step.place)
        if not form.items:
            return []
        if (reason := self._too_late(step.ask)) is None:
            return self._go_on(step, form, after_withdrawal=after_withdrawal)
        return [self._miss(step.ask, form, step.place, reason)]

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
        self, step: QuestionnaireStep, form: Instrument, *, after_withdrawal: bool
    ) -> list[str]:
        ask = step.ask
        whole = len(self.context.protocol.form(ask).items)
        what = f"{ask.timepoint} {ask.instrument}: {len(form.items)} of {whole} items were open"
        gap = f"{self._gap_s:.0f} s after the exposure"
        self.events.event("questionnaire_resumed", detail=f"{what}, {gap}")
        if len(form.items) == whole and (left_s := ask.wait_s - (self._gap_s or 0.0)) > 0:
            self.rest(left_s)
        interview = Interview(self.context, self.events, step, form)
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


def compared_conditions(
    ask: Ask, sequence: Sequence, session: int, place: TrialPlace
) -> tuple[str, ...]:
    """Return the conditions behind answers 1, 2, …, in the order of their first exposure.

    Raises
    ------
    InputError
        If a pair is twice the same condition.
    """
    if ask.compares is None:
        return ()
    trials = sequence.sessions[session - 1]
    if ask.compares == "pair":
        last = place.trial or 0
        pair = tuple(trial.condition for trial in trials[last - 2 : last])
        if pair[0] == pair[1]:
            message = f"exposures {last - 1} and {last} of session {session} in order"
            raise InputError(
                f"{message} `{sequence.name}` are both in condition `{pair[0]}`, and "
                f"`{ask.instrument}` asks which of a pair; let pairs differ"
            )
        return pair
    before = sequence.sessions[: session - 1] if ask.compares == "study" else ()
    met = [trial.condition for each in (*before, trials) for trial in each]
    return tuple(dict.fromkeys(met))


class FreeTexts:
    """The free texts of one session: each is asked once, also in a session that goes on."""

    def __init__(self, context: SessionContext, events: EventLog) -> None:
        self._context, self._events = context, events
        rows = Session(events.recorder.folder).rows(TextRow, repaired=True)
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
        if answered:
            return
        asked_s = self._context.clock.now_s()
        while True:
            self._context.operators.begin("questionnaire", step.words)
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


class ScreeningRunner:
    """The screening of one session."""

    def __init__(self, context: SessionContext, events: EventLog) -> None:
        self._context, self._events = context, events
        rows = Session(events.recorder.folder).rows(ScreeningRow, repaired=True)
        self._decided = {row["rule"] for row in rows}

    def check_covariates(self) -> None:
        """Apply the rules on covariates of the enrolment, before the first session, once.

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
        while True:
            self._context.operators.begin("questionnaire", "screening")
            try:
                return respondent.decide(question)
            except (Redone, Skipped):  # it is a decision, which nobody can leave out
                continue
