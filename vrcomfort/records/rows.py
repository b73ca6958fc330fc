"""Row types: their columns are the columns of the CSV files, in order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import ClassVar, Protocol, TypeAlias

from vrcomfort.geometry import Gaze, Pose, View
from vrcomfort.records.pose_columns import POSE_COLUMNS

Cell: TypeAlias = str | int | float | None


class Row(Protocol):
    """A row that knows its file."""

    FILE: ClassVar[str]

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header; None is missing."""


class _FlatRow:
    """A row whose dataclass fields are its columns."""

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""
        return tuple(field.name for field in fields(cls))  # type: ignore[arg-type]

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header."""
        return [getattr(self, name) for name in self.columns()]


@dataclass(frozen=True)
class ParticipantRow(_FlatRow):
    """One participant of the study; `status` is enrolled, completed, withdrawn or excluded."""

    FILE: ClassVar[str] = "participants.csv"
    participant: str
    sequence: str
    status: str
    enrolled_at: str
    note: str = ""


@dataclass(frozen=True)
class TrialRow(_FlatRow):
    """One exposure, written when it ends, however it ends.

    Parameters
    ----------
    period
        Counts the exposures of a participant over all sessions, from 1.
    block, trial
        Count from 1 within the session; `trial` is the exposure's position in it.
    status
        completed, withdrawn (by the participant), stopped (by the stop rule), or aborted.
    abort_code
        Blank, or participant, rating, operator, headset_ended, runtime_lost, error, or killed (the
        program ended without a word; the row was written when the session was resumed).
    attempt
        1, and one more each time that the exposure was begun again.
    resumed
        1 in every row, of every file, written after the session was resumed.
    dropped
        Frames whose interval exceeded 1.2 × the frame period.
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


@dataclass(frozen=True)
class QuestionnaireRow(_FlatRow):
    """One answer. `trial` and `condition` are blank where the whole session is meant.

    Parameters
    ----------
    response
        None where the participant would rather not say.
    order
        Place in the presentation, from 1.
    """

    FILE: ClassVar[str] = "questionnaires.csv"
    participant: str
    session: int
    period: int | None
    block: int | None
    trial: int | None
    condition: str | None
    timepoint: str
    instrument: str
    item: str
    response: int | None
    asked_s: float
    answered_s: float
    order: int
    resumed: int = 0


@dataclass(frozen=True)
class RatingRow(_FlatRow):
    """One rating during exposure; `missed` is 1 where none came in time."""

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
class EventRow(_FlatRow):
    """Something that happened; durations of moments are 0."""

    FILE: ClassVar[str] = "events.csv"
    onset_s: float
    duration_s: float
    name: str
    detail: str = ""
    resumed: int = 0


@dataclass(frozen=True)
class TimingRow(_FlatRow):
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


RAYS = tuple(f"ray_{number}_m" for number in range(1, 10))


@dataclass(frozen=True)
class GazeRow:
    """Where the participant looked in one frame, predicted for its display time.

    Parameters
    ----------
    gaze
        In the stage; blank where it is not valid.
    hit_m
        Where focus follows the gaze: how far away what it meets is, along the head's forward axis.
    """

    FILE: ClassVar[str] = "gaze.csv"
    session_s: float
    xr_time_ns: int
    gaze: Gaze
    hit_m: float | None = None
    resumed: int = 0

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""
        origin = tuple(f"origin_{axis}_m" for axis in "xyz")
        direction = tuple(f"direction_{axis}" for axis in "xyz")
        return ("session_s", "xr_time_ns", "valid", *origin, *direction, "hit_m", "resumed")

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header."""
        ray: list[float | None] = [None] * 6
        if self.gaze.valid:
            ray = [*self.gaze.pose.position.tolist(), *self.gaze.pose.forward.tolist()]
        hit_m = self.hit_m if self.gaze.valid else None
        return [self.session_s, self.xr_time_ns, int(self.gaze.valid), *ray, hit_m, self.resumed]


@dataclass(frozen=True)
class FrameRow:
    """One frame as it was shown.

    Parameters
    ----------
    trial
        0 in training.
    head, left, right
        Poses in stage space, with the eyes' frusta.
    avatar
        world-from-stage.
    rays_m
        Nine distances along the focus rays, the centre first; empty where no focus was computed.
    rays_used
        Nine characters, 1 = used. Read this column as text.
    dropped
        1 where the interval to the frame before exceeded 1.2 × the period.
    discontinuity
        Whether the pose before has nothing to do with this one; a playback cuts there again.
    gaze
        Its row of ``gaze.csv``, which a recorder writes with this one; None without an eye tracker.
    """

    FILE: ClassVar[str] = "frames.csv"
    session_s: float
    xr_time_ns: int
    period_ns: int
    trial: int
    should_render: bool
    head: Pose
    left: View
    right: View
    avatar: Pose
    focus_m: float | None = None
    focus_raw_m: float | None = None
    rays_m: tuple[float, ...] = ()
    rays_used: str | None = None
    max_blur_px: float | None = None
    cpu_ms: float | None = None
    gpu_ms: float | None = None
    dropped: int = 0
    discontinuity: bool = False
    resumed: int = 0
    gaze: GazeRow | None = None

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""
        when = ("session_s", "xr_time_ns", "period_ns", "trial", "should_render")
        focus = ("focus_m", "focus_raw_m", *RAYS, "rays_used")
        costs = ("max_blur_px", "cpu_ms", "gpu_ms", "dropped")
        return (*when, *POSE_COLUMNS, *focus, *costs, "discontinuity", "resumed")

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header."""
        rays = self.rays_m or (None,) * len(RAYS)
        return [
            self.session_s,
            self.xr_time_ns,
            self.period_ns,
            self.trial,
            int(self.should_render),
            *_numbers(self.head),
            *_numbers(self.left.pose),
            *_numbers(self.right.pose),
            *_angles(self.left),
            *_angles(self.right),
            *_numbers(self.avatar),
            self.focus_m,
            self.focus_raw_m,
            *rays,
            self.rays_used,
            self.max_blur_px,
            self.cpu_ms,
            self.gpu_ms,
            self.dropped,
            int(self.discontinuity),
            self.resumed,
        ]


def _numbers(pose: Pose) -> list[float]:
    return [*pose.position.tolist(), *pose.orientation.tolist()]


def _angles(view: View) -> tuple[float, float, float, float]:
    return view.fov.left, view.fov.right, view.fov.up, view.fov.down


def cell_text(value: Cell) -> str:
    """Write a cell: blank for None and for numbers that are none, shortest exact text for floats.

    Line ends inside a text become spaces, so that a row is a line and a cut one is seen.
    """
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ""
    if isinstance(value, str):
        return " ".join(value.splitlines())
    return repr(float(value)) if isinstance(value, float) else str(int(value))
