"""Motion on the image: velocity, shutter and streaks.

NumPy twins, in float64, of ``shaders/include/velocity.glsl`` and ``motion_tile_classes.glsl``, and
of the averages of ``motion_blur.frag`` and ``streak_average.frag``.
Thresholds are ours.
"""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array
from vrcomfort.optics.motion import Sampling, sampling_of

SPEED_LIMIT_PX = 16_384.0
"""No velocity is longer than this, so that half floats hold it; far above every streak limit."""


BEHIND = 1e-3
"""Least ratio of previous to present distance: what was behind the eye came from its rim."""


LEAST_W = 1e-6
"""Least present distance: the rims of triangles are interpolated past the eye."""


LEAST_PX = 0.25
"""Half velocities below this are left alone: half a pixel in all."""


def velocity_px(clip_now: ArrayLike, clip_before: ArrayLike, /, size_px: tuple[int, int]) -> Array:
    """Return (..., 2) pixels per frame, now minus before, +x right and +y up.

    Parameters
    ----------
    clip_now, clip_before
        (..., 4) clip coordinates of one surface point; `clip_now` is in front of the eye (w > 0).

    Notes
    -----
    A point whose previous w is not positive was behind the eye, where a projection means nothing:
    w is held at a small part of the present one, which keeps the direction and makes the speed
    large; :data:`SPEED_LIMIT_PX` bounds it.
    """
    now = np.asarray(clip_now, dtype=np.float64)
    before = np.asarray(clip_before, dtype=np.float64)
    w_now = np.maximum(now[..., 3:], LEAST_W)
    w_before = np.maximum(before[..., 3:], BEHIND * w_now)
    half_size = np.array(size_px, dtype=np.float64) / 2
    velocity = (now[..., :2] / w_now - before[..., :2] / w_before) * half_size
    return shorten(velocity, SPEED_LIMIT_PX)


def shorten(vector: ArrayLike, limit: float, /) -> Array:
    """Return (..., 2) vectors no longer than `limit`, their direction kept; zero stays zero."""
    array = np.asarray(vector, dtype=np.float64)
    length = np.linalg.norm(array, axis=-1, keepdims=True)
    shortened: Array = array * (limit / np.maximum(length, limit))
    return shortened


def half_velocity_px(
    velocity: ArrayLike, /, *, shutter_fraction: float, max_radius_px: float
) -> Array:
    """Return (..., 2): how far a point moves from the middle of the shutter's opening to its end.

    The shutter is open for `shutter_fraction` of the frame period, centred on the frame's pose, so
    a streak reaches this far to both sides. Longer ones are shortened to `max_radius_px`.
    """
    reach = np.asarray(velocity, dtype=np.float64) * (shutter_fraction / 2)
    return shorten(reach, max_radius_px)


def time_over(k: ArrayLike, reach: ArrayLike, /) -> Array:
    """Return how long a streak from -reach to +reach px is over a pixel `k` px away.

    In px of its way, where the image between pixels is interpolated linearly: the integral of a
    tent around `k`. Over all pixels it sums to 2 `reach`.
    """
    middle, ends = np.asarray(k, dtype=np.float64), np.asarray(reach, dtype=np.float64)
    over: Array = _tent_integral(middle + ends) - _tent_integral(middle - ends)
    return over


def _tent_integral(x: Array) -> Array:
    beyond = 0.5 * (1 - np.minimum(np.abs(x), 1)) ** 2
    return np.where(x < 0, beyond, 1 - beyond)


def streak_weights(reach_px: float, /, *, samples: int, width_px: int) -> Array:
    """Return (2 n + 1,): how much each pixel from -n to n px away counts in a streak's average.

    Where all streaks are alike and lie along a row. ``motion_blur.frag`` averages in one step,
    ``streak_average.frag``, drawn twice, in two.

    Parameters
    ----------
    reach_px
        Of the half velocity; more than 0.
    samples
        As in ``MotionBlur.samples``; without the cubic read, which is across the streak.
    width_px
        Of the image.
    """
    how = sampling_of(samples, width_px)
    pixels = np.arange(-ceil(reach_px) - 2, ceil(reach_px) + 3, dtype=np.float64)
    if reach_px <= how.one_step_px:
        return _one_step_weights(reach_px, pixels, how.pairs)
    first = _comb_weights(reach_px / how.parts, pixels, how.taps)
    second = _comb_weights(reach_px, pixels, how.parts)
    both: Array = np.convolve(first, second, mode="same")
    return both


def frame_kind(shortest_px: float, longest_px: float, slopes: ArrayLike, /, how: Sampling) -> int:
    """Return how a frame is averaged: 0 one step, 1 two, 2 and 3 with half the averages on x or y.

    Twin of ``kind_of`` in ``shaders/include/frame_kinds.glsl``.

    Parameters
    ----------
    shortest_px, longest_px
        Of the frame's half velocities.
    slopes
        (2,) greatest |y| / |x| and |x| / |y| of the tiles' longest half velocities.
    """
    along_x, along_y = np.asarray(slopes, dtype=np.float64) <= MOST_SLOPE
    if longest_px <= how.one_step_px:
        return 0
    if not how.halves or shortest_px <= how.one_step_px:
        return 1
    return 2 if along_x else 3 if along_y else 1


MOST_SLOPE = 4 / 3


def halved_weights(reach_px: float, at: int, pixels: ArrayLike, /, how: Sampling) -> Array:
    """Return (n,): how much each of the `pixels` of a row counts in the average of pixel `at`.

    Where all streaks lie along the row and are alike, in frames that halve averages. Those of
    pixels 0 and 1, 2 and 3, … are at 0.5, 2.5, …
    """
    places = np.asarray(pixels, dtype=np.float64)
    reach_px = float(np.sqrt(reach_px**2 - 2.25))
    ends = at + _comb_px(reach_px, how.parts)
    found = np.zeros_like(places)
    for texel in range(int(ends.min()) // 2 - 2, int(ends.max()) // 2 + 2):
        share = np.maximum(1 - np.abs((ends - 0.5) / 2 - texel), 0).sum() / how.parts
        reads = 2 * texel + 0.5 + _comb_px(reach_px / how.parts, how.taps)
        found += share * _tents(places, reads) / how.taps
    return found


def _one_step_weights(reach_px: float, pixels: Array, pairs: int) -> Array:
    even = min(2 * reach_px / (2 * pairs + 1), reach_px - 2 * pairs + 0.5)
    own = max(float(time_over(0.0, reach_px)), even)
    part_px = (reach_px - own / 2) / pairs
    middle_px = 0.75 if reach_px < 1 else own / 2 + part_px * pairs / 2
    at_px = middle_px + part_px * (np.arange(pairs) - (pairs - 1) / 2)
    taps = part_px * _tents(pixels, np.concatenate([-at_px, at_px]))
    weights: Array = (taps + np.where(pixels == 0, own, 0)) / (2 * reach_px)
    return weights


def _comb_weights(reach_px: float, pixels: Array, samples: int) -> Array:
    return _tents(pixels, _comb_px(reach_px, samples)) / samples


def _comb_px(reach_px: float, samples: int) -> Array:
    comb: Array = 2 * reach_px * (np.arange(samples) - samples // 2) / samples
    return comb


def _tents(pixels: Array, at_px: Array) -> Array:
    """Return what bilinear reads at some places take of each pixel."""
    weights: Array = np.maximum(1 - np.abs(pixels[:, None] - at_px), 0).sum(axis=1)
    return weights


def tolerance_px(half_velocity_px: ArrayLike, /) -> Array:
    """Return by how much another half velocity may differ and still count as moving along."""
    tolerance: Array = 0.25 + 0.1 * np.asarray(half_velocity_px, dtype=np.float64)
    return tolerance


def jump_px(half_velocity_px: ArrayLike, /) -> Array:
    """Return by how much half velocities of two pixels side by side may differ in one thing."""
    jump: Array = 0.5 + 0.1 * np.asarray(half_velocity_px, dtype=np.float64)
    return jump


def moves_alike(around: ArrayLike, /, *, shortest_px: float, steepness_px: float) -> bool:
    """Return whether a tile in which something moves needs no look at who hides whom.

    Twin of ``class_of`` in ``shaders/include/motion_tile_classes.glsl``. Things pass each other
    where half velocities jump; where they change slowly, all that a pixel sees moves along with it.

    Parameters
    ----------
    around
        (2,) longest half velocity that reaches the tile, px.
    shortest_px, steepness_px
        Length of the tile's shortest half velocity, and the most by which half velocities of two
        pixels side by side differ within reach.
    """
    return bool(np.linalg.norm(around) >= LEAST_PX and steepness_px <= jump_px(shortest_px))


def beside_px(half_velocity: ArrayLike, line: ArrayLike, /) -> Array:
    """Return (...,): how far the ends of (..., 2) half velocities lie beside (..., 2) lines."""
    length = np.linalg.norm(np.asarray(line, dtype=np.float64), axis=-1)
    beside: Array = np.abs(_cross(half_velocity, line)) / np.maximum(length, 1e-6)
    return beside


def crosses(half_velocity: ArrayLike, line: ArrayLike, /) -> NDArray[np.bool_]:
    """Return (...,): whether half velocities go clearly another way than lines: 11.5° or more.

    Fronts that cross the longest streak of a tile are looked for along a line of their own.
    """
    length = np.linalg.norm(np.asarray(half_velocity, dtype=np.float64), axis=-1)
    return np.asarray(beside_px(half_velocity, line) > LEAST_PX + 0.2 * length)


def share_along(half_velocity: ArrayLike, line: ArrayLike, other: ArrayLike, /) -> Array:
    """Return (...,): the share of a front that counts along `line`, not along `other`.

    Parameters
    ----------
    half_velocity
        (..., 2), of the front.
    line, other
        (..., 2), of any length and in either sense; `other` is (0, 0) where there is only one.

    Notes
    -----
    The shares along two lines are as the squares of the cotangents of the front's angles to them,
    and make 1: what goes along a line counts there only, what goes at right angles to it does not.
    """
    u, first, second = (np.asarray(v, dtype=np.float64) for v in (half_velocity, line, other))
    here = np.sum(u * first, axis=-1) * _cross(u, second)
    there = np.sum(u * second, axis=-1) * _cross(u, first)
    return np.where(there == 0, 1.0, here**2 / np.maximum(here**2 + there**2, 1e-30))


def _cross(a: ArrayLike, b: ArrayLike) -> Array:
    u, v = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    product: Array = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return product
