"""What is to be drawn on each tile, where discs are summed over every pixel."""

from __future__ import annotations

import moderngl

from vrcomfort.render.effects.depth_of_field.circle_of_confusion import Defocus
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import make_reach_pass

READ_AROUND_PX = 4
"""Half resolution is read between texels, each made of the points around one (blur_kinds.frag)."""


class TileKinds:
    """Finds how each tile is blurred, and what the tiles around need of it (``blur_kinds.frag``).

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
        defocus: Defocus,
        *,
        small_px: float,
        read_around_px: int = READ_AROUND_PX,
    ) -> None:
        self._defocus = defocus
        self._tiles = defocus.radii.make_pass(
            ctx,
            "depth_of_field/defocus_tiles.frag",
            size_px=defocus.tiles.size,
            inputs={"tiles": defocus.tiles},
            defines={"TILE": defocus.tile_px, "SMALL_PX": small_px},
        )
        tiles = {"tiles": self._tiles.target}
        self._reach = make_reach_pass(ctx, defocus, "depth_of_field/defocus_reach.frag", tiles)
        self.reach = self._reach.target
        """What may reach each tile."""
        self._kinds = make_reach_pass(
            ctx,
            defocus,
            "depth_of_field/blur_kinds.frag",
            {"reach": self.reach},
            margin_px=read_around_px,
            defines={"SMALL_PX": small_px},
            components=1,
        )
        self.kinds = self._kinds.target
        """Bits of ``include/kinds.glsl``."""

    def render(self, pixel_aspect: float) -> None:
        """Look at the image of the last eye."""
        self._tiles.render(self._defocus.now)
        self._reach.render(Aspect(pixel_aspect))
        self._kinds.render(Aspect(pixel_aspect))
