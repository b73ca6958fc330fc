"""Poses, fields of view and projections, in float64.

Frames follow OpenXR: right-handed, +Y up, −Z forward, metres, quaternions (x, y, z, w).
Transforms are named target-from-source: ``clip_from_view @ view_from_world``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NoReturn, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.rotations import (
    ROUNDING,
    Array,
    axis_angle,
    normalize,
    product,
    quaternion_multiply,
    rotate,
    rotated,
    rotation_matrix,
    rotation_rows,
    slerp,
    turn_to,
    unit_quaternion,
    yaw_pitch_roll,
)

__all__ = [
    "FARTHEST_M",
    "Array",
    "EyeGaze",
    "Fov",
    "Gaze",
    "HiddenArea",
    "HiddenAreas",
    "Pose",
    "Quad",
    "View",
    "axis_angle",
    "clip_from_view",
    "focal_length_px",
    "heading",
    "hidden_areas_of",
    "interpolate_pose",
    "normalize",
    "principal_point_px",
    "quaternion_multiply",
    "rotate",
    "rotation_matrix",
    "slerp",
    "turn_to",
    "unit_quaternion",
    "view_from_clip",
    "yaw_pitch_roll",
]

FARTHEST_M = 1e6
"""No position is further: no scene has anything there, and squares of distances leave single
precision."""


_write = object.__setattr__


class Pose:
    """A rigid transform: the place of a frame (`source`) in another (`target`). It never changes.

    Parameters
    ----------
    position
        (3,) metres, in the target frame.
    orientation
        (4,) unit quaternion (x, y, z, w), target-from-source.

    Attributes
    ----------
    numbers
        Position, then orientation. A frame has dozens of poses, and plain numbers take a tenth of
        the time of arrays of three: arrays are made of them where somebody asks for one.
    """

    __slots__ = ("_orientation", "_position", "_rotation", "numbers")
    numbers: tuple[float, ...]
    _position: Array
    _orientation: Array
    _rotation: Array

    def __init__(
        self,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (0.0, 0.0, 0.0, 1.0),
    ) -> None:
        x, y, z = np.asarray(position, dtype=np.float64).reshape(3).tolist()
        turn = unit_quaternion(np.asarray(orientation, dtype=np.float64).reshape(4))
        _write(self, "numbers", (x, y, z, *turn.tolist()))

    @classmethod
    def of(cls, position: Sequence[float], orientation: Sequence[float]) -> Pose:
        """Make a pose from plain numbers, in a tenth of the time."""
        x, y, z, w = orientation
        square = x * x + y * y + z * z + w * w
        if abs(square - 1.0) >= ROUNDING:
            length = math.sqrt(square)
            orientation = (x / length, y / length, z / length, w / length)
        pose = cls.__new__(cls)
        _write(pose, "numbers", (*position, *orientation))
        return pose

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a pose never changes: {name!r} cannot be set")

    def _keep(self, name: str, values: ArrayLike) -> Array:
        array = np.array(values, dtype=np.float64)
        array.setflags(write=False)
        _write(self, name, array)
        return array

    @property
    def position(self) -> Array:
        """Return (3,) metres."""
        try:
            return self._position
        except AttributeError:  # asked for the first time
            return self._keep("_position", self.numbers[:3])

    @property
    def orientation(self) -> Array:
        """Return the (4,) unit quaternion."""
        try:
            return self._orientation
        except AttributeError:
            return self._keep("_orientation", self.numbers[3:])

    @property
    def rotation(self) -> Array:
        """Return target-from-source as a (3, 3) rotation matrix."""
        try:
            return self._rotation
        except AttributeError:
            return self._keep("_rotation", rotation_rows(*self.numbers[3:]))

    def __matmul__(self, other: Pose) -> Pose:
        """Compose: ``a_from_c = a_from_b @ b_from_c``."""
        x, y, z, qx, qy, qz, qw = self.numbers
        px, py, pz, rx, ry, rz, rw = other.numbers
        dx, dy, dz = rotated(qx, qy, qz, qw, px, py, pz)
        turn = product(qx, qy, qz, qw, rx, ry, rz, rw)
        return Pose.of((x + dx, y + dy, z + dz), turn)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Pose) and self.numbers == other.numbers

    def __hash__(self) -> int:
        return hash(self.numbers)

    def __repr__(self) -> str:
        return f"Pose(position={self.numbers[:3]}, orientation={self.numbers[3:]})"

    def __reduce__(self) -> tuple[object, ...]:
        return Pose, (self.numbers[:3], self.numbers[3:])

    def inverse(self) -> Pose:
        """Return source-from-target."""
        px, py, pz, x, y, z, w = self.numbers
        back_x, back_y, back_z = rotated(-x, -y, -z, w, px, py, pz)
        return Pose.of((-back_x, -back_y, -back_z), (-x, -y, -z, w))

    def turned_as(self, other: Pose) -> Pose:
        """Return a pose that is where this one is and turned as the other one is."""
        return Pose.of(self.numbers[:3], other.numbers[3:])

    def matrix(self) -> Array:
        """Return target-from-source as a (4, 4) matrix."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = self.numbers[:3]
        return matrix

    @property
    def forward(self) -> Array:
        """Return the (3,) direction of −Z in the target frame."""
        _, _, _, x, y, z, w = self.numbers
        return np.array(rotated(x, y, z, w, 0.0, 0.0, -1.0))


@dataclass(frozen=True)
class Fov:
    """Half angles of an asymmetric frustum, radians, signed as in OpenXR.

    left and down are negative for a frustum that contains its own axis.
    """

    left: float
    right: float
    up: float
    down: float

    @cached_property
    def tangents(self) -> tuple[float, float, float, float]:
        """Return the tangents of (left, right, up, down)."""
        return math.tan(self.left), math.tan(self.right), math.tan(self.up), math.tan(self.down)

    @classmethod
    def symmetric(cls, *, vertical_rad: float, aspect: float) -> Fov:
        """Build a symmetric frustum from its full vertical angle and width / height."""
        up = vertical_rad / 2
        right = float(np.arctan(np.tan(up) * aspect))
        return cls(-right, right, up, -up)


@dataclass(frozen=True)
class View:
    """One eye: its pose (in the frame its owner states) and its frustum."""

    pose: Pose
    fov: Fov


@dataclass(frozen=True)
class EyeGaze:
    """Where an eye tracker says that one eye looks.

    Parameters
    ----------
    pose
        stage-from-gaze: at the eye, −Z along its line of sight.
    valid
        False where the tracker does not see this eye: `pose` means nothing then.
    pupil_mm
        Diameter of the pupil; None where the tracker does not tell it.
    """

    pose: Pose
    valid: bool = True
    pupil_mm: float | None = None


@dataclass(frozen=True)
class Gaze:
    """Where an eye tracker says that both eyes look.

    Parameters
    ----------
    pose
        stage-from-gaze: between the eyes, −Z along the line of sight.
    valid
        False during a blink or where the tracker has lost the eyes: `pose` means nothing then.
    eyes
        The left and the right eye; None where the tracker does not tell them apart.
    """

    pose: Pose
    valid: bool = True
    eyes: tuple[EyeGaze | None, EyeGaze | None] = (None, None)


@dataclass(frozen=True)
class Quad:
    """A rectangle in space that faces +Z of its own frame: a panel.

    Parameters
    ----------
    pose
        stage-from-quad: the centre, and which way it faces.
    size_m
        (width, height).
    """

    pose: Pose
    size_m: tuple[float, float]

    def intersection(self, ray: Pose) -> tuple[float, float] | None:
        """Return where the ray along −Z of `ray` meets the front: (right, down), each 0 to 1.

        None where it misses, runs along the rectangle, or comes from behind.
        """
        local = self.pose.inverse() @ ray
        height_m, fall = local.position[2], -local.forward[2]
        if height_m <= 0 or fall <= 0:
            return None
        x_m, y_m = (local.position + local.forward * (height_m / fall))[:2]
        right, down = x_m / self.size_m[0] + 0.5, 0.5 - y_m / self.size_m[1]
        inside = 0 <= right <= 1 and 0 <= down <= 1
        return (float(right), float(down)) if inside else None


@dataclass(frozen=True, eq=False)
class HiddenArea:
    """The part of one eye's image that the lens never shows: OpenXR's hidden triangle mesh.

    Parameters
    ----------
    vertices
        (n, 2) tangents of the view: x / −z and y / −z.
    triangles
        (m, 3) indices into `vertices`.
    """

    vertices: NDArray[np.float32]
    triangles: NDArray[np.uint32]

    @property
    def percent(self) -> float:
        """Return its part of the image, taking the outermost vertices for the image's corners."""
        a, b, c = np.moveaxis(self.vertices[self.triangles].astype(np.float64), 1, 0)
        (abx, aby), (acx, acy) = (b - a).T, (c - a).T
        hidden = np.abs(abx * acy - aby * acx).sum() / 2
        return float(100 * hidden / np.prod(np.ptp(self.vertices, axis=0)))

    @property
    def facts(self) -> dict[str, Any]:
        """Return the area for a JSON file; :meth:`of_facts` is the inverse."""
        return {"vertices": self.vertices.tolist(), "triangles": self.triangles.tolist()}

    @classmethod
    def of_facts(cls, facts: Mapping[str, Any]) -> HiddenArea:
        """Return the area that `facts` are of.

        Raises
        ------
        ValueError, KeyError, TypeError
            If they are of none.
        """
        vertices = np.array(facts["vertices"], dtype=np.float32).reshape(-1, 2)
        triangles = np.array(facts["triangles"], dtype=np.uint32).reshape(-1, 3)
        if not np.isfinite(vertices).all() or (triangles >= len(vertices)).any():
            raise ValueError("a vertex of a visibility mask is missing")
        return cls(vertices, triangles)


HiddenAreas: TypeAlias = tuple[HiddenArea | None, HiddenArea | None]
"""Of the left and the right eye; None where all of the image can be seen."""


def hidden_areas_of(headset: Mapping[str, Any]) -> HiddenAreas:
    """Return the hidden areas that a manifest's `headset` tells of; none where it tells why not.

    Raises
    ------
    ValueError, KeyError, TypeError
        If its ``visibility_mask`` is damaged.
    """
    facts = headset.get("visibility_mask", "")
    if isinstance(facts, str):
        return None, None
    left, right = (None if each is None else HiddenArea.of_facts(each) for each in facts)
    return left, right


def interpolate_pose(a: Pose, b: Pose, t: float) -> Pose:
    """Interpolate two poses: positions linearly, orientations by `slerp`; extrapolates too."""
    return Pose(a.position + (b.position - a.position) * t, slerp(a.orientation, b.orientation, t))


@lru_cache(maxsize=16)
def clip_from_view(fov: Fov, near_m: float) -> Array:
    """Return the (4, 4) reverse-Z projection with infinite far plane and clip depth [0, 1].

    Depth is ``near_m / distance``: 1 on the near plane, 0 at infinity, so ``1 / distance`` is
    linear in depth and the sky needs no special case. The array is kept, hence read-only: a
    headset's frusta stay the same.
    """
    left, right, up, down = fov.tangents
    width, height = right - left, up - down
    matrix = np.array(
        [
            [2 / width, 0.0, (right + left) / width, 0.0],
            [0.0, 2 / height, (up + down) / height, 0.0],
            [0.0, 0.0, 0.0, near_m],
            [0.0, 0.0, -1.0, 0.0],
        ]
    )
    matrix.setflags(write=False)
    return matrix


@lru_cache(maxsize=16)
def view_from_clip(fov: Fov, near_m: float) -> Array:
    """Return the (4, 4) inverse of `clip_from_view`, kept and read-only as well."""
    matrix = np.asarray(np.linalg.inv(clip_from_view(fov, near_m)), dtype=np.float64)
    matrix.setflags(write=False)
    return matrix


def focal_length_px(fov: Fov, size_px: tuple[int, int]) -> tuple[float, float]:
    """Return horizontal and vertical focal length in pixels of a (width, height) image."""
    left, right, up, down = fov.tangents
    return size_px[0] / (right - left), size_px[1] / (up - down)


def principal_point_px(fov: Fov, size_px: tuple[int, int]) -> tuple[float, float]:
    """Return the pixel coordinates of the optical axis, from the lower left corner."""
    left, right, up, down = fov.tangents
    return -left / (right - left) * size_px[0], -down / (up - down) * size_px[1]


def heading(pose: Pose) -> Array:
    """Return the turn about +Y that a pose holds; steep looks up or down keep their meaning."""
    # Straight up or down, forward has no heading: the top of the head tells it then.
    forward = rotate(pose.orientation, [0.0, 0.0, -1.0])
    up = rotate(pose.orientation, [0.0, 1.0, 0.0])
    level = forward if abs(forward[1]) < 0.99 else -np.sign(forward[1]) * up
    return axis_angle([0.0, 1.0, 0.0], np.arctan2(-level[0], -level[2]))
