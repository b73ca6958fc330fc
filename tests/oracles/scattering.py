"""Depth of field by scattering: every pixel over its disc (Carnegie & Rhee 2015, Algorithm 1).

NumPy twin, in float64, of ``shaders/depth_of_field/scatter.*`` and ``scatter_mean.frag``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tests.oracles.circle_of_confusion import disc_area_px, disc_weight
from vrcomfort.geometry import Array

SHARP_PX = 0.5
"""A disc of this radius covers its own pixel only."""


def scatter(points: ArrayLike, /, *, pixel_aspect: float = 1.0) -> Array:
    """Return (h, w, 3) colours after every pixel was spread over its disc.

    Parameters
    ----------
    points
        (h, w, 4) colour and signed radius in pixels of image width.
    pixel_aspect
        Image pixels per unit, vertical over horizontal.

    Notes
    -----
    The weights of a disc are its coverage over its area, about 1 in sum; a pixel's colour is the
    sum of what arrives over the sum of the weights. No pixel hides another.
    """
    image = np.asarray(points, dtype=np.float64)
    shares = np.zeros_like(image)
    for y, x in np.ndindex(image.shape[:2]):
        weight = _weights(image.shape[:2], (y, x), abs(image[y, x, 3]), pixel_aspect)
        shares += weight[..., None] * [*image[y, x, :3], 1.0]
    colours: Array = shares[..., :3] / shares[..., 3:]
    return colours


def _weights(
    shape: tuple[int, ...], pixel: tuple[int, int], radius_px: float, pixel_aspect: float
) -> Array:
    """Return the (h, w) weights of one pixel's disc."""
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    if radius_px <= SHARP_PX:
        own: Array = ((rows == pixel[0]) & (columns == pixel[1])).astype(np.float64)
        return own
    distance_px = np.hypot((rows - pixel[0]) / pixel_aspect, columns - pixel[1])
    area_px = np.maximum(disc_area_px(radius_px) * pixel_aspect, 1.0)
    weights: Array = disc_weight(distance_px, radius_px) / area_px
    return weights
