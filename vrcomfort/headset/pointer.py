"""The dot where somebody points on a panel: a small panel of its own, moved and never redrawn."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Pose, Quad

SIZE_PX = 32, 32
PANEL_SHARE = 0.02
"""Its diameter, of the panel's width: nearly a degree on a panel 45 degrees wide."""
LIFT_M = 0.002
"""So far before the panel, which it never hides behind."""

COLOUR, RIM = (255, 210, 80), (0, 0, 0)
RIM_SHARE = 0.3
"""Of its radius."""


@lru_cache(maxsize=1)
def pointer_picture() -> NDArray[np.uint8]:
    """Return (height, width, 4) pixels, sRGB with straight alpha: a disc with a dark rim."""
    width, height = SIZE_PX
    y, x = np.mgrid[:height, :width]
    radius_px = np.hypot(x - (width - 1) / 2, y - (height - 1) / 2)
    edge_px = width / 2 - 1
    picture = np.zeros((height, width, 4), np.uint8)
    inner = np.clip(edge_px * (1 - RIM_SHARE) - radius_px + 0.5, 0, 1)[..., None]
    picture[..., :3] = np.rint(inner * COLOUR + (1 - inner) * RIM)
    picture[..., 3] = np.rint(255 * np.clip(edge_px - radius_px + 0.5, 0, 1))
    picture.flags.writeable = False
    return picture


def pointer_quad(panel: Quad, point: tuple[float, float]) -> Quad:
    """Return where the pointer stands at the fractions (right, down) of a panel."""
    width_m, height_m = panel.size_m
    right, down = point
    place = Pose(np.array([(right - 0.5) * width_m, (0.5 - down) * height_m, LIFT_M]))
    return Quad(panel.pose @ place, (PANEL_SHARE * width_m, PANEL_SHARE * width_m))
