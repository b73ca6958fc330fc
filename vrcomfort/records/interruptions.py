"""Rows that an interruption may lose: one account for recorder, resume and verify.

`KEPT` says of each file how old a row is at most that may be missing, which rows it relies on, and
when what it tells was over. The recorder syncs by it, resume goes on by it after everything on
record, and verify allows no more. After a signal nothing is missing. After SIGKILL rows are missing
that were not in their files yet, after a power cut those that were not on the disk, and after a
full disk those that it refused; in each file these are the last of the run. A row is written and
synced after those that it relies on, so that it never refers to one that the recorder holds back. A
power cut may still keep the younger of two files, for a disk writes what was not synced in any
order. The event `session_resumed`, and `earlier_runs` in the manifest, tell of each interruption.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from vrcomfort.records.exposure_rows import (
    BallRow,
    DialRow,
    PracticeRow,
    RatingRow,
    TaskRow,
    TimingRow,
    TrialRow,
)
from vrcomfort.records.frame_rows import FrameRow, GazeRow, HandJointsRow, ImageRow, PartRow
from vrcomfort.records.rows import Row
from vrcomfort.records.session_rows import (
    ClockRow,
    EventRow,
    GazeValidationRow,
    QuestionnaireRow,
    ScreeningRow,
    TextRow,
)
from vrcomfort.records.tables import RecordedRow

SYNC_EVERY_S = 0.5
"""So long may a row of a frame wait for its sync: less than promised, for slow disks."""
SAFE_AT_ONCE_S = 0.2
"""What is promised of rows that are synced as they come."""
SAFE_AFTER_S = 1.2
"""What is promised of the others: a row that was handed over so long ago is on the disk."""


class Kept(NamedTuple):
    """The part of a file that survives any interruption.

    Parameters
    ----------
    safe_after_s
        A row that was handed over so long ago is not lost to a power cut.
    over_s
        Columns whose sum is when that was over what a row tells, on the session's clock.
    relies_on
        Files whose waiting rows are written, and synced, before its own.
    """

    row_type: type[Row]
    safe_after_s: float
    over_s: tuple[str, ...]
    relies_on: frozenset[str] = frozenset()


_OF_A_FRAME = frozenset({FrameRow.FILE})
_BEFORE_TRIAL: tuple[Kept, ...] = (
    Kept(FrameRow, SAFE_AFTER_S, ("session_s",)),
    Kept(GazeRow, SAFE_AFTER_S, ("session_s",), _OF_A_FRAME),
    Kept(ImageRow, SAFE_AFTER_S, ("session_s",), _OF_A_FRAME),
    Kept(HandJointsRow, SAFE_AFTER_S, ("session_s",), _OF_A_FRAME),
    Kept(BallRow, SAFE_AFTER_S, ("session_s",), _OF_A_FRAME),
    Kept(PartRow, SAFE_AFTER_S, ("session_s",), _OF_A_FRAME),
    Kept(ClockRow, SAFE_AFTER_S, ("session_s",)),
    Kept(RatingRow, SAFE_AT_ONCE_S, ("onset_s", "latency_s")),
    Kept(TaskRow, SAFE_AT_ONCE_S, ("onset_s", "reaction_s")),
    Kept(DialRow, SAFE_AT_ONCE_S, ("onset_s",)),
    Kept(QuestionnaireRow, SAFE_AT_ONCE_S, ("answered_s",)),
    Kept(TextRow, SAFE_AT_ONCE_S, ("answered_s",)),
    Kept(ScreeningRow, SAFE_AT_ONCE_S, ("decided_s",)),
    Kept(GazeValidationRow, SAFE_AT_ONCE_S, ("onset_s",)),
    Kept(PracticeRow, SAFE_AT_ONCE_S, ("end_s",)),
    Kept(TimingRow, SAFE_AFTER_S, ()),
    Kept(EventRow, SAFE_AT_ONCE_S, ("onset_s", "duration_s"), frozenset({QuestionnaireRow.FILE})),
)
KEPT: tuple[Kept, ...] = (
    *_BEFORE_TRIAL,
    Kept(TrialRow, SAFE_AT_ONCE_S, ("end_s",), frozenset(e.row_type.FILE for e in _BEFORE_TRIAL)),
)
"""Of each file of a session, each after those that its rows refer to."""

WRITTEN_IN_ORDER = tuple(each.row_type.FILE for each in KEPT)
RELIES_ON: Mapping[str, frozenset[str]] = {each.row_type.FILE: each.relies_on for each in KEPT}
SYNCED_AT_ONCE = tuple(each.row_type for each in KEPT if each.safe_after_s == SAFE_AT_ONCE_S)
OF_FRAMES = tuple(each.row_type for each in KEPT if each.relies_on == _OF_A_FRAME)
"""Their rows have the time of a frame."""

RESUMED = "session_resumed"
"""The event with which each run after the first begins."""


class Interruption(NamedTuple):
    """An end of a run that another has followed, or may follow.

    Parameters
    ----------
    session_s
        When the next run began: nothing of this one is later. Infinite where none has begun.
    killed
        The run had no time to close its files: the last rows of some may be missing.
    """

    session_s: float
    killed: bool


def interruptions(manifest: Mapping[str, Any], events: Iterable[RecordedRow]) -> list[Interruption]:
    """Return the interruptions of a session, in order."""
    ended = [run.get("status") == "killed" for run in manifest.get("earlier_runs", [])]
    began_s = [event["onset_s"] for event in events if event["name"] == RESUMED]
    if len(ended) != len(began_s):  # a run was killed before it said that it had begun
        ended = [any(ended)] * len(began_s)
    found = [Interruption(*each) for each in zip(began_s, ended, strict=True)]
    if manifest["status"] == "running":
        found.append(Interruption(float("inf"), killed=True))
    return found
