"""Reads columns of trace files as arrays; a wrong cell is refused with its place."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from vrcomfort.csv_table import CsvTable, plain_digits
from vrcomfort.errors import InputError
from vrcomfort.geometry import FARTHEST_M, Array
from vrcomfort.records.frame_rows import SNAP_TURN
from vrcomfort.records.shared_columns import HEAD, fov_columns, pose_columns
from vrcomfort.traces.pose_track import PoseTrack, Times

Number = TypeVar("Number", int, float)


@dataclass(frozen=True)
class TraceTable(CsvTable):
    """A table of numbers."""

    def has(self, columns: Sequence[str]) -> bool:
        """Return whether all `columns` are there."""
        return set(columns) <= set(self.header)

    def text(self, column: str) -> list[str]:
        """Return the cells of one column."""
        index = self.header.index(column)
        return [row[index] for row in self.rows]

    def integers(self, column: str) -> NDArray[np.int64]:
        """Return (n,) int64 of one column; raise InputError at the first cell that is none."""
        return np.array(self._numbers(column, _whole, "a whole number"), dtype=np.int64)

    def floats(self, columns: Sequence[str]) -> Array:
        """Return (n, columns) float64; raise InputError at the first cell that is not finite."""
        parsed = [self._numbers(column, _real, "a finite number") for column in columns]
        table = np.array(parsed, dtype=np.float64).T
        bad = np.argwhere(~np.isfinite(table))
        if len(bad):
            row, column = bad[0]
            raise self.error(
                row, columns[column], self._not_a("a finite number", row, columns[column])
            )
        return table

    def positions(self, columns: Sequence[str]) -> Array:
        """Return (n, columns) metres; raise InputError at the first that is nowhere near a scene.

        That is the limit of poses on the command line.
        """
        table = self.floats(columns)
        far = np.argwhere(np.abs(table) > FARTHEST_M)
        if len(far):
            row, column = far[0]
            message = f"{table[row, column]:g} m is more than {FARTHEST_M / 1e3:.0f} km away"
            raise self.error(row, columns[column], f"{message}; positions are metres")
        return table

    def quaternions(self, columns: Sequence[str]) -> Array:
        """Return (n, 4) unit quaternions as written; raise InputError if one is 0.1 % off."""
        table = self.floats(columns)
        norms = np.linalg.norm(table, axis=1)
        bad = np.flatnonzero(np.abs(norms - 1) > 1e-3)
        if len(bad):
            raise self.error(
                bad[0],
                columns[0],
                f"the quaternion {columns[0]} … {columns[-1]} has length {norms[bad[0]]:.6g}; "
                "a rotation needs length 1",
            )
        return table

    def rising(
        self, column: str, values: NDArray[np.int64], *, after: int | None = None
    ) -> NDArray[np.int64]:
        """Return `values` of `column`; raise InputError where they do not rise.

        Parameters
        ----------
        after
            The value in the row before this table's first.
        """
        start = [] if after is None else [after]
        numbers = [*start, *values.tolist()]
        for row, (before, now) in enumerate(pairwise(numbers), start=1 - len(start)):
            if now <= before:
                how = "stands still" if now == before else f"goes back by {before - now} ns"
                raise self.error(row, column, f"time {how}; samples must be in order, each later")
        return values

    def error(self, row: int, column: str, message: str) -> InputError:
        """Return the error of one cell (`row` counts from 0)."""
        return self.fault(message, self.lines[row], column)

    def _numbers(self, column: str, convert: Callable[[str], Number], kind: str) -> list[Number]:
        cells = self.text(column)
        try:
            return [convert(cell) for cell in cells]
        except ValueError:
            row = next(i for i, cell in enumerate(cells) if not _converts(cell, convert))
            raise self.error(row, column, self._not_a(kind, row, column)) from None

    def _not_a(self, kind: str, row: int, column: str) -> str:
        cell = self.rows[row][self.header.index(column)]
        if not cell.strip():
            return f"this cell is empty; it needs {kind}"
        return f"{cell.strip()!r} is not {kind}"


def _real(cell: str) -> float:
    return float(plain_digits(cell))


def _whole(cell: str) -> int:
    return int64(int(plain_digits(cell)))


def int64(number: int) -> int:
    """Return a whole number; raise ValueError if it needs more than 64 bits."""
    if not -(2**63) <= number < 2**63:
        raise ValueError(f"{number} needs more than 64 bits")
    return number


def _converts(cell: str, convert: Callable[[str], Number]) -> bool:
    try:
        convert(cell)
    except ValueError:
        return False
    return True


ROWS_AT_ONCE = 4096
"""Text takes many times the memory of the numbers in it."""


def read_parts(
    path: str | Path, check_header: Callable[[TraceTable], None]
) -> Iterator[TraceTable]:
    """Yield a table some rows at a time; `check_header` may refuse its header.

    No part is empty but the last, which tells what was left out.

    Raises
    ------
    InputError
        As `CsvTable.read`, or if there is no row.
    """
    parts = TraceTable.parts(path, appended=True, most_rows=ROWS_AT_ONCE)
    for number, table in enumerate(parts):
        if number == 0:
            if not table.header:
                message = "the file is empty; a trace starts with a header row"
                raise InputError(message, file=table.file, line=1)
            check_header(table)
            if not table.rows:
                raise table.fault("there is a header but no complete row", 1)
        yield table


TIME, PERIOD, TRIAL = "xr_time_ns", "period_ns", "trial"
DISCONTINUITY = "discontinuity"
"""1 where the pose before has nothing to do with this one (loop, teleport), 2 where the avatar's
heading before does not (snap turn), else 0."""
REQUIRED = (TIME, *HEAD)
HANDS = (pose_columns("left_hand"), pose_columns("right_hand"))
EYES = (pose_columns("left"), pose_columns("right"))
FOVS = (fov_columns("left"), fov_columns("right"))


def require_trace(table: TraceTable) -> None:
    """Raise InputError if a required column is missing: perhaps this is another program's log."""
    if TIME not in table.header and not {*HEAD} & {*table.header}:
        message = f"this is not a trace, which has {TIME} and {HEAD[0]} … {HEAD[-1]}; logs of other"
        raise table.fault(f"{message} programs: `vrcomfort import-trace FILE --out TRACE.csv`", 1)
    table.require(REQUIRED)


def has_group(table: TraceTable, columns: tuple[str, ...]) -> bool:
    """Return whether an optional group of columns is there; half of a group is an error."""
    missing = [name for name in columns if name not in table.header]
    if missing and len(missing) < len(columns):
        there = next(name for name in columns if name in table.header)
        message = f"the column {missing[0]!r} is missing although {there!r} is there"
        raise table.fault(message, 1, missing[0])
    return not missing


def track_of(table: TraceTable, columns: tuple[str, ...]) -> PoseTrack:
    """Return the poses in seven columns."""
    return PoseTrack(table.positions(columns[:3]), table.quaternions(columns[3:]))


def cuts_of(
    table: TraceTable, trial: tuple[str, ...] | None, *, before: str | None, start: bool
) -> NDArray[np.bool_]:
    """Return (n,) bool: the start, changes of trial, and the file's discontinuities.

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


def hands_of(table: TraceTable) -> tuple[PoseTrack | None, PoseTrack | None]:
    """Return stage-from-aim of both hands, NaN in blank rows; None where all are blank."""
    left, right = (
        _track_with_gaps(table, columns) if has_group(table, columns) else None for columns in HANDS
    )
    return left, right


def _track_with_gaps(table: TraceTable, columns: tuple[str, ...]) -> PoseTrack | None:
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


def snap_turns_of(table: TraceTable) -> NDArray[np.bool_] | None:
    """Return (n,) bool where the avatar was turned at once, or None where the file says nothing."""
    return table.integers(DISCONTINUITY) == SNAP_TURN if table.has([DISCONTINUITY]) else None


def periods_of(table: TraceTable) -> Times | None:
    """Return (n,) int64 frame periods, or None where the file has none."""
    if not table.has([PERIOD]):
        return None
    periods = table.integers(PERIOD)
    bad = np.flatnonzero(periods <= 0)
    if len(bad):
        raise table.error(bad[0], PERIOD, "a frame period must be greater than 0 ns")
    return periods


def eyes_of(table: TraceTable) -> tuple[PoseTrack, PoseTrack] | None:
    """Return left and right eye poses, or None where the file has none."""
    if not has_group(table, (*EYES[0], *EYES[1])):
        return None
    return track_of(table, EYES[0]), track_of(table, EYES[1])


def fovs_of(table: TraceTable) -> Array | None:
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
