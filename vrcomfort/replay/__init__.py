"""Replays a recorded session, drawn from its own files."""

from vrcomfort.replay.drawn import Comparison, DrawnFrame, ReplaySelection, replay
from vrcomfort.replay.recorded import (
    RecordedExposure,
    RecordedSession,
    read_session,
    require_session,
)

__all__ = [
    "Comparison",
    "DrawnFrame",
    "RecordedExposure",
    "RecordedSession",
    "ReplaySelection",
    "read_session",
    "replay",
    "require_session",
]
