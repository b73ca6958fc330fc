"""Recorded gaze over time, and its file ``gaze.csv``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Gaze, Pose, normalize
from vrcomfort.traces.pose_track import Times
from vrcomfort.traces.table import Table, read_parts

TIME, VALID = "xr_time_ns", "valid"
ORIGIN = ("origin_x_m", "origin_y_m", "origin_z_m")
DIRECTION = ("direction_x", "direction_y", "direction_z")

LONGEST_NS = 50_000_000
"""A sample says nothing of a moment further away: the eyes may have jumped, or blinked."""


@dataclass(frozen=True, eq=False)
class GazeTrack:
    """What an eye tracker saw.

    Parameters
    ----------
    time_ns
        (n,) int64, rising, on the clock of the trace it belongs to.
    valid
        (n,) bool.
    origins, directions
        (n, 3) metres and unit vectors in the stage; NaN where not valid.
    """

    time_ns: Times
    valid: NDArray[np.bool_]
    origins: Array
    directions: Array

    def at(self, time_ns: int) -> Gaze:
        """Return the nearest sample's gaze: eyes jump, so nothing between two samples is known."""
        after = int(np.searchsorted(self.time_ns, time_ns))
        near = range(max(after - 1, 0), min(after + 1, len(self.time_ns)))
        away_ns, index = min((abs(int(self.time_ns[i]) - time_ns), i) for i in near)
        if away_ns > LONGEST_NS or not self.valid[index]:
            return Gaze(Pose(), valid=False)
        return Gaze(Pose(self.origins[index], turn_to(self.directions[index])))

    def covers(self, times_ns: Times) -> NDArray[np.bool_]:
        """Return (n,) whether a sample is near enough to each of (n,) times."""
        after = np.searchsorted(self.time_ns, times_ns)
        last = len(self.time_ns) - 1
        around = self.time_ns[np.clip([after - 1, after], 0, last)]
        near: NDArray[np.bool_] = np.abs(around - times_ns).min(axis=0) <= LONGEST_NS
        return near


def turn_to(direction: Array) -> Array:
    """Return the shortest turn from −Z to a (3,) unit vector, as a quaternion."""
    x, y, z = direction
    across = np.hypot(x, y)
    if z > 0 and across < 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])  # straight back: any axis across will do
    # 1 − z, without the digits that a subtraction loses where z is nearly 1
    less_z = across**2 / (1.0 + z) if z > 0 else 1.0 - z
    return normalize(np.array([y, -x, 0.0, less_z]))


def read_gaze(path: str | Path) -> GazeTrack:
    """Read a ``gaze.csv``.

    Raises
    ------
    InputError
        With file, line and column: a missing column, time that does not rise, a valid row without
        numbers, or a direction that is no unit vector.
    """
    parts: list[GazeTrack] = []
    for table in read_parts(path, _require):
        last = int(parts[-1].time_ns[-1]) if parts else None
        time_ns = table.rising(TIME, table.integers(TIME), after=last)
        valid = table.integers(VALID) != 0
        rays = np.full((len(time_ns), 6), np.nan)
        if valid.any():
            rays[valid] = _rays(table, valid)
        parts.append(GazeTrack(time_ns, valid, rays[:, :3], rays[:, 3:]))
    return GazeTrack(
        np.concatenate([part.time_ns for part in parts]),
        np.concatenate([part.valid for part in parts]),
        np.concatenate([part.origins for part in parts]),
        np.concatenate([part.directions for part in parts]),
    )


def _rays(table: Table, valid: NDArray[np.bool_]) -> Array:
    """Return (valid rows, 6) origins and directions; rows that are not valid may be blank."""
    kept = np.flatnonzero(valid).tolist()
    rows, lines = tuple(table.rows[i] for i in kept), tuple(table.lines[i] for i in kept)
    part = replace(table, rows=rows, lines=lines)
    rays = np.hstack([part.positions(ORIGIN), part.floats(DIRECTION)])
    lengths = np.linalg.norm(rays[:, 3:], axis=1)
    bad = np.flatnonzero(np.abs(lengths - 1) > 1e-3)
    if len(bad):
        message = f"the direction has length {lengths[bad[0]]:.6g}; it needs length 1"
        raise part.error(bad[0], DIRECTION[0], message)
    return rays


def _require(table: Table) -> None:
    table.require([TIME, VALID, *ORIGIN, *DIRECTION])
