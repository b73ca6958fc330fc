"""What may reach a pixel: a summary of the discs of each tile of pixels and of its surroundings."""

from __future__ import annotations

from math import ceil

import moderngl

from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass

TILE_PX = 16
"""Side of the tiles that share one summary."""

SMALL_PX = 2.0
"""What counts as a small disc unless a kernel says otherwise."""


def tile_passes(
    ctx: moderngl.Context, defocus: Defocus, *, small_px: float = SMALL_PX
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
    # Pixels are at most half again as tall as wide in any headset, hence the factor.
    reach = FullscreenPass(
        ctx,
        "defocus_reach.frag",
        size_px=tiles,
        inputs={"tiles": y_pass.target},
        defines={"REACH": max(1, ceil((1.5 * defocus.limit_px + 1) / TILE_PX)), "TILE": TILE_PX},
    )
    return x_pass, y_pass, reach
