"""At which resolution a disc is gathered: every pixel, half of them, or still coarser texels.

Radii are in pixels of image width. All thresholds are ours.
"""

from __future__ import annotations

COARSEST_TEXEL_PX = 16
"""No texel is wider than the tiles that wide discs are drawn on."""


def small_px(rings: int) -> float:
    """Return the radius up to which a disc is summed over every pixel.

    Wider ones come from half resolution, which blurs by itself as a disc of 2.6 px does: discs
    hardly wider than that would be squares.
    """
    return max(rings + 1.7, 3.0)


def coarser_above_px(rings: int, texel_px: int) -> float:
    """Return the radius above which discs are drawn on texels twice as wide as these.

    At half resolution (2 px) that is where rings are nearly two texels apart, and a disc at least
    three of the wider texels. On wider ones every texel counts: a disc has up to 254 of them where
    rings are few, a quarter more work than 49 taps on each of four times as many texels.
    """
    if texel_px == 2:
        return float(4 * max(rings, 3))
    return float(texel_px * max(9, 2 * rings))
