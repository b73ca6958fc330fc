"""Hillaire's kernel: twelve Poisson taps, turned per pixel, and a depth comparison."""

from __future__ import annotations

from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import poisson_taps
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect


class _Constants(NamedTuple):
    offsets: bytes
    radius_limit_px: float


class Poisson12Kernel:
    """The fragment program of Hillaire et al. 2008, Fig. 3 (``poisson12.frag``).

    Notes
    -----
    A sharp front does not leak, for a nearer tap weighs as much as it is blurred. A blurred front
    keeps its outline: sharp pixels beside it look at themselves only. The angles belong to the
    screen: the grain that replaces ghosts is the same in both eyes, and stays when the head turns.
    Without `rotate_taps` all angles are 0, and ghosts stay.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,
    ) -> None:
        taps = poisson_taps.POISSON_12.astype(np.float32)
        turns = poisson_taps.rotations() if settings.rotate_taps else np.array([[[1.0, 0.0]]])
        rotations = gl.color_texture(ctx, turns.shape[1::-1], components=2, dtype="f4")
        rotations.write(turns.astype(np.float32).tobytes())
        self._pass = FullscreenPass(
            ctx,
            "depth_of_field/poisson12.frag",
            size_px=coc.size_px,
            inputs={"colour_and_coc": coc.colour_and_coc, "rotations": rotations},
            filtered={"colour_and_coc"},
            constants=_Constants(taps.tobytes(), coc.limit_px),
            defines={"TAPS": len(taps)},
        )
        self.target = self._pass.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._pass.render(Aspect(pixel_aspect))
