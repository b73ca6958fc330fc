"""Rows that an interruption may lose: one account for recorder, resume and verify.

After a signal nothing is missing. After SIGKILL rows are missing that were not in their files yet,
after a power cut those that were not on the disk (`SAFE_AFTER_S`), and after a full disk those that
it refused; in each file these are the last of the run. `RELIES_ON` is the order in which files are
written and synced, so that a row never refers to one that the recorder holds back. A power cut may
still keep the younger of two files, for a disk writes what was not synced in any order. The event
`session_resumed`, and `earlier_runs` in the manifest, tell of each interruption.
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
from vrcomfort.records.frame_rows import FrameRow, GazeRow, ImageRow
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

OF_FRAMES: tuple[type[Row], ...] = (GazeRow, ImageRow, BallRow)
"""Their rows have the time of a frame."""

_IN_ORDER: tuple[type[Row], ...] = (
    FrameRow, *OF_FRAMES, ClockRow, RatingRow, TaskRow, DialRow, QuestionnaireRow, TextRow,
    ScreeningRow, GazeValidationRow, PracticeRow, TimingRow, EventRow, TrialRow,
)  # fmt: skip
WRITTEN_IN_ORDER = tuple(each.FILE for each in _IN_ORDER)
"""Files, each after those that its rows refer to."""

RELIES_ON: Mapping[str, frozenset[str]] = {
    **{each.FILE: frozenset({FrameRow.FILE}) for each in OF_FRAMES},
    EventRow.FILE: frozenset({QuestionnaireRow.FILE}),
    TrialRow.FILE: frozenset(WRITTEN_IN_ORDER[:-1]),
}
"""File → files whose waiting rows are written, and synced, before its own."""

SYNC_EVERY_S = 0.5
"""So long may a row of a frame wait for its sync: less than promised, for slow disks."""
SAFE_AFTER_S = 1.2
"""What is promised: a row that was handed over so long ago is on the disk."""

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
