"""What a study leaves on disk: row types (their fields are the CSV columns), recorder, reader."""

from vrcomfort.records.manifest import Machine, Manifest
from vrcomfort.records.reader import Rows, read_rows
from vrcomfort.records.recorder import Recorder, session_folder
from vrcomfort.records.rows import (
    EventRow,
    FrameRow,
    ParticipantRow,
    QuestionnaireRow,
    RatingRow,
    Row,
    TrialRow,
)
from vrcomfort.records.study import (
    completed_sessions,
    enrol,
    open_study,
    read_participants,
    recorded_sessions,
    set_status,
)

__all__ = [
    "EventRow",
    "FrameRow",
    "Machine",
    "Manifest",
    "ParticipantRow",
    "QuestionnaireRow",
    "RatingRow",
    "Recorder",
    "Row",
    "Rows",
    "TrialRow",
    "completed_sessions",
    "enrol",
    "open_study",
    "read_participants",
    "read_rows",
    "recorded_sessions",
    "session_folder",
    "set_status",
]
