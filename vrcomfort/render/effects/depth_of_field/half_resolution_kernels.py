"""Kernels of engines that blur at half resolution: a disc, rings, a separable Gaussian.

All draw half an image with its radii, blur it, and put it over the sharp image (`composite`).
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, MipChain
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.layered_gather import Aspect


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


class _Constants(NamedTuple):
    offsets: bytes
    radius_limit_px: float


def taps() -> Array:
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
        offsets = taps().astype(np.float32)
        self._gather = FullscreenPass(
            ctx,
            "depth_of_field/half_resolution_disc.frag",
            size_px=half_size(coc.size_px),
            inputs={"half_image": self._half.target},
            filtered={"half_image"},
            constants=_Constants(offsets.tobytes(), coc.limit_px),
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

LEVELS = 3
"""Of the mip chain above half resolution."""

TILE = 8
"""Side of a tile in texels of half resolution: 16 px."""

DILATIONS = 2
RINGS_FADE_PX = 1.0, 2.0


class HalfResolutionRingsKernel:
    """As the depth of field of Filament (`dof.mat`, 5 rings as on desktops).

    Notes
    -----
    In front and behind are gathered apart; what is in front is looked for as far as the widest disc
    of the tiles around goes, up to `DILATIONS` tiles. Its fast tiles, hole filling and bokeh shape
    are left out. Written from its description.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        settings: DepthOfField,  # noqa: ARG002 - the method has no numbers
    ) -> None:
        size = half_size(coc.size_px)
        self._half = halved(ctx, coc, firefly=True)
        chain = MipChain(ctx, self._half.target, LEVELS, size)
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
            defines={"RINGS": RINGS, "CHAIN": LEVELS, "TILE": TILE},
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
        for dilations in range(DILATIONS + 1):
            made.append(
                FullscreenPass(
                    ctx,
                    "depth_of_field/half_resolution_tiles.frag",
                    size_px=(ceil(size[0] / TILE), ceil(size[1] / TILE)),
                    inputs={"source": source},
                    defines={"DILATE": 1} if dilations else {"TILE": TILE},
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
    neighbours are blurred alike. No depth is compared: sharp fronts leak into what is blurred
    behind them, and blurred fronts end at their outline.
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
