"""What the reads that cover a small disc weigh.

NumPy twins, in float64, of ``shaders/depth_of_field/disc_footprint.frag``. Radii are in pixels.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array
from vrcomfort.optics.circle_of_confusion import disc_weight
from vrcomfort.optics.disc_footprint import NARROWER_PX, DiscFootprint


def weight(away_px: ArrayLike, radius_px: ArrayLike, width_px: int, /) -> Array:
    """Return the (...,) part of a read so far from the middle of a disc that is inside.

    Its rim falls over the width of what is read.
    """
    inside: Array = disc_weight(away_px, np.asarray(radius_px) - NARROWER_PX, width_px)
    return inside


def covered(
    radius_px: float, found: DiscFootprint, width_px: int, pixel_aspect: float = 1.0
) -> Array:
    """Return (n, 3): x and y (px) of the reads for a disc, and their weights, which add up to 1.

    Wider discs than the widest spread the reads. Texels beside the disc's own are in twos, and a
    read of 2 × 2 counts for four.
    """
    spread = max(radius_px / found.widest_px, 1.0)
    halves, inwards = found.pairs[:, :2], found.pairs[:, 3]
    away = np.hypot(halves[:, 0], halves[:, 1] / pixel_aspect)
    inside = weight(away, radius_px / spread, width_px)
    if width_px > 1:
        halves = halves * (1 - inwards * (1 - inside))[:, None]
    own = [[0.0, 0.0, float(weight(0.0, radius_px / spread, width_px))]]
    one = np.column_stack([spread * halves, inside * width_px**2])
    reads = np.concatenate([own, one, one * [-1, -1, 1]])
    shares: Array = reads / [1, 1, reads[:, 2].sum()]
    return shares
