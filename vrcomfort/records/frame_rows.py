"""What is written of frames: the rows of ``frames.csv``, ``gaze.csv`` and ``images.csv``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from vrcomfort.geometry import EyeGaze, Gaze, Pose, View
from vrcomfort.records.exposure_rows import BallRow
from vrcomfort.records.pose_columns import HANDS, POSE_COLUMNS
from vrcomfort.records.rows import Cell, FlatRow

CUT, SNAP_TURN = 1, 2
"""Of `discontinuity`: nothing of the frame before counts; or all but the avatar's heading."""

_UNKNOWN = (None,) * 7

_UNSEEN_RAY = (None,) * 6

RAYS = tuple(f"ray_{number}_m" for number in range(1, 10))


def gaze_columns(eye: str = "") -> tuple[str, ...]:
    """Return the six columns of a line of sight: of ``left_`` or ``right_``, or of both eyes."""
    origin = tuple(f"{eye}origin_{axis}_m" for axis in "xyz")
    return (*origin, *(f"{eye}direction_{axis}" for axis in "xyz"))


def eye_columns(eye: str) -> tuple[str, ...]:
    """Return the eight columns of one eye, ``left_`` or ``right_``."""
    return (f"{eye}valid", *gaze_columns(eye), f"{eye}pupil_mm")


EYE_GAZES = (*eye_columns("left_"), *eye_columns("right_"))


@dataclass(frozen=True)
class GazeRow:
    """Where the participant looked in one frame, predicted for its display time.

    Parameters
    ----------
    gaze
        In the stage; blank where it is not valid.
    hit_m, hit_node
        How far away what the line of sight meets is, measured as the focus is, and the name of the
        node that it belongs to; both blank where nothing is told, the name alone where that is sky.
    effect_centre
        What effects that are centred on the gaze were centred on: ``gaze``, ``held`` or ``head``;
        blank where the condition has none.
    """

    FILE: ClassVar[str] = "gaze.csv"
    session_s: float
    xr_time_ns: int
    gaze: Gaze
    hit_m: float | None = None
    hit_node: str | None = None
    effect_centre: str | None = None
    resumed: int = 0

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""
        hit = ("hit_m", "hit_node", "effect_centre")
        when = ("session_s", "xr_time_ns", "valid")
        return (*when, *gaze_columns(), *hit, *EYE_GAZES, "resumed")

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header."""
        valid = self.gaze.valid
        hit = (self.hit_m, self.hit_node) if valid else (None, None)
        return [
            self.session_s,
            self.xr_time_ns,
            int(valid),
            *(_ray(self.gaze.pose) if valid else _UNSEEN_RAY),
            *hit,
            self.effect_centre,
            *(cell for eye in self.gaze.eyes for cell in _eye(eye)),
            self.resumed,
        ]


def _ray(pose: Pose) -> tuple[Cell, ...]:
    return (*pose.numbers[:3], *pose.forward.tolist())


def _eye(eye: EyeGaze | None) -> tuple[Cell, ...]:
    if eye is None:
        return (None, *_UNSEEN_RAY, None)
    return (int(eye.valid), *(_ray(eye.pose) if eye.valid else _UNSEEN_RAY), eye.pupil_mm)


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
