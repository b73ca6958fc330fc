"""Our kernel with few taps: each tile of the image by the cheapest program that is right for it."""

from __future__ import annotations

from math import ceil, pi, sqrt
from typing import Any, NamedTuple

import moderngl
import numpy as np

from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.render import gl
from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass
from vrcomfort.render.kernels.base import Aspect
from vrcomfort.render.kernels.tiles import reach_defines

LEAST_TAPS = 4
"""Fewer have not the disc's second moments."""

READ_AREA = 4.0
"""A bilinear read stands for so many texels."""

LEAST_WIDE_PX = 2.6
"""What is drawn at half resolution is as blurred as a disc of 2.5 px."""

LEAST_SMOOTH_PX = 2.1
"""Half resolution, read bilinearly at full, is as blurred as a disc of 1.9 px."""


class _Offsets(NamedTuple):
    offsets: bytes


class _Walk(NamedTuple):
    offsets: bytes
    tap_count: int


class TapsKernel:
    """Gathers a few taps from a disc, the same ones everywhere (``taps_*.frag``).

    Notes
    -----
    Tiles where nothing is blurred are copied. Where all is about alike, taps are bilinear reads of
    texels so wide that the reads cover the disc: half of them where it is small, at half resolution
    where it is wide. Only tiles in which surfaces mix look at the depth of each tap, as the rings
    of `VrcomfortKernel` do.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        defocus: Defocus,
        taps: int,
    ) -> None:
        self._ctx, self._points, self._taps = ctx, defocus.points, taps
        self._few = max(LEAST_TAPS, ceil(self._taps / 2))
        self._tile_px = defocus.tile_px
        self._wide_px = max(LEAST_WIDE_PX, _covered_px(self._taps, 1, 1.0))
        halves = _halve(ctx, defocus.points)
        reach = self._reach_pass(defocus)
        self._reach = reach.target
        self.target = gl.color_texture(ctx, defocus.size_px)
        self._before = [reach, halves, self._tiles("taps_copy.frag", "COPIED", {"colour": colour})]
        self._blurs = [
            self._alike("FEW", defocus.points, 1, self.target, self._few),
            self._alike("FINE", defocus.points, 1, self.target),
            self._alike("SMOOTH", halves.target, 2, self.target),
            self._mixed(colour, halves.target),
        ]
        self._after: list[FullscreenPass] = []
        if defocus.limit_px > self._wide_px:
            self._add_wide(halves.target, widest=defocus.limit_px > _covered_px(self._taps, 2, 1.0))

    def _add_wide(self, halves: moderngl.Texture, *, widest: bool) -> None:
        """Draw wide discs at half resolution and enlarge them; `widest`: some read a quarter."""
        wide = gl.color_texture(self._ctx, halves.size)
        self._blurs.append(self._alike("WIDE", halves, 2, wide))
        if widest:
            quarters = _halve(self._ctx, halves)
            self._before.append(quarters)
            self._blurs.append(self._alike("WIDEST", quarters.target, 4, wide))
        self._after.append(
            self._tiles("taps_wide.frag", "WIDE | WIDEST", {"wide": wide}, filtered={"wide"})
        )

    def _reach_pass(self, defocus: Defocus) -> FullscreenPass:
        return FullscreenPass(
            self._ctx,
            "tap_reach.frag",
            size_px=defocus.tiles.size,
            inputs={"tiles": defocus.tiles},
            defines={
                **reach_defines(defocus.limit_px, self._tile_px),
                "WIDE_PX": self._wide_px,
                "WIDEST_PX": _covered_px(self._taps, 2, 1.0),
                "SMOOTH_PX": max(LEAST_SMOOTH_PX, _covered_px(self._taps, 1, 0.8)),
                "FEW_PX": _covered_px(self._few, 1, 0.7),
            },
        )

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        for each in self._before:
            each.render()
        for blur in self._blurs:
            blur.render(Aspect(pixel_aspect))
        for each in self._after:
            each.render()

    def _alike(
        self,
        kinds: str,
        level: moderngl.Texture,
        texel: int,
        target: moderngl.Texture,
        taps: int | None = None,
    ) -> FullscreenPass:
        """Return the pass over tiles of one surface that reads texels of this width (px)."""
        shown = 1 if target is self.target else 2
        return self._tiles(
            "taps_alike.frag",
            kinds,
            {"points": self._points, "level": level},
            filtered={"level"},
            target=target,
            constants=_Offsets(_offsets(taps or self._taps)),
            defines={
                "TAPS": taps or self._taps,
                "SHOWN": f"{shown}.0",
                "LEVEL": f"{texel}.0",
                "READ_PX2": coc.read_variance_px2(texel, shown) * 4,
                **({"RIM": 1} if shown > 1 else {}),
            },
        )

    def _mixed(self, colour: moderngl.Texture, halves: moderngl.Texture) -> FullscreenPass:
        return self._tiles(
            "taps_mixed.frag",
            "MIXED",
            {"points": self._points, "colour": colour, "halves": halves},
            constants=_Walk(_offsets(self._taps), self._taps),
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
        point_px = self._tile_px if target in {None, self.target} else self._tile_px // 2
        common: dict[str, Any] = {
            "KINDS": kinds,
            "TILE": self._tile_px,
            "TAPS": self._taps,
            "POINT_PX": point_px,
        }
        return FullscreenPass(
            self._ctx,
            fragment,
            size_px=self.target.size,
            inputs={"reach": self._reach, **inputs},
            defines={**common, **(defines or {})},
            vertex="tap_tiles.vert",
            tiles=self._reach.size,
            target=target or self.target,
            **options,
        )


def _covered_px(taps: int, texel: int, share: float) -> float:
    """Return the radius of the disc of which so many reads of texels of this width make a share."""
    return share * texel * sqrt(READ_AREA * taps / pi)


def _offsets(taps: int) -> bytes:
    return coc.tap_offsets(taps).astype(np.float32).tobytes()


def _halve(ctx: moderngl.Context, source: moderngl.Texture) -> FullscreenPass:
    width, height = source.size
    return FullscreenPass(
        ctx,
        "defocus_halve.frag",
        size_px=(ceil(width / 2), ceil(height / 2)),
        inputs={"points": source},
    )
