"""Directions and distances that focus follows: rays, the gaze, a script.

Sources: Carnegie & Rhee 2015, p. 36; Mantiuk et al. 2011, section 4. Each function names the
details that the print leaves open, and our choice.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from vrcomfort.geometry import Array, Gaze, Pose, normalize, rotate

RAYS = 9


def ray_tangents(ring_deg: float) -> Array:
    """Return (9, 2) tangents (right, up) of the rays: the centre, then eight from the right.

    The ring runs to the left over the top, in steps of 45°. Each of its rays is `ring_deg` from
    the centre; the paper says "small regular angular deviations" and leaves the angle open.
    """
    around = np.arange(RAYS - 1) * (np.pi / 4)
    ring = np.tan(np.radians(ring_deg)) * np.stack([np.cos(around), np.sin(around)], axis=1)
    return np.concatenate([np.zeros((1, 2)), ring])


GAZE_RING = 0.745
"""Where the eight outer rays around a line of sight lie, in radii of its neighbourhood: each of the
nine then stands for a ninth of its area."""

WIDEST_GAZE = np.sin(np.radians(5.0))
"""Least cosine between a ray and the head's forward axis: no eye looks beyond 85° from it."""


def gaze_tangents(head_from_gaze: Pose, radius_deg: float) -> Array | None:
    """Return (9, 2) tangents (right, up), in the head's frame, of rays around a line of sight.

    Parameters
    ----------
    head_from_gaze
        −Z along the line of sight; its place counts as the head centre.
    radius_deg
        Of the neighbourhood that stands for the error of the eye tracker.

    Returns
    -------
    None where a ray is further than 85° from the head's forward axis: no eye looks there.
    """
    reach = np.tan(np.radians(GAZE_RING * radius_deg))
    around = np.arange(RAYS - 1) * (np.pi / 4)
    in_gaze = np.full((RAYS, 3), -1.0)
    in_gaze[0, :2] = 0.0
    in_gaze[1:, :2] = reach * np.stack([np.cos(around), np.sin(around)], axis=1)
    rays = normalize(rotate(head_from_gaze.orientation, in_gaze))
    if rays[:, 2].max() > -WIDEST_GAZE:
        return None
    tangents: Array = rays[:, :2] / -rays[:, 2:]
    return tangents


def scripted_focus_m(
    script: Sequence[tuple[float, float]], time_s: float, every_s: float | None = None
) -> float:
    """Return the focus distance at a time.

    Parameters
    ----------
    script
        (seconds, metres), times rising. Between two entries focus moves linearly in dioptres, as
        an eye's accommodation is measured; before the first and after the last it rests.
    every_s
        The script begins again so often; None never.
    """
    at_s = time_s if every_s is None else time_s % every_s
    times_s, distances_m = np.array(script, dtype=np.float64).T
    return float(1 / np.interp(at_s, times_s, 1 / distances_m))


Source = Literal["gaze", "held", "head"]

AHEAD = np.array([0.0, 0.0, -1.0])


class Centre(NamedTuple):
    """A direction in the head's frame.

    Parameters
    ----------
    direction
        (3,) unit vector.
    source
        ``gaze``: where the eyes look; ``held``: where they last looked; ``head``: ahead.
    """

    direction: Array
    source: Source

    @property
    def tangents(self) -> tuple[float, float]:
        """Return (right, up) per metre ahead."""
        x, y, z = self.direction.tolist()
        return x / -z, y / -z


class GazeFollower:
    """Follows the gaze; where that is lost, holds its last direction for a while, then looks ahead.

    Parameters
    ----------
    hold_s
        How long the last direction is held.
    """

    def __init__(self, hold_s: float) -> None:
        self._hold_ns = round(hold_s * 1e9)
        self.reset()

    def reset(self) -> None:
        """Be as if the eyes had never been seen."""
        self._last: tuple[int, Array] | None = None

    def at(self, head_from_gaze: Gaze | None, time_ns: int) -> Centre:
        """Return the centre at a time; where time goes back, nothing is held.

        A gaze further than 85° from the head's forward axis is none: no eye looks there.
        """
        if self._last is not None and time_ns < self._last[0]:
            self.reset()
        if head_from_gaze is not None and head_from_gaze.valid:
            direction = head_from_gaze.pose.forward
            if direction[2] < -WIDEST_GAZE:
                self._last = time_ns, direction
                return Centre(direction, "gaze")
        if self._last is not None and time_ns - self._last[0] <= self._hold_ns:
            return Centre(self._last[1], "held")
        return Centre(AHEAD, "head")
