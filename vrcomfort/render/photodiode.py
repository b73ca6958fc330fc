"""A patch in a corner of both images, for a photodiode that measures when frames are seen.

It is drawn after tone mapping: full black or full white, whatever the condition does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import moderngl

from vrcomfort.geometry import Fov
from vrcomfort.protocol.viewing import Photodiode

Rectangle = tuple[int, int, int, int]
"""Left, bottom, width and height in px; rows count from the bottom, as on the GPU."""


@dataclass
class PatchLight:
    """Whether the patch is white in the frames of one exposure, as they are drawn."""

    settings: Photodiode
    _first_ns: int | None = None
    _drawn: int = field(default=0)

    @property
    def has_begun(self) -> bool:
        """Whether a frame was drawn."""
        return self._first_ns is not None

    def of_next(self, display_ns: int) -> bool:
        """Return whether it is white in the next frame that is drawn."""
        if self._first_ns is None:
            self._first_ns = display_ns
        count, self._drawn = self._drawn, self._drawn + 1
        if self.settings.white == "every_other_frame":
            return count % 2 == 0
        return display_ns - self._first_ns < self.settings.onset_s * 1e9


class PatchPainter:
    """Paints the patch onto the images that displays get.

    Parameters
    ----------
    images
        RGBA8 of each eye that is drawn.
    """

    def __init__(
        self, ctx: moderngl.Context, settings: Photodiode, images: tuple[moderngl.Texture, ...]
    ) -> None:
        self._settings = settings
        self._targets = [ctx.framebuffer([image]) for image in images]

    def paint(self, fovs: tuple[Fov, ...], *, white: bool) -> None:
        """Paint it onto the present images, which have these frusta."""
        light = float(white)
        for target, fov in zip(self._targets, fovs, strict=False):
            place = patch_place(self._settings, fov, target.size)
            target.clear(light, light, light, 1.0, viewport=place)


def patch_place(settings: Photodiode, fov: Fov, size_px: tuple[int, int]) -> Rectangle:
    """Return where the patch is in an image.

    Along each axis it begins `inset_deg` from the edge of the field and is `size_deg` long, both as
    angles from the eye in that axis.
    """
    vertical, _, horizontal = settings.corner.partition("_")
    left, width = _span(settings, fov.left, fov.right, size_px[0], near_low=horizontal == "left")
    bottom, height = _span(settings, fov.down, fov.up, size_px[1], near_low=vertical == "lower")
    return left, bottom, width, height


def _span(
    settings: Photodiode, low: float, high: float, size_px: int, *, near_low: bool
) -> tuple[int, int]:
    """Return where the patch begins along an axis, and how long it is; at least a pixel."""
    inset, length = math.radians(settings.inset_deg), math.radians(settings.size_deg)
    start = low + inset if near_low else high - inset - length
    ends = (min(max(angle, low), high) for angle in (start, start + length))
    width = math.tan(high) - math.tan(low)
    first, last = (round((math.tan(end) - math.tan(low)) / width * size_px) for end in ends)
    first = min(first, size_px - 1)
    return first, max(last - first, 1)
