"""The light that neighbours trade over discs of a few pixels.

NumPy twins, in float64, of ``shaders/depth_of_field/small_discs.frag``. Radii are in pixels of
image width, negative in front of the focus.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array
from vrcomfort.optics.circle_of_confusion import disc_weight
from vrcomfort.optics.small_discs import PER_PX


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
