"""What every headset gives and takes: frames with poses, and images."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from vrcomfort.geometry import Gaze, Pose, View

if TYPE_CHECKING:
    import moderngl


@dataclass(frozen=True)
class Frame:
    """One frame that the headset asks for.

    Parameters
    ----------
    index
        Counts up from 0 over the life of the headset.
    predicted_display_time_ns, period_ns
        When the frame is expected to be seen, and the time between frames.
    head_pose
        stage-from-head.
    views
        Left and right eye, stage-from-eye.
    avatar_pose
        world-from-stage: where locomotion (or a trace's anchor) has put the tracked space.
    should_render
        False where nobody sees the frame.
    discontinuity
        True where the pose before has nothing to do with this one (first frame, loop, teleport).
    paused
        True where the participant sees nothing of it (headset taken off or asleep): time that
        does not count as exposure.
    gaze
        Where the participant looks, None without an eye tracker.
    """

    index: int
    predicted_display_time_ns: int
    period_ns: int
    head_pose: Pose
    views: tuple[View, View]
    avatar_pose: Pose
    should_render: bool = True
    discontinuity: bool = False
    paused: bool = False
    gaze: Gaze | None = None


@dataclass(frozen=True)
class HeadsetEvent:
    """Something that happened to the headset, for the record.

    Parameters
    ----------
    name
        In ``snake_case``: ``session_state``, ``tracking_lost``, ``recentered`` ...
    detail
        What it changed to, in words.
    """

    name: str
    detail: str = ""


class Headset(Protocol):
    """A headset, a playback of one, or a window that stands in for one."""

    @property
    def name(self) -> str:
        """Return what the manifest calls this headset."""

    @property
    def refresh_hz(self) -> float:
        """Return the display's refresh rate."""

    @property
    def image_size_px(self) -> tuple[int, int]:
        """Return (width, height) of one eye's image."""

    @property
    def details(self) -> dict[str, str]:
        """Return what else the manifest should know: runtime, tracked space, image format ..."""

    def frames(self) -> Iterator[Frame]:
        """Yield frames until the headset (or its trace) ends; each must be submitted."""

    def submit(self, frame: Frame, eyes: tuple[moderngl.Texture, moderngl.Texture] | None) -> None:
        """Show the two images (linear sRGB already tone-mapped, RGBA8), or nothing for `None`."""

    def take_events(self) -> list[HeadsetEvent]:
        """Return what happened since the last call: taken off, tracking lost, recentered ..."""
