"""Which eye pose motion blur takes for the previous one, in float64 and without OpenGL."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Pose, interpolate_pose
from vrcomfort.protocol.conditions import CameraMode

Float32: TypeAlias = NDArray[np.float32]


def previous_eye_pose(
    mode: CameraMode,
    *,
    world_from_stage: Pose,
    stage_from_head: Pose,
    head_from_eye: Pose,
    previous_world_from_stage: Pose,
    previous_stage_from_head: Pose,
) -> Pose:
    """Return world-from-eye of the previous frame, less the motion that `mode` cancels.

    Notes
    -----
    - ``full``: the previous eye as it was.
    - ``head_cancelled``: the head has not moved in the stage; locomotion is kept.
    - ``rotation_cancelled``: the head has not turned in the stage, about its own centre, so that
      pure head rotation gives zero velocity at every depth; translation and locomotion are kept.
    - ``rotation_cancelled_eye``: as Chapman's "Comfort and motion blur in VR" (2020) has it, each
      eye about itself: the lever arm from head to eye leaves a velocity.
    - ``objects_only``: no camera moves, locomotion neither (Chapman's first form: the previous
      view is the present one).
    """
    if mode == "objects_only":
        return world_from_stage @ stage_from_head @ head_from_eye
    head = previous_stage_from_head
    if mode == "head_cancelled":
        head = stage_from_head
    elif mode == "rotation_cancelled":
        head = head.turned_as(stage_from_head)
    previous_eye = previous_world_from_stage @ head @ head_from_eye
    if mode != "rotation_cancelled_eye":
        return previous_eye
    return previous_eye.turned_as(world_from_stage @ stage_from_head @ head_from_eye)


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


def extrapolated_eye_pose(
    world_from_eye: Pose, previous_world_from_eye: Pose, frames: float
) -> Pose:
    """Return the eye pose `frames` after the present one (negative: before), velocity constant."""
    return interpolate_pose(previous_world_from_eye, world_from_eye, 1 + frames)


def _view_rotation(world_from_eye: Pose) -> Float32:
    return world_from_eye.rotation.T.astype(np.float32)
