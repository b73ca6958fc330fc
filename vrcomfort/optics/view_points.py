"""From which points of a lens a few views are drawn, and how much each is blurred: no OpenGL.

The views' small discs together are to be the lens's disc. How far they are from it is told by what
they make of a sharp edge, in all directions: images are mostly edges.
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
from vrcomfort.optics.sampling import with_moments

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
"""Radius of a blur over nearly the whole lens: the points show only what a filter cannot know."""

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
    """Return how far views from (n, 2) points make of an edge what a whole lens makes of it.

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

    But for so many `more` on the outermost: wide discs would leave the rim of the lens too soft.
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
