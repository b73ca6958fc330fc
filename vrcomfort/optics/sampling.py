"""Points that fill a lens and a shutter evenly."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array


def low_discrepancy(count: int, shift: ArrayLike) -> Array:
    """Return (count, n) points in [0, 1)ⁿ, moved around the torus by `shift` (n,).

    Notes
    -----
    Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018): steps by powers of
    1/φ, where φ is the root of φⁿ⁺¹ = φ + 1. The shift is a Cranley-Patterson rotation, so that
    two sets with different shifts are independent.
    """
    offset = np.asarray(shift, dtype=np.float64)
    phi = 1.5
    for _ in range(64):
        phi = (1 + phi) ** (1 / (len(offset) + 1))
    steps = phi ** -np.arange(1.0, len(offset) + 1)
    points: Array = (offset + np.arange(1, count + 1)[:, None] * steps) % 1.0
    return points


def concentric_disc(square: ArrayLike, /) -> Array:
    """Map (..., 2) points of the unit square to the unit disc, keeping areas and neighbours.

    Notes
    -----
    Shirley & Chiu, "A low distortion map between disk and square", 1997.
    """
    x, y = np.moveaxis(2 * np.asarray(square, dtype=np.float64) - 1, -1, 0)
    wide = np.abs(x) > np.abs(y)
    radius = np.where(wide, x, y)
    ratio = np.where(wide, y, x) / np.where(radius == 0, 1.0, radius)
    angle = np.where(wide, np.pi / 4 * ratio, np.pi / 2 - np.pi / 4 * ratio)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
