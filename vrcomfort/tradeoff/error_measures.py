"""Errors that a mean over the image hides: by region, finer than blur, over time, between eyes.

Regions follow from the pinhole image alone, its depth, its radii and its light:

============== =====================================================================================
one_surface    blurred, and no edge, thin object or lamp within its blur
near_rims      within the disc of a surface in front of the focus, at its silhouette edge: the
               background shows through
far_edges      beside something that is not in front of the focus, within the disc of a farther,
               blurred surface; no near rim
thin           narrower than `THIN_PART` of the whole image's width, as far as their discs go
lamps          light of more than `LAMP` (display white is 1), as far as its discs go
in_focus       radius of at most `SHARP_PX`, where no disc of something nearer reaches
============== =====================================================================================

Images are (h, w, …) with the bottom row first; a place on an image is (x, y) in pixel indices, so
that (0, 0) is the centre of the lower left pixel.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import (
    distance_transform_edt,
    gaussian_filter,
    grey_opening,
    median_filter,
    minimum_filter,
)

from vrcomfort.geometry import Array, Fov, Pose, focal_length_px, principal_point_px, rotate
from vrcomfort.tradeoff.image_error import LUMINANCE

Mask = NDArray[np.bool_]

REGIONS = ("one_surface", "near_rims", "far_edges", "thin", "lamps", "in_focus", "image_border")

SHARP_PX = 0.5
"""A disc of this radius is a pixel."""

EDGE = 0.05
"""Step of 1 / distance, in parts of the nearer one's, that is no slant but an edge."""

THIN_PART = 0.01
LAMP = 2.0

LEVELS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 96, 128, 192)
"""Reaches are rounded up to these pixels: a distance transform each."""


class PinholeView(NamedTuple):
    """Depth, radii and light of a view's pinhole image, bottom row first.

    Parameters
    ----------
    depth
        (h, w) reverse-Z depth: near / distance.
    radius_px
        (h, w) signed radius of the circle of confusion, negative in front of the focus.
    light
        (h, w, 3) linear light times the exposure: display white is 1.
    whole_width_px
        Width of the image of which this may be a part.
    """

    depth: NDArray[np.floating]
    radius_px: Array
    light: NDArray[np.floating]
    whole_width_px: int


def regions(seen: PinholeView) -> dict[str, Mask]:
    """Return (h, w) masks by name, without the image's border; apart from two they may overlap.

    `one_surface` and `in_focus` overlap with none.
    """
    radius = np.abs(seen.radius_px)
    rims, far = _edges(seen)
    near_rims = within(rims)
    found = {
        "near_rims": near_rims,
        "far_edges": within(far) & ~near_rims,
        "thin": within(np.where(_thin(seen), radius + 1, 0)),
        "lamps": within(np.where(seen.light.max(axis=-1) > LAMP, radius + 1, 0)),
    }
    taken = np.any(list(found.values()), axis=0)
    in_front = np.where(seen.radius_px < -SHARP_PX, radius, 0)
    sharp = (radius <= SHARP_PX) & ~within(in_front) & ~taken
    return {"one_surface": (radius > SHARP_PX) & ~taken, **found, "in_focus": sharp}


def border(shape: tuple[int, int], sides: tuple[bool, bool, bool, bool], wide_px: int) -> Mask:
    """Return the (h, w) pixels that are within `wide_px` of a side of the whole image.

    Parameters
    ----------
    sides
        Whether left, right, bottom and top of this part are sides of the whole.
    """
    found = np.zeros(shape, dtype=bool)
    left, right, bottom, top = (wide_px if side else 0 for side in sides)
    height, width = shape
    found[:, :left] = found[:, width - right :] = True
    found[:bottom] = found[height - top :] = True
    return found


def within(reach_px: NDArray[np.floating]) -> Mask:
    """Return where some pixel is at most as far away as its own (h, w) reach; 0 reaches nothing."""
    found = np.zeros(reach_px.shape, dtype=bool)
    rounded = np.select(
        [(reach_px > 0) & (reach_px <= level) for level in LEVELS], LEVELS, default=0
    )
    rounded = np.where(reach_px > LEVELS[-1], math.ceil(reach_px.max(initial=0)), rounded)
    for level in np.unique(rounded[rounded > 0]):
        found |= distance_transform_edt(rounded != level) <= level
    return found


def _edges(seen: PinholeView) -> tuple[Array, Array]:
    """Return how far blur reaches from near rims and from far edges, 0 where there is none."""
    rims, far = np.zeros(seen.depth.shape), np.zeros(seen.depth.shape)
    for axis in (0, 1):
        depth = np.moveaxis(seen.depth.astype(np.float64), axis, 0)
        radius = np.moveaxis(seen.radius_px, axis, 0)
        edge, step = _is_edge(depth), np.diff(depth, axis=0)
        ours = np.where(step > 0, radius[1:], radius[:-1])  # of the nearer side
        theirs = np.where(step > 0, radius[:-1], radius[1:])
        is_rim = edge & (ours < -SHARP_PX)
        is_far = edge & ~is_rim & (theirs > SHARP_PX)
        for reaches, reach in (
            (rims, np.where(is_rim, np.abs(ours) + 1, 0)),
            (far, np.where(is_far, theirs + 1, 0)),
        ):
            both = np.moveaxis(reaches, axis, 0)  # a view: both pixels of a pair get it
            both[1:] = np.maximum(both[1:], reach)
            both[:-1] = np.maximum(both[:-1], reach)
    return rims, far


def _is_edge(depth: Array) -> Mask:
    """Return between which rows (h − 1) there is an edge.

    Reverse-Z depth is affine on a plane's image: a step is an edge where it is unlike both steps
    beside it, which a slanted plane's is not.
    """
    step = np.diff(depth, axis=0)
    before, after = np.roll(step, 1, axis=0), np.roll(step, -1, axis=0)
    before[0], after[-1] = after[0], before[-1]
    unlike = np.minimum(np.abs(step - before), np.abs(step - after))
    nearer = np.maximum(depth[1:], depth[:-1])
    found: Mask = unlike > EDGE * nearer
    return found


def _thin(seen: PinholeView) -> Mask:
    """Return the pixels that an opening of the depth with a square removes."""
    side = max(3, round(THIN_PART * seen.whole_width_px) // 2 * 2 + 1)
    without = grey_opening(seen.depth.astype(np.float64), size=(side, side))
    found: Mask = seen.depth - without > EDGE * seen.depth
    return found


def region_errors(error: Array, masks: dict[str, Mask], known: Mask) -> dict[str, float | None]:
    """Return the RMS of an (h, w, 3) error in each region, and how many pixels that is.

    Parameters
    ----------
    masks
        (h, w) by name, those of :data:`REGIONS`.
    known
        (h, w): where the reference is sure; the others do not count.
    """
    found: dict[str, float | None] = {}
    for name in REGIONS:
        counted = masks[name] & known
        found[f"{name}_rms"] = _rms(error[counted])
        found[f"{name}_px"] = int(counted.sum())
    found["seams"] = _rms(high_pass(error)[masks["far_edges"] & known])
    return found


def _rms(values: Array) -> float | None:
    return math.sqrt(float(np.mean(values**2))) if len(values) else None


HIGH_PASS_PX = 1.0
"""Standard deviation of the Gaussian that is subtracted: the rest is finer than blur."""

WIDE_PX, WIDE_SIDE_PX = 10.0, 41
"""Where the radius is above the first over a square of the second, nothing fine can be right."""

MEDIAN_SIDE_PX = 5
STEP = 1 / 255
"""Of a display."""


class OffMedian(NamedTuple):
    """Pixels that stand out where everything is wide blur."""

    wide_px: int
    """How many pixels were looked at."""
    over_2: int
    """Off the median around them by more than 2/255."""
    over_4: int


def high_pass(error: ArrayLike) -> Array:
    """Return an (h, w, 3) error less its Gaussian mean: lines and beads, not soft errors."""
    image = np.asarray(error, dtype=np.float64)
    soft: Array = gaussian_filter(image, (HIGH_PASS_PX, HIGH_PASS_PX, 0))
    return image - soft


def off_median(
    shown: NDArray[np.floating],
    radius_px: NDArray[np.floating],
    judged: tuple[slice, slice] = (slice(None), slice(None)),
) -> OffMedian:
    """Count pixels of an (h, w, 3) image of display values in [0, 1] that are off their median.

    In luminance, against the median of the 5×5 pixels around, where the radius is above
    :data:`WIDE_PX` over 41×41 pixels: no such blur has anything so fine.

    Parameters
    ----------
    judged
        Slices of rows and columns in which pixels are counted; others only serve as neighbours.
    """
    wide = minimum_filter(np.abs(radius_px), WIDE_SIDE_PX, mode="nearest")[judged] > WIDE_PX
    light = np.asarray(shown, dtype=np.float32) @ LUMINANCE.astype(np.float32)
    off = np.abs(light - median_filter(light, MEDIAN_SIDE_PX))[judged][wide]
    return OffMedian(int(wide.sum()), int((off > 2 * STEP).sum()), int((off > 4 * STEP).sum()))


def flicker(before: ArrayLike, after: ArrayLike) -> Array:
    """Return the change of an (h, w, 3) error from a frame to the next.

    An error that stays the same is a wrong picture; one that changes is seen to flicker.
    """
    changed: Array = np.asarray(after, dtype=np.float64) - np.asarray(before, dtype=np.float64)
    return changed


DEPTH_TOLERANCE = 0.02
"""Relative difference of 1 / distance below which both eyes see the same surface."""


class EyeDepth(NamedTuple):
    """Where an eye is (in any frame both eyes share), its frustum, and its reverse-Z depth."""

    pose: Pose
    fov: Fov
    depth: NDArray[np.floating]
    near_m: float


class Correspondence(NamedTuple):
    """Pixels of the left eye and the places where the right eye sees the same surfaces.

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
    """Mean of \\|e_L(x) − e_R(x + d)\\| over surfaces that both eyes see."""
    shower_door: float
    """corr(e_L(x), e_R(x)) − corr(e_L(x), e_R(x + d)): +1 sticks to the screen, −1 to surfaces."""


def correspondence(left: EyeDepth, right: EyeDepth, *, margin_px: int = 0) -> Correspondence:
    """Find the surfaces that both eyes see, from their depths, without `margin_px` at the border.

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


def _directions(eye: EyeDepth, pixels: NDArray[np.intp]) -> Array:
    """Return (n, 3) points in the eye's frame, at a distance of 1 along its axis."""
    size_px = eye.depth.shape[1], eye.depth.shape[0]
    focal, center = focal_length_px(eye.fov, size_px), principal_point_px(eye.fov, size_px)
    tangent = (pixels + 0.5 - np.array(center)) / np.array(focal)
    return np.column_stack([tangent, np.full(len(pixels), -1.0)])


def _project(
    direction: Array, inverse_m: Array, source: EyeDepth, target: EyeDepth
) -> tuple[Array, Array]:
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
