"""The study folder: its description, its participants and who is enrolled next."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from vrcomfort.csv_table import CsvTable
from vrcomfort.design import Design, Enrolment
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol
from vrcomfort.records.lock import in_turn, only_program
from vrcomfort.records.manifest import read_manifest
from vrcomfort.records.recorder import csv_line, is_begun, replace_text, session_folder
from vrcomfort.records.rows import ParticipantRow, cell_text
from vrcomfort.records.schema import SCHEMA_VERSION, check_schema_version

DESCRIPTION = "dataset_description.json"


def now() -> str:
    """Return the current time, UTC, to the second, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def open_study(study: Path, protocol: Protocol, *, seed: int | None = None) -> int:
    """Make the study folder and its description, or check that it belongs to this protocol.

    Parameters
    ----------
    seed
        Of a new study (`None` is 0). A random order is drawn again from it whenever its
        participant comes back, so a study keeps its first seed.

    Returns
    -------
    int
        The study's seed.

    Raises
    ------
    InputError
        If the folder holds another study, or one with another seed, or cannot be written.
    """
    file = study / DESCRIPTION
    if file.exists():
        return _same_study(file, protocol, seed)
    try:
        study.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"cannot make this study folder: {error.strerror}; choose another --out"
        raise InputError(message, file=study) from error
    text = json.dumps(_description(protocol, seed or 0), indent=2, ensure_ascii=False)
    replace_text(file, text + "\n")
    return seed or 0


def _description(protocol: Protocol, seed: int) -> dict[str, object]:
    return {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "schema_version": SCHEMA_VERSION,
        "name": protocol.title,
        "description": f"Comfort study recorded with vrcomfort, protocol {protocol.name}.",
        "citation": protocol.citation,
        "protocol": protocol.name,
        "seed": seed,
        "conditions": {each.name: each.label or each.name for each in protocol.conditions},
        "scenes": list(protocol.scenes),
        "variableMeasured": [
            "participant", "session", "period", "trial", "condition", "scene",
            "timepoint", "instrument", "item", "response",
        ],
    }  # fmt: skip


def _same_study(file: Path, protocol: Protocol, seed: int | None) -> int:
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        name, kept = content["protocol"], int(content["seed"])
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InputError("this study description is damaged; restore it", file=file) from error
    check_schema_version(content, file)
    if name != protocol.name:
        message = f"this folder holds a study with protocol `{name}`, not `{protocol.name}`"
        raise InputError(f"{message}; choose another --out", file=file)
    if seed not in {None, kept}:
        message = f"this study was begun with seed {kept}, not {seed}"
        raise InputError(f"{message}; leave --seed out, or choose another --out", file=file)
    return kept


def read_participants(study: Path) -> list[ParticipantRow]:
    """Return everybody who was enrolled, in order.

    Raises
    ------
    InputError
        If the file is damaged: nobody is left out silently.
    """
    file = study / ParticipantRow.FILE
    if not file.exists():
        return []
    found = CsvTable.read(file, appended=True)
    if found.warnings:  # going on would enrol somebody twice
        last = len(found.rows) + 2
        message = "this row is half-written; complete it, with a line end, or remove it"
        raise InputError(message, file=file, line=last)
    if found.rows and set(found.header) != set(ParticipantRow.columns()):
        columns = ", ".join(ParticipantRow.columns())
        raise InputError(f"the columns must be {columns}", file=file, line=1)
    return [ParticipantRow(**row) for row in found.dicts()]


def enrolled(study: Path, participant: str) -> ParticipantRow | None:
    """Return the participant's row, or None for somebody new.

    Raises
    ------
    InputError
        If they have withdrawn or been excluded.
    """
    for row in read_participants(study):
        if row.participant == participant:
            if row.status in {"withdrawn", "excluded"}:
                raise InputError(f"participant {participant} is {row.status} from this study")
            return row
    return None


def enrol(study: Path, design: Design, participant: str) -> ParticipantRow:
    """Return the participant's row, enrolling them in the least filled sequence if they are new.

    Raises
    ------
    InputError
        If the name cannot be part of a file name, or they have withdrawn or been excluded.
    """
    check_name(participant)
    with _changing_participants(study):
        there = enrolled(study, participant)
        if there is not None:
            return there
        rows = read_participants(study)
        sequence = design.assign(Enrolment(row.sequence, row.status) for row in rows)
        row = ParticipantRow(participant, sequence.name, "enrolled", now())
        _write_participants(study, [*rows, row])
    return row


def check_name(participant: str) -> None:
    """Raise `InputError` if a name cannot be part of a file name."""
    if not re.fullmatch(r"[A-Za-z0-9]{1,64}", participant):
        raise InputError(f"participant `{participant}`: use 1 to 64 letters and digits only")


def _changing_participants(study: Path) -> AbstractContextManager[None]:
    """Two participants may be run at once; their rows are written one after the other."""
    return in_turn(study / ".participants.lock")


def set_status(study: Path, participant: str, status: str, note: str = "") -> None:
    """Change a participant's status; notes are added to those before."""
    with _changing_participants(study):
        rows = read_participants(study)
        changed = [
            replace(row, status=status, note="; ".join(filter(None, [row.note, note])))
            if row.participant == participant
            else row
            for row in rows
        ]
        _write_participants(study, changed)


def recorded_sessions(study: Path, participant: str) -> list[int]:
    """Return the numbers of a participant's sessions that are on disk."""
    folders = session_folder(study, participant, 1).parent.glob("ses-*")
    numbers = [folder.name.removeprefix("ses-") for folder in folders if is_begun(folder)]
    return sorted(int(number) for number in numbers if number.isdigit())


def completed_sessions(study: Path, participant: str) -> list[int]:
    """Return the numbers of a participant's sessions whose manifest says completed."""
    return _sessions(study, participant, lambda status: status == "completed")


def unfinished_sessions(study: Path, participant: str) -> list[int]:
    """Return the numbers of a participant's sessions that were interrupted, whatever did it."""
    return _sessions(study, participant, lambda status: status not in _FINISHED)


_FINISHED = {"completed", "withdrawn"}


def _sessions(study: Path, participant: str, wanted: Callable[[str | None], bool]) -> list[int]:
    return [
        number
        for number in recorded_sessions(study, participant)
        if wanted(_manifest_status(session_folder(study, participant, number)))
    ]


def _manifest_status(folder: Path) -> str | None:
    try:
        return read_manifest(folder).get("status")
    except InputError:
        return None


def only_run(study: Path, participant: str) -> AbstractContextManager[None]:
    """Return a lock that lets one program at a time run a participant.

    Raises
    ------
    InputError
        On entering, if another program runs this participant; or for a name that no folder has.
    """
    check_name(participant)
    file = session_folder(study, participant, 1).with_name("lock")
    return only_program(file, doing=f"participant {participant} is being run")


def _write_participants(study: Path, rows: list[ParticipantRow]) -> None:
    lines = [csv_line(ParticipantRow.columns())]
    lines += [csv_line(map(cell_text, row.cells())) for row in rows]
    replace_text(study / ParticipantRow.FILE, "".join(lines))
