"""How far each point of an image moves while the shutter is open, and the most of each tile."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl

from vrcomfort.protocol.conditions import MotionBlur
from vrcomfort.render.fullscreen_pass import FullscreenPass
from vrcomfort.render.peak import PeakPass

LEAST_TILE_PX = 16
MOST_TILES = 4
"""Tiles that the longest half streak may cross: more are finer, and more to look at."""


class _Shutter(NamedTuple):
    shutter_fraction: float
    radius_limit_px: float


class Streaks:
    """Turns velocities into half streaks of at most `limit_px`, and sums them up by tile.

    Parameters
    ----------
    depth, velocity
        Reverse-Z D32F and RG16F (px per frame, +x right, +y up) of `size_px`.

    Attributes
    ----------
    points
        RGBA16F, see ``streaks.frag``.
    tiles
        RGBA16F, see ``streak_tiles.frag``; one texel for `tile_px` pixels each way.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        depth: moderngl.Texture,
        velocity: moderngl.Texture,
        settings: MotionBlur,
        size_px: tuple[int, int],
    ) -> None:
        self.limit_px = settings.max_radius_percent / 100 * size_px[0]
        self.tile_px = max(LEAST_TILE_PX, ceil(self.limit_px / MOST_TILES))
        self._fraction = settings.shutter_fraction
        self._streaks = FullscreenPass(
            ctx,
            "streaks.frag",
            size_px=size_px,
            inputs={"velocity": velocity, "depth": depth},
        )
        self.points = self._streaks.target
        columns, rows = (ceil(side / self.tile_px) for side in size_px)
        x_pass = _tile_pass(ctx, 0, self.points, (columns, size_px[1]), self.tile_px)
        y_pass = _tile_pass(ctx, 1, x_pass.target, (columns, rows), self.tile_px)
        self.tiles = y_pass.target
        self._tile_passes = (x_pass, y_pass)
        self._peak = PeakPass(ctx, self.tiles)

    def render(self, scale: float = 1.0) -> None:
        """Find the present streaks; `scale` shortens them all."""
        self._streaks.render(_Shutter(self._fraction * scale, self.limit_px))
        for stage in self._tile_passes:
            stage.render()
        self._peak.render()

    def longest_px(self) -> float:
        """Return the longest half streak of all frames, before the limit; waits for the GPU."""
        return self._peak.read()


def _tile_pass(
    ctx: moderngl.Context,
    axis: int,
    source: moderngl.Texture,
    size_px: tuple[int, int],
    tile_px: int,
) -> FullscreenPass:
    return FullscreenPass(
        ctx,
        "streak_tiles.frag",
        size_px=size_px,
        inputs={"source": source},
        defines={"TILE": tile_px, "AXIS": axis},
    )
