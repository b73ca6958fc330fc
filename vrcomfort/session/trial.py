"""One trial: its exposure, its end, and its row."""

from __future__ import annotations

import hashlib
from collections import Counter
from dataclasses import dataclass
from functools import partial
from typing import Any

from vrcomfort.errors import RuntimeLostError, headset_ended
from vrcomfort.frame import HeadsetEvent
from vrcomfort.headset.base import CanSleep, Headset
from vrcomfort.operator_interface import ProgressKind
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.timeline import TrialPlace
from vrcomfort.records import ENDED_THE_STUDY, Interrupted, TrialRow
from vrcomfort.respondent import Exposure, Withdrew
from vrcomfort.session.adjustment import AdjustmentRun, Several, SliderRun
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.session.exposure import FrameLoop, Stimulus
from vrcomfort.session.frame_log import FrameLog, timing_row, trial_flags
from vrcomfort.session.interfaces import Activity
from vrcomfort.session.manifest_writer import ManifestWriter
from vrcomfort.session.no_frames import EventLoop
from vrcomfort.session.operator_control import Redone, Skipped
from vrcomfort.session.ratings import RatingSchedules, StopRule, schedules_of, trial_ending
from vrcomfort.session.start_pose import StartPose, start_pose_of
from vrcomfort.session.task_run import TaskRun
from vrcomfort.stop_signals import uninterrupted

IPD_TOLERANCE_M = 0.0015
"""Between what is measured and what is shown: rulers and scales of headsets tell millimetres."""


@dataclass
class Ending:
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


class TrialRunner:
    """Runs the trials of one session, one after the other.

    Parameters
    ----------
    trials
        How many the session has.
    interrupted
        How far an interrupted session came: attempts count on from there.
    """

    def __init__(
        self,
        context: SessionContext,
        *,
        events: EventLog,
        manifest: ManifestWriter,
        log: FrameLog,
        trials: int,
        interrupted: Interrupted | None,
    ) -> None:
        self._context = context
        self._events = events
        self._manifest = manifest
        self._log = log
        self._trials = trials
        self._interrupted = interrupted
        self._respondent = context.respondent
        self._operators = context.operators
        self._redone: Counter[int] = Counter()
        self._open: tuple[TrialPlace, Ending, FrameLoop | None] | None = None
        self._task: TaskRun | None = None
        self._adjustment: AdjustmentRun | None = None
        self._ipd_compared = False

    def run(self, place: TrialPlace) -> Ending:
        """Expose, again where an operator wants it so; return how the last attempt ended."""
        while (ending := self._attempt(place)).abort_code == "redone":
            self._redone[place.trial or 0] += 1
        return ending

    def give_up(self, abort_code: str) -> None:
        """Write the row of the exposure under way, while its own thread hangs.

        What the GPU still has (focus and times of the last frames) is lost.
        """
        if self._open is None:
            return
        place, ending, loop = self._open
        if loop is not None:
            loop.abandon()
        ending.abort_code = abort_code
        self._write_trial(place, ending)

    def _attempt(self, place: TrialPlace) -> Ending:
        """Expose, and write the trial's row in any case."""
        ending = Ending(self._context.clock.now_s())
        self._log.start_trial(place.trial or 0)
        self._open = place, ending, None
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
                self._open = None
                self._write_trial(place, ending)
        self._manifest.end_exposure(place.trial or 0)
        if ending.abort_code == "headset_ended":
            raise headset_ended("in the middle of an exposure")
        return ending

    def _expose(self, place: TrialPlace, ending: Ending) -> Withdrew | StopRule | None:
        """Show a trial; return the reason if the participant's study ends with it."""
        loop = self._enter(place)
        self._open = place, ending, loop
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
            self._respondent.end_exposure(loop.perceived_s)
        if result in {"completed", "task_done"}:
            ending.status = "completed"
            done = self._context.protocol.exposure_ends
            ending.abort_code = done if result == "task_done" else None
        else:
            ending.abort_code = result
        return None

    def _enter(self, place: TrialPlace) -> FrameLoop:
        context, protocol = self._context, self._context.protocol
        headset, start = self.start_pose_of(place)
        condition = protocol.condition(place.condition or "", place.scene)
        self._task = self._task_in(place, start.scene)
        self._adjustment = adjusting = self._adjustment_in(place)
        scene = self._task.drawn if self._task else start.scene
        context.renderer.begin(scene, adjusting.built_for if adjusting else condition)
        if adjusting:
            adjusting.show_start()
        loop = EventLoop if context.jumps else FrameLoop
        return loop(context, headset, self._events, self._log, start.path)

    def start_pose_of(self, place: TrialPlace) -> tuple[Headset, StartPose]:
        """Load a trial's scene, and lead the participant into it."""
        context, protocol = self._context, self._context.protocol
        if context.screen is not None:
            context.screen.show_loading()
        scene = context.load_scene(protocol.scene_source(place.scene))
        view = protocol.view(place.scene)
        start = start_pose_of(scene, view, walks=protocol.locomotion.mode != "off")
        headset = context.headset_for(view.scene, start.scene)
        self._manifest.note_headset(headset)
        self._compare_ipd(headset)
        self._operators.use(headset)
        return headset, start

    def _compare_ipd(self, headset: Headset) -> None:
        """Note, once, eyes that a worn headset shows closer or wider than the participant's."""
        measured_m, shown_m = self._context.ipd_measured_m, headset.details.get("ipd_m")
        worn = isinstance(headset, CanSleep)
        if not worn or self._ipd_compared or measured_m is None or shown_m is None:
            return
        self._ipd_compared = True
        if abs(measured_m - shown_m) > IPD_TOLERANCE_M:
            words = f"{1000 * shown_m:.1f} mm shown, {1000 * measured_m:.1f} mm measured"
            detail = f"distance between the eyes: {words}; set the headset's lenses to it"
            self._events.note(HeadsetEvent("ipd_differs", detail))

    def _task_in(self, place: TrialPlace, scene: Any) -> TaskRun | None:
        """Return the task of a trial, ready to begin."""
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
            duration_s=self._context.shown_s(place.scene),
        )

    def _adjustment_in(self, place: TrialPlace) -> AdjustmentRun | None:
        """Return the adjustment of a trial, ready to begin."""
        adjustment = self._context.protocol.adjustment_in(place.condition or "")
        known = self._of_dial(place)
        return None if adjustment is None else AdjustmentRun(**known, dial=adjustment)

    def _of_dial(self, place: TrialPlace) -> dict[str, Any]:
        known = self._identity(place, 0.0)
        return {
            "context": self._context,
            "events": self._events,
            "place": place,
            "attempt": known["attempt"],
            "resumed": bool(known["resumed"]),
        }

    def _activity(self, place: TrialPlace) -> Activity | None:
        """Return all that is done in a trial, and rated all through it."""
        slider = self._context.protocol.slider_in(place.condition or "")
        sliding = None if slider is None else SliderRun(**self._of_dial(place), dial=slider)
        parts = [each for each in (self._task, self._adjustment, sliding) if each is not None]
        return Several(parts) if parts else None

    def _train(self, loop: FrameLoop, place: TrialPlace, ending: Ending) -> None:
        """Show the first scene; a withdrawal here is an exposure of 0 s."""
        duration_s = self._context.protocol.training_s / self._context.time_scale
        if not duration_s:
            return
        while self._train_once(loop, place, ending, duration_s):
            pass

    def _train_once(
        self, loop: FrameLoop, place: TrialPlace, ending: Ending, duration_s: float
    ) -> bool:
        """Show the first scene; return whether an operator wants it once more."""
        start_s = self._context.clock.now_s()
        self._operators.begin("training", f"training in {place.scene}")
        stimulus = Stimulus(0, place.condition or "", duration_s, self._context.time_scale)
        try:
            loop.show(stimulus, progress=self._watch("training", place, duration_s))
        except (Redone, Skipped) as wish:
            return isinstance(wish, Redone)
        finally:
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
        words = f"exposure {number} of {self._trials}, attempt {attempt}: {_shown(place)}"
        self._operators.begin("exposure", words)
        try:
            return loop.show(
                Stimulus(number, condition, shown_s, full_s / shown_s),
                schedule=schedule,
                task=self._activity(place),
                progress=self._watch("exposure", place, shown_s),
            )
        finally:
            self._events.event("exposure", start_s, detail=_shown(place))
            self._note_clamps(place)

    def _ratings(self, number: int, full_s: float) -> RatingSchedules | None:
        """Return the schedules of ratings in an exposure; randomly drawn times are an event."""
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

    def _watch(self, step: ProgressKind, place: TrialPlace, total_s: float) -> partial[None]:
        return partial(self._events.tell, step, place, total=total_s)

    def _identity(self, place: TrialPlace, start_s: float) -> dict[str, Any]:
        """Return the fields of a trial's row that are known as the exposure begins."""
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

    def _write_trial(self, place: TrialPlace, ending: Ending) -> None:
        end_s, timing = self._context.clock.now_s(), self._log.timing_of(place.trial or 0)
        timing.seen.end(end_s - ending.start_s)
        trial = TrialRow(
            **self._identity(place, ending.start_s),
            end_s=end_s,
            status=ending.status,
            abort_code=ending.abort_code,
            frames=timing.frames,
            dropped=timing.dropped,
            missed_refreshes=timing.missed_refreshes,
            **timing.seen.cells(),
            part=place.part,
        )
        flags = trial_flags(timing, self._context.protocol)
        self._events.recorder.write(timing_row(trial, timing, flags), trial)
        if flags:
            text = f"trial {trial.trial}, attempt {trial.attempt}: {'; '.join(flags)}"
            self._manifest.flag(text)  # first: the event says that it is there
            self._events.event("timing_flag", detail=text)


def _ended_by(error: BaseException, protocol: Protocol) -> tuple[str, str] | None:
    """Return how the participant or the stop rule had ended the exposure before an error."""
    reason: BaseException | None = error
    while reason is not None:
        if isinstance(reason, Withdrew | StopRule):
            status, code = trial_ending(reason, protocol)
            return None if status == "completed" else (status, code)
        reason = reason.__context__
    return None


def _shown(place: TrialPlace) -> str:
    return f"{place.condition} in {place.scene}"
