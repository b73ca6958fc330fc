"""Rows of exposures: trials, practice, ratings, tasks, targets, adjustments, timing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from vrcomfort.records.rows import MOTION, Column, Needs, Row
from vrcomfort.records.shared_columns import (
    Attempt,
    ConditionName,
    EndS,
    FrameS,
    FrameTimeNs,
    FrameTrial,
    Hits,
    OnsetS,
    ParticipantName,
    PartOfStudy,
    Resumed,
    SceneName,
    Score,
    SessionNumber,
    Shots,
    StartS,
    Targets,
    TrialNumber,
)

OVER = ("completed", "skipped")
"""Statuses of a trial after which the session goes on with the next."""

_NOT_RECORDED = "it was not recorded"


@dataclass(frozen=True)
class TrialRow(Row):
    """One attempt at an exposure, written when it ends, however it ends."""

    FILE: ClassVar[str] = "trials.csv"
    participant: ParticipantName
    session: SessionNumber
    period: Annotated[
        int, Column("Place of the exposure among all of the participant's, from 1, over sessions")
    ]
    block: Annotated[int, Column("Number of the block in the session, from 1")]
    trial: TrialNumber
    condition: ConditionName
    scene: SceneName
    start_s: StartS
    end_s: EndS
    status: Annotated[
        str,
        Column(
            "completed, withdrawn (by the participant), stopped (by the stop rule), skipped (by an "
            "operator: the session went on after it), or aborted"
        ),
    ]
    abort_code: Annotated[
        str | None,
        Column(
            "What ended it early: participant, rating (of a completed trial: the protocol's rule "
            "ended the exposure alone), operator, redone (an operator had it begun again), "
            "headset_ended, runtime_lost, error, or killed (the program ended without a word; the "
            "row was written when the session was resumed)",
            blank="nothing did",
        ),
    ]
    attempt: Attempt
    resumed: Resumed
    frames: Annotated[int, Column("Frames that were shown")]
    dropped: Annotated[int, Column("Frames whose interval exceeded 1.2 times the frame period")]
    missed_refreshes: Annotated[
        int | None,
        Column("Refreshes of the display without a new frame", blank=_NOT_RECORDED, since=2),
    ] = None
    live_s: Annotated[
        float | None,
        Column(
            "Time in which each frame was shown for its period, and nothing of what the other "
            "seconds of the row say held; before version 5 also where the head was not tracked",
            blank=_NOT_RECORDED,
            since=2,
        ),
    ] = None
    frozen_s: Annotated[
        float | None,
        Column(
            "Time in which the picture stood still: beyond a frame's period, where that was more "
            "than 0.5 s; before version 5 beyond the period of each late frame",
            blank=_NOT_RECORDED,
            since=2,
        ),
    ] = None
    hidden_s: Annotated[
        float | None,
        Column(
            "Time in which nothing was visible: a pause, a session that the runtime did not show, "
            "no frames; before version 5 also the headset off, and no picture wanted",
            blank=_NOT_RECORDED,
            since=2,
        ),
    ] = None
    unfocused_s: Annotated[
        float | None,
        Column(
            "Time in which a menu of the headset's was in front; from version 5 on while the head "
            "was tracked and frames came in time",
            blank=_NOT_RECORDED,
            since=2,
        ),
    ] = None
    part: PartOfStudy = None
    off_s: Annotated[
        float | None,
        Column(
            "Time in which the headset was off: its presence sensor saw nobody",
            blank=_NOT_RECORDED,
            since=5,
        ),
    ] = None
    not_drawn_s: Annotated[
        float | None,
        Column("Time in which the runtime wanted no picture", blank=_NOT_RECORDED, since=5),
    ] = None
    half_rate_s: Annotated[
        float | None,
        Column(
            "Time in which frames came at half the display's rate or less, and did not stand still "
            "as in `frozen_s`",
            blank=_NOT_RECORDED,
            since=5,
        ),
    ] = None
    untracked_s: Annotated[
        float | None,
        Column(
            "Time in which the head's pose was not measured, and frames came in time",
            blank=_NOT_RECORDED,
            since=5,
        ),
    ] = None


@dataclass(frozen=True)
class PracticeRow(Row):
    """One exposure of a block of practice, which is no trial of the study."""

    FILE: ClassVar[str] = "practice.csv"
    participant: ParticipantName
    session: SessionNumber
    practice: Annotated[str, Column("Block of practice, as the protocol names it")]
    before_trial: Annotated[int, Column("Trial of the session that the practice comes before")]
    repetition: Annotated[int, Column("Repetition of the block in the session, from 1")]
    number: Annotated[int, Column("Place of the exposure in the repetition, from 1")]
    condition: ConditionName
    scene: SceneName
    task: Annotated[
        str, Column("The exposure's task, as the protocol names it", blank="it had none")
    ]
    start_s: StartS
    end_s: EndS
    status: Annotated[
        str,
        Column(
            "completed, skipped or redone (by an operator), withdrawn (by the participant), or "
            "aborted"
        ),
    ]
    targets: Targets = None
    hits: Hits = None
    shots: Shots = None
    score: Score = None
    met: Annotated[
        int | None,
        Column(
            "Of a block's last exposure: 1 where its criterion is met, 0 where not",
            blank="it is not the last, or has no criterion",
        ),
    ] = None
    over: Annotated[int, Column("1 where the block is not shown again, else 0")] = 0
    resumed: Resumed = 0


@dataclass(frozen=True)
class RatingRow(Row):
    """One rating during an exposure."""

    FILE: ClassVar[str] = "ratings.csv"
    participant: ParticipantName
    session: SessionNumber
    trial: TrialNumber
    condition: ConditionName
    onset_s: OnsetS
    latency_s: Annotated[float | None, Column("Time until the rating came", blank="it was missed")]
    instrument: Annotated[str, Column("Rating scale")]
    response: Annotated[
        int | None,
        Column("The rating, as the instrument codes it", blank="it was missed", signed=True),
    ]
    missed: Annotated[
        int, Column("0 where a rating came in time, else 1, or the protocol's `missed_code`")
    ]
    resumed: Resumed = 0


_NOT_OF_THE_ROW = "it means nothing for the row"


@dataclass(frozen=True)
class TaskRow(Row):
    """A target, shot or sample of a task, or the sums over a trial."""

    FILE: ClassVar[str] = "tasks.csv"
    participant: ParticipantName
    session: SessionNumber
    trial: TrialNumber
    condition: ConditionName
    attempt: Attempt
    task: Annotated[str, Column("The exposure's task, as the protocol names it")]
    kind: Annotated[str, Column("target (told when it is over), shot, sample or trial (the sums)")]
    number: Annotated[int, Column("Counts the rows of one kind in an attempt, from 1")]
    what: Annotated[str, Column("Name of the target", blank="the row has none")]
    onset_s: Annotated[
        float,
        Column(
            "When a target appeared, a shot or sample was made, or the trial began, on the "
            "session's clock"
        ),
    ]
    reaction_s: Annotated[
        float | None,
        Column("Time from the appearance of a target until it was met", blank="it was not met"),
    ] = None
    hit: Annotated[
        int | None,
        Column(
            "1 for a target that was met and a shot that met one, else 0", blank=_NOT_OF_THE_ROW
        ),
    ] = None
    error_deg: Annotated[
        float | None,
        Column("Angle between aim or gaze and the target's middle", blank=_NOT_OF_THE_ROW),
    ] = None
    distance_m: Annotated[
        float | None,
        Column("Distance to the target, from the path, or gone so far", blank=_NOT_OF_THE_ROW),
    ] = None
    x_m: Annotated[
        float | None,
        Column(
            "Place of the target, or of the head in a sample, in the world, to the right",
            blank=_NOT_OF_THE_ROW,
            needs=MOTION,
            signed=True,
        ),
    ] = None
    y_m: Annotated[
        float | None,
        Column(
            "Place of the target, or of the head in a sample, in the world, upwards",
            blank=_NOT_OF_THE_ROW,
            needs=MOTION,
            signed=True,
        ),
    ] = None
    z_m: Annotated[
        float | None,
        Column(
            "Place of the target, or of the head in a sample, in the world, backwards",
            blank=_NOT_OF_THE_ROW,
            needs=MOTION,
            signed=True,
        ),
    ] = None
    targets: Targets = None
    hits: Hits = None
    shots: Shots = None
    score: Score = None
    deaths: Annotated[
        int | None,
        Column("How often opponents won", blank="the row has no opponents", since=6),
    ] = None
    resumed: Resumed = 0


@dataclass(frozen=True)
class BallRow(Row):
    """A ball of a task from a frame on, where it is drawn otherwise than in the frame before."""

    FILE: ClassVar[str] = "balls.csv"
    NEEDS: ClassVar[Needs] = MOTION
    session_s: FrameS
    xr_time_ns: FrameTimeNs
    trial: FrameTrial
    ball: Annotated[int, Column("Counts the balls of the task, from 1")]
    x_m: Annotated[float, Column("Its centre in the world, to the right", signed=True)]
    y_m: Annotated[float, Column("Its centre in the world, upwards", signed=True)]
    z_m: Annotated[float, Column("Its centre in the world, backwards", signed=True)]
    radius_m: Annotated[float, Column("Its radius; 0 where it is not to be seen")]
    red: Annotated[float, Column("Red of its colour, linear")]
    green: Annotated[float, Column("Green of its colour, linear")]
    blue: Annotated[float, Column("Blue of its colour, linear")]
    resumed: Resumed = 0


@dataclass(frozen=True)
class DialRow(Row):
    """A turn of a dial during an exposure, or a sample of a slider."""

    FILE: ClassVar[str] = "dials.csv"
    participant: ParticipantName
    session: SessionNumber
    trial: TrialNumber
    condition: ConditionName
    attempt: Attempt
    dial: Annotated[str, Column("The dial that was turned, as the protocol names it")]
    setting: Annotated[
        str, Column("What an adjustment changes in the condition", blank="it is a slider")
    ]
    instrument: Annotated[str, Column("Rating scale of a slider", blank="it is an adjustment")]
    kind: Annotated[
        str,
        Column(
            "start (where it stood when the exposure began), change (of an adjustment), sample (of "
            "a slider), confirmed, or end (the exposure ended, and nothing was confirmed)"
        ),
    ]
    onset_s: OnsetS
    value: Annotated[
        float,
        Column(
            "Where it stood from then on: in the setting's unit, or on the instrument's scale",
            signed=True,
        ),
    ]
    resumed: Resumed = 0


_NO_FRAMES = "there were too few frames"
_NOT_TIMED = "the GPU was not timed"


@dataclass(frozen=True)
class TimingRow(Row):
    """Regularity and cost of the frames of one attempt at a trial.

    Notes
    -----
    Percentiles are nearest ranks (the smallest value that so many percent do not exceed) of
    values rounded to 0.01 ms.
    """

    FILE: ClassVar[str] = "timing.csv"
    participant: ParticipantName
    session: SessionNumber
    trial: TrialNumber
    condition: ConditionName
    attempt: Attempt
    frames: Annotated[int, Column("Frames that were shown")]
    dropped: Annotated[int, Column("Frames whose interval exceeded 1.2 times the frame period")]
    dropped_percent: Annotated[
        float | None, Column("Share of the frames that were dropped", blank=_NO_FRAMES)
    ]
    interval_median_ms: Annotated[
        float | None,
        Column(
            "Median interval between predicted display times of frames that follow each other",
            blank=_NO_FRAMES,
        ),
    ]
    interval_p95_ms: Annotated[
        float | None, Column("95th percentile of the intervals", blank=_NO_FRAMES)
    ]
    interval_p99_ms: Annotated[
        float | None, Column("99th percentile of the intervals", blank=_NO_FRAMES)
    ]
    cpu_median_ms: Annotated[
        float | None, Column("Median CPU time of the rendered frames", blank=_NO_FRAMES)
    ]
    cpu_p95_ms: Annotated[
        float | None, Column("95th percentile of the CPU times", blank=_NO_FRAMES)
    ]
    cpu_p99_ms: Annotated[
        float | None, Column("99th percentile of the CPU times", blank=_NO_FRAMES)
    ]
    gpu_median_ms: Annotated[
        float | None, Column("Median GPU time of the rendered frames", blank=_NOT_TIMED)
    ]
    gpu_p95_ms: Annotated[
        float | None, Column("95th percentile of the GPU times", blank=_NOT_TIMED)
    ]
    gpu_p99_ms: Annotated[
        float | None, Column("99th percentile of the GPU times", blank=_NOT_TIMED)
    ]
    flagged: Annotated[
        int,
        Column(
            "1 where too many frames were dropped, the picture stood still for too long, the head "
            "was hardly tracked, or a menu was in front"
        ),
    ]
    resumed: Resumed = 0
