"""The best that a post-process can do (R2): scatter of one pinhole image with exact visibility."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array

WIDEST_CRACK_PX = 1.0
"""Neighbours whose blurs differ by more than this belong to different surfaces."""


class Pinhole(NamedTuple):
    """What a post-process knows: one image, and for each pixel how deep it is and how it spreads.

    Parameters
    ----------
    image
        (h, w, 3) linear radiance, bottom row first.
    depth
        (h, w) reverse-Z depth: the larger one hides the smaller.
    radius_px
        (h, w) signed radius of the circle of confusion, in pixels of image width.
    streak_px
        (h, w, 2) motion while the shutter is open, +x right, +y up.
    pixel_aspect
        Vertical over horizontal pixels per radian.
    """

    image: NDArray[np.floating]
    depth: NDArray[np.floating]
    radius_px: Array
    streak_px: NDArray[np.floating]
    pixel_aspect: float = 1.0


def ideal_scatter(pinhole: Pinhole, samples: ArrayLike, /) -> Array:
    """Return (h, w, 3): the mean over samples of what each sees of the pinhole image's pixels.

    Every pixel is a square of its surface, at its depth. A sample (x, y of the unit disc, time in
    [−½, ½)) moves it by ``radius · (x, y) + streak · time``; the nearest wins. So each pixel's
    light is spread evenly over its disc and along its streak, except where something nearer
    hides it from that part of the lens at that time. Where a sample looks at what the pinhole image
    did not see, the farthest of the four surfaces next to that place (along row and column) is
    taken to go on behind the nearer ones: a post-process cannot know better.

    Squares grow by what they move relative to their neighbours (up to 1 px), so that slanted
    surfaces do not tear; wider gaps are edges of surfaces.

    Parameters
    ----------
    samples
        (n, 3), as of `optics.sampling.lens_and_shutter`.
    """
    height, width, _ = pinhole.image.shape
    order = np.argsort(pinhole.depth, axis=None, kind="stable")
    colours = pinhole.image.reshape(-1, 3)[order].astype(np.float64)
    rows, columns = np.divmod(order, width)
    connected = _connected(pinhole, 0), _connected(pinhole, 1)
    total = np.zeros((height, width, 3))
    samples = np.asarray(samples, dtype=np.float64)
    for x, y, time in samples:
        shift_x = pinhole.radius_px * x + pinhole.streak_px[..., 0] * time
        shift_y = pinhole.radius_px * y * pinhole.pixel_aspect + pinhole.streak_px[..., 1] * time
        places = [
            _covered(base + shift.reshape(-1)[order], _growth(shift, connected).reshape(-1)[order])
            for base, shift in ((columns, shift_x), (rows, shift_y))
        ]
        total += colours[_continued(_nearest(places[0], places[1], (height, width)))]
    return total / len(samples)


def _connected(pinhole: Pinhole, axis: int) -> NDArray[np.bool_]:
    """Return whether each pixel and the next along an axis belong to one surface."""
    spread = [np.abs(np.diff(pinhole.radius_px, axis=axis))]
    spread += [np.abs(np.diff(pinhole.streak_px[..., i], axis=axis)) for i in (0, 1)]
    connected: NDArray[np.bool_] = np.max(spread, axis=0) <= WIDEST_CRACK_PX
    return connected


def _growth(shift: Array, connected: tuple[NDArray[np.bool_], ...]) -> Array:
    """Return (h, w): how much farther than itself a pixel's square must reach to meet the next."""
    growth = np.zeros_like(shift)
    for axis in (0, 1):
        gap = np.abs(np.diff(shift, axis=axis)) * connected[axis]
        head, tail = [(0, 0), (0, 0)], [(0, 0), (0, 0)]
        head[axis], tail[axis] = (1, 0), (0, 1)
        growth = np.maximum(growth, np.maximum(np.pad(gap, head), np.pad(gap, tail)))
    return growth


def _covered(center: Array, growth: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first and last pixel whose centre a square covers: one, or two if it has grown."""
    half = (1 + growth) / 2
    first = np.floor(center - half).astype(np.intp) + 1
    last = np.maximum(first, np.floor(center + half).astype(np.intp))
    return first, last


def _nearest(
    columns: tuple[NDArray[np.intp], NDArray[np.intp]],
    rows: tuple[NDArray[np.intp], NDArray[np.intp]],
    shape: tuple[int, int],
) -> NDArray[np.intp]:
    """Return (h, w) indices of what is seen, −1 for nothing; squares come farthest first."""
    height, width = shape
    x = np.stack([columns[0], columns[1], columns[0], columns[1]], axis=-1)
    y = np.stack([rows[0], rows[0], rows[1], rows[1]], axis=-1)
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    index = np.broadcast_to(np.arange(len(x))[:, None], x.shape)
    seen = np.full(shape, -1, dtype=np.intp)
    # Of several values for one pixel NumPy keeps the last: the nearest.
    seen[y[inside], x[inside]] = index[inside]
    return seen


def _continued(seen: NDArray[np.intp]) -> NDArray[np.intp]:
    """Fill what is not seen (−1) with the farthest (least) index next to it in four directions."""
    if seen.min() >= 0:
        return seen
    nothing = seen.size
    found = np.full_like(seen, nothing)
    for turned, filled in ((seen, found), (seen.T, found.T)):
        for view, out in ((turned, filled), (turned[:, ::-1], filled[:, ::-1])):
            np.minimum(out, _last_seen(view, nothing), out=out)
    continued = np.where(seen >= 0, seen, found)
    # A row and a column without anything: any surface at all, the farthest.
    return np.where(continued == nothing, 0, continued)


def _last_seen(seen: NDArray[np.intp], nothing: int) -> NDArray[np.intp]:
    """Return for each place the last index at or before it in its row that is seen."""
    column = np.where(seen >= 0, np.arange(seen.shape[1]), -1)
    last = np.maximum.accumulate(column, axis=1)
    rows = np.arange(seen.shape[0])[:, None]
    return np.where(last >= 0, seen[rows, np.maximum(last, 0)], nothing)
