"""The small blur of each of many views through a lens."""

from __future__ import annotations

from typing import NamedTuple

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics.small_discs import PER_PX, grid_discs
from vrcomfort.render.effects.depth_of_field.circle_of_confusion import Defocus
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import make_reach_pass

WIDEST_PX = 6.0
"""Every pixel of a disc is looked at: wider ones cost more than they are worth."""


class _Discs(NamedTuple):
    discs: bytes


class SmallDiscsKernel:
    """Neighbours trade light over the nearer one's disc (``small_discs.frag``)."""

    def __init__(self, ctx: moderngl.Context, defocus: Defocus) -> None:
        tiles = {"tiles": defocus.tiles}
        self._reach = make_reach_pass(ctx, defocus, "depth_of_field/defocus_reach.frag", tiles)
        discs = grid_discs(defocus.limit_px)
        self._trade = FullscreenPass(
            ctx,
            "depth_of_field/small_discs.frag",
            size_px=defocus.size_px,
            inputs={"points": defocus.points, "reach": self._reach.target},
            constants=_Discs(discs.tobytes()),
            defines={"DISCS": len(discs), "PER_PX": float(PER_PX), "TILE": defocus.tile_px},
        )
        self.target = self._trade.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._reach.render(Aspect(pixel_aspect))
        self._trade.render(Aspect(pixel_aspect))
