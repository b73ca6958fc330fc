"""Our kernel: every texel of a disc, on the level on which there are not too many."""

from __future__ import annotations

from math import ceil
from typing import Any

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import levels
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect


class LayeredGatherKernel:
    """Dilates tiles, halves the image, gathers wide discs, composites: docs/depth_of_field.md.

    Notes
    -----
    Where no disc can be wider than what is summed over pixels, there is only the composite.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,
    ) -> None:
        self._ctx, self._coc = ctx, coc
        self._defines = coc.level_defines
        self._points = {"colour_and_coc": coc.colour_and_coc}
        self._dilate = self._dilate_pass()
        self._layers = self._layer_passes()
        self._mips = levels.half_levels(coc.limit_px, settings.samples) - 1
        self._half, self._gather = None, None
        wide: dict[str, moderngl.Texture] = {}
        if self._layers:
            self._half = self._pass("downsample", self._points, level=1)
            self._gather = self._gather_pass(self._half.target, settings.samples)
            wide = {"gathered": self._gather.target}
            wide |= {f"layers_{i}": each.target for i, each in enumerate(self._layers, 1)}
        self._composite = self._pass(
            "composite",
            {**self._points, "dilated": self._dilate.target, **wide},
            filtered={"gathered"},
            defines={**self._defines, "TILE": coc.tile_px},
        )
        self.target = self._composite.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the image of the last eye."""
        aspect = Aspect(pixel_aspect)
        self._dilate.render(aspect)
        for layer in self._layers:
            layer.render()
        if self._half is not None and self._gather is not None:
            self._half.render()
            if self._mips:
                self._half.target.build_mipmaps(0, self._mips)
            self._gather.render(aspect)
        self._composite.render(aspect)

    def _dilate_pass(self) -> FullscreenPass:
        coc = self._coc
        inputs = {"tiles": coc.tile_min_max}
        defines = {**self._defines, "TILE": coc.tile_px, "LIMIT_PX": float(coc.limit_px)}
        if coc.widest is not None:
            inputs["widest"] = coc.widest
            defines["WIDEST"] = 1
        return self._pass("coc_tile_dilate", inputs, defines=defines, size_px=coc.tile_min_max.size)

    def _layer_passes(self) -> list[FullscreenPass]:
        found: list[FullscreenPass] = []
        for level in range(1, int(self._defines["LEVELS"])):
            finer = found[-1].target if found else self._coc.colour_and_coc
            defines = {"FROM_LAYERS": 1} if found else {}
            found.append(
                self._pass("layers", {"finer": finer}, level=level, dtype="u4", defines=defines)
            )
        return found

    def _gather_pass(self, half: moderngl.Texture, samples: int) -> FullscreenPass:
        defines = {
            **self._defines,
            "HALF_EXACT": levels.HALF_WIDER * levels.exact_px(samples),
            "HALF_LEVELS": self._mips + 1,
        }
        if self._mips:
            half.build_mipmaps(0, self._mips)
        inputs = {"half_resolution": half}
        mipmapped = set(inputs) if self._mips else set()
        return self._pass("gather", inputs, level=1, defines=defines, mipmapped=mipmapped)

    def _pass(
        self,
        name: str,
        inputs: dict[str, moderngl.Texture],
        *,
        level: int = 0,
        size_px: tuple[int, int] | None = None,
        **options: Any,
    ) -> FullscreenPass:
        width, height = self._coc.size_px
        size_px = size_px or (ceil(width / 2**level), ceil(height / 2**level))
        fragment = f"depth_of_field/{name}.frag"
        return FullscreenPass(self._ctx, fragment, size_px=size_px, inputs=inputs, **options)
