"""Rows of ``frames.csv``: each waits for its focus and GPU time, which arrive some frames late."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import NamedTuple, Protocol

from vrcomfort.frame import FocusSample, Frame, GazeHit, GpuTime, ImageHash, RenderResult
from vrcomfort.records import BallRow, FrameRow, GazeRow, ImageRow, Row
from vrcomfort.scene.markers import Shown
from vrcomfort.session.timing import TrialTiming, missed_refreshes

_LATEST_FRAMES = 16
"""What has not come after so many frames does not come: the row is written without."""


class _Waiting(NamedTuple):
    """A row but for what is late: it is made once, when all is there."""

    row: partial[FrameRow]
    gaze: GazeRow | None
    seeks_gaze: bool
    image: partial[ImageRow] | None


class RowWriter(Protocol):
    """Where rows go: a session's recorder, or one file."""

    def write(self, *rows: Row) -> None:
        """Append rows."""


class FrameLog:
    """The frame rows of one session, in order.

    Parameters
    ----------
    last_ns
        Time of the last frame on record, where an interrupted session goes on.

    Attributes
    ----------
    timing
        Of the trial since `start_trial`.
    times_gpu
        Whether the renderer times the GPU.
    """

    def __init__(self, recorder: RowWriter, *, last_ns: int | None = None) -> None:
        self._recorder = recorder
        self._waiting: OrderedDict[int, _Waiting] = OrderedDict()
        self._focus: dict[int, FocusSample] = {}
        self._gpu_ms: dict[int, float] = {}
        self._hashes: dict[int, ImageHash] = {}
        self._hits: dict[int, GazeHit] = {}
        self._offset_ns = 0
        self._last_ns = last_ns
        self.times_gpu = False
        self.start_trial()

    @property
    def frames(self) -> int:
        """Return the frames of the trial."""
        return self.timing.frames

    @property
    def dropped(self) -> int:
        """Return the dropped frames of the trial."""
        return self.timing.dropped

    @property
    def recorded_minus_display_ns(self) -> int:
        """Return what is added to display times, so that time on record runs forwards."""
        return self._offset_ns

    def start_trial(self) -> None:
        """Count from zero; the first interval is none."""
        self.timing = TrialTiming()
        self._shown_ns: int | None = None

    def add(
        self,
        frame: Frame,
        rendered: RenderResult | None,
        *,
        trial: int,
        session_s: float,
        balls: Iterable[Shown] = (),
    ) -> None:
        """Take a frame, and whatever focus and GPU times arrived with it.

        `balls` are those that are drawn otherwise from this frame on.
        """
        missed, time_ns = self._count(frame), self._continuous_ns(frame)
        row = partial(
            FrameRow,
            session_s=session_s,
            xr_time_ns=time_ns,
            period_ns=frame.period_ns,
            trial=trial,
            should_render=frame.should_render,
            head=frame.head_pose,
            left=frame.views[0],
            right=frame.views[1],
            avatar=frame.avatar_pose,
            hands=frame.hands,
            head_valid=frame.head_valid,
            head_tracked=frame.head_tracked,
            session_state=frame.session_state or None,
            max_blur_px=rendered.max_blur_px if rendered else None,
            cpu_ms=rendered.cpu_ms if rendered else None,
            dropped=int(missed > 0),
            missed_refreshes=missed,
            discontinuity=frame.discontinuity,
            snap_turn=frame.snap_turn,
            balls=tuple(BallRow(session_s, time_ns, trial, *ball) for ball in balls),
        )
        gaze = None
        if frame.gaze is not None:
            centre = None if rendered is None else rendered.effect_centre
            gaze = GazeRow(session_s, time_ns, frame.gaze, effect_centre=centre)
        seeks_gaze = rendered is not None and rendered.seeks_gaze
        hashed = rendered is not None and rendered.hashed
        image = partial(ImageRow, session_s, time_ns, trial) if hashed else None
        self._waiting[frame.index] = _Waiting(row, gaze, seeks_gaze, image)
        if rendered is None:
            self.take(())
            return
        if rendered.cpu_ms is not None:
            self.timing.cpu.add(rendered.cpu_ms)
        self.times_gpu = rendered.gpu_times is not None
        self.take(
            rendered.focus_samples,
            rendered.gpu_times or (),
            rendered.image_hashes,
            rendered.gaze_hits,
        )

    def add_hidden(self, frame: Frame) -> None:
        """Take a frame that nobody sees: it has no row, and its time is no exposure."""
        self.timing.seen.add(frame)
        self._shown_ns = None

    def _count(self, frame: Frame) -> int:
        """Return how many refreshes were missed before a frame."""
        now_ns, before_ns = frame.predicted_display_time_ns, self._shown_ns
        missed, timing = 0, self.timing
        if before_ns is not None and not frame.discontinuity:
            missed = missed_refreshes(now_ns - before_ns, frame.period_ns)
            timing.intervals.add((now_ns - before_ns) / 1e6)
        self._shown_ns = now_ns if frame.seen else None  # nobody waits for the next one
        timing.frames += 1
        timing.dropped += missed > 0
        timing.missed_refreshes += missed
        timing.untracked += not frame.head_tracked
        timing.seen.add(frame)
        return missed

    def _continuous_ns(self, frame: Frame) -> int:
        """Keep time running forwards where a playback starts again with the next exposure."""
        time_ns = frame.predicted_display_time_ns + self._offset_ns
        if self._last_ns is not None and time_ns <= self._last_ns:
            self._offset_ns += self._last_ns + frame.period_ns - time_ns
            time_ns = self._last_ns + frame.period_ns
        self._last_ns = time_ns
        return time_ns

    def take(
        self,
        samples: Iterable[FocusSample],
        times: Iterable[GpuTime] = (),
        hashes: Iterable[ImageHash] = (),
        hits: Iterable[GazeHit] = (),
    ) -> None:
        """Give what arrived to its rows and write every row that need not wait longer."""
        self._hashes.update((each.frame_index, each) for each in hashes)
        self._hits.update((each.frame_index, each) for each in hits)
        self._focus.update((sample.frame_index, sample) for sample in samples)
        for time in times:
            self._gpu_ms[time.frame_index] = time.gpu_ms
            self.timing.gpu.add(time.gpu_ms)
        while self._waiting:
            index = next(iter(self._waiting))
            if not self._is_whole(index) and len(self._waiting) <= _LATEST_FRAMES:
                return
            self._write(index)

    def _is_whole(self, index: int) -> bool:
        if self._waiting[index].image is not None and index not in self._hashes:
            return False
        if self._waiting[index].seeks_gaze and index not in self._hits:
            return False
        return index in self._focus and (not self.times_gpu or index in self._gpu_ms)

    def finish(
        self,
        samples: Iterable[FocusSample] = (),
        times: Iterable[GpuTime] = (),
        hashes: Iterable[ImageHash] = (),
        hits: Iterable[GazeHit] = (),
    ) -> None:
        """Write all rows that wait; what has not come for them is blank."""
        self.timing.seen.end()
        self.take(samples, times, hashes, hits)
        while self._waiting:
            self._write(next(iter(self._waiting)))
        self._focus.clear()
        self._gpu_ms.clear()
        self._hashes.clear()
        self._hits.clear()

    def _write(self, index: int) -> None:
        (row, gaze, _, of_image), gpu_ms = self._waiting.pop(index), self._gpu_ms.pop(index, None)
        sample, known = self._focus.pop(index, None), self._hashes.pop(index, None)
        image = of_image(known.left, known.right) if known and of_image else None
        hit = self._hits.pop(index, None)
        if gaze is not None and hit is not None:
            gaze = replace(gaze, hit_m=hit.hit_m, hit_node=hit.node)
        if sample is None:
            self._recorder.write(row(gpu_ms=gpu_ms, gaze=gaze, image=image))
            return
        self._recorder.write(
            row(
                gpu_ms=gpu_ms,
                gaze=gaze,
                image=image,
                focus_m=float(sample.focus_m),
                focus_raw_m=float(sample.focus_raw_m),
                rays_m=tuple(map(float, sample.rays_m)),
                rays_used="".join("1" if used else "0" for used in sample.used),
            )
        )
