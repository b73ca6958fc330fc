"""Our kernel: every texel of a disc, on the level on which there are not too many."""

from __future__ import annotations

from math import ceil
from typing import Any

import moderngl
import numpy as np

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect

HALF_WIDER = 1.5
"""At half resolution a disc is summed up to so many times the radius, in texels: there are a quarter of the
pixels."""


class LayeredGatherKernel:
    """Draws the graph of docs/depth_of_field.md."""

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,  # noqa: ARG002 - the points hold it too
        coc: CocPasses,
        settings: DepthOfField,
    ) -> None:
        self._ctx, self._coc = ctx, coc
        self._defines = coc.level_defines
        self._dilate = self._pass(
            "coc_tile_dilate.frag",
            {"tiles": coc.tile_min_max},
            size_px=coc.tile_min_max.size,
            defines={**self._defines, "TILE": coc.tile_px, "LIMIT_PX": float(coc.limit_px)},
        )
        points = {"colour_and_coc": coc.colour_and_coc}
        dilated = {"dilated": self._dilate.target}
        self._layers = self._make_layers()
        self._half: FullscreenPass | None = None
        wide: dict[str, moderngl.Texture] = {}
        if self._layers:
            self._half, self._gather = self._make_wide(points)
            wide = {"gathered": self._gather.target}
            wide |= {f"layers_{i}": each.target for i, each in enumerate(self._layers, 1)}
        self._composite = self._pass(
            "composite.frag",
            {**points, **dilated, **wide},
            size_px=coc.size_px,
            filtered={"colour_and_coc", "gathered"},
            defines={**self._defines, "TILE": coc.tile_px},
        )
        self.target = self._composite.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the image of the last eye."""
        aspect = Aspect(pixel_aspect)
        self._dilate.render(aspect)
        if self._half is not None:
            for layer in self._layers:
                layer.render()
            self._half.render()
            if self._mips:
                self._half.target.build_mipmaps(0, self._mips)
            self._gather.render(aspect)
        self._composite.render(aspect)

    def _make_layers(self) -> list[FullscreenPass]:
        found: list[FullscreenPass] = []
        for level in range(1, self._defines["LEVELS"]):
            finer = found[-1].target if found else self._coc.colour_and_coc
            drawn = self._pass(
                "layers.frag",
                {"finer": finer},
                size_px=self._size(level),
                dtype="u4",
                defines={"FROM_LAYERS": 1} if found else {},
            )
            found.append(drawn)
        return found

    def _make_wide(
        self, points: dict[str, moderngl.Texture]
    ) -> tuple[FullscreenPass, FullscreenPass]:
        half = self._pass(
            "downsample.frag", points, size_px=self._size(1), filtered={"colour_and_coc"}
        )
        widest = HALF_WIDER * self._defines["EXACT_PX"]
        self._mips = max(ceil(np.log2(self._coc.limit_px / 2 / widest)), 0)
        if self._mips:
            half.target.build_mipmaps(0, self._mips)
        gather = self._pass(
            "gather.frag",
            {"half_resolution": half.target},
            size_px=self._size(1),
            **({"mipmapped": {"half_resolution"}} if self._mips else {}),
            defines={**self._defines, "HALF_EXACT": widest, "LODS": self._mips + 1},
        )
        return half, gather

    def _size(self, level: int) -> tuple[int, int]:
        width, height = self._coc.size_px
        return ceil(width / 2**level), ceil(height / 2**level)

    def _pass(
        self, fragment: str, inputs: dict[str, moderngl.Texture], **options: Any
    ) -> FullscreenPass:
        return FullscreenPass(self._ctx, f"depth_of_field/{fragment}", inputs=inputs, **options)
