"""Our cheapest kernel: everything but small discs is gathered at half resolution."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import blur_kernels
from vrcomfort.render.effects.depth_of_field.coc_passes import (
    CocPasses,
    Inputs,
    PixelAspect,
    each_level,
)
from vrcomfort.render.effects.depth_of_field.layered_gather import of_class, on_tiles

FILL_PX = 4.0
"""How far from a texel in focus its surroundings are, in ``half_gather.frag``."""

SLACK_PX = 4.0
"""A tile's range of radii is of texels of two pixels, which are read between: so much farther
discs are expected to come."""


class HalfGatherKernel:
    """Halves the image, gathers there, and sums small discs over pixels.

    Notes
    -----
    Half an image keeps one surface in each texel: of thin things before the focus some are lost.
    Tiles in focus are copied; tiles without small discs are half the image, enlarged. Where no
    depth discontinuity is within reach, discs are plain means.
    """

    def __init__(self, coc: CocPasses) -> None:
        self._coc, tile_px = coc, coc.tile_px
        small = {
            "SMALL_FROM_PX": blur_kernels.SMALL_FROM_PX,
            "SMALL_PX": blur_kernels.SMALL_PX,
        }
        self._surfaces: list[FullscreenPass] = []
        for level in range(blur_kernels.half_gather_levels(coc.max_radius_px)):
            finer = self._surfaces[-1].target if level else coc.colour_and_coc
            self._surfaces.append(
                coc.make_pass(
                    "half_surfaces",
                    {"finer": finer},
                    texel_px=2 ** (level + 1),
                    defines={"FROM_SURFACES": 1} if level else small,
                    reach_px=0.0,
                )
            )
        surfaces = [each.target for each in self._surfaces]
        self._tiles = coc.make_pass(
            "half_tiles",
            {"surfaces": surfaces[0]},
            texel_px=tile_px,
            defines={"TILE": tile_px // 2},
            reach_px=0.0,
        )
        self._dilate = coc.make_pass(
            "half_tile_dilate",
            {"tiles": self._tiles.target},
            texel_px=tile_px,
            defines={
                "TILE": tile_px,
                "MAX_RADIUS_PX": float(coc.max_radius_px),
                "SLACK_PX": SLACK_PX,
            },
            reach_px=coc.max_radius_px + SLACK_PX + 1,  # tiles that it touches count whole
        )
        surfaces_read = {"dilated": self._dilate.target, "surfaces": surfaces}
        levels = {
            **small,
            "LEVELS": len(surfaces),
            "EACH_LEVEL(f)": each_level(0, len(surfaces)),
            "TEXELS_PER_PX": blur_kernels.HALF_TEXELS_PER_PX,
        }
        widest_px = max(coc.max_radius_px, FILL_PX)
        # Summed over texels of the coarsest level.
        reach_px = {"dilated": 0.0, "surfaces": widest_px + 2.0 ** (len(surfaces) + 1)}
        self._mean = coc.make_pass(
            "half_mean",
            surfaces_read,
            texel_px=2,
            defines={**levels, **_classes("IN_FOCUS", "FAST_HALF_RESOLUTION", tile_px // 2)},
            reach_px=reach_px,
            **on_tiles(self._dilate.target),
        )
        self._gather = coc.make_pass(
            "half_gather",
            surfaces_read,
            texel_px=2,
            target=self._mean.target,
            defines={
                **levels,
                **_classes("COMPLEX_HALF_RESOLUTION", "COMPLEX", tile_px // 2),
                "FILL_PX": FILL_PX,
            },
            reach_px=reach_px,
            **on_tiles(self._dilate.target),
        )
        self.target = gl.eye_texture(coc.ctx, coc.size_px, coc.eyes)
        points, half = {"colour_and_coc": coc.colour_and_coc}, {"gathered": self._gather.target}
        both: Inputs = {**points, **half}
        self._sharp = self._composite(points, "in_focus", "IN_FOCUS")
        all_complete: dict[str, Any] = {"defines": {"ALL_COMPLETE": 1}, "filtered": set(half)}
        self._wide = [
            self._composite(half, "half_wide", "FAST_HALF_RESOLUTION", **all_complete),
            self._composite(half, "half_wide", "COMPLEX_HALF_RESOLUTION"),
        ]
        self._mixed = [
            self._composite(both, "half_fast", "FAST", defines=small, filtered=set(points)),
            self._composite(both, "half_mixed", "COMPLEX", defines=small, filtered=set(points)),
        ]

    def render(self, pixel_aspect: PixelAspect) -> None:
        """Blur the image of the last eye."""
        for each in self._surfaces:
            each.render()
        self._tiles.render()
        self._dilate.render(pixel_aspect_of_eye=pixel_aspect)
        self._mean.render(pixel_aspect_of_eye=pixel_aspect)
        self._gather.render(pixel_aspect_of_eye=pixel_aspect)
        self._sharp.render()
        for wide in self._wide:
            wide.render()
        for mixed in self._mixed:
            mixed.render(pixel_aspect_of_eye=pixel_aspect)

    def _composite(
        self,
        inputs: Inputs,
        fragment: str,
        name: str,
        *,
        defines: Mapping[str, Any] | None = None,
        **options: Any,
    ) -> FullscreenPass:
        """Return the pass that draws the tiles of a class."""
        # Discs up to SMALL_PX are summed from pixels; all is read between two, or two texels.
        reach_px = {"colour_and_coc": blur_kernels.SMALL_PX + 1, "gathered": 2.0, "dilated": 0.0}
        return self._coc.make_pass(
            fragment,
            {**inputs, "dilated": self._dilate.target},
            defines={**(defines or {}), **of_class(name, self._coc.tile_px, beside=0)},
            target=self.target,
            reach_px=reach_px,
            **on_tiles(self._dilate.target),
            **options,
        )


def _classes(first: str, last: str, point_px: int) -> dict[str, Any]:
    """Return the defines of ``tiles_of_class.vert`` for classes that follow each other."""
    return {**of_class(first, point_px, beside=0), "UP_TO": last}
