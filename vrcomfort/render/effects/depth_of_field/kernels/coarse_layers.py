"""Very wide blur, drawn on texels of 4, 8 and 16 px, as far as the limit of discs asks for them."""

from __future__ import annotations

from typing import Any

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics.gather_resolution import COARSEST_TEXEL_PX, coarser_above_px
from vrcomfort.optics.tile_classes import RingTile
from vrcomfort.optics.tile_classes import defines as class_defines
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.ring_tiles import READ_AROUND_PX
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import (
    Level,
    TilePasses,
    make_dilation_pass,
    make_level,
)


def read_around_px(limit_px: float, rings: int) -> int:
    """Return how much farther than discs reach their points may be read.

    Of texels a texel farther away, every texel that the disc covers: each is made of those around.
    """
    texel_px = 2
    while _needs_coarser(limit_px, rings, texel_px):
        texel_px *= 2
    return 3 * texel_px if texel_px > 2 else READ_AROUND_PX


def make_coarse_layers(
    ctx: moderngl.Context,
    coc: CocPasses,
    finer: Level,
    inputs: dict[str, moderngl.Texture],
    defines: dict[str, Any],
) -> CoarseLayers | None:
    """Return what draws the discs that are too wide for texels like those of `finer`, if any are.

    The parameters are those of :class:`CoarseLayers`.
    """
    if not _needs_coarser(coc.limit_px, defines["RINGS"], finer.texel_px):
        return None
    return CoarseLayers(ctx, coc, finer, inputs, defines)


class CoarseLayers:
    """Draws very wide discs on texels twice as wide as those of `finer` (:func:`coarser_above_px`).

    Parameters
    ----------
    finer
        Colours and signed radii.
    inputs
        The same of all pixels (`colour_and_coc`), and what may reach each tile (`dilated`).
    defines
        `RINGS` and `SMALL_PX`.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        finer: Level,
        inputs: dict[str, moderngl.Texture],
        defines: dict[str, Any],
    ) -> None:
        self.texel_px = texel_px = 2 * finer.texel_px
        rings = defines["RINGS"]
        self.above_px = coarser_above_px(rings, finer.texel_px)
        """Discs are drawn here from this radius on."""
        self._classes = make_dilation_pass(
            ctx,
            coc,
            "depth_of_field/classify_coarse_tiles.frag",
            {"dilated": inputs["dilated"]},
            margin_px=2 * texel_px,
            defines={"COARSE_PX": self.above_px, **class_defines(RingTile)},
            components=1,
        )
        self.classes = self._classes.target
        """`HALF_RESOLUTION` and `LAYERS` of `RingTile`."""
        self._tiles = TilePasses(ctx, coc, self.classes)
        here, foreground, self._background, self._foreground = (
            make_level(ctx, coc, texel_px, "f4") for _ in range(4)
        )
        self._coarser = make_coarse_layers(ctx, coc, here, inputs, defines)
        self._defines = {**defines, "LEVEL": texel_px}
        finer_input, points = (
            {"colour_and_coc": finer.texture},
            {"colour_and_coc": inputs["colour_and_coc"]},
        )
        self._downsampled = [
            self._tiles.make_pass(
                "depth_of_field/coc_downsample_tent.frag",
                RingTile.HALF_RESOLUTION,
                finer_input,
                here,
            ),
            self._tiles.make_pass(
                "depth_of_field/coarse_foreground.frag",
                RingTile.HALF_RESOLUTION,
                points,
                foreground,
                defines=self._defines,
            ),
        ]
        self._here, self._foreground_source = here.texture, foreground.texture
        seen = {"coarse_colour_and_coc": here.texture}
        in_foreground = {
            **seen,
            "coarse_foreground": foreground.texture,
            "dilated": inputs["dilated"],
        }
        self._layers = [
            self._layer(seen, self._background),
            self._layer(in_foreground, self._foreground, FOREGROUND=1),
        ]

    def render(self, pixel_aspect: float) -> None:
        """Draw both layers."""
        self._classes.render(Aspect(pixel_aspect))
        for each in self._downsampled:
            each.render()
        if self._coarser is not None:
            self._coarser.render(pixel_aspect)
        for layer in self._layers:
            layer.render(Aspect(pixel_aspect))

    def layers(self, *, foreground: bool) -> dict[str, moderngl.Texture]:
        """Return what ``bilateral_upsample.glsl`` reads: background, with `foreground` both."""
        background = {"wide_background": self._background.texture}
        return (
            {**background, "wide_foreground": self._foreground.texture}
            if foreground
            else background
        )

    def sources(self, *, foreground: bool) -> dict[str, moderngl.Texture]:
        """Return what ``coarse_gather.glsl`` reads for one of the layers."""
        return (
            {"coarse_foreground": self._foreground_source}
            if foreground
            else {"coarse_colour_and_coc": self._here}
        )

    def _layer(
        self, inputs: dict[str, moderngl.Texture], target: Level, **defines: Any
    ) -> FullscreenPass:
        wider, limit = read_coarser(self._coarser, foreground="FOREGROUND" in defines)
        defines = {**self._defines, **defines, **limit}
        return self._tiles.make_pass(
            "depth_of_field/gather_coarse.frag",
            RingTile.LAYERS,
            {**inputs, **wider},
            target,
            defines=defines,
        )


def read_coarser(
    coarser: CoarseLayers | None, *, foreground: bool
) -> tuple[dict[str, moderngl.Texture], dict[str, float]]:
    """Return the inputs and defines with which a layer reads one of wider texels, if there are."""
    if coarser is None:
        return {}, {}
    return coarser.layers(foreground=foreground), {"COARSE_PX": coarser.above_px}


def _needs_coarser(limit_px: float, rings: int, texel_px: int) -> bool:
    return texel_px < COARSEST_TEXEL_PX and limit_px > coarser_above_px(rings, texel_px)
