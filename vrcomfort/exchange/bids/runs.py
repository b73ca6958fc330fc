"""The exposures of a session as runs: which frames, gaze, ratings and events are whose."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from vrcomfort.csv_table import CsvTable
from vrcomfort.records.exposure_rows import DialRow, RatingRow, TaskRow, TrialRow
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.session_rows import EventRow

_EPSILON_S = 1e-6
Cells = dict[str, str]


@dataclass
class Run:
    """One attempt at an exposure.

    Parameters
    ----------
    number
        Its place in ``trials.csv``, from 1.
    gaze
        A row for each frame, or none.
    """

    number: int
    trial: Cells
    frames: list[Cells] = field(default_factory=list)
    gaze: list[Cells] = field(default_factory=list)
    ratings: list[Cells] = field(default_factory=list)
    tasks: list[Cells] = field(default_factory=list)
    dials: list[Cells] = field(default_factory=list)
    events: list[Cells] = field(default_factory=list)

    @property
    def start_s(self) -> float:
        """Return where the run's time begins: its first frame, or the exposure's start."""
        return float(self.frames[0]["session_s"] if self.frames else self.trial["start_s"])

    def holds(self, time_s: float) -> bool:
        """Return whether a moment of the session lies in the exposure."""
        start_s, end_s = float(self.trial["start_s"]), float(self.trial["end_s"])
        return start_s - _EPSILON_S <= time_s <= end_s + _EPSILON_S


def read_runs(folder: Path) -> list[Run]:
    """Return the runs of a session's folder.

    Raises
    ------
    InputError
        If a table is damaged.
    """
    runs = [
        Run(number, trial) for number, trial in enumerate(_rows(folder / TrialRow.FILE), start=1)
    ]
    times: dict[str, Run] = {}
    for row in _stream(folder / FrameRow.FILE):
        run = _of(runs, row["trial"], float(row["session_s"]))
        if run is not None:
            run.frames.append(row)
            times[row["xr_time_ns"]] = run
    if (folder / GazeRow.FILE).exists():
        for row in _stream(folder / GazeRow.FILE):
            if (run := times.get(row["xr_time_ns"])) is not None:
                run.gaze.append(row)
    for row in _rows(folder / RatingRow.FILE):
        run = _of(runs, row["trial"], float(row["onset_s"]))
        if run is not None:
            run.ratings.append(row)
    for kind in (TaskRow, DialRow):
        for row in _rows(folder / kind.FILE) if (folder / kind.FILE).exists() else ():
            run = _of(runs, row["trial"], float(row["onset_s"]))
            if run is not None:
                (run.tasks if kind is TaskRow else run.dials).append(row)
    for row in _rows(folder / EventRow.FILE):
        run = next((each for each in runs if each.holds(float(row["onset_s"]))), None)
        if run is not None and row["name"] not in {"exposure", "answer"}:
            run.events.append(row)
    return runs


def _of(runs: list[Run], trial: str, time_s: float) -> Run | None:
    return next((r for r in runs if r.trial["trial"] == trial and r.holds(time_s)), None)


def _rows(file: Path) -> Iterator[Cells]:
    return CsvTable.read(file, appended=True).dicts()


def _stream(file: Path) -> Iterator[Cells]:
    """Yield the rows of a large file, which has been verified."""
    with file.open(encoding="utf-8", newline="") as stream:
        yield from csv.DictReader(stream)
