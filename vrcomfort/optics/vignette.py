"""A field-of-view restrictor: how wide the clear field is, and how much of the image it shows."""

from __future__ import annotations

import math

import numpy as np

from vrcomfort.geometry import Fov, Pose


def moved_towards(
    strength: float, wanted: float, /, *, elapsed_s: float, attack_s: float, release_s: float
) -> float:
    """Return the strength after some time, which closes and opens at a constant rate.

    Parameters
    ----------
    strength, wanted
        0 (open) to 1 (restricted).
    attack_s, release_s
        Seconds from 0 to 1 and from 1 to 0; 0 is at once. Frames of any length that add up to the
        same time give the same strength, as long as `wanted` is the same in them.
    """
    elapsed_s = max(elapsed_s, 0.0)
    duration_s = attack_s if wanted > strength else release_s
    if elapsed_s >= duration_s * abs(wanted - strength):
        return wanted
    return strength + math.copysign(elapsed_s / duration_s, wanted - strength)


def clear_deg(open_deg: float, restricted_deg: float, strength: float) -> float:
    """Return the diameter of the clear field, which is linear in the strength."""
    return open_deg + (restricted_deg - open_deg) * strength


def widest_angle_deg(fov: Fov, centre_from_eye: Pose) -> float:
    """Return the largest angle from the field's axis in an eye's image: a corner's.

    Parameters
    ----------
    centre_from_eye
        The axis is its −Z. Only its rotation counts: canted displays look past the head's axis.
    """
    left, right, up, down = fov.tangents
    rays = np.array([(x, y, -1.0) for x in (left, right) for y in (up, down)])
    x, y, z = centre_from_eye.matrix()[:3, :3] @ rays.T
    return float(np.degrees(np.arctan2(np.hypot(x, y), -z)).max())
