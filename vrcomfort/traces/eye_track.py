"""Recorded gaze of one eye over time: columns of ``gaze.csv`` that not every tracker fills."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, EyeGaze, Pose, turn_to
from vrcomfort.records.frame_rows import eye_columns, gaze_columns
from vrcomfort.traces.columns import has_group
from vrcomfort.traces.table import Table


@dataclass(frozen=True, eq=False)
class EyeTrack:
    """What an eye tracker saw of one eye.

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


def eye_of(table: Table, eye: str) -> EyeTrack | None:
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


def rays_of(table: Table, valid: NDArray[np.bool_], eye: str = "") -> Array:
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


def part_of(table: Table, rows: NDArray[np.bool_]) -> Table:
    """Return some rows of a table."""
    kept = np.flatnonzero(rows).tolist()
    return replace(
        table,
        rows=tuple(table.rows[i] for i in kept),
        lines=tuple(table.lines[i] for i in kept),
    )


def _filled(table: Table, column: str) -> NDArray[np.bool_]:
    return np.array([bool(cell.strip()) for cell in table.text(column)], dtype=bool)
