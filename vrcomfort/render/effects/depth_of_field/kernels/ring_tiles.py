"""What is to be drawn on each tile, where discs are summed over every pixel."""

from __future__ import annotations

import moderngl

from vrcomfort.optics.tile_classes import RingTile
from vrcomfort.optics.tile_classes import defines as class_defines
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import make_dilation_pass

READ_AROUND_PX = 4
"""Half resolution is read between texels, each made of the pixels around one
(``classify_ring_tiles.frag``)."""


class RingTiles:
    """Finds how each tile is blurred, and what the tiles around need of it.

    ``coc_tile_small_wide.frag``, ``coc_tile_dilate.frag``, ``classify_ring_tiles.frag``.

    Parameters
    ----------
    small_px
        Discs up to this radius are told apart from wider ones.
    read_around_px
        How much farther than discs reach their points are read.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        *,
        small_px: float,
        read_around_px: int = READ_AROUND_PX,
    ) -> None:
        self._coc = coc
        self._tiles = coc.depth_to_coc.make_pass(
            ctx,
            "depth_of_field/coc_tile_small_wide.frag",
            size_px=coc.tile_min_max.size,
            inputs={"tile_min_max": coc.tile_min_max},
            defines={"TILE": coc.tile_px, "SMALL_PX": small_px},
        )
        tiles = {"tiles": self._tiles.target}
        self._dilate = make_dilation_pass(ctx, coc, "depth_of_field/coc_tile_dilate.frag", tiles)
        self.dilated = self._dilate.target
        """What may reach each tile."""
        self._classes = make_dilation_pass(
            ctx,
            coc,
            "depth_of_field/classify_ring_tiles.frag",
            {"dilated": self.dilated},
            margin_px=read_around_px,
            defines={"SMALL_PX": small_px, **class_defines(RingTile)},
            components=1,
        )
        self.classes = self._classes.target
        """Bits of `RingTile`."""

    def render(self, pixel_aspect: float) -> None:
        """Look at the image of the last eye."""
        self._tiles.render(self._coc.now)
        self._dilate.render(Aspect(pixel_aspect))
        self._classes.render(Aspect(pixel_aspect))
