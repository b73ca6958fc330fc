"""Our kernel with few taps: each tile of the image by the cheapest program that is right for it."""

from __future__ import annotations

from math import ceil, pi, sqrt
from typing import Any, NamedTuple

import moderngl
import numpy as np

from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.render import gl
from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass, Together
from vrcomfort.render.kernels.base import Aspect
from vrcomfort.render.kernels.tiles import reach_defines, reach_tiles

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


class _Level(NamedTuple):
    """An image, or half or a quarter of it, whose texels are so many pixels wide."""

    texture: moderngl.Texture
    texel_px: int


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
        self._ctx, self._defocus, self._taps = ctx, defocus, taps
        self._few = max(LEAST_TAPS, ceil(self._taps / 2))
        self._wide_px = max(LEAST_WIDE_PX, _covered_px(self._taps, 1, 1.0))
        self._reach = self._reach_pass()
        image, blurred, half = _Level(colour, 1), self._level(1), self._level(2)
        self.target = blurred.texture
        points = self._level(1)
        self._points = defocus.make_points(**self._on_tiles("MIXED", points, around=True))
        self._before = [
            self._tiles("taps_copy.frag", "COPIED", {"colour": colour}, blurred),
            self._shrink(image, half, "SMOOTH | WIDE | WIDEST"),
            self._halve_mixed(points, half),
        ]
        self._alikes = [
            self._alike("FEW", image, blurred, self._few),
            self._alike("FINE", image, blurred),
            self._alike("SMOOTH", half, blurred),
        ]
        self._mixed = self._mixed_pass(image, points, half, blurred)
        self._after: list[FullscreenPass] = []
        if defocus.limit_px > self._wide_px:
            self._add_wide(half, blurred, widest=defocus.limit_px > _covered_px(self._taps, 2, 1.0))

    def _add_wide(self, half: _Level, blurred: _Level, *, widest: bool) -> None:
        """Draw wide discs at half resolution and enlarge them; `widest`: some read a quarter."""
        wide = self._level(2)
        self._alikes.append(self._alike("WIDE", half, wide))
        if widest:
            quarter = self._level(4)
            self._before.append(self._shrink(half, quarter, "WIDEST"))
            self._alikes.append(self._alike("WIDEST", quarter, wide))
        inputs = {"wide": wide.texture}
        self._after.append(
            self._tiles("taps_wide.frag", "WIDE | WIDEST", inputs, blurred, filtered={"wide"})
        )

    def render(self, pixel_aspect: float) -> None:
        """Blur the image of the last eye."""
        aspect, eye = Aspect(pixel_aspect), self._defocus.now
        self._reach.render()
        self._points.render(eye)
        for each in self._before:
            each.render()
        for alike in self._alikes:
            alike.render(Together(eye, aspect))
        self._mixed.render(aspect)
        for each in self._after:
            each.render()

    def _reach_pass(self) -> FullscreenPass:
        tiles = self._defocus.tiles
        return FullscreenPass(
            self._ctx,
            "tap_reach.frag",
            size_px=tiles.size,
            inputs={"tiles": tiles},
            defines={
                **reach_defines(self._defocus.limit_px, self._defocus.tile_px),
                "WIDE_PX": self._wide_px,
                "WIDEST_PX": _covered_px(self._taps, 2, 1.0),
                "SMOOTH_PX": max(LEAST_SMOOTH_PX, _covered_px(self._taps, 1, 0.8)),
                "FEW_PX": _covered_px(self._few, 1, 0.7),
            },
        )

    def _level(self, texel_px: int) -> _Level:
        width, height = self._defocus.size_px
        size = ceil(width / texel_px), ceil(height / texel_px)
        return _Level(gl.color_texture(self._ctx, size), texel_px)

    def _shrink(self, source: _Level, target: _Level, kinds: str) -> FullscreenPass:
        """Return the pass that halves what tiles of one surface read."""
        level = {"level": source.texture}
        return self._tiles(
            "taps_shrink.frag", kinds, level, target, around=True, filtered={"level"}
        )

    def _halve_mixed(self, points: _Level, target: _Level) -> FullscreenPass:
        """Return the pass that halves points without mixing surfaces."""
        inputs = {"points": points.texture}
        return self._tiles("defocus_halve.frag", "MIXED", inputs, target, around=True)

    def _alike(
        self, kinds: str, level: _Level, target: _Level, taps: int | None = None
    ) -> FullscreenPass:
        """Return the pass over tiles of one surface."""
        shown = target.texel_px
        on_tiles = self._on_tiles(kinds, target, around=shown > 1)
        on_tiles["inputs"]["level"] = level.texture
        on_tiles["defines"] |= {
            "TAPS": taps or self._taps,
            "SHOWN": f"{shown}.0",
            "LEVEL": f"{level.texel_px}.0",
            "READ_PX2": coc.read_variance_px2(level.texel_px, shown) * 4,
        }
        constants = _Offsets(_offsets(taps or self._taps))
        return self._defocus.radii.make_pass(
            self._ctx, "taps_alike.frag", filtered={"level"}, constants=constants, **on_tiles
        )

    def _mixed_pass(
        self, image: _Level, points: _Level, half: _Level, target: _Level
    ) -> FullscreenPass:
        walk = _Walk(_offsets(self._taps), self._taps)
        inputs = {"points": points.texture, "colour": image.texture, "halves": half.texture}
        return self._tiles("taps_mixed.frag", "MIXED", inputs, target, constants=walk)

    def _tiles(
        self,
        fragment: str,
        kinds: str,
        inputs: dict[str, moderngl.Texture],
        target: _Level,
        *,
        around: bool = False,
        **options: Any,
    ) -> FullscreenPass:
        """Return a pass over the tiles of some kinds."""
        on_tiles = self._on_tiles(kinds, target, around=around)
        on_tiles["inputs"] |= inputs
        return FullscreenPass(self._ctx, fragment, **on_tiles, **options)

    def _on_tiles(self, kinds: str, target: _Level, *, around: bool) -> dict[str, Any]:
        """Return the options of a pass over tiles; `around`: also over those that they read."""
        tile_px = self._defocus.tile_px
        reach = self._reach.target
        return {
            "size_px": target.texture.size,
            "inputs": {"reach": reach},
            "vertex": "tap_tiles.vert",
            "tiles": reach.size,
            "target": target.texture,
            "defines": {
                "KINDS": kinds,
                "AROUND": reach_tiles(self._defocus.limit_px, tile_px) if around else 0,
                "TILE": tile_px,
                "TAPS": self._taps,
                "POINT_PX": tile_px // target.texel_px,
            },
        }


def _covered_px(taps: int, texel: int, share: float) -> float:
    """Return the radius of the disc of which so many reads of texels of this width make a share."""
    return share * texel * sqrt(READ_AREA * taps / pi)


def _offsets(taps: int) -> bytes:
    return coc.tap_offsets(taps).astype(np.float32).tobytes()
