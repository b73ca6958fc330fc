"""Very wide discs on wide texels: how wide they are there, and what a texel knows of fronts.

NumPy twins, in float64, of ``shaders/include/coarse.glsl``. Radii are in pixels of image width.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array

STEPS_PER_PX = 64
"""Steps of a radius that shares a number with a coverage."""


def level_variance_px2(texel_px: int) -> float:
    """Return the variance that wide texels blur with by themselves, along each axis.

    Halving by a tent of 3 texels adds half of their width squared, enlarging to texels half as wide
    as much on average: from 1 px to `texel_px`, a geometric series.
    """
    return (texel_px**2 - 1) / 3


def disc_texels(radius_px: ArrayLike, texel_px: int, /) -> Array:
    """Return the (...,) radius in texels of a disc that becomes as wide as it should be.

    A disc of radius r has variance r²/4 along each axis.
    """
    radius = np.asarray(radius_px, dtype=np.float64)
    own = np.sqrt(np.maximum(radius**2 - 4 * level_variance_px2(texel_px), 0))
    disc: Array = np.maximum(own / texel_px, 0.5)
    return disc


def packed_foreground(signed_px: ArrayLike, coverage: ArrayLike, /) -> Array:
    """Return a signed radius, rounded to 1/64 px, and a coverage from 0 to 1 in one number."""
    steps = np.floor(np.asarray(signed_px, dtype=np.float64) * STEPS_PER_PX + 0.5)
    packed: Array = steps + np.asarray(coverage) / 2
    return packed


def unpacked_foreground(packed: ArrayLike, /) -> tuple[Array, Array]:
    """Return signed radii and coverages of :func:`packed_foreground`."""
    number = np.asarray(packed, dtype=np.float64)
    whole = np.floor(number)
    return whole / STEPS_PER_PX, 2 * (number - whole)
