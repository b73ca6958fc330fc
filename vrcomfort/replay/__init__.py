"""Replays a recorded session, drawn from its own files."""

from vrcomfort.replay.drawn import DrawnFrame, ReplaySelection, replay
from vrcomfort.replay.exposures import RecordedExposure
from vrcomfort.replay.hashes import Comparison
from vrcomfort.replay.recorded import RecordedSession, read_session, require_session

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
