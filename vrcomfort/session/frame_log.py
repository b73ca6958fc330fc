"""Rows of ``frames.csv``, and the timing of trials."""

from __future__ import annotations

import math
from collections import Counter, OrderedDict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple, Protocol

from vrcomfort.frame import (
    DROPPED_INTERVAL_PERIODS,
    FocusSample,
    Frame,
    GazeHit,
    GpuTime,
    ImageHash,
    RenderResult,
)
from vrcomfort.records import BallRow, FrameRow, GazeRow, ImageRow, Row, TimingRow, TrialRow
from vrcomfort.scene.markers import Shown

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


def seen_between_ns(before: Frame, frame: Frame) -> int:
    """Return how much of the time between two frames something was seen, and so is exposure.

    Where poses jump (a cut of a trace, another place), the frame before was seen for its period.
    """
    passed_ns = frame.predicted_display_time_ns - before.predicted_display_time_ns
    if not frame.discontinuity:
        return passed_ns
    return min(passed_ns, before.period_ns) if passed_ns > 0 else before.period_ns


@dataclass
class SeenTime:
    """The seconds of a trial by visibility: live, frozen, hidden, unfocused; they add up to it.

    Parameters
    ----------
    live_s
        A frame was shown for its period.
    frozen_s
        A frame stood for longer: refreshes passed without a new one.
    hidden_s
        Nothing was seen: the headset was taken off or asleep, or the runtime wanted no picture.
    unfocused_s
        The frame was shown, and something of the runtime's had the input.
    """

    live_s: float = 0.0
    frozen_s: float = 0.0
    hidden_s: float = 0.0
    unfocused_s: float = 0.0
    _frame: Frame | None = None
    """The last frame, whose time is not over."""

    def add(self, frame: Frame) -> None:
        """Close the time of the frame before."""
        before, self._frame = self._frame, frame
        if before is None:
            return
        passed_ns = frame.predicted_display_time_ns - before.predicted_display_time_ns
        if before.seen:
            seen_ns = seen_between_ns(before, frame)
            self.hidden_s += max(passed_ns - seen_ns, 0) / 1e9
            passed_ns = seen_ns
        self._count(before, passed_ns)

    def end(self) -> None:
        """Give the last frame its period."""
        if self._frame is not None:
            self._count(self._frame, self._frame.period_ns)
            self._frame = None

    def _count(self, frame: Frame, passed_ns: int) -> None:
        if not frame.seen:
            self.hidden_s += passed_ns / 1e9
            return
        late = passed_ns > DROPPED_INTERVAL_PERIODS * frame.period_ns
        shown_ns = frame.period_ns if late else passed_ns
        self.frozen_s += (passed_ns - shown_ns) / 1e9
        if frame.unfocused:
            self.unfocused_s += shown_ns / 1e9
        else:
            self.live_s += shown_ns / 1e9

    @property
    def frozen_percent(self) -> float:
        """Return the frozen share of the time in which something was seen."""
        seen_s = self.live_s + self.frozen_s + self.unfocused_s
        return round(100 * self.frozen_s / seen_s, 2) if seen_s else 0.0

    def cells(self) -> dict[str, Any]:
        """Return the seconds, named as the columns of ``trials.csv``."""
        names = ("live_s", "frozen_s", "hidden_s", "unfocused_s")
        return {name: round(getattr(self, name), 9) for name in names}


@dataclass
class TrialTiming:
    """The frames of one trial so far; of training and the like, which have no trial, it is 0."""

    trial: int = 0
    frames: int = 0
    dropped: int = 0
    missed_refreshes: int = 0
    untracked: int = 0
    """Frames whose head pose the headset had not measured."""
    seen: SeenTime = field(default_factory=SeenTime)
    intervals: Durations = field(default_factory=Durations)
    cpu: Durations = field(default_factory=Durations)
    gpu: Durations = field(default_factory=Durations)

    @property
    def frozen_so_far_s(self) -> float:
        """Return for how long the picture stood still."""
        return self.seen.frozen_s

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
    late = passed_ns > DROPPED_INTERVAL_PERIODS * period_ns
    return max(round(passed_ns / period_ns) - 1, 1) if late else 0


def trial_flags(timing: TrialTiming, limit_percent: float) -> list[str]:
    """Return an analyst's notes on a trial, a clause each; none where all was well.

    Parameters
    ----------
    limit_percent
        How many per cent of the frames may be dropped, and of the time frozen.
    """
    flags, seen = [], timing.seen
    if (timing.dropped_percent or 0) > limit_percent:
        flags.append(f"{timing.dropped_percent:g} % of {timing.frames} frames dropped")
    if seen.frozen_percent > limit_percent:
        frozen = f"the picture stood still for {seen.frozen_s:.2f} s, {seen.frozen_percent:g} %"
        flags.append(f"{frozen} of the time, and was live for {seen.live_s:.2f} s")
    if flags:
        flags.append(f"the limit is {limit_percent:g} %")
    if 2 * timing.untracked > timing.frames:
        flags.append(f"the head was not tracked in {timing.untracked} of {timing.frames} frames")
    if seen.unfocused_s:
        text = f"a menu of the runtime's was in front for {seen.unfocused_s:.2f} s"
        flags.append(f"{text}: the participant saw it, and could not stop")
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


_LATEST_FRAMES = 16
"""Frames after which a row is written without the values that have not arrived."""


class _Waiting(NamedTuple):
    """A row without its late values: it is made once, when they have arrived."""

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
        """Return the offset added to display times, so that time on record runs forwards."""
        return self._offset_ns

    def start_trial(self, trial: int = 0) -> None:
        """Count from zero; the first interval is none."""
        self.timing = TrialTiming(trial)
        self._shown_ns: int | None = None

    def timing_of(self, trial: int) -> TrialTiming:
        """Return the timing of a trial: none, while what was shown last is not of it.

        An exposure may end at any line, also between its training and its first frame.
        """
        timing = self.timing
        return timing if timing.trial == trial else TrialTiming(trial)

    def add(
        self,
        frame: Frame,
        rendered: RenderResult | None,
        *,
        trial: int,
        session_s: float,
        balls: Iterable[Shown] = (),
    ) -> None:
        """Take a frame, and the focus and GPU times that arrived with it.

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
        """Take an invisible frame: it has no row, and its time is no exposure."""
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
        """Give late values to their rows and write every complete row."""
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
        """Write all waiting rows; late values that have not arrived are blank."""
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
