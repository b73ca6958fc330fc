"""Parts of an eye's image that are drawn alone, and show what the whole image would show there.

At a headset's size a reference of the whole image takes too long without a GPU. A window is drawn
with a frustum of its own, on the pixel grid of the whole image, and wider than what is judged: by
as far as any disc reaches. Its corner is a multiple of :data:`ALIGNED_PX`, so that tiles and
half-resolution texels lie where they would lie in the whole image.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, View
from vrcomfort.protocol.conditions import Condition

ALIGNED_PX = 32
"""Side of the widest tile (and of a texel of the coarsest mip level) that is kept in place."""

SLACK_PX = 16
"""How much farther than the widest disc a method may look: half a tile, or a bilinear read."""

HEADSET_PX = (1832, 1920)
"""The whole image that the windows of :data:`WINDOWS` are parts of."""

WINDOW_POSES = 2
"""Places of each walk, of which :data:`WINDOWS` has parts."""


@dataclass(frozen=True)
class Window:
    """A rectangle of a whole image, in pixels from its lower left corner.

    Parameters
    ----------
    name
        What is to be seen there.
    left_px, bottom_px, width_px, height_px
        What is judged.
    """

    name: str
    left_px: int
    bottom_px: int
    width_px: int
    height_px: int

    def drawn(self, whole_px: tuple[int, int], reach_px: float) -> Window:
        """Return what is drawn so that the judged part sees everything up to `reach_px` away.

        It ends where the whole image ends, for what lies outside nobody's post-process sees.
        """
        wider = math.ceil((reach_px + SLACK_PX) / ALIGNED_PX) * ALIGNED_PX
        left, bottom = max(0, self.left_px - wider), max(0, self.bottom_px - wider)
        right = min(whole_px[0], self.left_px + self.width_px + wider)
        top = min(whole_px[1], self.bottom_px + self.height_px + wider)
        return replace(
            self, left_px=left, bottom_px=bottom, width_px=right - left, height_px=top - bottom
        )

    @property
    def size_px(self) -> tuple[int, int]:
        """Return (width, height)."""
        return self.width_px, self.height_px

    def within(self, other: Window) -> tuple[slice, slice]:
        """Return where it lies in images of another window: slices of rows and of columns."""
        left, bottom = self.left_px - other.left_px, self.bottom_px - other.bottom_px
        return slice(bottom, bottom + self.height_px), slice(left, left + self.width_px)


WINDOWS: dict[tuple[str, int], tuple[Window, ...]] = {
    ("temple", 0): (
        Window("near_rims", 224, 1056, 448, 448),
        Window("far_edges", 1216, 608, 616, 512),
    ),
    ("temple", 1): (Window("lamps", 512, 768, 448, 448),),
    ("mountain", 0): (
        Window("near_rims", 64, 1440, 448, 448),
        Window("thin", 1152, 1056, 448, 448),
    ),
    ("mountain", 1): (),
}
"""By scene and place on its walk, parts of the left eye's image of :data:`HEADSET_PX`: blurred
fronts over what is behind, far edges up to the image's border, lamps, thin things."""


def through(frame: Frame, window: Window, whole_px: tuple[int, int]) -> Frame:
    """Return the frame with frusta that see only the window, in both eyes."""
    left, right = (View(view.pose, sub_frustum(view.fov, window, whole_px)) for view in frame.views)
    return replace(frame, views=(left, right))


def sub_frustum(fov: Fov, window: Window, whole_px: tuple[int, int]) -> Fov:
    """Return the frustum of a part of an image: tangents are linear in pixels."""
    left, right, up, down = fov.tangents
    wide, tall = (right - left) / whole_px[0], (up - down) / whole_px[1]
    return Fov(
        math.atan(left + window.left_px * wide),
        math.atan(left + (window.left_px + window.width_px) * wide),
        math.atan(down + (window.bottom_px + window.height_px) * tall),
        math.atan(down + window.bottom_px * tall),
    )


def of_part(condition: Condition, part: float) -> Condition:
    """Return the condition that blurs an image by as many pixels as one `part` times as wide.

    Percentages of the image's width grow, beyond what a protocol may ask for.
    """
    changes = {}
    for name in ("depth_of_field", "motion_blur"):
        settings = getattr(condition, name)
        if settings is not None:
            percent = settings.max_radius_percent / part
            changes[name] = settings.model_copy(update={"max_radius_percent": percent})
    return condition.model_copy(update=changes)
