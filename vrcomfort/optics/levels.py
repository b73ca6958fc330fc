"""On which level of an image a disc is summed, so that it never has too many texels: no OpenGL.

Level 0 are the pixels; texels of level L are 2^L px wide. Two levels share the discs between them
(``shaders/include/levels.glsl``). Radii are in pixels of image width. All choices are ours.
"""

from __future__ import annotations

from math import ceil, log2, pi, sqrt

MOST = 5
"""So many levels are kept with two surfaces in a texel: the last one takes all that is wider."""

FADED = 0.85
"""Part of its widest disc from which a level shares with the next."""

HALF_WIDER = 1.5
"""At half resolution, where there are a quarter of the pixels, a disc of one surface is summed on a
level up to so many times the radius, in texels."""


LEAST_TEXELS = 16
"""Of a disc; with fewer, where they lie begins to show."""


def exact_px(samples: int) -> float:
    """Return the radius of a disc that so many pixels fill: up to there all of them are summed."""
    return sqrt(samples / pi)


def levels(limit_px: float, samples: int) -> int:
    """Return how many levels there are, for discs of at most this radius."""
    widest = exact_px(samples)
    if limit_px <= FADED * widest:
        return 1
    return min(1 + max(1, ceil(log2(limit_px / widest))), MOST)


def coarser_behind(samples: int) -> bool:
    """Return whether what is behind a surface is summed one level coarser than the surface.

    It fills only a part of a pixel; a disc has a quarter of the texels there.
    """
    return samples // 4 >= LEAST_TEXELS


def coarsest_of_one_surface(limit_px: float, samples: int) -> int:
    """Return the coarsest level on which discs of one surface are summed, 1 at least."""
    halvings = ceil(log2(max(limit_px / 2 / (HALF_WIDER * exact_px(samples)), 1.0)))
    return min(1 + halvings, MOST - 1)
