"""Rows of what happens in exposures; their fields are the columns of the files, in order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from vrcomfort.records.rows import FlatRow

OVER = ("completed", "skipped")
"""Statuses of a trial after which the session goes on with the next."""


@dataclass(frozen=True)
class TrialRow(FlatRow):
    """One exposure, written when it ends, however it ends.

    Parameters
    ----------
    period
        Counts the exposures of a participant over all sessions, from 1.
    block, trial
        Count from 1 within the session; `trial` is the exposure's position in it.
    status
        completed, withdrawn (by the participant), stopped (by the stop rule), skipped (by an
        operator: the session went on after it), or aborted.
    abort_code
        Blank, or what ended it early: participant, rating (of a completed trial: the protocol's
        rule ended the exposure alone), operator, redone (an operator had it begun again),
        headset_ended, runtime_lost, error, or killed (the
        program ended without a word; the row was written when the session was resumed).
    attempt
        1, and one more each time that the exposure was begun again.
    resumed
        1 in every row, of every file, written after the session was resumed.
    dropped
        Frames whose interval exceeded 1.2 × the frame period.
    missed_refreshes
        Refreshes of the display that passed without a new frame.
    live_s, frozen_s, hidden_s, unfocused_s
        Seconds of the trial in which frames came, in which none came, in which the participant saw
        nothing of them, and in which something of the runtime's had the input. Blank where it was
        not recorded.
    part
        Of the study, where it has parts.
    """

    FILE: ClassVar[str] = "trials.csv"
    participant: str
    session: int
    period: int
    block: int
    trial: int
    condition: str
    scene: str
    start_s: float
    end_s: float
    status: str
    abort_code: str | None
    attempt: int
    resumed: int
    frames: int
    dropped: int
    missed_refreshes: int | None = None
    live_s: float | None = None
    frozen_s: float | None = None
    hidden_s: float | None = None
    unfocused_s: float | None = None
    part: str | None = None


@dataclass(frozen=True)
class PracticeRow(FlatRow):
    """One exposure of a block of practice, which is no trial of the study.

    Parameters
    ----------
    practice
        Name of the block.
    before_trial
        The trial that it comes before.
    repetition, number
        Of the block in the session, and of the exposure in the block, from 1.
    status
        completed, skipped, redone, withdrawn or aborted.
    targets, hits, shots, score
        Of its task, as in ``tasks.csv``.
    met
        Of a block's last exposure: 1 where the criterion is met, 0 where not; blank without one.
    over
        1 where the block is not shown again, else 0.
    """

    FILE: ClassVar[str] = "practice.csv"
    participant: str
    session: int
    practice: str
    before_trial: int
    repetition: int
    number: int
    condition: str
    scene: str
    task: str
    start_s: float
    end_s: float
    status: str
    targets: int | None = None
    hits: int | None = None
    shots: int | None = None
    score: float | None = None
    met: int | None = None
    over: int = 0
    resumed: int = 0


@dataclass(frozen=True)
class RatingRow(FlatRow):
    """One rating during exposure; `missed` is 0, or the schedule's code (1) where none came."""

    FILE: ClassVar[str] = "ratings.csv"
    participant: str
    session: int
    trial: int
    condition: str
    onset_s: float
    latency_s: float | None
    instrument: str
    response: int | None
    missed: int
    resumed: int = 0


@dataclass(frozen=True)
class TaskRow(FlatRow):
    """Something of a task: a target, a shot, a sample, or the whole trial; blank: means nothing.

    Parameters
    ----------
    attempt
        As in ``trials.csv``.
    task
        Its name in the protocol.
    kind
        target, shot, sample or trial.
    number
        Counts the rows of one kind in an attempt, from 1.
    what
        Name of the target.
    onset_s
        When it began; a shot, when it was made.
    reaction_s
        Of a target that was met: from its beginning.
    hit
        1 for a target that was met and for a shot that met one, else 0.
    error_deg
        Between where somebody pointed (or looked) and the middle of the target.
    distance_m
        To the target, from the path, or of the way that was gone.
    x_m, y_m, z_m
        Of the target, or of the head in a sample, in the world.
    targets, hits, shots, score
        Of the whole trial; `score` is what the task is about.
    """

    FILE: ClassVar[str] = "tasks.csv"
    participant: str
    session: int
    trial: int
    condition: str
    attempt: int
    task: str
    kind: str
    number: int
    what: str
    onset_s: float
    reaction_s: float | None = None
    hit: int | None = None
    error_deg: float | None = None
    distance_m: float | None = None
    x_m: float | None = None
    y_m: float | None = None
    z_m: float | None = None
    targets: int | None = None
    hits: int | None = None
    shots: int | None = None
    score: float | None = None
    resumed: int = 0


@dataclass(frozen=True)
class BallRow(FlatRow):
    """A ball of a task from a frame on, where it is drawn otherwise than in the frame before.

    Parameters
    ----------
    session_s, xr_time_ns, trial
        Those of the frame.
    ball
        Counts the balls of the task from 1.
    x_m, y_m, z_m
        Its middle, in the world.
    radius_m
        0 where it is not to be seen.
    red, green, blue
        Its colour, linear.
    """

    FILE: ClassVar[str] = "balls.csv"
    session_s: float
    xr_time_ns: int
    trial: int
    ball: int
    x_m: float
    y_m: float
    z_m: float
    radius_m: float
    red: float
    green: float
    blue: float
    resumed: int = 0


@dataclass(frozen=True)
class DialRow(FlatRow):
    """Where a dial was turned to during an exposure.

    Parameters
    ----------
    attempt
        As in ``trials.csv``.
    dial
        Its name in the protocol.
    setting
        Of an adjustment: what it changes in the condition.
    instrument
        Of a slider: what is rated.
    kind
        start (where it stood when the exposure began), change (of an adjustment), sample (of a
        slider), confirmed, or end (where it stood when the exposure ended and nothing was
        confirmed).
    value
        In the setting's unit, drawn from that frame on; or on the instrument's scale.
    """

    FILE: ClassVar[str] = "dials.csv"
    participant: str
    session: int
    trial: int
    condition: str
    attempt: int
    dial: str
    setting: str
    instrument: str
    kind: str
    onset_s: float
    value: float
    resumed: int = 0


@dataclass(frozen=True)
class TimingRow(FlatRow):
    """How regularly the frames of one attempt at a trial came, and what they cost.

    Parameters
    ----------
    frames, dropped, dropped_percent
        As in ``trials.csv``, and their ratio.
    interval_*
        Times between two frames that followed each other, by their predicted display times.
    cpu_*, gpu_*
        Of the frames that were rendered; blank where the GPU is not timed.
    flagged
        1 where more was dropped than the protocol's `max_dropped_percent`.

    Notes
    -----
    Percentiles are nearest ranks (the smallest value that so many percent do not exceed) of
    values rounded to 0.01 ms.
    """

    FILE: ClassVar[str] = "timing.csv"
    participant: str
    session: int
    trial: int
    condition: str
    attempt: int
    frames: int
    dropped: int
    dropped_percent: float | None
    interval_median_ms: float | None
    interval_p95_ms: float | None
    interval_p99_ms: float | None
    cpu_median_ms: float | None
    cpu_p95_ms: float | None
    cpu_p99_ms: float | None
    gpu_median_ms: float | None
    gpu_p95_ms: float | None
    gpu_p99_ms: float | None
    flagged: int
    resumed: int = 0
