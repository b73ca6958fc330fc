"""Kernels of depth of field as three engines have them, for `vrcomfort tradeoff`.

Each was written anew after the engine's published passes; docs/sources.md says where it differs.
Two blur at half resolution: they draw half an image with its radii, blur it, and put it over the
sharp image.
"""

from __future__ import annotations

from math import ceil, log2

import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, of_each
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses, PixelAspect

HALF_PX = 2
"""Side of a texel of half an image: how far beyond a pixel a bilinear read of it goes."""

IN_FOCUS_PX = 1.0
"""Below this radius Filament leaves the sharp image."""


def halved(coc: CocPasses, source: AnyTexture, texel_px: int, **defines: float) -> FullscreenPass:
    """Return the pass that draws half of an image with its radii (``half_resolution.frag``)."""
    return coc.make_pass(
        "half_resolution", {"source": source}, texel_px=texel_px, defines=defines, reach_px=0.0
    )


def composite(coc: CocPasses, half_image: AnyTexture) -> FullscreenPass:
    """Return the pass ``half_resolution_composite.frag``: half an image over the whole."""
    return coc.make_pass(
        "half_resolution_composite",
        {"colour_and_coc": coc.colour_and_coc, "half_image": half_image},
        filtered={"half_image"},
        reach_px={"colour_and_coc": 0.0, "half_image": HALF_PX},
    )


def disc_taps() -> Array:
    """Return (43, 2) points of the unit disc: its middle, and 7, 14 and 21 on three rings.

    Ring k has the radius (k + 1/7) / (3 + 1/7).
    """
    rings = [
        np.stack([np.cos(angle), np.sin(angle)], axis=-1) * (ring + 1 / 7) / (3 + 1 / 7)
        for ring in (1, 2, 3)
        for angle in [np.arange(7 * ring) * 2 * np.pi / (7 * ring)]
    ]
    return np.concatenate([np.zeros((1, 2)), *rings])


class HalfResolutionDiscKernel:
    """As KinoBokeh (Takahashi and Unity Technologies, 2016) with its kernel of 43 samples.

    Notes
    -----
    Samples lie in a disc that is as wide for every pixel: the widest of the image, where KinoBokeh
    has one of four sizes that its user chooses. Where blur is a third of it, a few samples are
    left. KinoBokeh fades what is in focus to black before the gather; here it is not, so that a
    constant image stays constant.
    """

    def __init__(self, coc: CocPasses) -> None:
        self._half = halved(coc, coc.colour_and_coc, HALF_PX, BY_RADIUS=1)
        offsets = disc_taps().astype(np.float32)
        widest = {} if coc.widest is None else {"widest": coc.widest}
        self._gather = coc.make_pass(
            "half_resolution_disc",
            {"half_image": self._half.target, **widest},
            texel_px=HALF_PX,
            filtered={"half_image"},
            constants={"offsets": offsets.tobytes(), "max_radius_px": coc.max_radius_px},
            defines={"TAPS": len(offsets), **({"WIDEST": 1} if widest else {})},
            reach_px={"half_image": coc.max_radius_px + HALF_PX},
        )
        self._tent = coc.make_pass(
            "tent",
            {"source": self._gather.target},
            texel_px=HALF_PX,
            filtered={"source"},
            reach_px=HALF_PX,
        )
        self._composite = composite(coc, self._tent.target)
        self.target = self._composite.target

    def render(self, pixel_aspect: PixelAspect) -> None:
        """Blur the present points."""
        self._half.render()
        self._gather.render(pixel_aspect_of_eye=pixel_aspect)
        self._tent.render()
        self._composite.render()


RINGS = 4
"""The centre among them: 49 samples, as Filament has on desktops."""

RING_TILE = 8
"""Side of a tile in texels of half resolution: 16 px."""


def ring_levels(max_radius_px: float) -> int:
    """Return how many levels rings of the widest discs read above half resolution."""
    return max(1, round(log2(max(0.5 * max_radius_px / (RINGS - 0.5), 1.0))))


def ring_dilations(max_radius_px: float) -> int:
    """Return how many tiles the widest disc reaches beyond its own."""
    return max(1, ceil(max_radius_px / (2 * RING_TILE)))


class HalfResolutionRingsKernel:
    """As the depth of field of Filament (`dof*.mat`) on desktops.

    Notes
    -----
    Filament's limit of 32 px is not there: tiles are dilated, and levels drawn, as far as the
    widest disc asks for. Samples are shifted by a random number of each pixel. Colour and radius
    are one read, where Filament makes two.
    """

    def __init__(self, coc: CocPasses) -> None:
        half = halved(coc, coc.colour_and_coc, HALF_PX, IN_FOCUS_PX=IN_FOCUS_PX)
        levels = _levels(coc, half.target)
        tiles = _tiles(coc, half.target)
        coarsest_px = HALF_PX * 2 ** len(levels)
        self._gather = coc.make_pass(
            "half_resolution_rings",
            {
                "half_image": half.target,
                "levels": [level.target for level in levels],
                "tiles": tiles[-1].target,
            },
            texel_px=HALF_PX,
            filtered={"half_image", "levels"},
            defines={
                "RINGS": RINGS,
                "CHAIN": len(levels),
                "TILE": RING_TILE,
                "IN_FOCUS_PX": IN_FOCUS_PX,
            },
            reach_px={
                **dict.fromkeys(("half_image", "levels"), coc.max_radius_px + coarsest_px),
                "tiles": 0.0,
            },
        )
        median = coc.make_pass(
            "median",
            {"source": self._gather.target, "tiles": tiles[-1].target},
            texel_px=HALF_PX,
            defines={"TILE": RING_TILE, "IN_FOCUS_PX": IN_FOCUS_PX},
            reach_px={"source": HALF_PX, "tiles": 0.0},
        )
        shown = composite(coc, median.target)
        self._before, self._after = (half, *levels, *tiles), (median, shown)
        self.target = shown.target

    def render(self, pixel_aspect: PixelAspect) -> None:
        """Blur the present points."""
        for each in self._before:
            each.render()
        self._gather.render(pixel_aspect_of_eye=pixel_aspect)
        for each in self._after:
            each.render()


def _levels(coc: CocPasses, half_image: AnyTexture) -> list[FullscreenPass]:
    made: list[FullscreenPass] = []
    for level in range(1, ring_levels(coc.max_radius_px) + 1):
        source = made[-1].target if made else half_image
        made.append(halved(coc, source, HALF_PX * 2**level, LEVELS=1, IN_FOCUS_PX=IN_FOCUS_PX))
    return made


def _tiles(coc: CocPasses, half_image: AnyTexture) -> list[FullscreenPass]:
    made: list[FullscreenPass] = []
    side_px = HALF_PX * RING_TILE
    for dilation in range(ring_dilations(coc.max_radius_px) + 1):
        # A disc that is to reach another tile this many steps away crosses all tiles between.
        dilate = {"DILATE": 1, "FROM_PX": float(side_px * (dilation - 1))}
        made.append(
            coc.make_pass(
                "half_resolution_tiles",
                {"source": made[-1].target if made else half_image},
                texel_px=side_px,
                defines=dilate if dilation else {"TILE": RING_TILE},
                components=2,
                reach_px=float(side_px) if dilation else 0.0,
            )
        )
    return made


GAUSSIAN_REACH = 1.5
"""Half the width of the Gaussian's samples, in standard deviations: Bevy's value."""


class SeparableGaussianKernel:
    """As the Gaussian depth of field of Bevy (0.14).

    Notes
    -----
    Every pixel has its own width, so that the two axes are a two-dimensional Gaussian only where
    neighbours are blurred alike. No depth is compared: a sharp foreground leaks into the
    blurred background, and a blurred foreground ends at its silhouette edge.
    """

    def __init__(self, coc: CocPasses) -> None:
        self._rows = _along(coc, coc.colour_and_coc)
        self._columns = _along(coc, self._rows.target)
        self.target = self._columns.target

    def render(self, pixel_aspect: PixelAspect) -> None:
        """Blur the present points."""
        each = pixel_aspect if isinstance(pixel_aspect, tuple) else (pixel_aspect,)
        self._rows.render(axis_of_eye=of_each([(1.0, 0.0)] * len(each)))
        self._columns.render(axis_of_eye=of_each([(0.0, aspect) for aspect in each]))


def _along(coc: CocPasses, source: AnyTexture) -> FullscreenPass:
    return coc.make_pass(
        "separable_gaussian",
        {"source": source},
        filtered={"source"},
        defines={"REACH": GAUSSIAN_REACH},
        # Sigma is half a radius. The last pair of texels may begin beyond, and is read between two.
        reach_px=0.5 * GAUSSIAN_REACH * coc.max_radius_px + 3,
    )
