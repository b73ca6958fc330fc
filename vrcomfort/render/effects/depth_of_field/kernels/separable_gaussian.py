"""A Gaussian along rows, then along columns, at half resolution: an engine's cheap way."""

from __future__ import annotations

from typing import NamedTuple

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.half_resolution import (
    composite,
    half_size,
    halved,
)

FADE_PX = 0.5, 2.5


class _Axis(NamedTuple):
    axis: tuple[float, float]


class SeparableGaussianKernel:
    """As the Gaussian depth of field of Bevy (0.14), here at half resolution.

    Notes
    -----
    Every pixel has its own width, so that the two axes are a two-dimensional Gaussian only where
    neighbours are blurred alike. No depth is compared: sharp fronts leak into what is blurred
    behind them, and blurred fronts end at their outline.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - the method has no numbers
    ) -> None:
        self._half = halved(ctx, coc, firefly=False)
        self._rows = self._along(ctx, self._half.target, coc)
        self._columns = self._along(ctx, self._rows.target, coc)
        self._composite = composite(
            ctx, coc, self._columns.target, fade_px=FADE_PX, own_radius=True
        )
        self.target = self._composite.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._half.render()
        self._rows.render(_Axis((1.0, 0.0)))
        self._columns.render(_Axis((0.0, pixel_aspect)))
        self._composite.render()

    @staticmethod
    def _along(
        ctx: moderngl.Context, half_image: moderngl.Texture, coc: CocPasses
    ) -> FullscreenPass:
        return FullscreenPass(
            ctx,
            "depth_of_field/separable_gaussian.frag",
            size_px=half_size(coc.size_px),
            inputs={"half_image": half_image},
            filtered={"half_image"},
        )
