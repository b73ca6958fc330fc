"""Where a participant is carried, and when: a smooth way through timed floor points."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vrcomfort.geometry import Array, Pose, axis_angle
from vrcomfort.settings.camera_path import PathPoint

_SAME_PLACE_M = 1e-9
_CLOSED = 1e-6
"""Largest gap, in metres or turns, of a path that closes."""


class ShortenedTurn(NamedTuple):
    """A step between two headings that turns the shorter way; `number` counts points from 1."""

    number: int
    from_deg: float
    to_deg: float
    turned_deg: float


class CameraPath:
    """A way through floor points that reaches each at its time.

    Positions and headings are monotone cubic interpolants (Fritsch & Butland 1984): speed has no
    jumps, and between two points nothing lies outside the box that they span, so that a path that
    its points keep in a room stays in it. Headings turn the shorter way round.

    Parameters
    ----------
    points
        At least two, times rising from 0.
    unwrapped
        Whether headings turn as far as is written; those that are not, the shorter way.
    loop
        Whether it begins again when it is over.

    Attributes
    ----------
    shortened
        Steps of 180 degrees or more that are written and not turned.
    """

    def __init__(
        self, points: Sequence[PathPoint], *, unwrapped: bool = False, loop: bool = False
    ) -> None:
        self.loop = loop
        self._times_s = np.array([point.time_s for point in points])
        positions = np.array([point.position for point in points])
        yaws_rad = _yaws_rad(points, positions)
        yaws_rad = _as_written(points, yaws_rad) if unwrapped else np.unwrap(yaws_rad)
        self.shortened = () if unwrapped else tuple(_shortened(points, yaws_rad))
        yaws_rad = _at_their_rates(points, yaws_rad)
        self._knots = np.column_stack([positions, yaws_rad])
        slopes = _slopes_of_loop if loop else _monotone_slopes
        self._slopes = slopes(self._times_s, self._knots)

    @property
    def closes(self) -> bool:
        """Return whether the last point is where the first is, and heads there too."""
        apart_m = np.abs(self._knots[-1, :3] - self._knots[0, :3]).max()
        turns = (self._knots[-1, 3] - self._knots[0, 3]) / (2 * np.pi)
        return bool(apart_m < _CLOSED and abs(turns - np.round(turns)) < _CLOSED)

    @property
    def duration_s(self) -> float:
        """Return when the last point is reached, for the first time."""
        return float(self._times_s[-1])

    def pose(self, time_s: float) -> Pose:
        """Return world-from-floor at a time; before the first and after the last it stands."""
        x, y, z, yaw_rad = self._values(np.array([time_s]))[0]
        return Pose(np.array([x, y, z]), axis_angle([0.0, 1.0, 0.0], float(yaw_rad)))

    def moved(self, time_s: float) -> Pose:
        """Return the motion from the pose at time 0 to that at a time."""
        return self.pose(time_s) @ self.pose(0.0).inverse()

    def positions(self, times_s: Array) -> Array:
        """Return the (n, 3) floor points at (n,) times."""
        return self._values(times_s)[:, :3]

    def _values(self, times_s: Array) -> Array:
        """Return (n, 4) x, y, z and yaw: cubic Hermite between points."""
        knots_s = self._times_s
        if self.loop:
            times_s = times_s % self.duration_s
        times_s = np.clip(times_s, 0.0, self.duration_s)
        left = np.clip(np.searchsorted(knots_s, times_s, side="right") - 1, 0, len(knots_s) - 2)
        step_s = (knots_s[left + 1] - knots_s[left])[:, None]
        u = (times_s - knots_s[left])[:, None] / step_s
        near, far = self._knots[left], self._knots[left + 1]
        leave, arrive = self._slopes[left] * step_s, self._slopes[left + 1] * step_s
        found: Array = near + u * (
            leave
            + u * (3 * (far - near) - 2 * leave - arrive)
            + u**2 * (2 * (near - far) + leave + arrive)
        )
        return found


def _monotone_slopes(times_s: Array, values: Array) -> Array:
    """Return (n, k) slopes at the points: 0 where a value turns back, else a harmonic mean.

    Fritsch & Butland (1984), SIAM J. Sci. Stat. Comput. 5, Eq. 5; at both ends the straight way.
    """
    steps = np.diff(times_s)[:, None]
    ways = np.diff(values, axis=0) / steps
    before, after = ways[:-1], ways[1:]
    first, second = steps[:-1] + 2 * steps[1:], 2 * steps[:-1] + steps[1:]
    goes_on = before * after > 0
    safe_before, safe_after = np.where(goes_on, before, 1.0), np.where(goes_on, after, 1.0)
    mean = (first + second) / (first / safe_before + second / safe_after)
    return np.vstack([ways[:1], np.where(goes_on, mean, 0.0), ways[-1:]])


def _slopes_of_loop(times_s: Array, values: Array) -> Array:
    """Return (n, k) slopes of a way that begins again: alike at both ends."""
    before_s, after_s = times_s[0] - np.diff(times_s)[-1], times_s[-1] + np.diff(times_s)[0]
    ways = np.diff(values, axis=0)
    around = np.vstack([values[:1] - ways[-1:], values, values[-1:] + ways[:1]])
    return _monotone_slopes(np.array([before_s, *times_s, after_s]), around)[1:-1]


def _at_their_rates(points: Sequence[PathPoint], yaws_rad: Array) -> Array:
    """Return the (n,) headings with turns at the rates of points; later ones turn with them."""
    if all(point.turning_deg_s is None for point in points):
        return yaws_rad
    turned = yaws_rad.copy()
    for index, (before, after) in enumerate(pairwise(points), start=1):
        if before.turning_deg_s is not None:
            turn_rad = np.radians(before.turning_deg_s * (after.time_s - before.time_s))
            turned[index] = turned[index - 1] + turn_rad
        else:
            turned[index] = turned[index - 1] + yaws_rad[index] - yaws_rad[index - 1]
            if after.yaw_deg is not None:  # as written, by whole turns off at most
                off = np.radians(after.yaw_deg) - turned[index]
                turned[index] += off - 2 * np.pi * np.round(off / (2 * np.pi))
    return turned


def _yaws_rad(points: Sequence[PathPoint], positions: Array) -> Array:
    """Return the (n,) headings: those written, else towards the next point that is elsewhere."""
    ahead_rad: list[float] = []
    last_rad = 0.0
    for before, after in pairwise(positions):
        way = after - before
        if np.hypot(way[0], way[2]) > _SAME_PLACE_M:
            last_rad = float(np.arctan2(-way[0], -way[2]))
        ahead_rad.append(last_rad)
    ahead_rad.append(last_rad)
    return np.array(
        [
            ahead if point.yaw_deg is None else np.radians(point.yaw_deg)
            for point, ahead in zip(points, ahead_rad, strict=True)
        ]
    )


def _as_written(points: Sequence[PathPoint], yaws_rad: Array) -> Array:
    """Return the (n,) headings with all turns that are written; others turn the shorter way."""
    turned = yaws_rad.copy()
    for index in range(1, len(points)):
        if points[index].yaw_deg is None:
            step_rad = turned[index] - turned[index - 1]
            turned[index] -= 2 * np.pi * np.round(step_rad / (2 * np.pi))
    return turned


def _shortened(points: Sequence[PathPoint], yaws_rad: Array) -> Iterator[ShortenedTurn]:
    turned_deg = np.degrees(np.diff(yaws_rad))
    for index, (before, after) in enumerate(pairwise(points)):
        if before.yaw_deg is None or after.yaw_deg is None:
            continue
        if abs(after.yaw_deg - before.yaw_deg) >= 180:
            turn_deg = float(turned_deg[index])
            yield ShortenedTurn(index + 1, before.yaw_deg, after.yaw_deg, turn_deg)
