"""Which eye pose motion blur takes for the previous one, in float64 and without OpenGL."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose, interpolate_pose, rotate
from vrcomfort.protocol.conditions import CameraMode, Carried, Neck, VirtualTurning
from vrcomfort.scene.node_poses import HandPoses

Float32: TypeAlias = NDArray[np.float32]


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
      as if the head had been where it is now. What rests before the head is sharp in every mode.
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
    """What a vertex shader needs to place a point in the present and the previous view.

    ``view = view_from_world · x`` and ``previous_view = previous_view_from_world · (x_before +
    eye_delta_m)``, where x is a world position less the present eye's position. Subtracting in
    float64 and sharing bit-equal rotations makes cancelled rotation exactly zero on the GPU.
    """

    view_from_world: Float32
    """(3, 3) rotation."""
    previous_view_from_world: Float32
    """(3, 3) rotation."""
    eye_delta_m: Float32
    """(3,) present eye position less previous one, world axes."""


def camera_motion(world_from_eye: Pose, previous_world_from_eye: Pose) -> CameraMotion:
    """Return the float32 rotations and eye displacement between two eye poses."""
    delta = world_from_eye.position - previous_world_from_eye.position
    return CameraMotion(
        _view_rotation(world_from_eye),
        _view_rotation(previous_world_from_eye),
        delta.astype(np.float32),
    )


def previous_clip_from_clip(
    clip_from_view: Array, world_from_eye: Pose, previous_world_from_eye: Pose
) -> Array:
    """Return (4, 4): where a point that does not move was in the image before, from where it is.

    With `clip_from_view` for both. Exactly the identity where the pose has not changed, and without
    rotation where the orientation has not: cancelled rotation moves nothing.
    """
    before_from_now = np.zeros((4, 4))
    previous_from_world = previous_world_from_eye.rotation.T
    if not np.array_equal(world_from_eye.orientation, previous_world_from_eye.orientation):
        turn = previous_from_world @ world_from_eye.rotation
        before_from_now[:3, :3] = turn - np.eye(3)
    delta_m = world_from_eye.position - previous_world_from_eye.position
    before_from_now[:3, 3] = previous_from_world @ delta_m
    change: Array = clip_from_view @ before_from_now @ np.linalg.inv(clip_from_view)
    return np.eye(4) + change


def extrapolated_eye_pose(
    world_from_eye: Pose, previous_world_from_eye: Pose, frames: float
) -> Pose:
    """Return the eye pose `frames` after the present one (negative: before), velocity constant."""
    return interpolate_pose(previous_world_from_eye, world_from_eye, 1 + frames)


def _view_rotation(world_from_eye: Pose) -> Float32:
    return world_from_eye.rotation.T.astype(np.float32)
