"""Rotations as quaternions (x, y, z, w) and matrices, in float64."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from functools import reduce
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]

ROUNDING = 1e-14
"""So far the squared length of a unit quaternion may be from 1."""


_SUMMED_IN_TURN = 8
"""Shorter vectors are summed by NumPy from the first to the last, and so here: `sum` is exacter."""


def normalize(vector: ArrayLike) -> Array:
    """Return (..., n) vectors scaled to unit length."""
    array = np.asarray(vector, dtype=np.float64)
    if array.ndim == 1 and len(array) < _SUMMED_IN_TURN:  # the same bits, in a third of the time
        numbers = array.tolist()
        return array / math.sqrt(reduce(operator.add, map(operator.mul, numbers, numbers)))
    unit: Array = array / np.linalg.norm(array, axis=-1, keepdims=True)
    return unit


def unit_quaternion(quaternion: ArrayLike) -> Array:
    """Return the (4,) quaternion scaled to unit length, unchanged where only rounding is missing.

    Normalising twice may differ from normalising once in the last bit; so a pose that was
    written to a file and read back would not be the same pose.
    """
    q = np.asarray(quaternion, dtype=np.float64)
    return q if abs(float(q @ q) - 1.0) < ROUNDING else normalize(q)


def quaternion_multiply(a: ArrayLike, b: ArrayLike, /) -> Array:
    """Return the Hamilton product of (..., 4) quaternions (x, y, z, w): `b` is applied first."""
    return _joined(product(*_parts(a), *_parts(b)))


def rotate(quaternion: ArrayLike, vector: ArrayLike, /) -> Array:
    """Rotate (..., 3) vectors by (..., 4) unit quaternions."""
    return _joined(rotated(*_parts(quaternion), *_parts(vector)))


def product(
    ax: Any, ay: Any, az: Any, aw: Any, bx: Any, by: Any, bz: Any, bw: Any
) -> tuple[Any, Any, Any, Any]:
    """Return the components of the Hamilton product; each may be a number or an array."""
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def rotated(x: Any, y: Any, z: Any, w: Any, vx: Any, vy: Any, vz: Any) -> tuple[Any, Any, Any]:
    """Return the components of a vector turned by a unit quaternion; numbers or arrays."""
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return (
        vx + w * tx + (y * tz - z * ty),
        vy + w * ty + (z * tx - x * tz),
        vz + w * tz + (x * ty - y * tx),
    )


def _parts(vectors: ArrayLike) -> list[Any]:
    """Return the n components of (..., n) vectors: arrays, or numbers for a single vector.

    Numbers are ten times as fast as arrays of one, and a frame has a hundred poses.
    """
    array = np.asarray(vectors, dtype=np.float64)
    parts: list[Any] = array.tolist() if array.ndim == 1 else list(np.moveaxis(array, -1, 0))
    return parts


def _joined(parts: Sequence[Any]) -> Array:
    """Return the (..., n) vectors that have these components."""
    return np.array(parts) if isinstance(parts[0], float) else np.stack(parts, axis=-1)


def rotation_matrix(quaternion: ArrayLike, /) -> Array:
    """Return the (..., 3, 3) rotation matrix of (..., 4) unit quaternions."""
    x, y, z, w = _parts(quaternion)
    rows = rotation_rows(x, y, z, w)
    if isinstance(x, float):
        return np.array(rows)
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rotation_rows(x: Any, y: Any, z: Any, w: Any) -> list[list[Any]]:
    """Return the rows of the matrix of a unit quaternion; each part a number or an array."""
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


def axis_angle(axis: ArrayLike, angle_rad: ArrayLike, /) -> Array:
    """Return the (..., 4) quaternion of a right-handed turn about a (..., 3) axis."""
    half = np.asarray(angle_rad, dtype=np.float64)[..., None] / 2
    return np.concatenate([normalize(axis) * np.sin(half), np.cos(half)], axis=-1)


def yaw_pitch_roll(yaw_rad: float, pitch_rad: float, roll_rad: float) -> Array:
    """Return the quaternion of a head that turns left, then up, then rolls to its left.

    Intrinsic turns, each about the axis that the turn before left behind: +Y, +X, +Z.
    """
    halves = np.array([yaw_rad, pitch_rad, roll_rad]) / 2
    sin_yaw, sin_pitch, sin_roll = np.sin(halves).tolist()
    cos_yaw, cos_pitch, cos_roll = np.cos(halves).tolist()
    yaw_pitch = product(0.0, sin_yaw, 0.0, cos_yaw, sin_pitch, 0.0, 0.0, cos_pitch)
    return np.array(product(*yaw_pitch, 0.0, 0.0, sin_roll, cos_roll))


def slerp(a: ArrayLike, b: ArrayLike, t: ArrayLike, /) -> Array:
    """Interpolate (..., 4) unit quaternions along the shorter arc; `t` outside [0, 1] extrapolates.

    Notes
    -----
    Shoemake, "Animating rotation with quaternion curves", SIGGRAPH 1985.
    """
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    if a.ndim == b.ndim == np.ndim(t) + 1 == 1:
        return np.array(slerp_numbers(a.tolist(), b.tolist(), float(t)))  # type: ignore[arg-type]
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


def slerp_numbers(a: list[float], b: list[float], t: float) -> list[float]:
    """Return `slerp` of two quaternions, in plain numbers: hot."""
    if sum(map(operator.mul, a, b)) < 0:
        b = [-each for each in b]
    theta = 2 * math.atan2(math.dist(a, b), math.hypot(*map(operator.add, a, b)))
    weight_a, weight_b = 1.0 - t, t
    if theta >= 1e-9:
        sine = math.sin(theta)
        weight_a, weight_b = math.sin(weight_a * theta) / sine, math.sin(t * theta) / sine
    mixed = [weight_a * each + weight_b * other for each, other in zip(a, b, strict=True)]
    length = math.hypot(*mixed)
    return [each / length for each in mixed]


def turn_to(direction: Array) -> Array:
    """Return the shortest turn from −Z to a (3,) unit vector, as a quaternion."""
    x, y, z = direction
    across = np.hypot(x, y)
    if z > 0 and across < 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])  # straight back: any axis across will do
    # 1 − z, without the digits that a subtraction loses where z is nearly 1
    less_z = across**2 / (1.0 + z) if z > 0 else 1.0 - z
    return normalize(np.array([y, -x, 0.0, less_z]))
