"""Blur by a MIP pyramid that is blown up again ("Four Tricks for Fast Blurring", 2001).

Trick three: ``mip_downsample.frag`` in ``shaders/common`` and ``mip.frag`` in
``shaders/depth_of_field``. Radii are in pixels.
"""

from __future__ import annotations

import numpy as np

MOST_LEVELS = 9
"""Enough for discs of 512 px radius; with `points` these are ten textures of sixteen."""


def levels(radius_limit_px: float) -> int:
    """Return how many levels discs up to this radius need: the last is at least as blurred."""
    return int(np.clip(np.ceil(np.log2(max(radius_limit_px, 2.0))), 1, MOST_LEVELS))
