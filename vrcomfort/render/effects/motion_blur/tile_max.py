"""How far each point of an image moves while the shutter is open, and the most of each tile."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.max_reduction import MaxReductionPass

LEAST_TILE_PX = 16
MOST_TILES = 8
"""Tiles that the longest half velocity may cross: more are finer, and more to look at."""
ROWS = 4
"""Rows of pixels that are summed up first; a tile has a multiple of them."""


class _Opening(NamedTuple):
    shutter_fraction: float


class TileMaxPass:
    """Sums up by tile how far points move while the shutter is open.

    Parameters
    ----------
    velocity
        RG16F (px per frame, +x right, +y up).
    limit_px
        No half velocity counts for more, whatever it is.
    jump
        Things pass each other where half velocities differ by this part of the shorter one.

    Attributes
    ----------
    target, crossing
        RGBA16F and RG16F, see ``tile_max.frag``; one texel for `tile_px` pixels each way.
    frame_longest, longest
        The longest half velocity of the frame and of all frames, before the limit.
    """

    def __init__(
        self, ctx: moderngl.Context, *, velocity: moderngl.Texture, limit_px: float, jump: float
    ) -> None:
        width, height = velocity.size
        self.tile_px = max(LEAST_TILE_PX, ROWS * ceil(limit_px / MOST_TILES / ROWS))
        columns, strips = ceil(width / self.tile_px), ceil(height / ROWS)
        self._strips = FullscreenPass(
            ctx,
            "motion_blur/tile_max.frag",
            size_px=(columns, strips),
            inputs={"velocity": velocity},
            more_components=(2,),
            defines={"TILE": self.tile_px, "ROWS": ROWS, "JUMP": jump},
        )
        self._tiles = FullscreenPass(
            ctx,
            "motion_blur/tile_max.frag",
            size_px=(columns, ceil(height / self.tile_px)),
            inputs=dict(zip(("source", "source_crossing"), self._strips.targets, strict=True)),
            more_components=(2,),
            defines={"STRIPS": self.tile_px // ROWS},
        )
        self.target, self.crossing = self._tiles.targets
        self.frame_longest = MaxReductionPass(ctx, self.target)
        self.longest = MaxReductionPass(ctx, self.frame_longest.target, components="x")

    def render(self, shutter_fraction: float) -> None:
        """Find the present streaks; the shutter is open for this part of a frame period."""
        self._strips.render(_Opening(shutter_fraction))
        self._tiles.render()
        self.frame_longest.forget()
        self.frame_longest.render()
        self.longest.render()
