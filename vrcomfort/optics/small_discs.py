"""Discs of a few pixels, as wide as they should be on the pixel grid: no OpenGL.

NumPy twins, in float64, of ``shaders/depth_of_field/small_discs.frag``. Radii are in pixels
of image width, negative in front of the focus.
"""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array
from vrcomfort.optics.circle_of_confusion import disc_weight

PER_PX = 16
"""Entries of the table for each pixel of radius."""


def grid_discs(limit_px: float) -> NDArray[np.float32]:
    """Return (n, 2) discs for radii of 0, 1/16, 2/16 … px up to `limit_px`: a radius and a weight.

    Weights of :func:`disc_weight` at that radius, times the weight, add up to 1 over the pixel grid
    and have the variance of the disc, r²/4 along each axis. An image of pixels has the width of a
    pixel already; :func:`fronts.disc_share`, for pixels that are spread alone, adds it.
    """
    radius = np.arange(PER_PX * ceil(limit_px) + 2) / PER_PX
    grid = np.linspace(0.5, radius[-1] + 1, 200 * len(radius))
    variance = np.maximum.accumulate(_sums(grid, squared=True) / _sums(grid) / 2)
    found = np.interp(radius**2 / 4, variance, grid)
    return np.column_stack([found, 1 / _sums(found)]).astype(np.float32)


def share(away_px: ArrayLike, radius_px: ArrayLike, discs: NDArray[np.float32]) -> Array:
    """Return the part of their light that two pixels trade over a disc, per square pixel."""
    entry = np.arange(len(discs)) / PER_PX
    radius = np.asarray(radius_px, dtype=np.float64)
    grid, weight = (np.interp(radius, entry, column) for column in discs.T)
    part: Array = disc_weight(np.maximum(away_px, 1.0), grid) * weight
    return part


def trade(
    points: NDArray[np.floating], discs: NDArray[np.float32], pixel_aspect: float = 1.0
) -> Array:
    """Return (h, w, 3) blurred colours of (h, w, 4) points (colour and signed radius).

    Two pixels trade light over the disc of the nearer one, so that none is lost but at the rims of
    the image, beyond which its outermost pixels go on.
    """
    image = points.astype(np.float64)
    height, width = image.shape[:2]
    cells = int(np.abs(image[..., 3]).max() + 1)
    rows = int(np.abs(image[..., 3]).max() * pixel_aspect + 1)
    traded = np.zeros_like(image)
    for y in range(-rows, rows + 1):
        for x in range(-cells, cells + 1):
            across = np.clip(np.arange(width) + x, 0, width - 1)
            other = image[np.clip(np.arange(height) + y, 0, height - 1)][:, across]
            radius = np.abs(np.minimum(image[..., 3], other[..., 3]))
            part = share(np.hypot(x, y / pixel_aspect), radius, discs) / pixel_aspect
            part *= (x, y) != (0, 0)
            traded[..., :3] += part[..., None] * (other[..., :3] - image[..., :3])
            traded[..., 3] += part
    colour: Array = image[..., :3] + traded[..., :3] / np.maximum(traded[..., 3:], 1.0)
    return colour


def _sums(grid_radius: Array, *, squared: bool = False) -> Array:
    """Return the (n,) sums of the weights, or of weight times distance², over the pixel grid."""
    cells = np.arange(-ceil(grid_radius.max() + 1), ceil(grid_radius.max() + 1) + 1)
    squares, count = np.unique(np.add.outer(cells**2, cells**2), return_counts=True)
    weights = disc_weight(np.sqrt(squares), grid_radius[:, None]) * count
    sums: Array = weights @ (squares if squared else np.ones(len(squares)))
    return sums
