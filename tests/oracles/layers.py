"""Depth of field by gathering a back and a front layer, every pixel of every disc.

NumPy twin, in float64, of what ``shaders/depth_of_field/composite.frag`` does with discs
that are summed over pixels (`levels.exact_px`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from tests.oracles.gather import disc_share, grid_radius_px, nearer, slack_px
from vrcomfort.geometry import Array

SHARP_PX = 0.5
"""Discs up to this radius are the pixel itself."""


def layered(points: ArrayLike, /, *, pixel_aspect: float = 1.0) -> Array:
    """Return (h, w, 3) colours: a front that adds up to an opacity of 1 at most, over a back.

    Parameters
    ----------
    points
        (h, w, 4) colour and signed radius in pixels of image width, negative in front of the focus.
    pixel_aspect
        Image pixels per unit, vertical over horizontal.

    Notes
    -----
    The back is the mean over a pixel's own disc of its surface and those behind; what is of its
    surface counts with its own disc, :func:`as_own_px`. That of a sharp pixel is the pixel. Beyond
    the image its rim goes on.
    """
    image = np.asarray(points, dtype=np.float64)
    reach_px = float(np.abs(image[..., 3]).max()) + 1
    back, front = (np.zeros_like(image) for _ in range(2))
    rows = int(reach_px * pixel_aspect)
    for y in range(-rows, rows + 1):
        for x in range(-int(reach_px), int(reach_px) + 1):
            behind, over = _shares(image, x, y, pixel_aspect)
            back += behind
            front += over / (math.pi * pixel_aspect)
    opacity = front[..., 3:]
    colours = front[..., :3] / np.where(opacity > 0, opacity, 1)
    mixed: Array = back[..., :3] / back[..., 3:]
    return mixed + np.minimum(opacity, 1) * (colours - mixed)


def as_own_px(own_px: ArrayLike, other_px: ArrayLike, /) -> Array:
    """Return the radius over which a point behind or beside another, of `own_px`, is gathered.

    Both radii are positive. It is the other one's as far as that may be of the same surface.
    """
    own, slack = np.asarray(own_px, dtype=np.float64), slack_px(own_px)
    radius: Array = np.clip(np.asarray(other_px), own - slack, own + slack)
    return radius


def _shares(image: Array, x: int, y: int, pixel_aspect: float) -> tuple[Array, Array]:
    """Return what the pixel that is x to the right and y up adds to every back and front."""
    height, width, _ = image.shape
    up = np.clip(np.arange(height) + y, 0, height - 1)
    right = np.clip(np.arange(width) + x, 0, width - 1)
    q = image[up][:, right]
    is_front = nearer(image[..., 3], q[..., 3])
    own, radius = np.abs(image[..., 3]), np.abs(q[..., 3])
    radius = as_own_px(own, radius) * (1 - is_front) + radius * is_front
    share = disc_share(math.hypot(x, y / pixel_aspect), grid_radius_px(radius))
    light = np.concatenate([q[..., :3], np.ones((height, width, 1))], axis=-1)
    behind = np.where(own > SHARP_PX, share, x == y == 0) * (1 - is_front)
    return behind[..., None] * light, (is_front * share)[..., None] * light
