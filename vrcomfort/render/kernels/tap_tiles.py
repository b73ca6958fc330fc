"""Which tiles of an image take which kind of work, where discs have a few taps."""

from __future__ import annotations

from typing import Any, NamedTuple

import moderngl

from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass
from vrcomfort.render.kernels.tile_passes import reach_defines

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
        self._ctx, self._defocus = ctx, defocus
        self._reach = self._pass("tap_reach.frag", {"tiles": defocus.tiles}, bounds.defines())
        self._around = self._pass("tap_around.frag", {"reach": self._reach.target}, {})
        self.kinds = self._around.target
        """r, g: range of radii that may matter in the tile; kinds in `OWN` and `AROUND`."""

    def render(self) -> None:
        """Sort the tiles of the last eye."""
        self._reach.render()
        self._around.render()

    def _pass(
        self, fragment: str, inputs: dict[str, moderngl.Texture], defines: dict[str, Any]
    ) -> FullscreenPass:
        """Return a pass with a texel for each tile."""
        defines = {**reach_defines(self._defocus.limit_px, self._defocus.tile_px), **defines}
        if self._defocus.widest is not None:
            inputs = {**inputs, "widest_so_far": self._defocus.widest}
            defines = {**defines, "WIDEST_SO_FAR": 1}
        size = self._defocus.tiles.size
        return FullscreenPass(self._ctx, fragment, size_px=size, inputs=inputs, defines=defines)
