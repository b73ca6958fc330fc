"""Which tiles of an image take which kind of work, where discs have a few taps."""

from __future__ import annotations

import moderngl

from vrcomfort.optics.tile_kinds import Bounds
from vrcomfort.render.effects.depth_of_field.circle_of_confusion import Defocus
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import make_reach_pass

OWN, AROUND = "b", "a"
"""Channels of :attr:`TapTiles.kinds`: a tile's own kind, and those of all that read it."""


class TapTiles:
    """What may reach each tile (``tap_reach.frag``), and whose programs read it."""

    def __init__(self, ctx: moderngl.Context, defocus: Defocus, bounds: Bounds) -> None:
        tiles = {"tiles": defocus.tiles}
        self._reach = make_reach_pass(
            ctx, defocus, "depth_of_field/tap_reach.frag", tiles, defines=_defines(bounds)
        )
        reach = {"reach": self._reach.target}
        self._around = make_reach_pass(ctx, defocus, "depth_of_field/tap_around.frag", reach)
        self.kinds = self._around.target
        """r, g: range of radii that may matter in the tile; kinds in `OWN` and `AROUND`."""

    def render(self, pixel_aspect: float) -> None:
        """Sort the tiles of the last eye."""
        self._reach.render(Aspect(pixel_aspect))
        self._around.render(Aspect(pixel_aspect))


def _defines(bounds: Bounds) -> dict[str, float | str]:
    """Return them for ``tap_reach.frag``."""
    radii = {name.upper(): each for name, each in bounds._asdict().items() if "px" in name}
    return {**radii, "FINE_READS": "true" if bounds.fine_reads else "false"}
