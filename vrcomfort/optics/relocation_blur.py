"""How blurred the image is after a relocation."""

from __future__ import annotations

import math


def level_after(level: float, /, *, elapsed_s: float, duration_s: float) -> float:
    """Return the MIP level some time after a cut: from `level` to 0 at a constant rate.

    Parameters
    ----------
    level
        At the cut; a texel of level k is 2^k px wide.
    """
    return level * min(max(1 - elapsed_s / duration_s, 0.0), 1.0)


def levels(level: float, /) -> int:
    """Return how many halvings of the image a level is made of: the two around it."""
    return math.ceil(level)
