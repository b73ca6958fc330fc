"""The study folder: its description, its participants and their enrolment."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import CsvTable
from vrcomfort.design import Design, Enrolment
from vrcomfort.errors import InputError
from vrcomfort.escaping import escape_unprintable
from vrcomfort.files import read_text
from vrcomfort.json_text import json_of
from vrcomfort.protocol import Protocol
from vrcomfort.questionnaire import FOLDER as INSTRUMENTS
from vrcomfort.records.checksums import CHECKSUMS, replace_listed
from vrcomfort.records.disk import (
    GROUP,
    OWNER,
    Access,
    in_turn,
    make_folders,
    only_program,
    refuse_links,
    refused,
    replace_text,
)
from vrcomfort.records.json_file import DescribedShape, DescriptionShape, read_json
from vrcomfort.records.manifest import read_manifest
from vrcomfort.records.names import check_case, check_participant, check_study
from vrcomfort.records.recorder import is_begun, session_folder
from vrcomfort.records.rows import csv_line
from vrcomfort.records.schema import SCHEMA_VERSION
from vrcomfort.records.session_rows import LONGEST_TEXT, ParticipantRow
from vrcomfort.records.tables import read_table

DESCRIPTION = "dataset_description.json"
ERASED = "erased"
"""Status of the row that stays of somebody whose data were erased."""
LONGEST_NOTES = 80_000
"""Characters of a participant's notes; the program's own notes have room beside."""


def now() -> str:
    """Return the current time, UTC, to the second, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def open_study(
    study: Path, protocol: Protocol, *, seed: int | None = None, group_readable: bool = False
) -> int:
    """Make the study folder and its description, or check that it belongs to this protocol.

    Parameters
    ----------
    seed
        Of a new study (`None` is 0). A random order is drawn again from it whenever its
        participant comes back, so a study keeps its first seed.
    group_readable
        A new study's files are for the owner's group as well, and not for the owner alone. A
        study keeps this, too.

    Returns
    -------
    int
        The study's seed.

    Raises
    ------
    InputError
        If the folder holds another study, one with another seed or for other readers, cannot be
        written, or has a name that Windows does not take.
    """
    file = study / DESCRIPTION
    refuse_links(study, file)
    if file.exists():
        kept = _same_study(file, protocol, seed, group_readable)
        _keep_instruments(study, protocol, access_of(study))
        return kept
    check_study(study.resolve().name)
    access = GROUP if group_readable else OWNER
    try:
        make_folders(study, study, access)
    except OSError as error:
        message = f"cannot make this study folder: {error.strerror}; choose another output folder"
        raise InputError(message, file=study) from error
    _keep_instruments(study, protocol, access)
    text = json_of(_description(protocol, seed or 0, access))
    replace_listed(file, text + "\n", access)
    return seed or 0


@contextmanager
def opened_study(
    study: Path, protocol: Protocol, *, seed: int | None = None, group_readable: bool = False
) -> Iterator[int]:
    """Open a study as `open_study` does; a new one in which nothing was recorded goes at the end.

    Yields
    ------
    int
        The study's seed.
    """
    own = [study / INSTRUMENTS / f"{name}.toml" for name in protocol.own_instruments]
    lists = study / DESCRIPTION, study / CHECKSUMS
    places = (*own, *lists, study / INSTRUMENTS, study, *study.parents)
    made = [each for each in places if not each.exists()]
    try:
        yield open_study(study, protocol, seed=seed, group_readable=group_readable)
    finally:
        is_new = study / DESCRIPTION in made
        if is_new and not ((study / ParticipantRow.FILE).exists() or any(study.glob("sub-*"))):
            for each in made:
                with suppress(OSError):  # another has put something there, or nobody
                    if each.is_dir():
                        each.rmdir()
                    else:
                        each.unlink()


def _keep_instruments(study: Path, protocol: Protocol, access: Access) -> None:
    """Keep the lab's own instruments with the answers to them.

    Raises
    ------
    InputError
        If the study has another text of one: answers to both would stand under one name.
    """
    for name, text in protocol.own_instruments.items():
        file = study / INSTRUMENTS / f"{name}.toml"
        refuse_links(study, file)
        if not file.exists():
            make_folders(study, file.parent, access)
            replace_text(file, text, access)
        elif read_text(file, "instrument") != text:
            message = f"this study was begun with another text of `{name}`"
            hint = "give the changed instrument another name, or choose another output folder"
            raise InputError(f"{message}; {hint}", file=file)


def access_of(study: Path) -> Access:
    """Return the permissions of a study's files.

    Raises
    ------
    InputError
        If the study's description is damaged.
    """
    file = study / DESCRIPTION
    if not file.exists():
        return OWNER
    readers = read_description(study).get("readable_by")
    return GROUP if readers == "group" else OWNER


def read_description(study: Path) -> dict[str, Any]:
    """Return the content of a study's description.

    Raises
    ------
    InputError
        If it is damaged, or describes a dataset that is no study of ours: BIDS and Psych-DS call
        their files so, too.
    """
    file = study / DESCRIPTION
    content = read_json(file, DescribedShape, "study description")
    if not {"protocol", "seed"} & content.keys():
        message = "this describes a dataset, and no study that vrcomfort recorded"
        raise InputError(f"{message}; give the folder of the study", file=file)
    return read_json(file, DescriptionShape, "study description")


def _description(protocol: Protocol, seed: int, access: Access) -> dict[str, object]:
    return {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "schema_version": SCHEMA_VERSION,
        "name": protocol.title,
        "description": f"Comfort study recorded with vrcomfort, protocol {protocol.name}.",
        "citation": protocol.citation,
        "protocol": protocol.name,
        "seed": seed,
        "readable_by": "group" if access == GROUP else "owner",
        "conditions": {each.name: each.label or each.name for each in protocol.conditions},
        "scenes": list(protocol.scenes),
        "variableMeasured": [
            "participant", "session", "period", "trial", "condition", "scene",
            "timepoint", "instrument", "item", "response",
        ],
    }  # fmt: skip


def _same_study(file: Path, protocol: Protocol, seed: int | None, group_readable: bool) -> int:
    content = read_description(file.parent)
    name, kept = content["protocol"], int(content["seed"])
    if name != protocol.name:
        message = f"this folder holds a study with protocol `{name}`, not `{protocol.name}`"
        raise InputError(f"{message}; choose another output folder", file=file)
    if seed not in {None, kept}:
        message = f"this study was begun with seed {kept}, not {seed}"
        raise InputError(f"{message}; leave --seed out, or choose another output folder", file=file)
    if group_readable and access_of(file.parent) != GROUP:
        message = "this study was begun for its owner's eyes alone"
        raise InputError(
            f"{message}; leave --group-readable out, or choose another output folder", file=file
        )
    return kept


def read_participants(study: Path) -> list[ParticipantRow]:
    """Return the rows of all participants, in the order of enrolment.

    Raises
    ------
    InputError
        If the file is damaged: nobody is left out silently.
    """
    file = study / ParticipantRow.FILE
    rows: tuple[ParticipantRow, ...] = ()
    if file.exists():
        now = file.stat()
        rows = _participants(file, (now.st_ino, now.st_size, now.st_mtime_ns))
    begun = () if rows else sorted(study.glob("sub-*/ses-*/manifest.json"))
    if begun:  # going on would enrol them again
        who = begun[0].parent.parent.name
        message = f"it has no participants, and {who} has a session; restore it from a copy"
        raise InputError(message, file=file)
    return list(rows)


@lru_cache(maxsize=1)
def _participants(file: Path, _version: tuple[int, int, int]) -> tuple[ParticipantRow, ...]:
    """Read the list anew where the file has changed: each session looks into it several times."""
    found = read_table(file)
    if found.warnings:  # going on would enrol somebody twice
        last = len(found.rows) + 2
        message = "this row is half-written; complete it, with a line end, or remove it"
        raise InputError(message, file=file, line=last)
    own = ParticipantRow.columns()
    if found.rows and not set(own) <= set(found.header):
        raise InputError(f"the columns must be {', '.join(own)}", file=file, line=1)
    _check_participants(found)
    return tuple(_participant(row) for row in found.dicts())


def _participant(row: dict[str, str]) -> ParticipantRow:
    own = {name: row[name] for name in ParticipantRow.columns()}
    return ParticipantRow(**own, others=tuple((k, v) for k, v in row.items() if k not in own))


def _check_participants(found: CsvTable) -> None:
    seen: set[str] = set()
    for line, row in zip(found.lines, found.dicts(), strict=True):
        if row["participant"] in seen:
            message = f"{row['participant']} is here twice; mend it first"
            raise found.fault(message, line, "participant")
        seen.add(row["participant"])
        for column, shape in _PARTICIPANT_CELLS.items():
            if not shape.fullmatch(row[column]):
                message = f"{row[column][:40]!r} cannot be here; {_PARTICIPANT_WORDS[column]}"
                raise found.fault(message, line, column)


_PARTICIPANT_CELLS = {
    "participant": re.compile(r"[A-Za-z0-9]{1,64}"),
    "sequence": re.compile(r"[A-Za-z0-9_-]+"),
    "status": re.compile("enrolled|completed|withdrawn|excluded|erased"),
}
_PARTICIPANT_WORDS = {
    "participant": "a name is 1 to 64 letters (A to Z) and digits",
    "sequence": "write the sequence that the session's manifest has",
    "status": "write enrolled, completed, withdrawn or excluded",
}


def enrolled(study: Path, participant: str) -> ParticipantRow | None:
    """Return the participant's row, or None for a new participant.

    Raises
    ------
    InputError
        If they have withdrawn or been excluded.
    """
    for row in read_participants(study):
        if row.participant == participant:
            if row.status in {"withdrawn", "excluded", ERASED}:
                raise InputError(_gone(study, participant, row.status))
            return row
    return None


def _gone(study: Path, participant: str, status: str) -> str:
    remedy = "choose another participant"
    if status == "withdrawn":
        undo = f"vrcomfort undo-withdrawal {study} {participant} --reason …"
        remedy = f"if that was a slip of the hand: {undo}"
    return f"participant {participant} is {status} from this study; {remedy}"


def note_end(study: Path, participant: str, sessions: int) -> None:
    """Correct the status of a participant after the end of their last session.

    A program that was ended just then could write it into the session's manifest alone.

    Parameters
    ----------
    sessions
        How many the study has.
    """
    known = {row.participant: row.status for row in read_participants(study)}
    if known.get(participant) != "enrolled":
        return
    if ended := withdrawn_sessions(study, participant):
        set_status(study, participant, "withdrawn", f"session {ended[-1]}")
    elif len(completed_sessions(study, participant)) == sessions:
        set_status(study, participant, "completed")


def enrol(
    study: Path, design: Design, participant: str, covariates: Mapping[str, str] | None = None
) -> ParticipantRow:
    """Return the participant's row, enrolling them if they are new: in the group and sequence next.

    Parameters
    ----------
    covariates
        Those that the protocol declares; of an enrolled participant, those known of them or none.

    Raises
    ------
    InputError
        If the name cannot be part of a file name, differs from another in case alone, they have
        withdrawn or been excluded, or a covariate is missing, unknown, impossible or another.
    """
    check_participant(participant)
    with changing_participants(study):
        check_case(participant, (row.participant for row in read_participants(study)))
        there = enrolled(study, participant)
        known = entered(design, there, covariates or {})
        if there is not None:
            return there
        rows = read_participants(study)
        sequence = design.assign((enrolment_of(row) for row in rows), known)
        group = {"group": sequence.group} if sequence.group else {}
        others = tuple({**group, **known}.items())
        row = ParticipantRow(participant, sequence.name, "enrolled", now(), others=others)
        _write_participants(study, [*rows, row])
    return row


def enrolment_of(row: ParticipantRow) -> Enrolment:
    """Return the enrolment of a participant's row, for the assignment of orders."""
    return Enrolment(row.sequence, row.status, row.covariates)


def entered(
    design: Design, there: ParticipantRow | None, covariates: Mapping[str, str]
) -> dict[str, str]:
    """Return the covariates of a participant, checked.

    Raises
    ------
    InputError
        If one is missing, unknown, impossible, or not what was entered at the enrolment.
    """
    if there is None:
        return design.checked(covariates)
    for name, value in design.checked({**there.covariates, **covariates}).items():
        before = there.covariates.get(name, value)
        if value != before:
            message = f"{there.participant} was enrolled with {name} = {before}, not {value}"
            raise InputError(f"{message}; leave --covariate out")
    return there.covariates


def checked_reason(row: ParticipantRow, text: str) -> str:
    """Return an experimenter's reason or note, escaped.

    Raises
    ------
    InputError
        If it is empty, or longer than a note can be.
    """
    reason = escape_unprintable(text.strip())
    if not reason:
        raise InputError("the text is empty; say why")
    if len(reason) > LONGEST_TEXT:
        message = f"the text has {len(reason):,} characters, and a note at most {LONGEST_TEXT:,}"
        raise InputError(f"{message}; shorten it")
    if len(row.note) + len(reason) > LONGEST_NOTES:
        message = f"the notes on {row.participant} have {len(row.note):,} characters and are full"
        raise InputError(f"{message}; keep this one elsewhere")
    return reason


def changing_participants(study: Path) -> AbstractContextManager[None]:
    """Two participants may be run at once; their rows are written one after the other."""
    file = study / ".participants.lock"
    refuse_links(study, file)
    return in_turn(file, access_of(study))


def change_participants(
    study: Path, change: Callable[[list[ParticipantRow]], list[ParticipantRow]]
) -> None:
    """Write the rows of all participants as `change` returns them; other programs wait."""
    with changing_participants(study):
        _write_participants(study, change(read_participants(study)))


def set_status(study: Path, participant: str, status: str, note: str = "") -> None:
    """Change a participant's status; notes are added to those before."""
    change_participants(
        study,
        lambda rows: [
            replace(row, status=status, note="; ".join(filter(None, [row.note, note])))
            if row.participant == participant
            else row
            for row in rows
        ],
    )


def set_fact(study: Path, participant: str, name: str, value: str) -> None:
    """Write a result of a session into the participant's row."""
    change_participants(
        study,
        lambda rows: [
            replace(row, others=tuple({**dict(row.others), name: value}.items()))
            if row.participant == participant
            else row
            for row in rows
        ],
    )


def recorded_sessions(study: Path, participant: str) -> list[int]:
    """Return the numbers of a participant's sessions that are on disk."""
    folders = session_folder(study, participant, 1).parent.glob("ses-*")
    numbers = [folder.name.removeprefix("ses-") for folder in folders if is_begun(folder)]
    return sorted(int(number) for number in numbers if re.fullmatch("[1-9][0-9]{0,8}", number))


def completed_sessions(study: Path, participant: str) -> list[int]:
    """Return the numbers of a participant's sessions that are over, to their end or early."""
    return _sessions(study, participant, lambda status: status in {"completed", "ended"})


def withdrawn_sessions(study: Path, participant: str) -> list[int]:
    """Return the numbers of a participant's withdrawn sessions, by their manifests."""
    return _sessions(study, participant, lambda status: status == "withdrawn")


def unfinished_sessions(study: Path, participant: str) -> list[int]:
    """Return the numbers of a participant's interrupted sessions."""
    return _sessions(study, participant, lambda status: status not in _FINISHED)


_FINISHED = {"completed", "ended", "withdrawn"}


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
        On entering, if another program runs this participant; at once for a name that no folder
        has, or that differs from another in case alone.
    """
    check_participant(participant)
    check_case(participant, (row.participant for row in read_participants(study)))
    file, access = session_folder(study, participant, 1).with_name("lock"), access_of(study)
    try:
        make_folders(study, file.parent, access)
    except OSError as error:
        raise refused(file.parent, error) from error
    return _only_run(file, access, doing=f"participant {participant} is being run")


@contextmanager
def _only_run(lock: Path, access: Access, *, doing: str) -> Iterator[None]:
    """Hold a participant's lock; where nothing was recorded, their folder goes at the end."""
    try:
        with only_program(lock, access, doing=doing):
            try:
                yield
            finally:
                if not _CLOSED_FIRST:
                    _remove_where_alone(lock)
    finally:
        if _CLOSED_FIRST:
            _remove_where_alone(lock)
        with suppress(OSError):
            lock.parent.rmdir()


_CLOSED_FIRST = sys.platform == "win32"
"""Windows removes no open file: neither ours while we hold it, nor that of another program."""


def _remove_where_alone(lock: Path) -> None:
    with suppress(OSError):
        if [each.name for each in lock.parent.iterdir()] == [lock.name]:
            lock.unlink()


def _write_participants(study: Path, rows: list[ParticipantRow]) -> None:
    others = list(dict.fromkeys(name for row in rows for name, _ in row.others))
    lines = [csv_line((*ParticipantRow.columns(), *others))]
    for row in rows:
        more = [dict(row.others).get(name, "") for name in others]
        lines.append(csv_line((*row.cells(), *more)))
    replace_listed(study / ParticipantRow.FILE, "".join(lines), access_of(study))
    _participants.cache_clear()
