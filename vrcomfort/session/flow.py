"""One session from its first question to its last."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any, Literal

from vrcomfort.geometry import Pose
from vrcomfort.protocol import Sequence
from vrcomfort.records import Interrupted
from vrcomfort.records.interruptions import RESUMED
from vrcomfort.respondent import Withdrew
from vrcomfort.scene.data import Scene
from vrcomfort.session.compared import is_due
from vrcomfort.session.context import SessionContext
from vrcomfort.session.event_log import EventLog, TrialPlace
from vrcomfort.session.eye_height import EyeHeight
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.session.free_text import FreeTexts
from vrcomfort.session.gaze_validation import Validation
from vrcomfort.session.instructor import Instructor
from vrcomfort.session.interview import Interview
from vrcomfort.session.manifest_writer import ManifestWriter
from vrcomfort.session.open_questions import OpenQuestions
from vrcomfort.session.operator_desk import SessionOrder
from vrcomfort.session.practice import PracticeRunner
from vrcomfort.session.remaining import SessionTime, planned_steps
from vrcomfort.session.rests import Rests
from vrcomfort.session.screener import Screener
from vrcomfort.session.stop_rules import ScoreWatch, StopRule, ends_of
from vrcomfort.session.trial import TrialRunner

SessionStatus = Literal["completed", "ended", "withdrawn", "aborted"]
"""`ended`: early, and the participant may come back for the next session."""


class SessionFlow:
    """Runs one session: questionnaires, exposures and rests in the protocol's order.

    Parameters
    ----------
    interrupted
        How far an interrupted session came: goes on at the exposure after it.
    """

    def __init__(
        self,
        context: SessionContext,
        *,
        events: EventLog,
        manifest: ManifestWriter,
        interrupted: Interrupted | None = None,
    ) -> None:
        self._context = context
        self._events = events
        self._manifest = manifest
        self._places = _places(context.sequence, events.session)
        self._respondent = context.respondent
        self._interrupted = interrupted
        last_ns = interrupted.xr_time_ns if interrupted else None
        self._log = FrameLog(events.recorder, last_ns=last_ns)
        self._instructor = Instructor(context, events)
        self._rests = Rests(context, events, self._instructor, interrupted)
        self._open = (
            OpenQuestions(context, events, interrupted, self._rests.rest) if interrupted else None
        )
        self._scores = ScoreWatch(context.protocol)
        self._texts = FreeTexts(context, events)
        self._screener = Screener(context, events)
        self._steering = context.steering
        self._trials = TrialRunner(
            context,
            events=events,
            manifest=manifest,
            log=self._log,
            trials=len(self._places),
            interrupted=interrupted,
        )
        self._practice = PracticeRunner(
            context, events, self._log, self._trials, self._instructor, interrupted
        )
        validation = context.protocol.gaze_validation
        self._validation = (
            Validation(context, events, self._log, validation) if validation else None
        )

    def run(self) -> tuple[SessionStatus, str]:
        """Run the session; return how it ended and a note on why.

        Raises
        ------
        KeyboardInterrupt
            If the operator stopped it: all rows have been written.
        """
        self._begin()
        try:
            self._steering.await_start()
            self._everything()
        except (Withdrew, StopRule) as reason:
            return self._end_early(reason), str(reason)
        self._events.event("session_end")
        return "completed", ""

    def _end_early(self, reason: Withdrew | StopRule) -> SessionStatus:
        """Write that somebody's session, or study, ends here."""
        ends = ends_of(reason, self._context.protocol)
        status: SessionStatus = "ended" if ends == "session" else "withdrawn"
        by = reason.by if isinstance(reason, StopRule) else "participant"
        # First: whatever fails now, it is known.
        self._manifest.close(status, {"by": by, "ends": ends, "reason": str(reason)})
        self._events.event(status, detail=str(reason))
        return status

    def give_up(self, abort_code: str) -> None:
        """Write what is known of the exposure under way, while its own thread hangs."""
        self._trials.give_up(abort_code)
        self._events.event(abort_code)

    def _begin(self) -> None:
        before = self._interrupted
        self._context.floor.offset_m = 0.0
        self._context.clock.start(before.session_s if before else 0.0)
        if before:
            self._events.event(RESUMED, detail=f"after exposure {before.done}")
            for undone in _undone_since(before.manifest):
                self._events.event("withdrawal_undone", detail=str(undone["reason"]))
            for warning in before.warnings:
                self._events.event("row_cut_off", detail=warning)
        else:
            self._events.event("session_start")
        self._respondent.start_session(self._events.session)
        self._manifest.open()
        left = self._places[before.done if before else 0 :]
        steps = tuple(planned_steps(self._context, left, self._events.session))
        time = SessionTime(steps, self._events.now_s)
        words = self._context.protocol.words
        self._steering.attach(self._events, self._context.screen, words=words, time=time)
        shown = tuple((place.scene, place.condition or "") for place in self._places)
        name, who = self._context.sequence.name, self._context.participant
        order = SessionOrder(who, self._events.session, name, shown, time.remaining_s)
        self._steering.desk.open(order)

    def _everything(self) -> None:
        places = self._places[self._interrupted.done if self._interrupted else 0 :]
        self._ask_what_was_open()
        if places:  # else only the end is left, and nothing to be a baseline of
            self._screener.look_at_ipd()
            self._screener.look_at_covariates()
            self._instructor.tell("session_start", TrialPlace())
            self._ask("session_start", TrialPlace())
        for index, place in enumerate(places):
            self._manifest.boundary()
            rested = self._rests.between(place, first=index == 0)
            self._measure_height(place, first=index == 0, rested=rested)
            self._validate_gaze(place, first=index == 0, rested=rested)
            self._practice.run(place)
            self._instructor.tell("before_trial", place)
            self._ask("before_trial", place)
            self._trial(place)
        if places or self._open is None:
            self._ask("session_end", TrialPlace())
        else:
            self._missed(self._open.ask("session_end", TrialPlace()))
            self._texts.ask("session_end", TrialPlace())
        self._instructor.tell("session_end", TrialPlace())

    def _measure_height(self, place: TrialPlace, *, first: bool, rested: bool) -> None:
        """Measure the height of the eyes at the session's start, and after breaks."""
        posture = self._context.protocol.posture
        if posture is None or not (first or (rested and posture.after_breaks)):
            return
        headset, _ = self._trials.stand(place)
        measuring = EyeHeight(self._context, self._events, self._log, self._manifest, posture)
        measuring.measure(place, headset)

    def _validate_gaze(self, place: TrialPlace, *, first: bool, rested: bool) -> None:
        """Validate the eye tracker at the session's start, and after breaks."""
        settings = self._context.protocol.gaze_validation
        again = settings is not None and settings.after_breaks and rested
        if self._validation is None or not (first or again):
            return
        headset, standing = self._trials.stand(place)
        spawn = standing.scene.spawn if isinstance(standing.scene, Scene) else Pose()
        resumed = self._interrupted is not None
        if sentence := self._validation.hold(place, headset, spawn, resumed=resumed):
            self._manifest.miss(sentence)

    def _ask_what_was_open(self) -> None:
        """Ask what a session that goes on owes to its last exposure.

        Raises
        ------
        Withdrew
            If that exposure had ended the participant's study.
        """
        if self._open is None or not self._open.before.last_trial:
            return
        last = self._open.before.last_trial
        place = self._places[last - 1]
        ended = self._open.before.ended_by
        try:
            self._missed(self._open.ask("after_trial", place, after_withdrawal=ended is not None))
            self._texts.ask("after_trial", place)
        except Withdrew as refusal:
            if ended is None:
                raise
            self._events.event("questionnaire_refused", detail=str(refusal))
        if ended is not None:
            told = f"{ended} in trial {last}, before the session was interrupted"
            raise StopRule(told, "session" if self._open.before.ended_session else "study", ended)

    def _missed(self, sentences: list[str]) -> None:
        for sentence in sentences:
            self._manifest.miss(sentence)

    def _ask(self, when: str, place: TrialPlace, *, after_withdrawal: bool = False) -> None:
        for ask in self._context.protocol.asks(when):
            if not is_due(ask, place):
                continue
            if ask.wait_s:
                self._rests.rest(ask.wait_s)
            interview = Interview(self._context, self._events, ask, place)
            self._missed(interview.hold(after_withdrawal=after_withdrawal))
            if not after_withdrawal:
                self._screener.hear(ask, interview.answers)
                self._scores.hear(ask, interview.answers)
        self._texts.ask(when, place)

    def _trial(self, place: TrialPlace) -> None:
        """Expose, and ask how it was."""
        ending = self._trials.run(place)
        if ending.status != "skipped":
            self._ask_about(place, ending.reason)

    def _ask_about(self, place: TrialPlace, reason: Withdrew | StopRule | None) -> None:
        """Ask how an exposure was; raise the reason if the participant's study ends with it."""
        if reason is None:
            self._instructor.tell("after_trial", place)
            self._ask("after_trial", place)
            return
        self._events.event("exposure_stopped", detail=str(reason))
        try:
            self._ask("after_trial", place, after_withdrawal=True)
        except Withdrew as refusal:
            self._events.event("questionnaire_refused", detail=str(refusal))
        raise reason


def _undone_since(manifest: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the withdrawals that were undone after the run that a manifest tells of."""
    began = datetime.fromisoformat(manifest["started_at"])
    undone = manifest.get("withdrawals_undone", [])
    return [each for each in undone if datetime.fromisoformat(each["at"]) >= began]


def _places(sequence: Sequence, session: int) -> list[TrialPlace]:
    """Return the trials of a session; periods count over the sessions before it."""
    before = sum(len(each) for each in sequence.sessions[: session - 1])
    return [
        TrialPlace(before + number, 1, number, trial.condition, trial.scene, trial.part)
        for number, trial in enumerate(sequence.sessions[session - 1], start=1)
    ]
