"""Our kernel with few taps: each tile of the image by the cheapest program that is right for it."""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple

import moderngl
import numpy as np

from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render import gl
from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass
from vrcomfort.render.kernels.base import Aspect
from vrcomfort.render.kernels.tiles import TILE_PX, tile_passes

SMALL_TAPS = 12
"""No more are needed where discs are small: bilinear reads overlap."""


class _Offsets(NamedTuple):
    offsets: bytes


class TapsKernel:
    """Gathers a few taps from a disc, the same ones everywhere (``taps_*.frag``).

    Notes
    -----
    Tiles where nothing is blurred are copied. Where all is about alike, taps are bilinear reads:
    small discs at full resolution, wide ones at half. Only tiles in which surfaces mix look at the
    depth of each tap, as the rings of `VrcomfortKernel` do.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        defocus: Defocus,
        settings: DepthOfField,
    ) -> None:
        self._ctx, self._points, self._taps = ctx, defocus.points, settings.taps or SMALL_TAPS
        halves = _halve(ctx, defocus.points)
        quarters = _halve(ctx, halves.target)
        self._before = (*tile_passes(ctx, defocus), halves, quarters)
        self._reach = self._before[2].target
        self._wide = gl.color_texture(ctx, halves.target.size)
        self.target = gl.color_texture(ctx, defocus.size_px)
        few = min(self._taps, SMALL_TAPS)
        self._copy = self._tiles("taps_copy.frag", "COPIED", {"colour": colour})
        self._blurs = (
            self._alike("WIDE", halves.target, 2, self._taps, self._wide),
            self._alike("WIDEST", quarters.target, 4, self._taps, self._wide),
            self._alike("SMALL", defocus.points, 1, few, self.target),
            self._mixed(colour, halves.target),
        )
        self._enlarge = self._tiles(
            "taps_wide.frag", "WIDE | WIDEST", {"wide": self._wide}, filtered={"wide"}
        )

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        for each in (*self._before, self._copy):
            each.render()
        for blur in self._blurs:
            blur.render(Aspect(pixel_aspect))
        self._enlarge.render()

    def _alike(
        self, kinds: str, level: moderngl.Texture, texel: int, taps: int, target: moderngl.Texture
    ) -> FullscreenPass:
        """Return the pass over tiles of one surface that reads texels of this width (px)."""
        shown = 1 if texel == 1 else 2
        return self._tiles(
            "taps_alike.frag",
            kinds,
            {"level": level},
            filtered={"level"},
            target=target,
            constants=_offsets(taps),
            defines={
                "SHOWN": f"{shown}.0",
                "LEVEL": f"{texel}.0",
                "READ_PX2": coc.read_variance_px2(texel, shown) * 4,
                "PATTERN": taps,
                **({"RIM": 1} if shown > 1 else {}),
            },
        )

    def _mixed(self, colour: moderngl.Texture, halves: moderngl.Texture) -> FullscreenPass:
        return self._tiles(
            "taps_mixed.frag",
            "MIXED",
            {"colour": colour, "halves": halves},
            filtered={"points", "halves"},
            constants=_offsets(self._taps),
        )

    def _tiles(
        self,
        fragment: str,
        kinds: str,
        inputs: dict[str, moderngl.Texture],
        *,
        target: moderngl.Texture | None = None,
        defines: dict[str, Any] | None = None,
        **options: Any,
    ) -> FullscreenPass:
        """Return a pass over the tiles of some kinds."""
        common: dict[str, Any] = {"KINDS": kinds, "TILE": TILE_PX, "TAPS": self._taps}
        return FullscreenPass(
            self._ctx,
            fragment,
            size_px=self.target.size,
            inputs={"points": self._points, "reach": self._reach, **inputs},
            defines={**common, **(defines or {})},
            vertex="tap_tiles.vert",
            vertices=6 * self._reach.width * self._reach.height,
            target=target or self.target,
            **options,
        )


def _offsets(taps: int) -> _Offsets:
    return _Offsets(coc.tap_offsets(taps).astype(np.float32).tobytes())


def _halve(ctx: moderngl.Context, source: moderngl.Texture) -> FullscreenPass:
    width, height = source.size
    return FullscreenPass(
        ctx,
        "defocus_halve.frag",
        size_px=(ceil(width / 2), ceil(height / 2)),
        inputs={"points": source},
    )
