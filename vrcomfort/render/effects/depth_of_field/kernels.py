"""Kernels of depth of field by their names in a protocol, and those of papers and engines.

A kernel spreads each pixel over its circle of confusion. Leaks and halos of each stand in its
notes: the trade-off measures them. Kernels of engines blur at half resolution: they draw half an
image with its radii, blur it, and put it over the sharp image (`composite`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import ceil
from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.gpu import gl, passes, shaders
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, MipChain
from vrcomfort.gpu.passes import Pass, PassImage
from vrcomfort.optics import blur_kernels
from vrcomfort.protocol.conditions import DepthOfField, Kernel
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.layered_gather import (
    Aspect,
    BlurKernel,
    LayeredGatherKernel,
)


def half_size(size_px: tuple[int, int]) -> tuple[int, int]:
    """Return half a size, rounded up."""
    width, height = size_px
    return ceil(width / 2), ceil(height / 2)


def halved(ctx: moderngl.Context, coc: CocPasses, *, firefly: bool) -> FullscreenPass:
    """Return the pass that draws half of an image with its radii (``half_resolution.frag``)."""
    return FullscreenPass(
        ctx,
        "depth_of_field/half_resolution.frag",
        size_px=half_size(coc.size_px),
        inputs={"colour_and_coc": coc.colour_and_coc},
        defines={"FIREFLY": 1} if firefly else {},
    )


def composite(
    ctx: moderngl.Context,
    coc: CocPasses,
    half_image: moderngl.Texture,
    *,
    fade_px: tuple[float, float],
    own_radius: bool = False,
    half_front: moderngl.Texture | None = None,
) -> FullscreenPass:
    """Return the pass that puts half an image over the whole (``half_resolution_composite.frag``).

    Parameters
    ----------
    fade_px
        Between these radii of its own a pixel goes from sharp to blurred.
    """
    fronts = {} if half_front is None else {"half_front": half_front}
    return FullscreenPass(
        ctx,
        "depth_of_field/half_resolution_composite.frag",
        size_px=coc.size_px,
        inputs={"colour_and_coc": coc.colour_and_coc, "half_image": half_image, **fronts},
        filtered={"half_image", *fronts},
        defines={
            "FAR_FROM_PX": float(fade_px[0]),
            "FAR_TO_PX": float(fade_px[1]),
            **({"OWN_RADIUS": 1} if own_radius else {}),
            **({"FRONT": 1} if fronts else {}),
        },
    )


DISC_FADE_PX = 2.0, 4.0


class _TapUniforms(NamedTuple):
    offsets: bytes
    max_radius_px: float


def disc_taps() -> Array:
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
        offsets = disc_taps().astype(np.float32)
        self._gather = FullscreenPass(
            ctx,
            "depth_of_field/half_resolution_disc.frag",
            size_px=half_size(coc.size_px),
            inputs={"half_image": self._half.target},
            filtered={"half_image"},
            constants=_TapUniforms(offsets.tobytes(), coc.max_radius_px),
            defines={"TAPS": len(offsets)},
        )
        self._tent = FullscreenPass(
            ctx,
            "depth_of_field/tent.frag",
            size_px=half_size(coc.size_px),
            inputs={"source": self._gather.target},
            filtered={"source"},
        )
        self._composite = composite(ctx, coc, self._tent.target, fade_px=DISC_FADE_PX)
        self.target = self._composite.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._half.render()
        self._gather.render(Aspect(pixel_aspect))
        self._tent.render()
        self._composite.render()


RINGS = 5
"""The centre among them: 81 samples."""

RING_MIPS = 3
"""Of the mip chain above half resolution: rings of wide discs read coarser mips."""

RING_TILE = 8
"""Side of a tile in texels of half resolution: 16 px."""

RING_DILATIONS = 2
RINGS_FADE_PX = 1.0, 2.0


class HalfResolutionRingsKernel:
    """As the depth of field of Filament (`dof.mat`, 5 rings as on desktops).

    Notes
    -----
    Foreground and background are gathered apart; the foreground is sought as far as the widest disc
    of the tiles around goes, up to `RING_DILATIONS` tiles. Its fast tiles, hole filling and bokeh
    shape are left out. Written from its description.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - the method has no numbers
    ) -> None:
        size = half_size(coc.size_px)
        self._half = halved(ctx, coc, firefly=True)
        chain = MipChain(ctx, self._half.target, RING_MIPS, size)
        tiles = self._tile_passes(ctx, size)
        self._gather = FullscreenPass(
            ctx,
            "depth_of_field/half_resolution_rings.frag",
            size_px=size,
            inputs={
                "half_image": self._half.target,
                "levels": chain.levels,
                "tiles": tiles[-1].target,
            },
            filtered={"half_image", "levels"},
            defines={"RINGS": RINGS, "CHAIN": RING_MIPS, "TILE": RING_TILE},
            more_components=(4,),
        )
        median = FullscreenPass(
            ctx,
            "depth_of_field/median.frag",
            size_px=size,
            inputs=dict(zip(("background", "foreground"), self._gather.targets, strict=True)),
            more_components=(4,),
        )
        background, foreground = median.targets
        shown = composite(ctx, coc, background, fade_px=RINGS_FADE_PX, half_front=foreground)
        self._chain, self._tiles, self._after = chain, tiles, (median, shown)
        self.target = shown.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._half.render()
        self._chain.render()
        for each in self._tiles:
            each.render()
        self._gather.render(Aspect(pixel_aspect))
        for each in self._after:
            each.render()

    def _tile_passes(self, ctx: moderngl.Context, size: tuple[int, int]) -> list[FullscreenPass]:
        made: list[FullscreenPass] = []
        source = self._half.target
        for dilations in range(RING_DILATIONS + 1):
            made.append(
                FullscreenPass(
                    ctx,
                    "depth_of_field/half_resolution_tiles.frag",
                    size_px=(ceil(size[0] / RING_TILE), ceil(size[1] / RING_TILE)),
                    inputs={"source": source},
                    defines={"DILATE": 1} if dilations else {"TILE": RING_TILE},
                    components=2,
                )
            )
            source = made[-1].target
        return made


GAUSSIAN_FADE_PX = 0.5, 2.5


class _Axis(NamedTuple):
    axis: tuple[float, float]


class SeparableGaussianKernel:
    """As the Gaussian depth of field of Bevy (0.14), here at half resolution.

    Notes
    -----
    Every pixel has its own width, so that the two axes are a two-dimensional Gaussian only where
    neighbours are blurred alike. No depth is compared: a sharp foreground leaks into the
    blurred background, and a blurred foreground ends at its silhouette edge.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - the method has no numbers
    ) -> None:
        self._half = halved(ctx, coc, firefly=False)
        self._rows = self._along(ctx, self._half.target, coc)
        self._columns = self._along(ctx, self._rows.target, coc)
        self._composite = composite(
            ctx, coc, self._columns.target, fade_px=GAUSSIAN_FADE_PX, own_radius=True
        )
        self.target = self._composite.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._half.render()
        self._rows.render(_Axis((1.0, 0.0)))
        self._columns.render(_Axis((0.0, pixel_aspect)))
        self._composite.render()

    @staticmethod
    def _along(
        ctx: moderngl.Context, half_image: moderngl.Texture, coc: CocPasses
    ) -> FullscreenPass:
        return FullscreenPass(
            ctx,
            "depth_of_field/separable_gaussian.frag",
            size_px=half_size(coc.size_px),
            inputs={"half_image": half_image},
            filtered={"half_image"},
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

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,
    ) -> None:
        taps = blur_kernels.POISSON_12.astype(np.float32)
        turns = blur_kernels.rotations() if settings.rotate_taps else np.array([[[1.0, 0.0]]])
        rotations = gl.color_texture(ctx, turns.shape[1::-1], components=2, dtype="f4")
        rotations.write(turns.astype(np.float32).tobytes())
        self._pass = FullscreenPass(
            ctx,
            "depth_of_field/poisson12.frag",
            size_px=coc.size_px,
            inputs={"colour_and_coc": coc.colour_and_coc, "rotations": rotations},
            filtered={"colour_and_coc"},
            constants=_TapUniforms(taps.tobytes(), coc.max_radius_px),
            defines={"TAPS": len(taps)},
        )
        self.target = self._pass.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._pass.render(Aspect(pixel_aspect))


class Poisson15NearKernel:
    """The second pass of Mantiuk et al. 2011, section 4 (``poisson15_near.frag``).

    Fifteen Poisson taps in circles that a blurred foreground widens around it.

    Notes
    -----
    A blurred foreground gets soft edges because its surroundings are blurred too, sharp background
    included ("the drawback of this method"). Taps are not compared in depth: a sharp foreground
    leaks into a blurred background, as the paper says of methods of this kind.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - the paper's numbers are fixed
    ) -> None:
        width, height = coc.size_px
        cell = {"CELL": 2**blur_kernels.NEAR_LEVEL}
        self._near_mean = FullscreenPass(
            ctx,
            "depth_of_field/poisson15_near_mean.frag",
            size_px=(ceil(width / cell["CELL"]), ceil(height / cell["CELL"])),
            inputs={"colour_and_coc": coc.colour_and_coc},
            defines=cell,
            components=1,
        )
        taps = blur_kernels.POISSON_15.astype(np.float32)
        self._gather = FullscreenPass(
            ctx,
            "depth_of_field/poisson15_near.frag",
            size_px=coc.size_px,
            inputs={"colour_and_coc": coc.colour_and_coc, "near_mean": self._near_mean.target},
            filtered={"near_mean", "colour_and_coc"},
            constants=_TapUniforms(taps.tobytes(), coc.max_radius_px),
            defines={"TAPS": len(taps), **cell},
        )
        self.target = self._gather.target

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._near_mean.render()
        self._gather.render(Aspect(pixel_aspect))


class _Slices(NamedTuple):
    slices_m: bytes


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

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,
        *,
        slices: bool = False,
    ) -> None:
        self._slices_m = settings.slices_m if slices else None
        levels = len(self._slices_m or ()) or blur_kernels.pyramid_levels(coc.max_radius_px)
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
        self._shown.render()

    def _defines(self, *, slices: bool) -> dict[str, int]:
        if not slices:
            return {}
        return {"SLICES": 1} | ({"AT_DISTANCES": 1} if self._slices_m else {})

    def _places(self) -> _Slices | None:
        if self._slices_m is None:
            return None
        return _Slices(np.array(self._slices_m, dtype=np.float32).tobytes())


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

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - the algorithm has no further numbers
    ) -> None:
        self._ctx = ctx
        self._colour_and_coc = coc.colour_and_coc
        # 32-bit floats: half floats lose small shares beside the sum of many discs.
        shares = gl.color_texture(ctx, coc.size_px, dtype="f4")
        self._framebuffer = ctx.framebuffer([shares])
        self._scope = ctx.scope(self._framebuffer, moderngl.BLEND | moderngl.PROGRAM_POINT_SIZE)
        reads, writes = (PassImage.of(coc.colour_and_coc),), (PassImage.of(shares),)
        self._cleared = passes.clear([shares])
        self._declared = Pass("depth_of_field/scatter.frag", reads, writes, blends=True)
        # Squares are drawn where the widest disc is larger than the driver's largest point.
        widest_px = 2 * (TALLEST_PIXEL * (coc.max_radius_px + 0.5) + 1)
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
        self._cleared.run(self._framebuffer.clear)
        self._colour_and_coc.use(0)
        self._ctx.blend_func = moderngl.ONE, moderngl.ONE
        self._declared.run(self._draw)
        self._mean.render()

    def _draw(self) -> None:
        pixels = self._colour_and_coc.width * self._colour_and_coc.height
        with self._scope:
            if self._fits_points:
                self._sprites.render(moderngl.POINTS, vertices=pixels)
            else:
                self._sprites.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=pixels)


_Maker = Callable[[moderngl.Context, CocPasses, DepthOfField], BlurKernel]
_KERNELS: dict[Kernel, _Maker] = {
    "vrcomfort": LayeredGatherKernel,
    "scatter": ScatterKernel,
    "poisson12": Poisson12Kernel,
    "poisson15_near": Poisson15NearKernel,
    "mip": MipKernel,
    "mip_slices": partial(MipKernel, slices=True),
    "half_resolution_disc": HalfResolutionDiscKernel,
    "ring_gather": HalfResolutionRingsKernel,
    "separable_gaussian": SeparableGaussianKernel,
}


def make_kernel(ctx: moderngl.Context, coc: CocPasses, settings: DepthOfField) -> BlurKernel:
    """Return the kernel that `settings` name, reading the points of `coc`."""
    return _KERNELS[settings.kernel](ctx, coc, settings)
