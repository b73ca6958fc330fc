"""Remembers the largest value that frames produced, without waiting for any of them."""

from __future__ import annotations

import moderngl
import numpy as np

from vrcomfort.gpu import gl, shaders


class MaxReductionPass:
    """Keeps the greatest length of some components in one pixel, `target`."""

    def __init__(
        self, ctx: moderngl.Context, texels: moderngl.Texture, *, components: str = "xy"
    ) -> None:
        self._ctx = ctx
        self._texels = texels
        self.target = gl.color_texture(ctx, (1, 1), components=1, dtype="f4")
        self._framebuffer = ctx.framebuffer([self.target])
        self._framebuffer.clear()
        program = shaders.program(
            ctx, "common/max_reduction.frag", "common/max_reduction.vert", {"VALUE": components}
        )
        self._points = ctx.vertex_array(program, [])
        self._points.program["texels"] = 0
        self._scope = ctx.scope(self._framebuffer, moderngl.BLEND)

    def render(self) -> None:
        """Take the present texels into account."""
        self._texels.use(0)
        self._ctx.blend_equation = (moderngl.MAX, moderngl.MAX)
        with self._scope:
            self._points.render(moderngl.POINTS, vertices=self._texels.width * self._texels.height)
        self._ctx.blend_equation = (moderngl.FUNC_ADD, moderngl.FUNC_ADD)

    def read(self) -> float:
        """Return the greatest value since the pass was made; waits for the GPU."""
        return float(np.frombuffer(self.target.read(), dtype=np.float32)[0])

    def forget(self) -> None:
        """Start again from 0."""
        self._framebuffer.clear()
