"""Our kernel: tiles say what may reach a pixel; fronts spread, sharp fronts do not leak."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.optics import fronts
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass
from vrcomfort.render.kernels.base import Aspect
from vrcomfort.render.kernels.tiles import TILE_PX, tile_passes

_LAYERS: tuple[dict[str, int], ...] = ({}, {"FRONT": 1})
"""Wide blur behind each pixel, and in front of it."""


class _Directions(NamedTuple):
    directions: bytes


class VrcomfortKernel:
    """Tile-classified gather with a back and a front layer (``depth_of_field.frag``).

    Every pixel of a disc is looked at up to a radius that grows with the `rings`
    (:func:`fronts.small_px`). The widest discs come from half resolution, in 32-bit floats, so that
    a constant image is rounded once.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        defocus: Defocus,
        settings: DepthOfField,
    ) -> None:
        width, height = defocus.size_px
        small_px = fronts.small_px(settings.rings)
        self._summaries = tile_passes(ctx, defocus, small_px=small_px)
        self._half = FullscreenPass(
            ctx,
            "defocus_half.frag",
            size_px=(ceil(width / 2), ceil(height / 2)),
            inputs={"points": defocus.points},
            dtype="f4",
        )
        reach = self._summaries[-1].target
        directions = _Directions(coc.ring_directions(settings.rings).astype(np.float32).tobytes())
        defines: dict[str, int | float] = {
            "RINGS": settings.rings,
            "TILE": TILE_PX,
            "SMALL_PX": small_px,
        }
        self._wide = tuple(
            FullscreenPass(
                ctx,
                "defocus_wide.frag",
                size_px=self._half.target.size,
                inputs={
                    "points": defocus.points,
                    "points_half": self._half.target,
                    "reach": reach,
                },
                filtered=() if layer else {"points_half"},
                constants=directions,
                defines={**defines, **layer},
                dtype="f4",
            )
            for layer in _LAYERS
        )
        wide_back, wide_front = (layer.target for layer in self._wide)
        self._gather = FullscreenPass(
            ctx,
            "depth_of_field.frag",
            size_px=defocus.size_px,
            inputs={
                "colour": colour,
                "points": defocus.points,
                "wide_back": wide_back,
                "wide_front": wide_front,
                "reach": reach,
            },
            constants=directions,
            defines=defines,
        )
        self.target = self._gather.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        for summary in self._summaries:
            summary.render()
        self._half.render()
        for layer in (*self._wide, self._gather):
            layer.render(Aspect(pixel_aspect))
