"""A headset that plays a head trace: a real headset without a person, in lockstep.

Frames come as fast as they are drawn (for people: never faster than they would be shown), and the
same trace gives the same frames every time.
"""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice, pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.frame import MEAN_IPD_M, Frame, HeadsetEvent
from vrcomfort.geometry import Fov, Pose, View, heading
from vrcomfort.rotations import slerp_numbers
from vrcomfort.traces.pose_track import PoseTrack
from vrcomfort.traces.trace import Trace

if TYPE_CHECKING:
    import moderngl

SECOND_NS = 1_000_000_000
HIGHEST_HZ = 10_000
"""No display is so fast; a slip of the keyboard would make a session of endless frames."""

TEMPORAL_TANGENT, NASAL_TANGENT = 1.1, 0.9
"""Horizontal half fields of the default eyes: 47.7° outwards, 42.0° inwards."""


@dataclass(frozen=True)
class _Sample:
    """Where a frame falls in a trace: between sample `index` and the next one."""

    index: int
    fraction: float
    time_ns: int
    cut: bool
    snap_turn: bool = False


class PlaybackHeadset:
    """Plays a trace through the headset protocol.

    Parameters
    ----------
    trace
        What the head did. With avatar poses it plays in the world; without them it is anchored:
        its first floor point and heading are put on `spawn`. It is never clamped to a floor.
    image_size_px
        (width, height) of one eye's image.
    refresh_hz
        Display rate. `None` is the trace's own: one frame per sample, at the sample's own time,
        with the recorded poses bit for bit.
    ipd_m
        Distance between the eyes, where the trace has no eye poses.
    fovs
        Left and right frustum; `None` takes the trace's, or else `default_fovs`.
    spawn
        world-from-stage of the scene's starting point.
    loop
        Start again after the end, as a cut. Without it, `frames` ends with the trace.
    max_frames
        End each run of `frames` after so many.
    real_time
        Give no frame before its time, so that an exposure lasts as long as it says. Where drawing
        is slower than the display, an exposure lasts longer.
    """

    def __init__(
        self,
        trace: Trace,
        *,
        image_size_px: tuple[int, int],
        refresh_hz: float | None = None,
        ipd_m: float = MEAN_IPD_M,
        fovs: tuple[Fov, Fov] | None = None,
        spawn: Pose | None = None,
        loop: bool = True,
        max_frames: int | None = None,
        real_time: bool = False,
    ) -> None:
        if refresh_hz is not None and not 0 < refresh_hz <= HIGHEST_HZ:
            message = f"a refresh rate must be above 0 and at most {HIGHEST_HZ} Hz"
            raise InputError(f"{message}, not {refresh_hz:g}")
        self._size_px = image_size_px
        self._rate = None if refresh_hz is None else Fraction(refresh_hz)
        self._ipd_m = ipd_m
        self._head_from_eyes = [Pose((side * ipd_m / 2, 0.0, 0.0)) for side in (-1, 1)]
        self._fovs = fovs
        self._default_fovs = default_fovs(image_size_px)
        self._loop = loop
        self._max_frames = max_frames
        self._real_time = real_time
        self._next_index = 0
        self._next_time_ns = int(trace.time_ns[0])
        self._trace = trace
        self.place(spawn=spawn)

    @property
    def name(self) -> str:
        """Return the headset's name for the manifest."""
        return "playback"

    @property
    def refresh_hz(self) -> float:
        """Return the display rate; the trace's own is its median."""
        own_hz = SECOND_NS / self._trace.median_period_ns
        return own_hz if self._rate is None else float(self._rate)

    @property
    def image_size_px(self) -> tuple[int, int]:
        """Return (width, height) of one eye's image."""
        return self._size_px

    @property
    def details(self) -> dict[str, Any]:
        """Return how far apart the eyes are, and which trace it plays, if that is a file."""
        sha256 = self._trace.sha256
        return {"ipd_m": self.ipd_m} | ({} if sha256 is None else {"trace_sha256": sha256})

    @property
    def ipd_m(self) -> float:
        """Return the distance between the eyes (of the first sample, where they are recorded)."""
        if self._trace.eyes is None:
            return self._ipd_m
        left, right = self._trace.eyes
        return float(np.linalg.norm(right.positions[0] - left.positions[0]))

    @property
    def trace_s(self) -> float:
        """Return how long the trace is."""
        return float(self._trace.time_ns[-1] - self._trace.time_ns[0]) / SECOND_NS

    def place(self, trace: Trace | None = None, *, spawn: Pose | None = None) -> None:
        """Put the participant elsewhere: the next `frames` start `trace` there.

        Frame indices and display times run on, so that a session has one clock.
        """
        self._trace = self._trace if trace is None else trace
        self._anchor = world_from_stage(self._trace.head, Pose() if spawn is None else spawn)

    def frames(self) -> Iterator[Frame]:
        """Yield the frames of the trace from its start; the first is a discontinuity."""
        schedule = self._schedule(self._next_time_ns)
        due_s = time.monotonic()
        for sample, display_ns in islice(schedule, self._max_frames):
            period_ns = self._period_ns(sample)
            frame = self._frame(sample, self._next_index, display_ns, period_ns)
            # Before the frame is given away: a session may drop the iterator at any frame.
            self._next_time_ns = display_ns + period_ns
            self._next_index += 1
            yield frame
            if self._real_time:
                due_s = _wait_until(due_s + period_ns / SECOND_NS)

    def submit(self, frame: Frame, eyes: tuple[moderngl.Texture, moderngl.Texture] | None) -> None:
        """Discard the images."""

    def take_events(self) -> list[HeadsetEvent]:
        """Return nothing: to a trace nothing happens."""
        return []

    def _schedule(self, start_ns: int) -> Iterator[tuple[_Sample, int]]:
        if self._rate is None:
            yield from self._own_times(start_ns)
            return
        for count, sample in enumerate(self._resampled()):
            yield sample, start_ns + _periods_ns(count, self._rate)

    def _own_times(self, start_ns: int) -> Iterator[tuple[_Sample, int]]:
        times, cuts = self._trace.time_ns, self._trace.cuts
        first_ns, last_ns = int(times[0]), int(times[-1])
        while True:
            for index in range(len(times)):
                snap_turn = self._turns_at(index)
                sample = _Sample(index, 0.0, int(times[index]), bool(cuts[index]), snap_turn)
                yield sample, start_ns + sample.time_ns - first_ns
            if not self._loop:
                return
            start_ns += last_ns - first_ns + self._period_ns(sample)

    def _resampled(self) -> Iterator[_Sample]:
        jumps = self._trace.cuts
        if self._trace.snap_turns is not None:
            jumps = jumps | self._trace.snap_turns
        bounds = [*np.flatnonzero(jumps).tolist(), len(self._trace)]
        while True:
            for first, end in pairwise(bounds):
                yield from self._resampled_piece(first, end)
            if not self._loop:
                return

    def _resampled_piece(self, first: int, end: int) -> Iterator[_Sample]:
        """Yield the display times between two cuts or snap turns: never a pose across one."""
        assert self._rate is not None  # noqa: S101 - tells mypy what `_schedule` knows
        times: list[int] = self._trace.time_ns[first:end].tolist()
        count = 0
        first_ns, last_ns = times[0], times[-1]
        while (time_ns := first_ns + _periods_ns(count, self._rate)) <= last_ns + 1:
            before, fraction = _place(times, time_ns)
            cut = count == 0 and bool(self._trace.cuts[first])
            snap_turn = count == 0 and self._turns_at(first)
            yield _Sample(first + before, fraction, time_ns, cut, snap_turn)
            count += 1

    def _turns_at(self, index: int) -> bool:
        return self._trace.snap_turns is not None and bool(self._trace.snap_turns[index])

    def _period_ns(self, sample: _Sample) -> int:
        if self._rate is not None:
            return _periods_ns(1, self._rate)
        if self._trace.period_ns is not None:
            return int(self._trace.period_ns[sample.index])
        return self._trace.median_period_ns

    def _frame(self, sample: _Sample, index: int, display_ns: int, period_ns: int) -> Frame:
        trace = self._trace
        head = _pose_at(trace.head, sample)
        return Frame(
            index=index,
            predicted_display_time_ns=display_ns,
            period_ns=period_ns,
            head_pose=head,
            views=self._views(head, sample),
            avatar_pose=self._anchor if trace.avatar is None else _pose_at(trace.avatar, sample),
            discontinuity=sample.cut,
            snap_turn=sample.snap_turn,
            gaze=None if trace.gaze is None else trace.gaze.at(sample.time_ns),
            hands=(_hand_at(trace.left_hand, sample), _hand_at(trace.right_hand, sample)),
        )

    def _views(self, head: Pose, sample: _Sample) -> tuple[View, View]:
        left, right = self._fovs_at(sample)
        if self._trace.eyes is not None:
            eyes = [_pose_at(eye, sample) for eye in self._trace.eyes]
        else:
            eyes = [head @ head_from_eye for head_from_eye in self._head_from_eyes]
        return View(eyes[0], left), View(eyes[1], right)

    def _fovs_at(self, sample: _Sample) -> tuple[Fov, Fov]:
        if self._fovs is not None:
            return self._fovs
        if self._trace.fovs is None:
            return self._default_fovs
        left, right = self._trace.fovs[sample.index].tolist()
        return Fov(*left), Fov(*right)


def _periods_ns(count: int, rate_hz: Fraction) -> int:
    """Return the duration of `count` periods: `round(count * SECOND_NS / rate_hz)`, faster.

    >>> _periods_ns(3, Fraction(90))
    33333333
    """
    numerator, denominator = rate_hz.as_integer_ratio()
    whole, rest = divmod(count * SECOND_NS * denominator, numerator)
    twice = 2 * rest - numerator
    return whole + (twice > 0 or (twice == 0 and whole % 2 == 1))


def _wait_until(due_s: float) -> float:
    """Sleep until a time of the monotonic clock; return when it was over, the late one if late."""
    time.sleep(max(due_s - time.monotonic(), 0.0))
    return max(due_s, time.monotonic() - 1e-3)  # sleeping wakes a little late: no drift from that


def default_fovs(image_size_px: tuple[int, int]) -> tuple[Fov, Fov]:
    """Return mirrored frusta with square pixels: wider outwards, and a little wider downwards."""
    width, height = image_size_px
    vertical = (TEMPORAL_TANGENT + NASAL_TANGENT) * height / width
    out, nasal = float(np.arctan(TEMPORAL_TANGENT)), float(np.arctan(NASAL_TANGENT))
    up, down = float(np.arctan(0.48 * vertical)), -float(np.arctan(0.52 * vertical))
    return Fov(-out, nasal, up, down), Fov(-nasal, out, up, down)


def world_from_stage(head: PoseTrack, spawn: Pose) -> Pose:
    """Return the anchor that puts the first head's floor point and heading on `spawn`."""
    x, _, z = head.positions[0]
    return spawn @ Pose(np.array([x, 0.0, z]), heading(head.pose(0))).inverse()


def _place(times: list[int], time_ns: int) -> tuple[int, float]:
    """Return the sample at or before a time, and how far on the way to the next one it is.

    A sample within 1 ns counts as being there: recorded times are whole nanoseconds, and a
    recording that is played at its own rate must give its own poses.
    """
    before = bisect_right(times, time_ns + 1) - 1
    elapsed = time_ns - times[before]
    if elapsed <= 1:
        return before, 0.0
    return before, elapsed / (times[before + 1] - times[before])


def _hand_at(track: PoseTrack | None, sample: _Sample) -> Pose | None:
    """Return where a hand is, None where it is not known at both samples around."""
    if track is None:
        return None
    around = slice(sample.index, sample.index + (1 if sample.fraction == 0.0 else 2))
    return None if np.isnan(track.positions[around]).any() else _pose_at(track, sample)


def _pose_at(track: PoseTrack, sample: _Sample) -> Pose:
    if sample.fraction == 0.0:
        return track.pose(sample.index)
    a, b = sample.index, sample.index + 1
    place, then = track.positions[a : b + 1].tolist()  # plain numbers are faster: hot
    position = [x + (y - x) * sample.fraction for x, y in zip(place, then, strict=True)]
    before, after = track.orientations[a : b + 1].tolist()
    return Pose.of(position, slerp_numbers(before, after, sample.fraction))
