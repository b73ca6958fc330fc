"""Interfaces of a session to its renderer, tasks and other devices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeAlias

from vrcomfort.frame import (
    FocusSample,
    Frame,
    GazeHit,
    GpuTime,
    ImageHash,
    PartTime,
    RenderResult,
)
from vrcomfort.headset.base import Headset
from vrcomfort.protocol import Condition
from vrcomfort.records import EventRow, RatingRow
from vrcomfort.scene.markers import Shown
from vrcomfort.tasks import Demand


class Renderer(Protocol):
    """Draws frames of one scene under one condition at a time."""

    def begin(self, scene: Any, condition: Condition) -> None:
        """Prepare a scene and a condition; forget everything before."""

    def adjust(self, condition: Condition) -> None:
        """Change settings of the present condition between two frames."""

    def render(self, frame: Frame, scene_time_s: float) -> RenderResult:
        """Draw both eyes."""

    def drain(self) -> Sequence[FocusSample]:
        """Return the focus samples that have not arrived yet."""

    def drain_times(self) -> Sequence[GpuTime]:
        """Return the GPU times that have not arrived yet."""

    def drain_part_times(self) -> Sequence[PartTime]:
        """Return times of parts that are still on their way."""

    def drain_hashes(self) -> Sequence[ImageHash]:
        """Return the hashes of images that have not arrived yet."""

    def drain_gaze_hits(self) -> Sequence[GazeHit]:
        """Return the gaze hits that have not been returned yet."""

    def clamps(self) -> Sequence[str]:
        """Return which limits have shortened a blur since `begin`, in words; waits for the GPU."""


LoadScene: TypeAlias = Callable[[str], Any]
"""Takes a scene's name or file (`Protocol.scene_source`), returns the renderer's scene."""

HeadsetFor: TypeAlias = Callable[[str, Any], Headset]
"""Takes a scene's name and the loaded scene; returns the headset standing in it.

Called once per exposure: a playback headset is made anew, a real one is led to the spawn point.
"""


class Activity(Protocol):
    """An activity during frames: a task, an adjustment, or a validation of the gaze."""

    @property
    def done(self) -> bool:
        """Return whether the exposure ends with it, before its time."""

    def demand(self, frame: Frame) -> Demand | None:
        """Return the current target of gaze, and perhaps of pointing."""

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame before it is drawn."""

    def next_s(self) -> float | None:
        """Return when something happens next in a session without frames; None: in every frame."""

    def changed(self) -> Sequence[Shown]:
        """Return the balls that are drawn otherwise than at the last call, for the record."""

    def finish(self) -> None:
        """End with the exposure, however it ended."""


class Outlet(Protocol):
    """Outlet to other devices, such as LabStreamingLayer; never waits."""

    def now_s(self) -> float | None:
        """Return its own clock, if it has one."""

    def mark(self, row: EventRow) -> None:
        """Pass on an event, now."""

    def rate(self, row: RatingRow) -> None:
        """Pass on a rating, now."""

    def show(self, frame: Frame, monotonic_ns: int | None) -> None:
        """Pass on the head and the gaze of a frame.

        `monotonic_ns` is its display time on the system's monotonic clock, None where not known.
        """

    def begin_exposure(self, trial: int, condition: str, monotonic_ns: int | None) -> None:
        """Pass on that the first frame of an exposure (trial 0: of training) was submitted."""

    def end_exposure(self, trial: int) -> None:
        """Pass on that an exposure is over."""

    def take_left_out(self) -> int:
        """Return how much could not be passed on since the last call."""


class NoOutlet:
    """Where no other device listens."""

    def now_s(self) -> float | None:
        """Return None."""
        return None

    def mark(self, row: EventRow) -> None:
        """Do nothing."""

    def rate(self, row: RatingRow) -> None:
        """Do nothing."""

    def show(self, frame: Frame, monotonic_ns: int | None) -> None:
        """Do nothing."""

    def begin_exposure(self, trial: int, condition: str, monotonic_ns: int | None) -> None:
        """Do nothing."""

    def end_exposure(self, trial: int) -> None:
        """Do nothing."""

    def take_left_out(self) -> int:
        """Return 0."""
        return 0
