"""Poisson taps in a pixel's own circle of confusion: the patterns of two sources.

For ``poisson12.frag`` (Hillaire et al. 2008, Fig. 3) and ``poisson15_near*.frag`` (Mantiuk et al.
2011, section 4) in ``shaders/depth_of_field``.
"""

from __future__ import annotations

import numpy as np

from vrcomfort.geometry import Array

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
