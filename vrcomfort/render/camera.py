"""Camera of an eye and its motion since the frame before: float64, no OpenGL.

Where an eye is (`EyeCamera`) and the point of its lens, how the head moved and how fast
(`HeadStep`), and the eye pose that motion blur takes for the previous one (`previous_eye_pose`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import (
    Array,
    Fov,
    Pose,
    clip_from_view,
    interpolate_pose,
    rotate,
    view_from_clip,
)
from vrcomfort.optics.motion import ramp, speed_m_s, turn_deg_s
from vrcomfort.protocol.conditions import CameraMode, Carried, Neck, SpeedRamps, VirtualTurning
from vrcomfort.rotations import rotation_rows
from vrcomfort.scene.node_poses import HandPoses

LensLaw = Literal["linear", "dioptre"]
"""Radius per metre of defocus, or per dioptre (all lenses)."""

_UNIT = np.eye(4)

NEAR_M = 0.02
"""Distance of the near plane, where nothing else is said."""


@dataclass(frozen=True)
class Lens:
    """One point of a lens, for references that accumulate many (``shaders/include/lens.glsl``).

    Parameters
    ----------
    position
        (x, y) in the unit disc; (0, 0) is the pinhole.
    focus_m
        Focus distance, from the head centre along the head's forward axis.
    infinity_m
        Distance taken for the sky.
    px_per_defocus
        Radius of the circle of confusion per metre (or dioptre) of defocus.
    max_radius_px
        No circle of confusion has a larger radius.
    distance_offset_m
        How far the lens is behind the head centre; `focus_m` and `infinity_m` are from the lens.
    """

    position: tuple[float, float]
    focus_m: float
    infinity_m: float
    px_per_defocus: float
    max_radius_px: float
    distance_offset_m: float = 0.0


@dataclass(frozen=True)
class EyeCamera:
    """An eye in the world.

    Parameters
    ----------
    world_from_eye
        Pose of the eye; its frustum is `fov` with the near plane at `near_m`.
    world_from_head
        Decides levels of detail, shadows and head-locked nodes for both eyes; the eye itself
        where it is None.
    in_head
        Head-from-eye, where it is known.
    lens
        A point of the lens other than the pinhole. A renderer built for lenses needs one.
    peripheral_axis, vignette_axis
        (3,) in the head's frame: centre of peripheral blur and of the vignette, where that
        is not the head's forward axis.
    """

    world_from_eye: Pose
    fov: Fov
    near_m: float = NEAR_M
    world_from_head: Pose | None = None
    in_head: Pose | None = None
    lens: Lens | None = None
    peripheral_axis: Array | None = None
    vignette_axis: Array | None = None

    @property
    def head(self) -> Pose:
        """Return world-from-head, or world-from-eye where no head was given."""
        return self.world_from_eye if self.world_from_head is None else self.world_from_head

    @property
    def head_from_eye(self) -> Pose:
        """Return the place of the eye in the head, one object for all who ask."""
        kept: Pose | None = self.in_head or self.__dict__.get("_head_from_eye")
        if kept is None:
            kept = self.head.inverse() @ self.world_from_eye
            self.__dict__["_head_from_eye"] = kept  # in a third of the time of `cached_property`
        return kept


@dataclass(frozen=True)
class PreviousCamera:
    """Where the eye counts as having been one frame ago, and the scene's time then.

    `previous_eye_pose` makes it; head-locked nodes do not use the pose.
    """

    world_from_eye: Pose
    time_s: float


def rotation_only(rotation: Array) -> Array:
    """Return a (3, 3) rotation as a (4, 4) matrix."""
    matrix = _UNIT.copy()
    matrix[:3, :3] = rotation
    return matrix


class HeadStep(NamedTuple):
    """The head and the stage in two frames that follow each other.

    `head` is stage-from-head, `avatar` world-from-stage, `seconds` the time between the two
    predicted display times, and `periods` that time in frame periods: more than one where frames
    were dropped. `snap_turn`: the avatar was turned at once; `avatar_before` has been, too.
    """

    head_before: Pose
    head: Pose
    avatar_before: Pose
    avatar: Pose
    seconds: float
    periods: int = 1
    snap_turn: bool = False

    def turn_deg_s(self, of: Literal["head", "avatar", "both"]) -> float:
        """Return the speed of turning of the tracked head, of locomotion, or of their sum."""
        return turn_deg_s(*self._poses(of), seconds=self.seconds)

    def speed_m_s(self, of: Literal["head", "avatar", "both"]) -> float:
        """Return the speed of the head in its room, by locomotion, or in the world."""
        return speed_m_s(*self._poses(of), seconds=self.seconds)

    def _poses(self, of: Literal["head", "avatar", "both"]) -> tuple[Pose, Pose]:
        """Return world-from-head before and now, the other part resting as it is now."""
        head_before = self.head if of == "avatar" else self.head_before
        avatar_before = self.avatar if of == "head" else self.avatar_before
        return avatar_before @ head_before, self.avatar @ self.head


def speed_share(settings: SpeedRamps, step: HeadStep | None) -> float:
    """Return 0 (at rest, or after a cut) to 1 (at full speed), the same for both eyes."""
    if step is None:
        return 0.0
    turning, moving, of = settings.turning, settings.moving, settings.speed_of
    by_turning = turning and ramp(step.turn_deg_s(of), turning.from_deg_s, turning.to_deg_s)
    by_moving = moving and ramp(step.speed_m_s(of), moving.from_m_s, moving.to_m_s)
    return max(by_turning or 0.0, by_moving or 0.0)


def previous_eye_pose(
    mode: CameraMode,
    *,
    world_from_stage: Pose,
    stage_from_head: Pose,
    head_from_eye: Pose,
    previous_world_from_stage: Pose,
    previous_stage_from_head: Pose,
    virtual_turning: VirtualTurning = "by_mode",
    neck: Neck | None = None,
) -> Pose:
    """Return world-from-eye of the previous frame, less the motion that is cancelled.

    Parameters
    ----------
    virtual_turning
        Whether turns of the avatar blur: ``kept``, ``cancelled`` (about the head centre), or as
        the mode has it.
    neck
        About which ``rotation_cancelled`` cancels, in place of the head centre.

    Notes
    -----
    - ``full``: the previous eye as it was.
    - ``head_cancelled``: the head has not moved in the stage; locomotion is kept.
    - ``rotation_cancelled``: the head has not turned in the stage, about its own centre (or its
      neck), so that pure head rotation gives zero velocity at every depth; translation (of the
      neck) and locomotion are kept.
    - ``rotation_cancelled_eye``: as Chapman's "Comfort and motion blur in VR" (2020) has it, each
      eye about itself: the lever arm from head to eye leaves a velocity. The avatar's turns are
      cancelled in the same way.
    - ``objects_only``: no camera moves, locomotion neither (Chapman's first form: the previous
      view is the present one).
    """
    previous_stage = previous_world_from_stage
    if mode == "objects_only":
        if virtual_turning != "kept":
            return world_from_stage @ stage_from_head @ head_from_eye
        previous_stage = turned_like(world_from_stage, previous_stage, stage_from_head)
    elif virtual_turning == "cancelled":
        previous_stage = turned_like(previous_stage, world_from_stage, stage_from_head)
    head = previous_stage_from_head
    if mode in ("head_cancelled", "objects_only"):
        head = stage_from_head
    elif mode == "rotation_cancelled":
        head = _not_turned(head, stage_from_head, neck)
    previous_eye = previous_stage @ head @ head_from_eye
    if mode != "rotation_cancelled_eye":
        return previous_eye
    stage = previous_stage if virtual_turning == "kept" else world_from_stage
    return previous_eye.turned_as(stage @ stage_from_head @ head_from_eye)


def _not_turned(previous: Pose, now: Pose, neck: Neck | None) -> Pose:
    """Return the previous head in stage, turned about its centre or neck to where it looks now."""
    if neck is None:
        return previous.turned_as(now)
    head_from_neck = Pose(np.array([0.0, -neck.below_m, neck.behind_m]))
    moved = (now @ head_from_neck).position - (previous @ head_from_neck).position
    return Pose(now.position - moved, now.orientation)


def turned_like(world_from_stage: Pose, other: Pose, stage_from_head: Pose) -> Pose:
    """Return a stage turned as another is, the head's centre staying where it is in the world."""
    head = stage_from_head.position
    lever = rotate(world_from_stage.orientation, head) - rotate(other.orientation, head)
    return Pose(world_from_stage.position + lever, other.orientation)


def hand_poses(
    carried: Carried,
    *,
    world_from_stage: Pose,
    stage_from_head: Pose,
    stage_from_hands: tuple[Pose | None, Pose | None],
    previous_world_from_stage: Pose,
    previous_stage_from_head: Pose,
    previous_stage_from_hands: tuple[Pose | None, Pose | None],
) -> tuple[HandPoses, HandPoses]:
    """Return world-from-hand now, and as motion blur counts it a frame ago.

    Notes
    -----
    - ``with_head``: a hand has moved as far as it has in the head's frame; the pose before is given
      as if the head had been where it is now. An object held still before the head is sharp in
      every mode.
    - ``in_world``: the hand where it was in the world. In a mode that cancels the head's motion,
      the hand that goes with the head blurs ("objects which are moving with the head ... blur
      incorrectly", Chapman 2020).

    A hand that was not known before has not moved.
    """
    found = []
    for hand, previous in zip(stage_from_hands, previous_stage_from_hands, strict=True):
        now = before = None if hand is None else world_from_stage @ hand
        if hand is not None and previous is not None:
            in_head, before_in_head = (
                head.inverse() @ each
                for head, each in ((stage_from_head, hand), (previous_stage_from_head, previous))
            )
            if carried == "in_world":
                before = previous_world_from_stage @ previous
            elif before_in_head != in_head:  # equal bits stay equal
                before = world_from_stage @ stage_from_head @ before_in_head
        found.append((now, before))
    hands, counted = zip(*found, strict=True)
    return HandPoses(*hands), HandPoses(*counted)


class CameraMotion(NamedTuple):
    """Matrices that place a point in the present and the previous view of each of n eyes.

    ``view = view_from_world · x`` and ``previous_view = previous_view_from_world · (x_before +
    eye_delta_m)``, where x is a world position less the present eye's position. Subtracting in
    float64 and sharing bit-equal rotations makes cancelled rotation exactly zero on the GPU.
    """

    view_from_world: Array
    """(n, 3, 3) rotations."""
    previous_view_from_world: Array
    """(n, 3, 3) rotations."""
    eye_m: Array
    """(n, 3) present eye position."""
    eye_delta_m: Array
    """(n, 3) present eye position less previous one, world axes."""
    turned: NDArray[np.bool_]
    """(n,) whether the two rotations differ."""


def camera_motion(eyes: Sequence[Pose], previous: Sequence[Pose]) -> CameraMotion:
    """Return the rotations and eye displacements between world-from-eye poses, all at once."""
    numbers = np.array([pose.numbers for pose in (*eyes, *previous)]).reshape(2, -1, 7)
    rows = [rotation_rows(*pose.numbers[3:]) for pose in (*eyes, *previous)]
    rotations = np.array(rows).reshape(2, -1, 3, 3)
    now, before = rotations.swapaxes(-1, -2)
    delta = numbers[0, :, :3] - numbers[1, :, :3]
    turned = (numbers[0, :, 3:] != numbers[1, :, 3:]).any(axis=-1)
    return CameraMotion(now, before, numbers[0, :, :3], delta, turned)


def previous_clip_from_clip(cameras: Sequence[EyeCamera], motion: CameraMotion) -> Array:
    """Return (n, 4, 4): where a point that does not move was before, from where it is in the image.

    With the same frustum for both. Exactly the identity where the pose has not changed, and without
    rotation where the orientation has not: cancelled rotation moves nothing.
    """
    before_from_now = np.zeros((len(cameras), 4, 4))
    turn = motion.previous_view_from_world @ motion.view_from_world.swapaxes(1, 2)
    before_from_now[:, :3, :3] = (turn - _UNIT[:3, :3]) * motion.turned[:, None, None]
    moved = motion.previous_view_from_world @ motion.eye_delta_m[:, :, None]
    before_from_now[:, :3, 3] = moved[..., 0]
    clip, view = projections(cameras)
    change: Array = clip @ before_from_now @ view
    return _UNIT + change


def clips_from_relative(cameras: Sequence[EyeCamera], motion: CameraMotion) -> Array:
    """Return (n, 4, 4) clip-from-relative; relative = world axes, with the eye as origin."""
    found = projections(cameras)[0].copy()
    found[:, :, :3] = found[:, :, :3] @ motion.view_from_world
    return found


def projections(cameras: Sequence[EyeCamera]) -> tuple[Array, Array]:
    """Return (n, 4, 4) clip-from-view and its inverses; read-only, for they are kept."""
    return _projections(*((each.fov, each.near_m) for each in cameras))


@lru_cache(maxsize=16)
def _projections(*frusta: tuple[Fov, float]) -> tuple[Array, Array]:
    found = np.array(
        [[make(*each) for each in frusta] for make in (clip_from_view, view_from_clip)]
    )
    found.setflags(write=False)
    return found[0], found[1]


def extrapolated_eye_pose(
    world_from_eye: Pose, previous_world_from_eye: Pose, frames: float
) -> Pose:
    """Return the eye pose `frames` after the present one (negative: before), velocity constant."""
    return interpolate_pose(previous_world_from_eye, world_from_eye, 1 + frames)
