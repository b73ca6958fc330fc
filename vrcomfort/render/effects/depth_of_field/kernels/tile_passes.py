"""Passes over tiles of some classes only: each tile by a program that has just what it needs."""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple

import moderngl

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics.tile_classes import RingTile, TapTile
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses


class Level(NamedTuple):
    """An image, or half or a quarter of it, whose texels are so many pixels wide."""

    texture: moderngl.Texture
    texel_px: int


def make_level(ctx: moderngl.Context, coc: CocPasses, texel_px: int, dtype: str = "f2") -> Level:
    """Return a new target for all or a part of the resolution of an image."""
    width, height = coc.size_px
    size = ceil(width / texel_px), ceil(height / texel_px)
    return Level(gl.color_texture(ctx, size, dtype=dtype), texel_px)


def make_dilation_pass(
    ctx: moderngl.Context,
    coc: CocPasses,
    fragment: str,
    inputs: dict[str, moderngl.Texture],
    *,
    margin_px: int = 0,
    defines: dict[str, Any] | None = None,
    components: int = 4,
) -> FullscreenPass:
    """Return a pass with a texel for each tile, which looks as far around as discs have reached.

    The shader includes ``tile_dilate.glsl``, asks it for ``tiles_around``, and is drawn with
    `Aspect`.

    Parameters
    ----------
    margin_px
        How much farther than discs reach others may need something.
    """
    defines = {
        "TILE": coc.tile_px,
        "LIMIT_PX": float(coc.limit_px),
        "MARGIN_PX": margin_px,
        **(defines or {}),
    }
    if coc.widest is not None:
        inputs = {**inputs, "widest_so_far": coc.widest}
        defines["WIDEST_SO_FAR"] = 1
    size = coc.tile_min_max.size
    return FullscreenPass(
        ctx, fragment, size_px=size, inputs=inputs, defines=defines, components=components
    )


class TilePasses:
    """Makes passes over the tiles of some classes (``tiles_of_class.vert``).

    Parameters
    ----------
    classes
        A texel for each tile, its classes as bits (`tile_classes`) in some channels.
    """

    def __init__(self, ctx: moderngl.Context, coc: CocPasses, classes: moderngl.Texture) -> None:
        self._ctx, self._coc, self._classes = ctx, coc, classes

    def make_pass(
        self,
        fragment: str,
        classes: RingTile | TapTile,
        inputs: dict[str, moderngl.Texture],
        target: Level,
        *,
        channel: str = "r",
        defines: dict[str, Any] | None = None,
        lens: bool = False,
        **options: Any,
    ) -> FullscreenPass:
        """Return the pass over tiles that have one of `classes` in this channel.

        Parameters
        ----------
        lens
            The shader includes ``coc_of_depth.glsl``: the pass is drawn with `CocPasses.now`.
        """
        tile_px = self._coc.tile_px
        on_tiles: dict[str, Any] = {
            "size_px": target.texture.size,
            "inputs": {"tile_classes": self._classes, **inputs},
            "vertex": "depth_of_field/tiles_of_class.vert",
            "tiles": self._classes.size,
            "target": target.texture,
            "defines": {
                "CLASSES": classes.value,
                "CHANNEL": channel,
                "TILE": tile_px,
                "POINT_PX": tile_px // target.texel_px,
                **(defines or {}),
            },
        }
        if lens:
            return self._coc.depth_to_coc.make_pass(self._ctx, fragment, **on_tiles, **options)
        return FullscreenPass(self._ctx, fragment, **on_tiles, **options)
