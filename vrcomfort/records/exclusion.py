"""Notes on participants, exclusions by the experimenter, and taking these back: each with why."""

from __future__ import annotations

import re
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.records.session_rows import ParticipantRow
from vrcomfort.records.study import (
    checked_reason,
    now,
    only_run,
    read_participants,
    set_status,
    withdrawn_sessions,
)

_BEFORE = re.compile(r"excluded \(was (enrolled|completed|withdrawn)\)")


def exclude(study: Path, participant: str, reason: str) -> None:
    """Keep a participant out of all analyses; what was recorded stays.

    Raises
    ------
    InputError
        If there is no reason, nobody of this name, they are excluded, or a program runs them.
    """
    with only_run(study, participant):
        row, reason = _known(study, participant, reason)
        if row.status == "excluded":
            raise InputError(f"participant {participant} is excluded already", file=study)
        note = f"excluded (was {row.status}) {now()}: {reason}"
        set_status(study, participant, "excluded", note)


def undo_exclusion(study: Path, participant: str, reason: str) -> str:
    """Take an exclusion back; return what the participant is now: what they were before.

    Raises
    ------
    InputError
        If there is no reason, nobody of this name is excluded, or a program runs them.
    """
    with only_run(study, participant):
        row, reason = _known(study, participant, reason)
        if row.status != "excluded":
            message = f"participant {participant} is {row.status}, not excluded"
            raise InputError(message, file=study)
        before = _BEFORE.findall(row.note)
        usual = "withdrawn" if withdrawn_sessions(study, participant) else "enrolled"
        status = str(before[-1]) if before else usual
        set_status(study, participant, status, f"exclusion undone {now()}: {reason}")
        return status


def add_note(study: Path, participant: str, text: str) -> None:
    """Add a note to what is noted of a participant, with its date.

    Raises
    ------
    InputError
        If it is empty, or there is nobody of this name.
    """
    row, text = _known(study, participant, text)
    set_status(study, participant, row.status, f"{now()}: {text}")


def _known(study: Path, participant: str, text: str) -> tuple[ParticipantRow, str]:
    """Return a participant's row, and the checked reason or note."""
    for row in read_participants(study):
        if row.participant == participant:
            return row, checked_reason(row, text)
    raise InputError(f"this study has no participant {participant}", file=study)
