"""What may reach a pixel: a summary of the discs of each tile of pixels and of its surroundings."""

from __future__ import annotations

from math import ceil
from typing import Any

import moderngl

from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass

TALLEST = 1.5
"""In a headset pixels are at most this much taller than wide."""

READ_AROUND_PX = 4
"""Half resolution is read between texels, each made of the points around one (blur_kinds.frag)."""


def reach_defines(limit_px: float, tile_px: int) -> dict[str, int | float]:
    """Return what ``include/tile_reach.glsl`` and its users need, where no disc is wider."""
    reach = max(1, ceil((TALLEST * limit_px + 1) / tile_px))
    return {"TILE": tile_px, "TALLEST": TALLEST, "REACH": reach}


class TileKinds:
    """Finds how each tile is blurred, and what the tiles around need of it (``blur_kinds.frag``).

    Parameters
    ----------
    small_px
        Discs up to this radius are told apart from wider ones; less than a tile.
    """

    def __init__(self, ctx: moderngl.Context, defocus: Defocus, *, small_px: float) -> None:
        self._ctx, self._defocus = ctx, defocus
        size_px, tile_px, limit_px = defocus.tiles.size, defocus.tile_px, defocus.limit_px
        self._tiles = defocus.lens_pass(
            "defocus_tiles.frag",
            size_px=size_px,
            inputs={"tiles": defocus.tiles},
            defines={"TILE": tile_px, "SMALL_PX": small_px},
        )
        self._reach = FullscreenPass(
            ctx,
            "defocus_reach.frag",
            size_px=size_px,
            inputs={"tiles": self._tiles.target},
            defines=reach_defines(limit_px, tile_px),
        )
        self.reach = self._reach.target
        """What may reach each tile."""
        self._kinds = FullscreenPass(
            ctx,
            "blur_kinds.frag",
            size_px=size_px,
            inputs={"reach": self.reach},
            defines={
                **reach_defines(limit_px + READ_AROUND_PX, tile_px),
                "MARGIN_PX": READ_AROUND_PX,
                "SMALL_PX": small_px,
            },
            components=1,
        )

    def render(self) -> None:
        """Look at the present image."""
        self._tiles.render(self._defocus.eye)
        self._reach.render()
        self._kinds.render()

    def points_pass(self) -> FullscreenPass:
        """Return the pass that draws the points which some tile needs."""
        options = self._on("POINTS", self._defocus.tile_px)
        return self._defocus.on_tiles(options.pop("inputs"), **options)

    def draw(
        self,
        fragment: str,
        kinds: str,
        inputs: dict[str, moderngl.Texture],
        *,
        halved: bool = False,
        defines: dict[str, Any] | None = None,
        **options: Any,
    ) -> FullscreenPass:
        """Return a pass over the tiles of some kinds of an image, or of half of it."""
        tile_px = self._defocus.tile_px // 2 if halved else self._defocus.tile_px
        width, height = self._defocus.size_px
        on = self._on(kinds, tile_px)
        return FullscreenPass(
            self._ctx,
            fragment,
            size_px=(ceil(width / 2), ceil(height / 2)) if halved else (width, height),
            inputs={**on.pop("inputs"), **inputs},
            defines={"TILE": self._defocus.tile_px, **on.pop("defines"), **(defines or {})},
            **on,
            **options,
        )

    def _on(self, kinds: str, point_px: int) -> dict[str, Any]:
        return {
            "inputs": {"kinds": self._kinds.target},
            "defines": {"KINDS": kinds, "POINT_PX": point_px},
            "vertex": "kind_tiles.vert",
            "tiles": self._kinds.target.size,
        }
