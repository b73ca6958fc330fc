"""Notices a wall clock that was set back: file times and the order of sessions then mislead."""

from __future__ import annotations

import time
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.records.reader import Study
from vrcomfort.records.study import read_participants

TOLERANCE_S = 2.0
"""What a time server may take back at a stroke, and what whole seconds on record round away."""


def set_back_before(study: Path, participant: str) -> list[str]:
    """Return a sentence if the clock stands earlier than the study's latest record.

    It looks at when people were enrolled, and at this participant's sessions.
    """
    moments = [moment for text in _on_record(study, participant) if (moment := _moment(text))]
    now = datetime.now(UTC)
    last = max(moments, default=now)
    if (last - now).total_seconds() <= TOLERANCE_S:
        return []
    at, then = now.isoformat(timespec="seconds"), last.isoformat(timespec="seconds")
    return [f"the clock stood at {at}, but this study's folder has records of {then}"]


def _on_record(study: Path, participant: str) -> Iterable[object]:
    yield from (row.enrolled_at for row in read_participants(study))
    for session in Study(study).sessions_of(participant):
        try:
            manifest = session.manifest
        except InputError:  # whoever goes on with it is told
            continue
        yield from (manifest["started_at"], manifest.get("finished_at"))


def _moment(text: object) -> datetime | None:
    """Return a moment that says its time zone; spreadsheets write others."""
    try:
        moment = datetime.fromisoformat(str(text))
    except ValueError:
        return None
    return moment if moment.tzinfo else None


class WallClockWatch:
    """Compares the wall clock with the monotonic one, which cannot be set."""

    def __init__(self) -> None:
        self._ahead_s = self._wall_ahead_s()

    def set_back(self) -> list[str]:
        """Return a sentence if the wall clock was set back since this was asked last."""
        before_s, self._ahead_s = self._ahead_s, self._wall_ahead_s()
        back_s = before_s - self._ahead_s
        if back_s <= TOLERANCE_S:
            return []
        at = datetime.now(UTC).isoformat(timespec="seconds")
        return [f"the clock was set back by {back_s:.0f} s, to {at}, during the session"]

    @staticmethod
    def _wall_ahead_s() -> float:
        return time.time() - time.monotonic()
