"""Who is in front of whom where discs are gathered: told by signed radii, which order depth.

NumPy twins, in float64, of ``shaders/include/discs.glsl``; of `margin_px` and `nearer` in
``coc.glsl``. Radii are in pixels of image width, negative in front of the focus. All thresholds are
ours.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array

RIM_PX = math.sqrt(20 / 12)
"""A rim that falls as smoothstep over so many pixels has the variance of a pixel, 1/12."""


def margin_px(radius_px: ArrayLike, /) -> Array:
    """Return how much nearer, in radius, another point must be to be a surface of its own.

    Well above the rounding of half floats; a slanted surface stays one.
    """
    return np.maximum(0.125, 0.05 * np.abs(np.asarray(radius_px, dtype=np.float64)))


def nearer(radius_px: ArrayLike, other_px: ArrayLike, /) -> Array:
    """Return 0 where the other point is on the same surface or behind, up to 1 where it is nearer.

    It grows between one margin and two.
    """
    radius, other = (np.asarray(each, dtype=np.float64) for each in (radius_px, other_px))
    return np.clip((radius - other) / margin_px(radius) - 1, 0.0, 1.0)


def farther(radius_px: ArrayLike, other_px: ArrayLike, /) -> Array:
    """Return 0 where the other point may be on the same surface or is nearer, 1 where it is behind.

    A surface that slants is hardly more than a tenth of the radius and an eighth of a pixel behind
    itself.
    """
    radius, other = (np.asarray(each, dtype=np.float64) for each in (radius_px, other_px))
    return np.clip((other - radius) / (0.2 * np.abs(radius) + 0.25) - 0.5, 0.0, 1.0)


def slack_px(radius_px: ArrayLike, /) -> Array:
    """Return how much another radius may differ to count in full as one of this point's surface.

    0 where the point is sharp, so that nothing but itself is seen at it.
    """
    radius = np.abs(np.asarray(radius_px, dtype=np.float64))
    return np.minimum(margin_px(radius), np.maximum(radius - 0.5, 0.0))


def grid_radius_px(radius_px: ArrayLike, /) -> Array:
    """Return the (...,) radius at which :func:`disc_share` comes closest to a lens.

    Notes
    -----
    From 1 px on, 0.02 px less than the radius would give the area that a disc around a pixel's
    middle shares with each pixel: the best there is if pixels are squares of one colour. A lens
    sees what pixels are means of, and its image is averaged over pixels once, not twice: discs
    0.04 to 0.12 px narrower are closer to that. 0.05 px less is close to both. Near 0.5 px, where
    the image must be left as it is, nothing of the disc may be on the next pixel.
    """
    radius = np.asarray(radius_px, dtype=np.float64)
    return np.minimum(radius - 0.05, 1 - RIM_PX / 2 + 3 * (radius - 0.5))


def disc_share(away_px: ArrayLike, grid_radius: ArrayLike, /) -> Array:
    """Return π times the part of a disc's light that lands on a square pixel of its plane.

    Parameters
    ----------
    grid_radius
        :func:`grid_radius_px` of the disc's radius.
    """
    radius = np.asarray(grid_radius, dtype=np.float64)
    inside = np.clip((radius - np.asarray(away_px)) / RIM_PX + 0.5, 0, 1)
    share: Array = inside**2 * (3 - 2 * inside) / (radius**2 + 1 / 12)
    return share


def disc_texels(radius_px: ArrayLike, texel_px: float, /) -> Array:
    """Return the radius in texels that are means of pixels: half of their blur is made up for."""
    squares = np.asarray(radius_px, dtype=np.float64) ** 2 - (texel_px**2 - 1) / 2
    return np.maximum(np.sqrt(np.maximum(squares, 0.0)) / texel_px, 0.5)
