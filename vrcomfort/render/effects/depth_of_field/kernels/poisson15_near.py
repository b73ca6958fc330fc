"""Mantiuk's kernel: fifteen Poisson taps in circles that blurred fronts widen around them."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import gathering
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.circle_of_confusion import Defocus
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
        colour: moderngl.Texture,  # noqa: ARG002 - the points hold it too
        defocus: Defocus,
        settings: DepthOfField,  # noqa: ARG002 - the paper's numbers are fixed
    ) -> None:
        width, height = defocus.size_px
        cell = {"CELL": 2**gathering.NEAR_LEVEL}
        self._near_mean = FullscreenPass(
            ctx,
            "depth_of_field/poisson15_near_mean.frag",
            size_px=(ceil(width / cell["CELL"]), ceil(height / cell["CELL"])),
            inputs={"points": defocus.points},
            defines=cell,
            components=1,
        )
        taps = gathering.POISSON_15.astype(np.float32)
        self._gather = FullscreenPass(
            ctx,
            "depth_of_field/poisson15_near.frag",
            size_px=defocus.size_px,
            inputs={"points": defocus.points, "near_mean": self._near_mean.target},
            filtered={"near_mean", "points"},
            constants=_Constants(taps.tobytes(), defocus.limit_px),
            defines={"TAPS": len(taps), **cell},
        )
        self.target = self._gather.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._near_mean.render()
        self._gather.render(Aspect(pixel_aspect))
