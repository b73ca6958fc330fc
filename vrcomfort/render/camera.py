"""Where an eye is, where it was, and which point of its lens is looking: float64, no OpenGL."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vrcomfort.geometry import Array, Fov, Pose, clip_from_view

LensLaw = Literal["linear", "dioptre"]
"""Radius per metre of defocus, or per dioptre (all lenses)."""

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
        Distance of what is sharp, from the head centre along the head's forward axis.
    infinity_m
        Distance taken for the sky.
    px_per_defocus
        Radius of the circle of confusion per metre (or dioptre) of defocus.
    radius_limit_px
        No circle of confusion has a larger radius.
    distance_offset_m
        How far the lens is behind the head centre; `focus_m` and `infinity_m` are from the lens.
    """

    position: tuple[float, float]
    focus_m: float
    infinity_m: float
    px_per_defocus: float
    radius_limit_px: float
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
    lens
        A point of the lens other than the pinhole. A renderer built for lenses needs one.
    peripheral_axis, vignette_axis
        (3,) in the head's frame: what peripheral blur and the vignette are centred on, where that
        is not the head's forward axis.
    """

    world_from_eye: Pose
    fov: Fov
    near_m: float = NEAR_M
    world_from_head: Pose | None = None
    lens: Lens | None = None
    peripheral_axis: Array | None = None
    vignette_axis: Array | None = None

    @property
    def head(self) -> Pose:
        """Return world-from-head, or world-from-eye where no head was given."""
        return self.world_from_eye if self.world_from_head is None else self.world_from_head

    def clip_from_view(self) -> Array:
        """Return the (4, 4) reverse-Z projection."""
        return clip_from_view(self.fov, self.near_m)

    def view_from_relative(self) -> Array:
        """Return the (4, 4) rotation from world axes, with the eye as origin, into the view."""
        return rotation_only(self.world_from_eye.rotation.T)

    def clip_from_relative(self) -> Array:
        """Return (4, 4) clip-from-relative; relative = world axes, with the eye as origin."""
        matrix = self.clip_from_view().copy()
        matrix[:, :3] = matrix[:, :3] @ self.world_from_eye.rotation.T
        return matrix


@dataclass(frozen=True)
class PreviousCamera:
    """Where the eye counts as having been one frame ago, and the scene's time then.

    `render.camera_motion.previous_eye_pose` makes it; head-locked nodes do not use the pose.
    """

    world_from_eye: Pose
    time_s: float


def rotation_only(rotation: Array) -> Array:
    """Return a (3, 3) rotation as a (4, 4) matrix."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    return matrix
