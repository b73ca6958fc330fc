"""The small blur of each of many views through a lens."""

from __future__ import annotations

from typing import NamedTuple

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics.small_discs import PER_PX, grid_discs
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import make_dilation_pass

WIDEST_PX = 6.0
"""Every pixel of a disc is looked at: wider ones cost more than they are worth."""


class _Discs(NamedTuple):
    discs: bytes


class SmallDiscsKernel:
    """Neighbours trade light over the nearer one's disc (``small_discs.frag``)."""

    def __init__(self, ctx: moderngl.Context, coc: CocPasses) -> None:
        tiles = {"tiles": coc.tile_min_max}
        self._dilate = make_dilation_pass(ctx, coc, "depth_of_field/coc_tile_dilate.frag", tiles)
        discs = grid_discs(coc.limit_px)
        self._trade = FullscreenPass(
            ctx,
            "depth_of_field/small_discs.frag",
            size_px=coc.size_px,
            inputs={"colour_and_coc": coc.colour_and_coc, "dilated": self._dilate.target},
            constants=_Discs(discs.tobytes()),
            defines={"DISCS": len(discs), "PER_PX": float(PER_PX), "TILE": coc.tile_px},
        )
        self.target = self._trade.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._dilate.render(Aspect(pixel_aspect))
        self._trade.render(Aspect(pixel_aspect))
