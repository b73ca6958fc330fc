"""Unity's head poses in our frames."""

from __future__ import annotations

import numpy as np

from vrcomfort.geometry import Array, axis_angle, quaternion_multiply


def positions_from_unity(positions: Array) -> Array:
    """Return (n, 3) right-handed positions of Unity's left-handed ones: ``(x, y, -z)``."""
    return positions * [1.0, 1.0, -1.0]


def orientations_from_unity(euler_deg: Array) -> Array:
    """Return (n, 4) right-handed quaternions of Unity's (n, 3) Euler angles in degrees.

    Unity turns about z first, then x, then y, by the left-hand rule. Quaternion algebra does not
    know about handedness, so the product is formed in Unity's frame and then mirrored in z:
    ``(-x, -y, z, w)``.
    """
    about_x, about_y, about_z = (
        axis_angle(axis, np.radians(angle))
        for axis, angle in zip(np.eye(3)[:, None], euler_deg.T, strict=True)
    )
    unity = quaternion_multiply(quaternion_multiply(about_y, about_x), about_z)
    return unity * [-1.0, -1.0, 1.0, 1.0]
