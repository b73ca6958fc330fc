"""Small discs as reads that cover them, every texel once: no OpenGL. All radii are in pixels.

NumPy twins, in float64, of ``shaders/depth_of_field/taps_cover.frag``. Between as many reads that
are spread over the disc by their area alone, as those of `optics.taps` are, there are gaps, and
some texels count twice: a light of a pixel becomes spots. All choices are ours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array
from vrcomfort.optics.circle_of_confusion import disc_weight

TALLEST = 1.5
"""In a headset pixels are at most so much taller than wide."""

NARROWER_PX = 0.05
"""How much narrower a disc is on the pixel grid: :func:`fronts.grid_radius_px` says why."""

INWARD_PX = 0.75
"""How far a read of 2 × 2 texels would move inwards, were all of it beyond the disc's rim."""


class Cover(NamedTuple):
    """Pairs of reads, opposite each other, from a disc's middle outwards."""

    pairs: Array
    """(n, 4): x and y (px) from the middle of the disc's pixel, how far that is, and by which part
    of it the read would move inwards, were all of it beyond the rim."""

    widest_px: float
    """Radius of the widest disc that is covered."""


def cover(taps: int, width_px: int, *, tallest: float = TALLEST) -> Cover:
    """Return the reads around a disc's own texel, for discs that `taps` cover on square pixels.

    Parameters
    ----------
    width_px
        1: each read is a texel. 2: it is the middle of 2 × 2. These are four grids around the own
        texel, each a quarter turn from the next: every texel is read once, and the reads have
        their mean where the disc has it.
    tallest
        Pixels are at most so much taller than wide: there, discs have more reads.
    """
    halves = _texels(taps) if width_px == 1 else _blocks(taps)
    away = np.hypot(*halves.T)
    order = np.argsort(away, kind="stable")
    halves, away = halves[order], away[order]
    beyond = float(away[(taps - 1) // 2])
    needed = np.hypot(halves[:, 0], halves[:, 1] / tallest) < beyond - 1e-6
    inwards = INWARD_PX / away
    pairs = np.column_stack([halves, away, inwards])[needed]
    return Cover(pairs, beyond - width_px / 2 + NARROWER_PX)


def weight(away_px: ArrayLike, radius_px: ArrayLike, width_px: int, /) -> Array:
    """Return the (...,) part of a read so far from the middle of a disc that is inside.

    Its rim falls over the width of what is read.
    """
    inside: Array = disc_weight(away_px, np.asarray(radius_px) - NARROWER_PX, width_px)
    return inside


def covered(radius_px: float, found: Cover, width_px: int, pixel_aspect: float = 1.0) -> Array:
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


def _texels(count: int) -> Array:
    """Return one of each two opposite texels around one, the nearest `count` and others."""
    cells = np.arange(-count, count + 1.0)
    x, y = (each.ravel() for each in np.meshgrid(cells, cells))
    texels = np.stack([x, y], axis=-1)
    one_of_two: Array = texels[(y > 0) | ((y == 0) & (x > 0))]
    return one_of_two


def _blocks(count: int) -> Array:
    """Return the middles of one of each two opposite squares of 2 × 2 texels, as `_texels`."""
    cells = 2.0 * np.arange(count)
    x, y = (each.ravel() for each in np.meshgrid(cells + 1.5, cells + 0.5))
    return np.concatenate([np.stack([x, y], axis=-1), np.stack([-y, x], axis=-1)])
