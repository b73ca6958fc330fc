"""Rows of people and of sessions; their fields are the columns of the files, in order."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import ClassVar

from vrcomfort.escaping import escape_unprintable
from vrcomfort.records.rows import FlatRow

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
        return super().columns()[:-1]

    @property
    def group(self) -> str | None:
        """Return the level of the between-subject factor."""
        return dict(self.others).get("group")

    @property
    def covariates(self) -> dict[str, str]:
        """Return what was entered at the enrolment."""
        return {name: value for name, value in self.others if name not in {"group", *FACTS}}


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
    text = text.replace("\r\n", "\n").replace("\r", "\n").replace("\\", "\\\\")
    return escape_unprintable(text.replace("\n", "\\n").replace("\t", "\\u0009"))


def in_lines(text: str) -> str:
    """Return the text that `one_line` has written."""
    return _ESCAPE.sub(_meant, text)


_ESCAPE = re.compile(r"\\(?:(\\|n)|u([0-9a-f]{4}))")


def _meant(found: re.Match[str]) -> str:
    if found[2]:
        return chr(int(found[2], 16))
    return "\n" if found[1] == "n" else "\\"


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
