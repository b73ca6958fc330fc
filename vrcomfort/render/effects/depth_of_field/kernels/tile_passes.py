"""Passes over tiles of some kinds only: each tile by a program that has just what it needs."""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple

import moderngl

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.render.effects.depth_of_field.circle_of_confusion import Defocus


class Level(NamedTuple):
    """An image, or half or a quarter of it, whose texels are so many pixels wide."""

    texture: moderngl.Texture
    texel_px: int


def make_level(ctx: moderngl.Context, defocus: Defocus, texel_px: int, dtype: str = "f2") -> Level:
    """Return a new target for all or a part of the resolution of an image."""
    width, height = defocus.size_px
    size = ceil(width / texel_px), ceil(height / texel_px)
    return Level(gl.color_texture(ctx, size, dtype=dtype), texel_px)


def make_reach_pass(
    ctx: moderngl.Context,
    defocus: Defocus,
    fragment: str,
    inputs: dict[str, moderngl.Texture],
    *,
    margin_px: int = 0,
    defines: dict[str, Any] | None = None,
    components: int = 4,
) -> FullscreenPass:
    """Return a pass with a texel for each tile, which looks as far around as discs have reached.

    The shader includes ``tile_reach.glsl``, asks it for ``reach_now``, and is drawn with `Aspect`.

    Parameters
    ----------
    margin_px
        How much farther than discs reach others may need something.
    """
    defines = {
        "TILE": defocus.tile_px,
        "LIMIT_PX": float(defocus.limit_px),
        "MARGIN_PX": margin_px,
        **(defines or {}),
    }
    if defocus.widest is not None:
        inputs = {**inputs, "widest_so_far": defocus.widest}
        defines["WIDEST_SO_FAR"] = 1
    size = defocus.tiles.size
    return FullscreenPass(
        ctx, fragment, size_px=size, inputs=inputs, defines=defines, components=components
    )


class TilePasses:
    """Makes passes over the tiles of `Defocus.tiles` that are of some kinds (``kind_tiles.vert``).

    Parameters
    ----------
    kinds
        A texel for each tile, its kinds as bits (``include/kinds.glsl``) in some channels.
    """

    def __init__(self, ctx: moderngl.Context, defocus: Defocus, kinds: moderngl.Texture) -> None:
        self._ctx, self._defocus, self._kinds = ctx, defocus, kinds

    def make_pass(
        self,
        fragment: str,
        kinds: str,
        inputs: dict[str, moderngl.Texture],
        target: Level,
        *,
        of: str = "r",
        defines: dict[str, Any] | None = None,
        lens: bool = False,
        **options: Any,
    ) -> FullscreenPass:
        """Return the pass over tiles that have one of `kinds` in channel `of`.

        Parameters
        ----------
        lens
            The shader includes ``defocus.glsl``: the pass is drawn with `Defocus.now`.
        """
        tile_px = self._defocus.tile_px
        on_tiles: dict[str, Any] = {
            "size_px": target.texture.size,
            "inputs": {"kinds": self._kinds, **inputs},
            "vertex": "depth_of_field/kind_tiles.vert",
            "tiles": self._kinds.size,
            "target": target.texture,
            "defines": {
                "KINDS": kinds,
                "OF": of,
                "TILE": tile_px,
                "POINT_PX": tile_px // target.texel_px,
                **(defines or {}),
            },
        }
        if lens:
            return self._defocus.radii.make_pass(self._ctx, fragment, **on_tiles, **options)
        return FullscreenPass(self._ctx, fragment, **on_tiles, **options)
