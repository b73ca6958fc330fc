"""Which pixels of a view show what: errors are told apart by what participants look at.

Everything follows from the pinhole image: its depth, its radii and its light.

============== =====================================================================================
one_surface    blurred, and no edge, thin thing or lamp within its blur
near_rims      within the disc of a surface in front of the focus, at its edge over something
               farther: what is behind shows through
far_edges      beside something that is not in front of the focus, within the disc of what is
               farther and blurred; no near rim
thin           things narrower than `THIN_PART` of the whole image's width, as far as their discs go
lamps          light of more than `LAMP` (display white is 1), as far as its discs go
in_focus       radius of at most `SHARP_PX`, where no disc of something nearer reaches
============== =====================================================================================
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, grey_opening

from vrcomfort.geometry import Array

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


class Seen(NamedTuple):
    """What the pinhole image of a view shows, bottom row first.

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


def regions(seen: Seen) -> dict[str, Mask]:
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


def _edges(seen: Seen) -> tuple[Array, Array]:
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


def _thin(seen: Seen) -> Mask:
    """Return what an opening of the depth with a square takes away."""
    side = max(3, round(THIN_PART * seen.whole_width_px) // 2 * 2 + 1)
    without = grey_opening(seen.depth.astype(np.float64), size=(side, side))
    found: Mask = seen.depth - without > EDGE * seen.depth
    return found
