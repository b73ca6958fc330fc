"""Recorded gaze over time, and its file ``gaze.csv``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Gaze, Pose, turn_to
from vrcomfort.records.frame_rows import gaze_columns
from vrcomfort.traces.eye_track import EyeTrack, eye_of, joined, rays_of
from vrcomfort.traces.pose_track import Times
from vrcomfort.traces.table import Table, read_parts

TIME, VALID = "xr_time_ns", "valid"
EYES = ("left_", "right_")

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
    eyes
        The left and the right eye alone; None where the tracker does not tell them apart.
    """

    time_ns: Times
    valid: NDArray[np.bool_]
    origins: Array
    directions: Array
    eyes: tuple[EyeTrack | None, EyeTrack | None] = (None, None)

    def at(self, time_ns: int) -> Gaze:
        """Return the nearest sample's gaze: eyes jump, so nothing between two samples is known."""
        after = int(np.searchsorted(self.time_ns, time_ns))
        near = range(max(after - 1, 0), min(after + 1, len(self.time_ns)))
        away_ns, index = min((abs(int(self.time_ns[i]) - time_ns), i) for i in near)
        if away_ns > LONGEST_NS:
            return Gaze(Pose(), valid=False)
        left, right = (None if eye is None else eye.at(index) for eye in self.eyes)
        if not self.valid[index]:
            return Gaze(Pose(), valid=False, eyes=(left, right))
        pose = Pose(self.origins[index], turn_to(self.directions[index]))
        return Gaze(pose, eyes=(left, right))

    def covers(self, times_ns: Times) -> NDArray[np.bool_]:
        """Return (n,) whether a sample is near enough to each of (n,) times."""
        after = np.searchsorted(self.time_ns, times_ns)
        last = len(self.time_ns) - 1
        around = self.time_ns[np.clip([after - 1, after], 0, last)]
        near: NDArray[np.bool_] = np.abs(around - times_ns).min(axis=0) <= LONGEST_NS
        return near


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
        rays = rays_of(table, valid)
        left, right = (eye_of(table, eye) for eye in EYES)
        parts.append(GazeTrack(time_ns, valid, rays[:, :3], rays[:, 3:], (left, right)))
    left, right = (joined([part.eyes[eye] for part in parts]) for eye in (0, 1))
    return GazeTrack(
        np.concatenate([part.time_ns for part in parts]),
        np.concatenate([part.valid for part in parts]),
        np.concatenate([part.origins for part in parts]),
        np.concatenate([part.directions for part in parts]),
        (left, right),
    )


def _require(table: Table) -> None:
    table.require([TIME, VALID, *gaze_columns()])
