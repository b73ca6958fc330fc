"""Poses, fields of view and projections, in float64.

Frames follow OpenXR: right-handed, +Y up, −Z forward, metres, quaternions (x, y, z, w).
Transforms are named target-from-source: ``clip_from_view @ view_from_world``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]


def _frozen(values: ArrayLike, size: int) -> Array:
    array = np.array(values, dtype=np.float64).reshape(size)
    array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False)
class Pose:
    """A rigid transform: the place of a frame (`source`) in another (`target`).

    Parameters
    ----------
    position
        (3,) metres, in the target frame.
    orientation
        (4,) unit quaternion (x, y, z, w), target-from-source.
    """

    position: Array = field(default_factory=lambda: np.zeros(3))
    orientation: Array = field(default_factory=lambda: np.array([0.0, 0.0, 0.0, 1.0]))

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", _frozen(self.position, 3))
        object.__setattr__(self, "orientation", _frozen(unit_quaternion(self.orientation), 4))

    def __matmul__(self, other: Pose) -> Pose:
        """Compose: ``a_from_c = a_from_b @ b_from_c``."""
        return Pose(
            self.position + rotate(self.orientation, other.position),
            quaternion_multiply(self.orientation, other.orientation),
        )

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Pose)
            and np.array_equal(self.position, other.position)
            and np.array_equal(self.orientation, other.orientation)
        )

    def __hash__(self) -> int:
        return hash((self.position.tobytes(), self.orientation.tobytes()))

    def inverse(self) -> Pose:
        """Return source-from-target."""
        inverse = self.orientation * [-1.0, -1.0, -1.0, 1.0]
        return Pose(-rotate(inverse, self.position), inverse)

    def matrix(self) -> Array:
        """Return target-from-source as a (4, 4) matrix."""
        matrix = np.eye(4)
        matrix[:3, :3] = rotation_matrix(self.orientation)
        matrix[:3, 3] = self.position
        return matrix

    @property
    def forward(self) -> Array:
        """Return the (3,) direction of −Z in the target frame."""
        return rotate(self.orientation, np.array([0.0, 0.0, -1.0]))


@dataclass(frozen=True)
class Fov:
    """Half angles of an asymmetric frustum, radians, signed as in OpenXR.

    left and down are negative for a frustum that contains its own axis.
    """

    left: float
    right: float
    up: float
    down: float

    @property
    def tangents(self) -> tuple[float, float, float, float]:
        """Return the tangents of (left, right, up, down)."""
        left, right, up, down = np.tan([self.left, self.right, self.up, self.down])
        return float(left), float(right), float(up), float(down)

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
class Gaze:
    """Where an eye tracker says that both eyes look.

    Parameters
    ----------
    pose
        stage-from-gaze: between the eyes, −Z along the line of sight.
    valid
        False during a blink or where the tracker has lost the eyes: `pose` means nothing then.
    """

    pose: Pose
    valid: bool = True


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


def normalize(vector: ArrayLike) -> Array:
    """Return (..., n) vectors scaled to unit length."""
    array = np.asarray(vector, dtype=np.float64)
    unit: Array = array / np.linalg.norm(array, axis=-1, keepdims=True)
    return unit


def unit_quaternion(quaternion: ArrayLike) -> Array:
    """Return the (4,) quaternion scaled to unit length, unchanged where only rounding is missing.

    Normalising twice may differ from normalising once in the last bit; so a pose that was
    written to a file and read back would not be the same pose.
    """
    q = np.asarray(quaternion, dtype=np.float64)
    return q if abs(float(q @ q) - 1.0) < 1e-14 else normalize(q)


def quaternion_multiply(a: ArrayLike, b: ArrayLike, /) -> Array:
    """Return the Hamilton product of (..., 4) quaternions (x, y, z, w): `b` is applied first."""
    ax, ay, az, aw = _parts(a)
    bx, by, bz, bw = _parts(b)
    return _joined(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )


def rotate(quaternion: ArrayLike, vector: ArrayLike, /) -> Array:
    """Rotate (..., 3) vectors by (..., 4) unit quaternions."""
    x, y, z, w = _parts(quaternion)
    vx, vy, vz = _parts(vector)
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return _joined(
        [
            vx + w * tx + (y * tz - z * ty),
            vy + w * ty + (z * tx - x * tz),
            vz + w * tz + (x * ty - y * tx),
        ]
    )


def _parts(vectors: ArrayLike) -> list[Any]:
    """Return the n components of (..., n) vectors: arrays, or numbers for a single vector.

    Numbers are ten times as fast as arrays of one, and a frame has a hundred poses.
    """
    array = np.asarray(vectors, dtype=np.float64)
    parts: list[Any] = array.tolist() if array.ndim == 1 else list(np.moveaxis(array, -1, 0))
    return parts


def _joined(parts: list[Any]) -> Array:
    """Return the (..., n) vectors that have these components."""
    return np.array(parts) if isinstance(parts[0], float) else np.stack(parts, axis=-1)


def rotation_matrix(quaternion: ArrayLike, /) -> Array:
    """Return the (..., 3, 3) rotation matrix of (..., 4) unit quaternions."""
    x, y, z, w = _parts(quaternion)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    if isinstance(x, float):
        return np.array(rows)
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def axis_angle(axis: ArrayLike, angle_rad: ArrayLike, /) -> Array:
    """Return the (..., 4) quaternion of a right-handed turn about a (..., 3) axis."""
    half = np.asarray(angle_rad, dtype=np.float64)[..., None] / 2
    return np.concatenate([normalize(axis) * np.sin(half), np.cos(half)], axis=-1)


def yaw_pitch_roll(yaw_rad: float, pitch_rad: float, roll_rad: float) -> Array:
    """Return the quaternion of a head that turns left, then up, then rolls to its left.

    Intrinsic turns, each about the axis that the turn before left behind: +Y, +X, +Z.
    """
    yaw = axis_angle([0.0, 1.0, 0.0], yaw_rad)
    pitch = axis_angle([1.0, 0.0, 0.0], pitch_rad)
    roll = axis_angle([0.0, 0.0, 1.0], roll_rad)
    return quaternion_multiply(quaternion_multiply(yaw, pitch), roll)


def slerp(a: ArrayLike, b: ArrayLike, t: ArrayLike, /) -> Array:
    """Interpolate (..., 4) unit quaternions along the shorter arc; `t` outside [0, 1] extrapolates.

    Notes
    -----
    Shoemake, "Animating rotation with quaternion curves", SIGGRAPH 1985.
    """
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    t = np.asarray(t, dtype=np.float64)[..., None]
    cosine = np.sum(a * b, axis=-1, keepdims=True)
    b = np.where(cosine < 0, -b, b)
    # atan2 of half chords keeps its accuracy at both ends, where arccos loses half the digits.
    theta = 2 * np.arctan2(
        np.linalg.norm(a - b, axis=-1, keepdims=True), np.linalg.norm(a + b, axis=-1, keepdims=True)
    )
    sine = np.sin(theta)
    near = theta < 1e-9
    safe = np.where(near, 1.0, sine)
    weight_a = np.where(near, 1.0 - t, np.sin((1.0 - t) * theta) / safe)
    weight_b = np.where(near, t, np.sin(t * theta) / safe)
    return normalize(weight_a * a + weight_b * b)


def interpolate_pose(a: Pose, b: Pose, t: float) -> Pose:
    """Interpolate two poses: positions linearly, orientations by `slerp`; extrapolates too."""
    return Pose(a.position + (b.position - a.position) * t, slerp(a.orientation, b.orientation, t))


def clip_from_view(fov: Fov, near_m: float) -> Array:
    """Return the (4, 4) reverse-Z projection with infinite far plane and clip depth [0, 1].

    Depth is ``near_m / distance``: 1 on the near plane, 0 at infinity, so ``1 / distance`` is
    linear in depth and the sky needs no special case.
    """
    left, right, up, down = fov.tangents
    matrix = np.zeros((4, 4))
    matrix[0, 0] = 2 / (right - left)
    matrix[0, 2] = (right + left) / (right - left)
    matrix[1, 1] = 2 / (up - down)
    matrix[1, 2] = (up + down) / (up - down)
    matrix[2, 3] = near_m
    matrix[3, 2] = -1.0
    return matrix


def focal_length_px(fov: Fov, size_px: tuple[int, int]) -> tuple[float, float]:
    """Return horizontal and vertical focal length in pixels of a (width, height) image."""
    left, right, up, down = fov.tangents
    return size_px[0] / (right - left), size_px[1] / (up - down)


def principal_point_px(fov: Fov, size_px: tuple[int, int]) -> tuple[float, float]:
    """Return the pixel coordinates of the optical axis, from the lower left corner."""
    left, right, up, down = fov.tangents
    return -left / (right - left) * size_px[0], -down / (up - down) * size_px[1]
