"""Recorded gaze over time, of both eyes and of each, and its file ``gaze.csv``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, EyeGaze, Gaze, Pose, turn_to
from vrcomfort.records.frame_rows import eye_columns, gaze_columns
from vrcomfort.traces.pose_track import Times
from vrcomfort.traces.table import TraceTable, has_group, read_parts


@dataclass(frozen=True, eq=False)
class EyeTrack:
    """The samples of an eye tracker for one eye.

    Parameters
    ----------
    told
        (n,) bool: whether the tracker says anything of this eye.
    valid
        (n,) bool: whether it saw it.
    rays
        (n, 6) origin in metres and direction of length 1, in the stage; NaN where not valid.
    pupils_mm
        (n,) diameters, NaN where none is told.
    """

    told: NDArray[np.bool_]
    valid: NDArray[np.bool_]
    rays: Array
    pupils_mm: Array

    def at(self, index: int) -> EyeGaze | None:
        """Return a sample, None where the tracker says nothing of this eye."""
        if not self.told[index]:
            return None
        told_mm = float(self.pupils_mm[index])
        pupil_mm = None if np.isnan(told_mm) else told_mm
        if not self.valid[index]:
            return EyeGaze(Pose(), valid=False, pupil_mm=pupil_mm)
        ray = self.rays[index]
        return EyeGaze(Pose(ray[:3], turn_to(ray[3:])), pupil_mm=pupil_mm)


def eye_of(table: TraceTable, eye: str) -> EyeTrack | None:
    """Read the columns of an eye (``left_`` or ``right_``); None where the file has none.

    Raises
    ------
    InputError
        With file, line and column: half of the columns, an eye that is seen without numbers, a
        direction that is no unit vector, or a pupil that is none.
    """
    columns = eye_columns(eye)
    if not has_group(table, columns):
        return None
    told, sized = (_filled(table, name) for name in (columns[0], columns[-1]))
    valid = np.zeros(len(told), dtype=bool)
    valid[told] = part_of(table, told).integers(columns[0]) != 0
    pupils_mm = np.full(len(told), np.nan)
    if sized.any():
        part = part_of(table, sized)
        pupils_mm[sized] = part.floats(columns[-1:])[:, 0]
        bad = np.flatnonzero(pupils_mm[sized] <= 0)
        if len(bad):
            raise part.error(bad[0], columns[-1], "a pupil has a diameter above 0 mm")
    return EyeTrack(told, valid, rays_of(table, valid, eye), pupils_mm)


def joined(parts: Sequence[EyeTrack | None]) -> EyeTrack | None:
    """Return the parts of a file as one; None where none says anything."""
    known = [each for each in parts if each is not None]
    if not any(each.told.any() for each in known):
        return None
    return EyeTrack(
        np.concatenate([each.told for each in known]),
        np.concatenate([each.valid for each in known]),
        np.concatenate([each.rays for each in known]),
        np.concatenate([each.pupils_mm for each in known]),
    )


def rays_of(table: TraceTable, valid: NDArray[np.bool_], eye: str = "") -> Array:
    """Return (n, 6) origins and directions, NaN in rows that are not valid: they may be blank.

    Raises
    ------
    InputError
        At the first that is no line of sight.
    """
    rays = np.full((len(valid), 6), np.nan)
    if not valid.any():
        return rays
    part, columns = part_of(table, valid), gaze_columns(eye)
    found = np.hstack([part.positions(columns[:3]), part.floats(columns[3:])])
    with np.errstate(over="ignore"):  # of numbers that are no direction
        lengths = np.linalg.norm(found[:, 3:], axis=1)
    bad = np.flatnonzero(np.abs(lengths - 1) > 1e-3)
    if len(bad):
        message = f"the direction has length {lengths[bad[0]]:.6g}; it needs length 1"
        raise part.error(bad[0], columns[3], message)
    rays[valid] = found
    return rays


def part_of(table: TraceTable, rows: NDArray[np.bool_]) -> TraceTable:
    """Return some rows of a table."""
    kept = np.flatnonzero(rows).tolist()
    return replace(
        table,
        rows=tuple(table.rows[i] for i in kept),
        lines=tuple(table.lines[i] for i in kept),
    )


def _filled(table: TraceTable, column: str) -> NDArray[np.bool_]:
    return np.array([bool(cell.strip()) for cell in table.text(column)], dtype=bool)


TIME, VALID = "xr_time_ns", "valid"
EYES = ("left_", "right_")

LONGEST_NS = 50_000_000
"""A sample says nothing of a moment further away: the eyes may have jumped, or blinked."""


@dataclass(frozen=True, eq=False)
class GazeTrack:
    """The samples of an eye tracker, of both eyes together.

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


def _require(table: TraceTable) -> None:
    table.require([TIME, VALID, *gaze_columns()])
