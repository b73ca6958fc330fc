"""What may reach a pixel: a summary of the discs of each tile of pixels and of its surroundings."""

from __future__ import annotations

from math import ceil

import moderngl

from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass

TILE_PX = 16
"""Side of the tiles that share one summary."""

TALLEST = 1.5
"""In a headset pixels are at most this much taller than wide."""


def reach_defines(limit_px: float, tile_px: int) -> dict[str, int | float]:
    """Return what ``include/tile_reach.glsl`` and its users need, where no disc is wider."""
    reach = max(1, ceil((TALLEST * limit_px + 1) / tile_px))
    return {"TILE": tile_px, "TALLEST": TALLEST, "REACH": reach}


def tile_passes(
    ctx: moderngl.Context, defocus: Defocus, *, small_px: float
) -> tuple[FullscreenPass, ...]:
    """Return the passes, in order; the last one's target has what may reach each tile.

    Parameters
    ----------
    small_px
        Discs up to this radius are told apart from wider ones; less than a tile.
    """
    width, height = defocus.size_px
    columns = (ceil(width / TILE_PX), height)
    tiles = (columns[0], ceil(height / TILE_PX))
    x_pass = FullscreenPass(
        ctx,
        "defocus_tiles.frag",
        size_px=columns,
        inputs={"source": defocus.points},
        defines={"TILE": TILE_PX, "SMALL_PX": small_px, "AXIS": 0},
    )
    y_pass = FullscreenPass(
        ctx,
        "defocus_tiles.frag",
        size_px=tiles,
        inputs={"source": x_pass.target},
        defines={"TILE": TILE_PX, "AXIS": 1},
    )
    reach = FullscreenPass(
        ctx,
        "defocus_reach.frag",
        size_px=tiles,
        inputs={"tiles": y_pass.target},
        defines=reach_defines(defocus.limit_px, TILE_PX),
    )
    return x_pass, y_pass, reach
