"""Discs of a few pixels, as wide as they should be on the pixel grid: no OpenGL.

For ``shaders/depth_of_field/small_discs.frag``. Radii are in pixels of image width.
"""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.optics.circle_of_confusion import disc_weight

PER_PX = 16
"""Entries of the table for each pixel of radius."""


def grid_discs(limit_px: float) -> NDArray[np.float32]:
    """Return (n, 2) discs for radii of 0, 1/16, 2/16 … px up to `limit_px`: a radius and a weight.

    Weights of :func:`disc_weight` at that radius, times the weight, add up to 1 over the pixel grid
    and have the variance of the disc, r²/4 along each axis. An image of pixels has the width of a
    pixel already; `disc_share` of ``gather.glsl``, for pixels that are spread alone, adds it.
    """
    radius = np.arange(PER_PX * ceil(limit_px) + 2) / PER_PX
    grid = np.linspace(0.5, radius[-1] + 1, 200 * len(radius))
    variance = np.maximum.accumulate(_sums(grid, squared=True) / _sums(grid) / 2)
    found = np.interp(radius**2 / 4, variance, grid)
    return np.column_stack([found, 1 / _sums(found)]).astype(np.float32)


def _sums(grid_radius: Array, *, squared: bool = False) -> Array:
    """Return the (n,) sums of the weights, or of weight times distance², over the pixel grid."""
    cells = np.arange(-ceil(grid_radius.max() + 1), ceil(grid_radius.max() + 1) + 1)
    squares, count = np.unique(np.add.outer(cells**2, cells**2), return_counts=True)
    weights = disc_weight(np.sqrt(squares), grid_radius[:, None]) * count
    sums: Array = weights @ (squares if squared else np.ones(len(squares)))
    return sums
