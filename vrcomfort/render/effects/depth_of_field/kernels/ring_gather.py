"""Our kernel: tiles say what may reach a pixel; fronts spread, sharp fronts do not leak."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, NamedTuple

import moderngl
import numpy as np

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics.circle_of_confusion import ring_directions
from vrcomfort.optics.gather_resolution import coarser_above_px, small_px
from vrcomfort.optics.tile_classes import RingTile
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels import coarse_layers
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.ring_tiles import RingTiles
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import (
    Level,
    TilePasses,
    make_level,
)


class _Directions(NamedTuple):
    directions: bytes


class RingGatherKernel:
    """Tile-classified gather with a background and a foreground layer (``gather_composite.frag``).

    Every pixel of a disc is looked at up to a radius that grows with the `rings`
    (:func:`gather_resolution.small_px`). Wider discs come from half resolution and, where
    their samples would lie far apart, from less (`CoarseLayers`), in 32-bit floats, so that a
    constant image is rounded once. Each tile is drawn by a program of its class; where nothing is
    blurred it is copied, and where nothing is blurred around it no radius is found either.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        coc: CocPasses,
        settings: DepthOfField,
    ) -> None:
        small = small_px(settings.rings)
        self._ctx, self._coc, self._rings = ctx, coc, settings.rings
        around_px = coarse_layers.read_around_px(coc.limit_px, settings.rings)
        self._classes = RingTiles(ctx, coc, small_px=small, read_around_px=around_px)
        self._tiles = TilePasses(ctx, coc, self._classes.classes)
        self._directions = _Directions(ring_directions(settings.rings).astype(np.float32).tobytes())
        self._defines: dict[str, Any] = {"RINGS": settings.rings, "SMALL_PX": small}
        blurred, points = self._level(1), self._level(1)
        self.target = blurred.texture
        image = {"colour": colour}
        self._colour_and_coc = self._tiles.make_pass(
            "depth_of_field/colour_and_coc.frag", RingTile.COLOUR_AND_COC, image, points, lens=True
        )
        self._before = [
            self._tiles.make_pass("depth_of_field/copy_tiles.frag", RingTile.SHARP, image, blurred)
        ]
        seen = {**image, "colour_and_coc": points.texture}
        all_around = {**seen, "dilated": self._classes.dilated}
        self._blurs = [
            self._gather(RingTile.ALIKE, seen, blurred, {"ONE_SURFACE": 1}),
            self._gather(RingTile.SMALL, all_around, blurred, {}),
        ]
        self._after: list[FullscreenPass] = []
        self._coarse: coarse_layers.CoarseLayers | None = None
        if coc.limit_px > small:
            self._add_wide(all_around, blurred)

    def render(self, pixel_aspect: float) -> None:
        """Blur the image of the last eye."""
        self._classes.render(pixel_aspect)
        self._colour_and_coc.render(self._coc.now)
        for each in self._before:
            each.render()
        if self._coarse is not None:
            self._coarse.render(pixel_aspect)
        for blur in self._blurs:
            blur.render(Aspect(pixel_aspect))
        for each in self._after:
            each.render()

    def _level(self, texel_px: int, dtype: str = "f2") -> Level:
        return make_level(self._ctx, self._coc, texel_px, dtype)

    def _gather(
        self,
        tile_class: RingTile,
        inputs: dict[str, moderngl.Texture],
        target: Level,
        defines: dict[str, float],
        **options: Any,
    ) -> FullscreenPass:
        """Return the pass over tiles of this class."""
        defines = {**self._defines, **defines}
        return self._tiles.make_pass(
            "depth_of_field/gather_composite.frag",
            tile_class,
            inputs,
            target,
            defines=defines,
            **options,
        )

    def _add_wide(self, all_around: dict[str, moderngl.Texture], blurred: Level) -> None:
        """Draw wide discs at half resolution, where there are any, and then what they reach."""
        half, background, foreground = (self._level(2, "f4") for _ in range(3))
        points = {"colour_and_coc": all_around["colour_and_coc"]}
        self._before.append(
            self._tiles.make_pass(
                "depth_of_field/coc_downsample_tent.frag", RingTile.HALF_RESOLUTION, points, half
            )
        )
        dilated = {"dilated": self._classes.dilated}
        self._coarse = coarse_layers.make_coarse_layers(
            self._ctx, self._coc, half, {**points, **dilated}, self._defines
        )
        inputs = {**points, **dilated, "half_resolution": half.texture}
        self._blurs += [
            self._wide(inputs, background, filtered={"half_resolution"}),
            self._wide(inputs, foreground, FOREGROUND=1),
        ]
        layers = {"wide_background": background.texture, "wide_foreground": foreground.texture}
        self._after.append(
            self._tiles.make_pass(
                "depth_of_field/upsample.frag",
                RingTile.WIDE,
                {"wide": background.texture},
                blurred,
                defines={"SHIFT_PX": 0.5},
                filtered={"wide"},
            )
        )
        self._blurs.append(
            self._gather(
                RingTile.LAYERED,
                {**all_around, **layers},
                blurred,
                {"WIDE_LAYERS": 1, "COARSE_PX": coarser_above_px(self._rings, half.texel_px)},
                constants=self._directions,
            )
        )

    def _wide(
        self,
        inputs: dict[str, moderngl.Texture],
        target: Level,
        *,
        filtered: Collection[str] = (),
        **defines: int,
    ) -> FullscreenPass:
        """Return the pass that draws one layer of wide blur."""
        foreground = "FOREGROUND" in defines
        wider, limit = coarse_layers.read_coarser(self._coarse, foreground=foreground)
        if self._coarse is not None:
            wider |= self._coarse.sources(foreground=foreground)
            limit["LEVEL"] = self._coarse.texel_px
        return self._tiles.make_pass(
            "depth_of_field/gather_half_resolution.frag",
            RingTile.LAYERS,
            {**inputs, **wider},
            target,
            filtered=filtered,
            constants=self._directions,
            defines={**self._defines, **defines, **limit},
        )
