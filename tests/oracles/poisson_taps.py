"""Depth of field by gathering: Poisson taps in a pixel's own circle of confusion.

NumPy twins, in float64, of ``poisson12.frag`` (Hillaire et al. 2008, Fig. 3) and
``poisson15_near*.frag`` (Mantiuk et al. 2011, section 4) in ``shaders/depth_of_field``. Images are
(h, w, 4) points: colour and signed radius in pixels of image width, negative in front of the focus.

Neither paper says how its textures are filtered. Colours are read bilinearly, as graphics cards do,
which is the better for the error of both kernels; radii are never averaged.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tests.oracles import pyramid
from vrcomfort.geometry import Array
from vrcomfort.optics.blur_kernels import (
    NEAR_LEVEL,
    POISSON_12,
    POISSON_15,
    ROTATIONS_PX,
    rotations,
)


def poisson12(
    points: ArrayLike,
    /,
    *,
    max_radius_px: float,
    pixel_aspect: float = 1.0,
    rotate_taps: bool = True,
) -> Array:
    """Return (h, w, 3) colours: own pixel and twelve taps, turned per pixel or not.

    Notes
    -----
    out = (c_p + Σ w_i c_i) / (1 + Σ w_i), where w_i is 1 for taps farther than p and their circle
    over the largest circle otherwise. The signed radius stands for depth.
    """
    image = np.asarray(points, dtype=np.float64)
    height, width, _ = image.shape
    repeats = (-(-height // ROTATIONS_PX), -(-width // ROTATIONS_PX), 1)
    turn = np.tile(rotations(), repeats)[:height, :width] if rotate_taps else np.array([1.0, 0.0])
    diameter_px = 2 * np.abs(image[..., 3])
    total = np.concatenate([image[..., :3], np.ones((height, width, 1))], axis=-1)
    for x, y in POISSON_12:
        turned = _turned(turn, x, y)
        away_px = diameter_px[..., None] * turned * [1.0, pixel_aspect]
        radius_px = _nearest(image[..., 3], away_px)
        blurred = np.minimum(np.abs(radius_px) / max(max_radius_px, 1e-6), 1.0)
        weight = np.where(radius_px > image[..., 3], 1.0, blurred)[..., None]
        colour = _bilinear(image[..., :3], away_px)
        total += weight * np.concatenate([colour, np.ones((height, width, 1))], axis=-1)
    colours: Array = total[..., :3] / total[..., 3:]
    return colours


def poisson15_near(
    points: ArrayLike, /, *, max_radius_px: float, pixel_aspect: float = 1.0
) -> Array:
    """Return (h, w, 3) colours: fifteen taps in circles of :func:`spread_radius_px`."""
    image = np.asarray(points, dtype=np.float64)
    mean = pyramid.magnified(near_mean_px(image[..., 3]), NEAR_LEVEL, image.shape[:2])
    radius_px = spread_radius_px(image[..., 3], mean, max_radius_px=max_radius_px)
    away_px = 2 * radius_px[..., None, None] * POISSON_15 * [1.0, pixel_aspect]
    taps = [_bilinear(image[..., :3], away_px[..., i, :]) for i in range(len(POISSON_15))]
    colours: Array = np.mean(taps, axis=0)
    return colours


def near_mean_px(radius_px: ArrayLike, /) -> Array:
    """Return the mean near radius of each cell of 8 × 8 pixels, positive."""
    near: Array = np.maximum(-np.asarray(radius_px, dtype=np.float64), 0.0)
    return pyramid.mean_level(near, NEAR_LEVEL)


def spread_radius_px(
    radius_px: ArrayLike, near_mean: ArrayLike, /, *, max_radius_px: float
) -> Array:
    """Return the (...,) radius to gather in, from a signed radius and the near mean around.

    Notes
    -----
    Mantiuk et al. 2011, Eq. 2, CoC = 2·max(CoC_o, CoC_b) − CoC_o, on the near circles ("duplicated
    and stored in two separate textures"), and the far circle where that is wider. It may exceed the
    largest circle beside a front; r_max holds here too.
    """
    signed = np.asarray(radius_px, dtype=np.float64)
    own = np.maximum(-signed, 0.0)
    near = 2 * np.maximum(own, near_mean) - own
    radius: Array = np.minimum(np.maximum(near, signed), max_radius_px)
    return radius


def _turned(turn: Array, x: float, y: float) -> Array:
    cosine, sine = np.moveaxis(turn, -1, 0)
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)


def _nearest(image: Array, away_px: Array) -> Array:
    """Return the (h, w, ...) texels in which (h, w, 2) offsets from each pixel's middle end."""
    height, width = image.shape[:2]
    rows, columns = np.mgrid[:height, :width] + 0.5
    column = np.clip(np.floor(columns + away_px[..., 0]), 0, width - 1).astype(int)
    row = np.clip(np.floor(rows + away_px[..., 1]), 0, height - 1).astype(int)
    found: Array = image[row, column]
    return found


def _bilinear(image: Array, away_px: Array) -> Array:
    """Return (h, w, n) means of the four texels around each offset, as :func:`_nearest`."""
    found = np.zeros_like(image)
    corner = np.floor(away_px)
    part = away_px - corner
    for step in np.ndindex(2, 2):
        share = np.where(step, part, 1 - part).prod(axis=-1)
        found += share[..., None] * _nearest(image, corner + step)
    return found
