"""The MIP pyramid blown up again: blur that costs the same for any radius."""

from __future__ import annotations

from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.mip_chain import MipChain
from vrcomfort.optics import pyramid
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses


class _Slices(NamedTuple):
    slices_m: bytes


class MipKernel:
    """Trick three of "Four Tricks for Fast Blurring", 2001 (``mip_downsample.frag``, ``mip.frag``).

    Parameters
    ----------
    slices
        False: each pixel cross-fades between the two levels around its radius. True: billboards
        that slice the scene, one level each, without a cross-fade; at `slices_m`, where the
        settings have them.

    Notes
    -----
    The pyramid knows no depth: whatever is sharp has a halo in blurred surroundings, and a blurred
    front ends at its outline. Slices show a hard edge wherever a surface meets a billboard.
    Blur is square and round in pixels, even where pixels are not.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,
        *,
        slices: bool = False,
    ) -> None:
        self._coc, self._slices_m = coc, settings.slices_m if slices else None
        levels = len(self._slices_m or ()) or pyramid.levels(coc.limit_px)
        self._chain = MipChain(ctx, coc.colour_and_coc, levels, coc.size_px)
        self._shown = FullscreenPass(
            ctx,
            "depth_of_field/mip.frag",
            size_px=coc.size_px,
            inputs={
                "colour_and_coc": coc.colour_and_coc,
                "levels": self._chain.levels,
                **({"depth": coc.depth_to_coc.depth} if self._slices_m else {}),
            },
            constants=self._places(),
            filtered={"levels"},
            defines={"CHAIN": levels, **self._defines(slices=slices)},
        )
        self.target = self._shown.target

    def render(self, pixel_aspect: float) -> None:  # noqa: ARG002 - texels are squares of pixels
        """Blur the present points."""
        self._chain.render()
        self._shown.render(self._coc.eye if self._slices_m else None)

    def _defines(self, *, slices: bool) -> dict[str, int]:
        if not slices:
            return {}
        return {"SLICES": 1} | ({"AT_DISTANCES": 1} if self._slices_m else {})

    def _places(self) -> _Slices | None:
        if self._slices_m is None:
            return None
        return _Slices(np.array(self._slices_m, dtype=np.float32).tobytes())
