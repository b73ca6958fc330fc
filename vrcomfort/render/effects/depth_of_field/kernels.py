"""Kernels of depth of field by their names in a protocol, and those of papers.

A kernel spreads each pixel over its circle of confusion. Leaks and halos of each stand in its
notes: the trade-off measures them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import moderngl
import numpy as np

from vrcomfort.gpu import gl, passes, shaders
from vrcomfort.gpu.fullscreen_pass import ADDED, MipChain, by_eyes
from vrcomfort.gpu.passes import Pass, PassImage
from vrcomfort.optics import blur_kernels
from vrcomfort.protocol.conditions import DepthOfField, Kernel
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses, Inputs, PixelAspect
from vrcomfort.render.effects.depth_of_field.engine_kernels import (
    HalfResolutionDiscKernel,
    HalfResolutionRingsKernel,
    SeparableGaussianKernel,
)
from vrcomfort.render.effects.depth_of_field.half_gather import HalfGatherKernel
from vrcomfort.render.effects.depth_of_field.layered_gather import (
    BlurKernel,
    LayeredGatherKernel,
    is_layered,
)


class Poisson12Kernel:
    """The fragment program of Hillaire et al. 2008, Fig. 3 (``poisson12.frag``).

    Twelve Poisson taps, turned per pixel, and a depth comparison.

    Notes
    -----
    A sharp foreground does not leak, for a nearer tap weighs as much as it is blurred. A blurred
    foreground keeps its silhouette edge: sharp pixels beside it look at themselves only. The angles
    belong to the screen: the grain that replaces ghosts is the same in both eyes, and stays when
    the head turns. Without `rotate_taps` all angles are 0, and ghosts stay.
    """

    def __init__(self, coc: CocPasses) -> None:
        taps = blur_kernels.POISSON_12.astype(np.float32)
        turned = coc.settings.rotate_taps
        turns = blur_kernels.rotations() if turned else np.array([[[1.0, 0.0]]])
        rotations = gl.color_texture(coc.ctx, turns.shape[1::-1], components=2, dtype="f4")
        rotations.write(turns.astype(np.float32).tobytes())
        self._pass = coc.make_pass(
            "poisson12",
            {"colour_and_coc": coc.colour_and_coc, "rotations": rotations},
            filtered={"colour_and_coc"},
            constants={"offsets": taps.tobytes(), "max_radius_px": coc.max_radius_px},
            defines={"TAPS": len(taps)},
            reach_px=coc.max_radius_px + 1,  # read between pixels
        )
        self.target = self._pass.target

    def render(self, pixel_aspect: PixelAspect) -> None:
        """Blur the present points."""
        self._pass.render(pixel_aspect_of_eye=pixel_aspect)


class Poisson15NearKernel:
    """The second pass of Mantiuk et al. 2011, section 4 (``poisson15_near.frag``).

    Fifteen Poisson taps in circles that a blurred foreground widens around it.

    Notes
    -----
    A blurred foreground gets soft edges because its surroundings are blurred too, sharp background
    included ("the drawback of this method"). Taps are not compared in depth: a sharp foreground
    leaks into a blurred background, as the paper says of methods of this kind.
    """

    def __init__(self, coc: CocPasses) -> None:
        points, cell_px = {"colour_and_coc": coc.colour_and_coc}, 2**blur_kernels.NEAR_LEVEL
        self._near_mean = coc.make_pass(
            "poisson15_near_mean",
            points,
            texel_px=cell_px,
            defines={"CELL": cell_px},
            components=1,
            reach_px=0.0,
        )
        taps = blur_kernels.POISSON_15.astype(np.float32)
        self._gather = coc.make_pass(
            "poisson15_near",
            {**points, "near_mean": self._near_mean.target},
            filtered={"near_mean", "colour_and_coc"},
            constants={"offsets": taps.tobytes(), "max_radius_px": coc.max_radius_px},
            defines={"TAPS": len(taps), "CELL": cell_px},
            reach_px={"colour_and_coc": coc.max_radius_px + 1, "near_mean": float(cell_px)},
        )
        self.target = self._gather.target

    def render(self, pixel_aspect: PixelAspect) -> None:
        """Blur the present points."""
        self._near_mean.render()
        self._gather.render(pixel_aspect_of_eye=pixel_aspect)


class MipKernel:
    """Trick three of "Four Tricks for Fast Blurring", 2001 (``mip_downsample.frag``, ``mip.frag``).

    The MIP pyramid magnified again: blur that costs the same for any radius.

    Parameters
    ----------
    slices
        False: each pixel cross-fades between the two levels around its radius. True: billboards
        that slice the scene, one level each, without a cross-fade; at `slices_m`, where the
        settings have them.

    Notes
    -----
    The pyramid knows no depth: sharp pixels have a halo in blurred surroundings, and a blurred
    foreground ends at its silhouette edge. Slices show a hard edge wherever a surface meets a
    billboard. Blur is square and round in pixels, even where pixels are not.
    """

    def __init__(self, coc: CocPasses, *, slices: bool = False) -> None:
        slices_m = coc.settings.slices_m if slices else None
        levels = len(slices_m or ()) or blur_kernels.pyramid_levels(coc.max_radius_px)
        self._chain = MipChain(coc.ctx, coc.colour_and_coc, levels, coc.size_px)
        inputs: Inputs = {"colour_and_coc": coc.colour_and_coc, "levels": self._chain.levels}
        defines = {"CHAIN": levels, **({"SLICES": 1} if slices else {})}
        constants = None
        if slices_m:
            inputs = {**inputs, "depth": coc.depth_to_coc.depth}
            defines["AT_DISTANCES"] = 1
            constants = {"slices_m": np.array(slices_m, dtype=np.float32).tobytes()}
        self._shown = coc.make_pass(
            "mip",
            inputs,
            constants=constants,
            filtered={"levels"},
            defines=defines,
            reach_px={"colour_and_coc": 0.0, "depth": 0.0, "levels": 2.0**levels},
        )
        self.target = self._shown.target

    def render(self, pixel_aspect: PixelAspect) -> None:  # noqa: ARG002 - texels are squares of pixels
        """Blur the present points."""
        self._chain.render()
        self._shown.render()


TALLEST_PIXEL = 1.5
"""Height over width of a pixel: no headset has narrower ones. Bounds the size of sprites."""


class ScatterKernel:
    """Algorithm 1 of Carnegie & Rhee 2015, as blended sprites (``scatter.vert``, ``scatter.frag``).

    Notes
    -----
    The algorithm asks no depth: every disc is blended into the output, hidden or not. Blending is
    addition here, so that the order of the pixels does not matter, and what arrived is divided by
    how much arrived, so that a constant image stays constant. At an edge where the discs of the
    blurred side add up to A, a sharp pixel of weight 1 on the other side keeps 1 / (1 + A) of its
    colour: a blurred foreground spreads over a sharp background with opacity A / (1 + A) instead of
    A, and a blurred background leaks over a sharp foreground just as much. Sharp pixels never
    spread.

    The cost is the sum of the areas of all discs, each at most that of `CocPasses.max_radius_px`.
    """

    def __init__(self, coc: CocPasses) -> None:
        self._ctx = ctx = coc.ctx
        self._colour_and_coc = coc.colour_and_coc
        # 32-bit floats: half floats lose small shares beside the sum of many discs.
        shares = gl.eye_texture(ctx, coc.size_px, coc.eyes, dtype="f4")
        self._framebuffer = ctx.framebuffer([shares])
        self._scope = ctx.scope(self._framebuffer, moderngl.BLEND | moderngl.PROGRAM_POINT_SIZE)
        reads, writes = (PassImage.of(coc.colour_and_coc),), (PassImage.of(shares),)
        self._cleared = passes.clear([shares])
        self._declared = Pass("depth_of_field/scatter.frag", reads, writes, blends=True)
        # Squares are drawn where the widest disc is larger than the driver's largest point.
        widest_px = 2 * (TALLEST_PIXEL * (coc.max_radius_px + 0.5) + 1)
        self._fits_points = widest_px <= ctx.info["GL_POINT_SIZE_RANGE"][1]
        defines = {**by_eyes(coc.eyes), **({} if self._fits_points else {"SQUARES": 1})}
        program = shaders.program(
            ctx, "depth_of_field/scatter.frag", "depth_of_field/scatter.vert", defines
        )
        program["colour_and_coc"] = 0
        self._sprites = ctx.vertex_array(program, [])
        self._mean = coc.make_pass("scatter_mean", {"shares": shares}, reach_px=0.0)
        self.target = self._mean.target

    def render(self, pixel_aspect: PixelAspect) -> None:
        """Blur the present points."""
        self._sprites.program["pixel_aspect_of_eye"] = pixel_aspect
        self._cleared.run(self._framebuffer.clear)
        self._colour_and_coc.use(0)
        self._ctx.blend_func = ADDED
        self._declared.run(self._draw)
        self._mean.render()

    def _draw(self) -> None:
        image = self._colour_and_coc
        pixels = image.width * image.height * gl.layers_of(image)
        with self._scope:
            if self._fits_points:
                self._sprites.render(moderngl.POINTS, vertices=pixels)
            else:
                self._sprites.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=pixels)


_KERNELS: dict[Kernel, Callable[[CocPasses], BlurKernel]] = {
    "scatter": ScatterKernel,
    "poisson12": Poisson12Kernel,
    "poisson15_near": Poisson15NearKernel,
    "mip": MipKernel,
    "mip_slices": partial(MipKernel, slices=True),
    "half_resolution_disc": HalfResolutionDiscKernel,
    "ring_gather": HalfResolutionRingsKernel,
    "separable_gaussian": SeparableGaussianKernel,
}


def make_kernel(coc: CocPasses, settings: DepthOfField) -> BlurKernel:
    """Return the kernel that `settings` name, reading the points of `coc`."""
    if is_layered(settings):
        return LayeredGatherKernel(coc, settings)
    if settings.kernel == "vrcomfort":
        return HalfGatherKernel(coc)
    return _KERNELS[settings.kernel](coc)
