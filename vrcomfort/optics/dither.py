"""Dither of 8-bit images with blue noise: the NumPy twin of ``shaders/display/tone_map.frag``."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array

SIDE = 64
"""Of the square of noise that is repeated over the image, in pixels."""

FILTER_PX = 1.5
"""Standard deviation of the filter that finds clusters and voids: Ulichney's value."""

FIRST_SHARE = 0.1
"""Share of the pixels in the first pattern: Ulichney's too."""


def dithered(display: ArrayLike, /) -> NDArray[np.uint8]:
    """Return 8-bit values of a (height, width, 3) image in [0, 1], the top row first.

    A value between two codes becomes one of both, as often as it is near it. The pattern depends on
    the pixel alone: it is the same in all channels, in both eyes and in every frame.
    """
    values = np.asarray(display, dtype=np.float64)
    height, width = values.shape[:2]
    rows, columns = np.arange(height)[::-1] % SIDE, np.arange(width) % SIDE
    threshold = blue_noise()[np.ix_(rows, columns)]
    return np.floor(np.clip(values, 0, 1) * 255 + threshold[..., None]).astype(np.uint8)


@cache
def blue_noise() -> Array:
    """Return (64, 64) thresholds between 0 and 1, each different; rows from the bottom.

    Pixels below any threshold are spread evenly, without lines and with hardly any low frequency.
    Sums are of integers, so that all machines find the same pattern.

    Notes
    -----
    Ulichney 1993, *The void-and-cluster method for dither array generation*. Ranks above one half
    are found like those below it; his third phase exchanges zeros and ones instead.
    """
    pattern = _Pattern()
    chances = np.random.default_rng(1).random(SIDE * SIDE)
    for place in np.argsort(chances)[: round(FIRST_SHARE * chances.size)].tolist():
        pattern.flip(place)
    while True:  # move the tightest point to the largest void, until it is the void it leaves
        tightest = pattern.tightest()
        pattern.flip(tightest)
        void = pattern.largest_void()
        pattern.flip(void)
        if void == tightest:
            break
    first = np.flatnonzero(pattern.points).tolist()
    taken: list[int] = []
    for _ in first:
        taken.append(pattern.tightest())
        pattern.flip(taken[-1])
    order = taken[::-1]
    for place in first:
        pattern.flip(place)
    while len(order) < chances.size:
        order.append(pattern.largest_void())
        pattern.flip(order[-1])
    thresholds = np.empty(chances.size)
    thresholds[order] = (np.arange(chances.size) + 0.5) / chances.size
    return thresholds.reshape(SIDE, SIDE)


class _Pattern:
    """Points of a square that repeats, and how crowded each place is."""

    def __init__(self) -> None:
        away = np.minimum(np.arange(SIDE), SIDE - np.arange(SIDE)) ** 2
        weights = np.exp(-np.add.outer(away, away) / (2 * FILTER_PX**2))
        self._weights = np.tile(np.rint(weights * 2**32).astype(np.int64), (2, 2))
        self._crowding = np.zeros((SIDE, SIDE), np.int64)
        self.points = np.zeros(SIDE * SIDE, np.bool_)

    def flip(self, place: int) -> None:
        """Add a point, or take it away."""
        row, column = divmod(place, SIDE)
        around = self._weights[SIDE - row : 2 * SIDE - row, SIDE - column : 2 * SIDE - column]
        self._crowding += -around if self.points[place] else around
        self.points[place] ^= True

    def tightest(self) -> int:
        """Return the point with the most points around it."""
        return int(np.argmax(np.where(self.points, self._crowding.ravel(), -1)))

    def largest_void(self) -> int:
        """Return the place without a point that has the fewest around it."""
        most = np.iinfo(np.int64).max
        return int(np.argmin(np.where(self.points, most, self._crowding.ravel())))
