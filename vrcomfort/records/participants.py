"""Participants after their enrolment: notes, exclusion, withdrawal taken back, exposures met."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from vrcomfort.design.audit import AdministeredOrder
from vrcomfort.errors import InputError
from vrcomfort.json_text import json_of
from vrcomfort.protocol import Sequence, Trial
from vrcomfort.records.checksums import update_checksums
from vrcomfort.records.disk import Access, replace_text
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.interrupted import ENDED_THE_STUDY, repair_table
from vrcomfort.records.reader import Session, Study
from vrcomfort.records.session_rows import ParticipantRow
from vrcomfort.records.study import (
    access_of,
    checked_reason,
    enrolment_of,
    now,
    only_run,
    read_participants,
    set_status,
    withdrawn_sessions,
)

_BEFORE = re.compile(r"excluded \(was (enrolled|completed|withdrawn)\)")


def exclude(study: Path, participant: str, reason: str) -> None:
    """Exclude a participant from all analyses; the recorded files stay.

    Raises
    ------
    InputError
        If there is no reason, nobody of this name, they are excluded, or a program runs them.
    """
    _known(study, participant, reason)  # refused before the lock is made
    with only_run(study, participant):
        row, reason = _known(study, participant, reason)
        if row.status == "excluded":
            raise InputError(f"participant {participant} is excluded already", file=study)
        note = f"excluded (was {row.status}) {now()}: {reason}"
        set_status(study, participant, "excluded", note)


def undo_exclusion(study: Path, participant: str, reason: str) -> str:
    """Undo an exclusion; return the participant's status, which is that before it.

    Raises
    ------
    InputError
        If there is no reason, nobody of this name is excluded, or a program runs them.
    """
    _known(study, participant, reason)
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
    """Add a note, with its date, to those on a participant.

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
    repair_table(folder, TrialRow, access)
    trials = list(session.rows(TrialRow, repaired=True))
    place: dict[str, int | None] = {"trial": None, "attempt": None}
    if trials and trials[-1]["status"] in ENDED_THE_STUDY:
        last = trials[-1]
        place = {"trial": last["trial"], "attempt": last["attempt"]}
    manifest["status"] = "aborted"
    manifest["withdrawals_undone"] = [*manifest.get("withdrawals_undone", []), why | place]
    text = json_of(manifest)
    replace_text(folder / "manifest.json", text + "\n", access)
    update_checksums(folder, ("manifest.json", TrialRow.FILE, f"{TrialRow.FILE}.cut"), access)


SIMULATED = "simulated"


def mixed_kinds_notice(study: Path, *, simulated: bool) -> str:
    """Return a sentence on the participants of the other kind, or nothing where there are none.

    Parameters
    ----------
    simulated
        What the participants are who come now.
    """
    people = (row.participant for row in read_participants(study))
    others = [name for name in people if (is_simulated(study, name) is (not simulated))]
    if not others:
        return ""
    more = f" and {len(others) - 3} more" if len(others) > 3 else ""
    there, here = ("real", "simulated") if simulated else ("simulated", "real")
    return (
        f"this study has {there} participants ({', '.join(others[:3])}{more}) and gets {here} ones "
        "now; reports keep them apart; choose another output folder for a study of one kind"
    )


def is_simulated(study: Path, participant: str) -> bool | None:
    """Return whether a participant was simulated; None where no session tells."""
    for session in Study(study).sessions_of(participant):
        try:
            respondent = session.manifest["respondent"]
        except (InputError, KeyError):
            continue
        return bool(respondent == SIMULATED)
    return None


def administered_orders(study: Path) -> list[AdministeredOrder]:
    """Return the administered order of each enrolled participant: exposures shown whole.

    Raises
    ------
    InputError
        If a file is damaged.
    """
    read = Study(study)
    return [_met(read, row) for row in read.enrolled]


def _met(study: Study, row: ParticipantRow) -> AdministeredOrder:
    sessions = tuple(_trials(session) for session in study.sessions_of(row.participant))
    run = Sequence.model_construct(name=row.sequence, group=row.group, sessions=sessions)
    return AdministeredOrder(row.participant, enrolment_of(row), run)


def _trials(session: Session) -> tuple[Trial, ...]:
    if not session.has(TrialRow):
        return ()
    table = session.table(TrialRow)
    table.require(("condition", "scene", "status"))
    whole = [row for row in table.dicts() if row["status"] == "completed"]
    return tuple(
        Trial(scene=row["scene"], condition=row["condition"], part=row.get("part") or None)
        for row in whole
    )
