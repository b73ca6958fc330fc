"""Our cheapest kernel: everything but small discs is gathered at half resolution."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil
from typing import Any

import moderngl

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import blur_kernels
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.layered_gather import Aspect

_Inputs = Mapping[str, moderngl.Texture]


class HalfGatherKernel:
    """Halves the image, gathers there, and sums small discs over pixels.

    Notes
    -----
    Half an image keeps one surface in each texel: of thin things before the focus some are lost.
    Tiles in focus are copied; tiles without small discs are half the image, enlarged.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - its numbers are fixed
    ) -> None:
        self._ctx, self._size_px, self._tile_px = ctx, coc.size_px, coc.tile_px
        self._surfaces: list[FullscreenPass] = []
        for level in range(blur_kernels.half_gather_levels(coc.max_radius_px)):
            finer = self._surfaces[-1].target if level else coc.colour_and_coc
            defines = {"FROM_SURFACES": 1} if level else {"SMALL_PX": blur_kernels.SMALL_PX}
            self._surfaces.append(
                self._pass("half_surfaces", {"finer": finer}, 2 ** (level + 1), defines)
            )
        self._tiles = self._pass(
            "half_tiles",
            {"surfaces": self._surfaces[0].target},
            self._tile_px,
            {"TILE": self._tile_px // 2},
        )
        self._dilate = self._pass(
            "half_tile_dilate",
            {"tiles": self._tiles.target},
            self._tile_px,
            {"TILE": self._tile_px, "MAX_RADIUS_PX": float(coc.max_radius_px)},
        )
        small = {
            "SMALL_FROM_PX": blur_kernels.SMALL_FROM_PX,
            "SMALL_PX": blur_kernels.SMALL_PX,
        }
        images = {f"surfaces_{i}": each.target for i, each in enumerate(self._surfaces)}
        self._gather = self._pass(
            "half_gather",
            {"dilated": self._dilate.target, **images},
            2,
            {
                **small,
                "TILE": self._tile_px // 2,
                "LEVELS": len(images),
                "TEXELS_PER_PX": blur_kernels.HALF_TEXELS_PER_PX,
            },
        )
        self.target = gl.color_texture(ctx, coc.size_px)
        points, half = {"colour_and_coc": coc.colour_and_coc}, {"gathered": self._gather.target}
        self._sharp = self._composite("IN_FOCUS", "in_focus", points)
        self._wide = self._composite("FAST", "half_wide", half, filtered=set(half))
        both = {**points, **half}
        self._mixed = self._composite("COMPLEX", "half_mixed", both, small, filtered=set(both))

    def render(self, pixel_aspect: float) -> None:
        """Blur the image of the last eye."""
        aspect = Aspect(pixel_aspect)
        for each in self._surfaces:
            each.render()
        self._tiles.render()
        self._dilate.render(aspect)
        self._gather.render(aspect)
        self._sharp.render()
        self._wide.render()
        self._mixed.render(aspect)

    def _composite(
        self,
        name: str,
        fragment: str,
        inputs: _Inputs,
        defines: Mapping[str, Any] | None = None,
        **options: Any,
    ) -> FullscreenPass:
        """Return the pass that draws the tiles of a class."""
        of_class = {"CLASS": name, "POINT_PX": self._tile_px, "BESIDE": 0}
        return self._pass(
            fragment,
            {**inputs, "dilated": self._dilate.target},
            1,
            {**(defines or {}), **of_class},
            target=self.target,
            vertex="depth_of_field/tiles_of_class.vert",
            tiles=self._dilate.target.size,
            **options,
        )

    def _pass(
        self, name: str, inputs: _Inputs, texel_px: int, defines: Mapping[str, Any], **options: Any
    ) -> FullscreenPass:
        width, height = self._size_px
        return FullscreenPass(
            self._ctx,
            f"depth_of_field/{name}.frag",
            inputs=inputs,
            size_px=(ceil(width / texel_px), ceil(height / texel_px)),
            defines=defines,
            texel_px=(texel_px, texel_px),
            **options,
        )
