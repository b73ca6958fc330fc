"""Our cheapest kernel: everything but small discs is gathered at half resolution."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.conditional import ConditionalDraws
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, max_reduction
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.gpu.visible_area import DRAWN
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

BEHIND_PX = 8.0
"""What is blurred more, in front of the focus, is drawn apart, at up to half a plain frame."""

_SMALL = {"SMALL_FROM_PX": blur_kernels.SMALL_FROM_PX, "SMALL_PX": blur_kernels.SMALL_PX}


class HalfImage:
    """Half the image, and its tiles, in which near things are looked for: `LookedThrough`."""

    behind_px, beside = BEHIND_PX, 1  # half a texel of a tile may be near, and not seen in it

    def __init__(self, coc: CocPasses) -> None:
        self._coc, tile_px = coc, coc.tile_px
        self._finest = self._finest_pass()
        self.finest = self._finest.target
        """RGBA16F: ``half_surfaces.frag``."""
        self._find_tiles = self._tile_pass()
        self.tiles = self._find_tiles.target
        """RGBA16F: ``half_tiles.frag``."""
        # Nothing reaches farther than the widest disc of this image.
        self._widest = max_reduction(coc.ctx, self.tiles, texel_px=(tile_px, tile_px))
        self.reach = (
            {"widest": self._widest.target},
            {"TILE": tile_px, "MAX_RADIUS_PX": float(coc.max_radius_px), "WIDEST": 1},
        )
        self._if_wide = ConditionalDraws(coc.ctx, self._any_wide)
        self.has_classified = False
        self._ask = self._tile_pass(self.tiles, "HAS_WIDE_END", up_to="HAS_ALL")

    def find(self) -> None:
        """Halve the image of the last eyes, and find its tiles."""
        self._finest.render()
        self._find_tiles.render()
        self._widest.render()

    def look(self, classify: Callable[[], None]) -> None:
        """Find tiles, and classify them where something near ends whose disc is wide."""
        self.find()
        self._if_wide.ask(self._ask.render)
        self._if_wide.run(classify)

    def _any_wide(self) -> bool:
        kinds = np.frombuffer(self.tiles.read(), np.float16)[3::4]
        self.has_classified = bool((kinds >= _WIDE_END).any())
        return self.has_classified

    def again(self, classes: AnyTexture) -> list[Callable[[], None]]:
        """Return what halves the image again where what is behind near things was drawn."""
        finest = self._finest_pass(classes)
        tiles = self._tile_pass(classes, "BEHIND", beside=2, target=self.tiles)
        return [finest.render, tiles.render, self._widest.render]

    def _finest_pass(self, classes: AnyTexture | None = None) -> FullscreenPass:
        """Return the pass over all of the image, or what is behind near things."""
        coc = self._coc
        inputs, reach_px = {"finer": coc.colour_and_coc}, {"finer": 0.0, "dilated": DRAWN}
        if classes is None:
            return coc.make_pass(
                "half_surfaces", inputs, texel_px=2, defines=_SMALL, reach_px=reach_px
            )
        return coc.make_pass(
            "half_surfaces",
            {**inputs, "dilated": classes},
            texel_px=2,
            target=self.finest,
            defines={**_SMALL, **of_class("BEHIND", coc.tile_px // 2, beside=self.beside)},
            reach_px=reach_px,
            **on_tiles(classes),
        )

    def _tile_pass(
        self,
        classes: AnyTexture | None = None,
        name: str = "",
        *,
        up_to: str | None = None,
        beside: int = 0,
        target: AnyTexture | None = None,
    ) -> FullscreenPass:
        """Return the pass over all tiles, or those of a class."""
        coc = self._coc
        defines: dict[str, Any] = {"TILE": coc.tile_px // 2, "WIDE_PX": BEHIND_PX}
        inputs, reach_px = {"surfaces": self.finest}, {"surfaces": 2.0, "dilated": DRAWN}
        if classes is None:
            return coc.make_pass(
                "half_tiles", inputs, texel_px=coc.tile_px, defines=defines, reach_px=reach_px
            )
        defines |= of_class(name, 1, beside=beside)
        return coc.make_pass(
            "half_tiles",
            {**inputs, "dilated": classes},
            texel_px=coc.tile_px,
            defines={**defines, **({} if up_to is None else {"UP_TO": up_to})},
            target=target,
            reach_px=reach_px,
            **on_tiles(classes),
        )


_WIDE_END = shaders.constant("tile_classes.glsl", "HAS_WIDE_END")


class HalfGatherKernel:
    """Halves the image, gathers there, and sums small discs over pixels.

    Notes
    -----
    Half an image keeps one surface in each texel: of thin things before the focus some are lost.
    Tiles in focus are copied; tiles without small discs are half the image, enlarged. Where no
    depth discontinuity is within reach, discs are plain means.

    Parameters
    ----------
    image
        What is found before it is rendered; without it the kernel finds it.
    target
        Where the blurred image comes to be.
    """

    def __init__(
        self,
        coc: CocPasses,
        image: HalfImage | None = None,
        target: AnyTexture | None = None,
    ) -> None:
        self._coc, tile_px = coc, coc.tile_px
        self._image, self._finds = image or HalfImage(coc), image is None
        surfaces = [self._image.finest]
        self._coarser: list[FullscreenPass] = []
        for level in range(1, blur_kernels.half_gather_levels(coc.max_radius_px)):
            self._coarser.append(
                coc.make_pass(
                    "half_surfaces",
                    {"finer": surfaces[-1]},
                    texel_px=2 ** (level + 1),
                    defines={"FROM_SURFACES": 1},
                    reach_px=0.0,
                )
            )
            surfaces.append(self._coarser[-1].target)
        inputs, defines = self._image.reach
        self._dilate = coc.make_pass(
            "half_tile_dilate",
            {"tiles": self._image.tiles, **inputs},
            texel_px=tile_px,
            defines={**defines, "SLACK_PX": SLACK_PX},
            # Tiles that it touches count whole.
            reach_px={"tiles": coc.max_radius_px + SLACK_PX + 1},
        )
        surfaces_read = {"dilated": self._dilate.target, "surfaces": surfaces}
        levels = {
            **_SMALL,
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
        self.target = target or gl.eye_texture(coc.ctx, coc.size_px, coc.eyes)
        points, half = {"colour_and_coc": coc.colour_and_coc}, {"gathered": self._gather.target}
        both: Inputs = {**points, **half}
        self._sharp = self._composite(points, "in_focus", "IN_FOCUS")
        all_complete: dict[str, Any] = {"defines": {"ALL_COMPLETE": 1}, "filtered": set(half)}
        self._wide = [
            self._composite(half, "half_wide", "FAST_HALF_RESOLUTION", **all_complete),
            self._composite(half, "half_wide", "COMPLEX_HALF_RESOLUTION"),
        ]
        self._mixed = [
            self._composite(both, "half_fast", "FAST", defines=_SMALL, filtered=set(points)),
            self._composite(both, "half_mixed", "COMPLEX", defines=_SMALL, filtered=set(points)),
        ]

    def render(self, pixel_aspect: PixelAspect) -> None:
        """Blur the image of the last eye."""
        if self._finds:
            self._image.find()
        for each in self._coarser:
            each.render()
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
