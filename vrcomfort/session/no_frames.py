"""Sessions of simulated participants without frames: time jumps from one event to the next."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import repeat
from typing import Any

import numpy as np

from vrcomfort.frame import (
    EYE_HEIGHT_M,
    FocusSample,
    Frame,
    GazeHit,
    GpuTime,
    HeadsetEvent,
    ImageHash,
    PartTime,
)
from vrcomfort.geometry import Fov, Pose, View, normalize, yaw_pitch_roll
from vrcomfort.protocol import Condition
from vrcomfort.protocol import Protocol as StudyProtocol
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.scene.load import load_scene
from vrcomfort.session.exposure import Ending, FrameLoop, Stimulus
from vrcomfort.session.interfaces import LoadScene
from vrcomfort.session.ratings import RatingSchedules
from vrcomfort.session.start_pose import without_meshes
from vrcomfort.stop_signals import interruptible

STEPS_HZ = 20.0
"""Rate of steps in tasks and in validations of the gaze, which pass step by step."""


HEAD_TURN_S = 0.2
"""Time constant with which the head of simulated eyes turns to what they are to look at."""


class EventLoop(FrameLoop):
    """Lets an exposure pass without frames.

    What falls due is met at its own time, and not at the next frame's. Where every frame counts, as
    with simulated eyes or in a validation of the gaze, time goes in steps with rows of frames.
    """

    _scene_s = 0.0
    _facing_rad = (0.0, 0.0)
    """Yaw and pitch of the head, which no display moves."""
    _shows = False
    """Whether an exposure is under way: points of a validation go with the head."""

    def _run(
        self,
        stimulus: Stimulus,
        schedule: RatingSchedules | None,
        progress: Callable[[float], None],
    ) -> Ending:
        task, self._shows = self._task, stimulus.trial > 0
        if self._sees or (task is not None and task.next_s() is None):
            return super()._run(stimulus, schedule, progress)
        duration_s = stimulus.duration_s * stimulus.time_scale
        still = next(self._frames)
        listening = interruptible(repeat(None))
        while True:
            next(listening)
            self.context.operators.look()
            self._pass(min(self._next_s(schedule), duration_s), stimulus)
            if self.perceived_s >= duration_s:
                self.elapsed_s = stimulus.duration_s
                return "completed"
            if task is not None:
                frame = self._carried(still)
                task.step(frame, self.headset, self.elapsed_s, self._scene_s)
            self._listen(stimulus, schedule)
            progress(self.elapsed_s)
            if task is not None and task.done:
                return "task_done"

    @property
    def _sees(self) -> bool:
        """Return whether the gaze of simulated eyes is recorded."""
        respondent = self.context.respondent
        return isinstance(respondent, SimulatedRespondent) and respondent.has_eyes

    def _with_eyes(self, frame: Frame) -> Frame:
        """Return a frame with simulated eyes, and a head that turns to their target."""
        if self._shows and self._sees:
            frame = self._turned(frame)
        return super()._with_eyes(frame)

    def _turned(self, frame: Frame) -> Frame:
        demand = self._task.demand(frame) if self._task else None
        if demand is not None:
            point = (frame.avatar_pose.inverse() @ Pose(demand.position_m)).position
            x, y, z = normalize(point - frame.head_pose.position).tolist()
            share = 1 - math.exp(-frame.period_ns / 1e9 / HEAD_TURN_S)
            yaw, pitch = self._facing_rad
            yaw += share * math.remainder(math.atan2(-x, -z) - yaw, 2 * math.pi)
            self._facing_rad = yaw, pitch + share * (math.asin(y) - pitch)
        head = Pose(frame.head_pose.position, yaw_pitch_roll(*self._facing_rad, 0.0))
        left, right = (View(head, view.fov) for view in frame.views)
        return replace(frame, head_pose=head, views=(left, right))

    def _next_s(self, schedule: RatingSchedules | None) -> float:
        """Return the next moment of the protocol's time in which something happens."""
        respondent = self.context.respondent
        times = [math.inf if schedule is None else schedule.next_s]
        if isinstance(respondent, SimulatedRespondent):
            times.append(respondent.next_s(self.perceived_s))
        return max(min(times), self.perceived_s)

    def _pass(self, perceived_s: float, stimulus: Stimulus) -> None:
        """Let time pass until something falls due, at most until `perceived_s`."""
        before_s, self.perceived_s = self.elapsed_s, perceived_s
        self.elapsed_s = perceived_s / stimulus.time_scale
        task_s = self._task.next_s() if self._task is not None else None
        if task_s is not None and task_s < self.elapsed_s:
            self.elapsed_s = max(task_s, before_s)
            self.perceived_s = self.elapsed_s * stimulus.time_scale
        passed_s = self.elapsed_s - before_s
        self._scene_s += passed_s
        self.context.clock.advance(passed_s)
        self.log.timing.seen.pass_without_frames(passed_s)


def scenes_for(protocol: StudyProtocol) -> LoadScene:
    """Return a loader for the parts of a scene that a session without frames needs."""
    if protocol.tasks:
        return load_scene
    return without_meshes if protocol.views else lambda _source: None


@dataclass
class StillHeadset:
    """A headset with a fixed head pose and no display."""

    refresh_hz: float = STEPS_HZ
    name: str = "none"
    image_size_px: tuple[int, int] = (16, 16)

    @property
    def details(self) -> dict[str, Any]:
        """Return nothing."""
        return {}

    def frames(self) -> Iterator[Frame]:
        """Yield frames for ever."""
        head = Pose(np.array([0.0, EYE_HEIGHT_M, 0.0]))
        view = View(head, Fov(-0.8, 0.8, 0.8, -0.8))
        period_ns = round(1e9 / self.refresh_hz)
        frame = Frame(0, 0, period_ns, head, (view, view), Pose())
        index = 0
        while True:
            time_ns = index * period_ns
            yield replace(
                frame, index=index, predicted_display_time_ns=time_ns, discontinuity=index == 0
            )
            index += 1

    def submit(self, frame: Frame, eyes: Any) -> None:
        """Show nothing."""

    def take_events(self) -> list[HeadsetEvent]:
        """Return nothing: nothing happens to it."""
        return []


@dataclass(frozen=True)
class _Unseen:
    eyes: tuple[None, None] = (None, None)
    focus_samples: tuple[FocusSample, ...] = ()
    max_blur_px: float | None = 0.0
    cpu_ms: float | None = None
    gpu_times: tuple[GpuTime, ...] | None = None
    hashed: bool = False
    image_hashes: tuple[ImageHash, ...] = ()
    seeks_gaze: bool = False
    gaze_hits: tuple[GazeHit, ...] = ()
    times_parts: bool = False
    part_times: tuple[PartTime, ...] = ()
    effect_centre: str | None = None


class NoPictures:
    """A renderer that draws nothing."""

    def begin(self, scene: Any, condition: Condition) -> None:
        """Prepare nothing."""

    def adjust(self, condition: Condition) -> None:
        """Change nothing."""

    def render(self, frame: Frame, scene_time_s: float) -> _Unseen:  # noqa: ARG002
        """Draw nothing."""
        return _Unseen()

    def drain(self) -> tuple[FocusSample, ...]:
        """Return nothing."""
        return ()

    def drain_times(self) -> tuple[GpuTime, ...]:
        """Return nothing."""
        return ()

    def drain_hashes(self) -> tuple[ImageHash, ...]:
        """Return nothing."""
        return ()

    def drain_part_times(self) -> tuple[PartTime, ...]:
        """Return nothing."""
        return ()

    def drain_gaze_hits(self) -> tuple[GazeHit, ...]:
        """Return nothing."""
        return ()

    def clamps(self) -> tuple[str, ...]:
        """Return nothing."""
        return ()
