"""Motion blur along each pixel's own velocity (Rosado 2007), for comparison with ours."""

from __future__ import annotations

import moderngl
import numpy as np

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.render.effects.motion_blur.shutter import Shutter

_LONGEST_BINDING = 0


class PerPixel:
    """Averages `samples` along each pixel's own streak into `target`: one pass."""

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: moderngl.Texture,
        velocity: moderngl.Texture,
        samples: int,
    ) -> None:
        self._ctx = ctx
        self._longest = gl.dynamic_buffer(ctx, 4)
        self._longest.clear()
        self._gather = FullscreenPass(
            ctx,
            "motion_blur/motion_blur_per_pixel.frag",
            size_px=colour.size,
            inputs={"colour": colour, "velocity": velocity},
            filtered={"colour"},
            defines={"SAMPLES": samples, "LONGEST_BINDING": _LONGEST_BINDING},
        )
        self.target = self._gather.target

    def render(self, shutter: Shutter) -> None:
        """Blur along the present streaks."""
        self._longest.bind_to_storage_buffer(_LONGEST_BINDING)
        self._gather.render(shutter)

    def longest_half_velocity_px(self) -> float:
        """Return the longest half streak that was shortened, 0 where none was; waits."""
        self._ctx.memory_barrier()
        return float(np.frombuffer(self._longest.read(), np.float32)[0])
