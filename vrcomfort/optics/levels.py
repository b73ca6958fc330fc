"""On which level of an image a disc is summed, so that it never has too many texels: no OpenGL.

Level 0 are the pixels; texels of level L are 2^L px wide. Twin of ``shaders/include/levels.glsl``. Radii
are in pixels of image width. All choices are ours.
"""

from __future__ import annotations

from math import ceil, log2



MOST = 5
"""Levels there are programs for: the last one takes all that is wider."""

FADED = 0.85
"""Part of its widest disc from which a level shares with the next."""

FEWEST = 6
"""Reads of 2 × 2 texels that cover a disc of less than 3 px."""


def reads(samples: int) -> int:
    """Return how many reads of 2 × 2 texels cover a disc of so many samples."""
    return max(samples, 1)


def exact_px(samples: int) -> float:
    """Return the radius up to which a disc is summed over its pixels."""
    return samples / 10


def levels(limit_px: float, samples: int) -> int:
    """Return how many levels there are, for discs of at most this radius."""
    widest = exact_px(samples)
    if limit_px <= FADED * widest:
        return 1
    return min(1 + max(1, ceil(log2(limit_px / widest))), MOST)
