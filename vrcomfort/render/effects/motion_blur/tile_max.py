"""How far each point of an image moves while the shutter is open, and the most of each tile."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.fullscreen_pass import FullscreenPass

LEAST_TILE_PX = 16
MOST_TILES = 8
"""Tiles that the longest half velocity may cross: more are finer, and more to look at."""
ROWS = 4
"""Rows of pixels that are summed up first; a tile has a multiple of them."""
AT_ONCE_PX = 400
"""Images up to so wide have few tiles: each is summed up at once."""
_LEAST = -1e30
"""Less than what any tile has."""


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
    frame
        The streaks of the whole frame.
    """

    def __init__(
        self, ctx: moderngl.Context, *, velocity: moderngl.Texture, limit_px: float, jump: float
    ) -> None:
        width, height = velocity.size
        self.tile_px = max(LEAST_TILE_PX, ROWS * ceil(limit_px / MOST_TILES / ROWS))
        at_once = width <= AT_ONCE_PX and self.tile_px == LEAST_TILE_PX
        rows = self.tile_px if at_once else ROWS
        self._strips = FullscreenPass(
            ctx,
            "motion_blur/tile_max.frag",
            size_px=(ceil(width / self.tile_px), ceil(height / rows)),
            inputs={"velocity": velocity},
            more_components=(2,),
            defines={"TILE": self.tile_px, "ROWS": rows, "JUMP": jump},
        )
        self._tiles = None if at_once else self._of_strips(ctx, height)
        self.target, self.crossing = (self._tiles or self._strips).targets
        self.frame = FrameStreaks(ctx, self.target)

    def _of_strips(self, ctx: moderngl.Context, height: int) -> FullscreenPass:
        strips = self._strips.targets
        return FullscreenPass(
            ctx,
            "motion_blur/tile_max.frag",
            size_px=(strips[0].width, ceil(height / self.tile_px)),
            inputs=dict(zip(("source", "source_crossing"), strips, strict=True)),
            more_components=(2,),
            defines={"STRIPS": self.tile_px // ROWS},
        )

    def render(self, shutter_fraction: float) -> None:
        """Find the present streaks; the shutter is open for this part of a frame period."""
        self._strips.render(_Opening(shutter_fraction))
        if self._tiles is not None:
            self._tiles.render()
        self.frame.render()


class FrameStreaks:
    """Sums up the tiles of a frame in one pixel, `target`: see ``frame_streaks.vert``."""

    def __init__(self, ctx: moderngl.Context, tile_max: moderngl.Texture) -> None:
        self._ctx, self._tile_max = ctx, tile_max
        self.target = gl.color_texture(ctx, (1, 1), dtype="f4")
        self._longest_of_all = gl.color_texture(ctx, (1, 1), components=1, dtype="f4")
        self._framebuffer = ctx.framebuffer([self.target, self._longest_of_all])
        self._framebuffer.clear()
        self._clear = gl.clearer(ctx)
        name = "motion_blur/frame_streaks"
        self._points = ctx.vertex_array(shaders.program(ctx, f"{name}.frag", f"{name}.vert"), [])
        self._points.program["tile_max"] = 0
        self._scope = ctx.scope(self._framebuffer, moderngl.BLEND)

    def render(self) -> None:
        """Begin with a new frame; what is remembered over all frames stays."""
        self._clear(self._framebuffer, (0.0, 0.0, _LEAST, 0.0))
        self._tile_max.use(0)
        self._ctx.blend_equation = (moderngl.MAX, moderngl.MAX)
        with self._scope:
            self._points.render(moderngl.POINTS, vertices=self._tile_max.height)
        self._ctx.blend_equation = (moderngl.FUNC_ADD, moderngl.FUNC_ADD)

    def longest_of_all_px(self) -> float:
        """Return the longest half velocity of all frames, before the limit; waits for the GPU."""
        return float(np.frombuffer(self._longest_of_all.read(), dtype=np.float32)[0])
