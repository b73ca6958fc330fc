"""Where in the view effects are centred that follow the gaze: what is done while it is lost."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from vrcomfort.geometry import Array, Gaze
from vrcomfort.optics.focus import WIDEST_GAZE

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


class GazeCentre:
    """Follows the gaze; where that is lost, holds its last direction for a while, then looks ahead.

    Parameters
    ----------
    hold_s
        How long the last direction is held.
    """

    def __init__(self, hold_s: float) -> None:
        self._hold_ns = round(hold_s * 1e9)
        self.forget()

    def forget(self) -> None:
        """Be as if the eyes had never been seen."""
        self._last: tuple[int, Array] | None = None

    def at(self, head_from_gaze: Gaze | None, time_ns: int) -> Centre:
        """Return the centre at a time; where time goes back, nothing is held.

        A gaze further than 85° from the head's forward axis is none: no eye looks there.
        """
        if self._last is not None and time_ns < self._last[0]:
            self.forget()
        if head_from_gaze is not None and head_from_gaze.valid:
            direction = head_from_gaze.pose.forward
            if direction[2] < -WIDEST_GAZE:
                self._last = time_ns, direction
                return Centre(direction, "gaze")
        if self._last is not None and time_ns - self._last[0] <= self._hold_ns:
            return Centre(self._last[1], "held")
        return Centre(AHEAD, "head")
