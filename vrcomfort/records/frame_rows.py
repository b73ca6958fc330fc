"""Rows of frames: frames, gaze, hashes of images, joints of hands, and times of parts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

from vrcomfort.frame import HAND_JOINTS
from vrcomfort.geometry import EyeGaze, Gaze, Pose, View
from vrcomfort.records.exposure_rows import BallRow
from vrcomfort.records.rows import BOTH, GAZE, MOTION, Cell, Column, ColumnGroup, Needs, Row
from vrcomfort.records.shared_columns import (
    Body,
    FrameS,
    FrameTimeNs,
    FrameTrial,
    Resumed,
    fov_columns,
    pose_columns,
)

CUT, SNAP_TURN = 1, 2
"""Of `discontinuity`: nothing of the frame before counts; or all but the avatar's heading."""

_UNKNOWN = (None,) * 7

_UNSEEN_RAY = (None,) * 6

_NOT_RECORDED = "it was not recorded"
_AXES = ("to the right", "upwards", "backwards")

RAYS = tuple(f"ray_{number}_m" for number in range(1, 10))


def gaze_columns(eye: str = "") -> tuple[str, ...]:
    """Return the six columns of a line of sight: of ``left_`` or ``right_``, or of both eyes."""
    origin = tuple(f"{eye}origin_{axis}_m" for axis in "xyz")
    return (*origin, *(f"{eye}direction_{axis}" for axis in "xyz"))


def eye_columns(eye: str) -> tuple[str, ...]:
    """Return the eight columns of one eye, ``left_`` or ``right_``."""
    return (f"{eye}valid", *gaze_columns(eye), f"{eye}pupil_mm")


def _sight(eye: str = "") -> tuple[Column, ...]:
    """Declare the columns of a line of sight."""
    whose = f"{eye.rstrip('_')} eye's " if eye else ""
    begins = [f"Begin of the {whose}line of sight in the stage, {axis}" for axis in _AXES]
    ways = [
        f"Direction of the {whose}line of sight in the stage (length 1), {axis}" for axis in _AXES
    ]
    # The line begins in the head: where it does tells the motion of the head, and of both eyes
    # their distance.
    parts = [*((each, BOTH) for each in begins), *((each, GAZE) for each in ways)]
    return tuple(
        Column(meaning, blank="the eyes were not seen", needs=needs, signed=True, name=name)
        for name, (meaning, needs) in zip(gaze_columns(eye), parts, strict=True)
    )


def _eye_columns(eye: str) -> tuple[Column, ...]:
    """Declare the columns of one eye."""
    alone = "the eye tracker does not tell the eyes apart"
    whose = eye.rstrip("_")
    valid, *_, pupil = eye_columns(eye)
    columns = (
        Column(f"1 where the eye tracker saw the {whose} eye", blank=alone, name=valid, of=int),
        *_sight(eye),
        Column(
            f"Diameter of the {whose} eye's pupil", blank="the tracker does not tell", name=pupil
        ),
    )
    return tuple(replace(each, since=4) for each in columns)


def _sight_cells(row: GazeRow) -> Iterable[Cell]:
    return _ray(row.gaze.pose) if row.gaze.valid else _UNSEEN_RAY


def _eye_cells(row: GazeRow) -> Iterable[Cell]:
    return [cell for eye in row.gaze.eyes for cell in _eye(eye)]


def _ray(pose: Pose) -> tuple[Cell, ...]:
    return (*pose.numbers[:3], *pose.forward.tolist())


def _eye(eye: EyeGaze | None) -> tuple[Cell, ...]:
    if eye is None:
        return (None, *_UNSEEN_RAY, None)
    return (int(eye.valid), *(_ray(eye.pose) if eye.valid else _UNSEEN_RAY), eye.pupil_mm)


_SIGHT = ColumnGroup(_sight(), _sight_cells)
_EACH_EYE = ColumnGroup((*_eye_columns("left_"), *_eye_columns("right_")), _eye_cells)


@dataclass(frozen=True)
class GazeRow(Row):
    """The gaze of one frame, predicted for its display time.

    Parameters
    ----------
    gaze
        In the stage.
    """

    FILE: ClassVar[str] = "gaze.csv"
    NEEDS: ClassVar[Needs] = GAZE
    session_s: FrameS
    xr_time_ns: FrameTimeNs
    gaze: Annotated[
        Gaze,
        Column(
            "0 where the eye tracker did not see the eyes",
            name="valid",
            of=int,
            cell=lambda row: int(row.gaze.valid),
        ),
        _SIGHT,
    ]
    hit_m: Annotated[
        float | None,
        Column(
            "Distance of what the line of sight meets, measured as focus is; before version 4 "
            "`focus_raw_m`, where focus followed the gaze",
            blank="nothing was met, the eyes were not seen, or the frame was not drawn",
            cell=lambda row: row.hit_m if row.gaze.valid else None,
        ),
    ] = None
    hit_node: Annotated[
        str | None,
        Column(
            "Name of the node that the line of sight meets",
            blank="as `hit_m`, or the sky",
            since=4,
            cell=lambda row: row.hit_node if row.gaze.valid else None,
        ),
    ] = None
    effect_centre: Annotated[
        str | None,
        Column(
            "Centre of gaze-contingent effects: gaze, held (its last direction) or head",
            blank="the condition has none",
            since=4,
        ),
        _EACH_EYE,
    ] = None
    resumed: Resumed = 0


@dataclass(frozen=True)
class ImageRow(Row):
    """Hashes of both eyes' images of a frame, of every 30th drawn frame of an exposure."""

    FILE: ClassVar[str] = "images.csv"
    NEEDS: ClassVar[Needs] = BOTH
    session_s: FrameS
    xr_time_ns: FrameTimeNs
    trial: FrameTrial
    left_hash: Annotated[
        str, Column("Hash of the left eye's image, 16 hexadecimal digits (`render.display`)")
    ]
    right_hash: Annotated[str, Column("Hash of the right eye's image, likewise")]
    resumed: Resumed = 0


_JOINTS = ColumnGroup(
    tuple(
        Column(
            f"{joint.replace('_', ' ').capitalize()} in the stage, {axis}; to 0.01 mm",
            blank="the joint was not known",
            needs=MOTION,
            signed=True,
            name=f"{joint}_{letter}_m",
        )
        for joint in HAND_JOINTS
        for letter, axis in zip("xyz", _AXES, strict=True)
    ),
    lambda row: row.positions_m,
)


@dataclass(frozen=True)
class HandJointsRow(Row):
    """The joints of one hand in one frame, where the runtime tracks it (XR_EXT_hand_tracking).

    Parameters
    ----------
    positions_m
        Three of each joint; None where it was not known.
    """

    FILE: ClassVar[str] = "hand_joints.csv"
    NEEDS: ClassVar[Needs] = MOTION
    session_s: FrameS
    xr_time_ns: FrameTimeNs
    trial: FrameTrial
    hand: Annotated[str, Column("left or right")]
    tracked: Annotated[bool, Column("1 where all joints were seen, 0 where some were inferred")]
    positions_m: Annotated[tuple[float | None, ...], _JOINTS]
    resumed: Resumed = 0


@dataclass(frozen=True)
class PartRow(Row):
    """The time of a part of a frame, both eyes together, of every 90th drawn frame."""

    FILE: ClassVar[str] = "part_times.csv"
    session_s: FrameS
    xr_time_ns: FrameTimeNs
    trial: FrameTrial
    part: Annotated[
        str, Column("Part of the frame, as `vrcomfort passes` names it: scene, depth_of_field, …")
    ]
    cpu_ms: Annotated[float, Column("Time in which the processor issued it")]
    gpu_ms: Annotated[
        float | None,
        Column(
            "GPU time, between two time stamps",
            blank="timer queries mean nothing (software rasterisers)",
        ),
    ]
    resumed: Resumed = 0


def _pose(body: Body, meaning: str, *, blank: str = "", since: int = 1) -> tuple[Column, ...]:
    """Declare the columns of a pose: position, then quaternion."""
    parts = [*(f"position, {axis}" for axis in _AXES), *(f"quaternion, {part}" for part in "xyzw")]
    return tuple(
        Column(
            f"{meaning}: {part}",
            blank=blank,
            since=since,
            needs=MOTION,
            signed=True,
            channel="POS" if part.startswith("position") else "ORNT",
            name=name,
        )
        for name, part in zip(pose_columns(body), parts, strict=True)
    )


_HEAD = ColumnGroup(_pose("head", "Head in the stage"), lambda row: row.head.numbers)
_LEFT = ColumnGroup(_pose("left", "Left eye in the stage"), lambda row: row.left.pose.numbers)
_RIGHT = ColumnGroup(_pose("right", "Right eye in the stage"), lambda row: row.right.pose.numbers)
_FOVS = ColumnGroup(
    tuple(
        Column(f"Half angle of the {eye} eye's frustum, {side}", signed=True, name=name)
        for eye in ("left", "right")
        for name, side in zip(
            fov_columns(eye), ("left (negative)", "right", "up", "down (negative)"), strict=True
        )
    ),
    lambda row: (*_angles(row.left), *_angles(row.right)),
)
_AVATAR = ColumnGroup(
    _pose("avatar", "Stage in the world (locomotion)"), lambda row: row.avatar.numbers
)
_FOCUS_RAYS = ColumnGroup(
    tuple(
        Column(
            f"Focus distance along ray {number}"
            + (", the centre (the line of sight with `gaze`)" if number == 1 else ""),
            blank="no rays were used (`autofocus_zone`, or a gaze that was not valid)",
            needs=BOTH,
            name=name,
        )
        for number, name in enumerate(RAYS, start=1)
    ),
    lambda row: row.rays_m or (None,) * len(RAYS),
)
_HANDS = ColumnGroup(
    tuple(
        column
        for body, which in (("left_hand", "Left"), ("right_hand", "Right"))
        for column in _pose(
            body,  # type: ignore[arg-type]  # mypy widens literals in a loop
            f"{which} hand's aim in the stage (−Z along the ray)",
            blank="the hand was not tracked",
            since=3,
        )
    ),
    lambda row: [cell for hand in row.hands for cell in (hand.numbers if hand else _UNKNOWN)],
)


def _angles(view: View) -> tuple[float, float, float, float]:
    return view.fov.left, view.fov.right, view.fov.up, view.fov.down


def _discontinuity(row: FrameRow) -> int:
    return CUT if row.discontinuity else SNAP_TURN if row.snap_turn else 0


@dataclass(frozen=True)
class FrameRow(Row):
    """One frame as it was shown.

    Parameters
    ----------
    rays_m
        Nine distances along the focus rays, the centre first; empty where no focus was computed.
    discontinuity
        Whether the pose before has nothing to do with this one; a playback cuts there again.
    snap_turn
        Whether the avatar was turned at once, as it is in a playback again.
    gaze
        Its row of ``gaze.csv``, which a recorder writes with this one; None without an eye tracker.
    image
        Its row of ``images.csv``, likewise; None where the images were not hashed.
    balls
        Its rows of ``balls.csv``, likewise: balls of a task that are drawn otherwise from it on.
    joints
        Its rows of ``hand_joints.csv``, likewise: of the hands that are tracked.
    parts
        Its rows of ``part_times.csv``, likewise; none where its parts were not timed.
    """

    FILE: ClassVar[str] = "frames.csv"
    session_s: FrameS
    xr_time_ns: FrameTimeNs
    period_ns: Annotated[int, Column("Predicted period of the display")]
    trial: FrameTrial
    should_render: Annotated[
        bool,
        Column("1 where the frame was drawn; 0 where the runtime wanted no picture, or `paused`"),
    ]
    head: Annotated[Pose, _HEAD]
    left: Annotated[View, _LEFT]
    right: Annotated[View, _RIGHT, _FOVS]
    avatar: Annotated[Pose, _AVATAR]
    head_valid: Annotated[
        bool | None,
        Column("1 where the headset knew the head's pose", blank=_NOT_RECORDED, since=2),
    ] = None
    head_tracked: Annotated[
        bool | None,
        Column(
            "1 where the headset measured the head's pose in this frame",
            blank=_NOT_RECORDED,
            since=2,
        ),
    ] = None
    session_state: Annotated[
        str | None,
        Column(
            "State of the OpenXR session, such as focused",
            blank="there was none, or it was not recorded",
            since=2,
        ),
    ] = None
    focus_m: Annotated[
        float | None,
        Column("Focus distance after the refocus law", blank="no focus", needs=BOTH),
    ] = None
    focus_raw_m: Annotated[
        float | None,
        Column("Focus distance before the refocus law", blank="no focus", needs=BOTH),
    ] = None
    rays_m: Annotated[tuple[float, ...], _FOCUS_RAYS] = ()
    rays_used: Annotated[
        str | None,
        Column("Nine characters, a ray each, 1 = used; text", blank="no rays", needs=BOTH),
    ] = None
    max_blur_px: Annotated[
        float | None,
        Column(
            "Largest radius, of a circle of confusion or half a streak, that the condition allows "
            "at this image size",
            blank="there is no limit (views through the lens)",
            needs=BOTH,
        ),
    ] = None
    cpu_ms: Annotated[
        float | None,
        Column(
            "Time in which the processor drew the frame; before version 6 with waits for images of "
            "the runtime",
            blank="it was not rendered",
        ),
    ] = None
    gpu_ms: Annotated[
        float | None,
        Column(
            "GPU time of the frame's drawing, from timer queries; before version 6 with waits for "
            "images of the runtime",
            blank="timer queries mean nothing (software rasterisers)",
        ),
    ] = None
    dropped: Annotated[
        int, Column("1 where the interval to the frame before exceeded 1.2 times the period")
    ] = 0
    missed_refreshes: Annotated[
        int | None,
        Column(
            "Refreshes of the display between the frame before and this one",
            blank=_NOT_RECORDED,
            since=2,
        ),
    ] = None
    discontinuity: Annotated[
        bool,
        Column(
            "1 where the pose before has nothing to do with this one (start, loop, teleport): a "
            "playback cuts there again; 2 at a snap turn: only the avatar's heading before has "
            "nothing to do with it",
            of=int,
            cell=_discontinuity,
        ),
    ] = False
    snap_turn: bool = False
    hands: Annotated[tuple[Pose | None, Pose | None], _HANDS] = (None, None)
    resumed: Resumed = 0
    user_present: Annotated[
        bool | None,
        Column(
            "1 where the headset's presence sensor saw somebody",
            blank="the runtime did not tell, or it was not recorded",
            since=5,
        ),
    ] = None
    paused: Annotated[
        bool | None,
        Column(
            "1 where nothing was shown: an operator's pause, the headset off or the session not "
            "visible; the row is the first of its kind, and stands for all frames until the next",
            blank=_NOT_RECORDED,
            since=5,
        ),
    ] = None
    wait_ms: Annotated[
        float | None,
        Column(
            "Wait until the runtime wanted the frame (xrWaitFrame, xrBeginFrame)",
            blank="no runtime makes frames wait, or it was not recorded",
            since=6,
        ),
    ] = None
    swapchain_wait_ms: Annotated[
        float | None,
        Column(
            "Time within the runtime's calls that lend images and take them back",
            blank="no runtime makes frames wait, or it was not recorded",
            since=6,
        ),
    ] = None
    gaze: GazeRow | None = None
    image: ImageRow | None = None
    balls: tuple[BallRow, ...] = ()
    joints: tuple[HandJointsRow, ...] = ()
    parts: tuple[PartRow, ...] = ()
