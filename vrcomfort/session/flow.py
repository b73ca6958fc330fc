"""One session from its first question to its last."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from typing import Any, Literal

from vrcomfort.errors import RuntimeLostError, headset_ended
from vrcomfort.geometry import Pose
from vrcomfort.headset.base import Headset
from vrcomfort.protocol import Protocol, Sequence
from vrcomfort.records import ENDED_THE_STUDY, Interrupted, TrialRow
from vrcomfort.respondent import Exposure, Withdrew
from vrcomfort.scene.data import Scene
from vrcomfort.session.compared import is_due
from vrcomfort.session.context import SessionContext
from vrcomfort.session.event_log import EventLog, TrialPlace
from vrcomfort.session.exposure import FrameLoop, Stimulus
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.session.gaze_validation import Validation
from vrcomfort.session.interfaces import Step
from vrcomfort.session.interview import Interview
from vrcomfort.session.manifest_writer import ManifestWriter
from vrcomfort.session.no_frames import EventLoop
from vrcomfort.session.open_questions import OpenQuestions
from vrcomfort.session.operator_desk import SessionOrder
from vrcomfort.session.ratings import RatingSchedules, schedules_of
from vrcomfort.session.standing import Standing, stand
from vrcomfort.session.steering import Redone, Skipped
from vrcomfort.session.stop_rules import (
    ScoreWatch,
    StopRule,
    ends_of,
    trial_ending,
)
from vrcomfort.session.task_run import TaskRun
from vrcomfort.session.timing import timing_row, trial_flags
from vrcomfort.stop_signals import uninterrupted

REST_SLICE_S = 0.2
"""So often a rest looks up."""

SessionStatus = Literal["completed", "ended", "withdrawn", "aborted"]
"""`ended`: early, and the participant may come back for the next session."""


@dataclass
class _Ending:
    """When an exposure began and how it ended; an error unless something better is known."""

    start_s: float
    status: str = "aborted"
    abort_code: str | None = "error"
    reason: Withdrew | StopRule | None = None
    """Why the participant's study ends with it."""

    @property
    def ended_the_study(self) -> bool:
        """Whether the participant, or the stop rule, has ended it."""
        return self.status in ENDED_THE_STUDY


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
        self._open = (
            OpenQuestions(context, events, interrupted, self._rest) if interrupted else None
        )
        self._scores = ScoreWatch(context.protocol)
        self._steering = context.steering
        self._redone: Counter[int] = Counter()
        self._open_trial: tuple[TrialPlace, _Ending, FrameLoop | None] | None = None
        self._task: TaskRun | None = None
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
        """Write what is known of the exposure under way, while its own thread hangs.

        What the GPU still has (focus and times of the last frames) is lost.
        """
        if self._open_trial is not None:
            place, ending, loop = self._open_trial
            if loop is not None:
                loop.abandon()
            ending.abort_code = abort_code
            self._write_trial(place, ending)
        self._events.event(abort_code)

    def _begin(self) -> None:
        before = self._interrupted
        self._context.clock.start(before.session_s if before else 0.0)
        if before:
            self._events.event("session_resumed", detail=f"after exposure {before.done}")
            for undone in _undone_since(before.manifest):
                self._events.event("withdrawal_undone", detail=str(undone["reason"]))
            for warning in before.warnings:
                self._events.event("row_cut_off", detail=warning)
        else:
            self._events.event("session_start")
        self._respondent.start_session(self._events.session)
        self._manifest.open()
        self._steering.attach(self._events, self._context.screen)
        shown = tuple((place.scene, place.condition or "") for place in self._places)
        name, who = self._context.sequence.name, self._context.participant
        self._steering.desk.open(SessionOrder(who, self._events.session, name, shown))

    def _everything(self) -> None:
        places = self._places[self._interrupted.done if self._interrupted else 0 :]
        self._ask_what_was_open()
        if places:  # else only the end is left, and nothing to be a baseline of
            self._ask("session_start", TrialPlace())
        for index, place in enumerate(places):
            self._manifest.boundary()
            if index and self._context.protocol.break_s:
                self._rest(self._context.protocol.break_s)
            self._validate_gaze(place, first=index == 0)
            self._ask("before_trial", place)
            self._trial(place)
        if places or self._open is None:
            self._ask("session_end", TrialPlace())
        else:
            self._missed(self._open.ask("session_end", TrialPlace()))

    def _validate_gaze(self, place: TrialPlace, *, first: bool) -> None:
        """Validate the eye tracker at the session's start, and after breaks."""
        protocol = self._context.protocol
        settings = protocol.gaze_validation
        again = settings is not None and settings.after_breaks and protocol.break_s > 0
        if self._validation is None or not (first or again):
            return
        headset, standing = self._stand(place)
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
                self._rest(ask.wait_s)
            interview = Interview(self._context, self._events, ask, place)
            self._missed(interview.hold(after_withdrawal=after_withdrawal))
            if not after_withdrawal:
                self._scores.hear(ask, interview.answers)

    def _rest(self, duration_s: float) -> None:
        """Wait; in slices, so that progress can be shown, and a wish to stop be heard."""
        clock = self._context.clock
        start_s = clock.now_s()
        paused_s = 0.0
        self._steering.begin("rest", f"rest of {duration_s:g} s")
        try:
            while (left_s := duration_s - (clock.now_s() - start_s - paused_s)) > 1e-6:
                self._events.tell("rest", TrialPlace(), duration_s - left_s, duration_s)
                paused_s += self._rest_a_moment(left_s)
            self._respondent.rest(duration_s)
        except Skipped:
            self._respondent.rest(clock.now_s() - start_s)
        finally:
            self._events.event("rest", start_s)

    def _rest_a_moment(self, left_s: float) -> float:
        """Let a slice of a rest pass; return how much of it was paused."""
        clock = self._context.clock
        self._steering.look()
        before_s, paused = clock.now_s(), self._steering.paused
        if not self._respondent.resting(left_s):
            clock.wait(left_s if self._context.jumps else min(left_s, REST_SLICE_S))
        return clock.now_s() - before_s if paused else 0.0

    def _trial(self, place: TrialPlace) -> None:
        """Expose, again where an operator wants it so, and ask how it was."""
        while (ending := self._attempt(place)).abort_code == "redone":
            self._redone[place.trial or 0] += 1
        if ending.status != "skipped":
            self._ask_about(place, ending.reason)

    def _ask_about(self, place: TrialPlace, reason: Withdrew | StopRule | None) -> None:
        """Ask how an exposure was; raise the reason if the participant's study ends with it."""
        if reason is None:
            self._ask("after_trial", place)
            return
        self._events.event("exposure_stopped", detail=str(reason))
        try:
            self._ask("after_trial", place, after_withdrawal=True)
        except Withdrew as refusal:
            self._events.event("questionnaire_refused", detail=str(refusal))
        raise reason

    def _attempt(self, place: TrialPlace) -> _Ending:
        """Expose, and write the trial's row whatever happens."""
        ending = _Ending(self._context.clock.now_s())
        self._log.start_trial()
        self._open_trial = place, ending, None
        try:
            ending.reason = self._expose(place, ending)
        except KeyboardInterrupt:
            ending.abort_code = ending.abort_code if ending.ended_the_study else "operator"
            raise
        except RuntimeLostError:
            ending.abort_code = ending.abort_code if ending.ended_the_study else "runtime_lost"
            raise
        finally:
            with uninterrupted():
                self._open_trial = None
                self._write_trial(place, ending)
        self._manifest.end_exposure(place.trial or 0)
        if ending.abort_code == "headset_ended":
            raise headset_ended("in the middle of an exposure")
        return ending

    def _expose(self, place: TrialPlace, ending: _Ending) -> Withdrew | StopRule | None:
        """Show a trial; return the reason if the participant's study ends with it."""
        loop = self._enter(place)
        self._open_trial = place, ending, loop
        try:
            if place.trial == 1 and not self._redone[1]:
                self._train(loop, place, ending)
            ending.start_s = self._context.clock.now_s()
            self._manifest.begin_exposure(**self._identity(place, ending.start_s))
            result = self._show(loop, place)
        except (Withdrew, StopRule) as reason:
            ending.status, ending.abort_code = trial_ending(reason, self._context.protocol)
            if ending.status != "completed":
                return reason
            self._events.event("exposure_ended", detail=str(reason))
            return None
        except Skipped:
            ending.status, ending.abort_code = "skipped", "operator"
            return None
        except Redone:
            ending.abort_code = "redone"
            return None
        except BaseException as error:
            how = _ended_by(error, self._context.protocol)
            if how is not None:  # and then something failed
                ending.status, ending.abort_code = how
            raise
        finally:
            self._respondent.end_exposure(loop.felt_s)
        if result in {"completed", "task_done"}:
            ending.status = "completed"
            ending.abort_code = "task" if result == "task_done" else None
        else:
            ending.abort_code = result
        return None

    def _enter(self, place: TrialPlace) -> FrameLoop:
        context, protocol = self._context, self._context.protocol
        headset, standing = self._stand(place)
        condition = protocol.condition(place.condition or "")
        self._task = self._task_in(place, standing.scene)
        context.renderer.begin(self._task.drawn if self._task else standing.scene, condition)
        self._log.focus_follows_gaze = condition.focus.method == "gaze"
        loop = EventLoop if context.jumps else FrameLoop
        return loop(context, headset, self._events, self._log, standing.path)

    def _stand(self, place: TrialPlace) -> tuple[Headset, Standing]:
        """Load a trial's scene, and lead the participant into it."""
        context, protocol = self._context, self._context.protocol
        if context.screen is not None:
            context.screen.show_loading()
        scene = context.load_scene(protocol.scene_source(place.scene))
        view = protocol.view(place.scene)
        standing = stand(scene, view, walks=protocol.locomotion.mode != "off")
        headset = context.headset_for(view.scene, standing.scene)
        self._manifest.note_headset(headset)
        self._steering.use(headset)
        return headset, standing

    def _task_in(self, place: TrialPlace, scene: Any) -> TaskRun | None:
        """Return what is done in a trial, ready to begin."""
        number = place.trial or 0
        trial = self._context.sequence.sessions[self._events.session - 1][number - 1]
        settings = self._context.protocol.task_of(trial)
        if settings is None:
            return None
        known = self._identity(place, 0.0)
        return TaskRun(
            self._context,
            self._events,
            place,
            settings,
            scene,
            attempt=known["attempt"],
            resumed=bool(known["resumed"]),
        )

    def _train(self, loop: FrameLoop, place: TrialPlace, ending: _Ending) -> None:
        """Show the first scene; who withdraws here has an exposure of 0 s."""
        duration_s = self._context.protocol.training_s / self._context.stretch
        if not duration_s:
            return
        while self._train_once(loop, place, ending, duration_s):
            pass

    def _train_once(
        self, loop: FrameLoop, place: TrialPlace, ending: _Ending, duration_s: float
    ) -> bool:
        """Show the first scene; return whether an operator wants it once more."""
        start_s = self._context.clock.now_s()
        self._steering.begin("training", f"training in {place.scene}")
        stimulus = Stimulus(0, place.condition or "", duration_s, self._context.stretch)
        try:
            loop.show(stimulus, progress=self._watch("training", place, duration_s))
        except (Redone, Skipped) as wish:
            return isinstance(wish, Redone)
        finally:
            self._log.start_trial()  # its frames are not the exposure's
            ending.start_s = self._context.clock.now_s()
            self._events.event("training", start_s, detail=_shown(place))
        return False

    def _show(self, loop: FrameLoop, place: TrialPlace) -> str:
        protocol, number = self._context.protocol, place.trial or 0
        condition, full_s = place.condition or "", protocol.length_s(place.scene)
        shown_s = self._context.shown_s(place.scene)
        self._respondent.start_exposure(
            Exposure(self._events.session, number, place.scene, condition, full_s)
        )
        schedule = self._ratings(number, full_s)
        start_s = self._context.clock.now_s()
        attempt = self._attempts_before(number) + 1
        words = f"exposure {number} of {len(self._places)}, attempt {attempt}: {_shown(place)}"
        self._steering.begin("exposure", words)
        try:
            return loop.show(
                Stimulus(number, condition, shown_s, full_s / shown_s),
                schedule=schedule,
                task=self._task,
                progress=self._watch("exposure", place, shown_s),
            )
        finally:
            self._events.event("exposure", start_s, detail=_shown(place))
            self._note_clamps(place)

    def _ratings(self, number: int, full_s: float) -> RatingSchedules | None:
        """Return when what is asked during an exposure; times that were drawn are an event."""
        context = self._context
        if not context.protocol.ratings:
            return None
        person = int.from_bytes(hashlib.sha256(context.participant.encode()).digest()[:4])
        key = context.seed, person, self._events.session, number
        schedules = schedules_of(context.protocol, self._respondent, full_s, *key)
        if any(each.jitter_s for each in context.protocol.ratings):
            self._events.event("ratings_planned", detail=schedules.planned)
        return schedules

    def _note_clamps(self, place: TrialPlace) -> None:
        """Write down which limits have shortened a blur; only now, for this waits for the GPU."""
        for sentence in self._context.renderer.clamps():
            self._events.event("blur_limited", detail=sentence)
            self._manifest.clamp(f"{_shown(place)}: {sentence}")

    def _watch(self, step: Step, place: TrialPlace, total_s: float) -> partial[None]:
        return partial(self._events.tell, step, place, total=total_s)

    def _identity(self, place: TrialPlace, start_s: float) -> dict[str, Any]:
        """Return what is known of a trial's row when the exposure begins."""
        return {
            "participant": self._context.participant,
            "session": self._events.session,
            "period": place.period or 0,
            "block": place.block or 0,
            "trial": place.trial or 0,
            "condition": place.condition or "",
            "scene": place.scene,
            "start_s": start_s,
            "attempt": self._attempts_before(place.trial or 0) + 1,
            "resumed": int(self._interrupted is not None),
        }

    def _attempts_before(self, trial: int) -> int:
        """Return how often a trial was begun, but for the attempt under way."""
        before = self._interrupted.attempts if self._interrupted else {}
        return before.get(trial, 0) + self._redone[trial]

    def _write_trial(self, place: TrialPlace, ending: _Ending) -> None:
        trial = TrialRow(
            **self._identity(place, ending.start_s),
            end_s=self._context.clock.now_s(),
            status=ending.status,
            abort_code=ending.abort_code,
            frames=self._log.frames,
            dropped=self._log.dropped,
            missed_refreshes=self._log.timing.missed_refreshes,
            **self._log.timing.seen.cells(),
        )
        flags = trial_flags(self._log.timing, self._context.protocol.max_dropped_percent)
        self._events.recorder.write(timing_row(trial, self._log.timing, flags), trial)
        if flags:
            text = f"trial {trial.trial}, attempt {trial.attempt}: {'; '.join(flags)}"
            self._events.event("timing_flag", detail=text)
            self._manifest.flag(text)


def _undone_since(manifest: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the withdrawals that were undone after the run that a manifest tells of."""
    began = datetime.fromisoformat(manifest["started_at"])
    undone = manifest.get("withdrawals_undone", [])
    return [each for each in undone if datetime.fromisoformat(each["at"]) >= began]


def _ended_by(error: BaseException, protocol: Protocol) -> tuple[str, str] | None:
    """Return how the participant or the stop rule had ended the exposure before an error."""
    reason: BaseException | None = error
    while reason is not None:
        if isinstance(reason, Withdrew | StopRule):
            status, code = trial_ending(reason, protocol)
            return None if status == "completed" else (status, code)
        reason = reason.__context__
    return None


def _places(sequence: Sequence, session: int) -> list[TrialPlace]:
    """Return the trials of a session; periods count over the sessions before it."""
    before = sum(len(each) for each in sequence.sessions[: session - 1])
    return [
        TrialPlace(before + number, 1, number, trial.condition, trial.scene)
        for number, trial in enumerate(sequence.sessions[session - 1], start=1)
    ]


def _shown(place: TrialPlace) -> str:
    return f"{place.condition} in {place.scene}"
