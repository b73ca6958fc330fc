"""Blur by a MIP pyramid that is blown up again ("Four Tricks for Fast Blurring", 2001).

Trick three. NumPy twins, in float64, of ``shaders/common/mip_downsample.frag`` and
``shaders/depth_of_field/mip.frag``. Radii are in pixels.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array
from vrcomfort.optics.blur_kernels import pyramid_levels


def fade(radius_px: ArrayLike, level: int, /, *, slices: bool = False) -> Array:
    """Return (...,) opacities, from 0 to 1, of a level over the ones before it.

    Notes
    -----
    Level k has texels 2^k wide. Box and tent spread a point with a variance of 4^k/12 + 4^k/6 per
    axis, which is r²/4, that of a disc, at r = 2^k. Between levels opacity is linear in r², so the
    variance is the disc's at every radius. A slice's billboard stands at r = 2^(k − 1/2).
    """
    radius = np.asarray(radius_px, dtype=np.float64)
    if slices:
        return np.where(radius >= 2 ** (level - 0.5), 1.0, 0.0)
    sharper = 4.0 ** (level - 1) if level > 1 else 0.0
    return np.clip((radius**2 - sharper) / (4.0**level - sharper), 0.0, 1.0)


def mean_level(image: ArrayLike, level: int, /) -> Array:
    """Return (⌈h/2^k⌉, ⌈w/2^k⌉, ...) means of squares 2^k wide, or what of them is in the image."""
    pixels = np.asarray(image, dtype=np.float64)
    rows, columns = (range(0, size, 2**level) for size in pixels.shape[:2])
    side = 2**level
    return np.array(
        [[pixels[y : y + side, x : x + side].mean(axis=(0, 1)) for x in columns] for y in rows]
    )


def magnified(texels: ArrayLike, level: int, shape: tuple[int, int], /) -> Array:
    """Return (h, w, ...) texels of a level at full size, bilinear between their middles."""
    result = np.asarray(texels, dtype=np.float64)
    for axis, size in enumerate(shape):
        place = np.clip((np.arange(size) + 0.5) / 2**level - 0.5, 0, result.shape[axis] - 1)
        low = np.floor(place).astype(int)
        high = np.minimum(low + 1, result.shape[axis] - 1)
        part = (place - low).reshape([-1 if i == axis else 1 for i in range(result.ndim)])
        result = (1 - part) * result.take(low, axis) + part * result.take(high, axis)
    return result


def sliced(image: ArrayLike, distance_m: ArrayLike, slices_m: ArrayLike, /) -> Array:
    """Return (h, w, 3) colours behind billboards: level k covers what is behind the k-th."""
    shown, distance = np.asarray(image, dtype=np.float64), np.asarray(distance_m)
    sharp = shown
    for level, slice_m in enumerate(np.asarray(slices_m), start=1):
        billboard = magnified(mean_level(sharp, level), level, sharp.shape[:2])
        shown = np.where((distance >= slice_m)[..., None], billboard, shown)
    return shown


def mip(points: ArrayLike, /, *, max_radius_px: float, slices: bool = False) -> Array:
    """Return (h, w, 3) colours from the levels that fit each pixel's radius.

    Parameters
    ----------
    points
        (h, w, 4) colour and signed radius.
    """
    image = np.asarray(points, dtype=np.float64)
    shown, radius_px = image[..., :3], np.abs(image[..., 3])
    for level in range(1, pyramid_levels(max_radius_px) + 1):
        opacity = fade(radius_px, level, slices=slices)[..., None]
        billboard = magnified(mean_level(image[..., :3], level), level, image.shape[:2])
        shown = (1 - opacity) * shown + opacity * billboard
    return shown
