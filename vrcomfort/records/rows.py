"""Row types: their columns are the columns of the CSV files, in order."""

from __future__ import annotations

import csv
import io
import math
import re
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, ClassVar, Protocol, TypeAlias

Cell: TypeAlias = str | int | float | None

OVER = ("completed", "skipped")
"""Statuses of a trial after which the session goes on with the next."""


class Row(Protocol):
    """A row that knows its file."""

    FILE: ClassVar[str]

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header; None is missing."""


@cache
def _names(row_type: Any) -> tuple[str, ...]:
    """Return the names of a dataclass's fields: they are asked for with every row."""
    return tuple(field.name for field in fields(row_type))


class FlatRow:
    """A row whose dataclass fields are its columns."""

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the header."""
        return _names(cls)  # type: ignore[arg-type]

    def cells(self) -> Sequence[Cell]:
        """Return the values in the order of the header."""
        return [getattr(self, name) for name in self.columns()]


FACTS = ("gaze_validation_error_deg",)
"""Columns of participants.csv that sessions fill in."""


@dataclass(frozen=True)
class ParticipantRow(FlatRow):
    """One participant of the study; `status` is enrolled, completed, withdrawn or excluded.

    Parameters
    ----------
    others
        Further columns, which follow: `group` where the protocol has groups, and its covariates.
    """

    FILE: ClassVar[str] = "participants.csv"
    participant: str
    sequence: str
    status: str
    enrolled_at: str
    note: str = ""
    others: tuple[tuple[str, str], ...] = ()

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """Return the columns that every study has."""
        return _names(cls)[:-1]  # type: ignore[arg-type]

    @property
    def group(self) -> str | None:
        """Return the level of the between-subject factor."""
        return dict(self.others).get("group")

    @property
    def covariates(self) -> dict[str, str]:
        """Return what was entered at the enrolment."""
        return {name: value for name, value in self.others if name not in {"group", *FACTS}}


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
class QuestionnaireRow(FlatRow):
    """One answer. `trial` and `condition` are blank where the whole session is meant.

    Parameters
    ----------
    response
        None where the participant would rather not say.
    order
        Place in the presentation, from 1.
    part
        Of the study, where it has parts and all exposures that are meant belong to one.
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
    part: str | None = None
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


IPD_RULE = "distance between pupils in mm"
"""What the rule is called that a headset's fit makes."""


@dataclass(frozen=True)
class ScreeningRow(FlatRow):
    """A number beyond a screening rule, and what the experimenter decided.

    Parameters
    ----------
    rule
        What was beyond which bound.
    value
        The number; blank in anonymous copies where it is of the body.
    decision
        go_on or stop.
    """

    FILE: ClassVar[str] = "screening.csv"
    participant: str
    session: int
    rule: str
    value: float | None
    decision: str
    decided_s: float
    resumed: int = 0


LONGEST_TEXT = 20_000
"""Characters of an answer in one's own words, as they are written."""


@dataclass(frozen=True)
class TextRow(FlatRow):
    """An answer in one's own words; `trial` and `condition` are blank where the session is meant.

    Parameters
    ----------
    text
        In one line (`one_line`); blank where nothing was said.
    """

    FILE: ClassVar[str] = "texts.csv"
    participant: str
    session: int
    trial: int | None
    condition: str | None
    question: str
    text: str
    asked_s: float
    answered_s: float
    resumed: int = 0


def one_line(text: str) -> str:
    r"""Return a text in one line: \\ for \, \n for a line end, \uXXXX for what is no letter.

    Control characters, other line ends and halves of pairs would break rows; `in_lines` turns it
    back.
    """
    return "".join(map(_escaped, text.replace("\r\n", "\n").replace("\r", "\n")))


def _escaped(letter: str) -> str:
    if letter == "\\":
        return "\\\\"
    if letter == "\n":
        return "\\n"
    plain = unicodedata.category(letter) not in {"Cc", "Cs", "Zl", "Zp"}
    return letter if plain else f"\\u{ord(letter):04x}"


def in_lines(text: str) -> str:
    """Return the text that `one_line` has written."""
    return _ESCAPE.sub(_meant, text)


_ESCAPE = re.compile(r"\\(?:(\\|n)|u([0-9a-f]{4}))")


def _meant(found: re.Match[str]) -> str:
    if found[2]:
        return chr(int(found[2], 16))
    return "\n" if found[1] == "n" else "\\"


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
class GazeValidationRow(FlatRow):
    """How good the gaze on one point was, or (point blank) the mean over all points.

    Parameters
    ----------
    validation, attempt
        Count from 1 in a session; an attempt is repeated where it was not good enough.
    before_trial
        The exposure that it was before.
    eye
        combined: the gaze that the runtime gives for both; left, right: where it tells them apart.
    right_deg, up_deg, distance_m
        Where the point was, seen from the head when it appeared.
    samples, valid_percent
        Frames that counted, and the share of them in which the eyes were seen.
    accuracy_deg, precision_rms_deg, precision_sd_deg
        See `vrcomfort.traces.gaze_quality`; blank without a valid sample.
    good
        Of the mean: 1 where it is within the protocol's limit, else 0.
    """

    FILE: ClassVar[str] = "gaze_validation.csv"
    participant: str
    session: int
    validation: int
    attempt: int
    before_trial: int
    onset_s: float
    point: int | None
    eye: str
    right_deg: float | None
    up_deg: float | None
    distance_m: float | None
    samples: int
    valid_percent: float
    accuracy_deg: float | None
    precision_rms_deg: float | None
    precision_sd_deg: float | None
    good: int | None = None
    resumed: int = 0


@dataclass(frozen=True)
class EventRow(FlatRow):
    """Something that happened; durations of moments are 0."""

    FILE: ClassVar[str] = "events.csv"
    onset_s: float
    duration_s: float
    name: str
    detail: str = ""
    resumed: int = 0


@dataclass(frozen=True)
class ClockRow(FlatRow):
    """All clocks, read at one moment.

    Parameters
    ----------
    xr_time_ns
        The moment as a display time, as ``frames.csv`` has them; None where the headset does not
        tell.
    monotonic_ns, unix_ns
        The system's monotonic clock, and its time since 1970.
    lsl_s
        The clock of LabStreamingLayer; None where it is not used.
    took_ns
        How long the reading took: they are of one moment to half of this.
    """

    FILE: ClassVar[str] = "clocks.csv"
    session_s: float
    xr_time_ns: int | None
    monotonic_ns: int
    unix_ns: int
    lsl_s: float | None
    took_ns: int
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


def cell_text(value: Cell) -> str:
    """Write a cell: blank for None and for numbers that are none, shortest exact text for floats.

    Line ends inside a text become spaces, so that a row is a line and a cut one is seen.
    """
    if isinstance(value, float):  # most are
        return repr(float(value)) if math.isfinite(value) else ""
    if value is None:
        return ""
    return " ".join(value.splitlines()) if isinstance(value, str) else str(int(value))


def csv_line(cells: Iterable[str]) -> str:
    """Return one CSV line with its line end."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(cells)
    return line.getvalue()
