"""Points of a lens and of a shutter's time: many for references, few for views through the lens.

`view_points` places few views so that their small discs together are the lens's disc. Their error
is measured on a sharp edge in all directions (`edge_error`): images are mostly edges.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import product
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array


def low_discrepancy(count: int, shift: ArrayLike) -> Array:
    """Return (count, n) points in [0, 1)ⁿ, moved around the torus by `shift` (n,).

    Notes
    -----
    Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018): steps by powers of
    1/φ, where φ is the root of φⁿ⁺¹ = φ + 1. The shift is a Cranley-Patterson rotation, so that
    two sets with different shifts are independent.
    """
    offset = np.asarray(shift, dtype=np.float64)
    # Fixed-point iteration for the root: it contracts, and 64 steps reach the last bit.
    phi = 1.5
    for _ in range(64):
        phi = (1 + phi) ** (1 / (len(offset) + 1))
    steps = phi ** -np.arange(1.0, len(offset) + 1)
    points: Array = (offset + np.arange(1, count + 1)[:, None] * steps) % 1.0
    return points


def with_moments(points: Array, variance: float = 0.25) -> Array:
    """Return (n, 2) points moved about 0 and stretched until their variance is the same all round.

    That of the unit disc is 1/4. Where all lie on a line, they have it along this line.
    """
    centred = points - points.mean(axis=0)
    found, axes = np.linalg.eigh(centred.T @ centred / len(points))
    # An axis without extent is left alone (division by infinity): points on a line stay on it.
    stretch = np.sqrt(variance / np.where(found > 1e-9, found, np.inf))
    stretched: Array = centred @ (axes * stretch) @ axes.T
    return stretched


def concentric_disc(square: ArrayLike, /) -> Array:
    """Map (..., 2) points of the unit square to the unit disc, keeping areas and neighbours.

    Notes
    -----
    Shirley & Chiu, "A low distortion map between disk and square", 1997.
    """
    x, y = np.moveaxis(2 * np.asarray(square, dtype=np.float64) - 1, -1, 0)
    wide = np.abs(x) > np.abs(y)
    radius = np.where(wide, x, y)
    ratio = np.where(wide, y, x) / np.where(radius == 0, 1.0, radius)
    angle = np.where(wide, np.pi / 4 * ratio, np.pi / 2 - np.pi / 4 * ratio)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


def lens_and_shutter(count: int, *, lens: bool, shutter: bool, seed: int) -> Array:
    """Return (count, 3): a point (x, y) of the unit disc and a time in [−½, ½) for each sample.

    Even and odd samples are two low-discrepancy sets, each moved by a random shift of its own: two
    independent halves. A longer list begins with the shorter one. Only the dimensions that are
    asked for are filled (fewer dimensions, more even); the others are 0.
    """
    used = [column for column, wanted in enumerate((lens, lens, shutter)) if wanted]
    shifts = np.random.default_rng(seed).random((2, 3))[:, used]
    square = np.full((count, 3), 0.5)
    for half, shift in enumerate(shifts):
        own = square[half::2]
        if used and len(own):
            own[:, used] = low_discrepancy(len(own), shift)
    disc = concentric_disc(square[:, :2])
    return np.column_stack([disc, square[:, 2] - 0.5])


Counts: TypeAlias = NDArray[np.int64]
"""Points on each ring, from the inside."""

OVERLAP = 2.0
"""Radius of each of K discs in parts of 1/√K, at which they had the lens's area together. More
hides how pixels sample small lights; measured against 0.7 to 3 in both shipped scenes."""

WIDEST_OF_MANY = 0.5
"""Between this and nearly the whole lens, discs make its rim soft (:func:`edge_error`)."""

FEW = 12
"""Fewer discs than this leave gaps however they lie."""

FEW_RADIUS = 0.97
"""Radius of a blur over nearly the whole lens: the points add only surfaces that a filter cannot
know."""

_DIRECTIONS = 16
_PLACES = 64


def view_radius(count: int, over_blur: float = 1.0) -> float:
    """Return the radius over which each of `count` views is blurred, in parts of the lens.

    It is at most the lens, and `over_blur` times ``2 / √count`` or, if that is less, half the lens;
    up to eleven views, times 0.97.
    """
    if count == 1:
        return 1.0
    many = min(WIDEST_OF_MANY, OVERLAP / math.sqrt(count))
    whole = FEW_RADIUS if count < FEW else many
    return min(over_blur * whole, 1.0)


@lru_cache(maxsize=16)
def view_points(count: int, radius: float) -> Array:
    """Return (count, 2) points of the unit disc from which a lens is seen in `count` views.

    Mean and second moments of the points and of the disc of `radius` over which each view is
    blurred add up to those of the lens: nothing that is out of focus moves, and it is as wide as it
    should be, in every direction (from three points on).

    Notes
    -----
    Rings about the middle, each point with the same area. Of a few ways to share the points among
    rings, the one with the least :func:`edge_error` is taken; from eight points on it is a half to
    a quarter of a sunflower's (Vogel 1979), whose rim is uneven. Without a blur, moving each point
    downhill in energy distance (sums of |p - q|) gains no more than 2 % from 16 points on.
    """
    variance = max(1 - radius**2, 0.0) / 4
    more = (0, 2, 4) if 0 < radius <= WIDEST_OF_MANY else (0,)
    found = [with_moments(_rings(counts), variance) for counts in _shares(count, more)]
    best = min(found, key=lambda points: edge_error(points, radius))
    best.flags.writeable = False
    return best


def edge_error(points: ArrayLike, radius: float) -> float:
    """Return the error at an edge of views from (n, 2) points, against the whole lens.

    The root mean square over directions, and over places within 1.2 radii of the lens, of an edge
    between 0 and 1.
    """
    angle = np.arange(_DIRECTIONS) * np.pi * (math.sqrt(5) - 1) / 2
    along = np.asarray(points) @ _unit(angle)
    place = np.linspace(-1.2, 1.2, _PLACES)
    away = place - along[:, :, None]
    views = disc_edge(away / radius) if radius > 1e-9 else np.heaviside(away, 0.5)
    error: float = np.sqrt(np.mean((views.mean(axis=0) - disc_edge(place)) ** 2))
    return error


def disc_edge(away: ArrayLike, /) -> Array:
    """Return the part of the unit disc on the near side of a line, at signed distances from it."""
    x = np.clip(away, -1.0, 1.0)
    part: Array = 0.5 + (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
    return part


def _shares(count: int, more: tuple[int, ...]) -> Iterator[Counts]:
    """Yield numbers of points on each ring, from the inside, that grow evenly.

    But for `more` points on the outermost: wide discs would leave the rim of the lens too soft.
    """
    usual = round(math.sqrt(0.39 * count))
    for rings in range(max(1, usual - 1), usual + 2):
        for innermost, extra in product(range(1, 6), more if rings > 1 else (0,)):
            ring = np.arange(rings + 1)
            growth = 2 * (count / rings - innermost) / max(rings - 1, 1)
            ends = np.round(innermost * ring + growth * ring * (ring - 1) / 2)
            ends[-2] -= extra
            ends[-1] = count
            counts = np.diff(ends).astype(np.int64)
            if np.all(counts > 0):
                yield counts


def _rings(counts: Counts) -> Array:
    """Return points on rings of equal area per point; that of a single one is the middle.

    Each ring is turned so far off the axes, which most edges of rooms are along, that no two of its
    points share a row or a column: a quarter of a step, and an eighth where their number is odd.
    Every second ring is half a step further.
    """
    ends = np.concatenate([[0], np.cumsum(counts)])
    radius = np.sqrt((ends[:-1] + ends[1:]) / 2) * (counts > 1)
    turn = np.where(counts % 2, 0.125, 0.25) + 0.5 * (np.arange(len(counts)) % 2)
    angle = np.concatenate(
        [2 * np.pi * (np.arange(n) + start) / n for n, start in zip(counts, turn, strict=True)]
    )
    points: Array = np.repeat(radius, counts)[:, None] * _unit(angle).T
    return points


def _unit(angle: Array) -> Array:
    """Return (2, n) unit vectors."""
    return np.stack([np.cos(angle), np.sin(angle)])
