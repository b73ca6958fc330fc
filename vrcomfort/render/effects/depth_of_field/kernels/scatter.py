"""Carnegie & Rhee's kernel: every pixel is spread over its disc and blended into the image."""

from __future__ import annotations

import moderngl

from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses

TALLEST_PIXEL = 1.5
"""No headset's pixels are narrower than this, height over width."""


class ScatterKernel:
    """Algorithm 1 of Carnegie & Rhee 2015, as blended sprites (``scatter.vert``, ``scatter.frag``).

    Notes
    -----
    The algorithm asks no depth: every disc is blended into the output, whoever hides whom. Blending
    is addition here, so that the order of the pixels does not matter, and what arrived is divided
    by how much arrived, so that a constant image stays constant. At an edge where the discs of the
    blurred side add up to A, a sharp pixel of weight 1 on the other side keeps 1 / (1 + A) of its
    colour: a blurred front spreads over a sharp back with opacity A / (1 + A) instead of A, and a
    blurred back leaks over a sharp front just as much. Sharp pixels never spread.

    The cost is the sum of the areas of all discs, each at most that of `CocPasses.limit_px`.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - the algorithm has no further numbers
    ) -> None:
        self._ctx = ctx
        self._colour_and_coc = coc.colour_and_coc
        shares = gl.color_texture(ctx, coc.size_px, dtype="f4")
        self._framebuffer = ctx.framebuffer([shares])
        self._scope = ctx.scope(self._framebuffer, moderngl.BLEND | moderngl.PROGRAM_POINT_SIZE)
        widest_px = 2 * (TALLEST_PIXEL * (coc.limit_px + 0.5) + 1)
        self._fits_points = widest_px <= ctx.info["GL_POINT_SIZE_RANGE"][1]
        defines = {} if self._fits_points else {"SQUARES": 1}
        program = shaders.program(
            ctx, "depth_of_field/scatter.frag", "depth_of_field/scatter.vert", defines
        )
        program["colour_and_coc"] = 0
        self._sprites = ctx.vertex_array(program, [])
        self._mean = FullscreenPass(
            ctx,
            "depth_of_field/scatter_mean.frag",
            size_px=coc.size_px,
            inputs={"shares": shares},
        )
        self.target = self._mean.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._sprites.program["pixel_aspect"] = pixel_aspect
        self._framebuffer.clear()
        self._colour_and_coc.use(0)
        self._ctx.blend_func = moderngl.ONE, moderngl.ONE
        pixels = self._colour_and_coc.width * self._colour_and_coc.height
        with self._scope:
            if self._fits_points:
                self._sprites.render(moderngl.POINTS, vertices=pixels)
            else:
                self._sprites.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=pixels)
        self._mean.render()
