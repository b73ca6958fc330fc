"""Points that fill a lens and a shutter evenly."""

from __future__ import annotations

import math

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


def sunflower(count: int) -> Array:
    """Return (count, 2) points spread over the unit disc, with its mean and second moments.

    Notes
    -----
    Vogel, "A better way to construct the sunflower head", 1979. Against these, the same count of R2
    points through `concentric_disc` has 3 to 6 times the error at an edge, because their moments
    are off.
    """
    index = np.arange(count)
    angle = index * np.pi * (3 - math.sqrt(5))
    radius = np.sqrt((index + 0.5) / count)
    return with_moments(radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1))


def with_moments(points: Array, variance: float = 0.25) -> Array:
    """Return (n, 2) points moved about 0 and stretched until their variance is the same all round.

    That of the unit disc is 1/4. Where all lie on a line, they have it along this line.
    """
    centred = points - points.mean(axis=0)
    found, axes = np.linalg.eigh(centred.T @ centred / len(points))
    stretch = np.sqrt(variance / np.where(found > 1e-9, found, np.inf))
    stretched: Array = centred @ (axes * stretch) @ axes.T
    return stretched


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


def lens_and_shutter(count: int, *, lens: bool, shutter: bool, seed: int) -> Array:
    """Return (count, 3): a point (x, y) of the unit disc and a time in [−½, ½) for each sample.

    Even and odd samples are two low-discrepancy sets, each moved by a random shift of its own: two
    independent halves. A longer list begins with the shorter one. Only the dimensions that are
    asked for are filled (fewer dimensions, more even); the others are 0.
    """
    used = [column for column, wanted in enumerate((lens, lens, shutter)) if wanted]
    shifts = np.random.default_rng(seed).random((2, 3))[:, used]
    square = np.full((count, 3), 0.5)
    for half, shift in enumerate(shifts):
        own = square[half::2]
        if used and len(own):
            own[:, used] = low_discrepancy(len(own), shift)
    disc = concentric_disc(square[:, :2])
    return np.column_stack([disc, square[:, 2] - 0.5])
