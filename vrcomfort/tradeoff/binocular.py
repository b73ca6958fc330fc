"""Errors that only two eyes have: what one eye gets wrong otherwise than the other.

Images are (h, w, …) with the bottom row first; a place on an image is (x, y) in pixel indices, so
that (0, 0) is the centre of the lower left pixel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Fov, Pose, focal_length_px, principal_point_px, rotate

DEPTH_TOLERANCE = 0.02
"""Relative difference of 1 / distance below which both eyes see the same surface."""


class Eye(NamedTuple):
    """Where an eye is (in any frame both eyes share), its frustum, and its reverse-Z depth."""

    pose: Pose
    fov: Fov
    depth: NDArray[np.floating]
    near_m: float


class Correspondence(NamedTuple):
    """Where the right eye sees what the left eye's pixels see.

    Parameters
    ----------
    left
        (n, 2) integer pixels (column, row) of the left image that the right eye sees too.
    right
        (n, 2) places on the right image.
    """

    left: NDArray[np.intp]
    right: Array

    def here(self, image: NDArray[np.floating]) -> Array:
        """Return (n, …) values of either image at the left image's pixels."""
        values: Array = np.asarray(image, np.float64)[self.left[:, 1], self.left[:, 0]]
        return values

    def there(self, image: NDArray[np.floating]) -> Array:
        """Return (n, …) values of the right image's nearest pixels.

        Not interpolated: that would average the noise away that is to be measured.
        """
        column, row = np.rint(self.right).astype(np.intp).T
        values: Array = np.asarray(image, np.float64)[row, column]
        return values

    def smoothly_there(self, image: NDArray[np.floating]) -> Array:
        """Return (n, …) values of the right image, bilinear."""
        return _bilinear(np.asarray(image, np.float64), self.right)


class Binocular(NamedTuple):
    """Binocular errors of a pair of images."""

    rivalry: float
    """Mean of \\|e_L(x) − e_R(x + d)\\| over what both eyes see."""
    shower_door: float
    """corr(e_L(x), e_R(x)) − corr(e_L(x), e_R(x + d)): +1 sticks to the screen, −1 to surfaces."""


def correspondence(left: Eye, right: Eye, *, margin_px: int = 0) -> Correspondence:
    """Find what both eyes see, from their depths; pixels within `margin_px` of a rim are left out.

    Without turned eyes and frusta that differ, a point at distance z moves by −focal_px · IPD / z.
    """
    height, width = left.depth.shape
    row, column = np.mgrid[margin_px : height - margin_px, margin_px : width - margin_px]
    pixels = np.stack([column.ravel(), row.ravel()], axis=-1)
    seen = left.depth[pixels[:, 1], pixels[:, 0]].astype(np.float64)
    place, depth = _project(_directions(left, pixels), seen / left.near_m, left, right)
    last = np.array([width - 1 - margin_px, height - 1 - margin_px])
    inside = np.all((place >= margin_px) & (place <= last), axis=-1)
    pixels, place, depth = pixels[inside], place[inside], depth[inside]
    # Reverse-Z depth is affine on a plane's image, so that a bilinear read of it is right.
    found = _bilinear(right.depth.astype(np.float64), place) / right.near_m
    same = np.abs(found - depth) <= DEPTH_TOLERANCE * np.maximum(found, depth)
    return Correspondence(pixels[same], place[same])


def binocular_error(pairs: Correspondence, left: Array, right: Array) -> Binocular:
    """Return the errors of two (h, w, 3) error images, each test less reference."""
    own, same, there = pairs.here(left), pairs.here(right), pairs.there(right)
    if not len(own):
        return Binocular(float("nan"), float("nan"))
    return Binocular(
        rivalry=float(np.mean(np.abs(own - there))),
        shower_door=_correlation(own, same) - _correlation(own, there),
    )


def radius_mismatch_px(pairs: Correspondence, left: Array, right: Array) -> float:
    """Return the mean of |CoC_L(x) − CoC_R(x + d)| of two (h, w) images of radii."""
    if not len(pairs.left):
        return float("nan")
    return float(np.mean(np.abs(pairs.here(left) - pairs.smoothly_there(right))))


def _correlation(a: Array, b: Array) -> float:
    """Return Pearson's correlation; 0 where one of them does not vary."""
    a, b = a - a.mean(), b - b.mean()
    power = float(np.sum(a * a)) * float(np.sum(b * b))
    return float(np.sum(a * b)) / power**0.5 if power > 0 else 0.0


def _directions(eye: Eye, pixels: NDArray[np.intp]) -> Array:
    """Return (n, 3) points in the eye's frame, at a distance of 1 along its axis."""
    size_px = eye.depth.shape[1], eye.depth.shape[0]
    focal, center = focal_length_px(eye.fov, size_px), principal_point_px(eye.fov, size_px)
    tangent = (pixels + 0.5 - np.array(center)) / np.array(focal)
    return np.column_stack([tangent, np.full(len(pixels), -1.0)])


def _project(direction: Array, inverse_m: Array, source: Eye, target: Eye) -> tuple[Array, Array]:
    """Return (n, 2) places and (n,) 1 / distance in the target of points of the source.

    In homogeneous coordinates, position + direction / inverse_m is direction + position·inverse_m:
    the sky needs no infinite distance.
    """
    target_from_source = target.pose.inverse() @ source.pose
    point = rotate(target_from_source.orientation, direction)
    point = point + target_from_source.position * inverse_m[:, None]
    ahead = np.maximum(-point[:, 2:], 1e-9)
    size_px = target.depth.shape[1], target.depth.shape[0]
    focal, center = focal_length_px(target.fov, size_px), principal_point_px(target.fov, size_px)
    place = point[:, :2] / ahead * np.array(focal) + np.array(center) - 0.5
    return place, inverse_m / ahead[:, 0]


def _bilinear(image: Array, place: Array) -> Array:
    height, width = image.shape[:2]
    x0 = np.clip(np.floor(place[:, 0]).astype(np.intp), 0, max(width - 2, 0))
    y0 = np.clip(np.floor(place[:, 1]).astype(np.intp), 0, max(height - 2, 0))
    x1, y1 = np.minimum(x0 + 1, width - 1), np.minimum(y0 + 1, height - 1)
    shape = (-1, *[1] * (image.ndim - 2))
    u, v = (place[:, 0] - x0).reshape(shape), (place[:, 1] - y0).reshape(shape)
    below = image[y0, x0] * (1 - u) + image[y0, x1] * u
    above = image[y1, x0] * (1 - u) + image[y1, x1] * u
    mixed: Array = below * (1 - v) + above * v
    return mixed
