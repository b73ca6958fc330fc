"""How far each point of an image moves while the shutter is open, and the most of each tile."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.max_reduction import MaxReductionPass
from vrcomfort.protocol.conditions import MotionBlur

LEAST_TILE_PX = 16
MOST_TILES = 4
"""Tiles that the longest half velocity may cross: more are finer, and more to look at."""
ROWS = 4
"""Rows of pixels that are summed up first; a tile has a multiple of them."""


class Shutter(NamedTuple):
    """Uniforms of ``include/half_velocity.glsl``."""

    shutter_fraction: float
    radius_limit_px: float


class TileMaxPass:
    """Sums up by tile how far points move while the shutter is open.

    Parameters
    ----------
    velocity
        RG16F (px per frame, +x right, +y up) of `size_px`.

    Attributes
    ----------
    target, crossing
        RGBA16F and RG16F, see ``tile_max.frag``; one texel for `tile_px` pixels each way.
    longest
        The longest half velocity of all frames, before the limit.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        velocity: moderngl.Texture,
        settings: MotionBlur,
        size_px: tuple[int, int],
    ) -> None:
        self.limit_px = settings.max_radius_percent / 100 * size_px[0]
        self.tile_px = max(LEAST_TILE_PX, ROWS * ceil(self.limit_px / MOST_TILES / ROWS))
        self.velocity = velocity
        self._fraction = settings.shutter_fraction
        columns, strips = ceil(size_px[0] / self.tile_px), ceil(size_px[1] / ROWS)
        self._strips = FullscreenPass(
            ctx,
            "motion_blur/tile_max.frag",
            size_px=(columns, strips),
            inputs={"velocity": velocity},
            more_components=(2,),
            defines={"TILE": self.tile_px, "ROWS": ROWS},
        )
        self._tiles = FullscreenPass(
            ctx,
            "motion_blur/tile_max.frag",
            size_px=(columns, ceil(size_px[1] / self.tile_px)),
            inputs=dict(zip(("source", "source_crossing"), self._strips.targets, strict=True)),
            more_components=(2,),
            defines={"STRIPS": self.tile_px // ROWS},
        )
        self.target, self.crossing = self._tiles.targets
        self.longest = MaxReductionPass(ctx, self.target)

    def render(self, scale: float = 1.0) -> Shutter:
        """Find the present streaks; `scale` shortens them all. Return how the shutter is open."""
        shutter = Shutter(self._fraction * scale, self.limit_px)
        self._strips.render(_Opening(shutter.shutter_fraction))
        self._tiles.render()
        self.longest.render()
        return shutter


class _Opening(NamedTuple):
    shutter_fraction: float
