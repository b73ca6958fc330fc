"""The frame loop of an exposure, and the clocks that are read in it."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from vrcomfort.frame import Frame, GpuTime
from vrcomfort.geometry import Pose
from vrcomfort.headset.base import HasDisplayClock, HasWaits, Headset
from vrcomfort.headset.timing import RATE_CHANGED, RATE_RESTORED
from vrcomfort.records import ClockRow, RatingRow, Recorder
from vrcomfort.render.display import PatchLight
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.scene.camera_path import CameraPath
from vrcomfort.seen_time import FREEZE_S, UNSEEN, ShownFrame, display_intervals
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.session.interfaces import Activity
from vrcomfort.session.operator_control import Redone, Skipped
from vrcomfort.session.ratings import Rated, RatingSchedule, RatingSchedules
from vrcomfort.stop_signals import interruptible, uninterrupted

_TRIES = 3
"""The reading that took the least time is kept: others were interrupted."""


@dataclass
class ClockBridge:
    """Writes ``clocks.csv``, and puts display times on the system's monotonic clock meanwhile.

    Simulated participants live in no time of the system's: nothing is read then.
    """

    context: SessionContext
    recorder: Recorder
    _monotonic_minus_display_ns: int | None = None

    def read(self, headset: Headset, recorded_minus_display_ns: int) -> None:
        """Read all clocks, and write them without waiting.

        Parameters
        ----------
        recorded_minus_display_ns
            What is added to the headset's display times in the files of a session.
        """
        if not self.context.clock.is_real:
            return
        row, display_ns = min(
            (self._reading(headset) for _ in range(_TRIES)), key=lambda each: each[0].took_ns
        )
        if display_ns is not None:
            self._monotonic_minus_display_ns = row.monotonic_ns - display_ns
            row = ClockRow(
                row.session_s,
                display_ns + recorded_minus_display_ns,
                row.monotonic_ns,
                row.unix_ns,
                row.lsl_s,
                row.took_ns,
            )
        self.recorder.write_soon(row)

    def monotonic_ns(self, display_ns: int) -> int | None:
        """Return a display time on the system's monotonic clock; None where it is not known."""
        offset_ns = self._monotonic_minus_display_ns
        return None if offset_ns is None else display_ns + offset_ns

    def _reading(self, headset: Headset) -> tuple[ClockRow, int | None]:
        before_ns = time.monotonic_ns()
        display_ns = headset.display_now_ns() if isinstance(headset, HasDisplayClock) else None
        unix_ns = time.time_ns()
        lsl_s = self.context.outlet.now_s()
        session_s = self.context.clock.now_s()
        after_ns = time.monotonic_ns()
        middle_ns = (before_ns + after_ns) // 2
        row = ClockRow(session_s, None, middle_ns, unix_ns, lsl_s, after_ns - before_ns)
        return row, display_ns


@contextmanager
def collector_at_rest() -> Iterator[None]:
    """Let Python's collector of cycles look at nothing that is there now.

    Looking at everything takes as long as some frames; what frames make is little.
    """
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


Ending = Literal["completed", "task_done", "headset_ended"]

CLOCKS_EVERY_S = 10.0
"""Interval between two readings of all clocks in an exposure, the first at its first frame."""


@dataclass(frozen=True)
class Stimulus:
    """An exposure's stimulus: its trial number, condition and duration.

    Parameters
    ----------
    trial
        0 in training.
    duration_s
        What is shown.
    time_scale
        The protocol's seconds for each shown second.
    """

    trial: int
    condition: str
    duration_s: float
    time_scale: float = 1.0


def _no_waits() -> None:
    """Return nothing: no runtime makes frames wait."""


@dataclass
class FrameLoop:
    """Takes frames of a headset through the renderer; training and exposure share its frames."""

    context: SessionContext
    headset: Headset
    events: EventLog
    log: FrameLog
    path: CameraPath | None = None
    """Along which the participant is carried, from the beginning of training and exposure."""
    elapsed_s: float = 0.0
    """Seconds of the exposure that have been shown."""
    perceived_s: float = 0.0
    """The same in the protocol's time."""

    def __post_init__(self) -> None:
        self._frames: Iterator[Frame] = iter(self.headset.frames())
        self._scene_start_ns: int | None = None
        self._rating: tuple[Stimulus, RatingSchedules] | None = None
        self._cut_unseen = self._snap_unseen = False
        self._was_paused = self._back_at_start = False
        self._clocks = ClockBridge(self.context, self.events.recorder)
        self._clocks_due_s: float | None = None
        self._task: Activity | None = None
        self._light: PatchLight | None = None
        self._waits = self.headset.waits if isinstance(self.headset, HasWaits) else _no_waits
        self._light_told = False

    def show(
        self,
        stimulus: Stimulus,
        *,
        schedule: RatingSchedules | None = None,
        task: Activity | None = None,
        progress: Callable[[float], None],
    ) -> Ending:
        """Show frames for `stimulus.duration_s`, as counted by their display times.

        Raises
        ------
        Withdrew, StopRule, Skipped, Redone
            If the participant, a rating or an operator ends the exposure. Everything shown is
            logged.
        """
        self.elapsed_s = self.perceived_s = 0.0
        self._back_at_start = self.path is not None
        self.log.start_trial(stimulus.trial)
        self._rating = (stimulus, schedule) if schedule else None
        self._clocks_due_s = None
        photodiode = self.context.protocol.photodiode
        self._light = PatchLight(photodiode) if photodiode and stimulus.trial else None
        self._light_told = False
        self._task = task
        with uninterrupted():  # but for the wait for a frame: what was shown is recorded
            try:
                with collector_at_rest():
                    return self._run(stimulus, schedule, progress)
            finally:
                self._finish(stimulus)

    def _finish(self, stimulus: Stimulus) -> None:
        """Write everything that waits."""
        try:
            renderer = self.context.renderer
            hashes = renderer.drain_hashes()
            hits = renderer.drain_gaze_hits()
            parts = renderer.drain_part_times()
            self.log.finish(renderer.drain(), self._late_times(), hashes, hits, parts)
        finally:  # a disk that refuses a frame may yet take a rating
            self._close_rating()
            self._finish_task()
            self._end_outlet(stimulus)

    def _end_outlet(self, stimulus: Stimulus) -> None:
        outlet = self.context.outlet
        outlet.end_exposure(stimulus.trial)
        if left_out := outlet.take_left_out():
            detail = f"{left_out} samples: other devices were too slow to take them"
            self.events.event_soon("not_passed_on", detail=detail)

    def abandon(self) -> None:
        """Write all rows that wait, from another thread, while the loop's own hangs."""
        self.log.finish()
        self._close_rating()
        self._finish_task()

    def _finish_task(self) -> None:
        task, self._task = self._task, None
        if task is not None:
            task.finish()

    def _close_rating(self) -> None:
        open_rating, self._rating = self._rating, None
        if open_rating is not None and (rated := open_rating[1].close()):
            self._record(open_rating[0], *rated)

    def _run(
        self,
        stimulus: Stimulus,
        schedule: RatingSchedules | None,
        progress: Callable[[float], None],
    ) -> Ending:
        shown_ns, before, counted = 0, None, False
        for headset_frame in interruptible(self._frames):
            self._note_events()
            frame = self._commanded(headset_frame)
            exposed_ns = 0
            if before is not None:
                intervals = list(display_intervals(ShownFrame.of(before), ShownFrame.of(frame)))
                self.context.clock.advance(sum(ns for _, ns in intervals) / 1e9)
                if counted:
                    exposed_ns = sum(ns for state, ns in intervals if state not in UNSEEN)
            shown_ns += exposed_ns
            before, counted = frame, self._counts(frame)
            self.elapsed_s = shown_ns / 1e9
            self.perceived_s = self.elapsed_s * stimulus.time_scale
            if not counted:
                self._wait(frame, stimulus)
                continue
            shown = self._carried(frame)
            if self._task is not None:
                self._task.step(shown, self.headset, self.elapsed_s, self._scene_time_s(frame))
            self._draw(shown, stimulus)
            if schedule and (exposed_ns - frame.period_ns) / 1e9 > FREEZE_S:
                self._miss(stimulus, schedule)
            self._listen(stimulus, schedule)
            progress(self.elapsed_s)
            if self._task is not None and self._task.done:
                self.context.clock.advance(frame.period_ns / 1e9)
                return "task_done"
            # The next frame would lie more than half outside.
            if self.elapsed_s + 1.5 * frame.period_ns / 1e9 > stimulus.duration_s:
                self.context.clock.advance(frame.period_ns / 1e9)
                self.elapsed_s = stimulus.duration_s
                self.perceived_s = self.elapsed_s * stimulus.time_scale
                return "completed"
        return "headset_ended"

    def _counts(self, frame: Frame) -> bool:
        """Return whether a frame's time is exposure."""
        return frame.seen and not (frame.unfocused and self.context.protocol.unfocused == "pause")

    def _wait(self, frame: Frame, stimulus: Stimulus) -> None:
        """Show a frame outside the exposure's time, or take note of it."""
        if frame.paused:  # nobody sees it
            self.headset.submit(frame, None)
            now_s = self.context.clock.now_s()
            self.log.add_paused(frame, trial=stimulus.trial, session_s=now_s)
            self.context.operators.interface.see(frame, None, self.log.timing)
        else:
            self._draw(self._carried(frame), stimulus)
        self.context.respondent.update(self.perceived_s)

    def _commanded(self, frame: Frame) -> Frame:
        """Carry out operators' commands; return the frame, hidden while the session is paused."""
        operators = self.context.operators
        try:
            operators.look()
        except (Skipped, Redone):
            # The last frame was seen for its period.
            self.context.clock.advance(frame.period_ns / 1e9)
            raise
        was_paused, self._was_paused = self._was_paused, operators.paused
        if operators.paused:
            return replace(frame, paused=True)
        return replace(frame, discontinuity=True) if was_paused else frame

    def _late_times(self) -> Sequence[GpuTime]:
        return self.context.renderer.drain_times() if self.log.times_gpu else ()

    def _note_events(self) -> None:
        for event in self.headset.take_events():
            self.events.note(event)
            if event.name in (RATE_CHANGED, RATE_RESTORED):
                changed = event.name == RATE_CHANGED
                self.log.note_rate_change(event.detail if changed else "")
        self.events.report_file_changes()

    def _scene_time_s(self, frame: Frame) -> float:
        """Return the time of the scene's animations, which begins with its first frame."""
        if self._scene_start_ns is None:
            self._scene_start_ns = frame.predicted_display_time_ns
        return (frame.predicted_display_time_ns - self._scene_start_ns) / 1e9

    def _draw(self, frame: Frame, stimulus: Stimulus) -> None:
        scene_time_s = self._scene_time_s(frame)
        rendered = None
        if frame.should_render:
            shown = self._with_patch(self._with_unseen_jumps(frame))
            rendered = self.context.renderer.render(shown, scene_time_s)
        else:
            self._cut_unseen |= frame.discontinuity
            self._snap_unseen |= frame.snap_turn
        self.headset.submit(frame, rendered.eyes if rendered else None)
        self.log.add(
            frame,
            rendered,
            trial=stimulus.trial,
            session_s=self.context.clock.now_s(),
            balls=self._task.changed() if self._task and stimulus.trial else (),
            waits=self._waits(),
        )
        self.context.operators.interface.see(frame, rendered, self.log.timing)
        if frame.seen:
            self._pass_on(frame, stimulus)

    def _with_patch(self, frame: Frame) -> Frame:
        """Return a frame with the patch for a photodiode: black in training."""
        if self.context.protocol.photodiode is None:
            return frame
        time_ns = frame.predicted_display_time_ns
        return replace(frame, patch=self._light is not None and self._light.of_next(time_ns))

    def _pass_on(self, frame: Frame, stimulus: Stimulus) -> None:
        """Tell other devices of a frame that was submitted; read all clocks now and then."""
        begins = self._clocks_due_s is None
        if self._clocks_due_s is None or self.elapsed_s >= self._clocks_due_s:
            self._clocks.read(self.headset, self.log.recorded_minus_display_ns)
            self._clocks_due_s = self.elapsed_s + CLOCKS_EVERY_S
        outlet = self.context.outlet
        seen_ns = self._clocks.monotonic_ns(frame.predicted_display_time_ns)
        if begins:
            outlet.begin_exposure(stimulus.trial, stimulus.condition, seen_ns)
        if self._light is not None and self._light.has_begun and not self._light_told:
            self._light_told = True
            time_ns = frame.predicted_display_time_ns + self.log.recorded_minus_display_ns
            self.events.event_soon("photodiode", detail=f"white from xr_time_ns {time_ns} on")
        outlet.show(frame, seen_ns)

    def _carried(self, frame: Frame) -> Frame:
        """Return a frame where the path has taken the participant, by shown time."""
        if offset_m := self.context.floor.offset_m:
            lifted = Pose(np.array([0.0, offset_m, 0.0])) @ frame.avatar_pose
            frame = replace(frame, avatar_pose=lifted)
        if self.path is None:
            return self._with_eyes(frame)
        jump, self._back_at_start = self._back_at_start, False
        avatar = self.path.moved(self.elapsed_s) @ frame.avatar_pose
        carried = replace(frame, avatar_pose=avatar, discontinuity=frame.discontinuity or jump)
        return self._with_eyes(carried)

    def _with_eyes(self, frame: Frame) -> Frame:
        """Return a frame with the gaze of a simulated participant, where there is none."""
        respondent = self.context.respondent
        if frame.gaze is not None or not isinstance(respondent, SimulatedRespondent):
            return frame
        if not respondent.has_eyes:
            return frame
        demand = self._task.demand(frame) if self._task else None
        point = (
            None
            if demand is None
            else (frame.avatar_pose.inverse() @ Pose(demand.position_m)).position
        )
        gaze = respondent.look(frame.predicted_display_time_ns / 1e9, frame.head_pose, point)
        return frame if gaze is None else replace(frame, gaze=gaze)

    def _with_unseen_jumps(self, frame: Frame) -> Frame:
        """Tell the renderer of jumps in frames that the runtime did not want drawn."""
        cut, snap = self._cut_unseen, self._snap_unseen
        self._cut_unseen = self._snap_unseen = False
        if not (cut or snap):
            return frame
        return replace(
            frame,
            discontinuity=frame.discontinuity or cut,
            snap_turn=frame.snap_turn or snap,
        )

    def _listen(self, stimulus: Stimulus, schedule: RatingSchedules | None) -> None:
        self.context.respondent.update(self.perceived_s)
        if schedule and (rated := schedule.update(self.perceived_s, self.context.clock.now_s())):
            self._record(stimulus, *rated)
            rated[0].check(rated[1])

    def _miss(self, stimulus: Stimulus, schedule: RatingSchedules) -> None:
        now_s = self.context.clock.now_s()
        for missed in schedule.missed_while_frozen(self.perceived_s, now_s, stimulus.time_scale):
            self._record(stimulus, *missed)

    def _record(self, stimulus: Stimulus, schedule: RatingSchedule, rated: Rated) -> None:
        row = RatingRow(
            self.context.participant,
            self.events.session,
            stimulus.trial,
            stimulus.condition,
            onset_s=rated.onset_s,
            latency_s=None if rated.latency_s is None else round(rated.latency_s, 9),
            instrument=schedule.instrument.name,
            response=rated.response,
            missed=schedule.missed_code if rated.response is None else 0,
        )
        self.context.outlet.rate(row)
        self.events.recorder.write_soon(row)
        self.context.operators.interface.rated(
            schedule.instrument.name, self.perceived_s, rated.response
        )
