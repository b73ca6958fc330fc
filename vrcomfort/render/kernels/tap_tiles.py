"""Tiles of an image by the work that their blur takes, and passes over those of one kind."""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple

import moderngl

from vrcomfort.render import gl
from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass
from vrcomfort.render.kernels.tiles import reach_defines


class Bounds(NamedTuple):
    """Radii that divide the kinds of tiles (``include/tap_kinds.glsl``)."""

    slight_px: float
    few_px: float
    wide_px: float
    widest_px: float
    apart_px: float
    fine_reads: bool
    """Whether there is a program for what is alike, and neither few nor wide."""

    def defines(self) -> dict[str, float | str]:
        """Return them for ``tap_reach.frag``."""
        radii = {name.upper(): each for name, each in self._asdict().items() if "px" in name}
        return {**radii, "FINE_READS": "true" if self.fine_reads else "false"}


class Level(NamedTuple):
    """An image, or half or a quarter of it, whose texels are so many pixels wide."""

    texture: moderngl.Texture
    texel_px: int


class TapTiles:
    """What may reach each tile (``tap_reach.frag``, ``tap_around.frag``), and who draws it."""

    def __init__(self, ctx: moderngl.Context, defocus: Defocus, bounds: Bounds) -> None:
        self._ctx, self._defocus = ctx, defocus
        self._reach = self._of_all("tap_reach.frag", {"tiles": defocus.tiles}, bounds.defines())
        self._around = self._of_all("tap_around.frag", {"reach": self._reach.target}, {})

    def _of_all(
        self, fragment: str, inputs: dict[str, moderngl.Texture], defines: dict[str, Any]
    ) -> FullscreenPass:
        """Return a pass with a texel for each tile."""
        defines = {**reach_defines(self._defocus.limit_px, self._defocus.tile_px), **defines}
        if self._defocus.widest is not None:
            inputs = {**inputs, "widest_so_far": self._defocus.widest}
            defines = {**defines, "WIDEST_SO_FAR": 1}
        size = self._defocus.tiles.size
        return FullscreenPass(self._ctx, fragment, size_px=size, inputs=inputs, defines=defines)

    def render(self) -> None:
        """Sort the tiles of the last eye."""
        self._reach.render()
        self._around.render()

    def level(self, texel_px: int) -> Level:
        """Return a new target whose texels are so wide."""
        width, height = self._defocus.size_px
        size = ceil(width / texel_px), ceil(height / texel_px)
        return Level(gl.color_texture(self._ctx, size), texel_px)

    def make_pass(
        self,
        fragment: str,
        kinds: str,
        inputs: dict[str, moderngl.Texture],
        target: Level,
        *,
        around: bool = False,
        defines: dict[str, Any] | None = None,
        **options: Any,
    ) -> FullscreenPass:
        """Return a pass over the tiles of some kinds; `around`: over those that they read, too."""
        on_tiles = self._on_tiles(kinds, inputs, target, around=around, defines=defines)
        return FullscreenPass(self._ctx, fragment, **on_tiles, **options)

    def make_defocus_pass(
        self,
        fragment: str,
        kinds: str,
        inputs: dict[str, moderngl.Texture],
        target: Level,
        *,
        around: bool = False,
        defines: dict[str, Any] | None = None,
        **options: Any,
    ) -> FullscreenPass:
        """Return the same for a shader that includes ``defocus.glsl``."""
        on_tiles = self._on_tiles(kinds, inputs, target, around=around, defines=defines)
        return self._defocus.radii.make_pass(self._ctx, fragment, **on_tiles, **options)

    def _on_tiles(
        self,
        kinds: str,
        inputs: dict[str, moderngl.Texture],
        target: Level,
        *,
        around: bool,
        defines: dict[str, Any] | None,
    ) -> dict[str, Any]:
        tile_px, tiles = self._defocus.tile_px, self._around.target
        return {
            "size_px": target.texture.size,
            "inputs": {"reach": tiles, **inputs},
            "vertex": "tap_tiles.vert",
            "tiles": tiles.size,
            "target": target.texture,
            "defines": {
                "KINDS": kinds,
                "OF": "a" if around else "b",
                "TILE": tile_px,
                "POINT_PX": tile_px // target.texel_px,
                **(defines or {}),
            },
        }
