"""Our kernel: tiles say what may reach a pixel; fronts spread, sharp fronts do not leak."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, NamedTuple

import moderngl
import numpy as np

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.optics.gather_resolution import coarser_above_px, small_px
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.circle_of_confusion import Defocus
from vrcomfort.render.effects.depth_of_field.kernels import far_layers as far
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import (
    Level,
    TilePasses,
    make_level,
)
from vrcomfort.render.effects.depth_of_field.kernels.tiles import TileKinds


class _Directions(NamedTuple):
    directions: bytes


class VrcomfortKernel:
    """Tile-classified gather with a back and a front layer (``depth_of_field.frag``).

    Every pixel of a disc is looked at up to a radius that grows with the `rings`
    (:func:`gather_resolution.small_px`). Wider discs come from half resolution
    and, where their samples would lie far apart, from less (`FarLayers`), in 32-bit floats, so that
    a constant image is rounded once. Each tile is drawn by a program of its kind; where nothing is
    blurred it is copied, and where nothing is blurred around it there are no points either.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        defocus: Defocus,
        settings: DepthOfField,
    ) -> None:
        small = small_px(settings.rings)
        self._ctx, self._defocus, self._rings = ctx, defocus, settings.rings
        around_px = far.read_around_px(defocus.limit_px, settings.rings)
        self._kinds = TileKinds(ctx, defocus, small_px=small, read_around_px=around_px)
        self._tiles = TilePasses(ctx, defocus, self._kinds.kinds)
        self._directions = _Directions(
            coc.ring_directions(settings.rings).astype(np.float32).tobytes()
        )
        self._defines: dict[str, Any] = {"RINGS": settings.rings, "SMALL_PX": small}
        blurred, points = self._level(1), self._level(1)
        self.target = blurred.texture
        image = {"colour": colour}
        self._points = self._tiles.make_pass(
            "depth_of_field/defocus.frag", "POINTS", image, points, lens=True
        )
        self._before = [
            self._tiles.make_pass("depth_of_field/taps_copy.frag", "COPIED", image, blurred)
        ]
        seen = {**image, "points": points.texture}
        all_around = {**seen, "reach": self._kinds.reach}
        self._blurs = [
            self._gather("ALIKE", seen, blurred, {"ONE_SURFACE": 1}),
            self._gather("SMALL", all_around, blurred, {}),
        ]
        self._after: list[FullscreenPass] = []
        self._far: far.FarLayers | None = None
        if defocus.limit_px > small:
            self._add_wide(all_around, blurred)

    def render(self, pixel_aspect: float) -> None:
        """Blur the image of the last eye."""
        self._kinds.render(pixel_aspect)
        self._points.render(self._defocus.now)
        for each in self._before:
            each.render()
        if self._far is not None:
            self._far.render(pixel_aspect)
        for blur in self._blurs:
            blur.render(Aspect(pixel_aspect))
        for each in self._after:
            each.render()

    def _level(self, texel_px: int, dtype: str = "f2") -> Level:
        return make_level(self._ctx, self._defocus, texel_px, dtype)

    def _gather(
        self,
        kind: str,
        inputs: dict[str, moderngl.Texture],
        target: Level,
        defines: dict[str, float],
        **options: Any,
    ) -> FullscreenPass:
        """Return the pass over tiles of this kind."""
        defines = {**self._defines, **defines}
        return self._tiles.make_pass(
            "depth_of_field/depth_of_field.frag", kind, inputs, target, defines=defines, **options
        )

    def _add_wide(self, all_around: dict[str, moderngl.Texture], blurred: Level) -> None:
        """Draw wide discs at half resolution, where there are any, and then what they reach."""
        half, back, front = (self._level(2, "f4") for _ in range(3))
        points = {"points": all_around["points"]}
        self._before.append(
            self._tiles.make_pass("depth_of_field/defocus_half.frag", "HALVES", points, half)
        )
        reach = {"reach": self._kinds.reach}
        self._far = far.far_layers(
            self._ctx, self._defocus, half, {**points, **reach}, self._defines
        )
        inputs = {**points, **reach, "points_half": half.texture}
        self._blurs += [
            self._wide(inputs, back, filtered={"points_half"}),
            self._wide(inputs, front, FRONT=1),
        ]
        layers = {"wide_back": back.texture, "wide_front": front.texture}
        self._after.append(
            self._tiles.make_pass(
                "depth_of_field/enlarge.frag",
                "WIDE",
                {"wide": back.texture},
                blurred,
                defines={"SHIFT_PX": 0.5},
                filtered={"wide"},
            )
        )
        self._blurs.append(
            self._gather(
                "LAYERED",
                {**all_around, **layers},
                blurred,
                {"WIDE_LAYERS": 1, "FAR_PX": coarser_above_px(self._rings, half.texel_px)},
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
        front = "FRONT" in defines
        wider, limit = far.read_wider(self._far, front=front)
        if self._far is not None:
            wider |= self._far.points(front=front)
            limit["LEVEL"] = self._far.texel_px
        return self._tiles.make_pass(
            "depth_of_field/defocus_wide.frag",
            "LAYERS",
            {**inputs, **wider},
            target,
            filtered=filtered,
            constants=self._directions,
            defines={**self._defines, **defines, **limit},
        )
