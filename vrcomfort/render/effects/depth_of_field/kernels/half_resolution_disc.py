"""A disc of 43 samples at half resolution, as wide as the widest disc: an engine's bokeh."""

from __future__ import annotations

from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.half_resolution import (
    composite,
    half_size,
    halved,
)

FADE_PX = 2.0, 4.0


class _Constants(NamedTuple):
    offsets: bytes
    radius_limit_px: float


def taps() -> Array:
    """Return (43, 2) points of the unit disc: 1, 7, 14 and 21 on rings at 0, ⅓, ⅔ and 1."""
    rings = [
        np.stack([np.cos(angle), np.sin(angle)], axis=-1) * ring / 3
        for ring in (1, 2, 3)
        for angle in [np.arange(7 * ring) * 2 * np.pi / (7 * ring)]
    ]
    return np.concatenate([np.zeros((1, 2)), *rings])


class HalfResolutionDiscKernel:
    """As KinoBokeh (Takahashi, for Unity; its 43 samples and tent).

    Notes
    -----
    Samples lie in a disc of the largest radius there can be, not of the pixel's own: where blur is
    a third of the limit, a dozen samples are left. Written from its description; its fading of
    sharp colours to black before the gather is left out, since a constant image is to stay one.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - the method has no numbers
    ) -> None:
        self._half = halved(ctx, coc, firefly=True)
        offsets = taps().astype(np.float32)
        self._gather = FullscreenPass(
            ctx,
            "depth_of_field/half_resolution_disc.frag",
            size_px=half_size(coc.size_px),
            inputs={"half_image": self._half.target},
            filtered={"half_image"},
            constants=_Constants(offsets.tobytes(), coc.limit_px),
            defines={"TAPS": len(offsets)},
        )
        self._tent = FullscreenPass(
            ctx,
            "depth_of_field/tent.frag",
            size_px=half_size(coc.size_px),
            inputs={"source": self._gather.target},
            filtered={"source"},
        )
        self._composite = composite(ctx, coc, self._tent.target, fade_px=FADE_PX)
        self.target = self._composite.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._half.render()
        self._gather.render(Aspect(pixel_aspect))
        self._tent.render()
        self._composite.render()
