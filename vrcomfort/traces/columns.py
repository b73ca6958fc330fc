"""Which columns a trace file has, and how they become arrays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.records.frame_rows import SNAP_TURN
from vrcomfort.records.pose_columns import HEAD, fov_columns, pose_columns
from vrcomfort.traces.pose_track import PoseTrack, Times
from vrcomfort.traces.table import Table

TIME, PERIOD, TRIAL = "xr_time_ns", "period_ns", "trial"
DISCONTINUITY = "discontinuity"
"""1 where the pose before has nothing to do with this one (loop, teleport), 2 where the avatar's
heading before does not (snap turn), else 0."""
REQUIRED = (TIME, *HEAD)
HANDS = (pose_columns("left_hand"), pose_columns("right_hand"))
EYES = (pose_columns("left"), pose_columns("right"))
FOVS = (fov_columns("left"), fov_columns("right"))
UNITY_HEADER = ["Time", "x", "y", "z", "alpha", "beta", "gamma"]


def require_trace(table: Table) -> None:
    """Raise InputError if a required column is missing, or if this is another program's log."""
    if _words(table) == UNITY_HEADER:
        raise table.fault(
            "this looks like a Unity log; convert it first with "
            "`vrcomfort import-trace FILE --format unity-euler --out TRACE.csv`",
            1,
        )
    table.require(REQUIRED)


def require_unity(table: Table) -> None:
    """Raise InputError if this is not a Unity log: names on its first line, commas in its rows."""
    needed = " ".join(UNITY_HEADER)
    if _words(table) != UNITY_HEADER:
        raise table.fault(f"this is not a Unity log: its first line must be {needed!r}", 1)
    if list(table.header) != UNITY_HEADER:
        message = f"the rows below {needed!r} must be seven numbers with commas between them"
        raise table.fault(f"{message}, like 0.5,0,1.6,0,10,90,0", table.lines[0])


def _words(table: Table) -> list[str]:
    """Return the names of a header that has spaces in place of commas, too."""
    return table.header[0].split() if len(table.header) == 1 else list(table.header)


def has_group(table: Table, columns: tuple[str, ...]) -> bool:
    """Return whether an optional group of columns is there; half of a group is an error."""
    missing = [name for name in columns if name not in table.header]
    if missing and len(missing) < len(columns):
        there = next(name for name in columns if name in table.header)
        message = f"the column {missing[0]!r} is missing although {there!r} is there"
        raise table.fault(message, 1, missing[0])
    return not missing


def track_of(table: Table, columns: tuple[str, ...]) -> PoseTrack:
    """Return the poses in seven columns."""
    return PoseTrack(table.positions(columns[:3]), table.quaternions(columns[3:]))


def cuts_of(
    table: Table, trial: tuple[str, ...] | None, *, before: str | None, start: bool
) -> NDArray[np.bool_]:
    """Return (n,) bool: the start, changes of trial, and what the file calls a discontinuity.

    Parameters
    ----------
    before
        The trial of the row before this table's first.
    start
        No row is before this table's first.
    """
    cuts = np.zeros(len(table.rows), dtype=bool)
    if table.has([DISCONTINUITY]):
        marks = table.integers(DISCONTINUITY)
        cuts |= (marks != 0) & (marks != SNAP_TURN)
    if trial:
        cuts |= [now != earlier for now, earlier in zip(trial, (before, *trial), strict=False)]
    cuts[:1] |= start
    return cuts


def hands_of(table: Table) -> tuple[PoseTrack | None, PoseTrack | None]:
    """Return stage-from-aim of both hands, NaN in blank rows; None where all are blank."""
    left, right = (
        _track_with_gaps(table, columns) if has_group(table, columns) else None for columns in HANDS
    )
    return left, right


def _track_with_gaps(table: Table, columns: tuple[str, ...]) -> PoseTrack | None:
    cells = [table.text(name) for name in columns]
    known = [any(cell.strip() for cell in row) for row in zip(*cells, strict=True)]
    kept = np.flatnonzero(known)
    if not len(kept):
        return None
    poses = np.full((len(known), len(columns)), np.nan)
    rows = tuple(table.rows[i] for i in kept.tolist())
    lines = tuple(table.lines[i] for i in kept.tolist())
    poses[kept] = track_of(replace(table, rows=rows, lines=lines), columns).cells()
    return PoseTrack(poses[:, :3], poses[:, 3:])


def snap_turns_of(table: Table) -> NDArray[np.bool_] | None:
    """Return (n,) bool where the avatar was turned at once, or None where the file says nothing."""
    return table.integers(DISCONTINUITY) == SNAP_TURN if table.has([DISCONTINUITY]) else None


def periods_of(table: Table) -> Times | None:
    """Return (n,) int64 frame periods, or None where the file has none."""
    if not table.has([PERIOD]):
        return None
    periods = table.integers(PERIOD)
    bad = np.flatnonzero(periods <= 0)
    if len(bad):
        raise table.error(bad[0], PERIOD, "a frame period must be greater than 0 ns")
    return periods


def eyes_of(table: Table) -> tuple[PoseTrack, PoseTrack] | None:
    """Return left and right eye poses, or None where the file has none."""
    if not has_group(table, (*EYES[0], *EYES[1])):
        return None
    return track_of(table, EYES[0]), track_of(table, EYES[1])


def fovs_of(table: Table) -> Array | None:
    """Return (n, 2, 4) half angles of both eyes, or None where the file has none."""
    if not has_group(table, (*FOVS[0], *FOVS[1])):
        return None
    for left, right, up, down in FOVS:
        for low, high in ((left, right), (down, up)):
            bad = np.flatnonzero(~_spans(table.floats([low, high])))
            if len(bad):
                raise table.error(
                    bad[0], low, f"half angles need -π/2 < {low} < {high} < π/2, in radians"
                )
    return table.floats([*FOVS[0], *FOVS[1]]).reshape(-1, 2, 4)


def _spans(low_high: Array) -> NDArray[np.bool_]:
    low, high = low_high.T
    spans: NDArray[np.bool_] = (low < high) & (low > -np.pi / 2) & (high < np.pi / 2)
    return spans
