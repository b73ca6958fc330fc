"""Erases a participant's data on request; a dated row without identifying data stays."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.files import read_bytes
from vrcomfort.records.consents import erase_consents
from vrcomfort.records.disk import refuse_links, refused, sync_folder
from vrcomfort.records.frame_rows import FrameRow, GazeRow, HandJointsRow, ImageRow, PartRow
from vrcomfort.records.recorder import session_folder
from vrcomfort.records.session_rows import ParticipantRow
from vrcomfort.records.study import (
    ERASED,
    change_participants,
    now,
    only_run,
    read_participants,
    recorded_sessions,
)

_NUMBERS_ALONE = {each.FILE for each in (FrameRow, GazeRow, ImageRow, HandJointsRow, PartRow)}
_IN_NOTES = "[erased]"


@dataclass(frozen=True)
class Erasure:
    """The erased data, and places where the name still stands.

    Parameters
    ----------
    row
        Name of the row that stays in ``participants.csv``; blank where an erasure that had been
        interrupted was completed.
    sessions
        How many were deleted.
    mentions
        Files of the study that name the participant, or contain them in their path: reports and
        exports in the folder, details of events of others.
    """

    row: str
    sessions: int
    mentions: tuple[Path, ...]


def erase(study: Path, participant: str) -> Erasure:
    """Delete a participant's sessions, consents, covariates and notes.

    The row that stays has the order and the group, by which the next participants' are counted,
    and the day. Where it was interrupted, the same call completes it.

    Raises
    ------
    InputError
        If there is nobody of this name, a program runs them, this is an import, or the disk
        refuses.
    """
    if (study / "import.json").exists():
        message = "this is an import; delete the person from the files, and import these again"
        raise InputError(message, file=study)
    folder = session_folder(study, participant, 1).parent
    known = any(row.participant == participant for row in read_participants(study))
    if not known and not folder.is_dir():
        raise InputError(f"this study has no participant {participant}", file=study)
    refuse_links(study, folder)
    with only_run(study, participant):
        sessions = len(recorded_sessions(study, participant))
        try:
            for each in sorted(folder.iterdir()):
                if each.is_dir() and not each.is_symlink():
                    shutil.rmtree(each)
                elif each.name != "lock":
                    each.unlink()
            sync_folder(folder)
        except OSError as error:
            raise refused(folder, error) from error
        erase_consents(study, participant)
        called = _erase_row(study, participant)
    # Whose folder has nothing but its lock any more, it went with that.
    return Erasure(called, sessions, tuple(_mentions(study, participant)))


def _erase_row(study: Path, participant: str) -> str:
    """Replace a participant's row, and the name in the notes on others; return its new name."""
    called = ""

    def changed(rows: list[ParticipantRow]) -> list[ParticipantRow]:
        nonlocal called
        if all(row.participant != participant for row in rows):
            return rows
        taken = {row.participant.lower() for row in rows}
        called = next(n for k in range(1, len(rows) + 2) if (n := f"erased{k}") not in taken)
        return [_changed(row, participant, called) for row in rows]

    change_participants(study, changed)
    return called


def _changed(row: ParticipantRow, participant: str, called: str) -> ParticipantRow:
    if row.participant != participant:
        return replace(row, note=_word(participant).sub(_IN_NOTES, row.note))
    group = tuple((name, value) for name, value in row.others if name == "group")
    note = f"erased on {now()[:10]}"
    return ParticipantRow(called, row.sequence, ERASED, "", note, group)


def _word(name: str) -> re.Pattern[str]:
    """Return a pattern of a name; of a number or a single letter none, which may mean another."""
    if name.isdigit() or len(name) == 1:
        return re.compile(r"(?!)")
    return re.compile(rf"(?<![A-Za-z0-9]){name}(?![A-Za-z0-9])")


def _mentions(study: Path, participant: str) -> Iterator[Path]:
    """Yield the files that name a participant; recordings have numbers alone."""
    word = re.compile(rf"(?<![A-Za-z0-9]){participant}(?![A-Za-z0-9])")
    for file in sorted(study.rglob("*")):
        place = file.relative_to(study)
        if not file.is_file() or file.is_symlink() or file.name in _NUMBERS_ALONE:
            continue
        try:
            named = word.search(str(place)) or word.search(
                read_bytes(file).decode("utf-8", errors="replace")
            )
        except (OSError, InputError):
            named = None
        if named:
            yield place
