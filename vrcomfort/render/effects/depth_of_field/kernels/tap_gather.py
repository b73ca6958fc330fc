"""Our kernel with few taps: each tile of the image by the cheapest program that is right for it."""

from __future__ import annotations

from math import pi, sqrt
from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.gpu.fullscreen_pass import FullscreenPass, Together
from vrcomfort.optics import disc_footprint
from vrcomfort.optics import taps as pattern
from vrcomfort.optics.tile_classes import TapBounds, TapTile
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.tap_tiles import AROUND, OWN, TapTiles
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import (
    Level,
    TilePasses,
    make_level,
)

LEAST_TAPS = 6
"""Fewer are farther from a small disc than a cross-fade of two reads is."""

LEAST_MIXED_TAPS = 8
"""Fewer do not tell surfaces apart well."""

READ_AREA = 3.0
"""A bilinear read of half the image stands for so many texels: where there are more for each, reads
of a quarter show small lights better."""

FADED_READ_AREA = 4.0
"""With less than `LEAST_TAPS`; there, half of the image shows more than a quarter up to here."""

SLIGHT_PX = 2.0
"""In tiles with no wider disc a cross-fade does not tell surfaces apart."""

FADED_PX = 2.8
"""Widest disc that a cross-fade stands for; it ends at 2 px."""

LEAST_WIDE_PX = 2.2
"""What is drawn at half resolution is as blurred as a disc of 2 px."""

NEVER_PX = 1e9
"""No disc is so wide: where two reads must do, half of the points is not worth its passes."""

SPARSE_PX = 2.0
"""Taps among several surfaces read half resolution where they are farther apart."""


TEXELS = 3
"""So many texels, besides the disc's own, cost as much as a bilinear read."""


class _Offsets(NamedTuple):
    offsets: bytes


class _Walk(NamedTuple):
    offsets: bytes
    tap_count: int


class _Footprint(NamedTuple):
    pairs: bytes
    pair_count: int


class Step(NamedTuple):
    """A pass, and what it is to know: the lens of the eye, how a disc lies in the image."""

    drawn: FullscreenPass
    lens: bool = False
    disc: bool = False


class TapGatherKernel:
    """Gathers a few taps from a disc, the same ones everywhere (``taps_*.frag``).

    Notes
    -----
    Tiles where nothing is blurred are copied. Where all is about alike, a small disc is the mean of
    its texels, up to `TEXELS` times the taps; one that has more takes reads of 2 × 2 texels each
    (`optics.disc_footprint`). A wide one is twice as many reads at half resolution, which is a
    quarter of the pixels (`optics.taps`). Only tiles in which surfaces mix look at
    the depth of each tap, as the rings of `RingGatherKernel` do. With less than `LEAST_TAPS`, a
    small disc is a cross-fade of the image and half of it, in which surfaces whose discs are at
    most `SLIGHT_PX` are not told apart, and a wide one has three times as many taps.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        coc: CocPasses,
        taps: int,
    ) -> None:
        self._ctx, self._coc = ctx, coc
        self._fades = taps < LEAST_TAPS
        self._wide_taps = (3 if self._fades else 2) * taps
        self._mixed_taps = max(taps, LEAST_MIXED_TAPS)
        # Of reads a texel and two texels wide; a cross-fade has neither.
        texels = {1: TEXELS * taps + 1, 2: taps}
        self._footprints = (
            {} if self._fades else {w: disc_footprint.footprint(n, w) for w, n in texels.items()}
        )
        bounds = self._bounds()
        self._classes = TapTiles(ctx, coc, bounds)
        self._tiles = TilePasses(ctx, coc, self._classes.classes)
        image, blurred, points = Level(colour, 1), self._level(1), self._level(1)
        self.target = blurred.texture
        self._steps = [Step(self._points_pass(image, points), lens=True)]
        if not self._fades:
            self._steps += self._small(image, blurred)
        if self._fades or coc.limit_px > bounds.wide_px:
            self._steps += self._halved(image, blurred, bounds)
        self._steps.append(self._mixed(TapTile.MIXED, {"colour_and_coc": points.texture}, blurred))
        if coc.limit_px > bounds.apart_px:
            self._steps += self._apart(points, blurred)

    def render(self, pixel_aspect: float) -> None:
        """Blur the image of the last eye."""
        aspect, eye = (Aspect(pixel_aspect),), (self._coc.now,)
        self._classes.render(pixel_aspect)
        for drawn, lens, disc in self._steps:
            drawn.render(Together(*(eye if lens else ()), *(aspect if disc else ())))

    def _bounds(self) -> TapBounds:
        read_area = FADED_READ_AREA if self._fades else READ_AREA
        widest_px = 2 * sqrt(read_area * self._wide_taps / pi)
        if self._fades:
            return TapBounds(
                SLIGHT_PX, FADED_PX, LEAST_WIDE_PX, widest_px, NEVER_PX, fine_reads=False
            )
        apart_px = SPARSE_PX * sqrt(self._mixed_taps / pi)
        few_px, fine_px = (self._footprints[width].widest_px for width in (1, 2))
        wide_px = max(few_px, fine_px, LEAST_WIDE_PX)
        return TapBounds(0.5, few_px, wide_px, widest_px, apart_px, fine_reads=True)

    def _points_pass(self, image: Level, target: Level) -> FullscreenPass:
        inputs = {"colour": image.texture}
        return self._tiles.make_pass(
            "depth_of_field/colour_and_coc.frag",
            TapTile.MIXED | TapTile.APART,
            inputs,
            target,
            channel=AROUND,
            lens=True,
        )

    def _fade(self, image: Level, half: Level, target: Level) -> list[Step]:
        """Return how two reads stand for discs that are small, or no discs at all."""
        inputs = {"colour": image.texture, "half_resolution": half.texture}
        fade = self._tiles.make_pass(
            "depth_of_field/crossfade_half_resolution.frag",
            TapTile.SHARP | TapTile.FEW,
            inputs,
            target,
            channel=OWN,
            filtered={"half_resolution"},
        )
        return [self._shrink_with_radii(image, half), Step(fade, disc=True)]

    def _small(self, image: Level, target: Level) -> list[Step]:
        """Return how tiles of one surface with small discs, or none, are drawn."""
        inputs = {"colour": image.texture}
        copy = self._tiles.make_pass(
            "depth_of_field/copy_tiles.frag", TapTile.SHARP, inputs, target, channel=OWN
        )
        few, fine = (
            self._footprint(TapTile.FEW, image, target, 1),
            self._footprint(TapTile.FINE, image, target, 2),
        )
        return [Step(copy), few, fine]

    def _halved(self, image: Level, target: Level, bounds: TapBounds) -> list[Step]:
        """Return how all is drawn that reads half of the image."""
        half, limit_px = self._level(2), self._coc.limit_px
        steps = self._fade(image, half, target) if self._fades else [self._shrink(image, half)]
        if limit_px > bounds.wide_px:
            steps += self._wide(half, target, widest=limit_px > bounds.widest_px)
        return steps

    def _apart(self, points: Level, target: Level) -> list[Step]:
        """Return how half of the points is read where taps among several surfaces are far apart."""
        half = self._level(2)  # not the mean of pixels that `_wide` reads
        inputs = {"colour_and_coc": points.texture}
        halve = self._tiles.make_pass(
            "depth_of_field/coc_downsample_box.frag", TapTile.APART, inputs, half, channel=AROUND
        )
        inputs = {**inputs, "half_resolution": half.texture}
        return [
            Step(halve),
            self._mixed(TapTile.APART, inputs, target, READ_HALF_RESOLUTION=1, SPARSE_PX=SPARSE_PX),
        ]

    def _wide(self, half: Level, target: Level, *, widest: bool) -> list[Step]:
        """Return how wide discs are drawn at half resolution; `widest`: some read a quarter."""
        wide = self._level(2)
        steps = [self._alike(TapTile.WIDE, half, wide, self._wide_taps)]
        if widest:
            quarter = self._level(4)
            steps.append(self._shrink(half, quarter))
            steps.append(self._alike(TapTile.WIDEST, quarter, wide, self._wide_taps))
        inputs, classes = {"wide": wide.texture}, TapTile.WIDE | TapTile.WIDEST
        enlarge = self._tiles.make_pass(
            "depth_of_field/upsample.frag",
            classes,
            inputs,
            target,
            channel=OWN,
            defines={"SHIFT_PX": 0.0},
            filtered=inputs,
        )
        return [*steps, Step(enlarge)]

    def _level(self, texel_px: int) -> Level:
        return make_level(self._ctx, self._coc, texel_px)

    def _shrink(self, source: Level, target: Level) -> Step:
        """Return how an image is halved: all of it, as no tile says what is read around it."""
        size, texture = target.texture.size, target.texture
        inputs = {"level": source.texture}
        drawn = FullscreenPass(
            self._ctx,
            "depth_of_field/downsample.frag",
            size_px=size,
            inputs=inputs,
            target=texture,
            filtered=inputs,
        )
        return Step(drawn)

    def _shrink_with_radii(self, source: Level, target: Level) -> Step:
        drawn = self._coc.depth_to_coc.make_pass(
            self._ctx,
            "depth_of_field/downsample.frag",
            size_px=target.texture.size,
            inputs={"level": source.texture},
            target=target.texture,
            filtered={"level", "depth"},
            defines={"RADII": 1},
        )
        return Step(drawn, lens=True)

    def _footprint(self, tile_class: TapTile, image: Level, target: Level, width_px: int) -> Step:
        """Return how small discs are drawn: by reads of squares of so many pixels."""
        pairs, widest_px = self._footprints[width_px]
        drawn = self._tiles.make_pass(
            "depth_of_field/disc_footprint.frag",
            tile_class,
            {"colour": image.texture},
            target,
            channel=OWN,
            lens=True,
            constants=_Footprint(pairs.astype(np.float32).tobytes(), len(pairs)),
            defines={
                **({"BLOCKS": 1} if width_px > 1 else {}),
                "PAIRS": len(pairs),
                "WIDTH_PX": f"{width_px}.0",
                "WIDEST_PX": widest_px,
                "NARROWER_PX": disc_footprint.NARROWER_PX,
            },
            filtered={"colour"} if width_px > 1 else (),
        )
        return Step(drawn, lens=True, disc=True)

    def _alike(self, classes: TapTile, level: Level, target: Level, taps: int) -> Step:
        """Return how tiles of one surface are drawn."""
        texel, shown = level.texel_px, target.texel_px
        spread = pattern.spread(taps, texel, shown)
        has_radii = self._fades and texel == shown
        drawn = self._tiles.make_pass(
            "depth_of_field/gather_taps.frag",
            classes,
            {"level": level.texture},
            target,
            channel=AROUND if shown > 1 else OWN,
            lens=not has_radii,
            constants=_Offsets(_offsets(taps)),
            defines={
                **({"RADII": 1} if has_radii else {}),
                "TAPS": taps,
                "SHOWN": f"{shown}.0",
                "LEVEL": f"{texel}.0",
                **{f"EXTENT_{name.upper()}": each for name, each in spread._asdict().items()},
            },
            filtered={"level"},
        )
        return Step(drawn, lens=not has_radii, disc=True)

    def _mixed(
        self,
        tile_class: TapTile,
        inputs: dict[str, moderngl.Texture],
        target: Level,
        **defines: float,
    ) -> Step:
        """Return how tiles are drawn in which surfaces mix."""
        taps = self._mixed_taps
        drawn = self._tiles.make_pass(
            "depth_of_field/gather_taps_layered.frag",
            tile_class,
            {"dilated": self._classes.classes, **inputs},
            target,
            channel=OWN,
            constants=_Walk(_offsets(taps), taps),
            defines={"TAPS": taps, **defines},
        )
        return Step(drawn, disc=True)


def _offsets(taps: int) -> bytes:
    return pattern.tap_offsets(taps).astype(np.float32).tobytes()
