"""One session: the steps of its timeline, one after the other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime
from typing import Any, Literal, NoReturn

from vrcomfort.geometry import Pose
from vrcomfort.operator_interface import RatedScale, SessionOrder
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.timeline import (
    BreakStep,
    ExposureStep,
    EyeHeightStep,
    FreeTextStep,
    GazeValidationStep,
    InstructionStep,
    PracticeStep,
    QuestionnaireStep,
    RestStep,
    Resumption,
    ScreeningStep,
    SessionPlan,
    Step,
    trial_places,
)
from vrcomfort.records import Interrupted
from vrcomfort.records.interruptions import RESUMED
from vrcomfort.respondent import Withdrew
from vrcomfort.scene.data import Scene
from vrcomfort.session.breaks import BreakRunner
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.session.eye_height import EyeHeight
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.session.gaze_validation import Validation
from vrcomfort.session.instructor import Instructor
from vrcomfort.session.interview import FreeTexts, Interview, OpenQuestions, ScreeningRunner
from vrcomfort.session.manifest_writer import ManifestWriter
from vrcomfort.session.operator_control import SessionTime
from vrcomfort.session.practice import PracticeRunner
from vrcomfort.session.ratings import ScoreWatch, StopRule, ends_of
from vrcomfort.session.trial import TrialRunner

SessionStatus = Literal["completed", "ended", "withdrawn", "aborted"]
"""`ended`: early, and the participant may come back for the next session."""


class SessionFlow:
    """Runs the steps of one session's timeline.

    Parameters
    ----------
    interrupted
        Progress of an interrupted session: it goes on with the steps that are left.
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
        self._interrupted = interrupted
        self._places = trial_places(context.sequence, events.session)
        self._timeline = tuple(
            SessionPlan(
                context.protocol,
                context.sequence,
                events.session,
                context.exposure_s,
                resumption_of(interrupted) if interrupted else None,
            ).steps()
        )
        self._trial: int | None = None
        self._skipped: set[int | None] = set()
        last_ns = interrupted.xr_time_ns if interrupted else None
        self._log = FrameLog(events.recorder, last_ns=last_ns)
        self._instructor = Instructor(context, events)
        self._breaks = BreakRunner(context, events, self._instructor, interrupted)
        self._open = (
            OpenQuestions(context, events, interrupted, self._breaks.rest) if interrupted else None
        )
        self._scores = ScoreWatch(context.protocol)
        self._texts = FreeTexts(context, events)
        self._screener = ScreeningRunner(context, events)
        self._operators = context.operators
        self._trials = TrialRunner(
            context,
            events=events,
            manifest=manifest,
            log=self._log,
            trials=len(self._places),
            interrupted=interrupted,
        )
        self._practice = PracticeRunner(context, events, self._log, self._trials, interrupted)
        self._validation: Validation | None = None

    def run(self) -> tuple[SessionStatus, str]:
        """Run the session; return how it ended and a note on why.

        Raises
        ------
        KeyboardInterrupt
            If the operator stopped it: all rows have been written.
        """
        self._begin()
        try:
            self._operators.await_start()
            self._end_if_ended_before()
            for step in self._timeline:
                if step.when != "after_trial" or step.place.trial not in self._skipped:
                    self._run_step(step)
        except (Withdrew, StopRule) as reason:
            return self._end_early(reason), str(reason)
        self._events.event("session_end")
        return "completed", ""

    def _end_early(self, reason: Withdrew | StopRule) -> SessionStatus:
        """Record the end of the participant's session, or study."""
        ends = ends_of(reason, self._context.protocol)
        status: SessionStatus = "ended" if ends == "session" else "withdrawn"
        by = reason.by if isinstance(reason, StopRule) else "participant"
        # First: whatever fails now, it is known.
        self._manifest.close(status, {"by": by, "ends": ends, "reason": str(reason)})
        self._events.event(status, detail=str(reason))
        return status

    def give_up(self, abort_code: str) -> None:
        """Write the row of the exposure under way, while its own thread hangs."""
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
        self._context.respondent.start_session(self._events.session)
        self._manifest.open()
        planned = [each for step in self._timeline for each in step.planned]
        time = SessionTime(planned, self._events.now_s)
        words = self._context.protocol.words
        self._operators.attach(self._events, self._context.screen, words=words, time=time)
        order = SessionOrder(
            self._context.participant,
            self._events.session,
            self._context.sequence.name,
            tuple(each.name for each in planned),
            lambda: time.position,
            time.remaining_s,
            tuple(_rated_scales(self._context.protocol)),
            lambda: self._manifest.headset,
        )
        self._operators.interface.open(order)

    def _run_step(self, step: Step, *, after_withdrawal: bool = False) -> None:
        """Run a step of the timeline.

        Parameters
        ----------
        after_withdrawal
            The session ends with the exposure before: its answers have no consequences.

        Raises
        ------
        Withdrew, StopRule
            If the participant's session, or study, ends with it.
        """
        self._note_boundary(step)
        match step:
            case ScreeningStep(of="ipd"):
                self._screener.look_at_ipd()
            case ScreeningStep():
                self._screener.check_covariates()
            case InstructionStep():
                self._instructor.tell(step)
            case RestStep():
                self._breaks.rest(step.duration_s)
            case BreakStep():
                self._breaks.hold_break(step)
            case QuestionnaireStep():
                self._ask(step, after_withdrawal=after_withdrawal)
            case FreeTextStep():
                self._texts.ask(step)
            case EyeHeightStep():
                headset, _ = self._trials.start_pose_of(step.place)
                log, manifest = self._log, self._manifest
                EyeHeight(self._context, self._events, log, manifest, step).measure(headset)
            case GazeValidationStep():
                self._validate_gaze(step)
            case PracticeStep():
                self._practice.run(step)
            case ExposureStep():
                self._expose(step)

    def _note_boundary(self, step: Step) -> None:
        """Keep the state between two exposures, at the first step before a trial."""
        trial = step.place.trial
        if trial and trial != self._trial and step.when != "after_trial":
            self._trial = trial
            self._manifest.boundary()

    def _validate_gaze(self, step: GazeValidationStep) -> None:
        if self._validation is None:  # one for all: it counts them
            self._validation = Validation(self._context, self._events, self._log, step.validation)
        headset, start = self._trials.start_pose_of(step.place)
        spawn = start.scene.spawn if isinstance(start.scene, Scene) else Pose()
        resumed = self._interrupted is not None
        if sentence := self._validation.hold(step, headset, spawn, resumed=resumed):
            self._manifest.miss(sentence)

    def _ask(self, step: QuestionnaireStep, *, after_withdrawal: bool) -> None:
        if step.owed and self._open is not None:
            self._missed(self._open.ask(step, after_withdrawal=after_withdrawal))
            return
        interview = Interview(self._context, self._events, step)
        self._missed(interview.hold(after_withdrawal=after_withdrawal))
        if not after_withdrawal:
            self._screener.hear(step.ask, interview.answers)
            self._scores.hear(step.ask, interview.answers)

    def _missed(self, sentences: list[str]) -> None:
        for sentence in sentences:
            self._manifest.miss(sentence)

    def _expose(self, step: ExposureStep) -> None:
        """Expose; where the session ends with it, ask about the exposure first."""
        ending = self._trials.run(step.place)
        if ending.status == "skipped":
            self._skipped.add(step.place.trial)
        elif ending.reason is not None:
            self._events.event("exposure_stopped", detail=str(ending.reason))
            later = self._timeline[self._timeline.index(step) + 1 :]
            self._end_after([each for each in later if each.place == step.place], ending.reason)

    def _end_if_ended_before(self) -> None:
        """End a session that had ended with its last exposure, before the interruption.

        Raises
        ------
        StopRule
            After the questions that were still open.
        """
        before = self._interrupted
        if before is None or before.ended_by is None or not before.last_trial:
            return
        told = f"{before.ended_by} in trial {before.last_trial}, before the session was interrupted"
        rule = StopRule(told, "session" if before.ended_session else "study", before.ended_by)
        self._end_after(self._timeline, rule)

    def _end_after(self, steps: Iterable[Step], reason: Withdrew | StopRule) -> NoReturn:
        """Ask the questions about the last exposure, which can be refused, and end."""
        try:
            for step in steps:
                if not isinstance(step, InstructionStep):
                    self._run_step(step, after_withdrawal=True)
        except Withdrew as refusal:
            self._events.event("questionnaire_refused", detail=str(refusal))
        raise reason


def resumption_of(before: Interrupted) -> Resumption:
    """Return the progress of an interrupted session, as its timeline needs it."""
    over = {name for name, practised in before.practised.items() if practised.over}
    ended = before.ended_by is not None
    return Resumption(before.done, before.last_trial, before.attempts, over, ended=ended)


def _undone_since(manifest: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the withdrawals that were undone after the run that a manifest tells of."""
    began = datetime.fromisoformat(manifest["started_at"])
    undone = manifest.get("withdrawals_undone", [])
    return [each for each in undone if datetime.fromisoformat(each["at"]) >= began]


def _rated_scales(protocol: Protocol) -> Iterator[RatedScale]:
    """Yield the scales of the questions during exposure."""
    for each in protocol.ratings:
        asked = protocol.rated(each)
        yield RatedScale(asked.name, asked.low, asked.high, each.stop_at, each.stop_in_a_row)
