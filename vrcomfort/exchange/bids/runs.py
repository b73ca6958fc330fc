"""The exposures of a session as runs: which frames, gaze, ratings and events are whose."""

from __future__ import annotations

from dataclasses import dataclass, field

from vrcomfort.records.attempts import Attempt, FramesOfAttempts
from vrcomfort.records.exposure_rows import DialRow, RatingRow, TaskRow, TrialRow
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.reader import Session
from vrcomfort.records.session_rows import EventRow
from vrcomfort.records.times import within

_WHOLE = "trial", "attempt", "frames", "resumed"
_TIMES = "session_s", "start_s", "end_s"
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

    @property
    def attempt(self) -> Attempt:
        """Return which it is."""
        return int(self.trial["trial"]), int(self.trial["attempt"])

    def holds(self, time_s: float) -> bool:
        """Return whether a moment of the session lies in the exposure."""
        return within(time_s, float(self.trial["start_s"]), float(self.trial["end_s"]))


def read_runs(session: Session) -> list[Run]:
    """Return the runs of a session.

    Raises
    ------
    InputError
        If a table is damaged.
    """
    runs = [Run(number, row) for number, row in enumerate(session.text_rows(TrialRow), start=1)]
    times: dict[str, Run] = {}
    of_attempt = {run.attempt: run for run in runs}
    attempts = FramesOfAttempts(_numbers(run.trial) for run in runs)
    for row in session.text_rows(FrameRow):
        if (attempt := attempts.add(_numbers(row))) is not None:
            of_attempt[attempt].frames.append(row)
            times[row["xr_time_ns"]] = of_attempt[attempt]
    for row in session.text_rows(GazeRow):
        if (run := times.get(row["xr_time_ns"])) is not None:
            run.gaze.append(row)
    for row in session.text_rows(RatingRow):
        run = _of(runs, row["trial"], float(row["onset_s"]))
        if run is not None:
            run.ratings.append(row)
    for kind in (TaskRow, DialRow):
        for row in session.text_rows(kind):
            run = of_attempt.get((int(row["trial"]), int(row["attempt"])))
            if run is not None:
                (run.tasks if kind is TaskRow else run.dials).append(row)
    for row in session.text_rows(EventRow):
        run = next((each for each in runs if each.holds(float(row["onset_s"]))), None)
        if run is not None and row["name"] not in {"exposure", "answer"}:
            run.events.append(row)
    return runs


def _of(runs: list[Run], trial: str, time_s: float) -> Run | None:
    return next((r for r in runs if r.trial["trial"] == trial and r.holds(time_s)), None)


def _numbers(row: Cells) -> dict[str, float]:
    """Return what tells which attempt a row is of."""
    whole = {name: int(row[name]) for name in _WHOLE if name in row}
    return {**whole, **{name: float(row[name]) for name in _TIMES if name in row}}
