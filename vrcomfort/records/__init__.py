"""The files of a study: row types (their fields are the CSV columns), recorder, reader."""

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
from vrcomfort.records.interrupted import ENDED_THE_STUDY, Interrupted, repair_session
from vrcomfort.records.manifest import Machine, Manifest, facts_of_run, read_manifest
from vrcomfort.records.participants import (
    administered_orders,
    mixed_kinds_notice,
    undo_withdrawal,
)
from vrcomfort.records.reader import Session, Study
from vrcomfort.records.recorder import Recorder, overwriting, session_folder
from vrcomfort.records.row_files import Durability
from vrcomfort.records.rows import Row
from vrcomfort.records.session_rows import (
    FACTS,
    ClockRow,
    EventRow,
    GazeValidationRow,
    ParticipantRow,
    QuestionnaireRow,
    ScreeningRow,
    TextRow,
)
from vrcomfort.records.study import (
    access_of,
    completed_sessions,
    enrol,
    enrolled,
    entered,
    note_end,
    only_run,
    open_study,
    opened_study,
    read_participants,
    recorded_sessions,
    set_fact,
    set_status,
    unfinished_sessions,
)

__all__ = [
    "ENDED_THE_STUDY",
    "FACTS",
    "BallRow",
    "ClockRow",
    "DialRow",
    "Durability",
    "EventRow",
    "FrameRow",
    "GazeRow",
    "GazeValidationRow",
    "HandJointsRow",
    "ImageRow",
    "Interrupted",
    "Machine",
    "Manifest",
    "PartRow",
    "ParticipantRow",
    "PracticeRow",
    "QuestionnaireRow",
    "RatingRow",
    "Recorder",
    "Row",
    "ScreeningRow",
    "Session",
    "Study",
    "TaskRow",
    "TextRow",
    "TimingRow",
    "TrialRow",
    "access_of",
    "administered_orders",
    "completed_sessions",
    "enrol",
    "enrolled",
    "entered",
    "facts_of_run",
    "mixed_kinds_notice",
    "note_end",
    "only_run",
    "open_study",
    "opened_study",
    "overwriting",
    "read_manifest",
    "read_participants",
    "recorded_sessions",
    "repair_session",
    "session_folder",
    "set_fact",
    "set_status",
    "undo_withdrawal",
    "unfinished_sessions",
]
