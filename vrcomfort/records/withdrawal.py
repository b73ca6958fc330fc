"""Undoes a withdrawal that nobody wanted; what was recorded of it stays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.json_text import json_of
from vrcomfort.records.checksums import seal_again
from vrcomfort.records.disk import Access, replace_text
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.mend import mend
from vrcomfort.records.reader import Session, Study
from vrcomfort.records.session_rows import ParticipantRow
from vrcomfort.records.study import (
    access_of,
    checked_reason,
    now,
    only_run,
    read_participants,
    set_status,
)

ENDED_THE_STUDY = ("withdrawn", "stopped")
"""Statuses of the trial in which a participant's study ended."""


def undo_withdrawal(study: Path, participant: str, reason: str) -> int | None:
    """Make a withdrawn participant enrolled again, and the session that ended so interrupted.

    The reason and the date stand in the participant's note and in the session's manifest; rows and
    events stay as they are.

    Returns
    -------
    int
        The session that `run --resume` continues; None where no session had ended so.

    Raises
    ------
    InputError
        If there is no reason, nobody of this name has withdrawn, or another program runs them.
    """
    reason = checked_reason(_withdrawn(study, participant), reason)
    with only_run(study, participant):
        at = now()
        ended = None
        for session in Study(study).sessions_of(participant):
            if session.manifest.get("status") == "withdrawn":
                ended = session.number
                _reopen(session, {"at": at, "reason": reason}, access_of(study))
        set_status(study, participant, "enrolled", f"withdrawal undone {at}: {reason}")
    return ended


def undone_trials(manifest: Mapping[str, Any]) -> set[tuple[int, int]]:
    """Return (trial, attempt) of exposures whose withdrawal has been undone."""
    undone: Iterable[Mapping[str, Any]] = manifest.get("withdrawals_undone") or ()
    return {(each["trial"], each["attempt"]) for each in undone if each.get("trial")}


def _withdrawn(study: Path, participant: str) -> ParticipantRow:
    known = {row.participant: row for row in read_participants(study)}
    if participant not in known:
        raise InputError(f"this study has no participant {participant}", file=study)
    if known[participant].status != "withdrawn":
        message = f"participant {participant} is {known[participant].status}, not withdrawn"
        raise InputError(message, file=study)
    return known[participant]


def _reopen(session: Session, why: dict[str, Any], access: Access) -> None:
    folder, manifest = session.folder, session.manifest
    mend(folder, TrialRow, access)
    trials = list(session.rows(TrialRow, mended=True))
    place: dict[str, int | None] = {"trial": None, "attempt": None}
    if trials and trials[-1]["status"] in ENDED_THE_STUDY:
        last = trials[-1]
        place = {"trial": last["trial"], "attempt": last["attempt"]}
    manifest["status"] = "aborted"
    manifest["withdrawals_undone"] = [*manifest.get("withdrawals_undone", []), why | place]
    text = json_of(manifest)
    replace_text(folder / "manifest.json", text + "\n", access)
    seal_again(folder, ("manifest.json", TrialRow.FILE, f"{TrialRow.FILE}.cut"), access)
