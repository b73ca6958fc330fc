"""What is written of frames: the rows of ``frames.csv``, ``gaze.csv`` and ``images.csv``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from vrcomfort.geometry import Gaze, Pose, View
from vrcomfort.records.pose_columns import HANDS, POSE_COLUMNS
from vrcomfort.records.rows import BallRow, Cell, FlatRow

CUT, SNAP_TURN = 1, 2
"""Of `discontinuity`: nothing of the frame before counts; or all but the avatar's heading."""

_UNKNOWN = (None,) * 7

RAYS = tuple(f"ray_{number}_m" for number in range(1, 10))


@dataclass(frozen=True)
class GazeRow:
    """Where the participant looked in one frame, predicted for its display time.

    Parameters
    ----------
    gaze
        In the stage; blank where it is not valid.
    hit_m
        Where focus follows the gaze: how far away what it meets is: `FocusSample.focus_raw_m`.
    """

    FILE: ClassVar[str] = "gaze.csv"
    session_s: float
    xr_time_ns: int
    gaze: Gaze
    hit_m: float | None = None
    resumed: int = 0

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""
        origin = tuple(f"origin_{axis}_m" for axis in "xyz")
        direction = tuple(f"direction_{axis}" for axis in "xyz")
        return ("session_s", "xr_time_ns", "valid", *origin, *direction, "hit_m", "resumed")

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header."""
        ray: list[float | None] = [None] * 6
        if self.gaze.valid:
            ray = [*self.gaze.pose.numbers[:3], *self.gaze.pose.forward.tolist()]
        hit_m = self.hit_m if self.gaze.valid else None
        return [self.session_s, self.xr_time_ns, int(self.gaze.valid), *ray, hit_m, self.resumed]


@dataclass(frozen=True)
class ImageRow(FlatRow):
    """What both eyes' images of a frame were, for some of the frames: hashes of their pixels.

    Parameters
    ----------
    trial
        0 in training.
    left_hash, right_hash
        16 hexadecimal digits each; see `vrcomfort.render.image_hash`.
    """

    FILE: ClassVar[str] = "images.csv"
    session_s: float
    xr_time_ns: int
    trial: int
    left_hash: str
    right_hash: str
    resumed: int = 0


@dataclass(frozen=True)
class FrameRow:
    """One frame as it was shown.

    Parameters
    ----------
    trial
        0 in training.
    head, left, right
        Poses in stage space, with the eyes' frusta.
    avatar
        world-from-stage.
    hands
        stage-from-aim of the left and the right hand; None, blank, where it is not known.
    rays_m
        Nine distances along the focus rays, the centre first; empty where no focus was computed.
    rays_used
        Nine characters, 1 = used. Read this column as text.
    head_valid, head_tracked
        Whether the headset knew the head's pose, and whether it measured it in this frame; None
        where it does not say.
    session_state
        Of the OpenXR session, such as ``focused``; blank where there is none.
    dropped
        1 where the interval to the frame before exceeded 1.2 × the period.
    missed_refreshes
        Refreshes of the display that passed between the frame before and this one.
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
    """

    FILE: ClassVar[str] = "frames.csv"
    session_s: float
    xr_time_ns: int
    period_ns: int
    trial: int
    should_render: bool
    head: Pose
    left: View
    right: View
    avatar: Pose
    hands: tuple[Pose | None, Pose | None] = (None, None)
    head_valid: bool | None = None
    head_tracked: bool | None = None
    session_state: str | None = None
    focus_m: float | None = None
    focus_raw_m: float | None = None
    rays_m: tuple[float, ...] = ()
    rays_used: str | None = None
    max_blur_px: float | None = None
    cpu_ms: float | None = None
    gpu_ms: float | None = None
    dropped: int = 0
    missed_refreshes: int | None = None
    discontinuity: bool = False
    snap_turn: bool = False
    resumed: int = 0
    gaze: GazeRow | None = None
    image: ImageRow | None = None
    balls: tuple[BallRow, ...] = ()

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""
        when = ("session_s", "xr_time_ns", "period_ns", "trial", "should_render")
        state = ("head_valid", "head_tracked", "session_state")
        focus = ("focus_m", "focus_raw_m", *RAYS, "rays_used")
        costs = ("max_blur_px", "cpu_ms", "gpu_ms", "dropped", "missed_refreshes")
        last = ("discontinuity", *HANDS, "resumed")
        return (*when, *POSE_COLUMNS, *state, *focus, *costs, *last)

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header."""
        rays = self.rays_m or (None,) * len(RAYS)
        return [
            self.session_s,
            self.xr_time_ns,
            self.period_ns,
            self.trial,
            int(self.should_render),
            *self.head.numbers,
            *self.left.pose.numbers,
            *self.right.pose.numbers,
            *_angles(self.left),
            *_angles(self.right),
            *self.avatar.numbers,
            self.head_valid,
            self.head_tracked,
            self.session_state,
            self.focus_m,
            self.focus_raw_m,
            *rays,
            self.rays_used,
            self.max_blur_px,
            self.cpu_ms,
            self.gpu_ms,
            self.dropped,
            self.missed_refreshes,
            CUT if self.discontinuity else SNAP_TURN if self.snap_turn else 0,
            *(cell for hand in self.hands for cell in (hand.numbers if hand else _UNKNOWN)),
            self.resumed,
        ]


def _angles(view: View) -> tuple[float, float, float, float]:
    return view.fov.left, view.fov.right, view.fov.up, view.fov.down
