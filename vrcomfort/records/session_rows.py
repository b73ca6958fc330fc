"""Rows of people and of sessions."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated, ClassVar

from vrcomfort.escaping import escape_unprintable
from vrcomfort.records.rows import DATE, GAZE, TEXT, Column, Needs, Row
from vrcomfort.records.shared_columns import (
    AnsweredS,
    AskedS,
    ConditionOfSession,
    OnsetS,
    ParticipantName,
    PartOfStudy,
    Resumed,
    SessionNumber,
    TrialOfSession,
)

FACTS = ("gaze_validation_error_deg",)
"""Columns of participants.csv that sessions fill in."""


@dataclass(frozen=True)
class ParticipantRow(Row):
    """One participant of the study.

    Parameters
    ----------
    others
        Further columns, which follow: `FURTHER`, and the covariates that the protocol names.
    """

    FILE: ClassVar[str] = "participants.csv"
    FURTHER: ClassVar[tuple[Column, ...]] = (
        Column("Level of the between-subject factor", name="group", of=str),
        Column(
            "Mean error of the last validation of the gaze",
            blank="the gaze was not validated",
            needs=GAZE,
            name=FACTS[0],
        ),
    )
    participant: ParticipantName
    sequence: Annotated[str, Column("The order of conditions and scenes, as the protocol names it")]
    status: Annotated[
        str,
        Column(
            "enrolled, completed, withdrawn (in analyses as far as they came), excluded (in no "
            "analysis) or erased (on request; the row has a new name, and no data)"
        ),
    ]
    enrolled_at: Annotated[
        str,
        Column("When the participant was enrolled, ISO 8601", blank="their data were erased"),
    ]
    note: Annotated[
        str, Column("Notes of experimenters and of sessions", blank="there are none", needs=TEXT)
    ] = ""
    others: tuple[tuple[str, str], ...] = ()

    @property
    def group(self) -> str | None:
        """Return the level of the between-subject factor."""
        return dict(self.others).get("group")

    @property
    def covariates(self) -> dict[str, str]:
        """Return the covariates that were entered at the enrolment."""
        return {name: value for name, value in self.others if name not in {"group", *FACTS}}


@dataclass(frozen=True)
class ConsentRow(Row):
    """One consent of a participant."""

    FILE: ClassVar[str] = "consents.csv"
    NEEDS: ClassVar[Needs] = DATE
    participant: ParticipantName
    version: Annotated[str, Column("Version of the text, as the protocol calls it")]
    given_on: Annotated[str, Column("Day of the consent, ISO 8601")]
    text_sha256: Annotated[
        str, Column("SHA-256 of the text's file", blank="the protocol names no file")
    ]
    recorded_at: Annotated[str, Column("When it was entered, ISO 8601")]


@dataclass(frozen=True)
class QuestionnaireRow(Row):
    """One answer to a question of a questionnaire."""

    FILE: ClassVar[str] = "questionnaires.csv"
    participant: ParticipantName
    session: SessionNumber
    period: Annotated[
        int | None,
        Column(
            "Place of the exposure among all of the participant's, from 1, over sessions",
            blank="the whole session is meant",
        ),
    ]
    block: Annotated[
        int | None,
        Column("Number of the block in the session, from 1", blank="the whole session is meant"),
    ]
    trial: TrialOfSession
    condition: ConditionOfSession
    timepoint: Annotated[str, Column("When in the session it was asked, as the protocol names it")]
    instrument: Annotated[str, Column("Questionnaire")]
    item: Annotated[str, Column("Question of the questionnaire")]
    response: Annotated[
        int | None,
        Column("The answer, as the instrument codes it", blank="rather not say", signed=True),
    ]
    asked_s: AskedS
    answered_s: AnsweredS
    order: Annotated[int, Column("Place in the presentation, from 1")]
    part: PartOfStudy = None
    resumed: Resumed = 0


LONGEST_TEXT = 20_000
"""Characters of an answer in one's own words, as they are written."""


@dataclass(frozen=True)
class TextRow(Row):
    """One answer in the participant's own words."""

    FILE: ClassVar[str] = "texts.csv"
    NEEDS: ClassVar[Needs] = TEXT
    participant: ParticipantName
    session: SessionNumber
    trial: TrialOfSession
    condition: ConditionOfSession
    question: Annotated[str, Column("The question, as the protocol names it")]
    text: Annotated[
        str,
        Column(
            "The answer in one line: `\\n` is a line end, `\\\\` a backslash, `\\uXXXX` a control "
            "character",
            blank="nothing was said",
        ),
    ]
    asked_s: AskedS
    answered_s: AnsweredS
    resumed: Resumed = 0


def one_line(text: str) -> str:
    r"""Return a text in one line: \\ for \, \n for a line end, \uXXXX for control characters.

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
class ScreeningRow(Row):
    """A number beyond a screening rule, and the experimenter's decision."""

    FILE: ClassVar[str] = "screening.csv"
    participant: ParticipantName
    session: SessionNumber
    rule: Annotated[str, Column("The number and the bound that it was beyond")]
    value: Annotated[
        float | None,
        Column("The number", blank="of the body, in copies for others", signed=True),
    ]
    decision: Annotated[str, Column("The experimenter's decision: go_on or stop")]
    decided_s: Annotated[float, Column("When it was decided on the session's clock")]
    resumed: Resumed = 0


_NO_SAMPLE = "no sample was valid"


@dataclass(frozen=True)
class GazeValidationRow(Row):
    """Quality of the gaze on one point of a validation, or its mean over all points."""

    FILE: ClassVar[str] = "gaze_validation.csv"
    NEEDS: ClassVar[Needs] = GAZE
    participant: ParticipantName
    session: SessionNumber
    validation: Annotated[int, Column("Number of the validation in the session, from 1")]
    attempt: Annotated[
        int, Column("1, and one more each time that the validation was not good enough")
    ]
    before_trial: Annotated[int, Column("Trial of the session that the validation comes before")]
    onset_s: OnsetS
    point: Annotated[int | None, Column("Number of the point, from 1", blank="the mean over all")]
    eye: Annotated[
        str,
        Column(
            "combined (the runtime's gaze of both eyes), left or right (where it tells them apart)"
        ),
    ]
    right_deg: Annotated[
        float | None,
        Column(
            "Direction of the point to the right, from the head when it appeared",
            blank="the mean over all",
            signed=True,
        ),
    ]
    up_deg: Annotated[
        float | None,
        Column(
            "Direction of the point upwards, from the head when it appeared",
            blank="the mean over all",
            signed=True,
        ),
    ]
    distance_m: Annotated[
        float | None, Column("Distance of the point from the head", blank="the mean over all")
    ]
    samples: Annotated[int, Column("Frames that counted")]
    valid_percent: Annotated[float, Column("Share of them in which the eyes were seen")]
    accuracy_deg: Annotated[
        float | None, Column("Mean angle between gaze and point", blank=_NO_SAMPLE)
    ]
    precision_rms_deg: Annotated[
        float | None,
        Column("Root mean square of the angles between successive samples", blank=_NO_SAMPLE),
    ]
    precision_sd_deg: Annotated[
        float | None, Column("Standard deviation of the samples", blank=_NO_SAMPLE)
    ]
    good: Annotated[
        int | None,
        Column("Of the mean: 1 where it is within the protocol's limit, else 0", blank="a point"),
    ] = None
    resumed: Resumed = 0


@dataclass(frozen=True)
class EventRow(Row):
    """One event."""

    FILE: ClassVar[str] = "events.csv"
    onset_s: OnsetS
    duration_s: Annotated[float, Column("How long it lasted; 0 for a moment")]
    name: Annotated[str, Column("Name of the event; see below")]
    detail: Annotated[str, Column("Detail of the event", blank="it has none")] = ""
    resumed: Resumed = 0


@dataclass(frozen=True)
class ClockRow(Row):
    """All clocks, read at one moment."""

    FILE: ClassVar[str] = "clocks.csv"
    NEEDS: ClassVar[Needs] = DATE
    session_s: Annotated[float, Column("The moment on the session's clock")]
    xr_time_ns: Annotated[
        int | None,
        Column(
            "The moment as a display time, as in frames.csv",
            blank="the headset does not tell",
            signed=True,
        ),
    ]
    monotonic_ns: Annotated[int, Column("The system's monotonic clock")]
    unix_ns: Annotated[int, Column("The system's time since 1970")]
    lsl_s: Annotated[float | None, Column("The clock of LabStreamingLayer", blank="it is not used")]
    took_ns: Annotated[
        int, Column("Duration of the reading: the clocks are of one moment to half of this")
    ]
    resumed: Resumed = 0
