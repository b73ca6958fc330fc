"""Sample patterns and mip levels of depth of field's kernels.

For the layered gather (``shaders/include/levels.glsl``), mip 0 is the image itself, a texel of mip
L is 2^L px wide, and two mips share the discs between them. Radii are in pixels of image width.
All choices are ours. The kernels of sources follow below it.
"""

from __future__ import annotations

from math import ceil, log2, pi, sqrt

import numpy as np

from vrcomfort.geometry import Array

MOST_MIPS = 5
"""So many levels are kept with two surfaces in a texel: the last one takes all that is wider."""

CROSS_FADE_FROM = 0.85
"""Part of its widest disc from which a level shares with the next."""

WIDER = 1.5
"""From half resolution on, where there are a quarter of the pixels, a disc is summed on a level up
to this many times the radius, in texels."""


LEAST_TEXELS = 16
"""Of a disc; with fewer, where they lie begins to show."""


def exact_px(samples: int) -> float:
    """Return the radius of a disc of `samples` pixels: up to there all of them are summed."""
    return sqrt(samples / pi)


def gather_mips(max_radius_px: float, samples: int) -> int:
    """Return how many levels there are, for discs of at most this radius."""
    widest = exact_px(samples)
    if max_radius_px <= CROSS_FADE_FROM * widest:
        return 1
    return min(1 + max(1, ceil(log2(max_radius_px / (WIDER * widest)))), MOST_MIPS)


def coarser_behind(samples: int) -> bool:
    """Return whether the background of a surface is summed one mip coarser than the surface.

    It fills only a part of a pixel; a disc has a quarter of the texels there.
    """
    return samples // 4 >= LEAST_TEXELS


# Gather at half resolution, for the fewest samples (``shaders/depth_of_field/half_*.frag``).


HALF_GATHER_SAMPLES = 12
"""So many `samples` stand for it."""

SMALL_FROM_PX, SMALL_PX = 2.25, 3.5
"""Between these radii (px) a disc goes from taps in the pixels to the half image. Lower ones cost
less and err more: ``python -m bench.blur --set samples=12 --size 640x800``."""

HALF_TEXELS_PER_PX = 0.25
"""By how much the radius (px) of a disc is multiplied for the side of the texels, in those of the
half image, that it is summed on: of six to 25 there, and more below 5.6 px."""


def half_gather_levels(max_radius_px: float) -> int:
    """Return how many images it reads, each half as large as the one before."""
    coarsest = log2(max(HALF_TEXELS_PER_PX * max_radius_px, 1.0))
    return min(1 + max(0, ceil(coarsest - 0.4)), MOST_MIPS)


# Poisson taps in a pixel's own circle of confusion, for ``depth_of_field/poisson12.frag`` (Hillaire
# et al. 2008, Fig. 3) and ``depth_of_field/poisson15_near*.frag`` (Mantiuk et al. 2011, section 4).


POISSON_12 = np.array(
    [
        (0.0549, -0.0231),
        (-0.0813, -0.2218),
        (-0.1485, 0.1838),
        (0.1302, 0.2101),
        (-0.2833, -0.0743),
        (0.2939, 0.0259),
        (0.2846, -0.2128),
        (0.0939, -0.4167),
        (-0.4239, 0.1404),
        (-0.2854, -0.3510),
        (-0.0173, 0.4655),
        (0.3821, 0.2738),
    ]
)
"""(12, 2) offsets in a disc of diameter 1. The paper gives their number and their kind only; these
are apart by 0.23 at least, without a shift, and as spread out as the disc."""

POISSON_15 = np.array(
    [
        (0.0626, -0.1011),
        (-0.0137, 0.1263),
        (-0.1700, -0.0570),
        (0.1898, 0.0880),
        (-0.1170, -0.2627),
        (-0.2701, 0.1966),
        (0.0326, 0.3404),
        (0.3388, -0.0909),
        (0.2746, 0.2961),
        (-0.4134, -0.0120),
        (-0.3614, -0.2303),
        (0.2362, -0.3689),
        (0.0279, -0.4383),
        (0.4387, 0.1114),
        (-0.2556, 0.4023),
    ]
)
"""(15, 2) offsets in a disc of diameter 1, as `POISSON_12`; 0.2 apart at least."""

ROTATIONS_PX = 32
"""Side of the tile of angles; the paper says "a single low-resolution 2D texture"."""

NEAR_LEVEL = 3
"""Halvings of the near circles: "to 1/8th of its size in every dimension"."""


def rotations() -> Array:
    """Return (side, side, 2) cosine and sine of a random angle per pixel, the same every time."""
    angle = np.random.default_rng(2008).uniform(0, 2 * np.pi, (ROTATIONS_PX, ROTATIONS_PX))
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


# Blur by a MIP pyramid that is magnified again ("Four Tricks for Fast Blurring", 2001), for
# ``common/mip_downsample.frag`` and ``depth_of_field/mip.frag``. Radii are in pixels.


MOST_PYRAMID_LEVELS = 9
"""Enough for discs of 512 px radius; with `points` these are ten textures of sixteen."""


def pyramid_levels(max_radius_px: float) -> int:
    """Return how many levels discs up to this radius need: the last is at least as blurred."""
    return int(np.clip(np.ceil(np.log2(max(max_radius_px, 2.0))), 1, MOST_PYRAMID_LEVELS))
