"""Types that headset, renderer and session share for one frame, without OpenGL."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Gaze, Pose, View

MEAN_IPD_M = 0.063
"""The average distance between adults' pupils (Carnegie & Rhee 2015)."""

EYE_HEIGHT_M = 1.6
"""Of somebody who stands; where a picture is taken from if nothing else is said."""

STIMULUS_VERSION = 2
"""Of the pixels that conditions give: whoever changes a picture hash, however little, raises it.
Manifests have it; `run` goes on with a study of another one only if told."""

DROPPED_INTERVAL_PERIODS = 1.2
"""A frame is dropped when its interval exceeds this many periods (as PsychoPy counts)."""


_FINGERS = ("index", "middle", "ring", "little")
HAND_JOINTS = (
    "palm", "wrist", "thumb_metacarpal", "thumb_proximal", "thumb_distal", "thumb_tip",
    *(
        f"{finger}_{joint}"
        for finger in _FINGERS
        for joint in ("metacarpal", "proximal", "intermediate", "distal", "tip")
    ),
)  # fmt: skip
"""The joints of a hand, in OpenXR's order."""


@dataclass(frozen=True, eq=False)
class HandJoints:
    """The joints of one hand.

    Parameters
    ----------
    positions_m
        (26, 3), in the stage, in the order of `HAND_JOINTS`; NaN where one is not known.
    tracked
        Whether all of them are seen; else some are inferred.
    """

    positions_m: NDArray[np.float32]
    tracked: bool = True


@dataclass(frozen=True)
class Frame:
    """One frame that the headset asks for.

    Parameters
    ----------
    index
        Counts up from 0 over the life of the headset.
    predicted_display_time_ns, period_ns
        When the frame is expected to be seen, and the period at which frames are due.
    head_pose
        stage-from-head.
    views
        Left and right eye, stage-from-eye.
    avatar_pose
        world-from-stage: where locomotion (or a trace's anchor) has put the tracked space.
    should_render
        False where the runtime wants no picture: nobody sees the frame.
    discontinuity
        True where the pose before has nothing to do with this one (first frame, loop, teleport).
    snap_turn
        True where the avatar was turned at once: that is no motion, and the rest of the frame is.
    paused
        True where the participant sees nothing of it (headset taken off or asleep, an operator's
        pause): time that does not count as exposure.
    user_present
        Whether somebody wears the headset; None where nothing tells.
    gaze
        Where the participant looks, None without an eye tracker.
    hands
        stage-from-aim of the left and the right hand, None where the headset does not know it.
    joints
        The joints of the left and the right hand, None where the headset does not know them.
    head_valid
        False where the headset does not know the head: the poses are the last known.
    head_tracked
        False where no sensor sees the head: the poses are inferred, or the last known.
    session_state
        OpenXR's, in lower case: ``visible`` (something of the runtime's has the input), ``focused``
        ...; empty where there is none.
    patch
        Whether the patch for a photodiode is white in it; None: there is no patch.
    """

    index: int
    predicted_display_time_ns: int
    period_ns: int
    head_pose: Pose
    views: tuple[View, View]
    avatar_pose: Pose
    should_render: bool = True
    discontinuity: bool = False
    snap_turn: bool = False
    paused: bool = False
    user_present: bool | None = None
    gaze: Gaze | None = None
    hands: tuple[Pose | None, Pose | None] = (None, None)
    joints: tuple[HandJoints | None, HandJoints | None] = (None, None)
    head_valid: bool = True
    head_tracked: bool = True
    session_state: str = ""
    patch: bool | None = None

    @property
    def seen(self) -> bool:
        """Whether the participant sees the frame: else its time is no exposure."""
        return self.should_render and not self.paused and self.user_present is not False

    @property
    def unfocused(self) -> bool:
        """Whether the participant sees the frame, and the runtime's own menu has the input."""
        return self.seen and self.session_state == "visible"


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


@dataclass(frozen=True, eq=False)
class FocusSample:
    """The focus of one frame.

    Parameters
    ----------
    frame_index
        `Frame.index`.
    focus_m, focus_raw_m
        After and before the refocus law, metres along the head's forward axis, or along the ray
        where the condition measures so.
    rays_m
        (9,) metres, measured alike; NaN where focus is not found by rays.
    used
        (9,) bool, False for outliers.
    """

    frame_index: int
    focus_m: float
    focus_raw_m: float
    rays_m: Array
    used: NDArray[np.bool_]


class GazeHit(NamedTuple):
    """The hit of the line of sight of a frame (`Frame.index`).

    Parameters
    ----------
    hit_m
        How far away, measured as the focus is; None where it meets nothing.
    node
        Name of the node in the scene; empty where it meets nothing.
    """

    frame_index: int
    hit_m: float | None
    node: str


class ImageHash(NamedTuple):
    """The hashes of the images of a frame (`Frame.index`): 16 hexadecimal digits of each eye's."""

    frame_index: int
    left: str
    right: str


class GpuTime(NamedTuple):
    """The GPU time of a frame (`Frame.index`)."""

    frame_index: int
    gpu_ms: float


class PartTime(NamedTuple):
    """The time of a part of a frame (`Frame.index`), both eyes together.

    Parameters
    ----------
    part
        The scene, the resolve of its samples, an effect, …: as `vrcomfort passes` names them.
    cpu_ms
        Time in which the processor issued it.
    gpu_ms
        None where timer queries mean nothing.
    """

    frame_index: int
    part: str
    cpu_ms: float
    gpu_ms: float | None


class FrameWaits(NamedTuple):
    """Waits of a frame for the headset's runtime.

    Parameters
    ----------
    frame_ms
        Until the runtime wanted the frame.
    images_ms
        For the images that it lends: acquired, waited for, and given back.
    """

    frame_ms: float
    images_ms: float


class RenderResult(Protocol):
    """Both eyes' images of one frame, and the results that have arrived with it."""

    @property
    def eyes(self) -> tuple[Any, Any]:
        """Return the left and right image."""

    @property
    def focus_samples(self) -> Sequence[FocusSample]:
        """Return samples of earlier frames that have arrived."""

    @property
    def max_blur_px(self) -> float | None:
        """Return the largest blur radius that the condition allows at this size; None: no limit."""

    @property
    def cpu_ms(self) -> float | None:
        """Return the time in which the processor drew this frame, without waits."""

    @property
    def gpu_times(self) -> Sequence[GpuTime] | None:
        """Return times of earlier frames that have arrived; None where the GPU is not timed."""

    @property
    def times_parts(self) -> bool:
        """Return whether the parts of this frame are being timed."""

    @property
    def part_times(self) -> Sequence[PartTime]:
        """Return times of parts of earlier frames that have arrived."""

    @property
    def hashed(self) -> bool:
        """Return whether the images of this frame are being hashed."""

    @property
    def image_hashes(self) -> Sequence[ImageHash]:
        """Return hashes of the images of earlier frames that have arrived."""

    @property
    def seeks_gaze(self) -> bool:
        """Return whether the gaze hit of this frame is being measured."""

    @property
    def gaze_hits(self) -> Sequence[GazeHit]:
        """Return the gaze hits of earlier frames that have arrived."""

    @property
    def effect_centre(self) -> str | None:
        """Return the centre of gaze-contingent effects; None without any."""
