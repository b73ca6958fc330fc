"""One exposure: frames are drawn, shown and logged until the time is over or somebody stops."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from vrcomfort.frame import Frame, GpuTime
from vrcomfort.headset.base import Headset
from vrcomfort.records import RatingRow
from vrcomfort.respondent import Respondent
from vrcomfort.session.event_log import Diary
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.session.interfaces import Renderer
from vrcomfort.session.ratings import Rated, RatingSchedule

Ending = Literal["completed", "headset_ended"]


@dataclass(frozen=True)
class Exhibit:
    """What is shown under which number, and for how long.

    Parameters
    ----------
    trial
        0 in training.
    duration_s
        What is shown.
    stretch
        Seconds of the protocol that each shown second stands for (1 without an override).
    """

    trial: int
    condition: str
    duration_s: float
    stretch: float


@dataclass
class FrameLoop:
    """Takes frames of a headset through the renderer; training and exposure share its frames."""

    headset: Headset
    renderer: Renderer
    respondent: Respondent
    diary: Diary
    log: FrameLog
    elapsed_s: float = 0.0
    """Seconds of the exposure that have been shown."""

    def __post_init__(self) -> None:
        self._frames: Iterator[Frame] = iter(self.headset.frames())
        self._scene_start_ns: int | None = None

    def show(
        self,
        exhibit: Exhibit,
        *,
        schedule: RatingSchedule | None = None,
        progress: Callable[[float], None],
    ) -> Ending:
        """Show frames for `exhibit.duration_s`, as counted by their display times.

        Raises
        ------
        Withdrew, StopRule
            If the participant or a rating ends the exposure. Everything shown is logged.
        """
        self.elapsed_s = 0.0
        self.log.start_trial()
        try:
            return self._run(exhibit, schedule, progress)
        finally:
            try:
                self.log.finish(self.renderer.drain(), self._late_times())
            finally:  # a disk that refuses a frame may yet take a rating
                if schedule and (rated := schedule.close()):
                    self._record(exhibit, schedule, rated)

    def _run(
        self,
        exhibit: Exhibit,
        schedule: RatingSchedule | None,
        progress: Callable[[float], None],
    ) -> Ending:
        shown_ns, before_ns = 0, None
        for frame in self._frames:
            self._note_events()
            if frame.paused:  # nobody sees it: time that is no exposure
                self.headset.submit(frame, None)
                shown_ns += 0 if before_ns is None else frame.period_ns  # the last one seen
                before_ns = None
                continue
            now_ns = frame.predicted_display_time_ns
            shown_ns += 0 if before_ns is None else now_ns - before_ns
            before_s, before_ns = self.elapsed_s, now_ns
            self.elapsed_s = shown_ns / 1e9
            self.diary.clock.advance(self.elapsed_s - before_s)
            self._draw(frame, exhibit)
            self._listen(exhibit, schedule)
            progress(self.elapsed_s)
            # The next frame would lie more than half outside.
            if self.elapsed_s + 1.5 * frame.period_ns / 1e9 > exhibit.duration_s:
                self.diary.clock.advance(frame.period_ns / 1e9)
                self.elapsed_s = exhibit.duration_s
                return "completed"
        return "headset_ended"

    def _late_times(self) -> Sequence[GpuTime]:
        return self.renderer.drain_times() if self.log.times_gpu else ()

    def _note_events(self) -> None:
        for event in self.headset.take_events():
            self.diary.note(event)

    def _draw(self, frame: Frame, exhibit: Exhibit) -> None:
        if self._scene_start_ns is None:
            self._scene_start_ns = frame.predicted_display_time_ns
        scene_time_s = (frame.predicted_display_time_ns - self._scene_start_ns) / 1e9
        rendered = self.renderer.render(frame, scene_time_s) if frame.should_render else None
        self.headset.submit(frame, rendered.eyes if rendered else None)
        self.log.add(frame, rendered, trial=exhibit.trial, session_s=self.diary.clock.now_s())

    def _listen(self, exhibit: Exhibit, schedule: RatingSchedule | None) -> None:
        felt_s = self.elapsed_s * exhibit.stretch
        self.respondent.endure(felt_s)
        if schedule and (rated := schedule.update(felt_s, self.diary.clock.now_s())):
            self._record(exhibit, schedule, rated)
            schedule.check(rated)

    def _record(self, exhibit: Exhibit, schedule: RatingSchedule, rated: Rated) -> None:
        self.diary.recorder.write_soon(
            RatingRow(
                self.diary.participant,
                self.diary.session,
                exhibit.trial,
                exhibit.condition,
                onset_s=rated.onset_s,
                latency_s=None if rated.latency_s is None else round(rated.latency_s, 9),
                instrument=schedule.instrument.name,
                response=rated.response,
                missed=int(rated.response is None),
            )
        )
