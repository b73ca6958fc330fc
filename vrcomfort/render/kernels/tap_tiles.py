"""Which tiles of an image take which kind of work, where discs have a few taps."""

from __future__ import annotations

from typing import NamedTuple

import moderngl

from vrcomfort.render.defocus import Defocus
from vrcomfort.render.kernels.tile_passes import make_reach_pass

OWN, AROUND = "b", "a"
"""Channels of :attr:`TapTiles.kinds`: a tile's own kind, and those of all that read it."""


class Bounds(NamedTuple):
    """Radii that divide the kinds of tiles (``include/kinds.glsl``)."""

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


class TapTiles:
    """What may reach each tile (``tap_reach.frag``), and whose programs read it."""

    def __init__(self, ctx: moderngl.Context, defocus: Defocus, bounds: Bounds) -> None:
        tiles = {"tiles": defocus.tiles}
        self._reach = make_reach_pass(ctx, defocus, "tap_reach.frag", tiles, bounds.defines())
        reach = {"reach": self._reach.target}
        self._around = make_reach_pass(ctx, defocus, "tap_around.frag", reach)
        self.kinds = self._around.target
        """r, g: range of radii that may matter in the tile; kinds in `OWN` and `AROUND`."""

    def render(self) -> None:
        """Sort the tiles of the last eye."""
        self._reach.render()
        self._around.render()
