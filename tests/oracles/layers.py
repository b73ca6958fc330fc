"""Depth of field by gathering a back and a front layer, every pixel of every disc.

NumPy twin, in float64, of what ``shaders/depth_of_field/complex.frag`` does with discs
that are summed over pixels (`levels.exact_px`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tests.oracles.gather import (
    disc_share,
    farther,
    grid_radius_px,
    margin_px,
    nearer,
    slack_px,
)
from vrcomfort.geometry import Array

SHARP_PX = 0.5
"""Discs up to this radius are the pixel itself."""
WIDE_NEAR_PX = 2.0
"""In front of the focus, up to this radius what is behind has its own discs."""


def layered(points: ArrayLike, /, *, pixel_aspect: float = 1.0) -> Array:
    """Return (h, w, 3) colours: a front that adds up to an opacity of 1 at most, over the others.

    Parameters
    ----------
    points
        (h, w, 4) colour and signed radius in pixels of image width, negative in front of the focus.
    pixel_aspect
        Image pixels per unit, vertical over horizontal.

    Notes
    -----
    A pixel's own surface covers a part of its disc; what is of it counts with its own disc,
    :func:`as_own_px`. What is behind fills the rest: :func:`radius_behind_px`. A sharp pixel is
    itself. Beyond the image its rim goes on.
    What is behind is no wider than the widest disc that is seen past the silhouette.
    """
    image = np.asarray(points, dtype=np.float64)
    reach_px = float(np.abs(image[..., 3]).max()) + 1
    surface, behind, front = (np.zeros_like(image) for _ in range(3))
    free, widest = (np.zeros(image.shape[:2]) for _ in range(2))
    rows = int(reach_px * pixel_aspect)
    around = [
        (x, y) for y in range(-rows, rows + 1) for x in range(-int(reach_px), int(reach_px) + 1)
    ]
    for x, y in around:
        added = _shares(image, x, y, pixel_aspect)
        surface += added.surface
        free += added.free
        widest = np.where(added.free > 0, np.maximum(widest, added.radius), widest)
        front += added.front / (math.pi * pixel_aspect)
    for x, y in around:
        added = _shares(image, x, y, pixel_aspect)
        seen = np.clip((widest - added.radius) / margin_px(widest) + 2, 0, 1)
        behind += seen[..., None] * added.behind
    free = free[..., None]
    own = surface / (surface[..., 3:] + free)
    means = behind[..., :3] / np.where(behind[..., 3:] > 0, behind[..., 3:], 1)
    mixed = own[..., :3] + (1 - own[..., 3:]) * means
    opacity = front[..., 3:]
    colours = front[..., :3] / np.where(opacity > 0, opacity, 1)
    found: Array = mixed + np.minimum(opacity, 1) * (colours - mixed)
    return found


def as_own_px(own_px: ArrayLike, other_px: ArrayLike, /) -> Array:
    """Return the radius over which a point behind or beside another, of `own_px`, is gathered.

    Both radii are positive. It is the other one's as far as that may be of the same surface.
    """
    own, slack = np.asarray(own_px, dtype=np.float64), slack_px(own_px)
    radius: Array = np.clip(np.asarray(other_px), own - slack, own + slack)
    return radius


def radius_behind_px(own_px: ArrayLike, other_px: ArrayLike, /) -> Array:
    """Return the radius over which a point behind another is gathered, from signed radii.

    Its own, or the nearer one's if that is wider. From 2 to 3 px in front of the focus the nearer
    one's takes over: there the lens sees what that hides.
    """
    own, other = np.asarray(own_px, dtype=np.float64), np.asarray(other_px, dtype=np.float64)
    wide = np.clip(-own - WIDE_NEAR_PX, 0, 1)
    wider = np.maximum(np.abs(other), np.abs(own))
    radius: Array = wider + wide * (np.abs(own) - wider)
    return radius


class _Added(NamedTuple):
    """What a neighbour adds, light and weight, (h, w, 4); of `free` the weight, (h, w).

    `radius` is that of :func:`radius_behind_px`.
    """

    radius: Array
    surface: Array
    free: Array
    behind: Array
    front: Array


def _shares(image: Array, x: int, y: int, pixel_aspect: float) -> _Added:
    """Return what the pixel that is x to the right and y up adds to every pixel."""
    height, width, _ = image.shape
    up = np.clip(np.arange(height) + y, 0, height - 1)
    right = np.clip(np.arange(width) + x, 0, width - 1)
    q = image[up][:, right]
    p_px, q_px = image[..., 3], q[..., 3]
    is_front, is_behind = nearer(p_px, q_px), farther(p_px, q_px)
    away = math.hypot(x, y / pixel_aspect)
    own, radius = np.abs(p_px), np.abs(q_px)
    radius = as_own_px(own, radius) * (1 - is_front) + radius * is_front
    share = disc_share(away, grid_radius_px(radius))
    under = np.where(own > SHARP_PX, share, x == y == 0)
    behind_px = radius_behind_px(p_px, q_px)
    past = is_behind * disc_share(away, grid_radius_px(behind_px))
    light = np.concatenate([q[..., :3], np.ones((height, width, 1))], axis=-1)
    return _Added(
        behind_px,
        (under * (1 - is_front - is_behind))[..., None] * light,
        under * is_behind,
        past[..., None] * light,
        (is_front * share)[..., None] * light,
    )
