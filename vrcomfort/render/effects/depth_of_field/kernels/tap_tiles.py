"""Which tiles of an image take which kind of work, where discs have a few taps."""

from __future__ import annotations

import moderngl

from vrcomfort.optics.tile_classes import TapBounds, TapTile
from vrcomfort.optics.tile_classes import defines as class_defines
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import make_dilation_pass

OWN, AROUND = "b", "a"
"""Channels of :attr:`TapTiles.classes`: a tile's own class, and those of all that read it."""


class TapTiles:
    """What may reach each tile (``classify_tap_tiles.frag``), and whose programs read it."""

    def __init__(self, ctx: moderngl.Context, coc: CocPasses, bounds: TapBounds) -> None:
        tiles = {"tile_min_max": coc.tile_min_max}
        self._dilate = make_dilation_pass(
            ctx, coc, "depth_of_field/classify_tap_tiles.frag", tiles, defines=_defines(bounds)
        )
        dilated = {"dilated": self._dilate.target}
        self._around = make_dilation_pass(
            ctx, coc, "depth_of_field/dilate_tile_classes.frag", dilated
        )
        self.classes = self._around.target
        """r, g: range of radii that may matter in the tile; classes in `OWN` and `AROUND`."""

    def render(self, pixel_aspect: float) -> None:
        """Sort the tiles of the last eye."""
        self._dilate.render(Aspect(pixel_aspect))
        self._around.render(Aspect(pixel_aspect))


def _defines(bounds: TapBounds) -> dict[str, float | str]:
    """Return them for ``classify_tap_tiles.frag``."""
    radii = {name.upper(): each for name, each in bounds._asdict().items() if "px" in name}
    return {
        **class_defines(TapTile),
        **radii,
        "FINE_READS": "true" if bounds.fine_reads else "false",
    }
