"""Mantiuk's kernel: fifteen Poisson taps in circles that blurred fronts widen around them."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import poisson_taps
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect


class _Constants(NamedTuple):
    offsets: bytes
    radius_limit_px: float


class Poisson15NearKernel:
    """The second pass of Mantiuk et al. 2011, section 4 (``poisson15_near.frag``).

    Notes
    -----
    A blurred front gets soft edges because what lies around it is blurred too, sharp background
    included ("the drawback of this method"). Taps are not compared in depth: a sharp front leaks
    into a blurred back, as the paper says of methods of this kind.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - the paper's numbers are fixed
    ) -> None:
        width, height = coc.size_px
        cell = {"CELL": 2**poisson_taps.NEAR_LEVEL}
        self._near_mean = FullscreenPass(
            ctx,
            "depth_of_field/poisson15_near_mean.frag",
            size_px=(ceil(width / cell["CELL"]), ceil(height / cell["CELL"])),
            inputs={"colour_and_coc": coc.colour_and_coc},
            defines=cell,
            components=1,
        )
        taps = poisson_taps.POISSON_15.astype(np.float32)
        self._gather = FullscreenPass(
            ctx,
            "depth_of_field/poisson15_near.frag",
            size_px=coc.size_px,
            inputs={"colour_and_coc": coc.colour_and_coc, "near_mean": self._near_mean.target},
            filtered={"near_mean", "colour_and_coc"},
            constants=_Constants(taps.tobytes(), coc.limit_px),
            defines={"TAPS": len(taps), **cell},
        )
        self.target = self._gather.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._near_mean.render()
        self._gather.render(Aspect(pixel_aspect))
