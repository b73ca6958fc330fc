"""Verifies a study: its participants and its sessions, and that they belong together."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.exchange.designs import design_of
from vrcomfort.exchange.imports import IMPORT, is_import
from vrcomfort.exchange.verifying.findings import Verified
from vrcomfort.exchange.verifying.lists import check_listed
from vrcomfort.exchange.verifying.moments import MOST_LOOKS, state_of
from vrcomfort.exchange.verifying.session import check_order, is_draft, verify_session
from vrcomfort.files import sha256_of
from vrcomfort.records.checksums import CHECKSUMS
from vrcomfort.records.choice import SessionName, session_name
from vrcomfort.records.consents import read_consents
from vrcomfort.records.exposure_rows import RatingRow, TrialRow
from vrcomfort.records.json_file import (
    CopyShape,
    DescribedShape,
    ImportShape,
    read_json,
    read_shape,
)
from vrcomfort.records.preflights import FILE as PREFLIGHT
from vrcomfort.records.preflights import read_preflight
from vrcomfort.records.reader import Session
from vrcomfort.records.recorder import is_begun
from vrcomfort.records.session_rows import ConsentRow, ParticipantRow, QuestionnaireRow
from vrcomfort.records.study import DESCRIPTION, read_description, read_participants
from vrcomfort.records.tables import read_table

_ANONYMISED = "anonymised.json"
_OWN = {
    DESCRIPTION, ParticipantRow.FILE, ConsentRow.FILE, CHECKSUMS, "instruments",
    ".participants.lock", _ANONYMISED, PREFLIGHT,
}  # fmt: skip


def verify_study(
    study: Path,
    told: Callable[[], object] = lambda: None,
    *,
    without: Collection[SessionName] = (),
) -> Verified:
    """Look at everything in a study folder; nothing is changed.

    Parameters
    ----------
    told
        Called after each session.
    without
        Sessions that are passed over, as are those that an anonymous copy was made without.

    Raises
    ------
    InputError
        If this is no study folder.
    """
    imported = is_import(study)
    if not imported and not any((study / name).exists() for name in (DESCRIPTION, "sub-P01")):
        raise InputError(f"this is not a study folder: it has no {DESCRIPTION}", file=study)
    if not imported and not _is_recorded(study):
        read_description(study)  # which refuses other programs' datasets
    found = Verified(study)
    check_listed(study, found)
    seed = _description(study, found, imported=imported)
    if imported:
        _imported(study, found)
        found.leave_out_consequences()
        return found
    begun = {each.parent for each in session_folders(study) if is_begun(each)}  # listed before
    people = _participants(study, found)
    _strangers(study, begun, people, found)
    left_out = {*without, *_not_copied(study, found)}
    manifests = {
        name: _sessions(study / f"sub-{name}", found, told, left_out)
        for name in sorted(_folders(study) | set(people or ()))
    }
    _consents(study, people, manifests, found)
    try:
        read_preflight(study)
    except InputError as error:
        found.refusal(error, study / PREFLIGHT)
    now = _rows_now(study)  # whoever was changed meanwhile is being run
    for name, sessions in sorted(manifests.items()):
        if people and name in people and now.get(name) == people[name]:
            left = sum(each.participant == name for each in left_out)
            _agree(study, people[name], sessions, seed, found, left)
    found.leave_out_consequences()
    return found


def _is_recorded(study: Path) -> bool:
    """Return whether anything but the description says that vrcomfort recorded this study."""
    manifests = (each / "manifest.json" for each in session_folders(study))
    return (study / ParticipantRow.FILE).exists() or any(each.exists() for each in manifests)


def _not_copied(study: Path, found: Verified) -> list[SessionName]:
    """Return the sessions that an anonymous copy was made without, as its record says."""
    file = study / _ANONYMISED
    if not file.is_file():
        return []
    try:
        said = read_shape(file, CopyShape, "record of a copy")
        return [session_name(each) for each in said.sessions_left_out]
    except InputError as error:
        found.refusal(error, file)
    return []


def _consents(
    study: Path,
    people: Mapping[str, ParticipantRow] | None,
    manifests: Mapping[str, Mapping[int, Mapping[str, Any] | None]],
    found: Verified,
) -> None:
    """Check that each requested consent was given; anonymised copies have none."""
    file = study / ConsentRow.FILE
    if (study / _ANONYMISED).exists():
        return
    try:
        given = {(row.participant, row.version) for row in read_consents(study)}
    except InputError as error:
        found.refusal(error, file)
        return
    unlisted = sorted({name for name, _ in given} - set(people or ()))
    for who in unlisted if people is not None else ():
        found.fault(file, f"{who} is not in {ParticipantRow.FILE}; restore the changed file")
    for name, sessions in sorted(manifests.items()):
        for number, manifest in sorted(sessions.items()):
            asked = ((manifest or {}).get("settings") or {}).get("consent") or {}
            if asked and (name, asked.get("version")) not in given:
                message = f"session {number} of {name} asked for consent `{asked.get('version')}`"
                found.fault(file, f"{message}, which is not here; restore it from a copy")


def session_folders(study: Path) -> list[Path]:
    """Return the folders of all sessions."""
    return sorted(folder for folder in study.glob("sub-*/ses-*") if folder.is_dir())


def _description(study: Path, found: Verified, *, imported: bool) -> int | None:
    """Check the study's description; return its seed."""
    file = study / DESCRIPTION
    if not file.exists():
        found.fault(file, "is missing; restore it from a copy")
        return None
    try:
        content = (
            read_json(file, DescribedShape, "study description")
            if imported
            else read_description(study)
        )
    except InputError as error:
        found.refusal(error, file)
        return None
    seed = content.get("seed")
    return int(seed) if seed is not None else None


def _participants(study: Path, found: Verified) -> dict[str, ParticipantRow] | None:
    """Return name → row; None, and a finding, where the list cannot be read."""
    file = study / ParticipantRow.FILE
    if not file.exists() and not any(is_begun(each) for each in session_folders(study)):
        found.note(file, "is not there yet: nobody has been enrolled")
        return {}
    if not file.exists():
        found.fault(file, "is missing; restore it from a copy")
        return None
    try:
        rows = read_participants(study)
    except InputError as error:
        found.refusal(error, file)
        return None
    found.counts["participants"] = len(rows)
    return {row.participant: row for row in rows}


def _rows_now(study: Path) -> dict[str, ParticipantRow]:
    try:
        return {row.participant: row for row in read_participants(study)}
    except InputError:  # which has been told
        return {}


def _folders(study: Path) -> set[str]:
    return {each.name.removeprefix("sub-") for each in study.glob("sub-*") if each.is_dir()}


def _strangers(
    study: Path,
    begun: Collection[Path],
    people: Mapping[str, ParticipantRow] | None,
    found: Verified,
) -> None:
    """Find files in the study's folder that no recording has put there.

    Parameters
    ----------
    begun
        Folders of participants with a session.
    """
    for each in sorted(study.iterdir()):
        if each.name.startswith("sub-") and each.is_dir():
            known = people is None or each.name.removeprefix("sub-") in people
            if not known and each in begun:
                _homeless(each, study / ParticipantRow.FILE, found)
        elif each.is_symlink():
            found.fault(each, "is a symbolic link; put the file or folder itself here")
        elif each.name not in _OWN and not is_draft(each):
            found.note(each, "is not of vrcomfort's making; nothing in it was checked")


def _homeless(folder: Path, people: Path, found: Verified) -> None:
    """Tell of a participant's folder without a row in the list."""
    if people in found.altered:
        who = folder.name.removeprefix("sub-")
        found.fault(people, f"lacks {who}, who has sessions; restore the row")
    else:
        message = f"{people.name} does not list this participant"
        found.fault(folder, f"{message}; restore that file, or move the folder away")


def _sessions(
    folder: Path,
    found: Verified,
    told: Callable[[], object],
    left_out: Collection[SessionName],
) -> dict[int, dict[str, Any] | None]:
    """Verify a participant's sessions; return session → manifest."""
    manifests: dict[int, dict[str, Any] | None] = {}
    for each in _entries(folder, found):
        number = re.fullmatch("ses-([1-9][0-9]{0,8})", each.name)
        if number and (folder.name.removeprefix("sub-"), int(number[1])) in left_out:
            continue
        if number and each.is_dir() and not each.is_symlink():
            found.counts["sessions"] += 1
            manifests[int(number[1])] = _session(each, found)
            told()
        elif each.name != "lock":
            found.fault(each, "is neither a session nor the lock; move it out of the study")
    return manifests


def _entries(folder: Path, found: Verified) -> list[Path]:
    try:
        return sorted(folder.iterdir()) if folder.is_dir() else []
    except OSError as error:
        found.unreadable(error, folder)
        return []


def _session(folder: Path, found: Verified) -> dict[str, Any] | None:
    """Verify one session; a file that the system refuses to read is a finding.

    Where something is wrong and a program has written meanwhile, it is looked at again.
    """
    manifest = None
    for _ in range(MOST_LOOKS):
        looked, before = Verified(found.study), state_of(folder)
        try:
            manifest = verify_session(folder, looked)
        except OSError as error:
            manifest = None
            looked.unreadable(error, folder)
        if not looked.faults or state_of(folder) == before:
            break
    found.add(looked)
    return manifest


def _agree(
    study: Path,
    row: ParticipantRow,
    manifests: Mapping[int, Mapping[str, Any] | None],
    seed: int | None,
    found: Verified,
    left_out: int,
) -> None:
    """Compare a participant's row with the manifests of their sessions."""
    file = study / ParticipantRow.FILE
    planned: int | None = None
    statuses: dict[int, str | None] = {}
    for number, manifest in manifests.items():
        folder = study / f"sub-{row.participant}" / f"ses-{number}"
        if manifest is None:
            statuses[number] = None
            continue
        statuses[number] = manifest["status"]
        for key, there in (("sequence", row.sequence), ("seed", seed)):
            if there is not None and manifest[key] != there:
                where = study / (ParticipantRow.FILE if key == "sequence" else DESCRIPTION)
                pair = [(folder / "manifest.json", manifest[key]), (where, there)]
                if found.suspect(pair[0][0], where) == where:
                    pair.reverse()
                (place, one), (other, another) = pair
                message = f"`{key}` is {one}, and {other.relative_to(study)} says {another}"
                found.fault(place, f"{message}; restore the changed file")
        planned = _check_session_order(folder, row, manifest, found) or planned
    _check_status(file, row, statuses, planned, found, left_out)


def _check_status(
    file: Path,
    row: ParticipantRow,
    statuses: Mapping[int, str | None],
    planned: int | None,
    found: Verified,
    left_out: int,
) -> None:
    who, completed = (
        row.participant,
        [n for n, each in statuses.items() if each in {"completed", "ended"}],
    )
    withdrew = [number for number, each in statuses.items() if each == "withdrawn"]
    told = sum(each is None for each in statuses.values())  # of damaged manifests
    there = len(completed) + left_out + told
    if row.status == "completed" and planned is not None and there < planned:
        message = f"{who} is completed, with {len(completed)} of {planned} sessions completed"
        place = file.parent / f"sub-{who}" if file in found.intact else file
        found.fault(place, f"{message}; restore what is missing, or write enrolled")
    elif row.status == "completed" and not statuses and not left_out:
        place = file.parent / f"sub-{who}" if file in found.intact else file
        found.fault(place, f"{who} is completed, and has no session; restore the folder")
    elif row.status == "enrolled" and withdrew:
        message = f"{who} is enrolled, and has withdrawn in session {withdrew[0]}"
        found.fault(file, f"{message}; write withdrawn, or take it back: vrcomfort undo-withdrawal")
    elif row.status == "enrolled" and planned is not None and len(completed) == planned:
        message = f"{who} is enrolled, and all sessions are completed; write completed"
        folder = file.parent / f"sub-{who}" / f"ses-{completed[-1]}"
        lock = folder.with_name("lock")
        under_way = lock.exists() and lock.stat().st_size > 0
        if (folder / CHECKSUMS).exists() and not under_way:
            found.fault(file, message)
        else:  # which come last
            found.note(file, f"{message}, where the program was killed before it did")


def _check_session_order(
    folder: Path, row: ParticipantRow, manifest: Mapping[str, Any], found: Verified
) -> int | None:
    """Check the trials against the participant's order; return how many sessions that has."""
    file = folder / TrialRow.FILE
    try:
        sessions = design_of(manifest).sequence(row.sequence).sessions
        table = Session(folder).table(TrialRow)
        table.require(("trial", "condition", "scene", "status"))
    except InputError:
        return None  # which has been told, or another version's protocol
    number = manifest["session"]
    if number > len(sessions):
        message = f"this participant's order has {len(sessions)} sessions, and no {number}"
        found.fault(folder / "manifest.json", f"{message}; restore the changed file")
        return len(sessions)
    completed = manifest["status"] == "completed"
    check_order(file, table.dicts(), sessions[number - 1], found, completed=completed)
    return len(sessions)


def _imported(study: Path, found: Verified) -> None:
    """Check an import: its mapping is the one it names, and its tables are of its participants."""
    file = study / IMPORT
    try:
        said = read_json(file, ImportShape, "note of where an import came from").get("mapping")
    except InputError as error:
        found.refusal(error, file)
        return
    copy = study / "mapping.toml"
    if isinstance(said, dict) and copy.exists() and sha256_of(copy) != said.get("sha256"):
        found.fault(copy, f"is not the mapping that {IMPORT} names; restore it, or import again")
    people = {row["participant"] for _, row in _table(study / ParticipantRow.FILE, found)}
    found.counts["participants"] = len(people)
    for name in (QuestionnaireRow.FILE, RatingRow.FILE):
        for line, row in _table(study / name, found) if (study / name).exists() else ():
            found.counts[f"rows of {name}"] += 1
            if people and row["participant"] not in people:
                _unlisted(study, name, line, row["participant"], found)


def _unlisted(study: Path, name: str, line: int, who: str, found: Verified) -> None:
    """Report a row of a participant missing from the list of participants."""
    people = study / ParticipantRow.FILE
    if found.suspect(study / name, people) == people:
        message = f"does not list {who} of {name}, line {line}"
        found.fault(people, f"{message}; restore the row, or import again")
    else:
        message = f"{people.name} does not list {who}"
        found.fault(study / name, f"{message}; import again", line)


def _table(file: Path, found: Verified) -> list[tuple[int, dict[str, str]]]:
    """Return line and cells of each row; none, and a finding, where it is no table."""
    try:
        table = read_table(file, appended=False)
        table.require(("participant",))
    except InputError as error:
        found.refusal(error, file)
        return []
    return list(zip(table.lines, table.dicts(), strict=True))
