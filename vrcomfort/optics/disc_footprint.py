"""Small discs as reads that cover them, every texel once: no OpenGL. All radii are in pixels.

For ``shaders/depth_of_field/disc_footprint.frag``. Between as many reads that
are spread over the disc by their area alone, as those of `optics.taps` are, there are gaps, and
some texels count twice: a light of a pixel becomes spots. All choices are ours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vrcomfort.geometry import Array

TALLEST = 1.5
"""In a headset pixels are at most so much taller than wide."""

NARROWER_PX = 0.05
"""How much narrower a disc is on the pixel grid: `grid_radius_px` of ``gather.glsl`` says why."""

INWARD_PX = 0.75
"""How far a read of 2 × 2 texels would move inwards, were all of it beyond the disc's rim."""


class DiscFootprint(NamedTuple):
    """Pairs of reads, opposite each other, from a disc's middle outwards."""

    pairs: Array
    """(n, 4): x and y (px) from the middle of the disc's pixel, how far that is, and by which part
    of it the read would move inwards, were all of it beyond the rim."""

    widest_px: float
    """Radius of the widest disc that is covered."""


def footprint(taps: int, width_px: int, *, tallest: float = TALLEST) -> DiscFootprint:
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
    return DiscFootprint(pairs, beyond - width_px / 2 + NARROWER_PX)


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
