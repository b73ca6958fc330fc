"""Rings of samples at half resolution, behind and in front apart: an engine's way."""

from __future__ import annotations

from math import ceil

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.mip_chain import MipChain
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.half_resolution import (
    composite,
    half_size,
    halved,
)

RINGS = 5
"""The centre among them: 81 samples."""

LEVELS = 3
"""Of the mip chain above half resolution."""

TILE = 8
"""Side of a tile in texels of half resolution: 16 px."""

DILATIONS = 2
FADE_PX = 1.0, 2.0


class HalfResolutionRingsKernel:
    """As the depth of field of Filament (`dof.mat`, 5 rings as on desktops).

    Notes
    -----
    In front and behind are gathered apart; what is in front is looked for as far as the widest disc
    of the tiles around goes, up to `DILATIONS` tiles. Its fast tiles, hole filling and bokeh shape
    are left out. Written from its description.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - the method has no numbers
    ) -> None:
        size = half_size(coc.size_px)
        self._half = halved(ctx, coc, firefly=True)
        chain = MipChain(ctx, self._half.target, LEVELS, size)
        tiles = self._tile_passes(ctx, size)
        self._gather = FullscreenPass(
            ctx,
            "depth_of_field/half_resolution_rings.frag",
            size_px=size,
            inputs={
                "half_image": self._half.target,
                "levels": chain.levels,
                "tiles": tiles[-1].target,
            },
            filtered={"half_image", "levels"},
            defines={"RINGS": RINGS, "CHAIN": LEVELS, "TILE": TILE},
            more_components=(4,),
        )
        median = FullscreenPass(
            ctx,
            "depth_of_field/median.frag",
            size_px=size,
            inputs=dict(zip(("background", "foreground"), self._gather.targets, strict=True)),
            more_components=(4,),
        )
        background, foreground = median.targets
        shown = composite(ctx, coc, background, fade_px=FADE_PX, half_front=foreground)
        self._chain, self._tiles, self._after = chain, tiles, (median, shown)
        self.target = shown.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._half.render()
        self._chain.render()
        for each in self._tiles:
            each.render()
        self._gather.render(Aspect(pixel_aspect))
        for each in self._after:
            each.render()

    def _tile_passes(self, ctx: moderngl.Context, size: tuple[int, int]) -> list[FullscreenPass]:
        made: list[FullscreenPass] = []
        source = self._half.target
        for dilations in range(DILATIONS + 1):
            made.append(
                FullscreenPass(
                    ctx,
                    "depth_of_field/half_resolution_tiles.frag",
                    size_px=(ceil(size[0] / TILE), ceil(size[1] / TILE)),
                    inputs={"source": source},
                    defines={"DILATE": 1} if dilations else {"TILE": TILE},
                    components=2,
                )
            )
            source = made[-1].target
        return made
