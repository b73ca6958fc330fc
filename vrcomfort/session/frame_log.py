"""Rows of ``frames.csv``: each waits for its focus, which arrives some frames late."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import replace
from typing import Protocol

from vrcomfort.headset.base import Frame
from vrcomfort.records import FrameRow, Row
from vrcomfort.session.parts import FocusSample, RenderedFrame

_LATEST_FRAMES = 16
"""A focus that has not come after so many frames does not come: its row is written without."""

DROPPED_INTERVAL = 1.2
"""A frame is dropped when its interval exceeds this many periods (as PsychoPy counts)."""


class RowWriter(Protocol):
    """Where rows go: a session's recorder, or one file."""

    def write(self, *rows: Row) -> None:
        """Append rows."""


class FrameLog:
    """The frame rows of one session, in order.

    Counts frames and dropped frames of the trial since `start_trial`.
    """

    def __init__(self, recorder: RowWriter) -> None:
        self._recorder = recorder
        self._waiting: OrderedDict[int, FrameRow] = OrderedDict()
        self._focus: dict[int, FocusSample] = {}
        self._offset_ns = 0
        self._last_ns: int | None = None
        self.start_trial()

    def start_trial(self) -> None:
        """Count from zero; the first interval is none."""
        self.frames = self.dropped = 0
        self._shown_ns: int | None = None

    def add(
        self, frame: Frame, rendered: RenderedFrame | None, *, trial: int, session_s: float
    ) -> None:
        """Take a frame, and whatever focus arrived with it."""
        dropped = self._count(frame)
        self._waiting[frame.index] = FrameRow(
            session_s=session_s,
            xr_time_ns=self._continuous_ns(frame),
            period_ns=frame.period_ns,
            trial=trial,
            should_render=frame.should_render,
            head=frame.head_pose,
            left=frame.views[0],
            right=frame.views[1],
            avatar=frame.avatar_pose,
            max_blur_px=rendered.max_blur_px if rendered else None,
            cpu_ms=rendered.cpu_ms if rendered else None,
            dropped=int(dropped),
            discontinuity=frame.discontinuity,
        )
        self.take(rendered.focus_samples if rendered else ())

    def _count(self, frame: Frame) -> bool:
        now_ns, before_ns = frame.predicted_display_time_ns, self._shown_ns
        follows = before_ns is not None and not frame.discontinuity
        late = follows and now_ns - (before_ns or 0) > DROPPED_INTERVAL * frame.period_ns
        self._shown_ns = now_ns
        self.frames += 1
        self.dropped += late
        return late

    def _continuous_ns(self, frame: Frame) -> int:
        """Keep time running forwards where a playback starts again with the next exposure."""
        time_ns = frame.predicted_display_time_ns + self._offset_ns
        if self._last_ns is not None and time_ns <= self._last_ns:
            self._offset_ns += self._last_ns + frame.period_ns - time_ns
            time_ns = self._last_ns + frame.period_ns
        self._last_ns = time_ns
        return time_ns

    def take(self, samples: Iterable[FocusSample]) -> None:
        """Give focus samples to their rows and write every row that need not wait longer."""
        self._focus.update((sample.frame_index, sample) for sample in samples)
        while self._waiting:
            index = next(iter(self._waiting))
            if index not in self._focus and len(self._waiting) <= _LATEST_FRAMES:
                return
            self._write(index)

    def finish(self, samples: Iterable[FocusSample] = ()) -> None:
        """Write all rows that wait; those of which no focus came have blanks."""
        self.take(samples)
        while self._waiting:
            self._write(next(iter(self._waiting)))
        self._focus.clear()

    def _write(self, index: int) -> None:
        row, sample = self._waiting.pop(index), self._focus.pop(index, None)
        self._recorder.write(_with_focus(row, sample) if sample else row)


def _with_focus(row: FrameRow, sample: FocusSample) -> FrameRow:
    return replace(
        row,
        focus_m=float(sample.focus_m),
        focus_raw_m=float(sample.focus_raw_m),
        rays_m=tuple(float(ray) for ray in sample.rays_m),
        rays_used="".join("1" if used else "0" for used in sample.used),
    )
