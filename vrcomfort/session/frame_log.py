"""Rows of ``frames.csv``, and the timing of trials."""

from __future__ import annotations

import math
from collections import Counter, OrderedDict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple, Protocol

import numpy as np

from vrcomfort.frame import (
    FocusSample,
    Frame,
    FrameWaits,
    GazeHit,
    GpuTime,
    ImageHash,
    PartTime,
    RenderResult,
)
from vrcomfort.protocol import Protocol as StudyProtocol
from vrcomfort.records import (
    BallRow,
    FrameRow,
    GazeRow,
    HandJointsRow,
    ImageRow,
    PartRow,
    Row,
    TimingRow,
    TrialRow,
)
from vrcomfort.scene.markers import Shown
from vrcomfort.seen_time import (
    SEEN,
    SeenState,
    SeenTime,
    ShownFrame,
    is_late,
    passed_between_ns,
)

STEP_MS = 0.01
"""Times are counted in steps of this: exact enough, and never more memory for a longer trial."""


class Durations:
    """Counts times, and knows how long most of them were."""

    def __init__(self) -> None:
        self._counts: Counter[int] = Counter()

    def add(self, time_ms: float) -> None:
        """Count a time."""
        self._counts[round(time_ms / STEP_MS)] += 1

    def percentile_ms(self, percent: float) -> float | None:
        """Return the smallest time that `percent` of all do not exceed; None without any."""
        left = math.ceil(percent / 100 * self._counts.total())
        for step in sorted(self._counts):
            left -= self._counts[step]
            if left <= 0:
                return round(step * STEP_MS, 2)
        return None

    def summary(self, name: str) -> dict[str, float | None]:
        """Return median and tail, named as the columns of ``timing.csv``."""
        return {
            f"{name}_median_ms": self.percentile_ms(50),
            f"{name}_p95_ms": self.percentile_ms(95),
            f"{name}_p99_ms": self.percentile_ms(99),
        }


@dataclass
class TrialTiming:
    """The frames of one trial so far; of training and the like, which have no trial, it is 0."""

    trial: int = 0
    frames: int = 0
    dropped: int = 0
    missed_refreshes: int = 0
    untracked: int = 0
    """Frames whose head pose the headset had not measured."""
    rate_change: str = ""
    """The change of the display's rate that the trial was shown after; blank without one."""
    seen: SeenTime = field(default_factory=SeenTime)
    intervals: Durations = field(default_factory=Durations)
    cpu: Durations = field(default_factory=Durations)
    gpu: Durations = field(default_factory=Durations)

    @property
    def frozen_so_far_s(self) -> float:
        """Return for how long the picture stood still."""
        return self.seen.seconds(SeenState.FROZEN)

    @property
    def dropped_percent(self) -> float | None:
        """Return the share of dropped frames, None without frames."""
        return round(100 * self.dropped / self.frames, 2) if self.frames else None

    def summary(self) -> dict[str, Any]:
        """Return medians and tails, named as the columns of ``timing.csv``."""
        parts = {"interval": self.intervals, "cpu": self.cpu, "gpu": self.gpu}
        return {k: v for name, part in parts.items() for k, v in part.summary(name).items()}


def missed_refreshes(passed_ns: int, period_ns: int) -> int:
    """Return how many refreshes passed between two frames without a new one."""
    return max(round(passed_ns / period_ns) - 1, 1) if is_late(passed_ns, period_ns) else 0


_FLAGS: Mapping[SeenState, str] = {
    SeenState.FROZEN: "the picture stood still",
    SeenState.HALF_RATE: "frames came at half the display's rate or less",
    SeenState.UNTRACKED: "the head was not tracked",
    SeenState.UNFOCUSED: "a menu was in front, and the participant could not stop,",
}


def trial_flags(timing: TrialTiming, protocol: StudyProtocol) -> list[str]:
    """Return an analyst's notes on a trial, a clause each; none where all was well."""
    flags, seen = [], timing.seen
    if (timing.dropped_percent or 0) > protocol.max_dropped_percent:
        flags.append(f"{timing.dropped_percent:g} % of {timing.frames} frames dropped")
        flags[-1] += f" (limit {protocol.max_dropped_percent:g} %)"
    limits = protocol.flag_above_percent.model_dump()
    for state in seen.beyond(limits):
        how_long = f"{_FLAGS[state]} for {seen.seconds(state):.2f} s, {seen.percent(state):g} %"
        flags.append(f"{how_long} of the time (limit {limits[state.value]:g} %)")
    if flags:
        flags.append(f"the stimulus was seen for {seen.seconds(*SEEN):.2f} s")
    if timing.rate_change:
        flags.append(f"the display's rate was not that of the start: {timing.rate_change}")
    return flags


def timing_row(trial: TrialRow, timing: TrialTiming, flags: Sequence[str]) -> TimingRow:
    """Return a trial's row of ``timing.csv``."""
    percent = timing.dropped_percent
    return TimingRow(
        participant=trial.participant,
        session=trial.session,
        trial=trial.trial,
        condition=trial.condition,
        attempt=trial.attempt,
        frames=timing.frames,
        dropped=timing.dropped,
        dropped_percent=percent,
        **timing.summary(),
        flagged=int(bool(flags)),
    )


def _joints_rows(
    frame: Frame, session_s: float, time_ns: int, trial: int
) -> Iterator[HandJointsRow]:
    for hand, joints in zip(("left", "right"), frame.joints, strict=True):
        if joints is not None:
            numbers = np.round(joints.positions_m.astype(float).ravel(), JOINT_DECIMALS).tolist()
            known = tuple(None if math.isnan(number) else number for number in numbers)
            yield HandJointsRow(session_s, time_ns, trial, hand, joints.tracked, known)


JOINT_DECIMALS = 5
"""Of metres: cameras see hands no better, and a row of 78 numbers is half as long."""
_LATEST_FRAMES = 16
"""Frames after which a row is written without the values that have not arrived."""


class _Waiting(NamedTuple):
    """A row without its late values: it is made once, when they have arrived."""

    row: partial[FrameRow]
    gaze: GazeRow | None
    seeks_gaze: bool
    image: partial[ImageRow] | None
    part: partial[PartRow] | None


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
        Of what was shown last, since `start_trial`.
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
        self._parts: dict[int, list[PartTime]] = {}
        self._offset_ns = 0
        self._last_ns = last_ns
        self.times_gpu = False
        self._rate_change = ""
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
        """Return the offset added to display times, so that time on record runs forwards."""
        return self._offset_ns

    def start_trial(self, trial: int = 0) -> None:
        """Count from zero; the first interval is none."""
        self.timing = TrialTiming(trial, rate_change=self._rate_change)
        self._shown: ShownFrame | None = None
        self._paused: SeenState | None = None

    def note_rate_change(self, detail: str) -> None:
        """Take note that the display's rate is no longer that of the start; blank: it is again."""
        self._rate_change = detail
        self.timing.rate_change = detail or self.timing.rate_change

    def timing_of(self, trial: int) -> TrialTiming:
        """Return the timing of a trial; empty before its first frame.

        An exposure may end at any line, also between its training and its first frame.
        """
        timing = self.timing
        none = TrialTiming(trial, rate_change=self._rate_change)
        return timing if timing.trial == trial else none

    def add(
        self,
        frame: Frame,
        rendered: RenderResult | None,
        *,
        trial: int,
        session_s: float,
        balls: Iterable[Shown] = (),
        waits: FrameWaits | None = None,
    ) -> None:
        """Take a frame, and the focus and GPU times that arrived with it.

        `balls` are those that are drawn otherwise from this frame on, `waits` what the runtime made
        it wait, where there is one.
        """
        missed, time_ns = self._count(frame), self._continuous_ns(frame)
        row = partial(
            FrameRow,
            session_s=session_s,
            xr_time_ns=time_ns,
            period_ns=frame.period_ns,
            trial=trial,
            should_render=frame.should_render and not frame.paused,
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
            joints=tuple(_joints_rows(frame, session_s, time_ns, trial)),
            user_present=frame.user_present,
            paused=frame.paused,
            wait_ms=None if waits is None else waits.frame_ms,
            swapchain_wait_ms=None if waits is None else waits.images_ms,
        )
        gaze = None
        if frame.gaze is not None:
            centre = None if rendered is None else rendered.effect_centre
            gaze = GazeRow(session_s, time_ns, frame.gaze, effect_centre=centre)
        seeks_gaze = rendered is not None and rendered.seeks_gaze
        hashed = rendered is not None and rendered.hashed
        image = partial(ImageRow, session_s, time_ns, trial) if hashed else None
        timed = rendered is not None and rendered.times_parts
        part = partial(PartRow, session_s, time_ns, trial) if timed else None
        self._waiting[frame.index] = _Waiting(row, gaze, seeks_gaze, image, part)
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
            rendered.part_times,
        )

    def add_paused(self, frame: Frame, *, trial: int, session_s: float) -> None:
        """Take a frame of a pause: the first of its kind alone has a row."""
        state = ShownFrame.of(frame).state
        if state is not self._paused:
            self.add(frame, None, trial=trial, session_s=session_s)
        else:
            self.timing.seen.add(ShownFrame.of(frame))

    def _count(self, frame: Frame) -> int:
        """Return how many refreshes were missed before a frame."""
        shown, before = ShownFrame.of(frame), self._shown
        missed, timing = 0, self.timing
        if before is not None and not shown.cut:
            passed_ns = passed_between_ns(before, shown)
            missed = missed_refreshes(passed_ns, before.period_ns)
            timing.intervals.add(passed_ns / 1e6)
        self._shown = shown if frame.seen else None  # nobody waits for the next one
        self._paused = shown.state if frame.paused else None
        timing.frames += not frame.paused
        timing.dropped += missed > 0
        timing.missed_refreshes += missed
        timing.untracked += not (frame.head_tracked or frame.paused)
        timing.seen.add(shown)
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
        parts: Iterable[PartTime] = (),
    ) -> None:
        """Give late values to their rows and write every complete row."""
        for image_hash in hashes:
            self._hashes[image_hash.frame_index] = image_hash
        for hit in hits:
            self._hits[hit.frame_index] = hit
        for part in parts:
            self._parts.setdefault(part.frame_index, []).append(part)
        for sample in samples:
            self._focus[sample.frame_index] = sample
        for time in times:
            self._gpu_ms[time.frame_index] = time.gpu_ms
            self.timing.gpu.add(time.gpu_ms)
        while self._waiting:
            index = next(iter(self._waiting))
            if not self._is_whole(index) and len(self._waiting) <= _LATEST_FRAMES:
                return
            self._write(index)

    def _is_whole(self, index: int) -> bool:
        waiting = self._waiting[index]
        return (
            index in self._focus
            and (not self.times_gpu or index in self._gpu_ms)
            and (waiting.image is None or index in self._hashes)
            and (not waiting.seeks_gaze or index in self._hits)
            and (waiting.part is None or index in self._parts)
        )

    def finish(
        self,
        samples: Iterable[FocusSample] = (),
        times: Iterable[GpuTime] = (),
        hashes: Iterable[ImageHash] = (),
        hits: Iterable[GazeHit] = (),
        parts: Iterable[PartTime] = (),
    ) -> None:
        """Write all waiting rows; late values that have not arrived are blank."""
        self.take(samples, times, hashes, hits, parts)
        while self._waiting:
            self._write(next(iter(self._waiting)))
        self._focus.clear()
        self._gpu_ms.clear()
        self._hashes.clear()
        self._hits.clear()
        self._parts.clear()

    def _write(self, index: int) -> None:
        row, gaze, _, of_image, of_part = self._waiting.pop(index)
        gpu_ms, parts = self._gpu_ms.pop(index, None), self._parts.pop(index, ())
        if of_part is not None:
            row = partial(row, parts=tuple(of_part(*each[1:]) for each in parts))
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
                rays_m=tuple(sample.rays_m.tolist()),
                rays_used="".join(["1" if used else "0" for used in sample.used.tolist()]),
            )
        )
