"""Our kernel with few taps: each tile of the image by the cheapest program that is right for it."""

from __future__ import annotations

from math import ceil, pi, sqrt
from typing import Any, NamedTuple

import moderngl
import numpy as np

from vrcomfort.optics import taps as pattern
from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass, Together
from vrcomfort.render.kernels.base import Aspect
from vrcomfort.render.kernels.tap_tiles import AROUND, OWN, Bounds, TapTiles
from vrcomfort.render.kernels.tile_passes import Level, TilePasses, make_level

LEAST_TAPS = 6
"""Fewer are farther from a small disc than a cross-fade of two reads is."""

LEAST_MIXED_TAPS = 8
"""Fewer do not tell surfaces apart well."""

READ_AREA = 4.0
"""A bilinear read stands for so many texels."""

SLIGHT_PX = 1.5
"""In tiles with no wider disc a cross-fade does not tell surfaces apart."""

FADED_PX = 2.8
"""Widest disc that a cross-fade stands for; it ends at 2 px."""

LEAST_WIDE_PX = 2.2
"""What is drawn at half resolution is as blurred as a disc of 2 px."""


FAR_PX = 2.0
"""Taps among several surfaces read half of the points where they are farther apart."""


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
    texels so wide that the reads cover the disc: half of them where it is small; where it is wide,
    twice as many at half resolution, which is a quarter of the pixels. Only tiles in which surfaces
    mix look at the depth of each tap, as the rings of `VrcomfortKernel` do. With less than
    `LEAST_TAPS`, a small disc is a cross-fade of the image and half of it, in which surfaces whose
    discs are at most `SLIGHT_PX` are not told apart.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        defocus: Defocus,
        taps: int,
    ) -> None:
        self._ctx, self._defocus, self._taps = ctx, defocus, taps
        self._fades = taps < LEAST_TAPS
        self._wide_taps = (4 if self._fades else 2) * taps
        self._mixed_taps = max(taps, LEAST_MIXED_TAPS)
        bounds = self._bounds()
        self._kinds = TapTiles(ctx, defocus, bounds)
        self._tiles = TilePasses(ctx, defocus, self._kinds.kinds)
        image, half = Level(colour, 1), self._level(2)
        blurred, points = self._level(1), self._level(1)
        self.target = blurred.texture
        inputs = {"colour": colour}
        self._points = self._tiles.make_pass(
            "defocus.frag", "MIXED | APART", inputs, points, of=AROUND, lens=True
        )
        self._before = [
            self._tiles.make_pass("taps_copy.frag", "COPIED", inputs, blurred, of=OWN),
            self._shrink(image, half, None if self._fades else "WIDE | WIDEST"),
        ]
        self._alikes = self._small(image, half, blurred)
        self._mixed = [self._mixed_pass("MIXED", {"points": points.texture}, blurred)]
        if defocus.limit_px > bounds.apart_px:
            self._add_apart(points, half, blurred)
        self._after: list[FullscreenPass] = []
        if defocus.limit_px > bounds.wide_px:
            self._add_wide(half, blurred, widest=defocus.limit_px > bounds.widest_px)

    def _bounds(self) -> Bounds:
        widest_px = _covered_px(self._wide_taps, 2)
        apart_px = FAR_PX * sqrt(self._mixed_taps / pi)
        if self._fades:
            return Bounds(SLIGHT_PX, FADED_PX, LEAST_WIDE_PX, widest_px, apart_px, fine_reads=False)
        few_px, wide_px = 0.7 * _covered_px(self._few, 1), _covered_px(self._taps, 1)
        return Bounds(
            0.5, few_px, max(LEAST_WIDE_PX, wide_px), widest_px, apart_px, fine_reads=True
        )

    @property
    def _few(self) -> int:
        return max(LEAST_TAPS, ceil(self._taps / 2))

    def _small(self, image: Level, half: Level, blurred: Level) -> list[FullscreenPass]:
        """Return the passes over tiles of one surface with small discs."""
        if self._fades:
            return [self._fade_pass(image, half, blurred)]
        return [
            self._alike("FEW", image, blurred, self._few),
            self._alike("FINE", image, blurred, self._taps),
        ]

    def _add_apart(self, points: Level, half: Level, blurred: Level) -> None:
        """Read half of the points where taps among several surfaces are far apart."""
        inputs = {"points": points.texture}
        self._before.append(
            self._tiles.make_pass("defocus_halve.frag", "APART", inputs, half, of=AROUND)
        )
        inputs = {**inputs, "halves": half.texture}
        self._mixed.append(self._mixed_pass("APART", inputs, blurred, READ_HALVES=1, FAR_PX=FAR_PX))

    def _add_wide(self, half: Level, blurred: Level, *, widest: bool) -> None:
        """Draw wide discs at half resolution and enlarge them; `widest`: some read a quarter."""
        wide = self._level(2)
        self._alikes.append(self._alike("WIDE", half, wide, self._wide_taps))
        if widest:
            quarter = self._level(4)
            self._before.append(self._shrink(half, quarter, "WIDEST"))
            self._alikes.append(self._alike("WIDEST", quarter, wide, self._wide_taps))
        self._after.append(
            self._tiles.make_pass(
                "taps_wide.frag",
                "WIDE | WIDEST",
                {"wide": wide.texture},
                blurred,
                of=OWN,
                filtered={"wide"},
            )
        )

    def render(self, pixel_aspect: float) -> None:
        """Blur the image of the last eye."""
        aspect, eye = Aspect(pixel_aspect), self._defocus.now
        self._kinds.render()
        self._points.render(eye)
        for each in self._before:
            each.render()
        for alike in self._alikes:
            alike.render(Together(eye, aspect))
        for mixed in self._mixed:
            mixed.render(aspect)
        for each in self._after:
            each.render()

    def _level(self, texel_px: int) -> Level:
        return make_level(self._ctx, self._defocus, texel_px)

    def _shrink(self, source: Level, target: Level, kinds: str | None) -> FullscreenPass:
        """Return the pass that halves what tiles of one surface read, or (None) all."""
        options: dict[str, Any] = {"inputs": {"level": source.texture}, "filtered": {"level"}}
        if kinds is None:
            size, texture = target.texture.size, target.texture
            return FullscreenPass(
                self._ctx, "taps_shrink.frag", size_px=size, target=texture, **options
            )
        return self._tiles.make_pass("taps_shrink.frag", kinds, target=target, of=AROUND, **options)

    def _fade_pass(self, image: Level, half: Level, target: Level) -> FullscreenPass:
        inputs = {"colour": image.texture, "halves": half.texture}
        return self._tiles.make_pass(
            "taps_fade.frag", "FEW", inputs, target, of=OWN, lens=True, filtered={"halves"}
        )

    def _alike(self, kinds: str, level: Level, target: Level, taps: int) -> FullscreenPass:
        """Return the pass over tiles of one surface."""
        texel, shown = level.texel_px, target.texel_px
        spread = pattern.spread(taps, texel, shown)
        return self._tiles.make_pass(
            "taps_alike.frag",
            kinds,
            {"level": level.texture},
            target,
            of=AROUND if shown > 1 else OWN,
            lens=True,
            constants=_Offsets(_offsets(taps)),
            defines={
                "TAPS": taps,
                "SHOWN": f"{shown}.0",
                "LEVEL": f"{texel}.0",
                **{f"EXTENT_{name.upper()}": each for name, each in spread._asdict().items()},
            },
            filtered={"level"},
        )

    def _mixed_pass(
        self, kind: str, inputs: dict[str, moderngl.Texture], target: Level, **defines: float
    ) -> FullscreenPass:
        taps = self._mixed_taps
        return self._tiles.make_pass(
            "taps_mixed.frag",
            kind,
            {"reach": self._kinds.kinds, **inputs},
            target,
            of=OWN,
            constants=_Walk(_offsets(taps), taps),
            defines={"TAPS": taps, **defines},
        )


def _covered_px(taps: int, texel: int) -> float:
    """Return the radius of the disc that so many reads of texels of this width make up."""
    return texel * sqrt(READ_AREA * taps / pi)


def _offsets(taps: int) -> bytes:
    return pattern.tap_offsets(taps).astype(np.float32).tobytes()
