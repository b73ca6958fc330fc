"""The last pass: linear HDR light to the 8-bit image that a display gets."""

from __future__ import annotations

from typing import NamedTuple

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import tone

TONE_CURVE = {"COMPRESSION_START": tone.COMPRESSION_START, "DESATURATION": tone.DESATURATION}
"""Defines of ``include/tone.glsl``."""


class _Exposure(NamedTuple):
    exposure: float


class ToneMapPass:
    """Encodes `radiance` (linear RGBA16F) into `target` (RGBA8, sRGB-encoded, alpha 1)."""

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        radiance: moderngl.Texture,
        size_px: tuple[int, int],
        exposure: float,
    ) -> None:
        self._pass = FullscreenPass(
            ctx,
            "display/tone_map.frag",
            size_px=size_px,
            inputs={"radiance": radiance},
            constants=_Exposure(exposure),
            defines=TONE_CURVE,
            dtype="f1",
        )
        self.target = self._pass.target

    def render(self) -> None:
        """Encode the present image."""
        self._pass.render()
