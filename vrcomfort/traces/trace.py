"""Head traces: poses over time, as arrays, with their files.

A trace file is a CSV with the pose columns of `frames.csv` (`records.pose_columns`): time and
head are required, the rest is optional and further columns are ignored.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrcomfort.errors import InputError
from vrcomfort.files import sha256_of
from vrcomfort.geometry import Array
from vrcomfort.records.frame_rows import CUT, SNAP_TURN, FrameRow, GazeRow
from vrcomfort.records.shared_columns import AVATAR, HEAD
from vrcomfort.traces.gaze_track import GazeTrack, read_gaze
from vrcomfort.traces.pose_track import PoseTrack, Times
from vrcomfort.traces.table import (
    DISCONTINUITY,
    EYES,
    FOVS,
    HANDS,
    PERIOD,
    ROWS_AT_ONCE,
    TIME,
    TRIAL,
    TraceTable,
    cuts_of,
    eyes_of,
    fovs_of,
    hands_of,
    has_group,
    periods_of,
    read_parts,
    require_trace,
    snap_turns_of,
    track_of,
)


@dataclass(frozen=True, eq=False)
class Trace:
    """A head trace: poses over time, with hands, eyes and gaze where they were recorded.

    Parameters
    ----------
    time_ns
        (n,) int64, rising.
    head
        stage-from-head.
    cuts
        (n,) bool, True where the sample has nothing to do with the one before; the first is.
    period_ns
        (n,) int64 frame period at each sample, or None.
    eyes
        stage-from-eye, left and right, or None.
    fovs
        (n, 2, 4) half angles left, right, up, down of both eyes in radians, or None.
    avatar
        world-from-stage, or None where the trace knows no world.
    snap_turns
        (n,) bool, True where the avatar was turned at once, or None where there is none.
    left_hand, right_hand
        stage-from-aim, NaN where the hand was not known, or None where the trace has no hand.
    trial
        Name of the trial of each sample, or None.
    gaze
        What an eye tracker saw, or None.
    warnings
        What was left out while reading.
    sha256
        Of the file that it, or more than it, was read from; None where it is of no file.
    """

    time_ns: Times
    head: PoseTrack
    cuts: NDArray[np.bool_]
    period_ns: Times | None = None
    eyes: tuple[PoseTrack, PoseTrack] | None = None
    fovs: Array | None = None
    avatar: PoseTrack | None = None
    snap_turns: NDArray[np.bool_] | None = None
    left_hand: PoseTrack | None = None
    right_hand: PoseTrack | None = None
    trial: tuple[str, ...] | None = None
    gaze: GazeTrack | None = None
    warnings: tuple[str, ...] = ()
    sha256: str | None = field(default=None, repr=False)

    def __len__(self) -> int:
        return len(self.time_ns)

    @property
    def duration_s(self) -> float:
        """Return the time from the first to the last sample."""
        return float(self.time_ns[-1] - self.time_ns[0]) * 1e-9

    @cached_property
    def median_period_ns(self) -> int:
        """Return the median time between samples (cuts aside), 1/72 s for a single sample."""
        steps = np.diff(self.time_ns)[~self.cuts[1:]]
        return int(np.median(steps)) if len(steps) else round(1e9 / 72)

    def only_trial(self, name: str) -> Trace:
        """Return the samples of one trial.

        Raises
        ------
        InputError
            If the trace has no such trial.
        """
        trials = np.array(self.trial or ())
        keep = trials == name
        if not keep.any():
            known = ", ".join(dict.fromkeys(self.trial or ())) or "none"
            raise InputError(f"the trace has no trial {name!r}; it has: {known}")
        return self._part(keep)

    def between(self, first: int, end: int) -> Trace:
        """Return the samples from `first` up to but without `end`; the first is a cut."""
        rows = np.arange(len(self))
        return self._part((rows >= first) & (rows < end))

    def _part(self, keep: NDArray[np.bool_]) -> Trace:
        # A gap left by samples that are not kept is a cut, like the start.
        after_gap = np.concatenate([[True], np.diff(np.flatnonzero(keep)) > 1])
        return replace(
            self,
            time_ns=self.time_ns[keep],
            head=self.head[keep],
            cuts=self.cuts[keep] | after_gap,
            period_ns=None if self.period_ns is None else self.period_ns[keep],
            eyes=None if self.eyes is None else (self.eyes[0][keep], self.eyes[1][keep]),
            fovs=None if self.fovs is None else self.fovs[keep],
            avatar=None if self.avatar is None else self.avatar[keep],
            snap_turns=None if self.snap_turns is None else self.snap_turns[keep],
            left_hand=None if self.left_hand is None else self.left_hand[keep],
            right_hand=None if self.right_hand is None else self.right_hand[keep],
            trial=tuple(np.array(self.trial)[keep].tolist()) if self.trial else None,
        )


def read_trace(path: str | Path) -> Trace:
    """Read a trace, or a recorded `frames.csv`, which is one.

    A half-written last line is left out and named in `Trace.warnings`. The `gaze.csv` that a
    session leaves beside its `frames.csv` belongs to it.

    Raises
    ------
    InputError
        With file, line and column: a missing column, an empty cell, NaN, a quaternion that is
        not unit, time that does not rise, or a file of another kind.
    """
    file = Path(path)
    parts: list[Trace] = []
    for table in read_parts(file, require_trace):
        parts.append(_part_of(table, parts[-1] if parts else None))
    return replace(joined(parts), gaze=_gaze_beside(file), sha256=sha256_of(file))


def _part_of(table: TraceTable, before: Trace | None) -> Trace:
    """Return the trace in a part of a table, given that of the part before."""
    # The same few names in every row: kept once.
    trial = tuple(map(sys.intern, table.text(TRIAL))) if table.has([TRIAL]) else None
    last = None if before is None else int(before.time_ns[-1])
    last_trial = before.trial[-1] if before is not None and before.trial else None
    left_hand, right_hand = hands_of(table)
    return Trace(
        time_ns=table.rising(TIME, table.integers(TIME), after=last),
        head=track_of(table, HEAD),
        cuts=cuts_of(table, trial, before=last_trial, start=before is None),
        period_ns=periods_of(table),
        eyes=eyes_of(table),
        fovs=fovs_of(table),
        avatar=track_of(table, AVATAR) if has_group(table, AVATAR) else None,
        snap_turns=snap_turns_of(table),
        left_hand=left_hand,
        right_hand=right_hand,
        trial=trial,
        warnings=table.warnings,
    )


def joined(parts: list[Trace]) -> Trace:
    """Return one trace of parts that follow each other; empties the list, to save memory."""
    fields = {name: [getattr(part, name) for part in parts] for name in _JOINED}
    for hand in _HANDS:
        fields[hand] = _with_gaps(fields[hand], [len(part) for part in parts])
    rest = replace(parts[0], warnings=tuple(w for part in parts for w in part.warnings))
    parts.clear()
    return replace(rest, **{name: _join(fields.pop(name)) for name in _JOINED})


_HANDS = ("left_hand", "right_hand")
_JOINED = (
    "time_ns", "head", "cuts", "period_ns", "eyes", "fovs", "avatar", "snap_turns", *_HANDS,
    "trial",
)  # fmt: skip


def _with_gaps(tracks: list[PoseTrack | None], lengths: list[int]) -> list[PoseTrack | None]:
    """Return NaN in place of parts in which a hand is never known, if it is known in another."""
    if not any(tracks):
        return tracks
    return [
        track or PoseTrack(np.full((length, 3), np.nan), np.full((length, 4), np.nan))
        for track, length in zip(tracks, lengths, strict=True)
    ]


def _join(values: list[Any]) -> Any:
    """Return one array, track, pair of tracks or tuple of names of several that follow."""
    if values[0] is None:
        return None
    if isinstance(values[0], np.ndarray):
        return np.concatenate(values)
    if isinstance(values[0], PoseTrack):
        positions = np.concatenate([each.positions for each in values])
        return PoseTrack(positions, np.concatenate([each.orientations for each in values]))
    if isinstance(values[0][0], PoseTrack):
        return tuple(_join(list(eye)) for eye in zip(*values, strict=True))
    return tuple(chain.from_iterable(values))


def _gaze_beside(file: Path) -> GazeTrack | None:
    gaze = file.with_name(GazeRow.FILE)
    return read_gaze(gaze) if file.name == FrameRow.FILE and gaze.exists() else None


def write_trace(trace: Trace, path: str | Path) -> None:
    """Write a trace; floats as the shortest text that reads back the same."""
    with Path(path).open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        for start in range(0, len(trace), ROWS_AT_ONCE):
            columns = _written_columns(trace, slice(start, start + ROWS_AT_ONCE))
            if start == 0:
                writer.writerow(columns)
            writer.writerows(zip(*columns.values(), strict=True))


def _marks(trace: Trace) -> NDArray[np.int64]:
    snap_turns = np.zeros_like(trace.cuts) if trace.snap_turns is None else trace.snap_turns
    marks: NDArray[np.int64] = np.where(trace.cuts, CUT, np.where(snap_turns, SNAP_TURN, 0))
    return marks


def _written_columns(trace: Trace, rows: slice) -> dict[str, list[str]]:
    columns = {TIME: [str(value) for value in trace.time_ns[rows].tolist()]}
    if trace.period_ns is not None:
        columns[PERIOD] = [str(value) for value in trace.period_ns[rows].tolist()]
    if trace.trial is not None:
        columns[TRIAL] = list(trace.trial[rows])
    marks = _marks(trace)
    if marks[1:].any():
        columns[DISCONTINUITY] = [str(mark) for mark in marks[rows].tolist()]
    groups: list[tuple[tuple[str, ...], Array]] = [(HEAD, trace.head[rows].cells())]
    if trace.eyes is not None:
        groups += [(name, eye[rows].cells()) for name, eye in zip(EYES, trace.eyes, strict=True)]
    if trace.fovs is not None:
        groups += [(name, trace.fovs[rows, eye]) for eye, name in enumerate(FOVS)]
    if trace.avatar is not None:
        groups.append((AVATAR, trace.avatar[rows].cells()))
    for hand, track in zip(HANDS, (trace.left_hand, trace.right_hand), strict=True):
        if track is not None:
            groups.append((hand, track[rows].cells()))
    for group, table in groups:
        for name, values in zip(group, table.T.tolist(), strict=True):
            columns[name] = ["" if isnan(value) else repr(value) for value in values]
    return columns
