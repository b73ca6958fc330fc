"""The status of a study: its participants, their next sessions, its size on the disk."""

from __future__ import annotations

import shlex
import shutil
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from vrcomfort import __version__
from vrcomfort.design import Design
from vrcomfort.errors import InputError
from vrcomfort.exchange.designs import design_of, protocol_of
from vrcomfort.exchange.imports import is_import
from vrcomfort.records.apparatus import differences
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.reader import Session, Study
from vrcomfort.records.session_rows import ParticipantRow
from vrcomfort.records.study import (
    DESCRIPTION,
    ERASED,
    enrolment_of,
    read_description,
    read_participants,
)

OPEN = ("interrupted", "running or killed")

Content: TypeAlias = dict[str, Any]
"""Of a manifest."""
Begun: TypeAlias = tuple[Session, Content | InputError]
"""A session, and its manifest or what is wrong with it."""


@dataclass(frozen=True)
class SessionState:
    """One session that was begun.

    Parameters
    ----------
    status
        completed, withdrawn, interrupted, "running or killed", or damaged.
    exposures
        Shown whole; `planned` of them are in the order (None where it is not known).
    flagged
        Trials whose timing was worse than the protocol allows.
    fault
        Of a damaged manifest, in a sentence.
    """

    number: int
    status: str
    exposures: int
    planned: int | None
    started_at: str = ""
    flagged: int = 0
    fault: str = ""


@dataclass(frozen=True)
class PersonState:
    """One participant: their row, their sessions, and the command that is next."""

    participant: str
    status: str
    sequence: str
    group: str
    sessions: tuple[SessionState, ...]
    next: str
    command: str
    note: str


@dataclass
class StudyState:
    """A whole study.

    Parameters
    ----------
    next_sequence, next_group
        What the next new participant gets; None where `not_known` says why not.
    places
        Participants who take a place, of `participants_planned` (None where the protocol says
        none).
    schema_versions, versions
        Of the sessions' manifests, and the vrcomfort that recorded them → sessions.
    bytes_used, bytes_free
        Of the study's folder, and left on its disk.
    differences
        What its sessions differ in, of headset, image size, refresh rate, software and GPU.
    """

    study: str
    name: str
    protocol: str
    seed: int
    people: list[PersonState]
    statuses: dict[str, int]
    places: int | None = None
    participants_planned: int | None = None
    next_sequence: str | None = None
    next_group: str | None = None
    not_known: str = ""
    schema_versions: dict[str, int] = field(default_factory=dict)
    versions: dict[str, int] = field(default_factory=dict)
    vrcomfort: str = __version__
    bytes_used: int = 0
    bytes_free: int = 0
    differences: list[str] = field(default_factory=list)


def status_of(study: Path) -> StudyState:
    """Read where a study stands; nothing is changed.

    Raises
    ------
    InputError
        If this is no study folder, an import, or its description or participants are damaged.
    """
    if is_import(study):
        message = "this is an import, which has no sessions; vrcomfort report describes it"
        raise InputError(message, file=study)
    if not (study / DESCRIPTION).is_file():
        raise InputError(f"this is not a study folder: it has no {DESCRIPTION}", file=study)
    description = read_description(study)
    recorded = Study(study)
    rows = read_participants(study)
    begun = {
        row.participant: [(each, _manifest(each)) for each in recorded.sessions_of(row.participant)]
        for row in rows
    }
    known = [each for those in begun.values() for each in _readable(those)]
    last = max(known, key=lambda each: str(each["started_at"]), default=None)
    design, not_known = _design(last)
    state = StudyState(
        study=str(study),
        name=str(description.get("name", "")),
        protocol=description["protocol"],
        seed=description["seed"],
        people=[_person(study, row, begun[row.participant], design, last) for row in rows],
        statuses=dict(Counter(row.status for row in rows)),
        not_known=not_known,
        schema_versions=dict(Counter(str(each.get("schema_version", 1)) for each in known)),
        versions=dict(Counter(str(each["versions"].get("vrcomfort", "?")) for each in known)),
        bytes_used=_bytes_of(study),
        bytes_free=shutil.disk_usage(study).free,
        differences=differences(known),
    )
    if design is not None and last is not None:
        _next_participant(state, rows, design)
        state.participants_planned = protocol_of(last).participants
    return state


def _bytes_of(study: Path) -> int:
    size = 0
    for file in study.rglob("*"):
        with suppress(FileNotFoundError):  # a draft, which has taken its place meanwhile
            size += file.lstat().st_size if file.is_file() else 0
    return size


def _manifest(session: Session) -> Content | InputError:
    """Return a session's manifest, or the error of a damaged one."""
    try:
        return session.manifest
    except InputError as error:
        return error


def _readable(begun: Iterable[Begun]) -> list[Content]:
    return [manifest for _, manifest in begun if not isinstance(manifest, InputError)]


def _design(last: Mapping[str, Any] | None) -> tuple[Design | None, str]:
    """Return the design of the study, or why it is not known."""
    if last is None:
        return None, "no session says yet which protocol this is; vrcomfort design shows its orders"
    try:
        return design_of(last), ""
    except InputError as error:
        return None, error.message


def _next_participant(state: StudyState, rows: Sequence[ParticipantRow], design: Design) -> None:
    """Enter the order and group of the next new participant."""
    enrolments = [enrolment_of(row) for row in rows]
    state.places = sum(design.counts(each) for each in enrolments)
    if design.groups is not None and design.groups.bands:
        bands = ", ".join(design.groups.bands)
        state.not_known = f"the next participant's group depends on their {bands}"
        return
    try:
        sequence = design.assign(enrolments)
    except InputError as error:
        state.not_known = error.message
        return
    state.next_sequence, state.next_group = sequence.name, sequence.group or ""


def _person(
    study: Path,
    row: ParticipantRow,
    begun: Sequence[Begun],
    design: Design | None,
    last: Mapping[str, Any] | None,
) -> PersonState:
    planned = _planned(design, row.sequence)
    sessions = tuple(_session(session, manifest, planned) for session, manifest in begun)
    step, options = _next_step(row, sessions, len(planned) if planned else None)
    own = next(reversed(_readable(begun)), last)
    command = "" if options is None else _command(study, row.participant, own, options)
    group, note = row.group or "", row.note
    return PersonState(
        row.participant, row.status, row.sequence, group, sessions, step, command, note
    )


def _planned(design: Design | None, sequence: str) -> list[int] | None:
    """Return how many exposures each session of an order has."""
    if design is None:
        return None
    try:
        return [len(session) for session in design.sequence(sequence).sessions]
    except InputError:
        return None


def _session(
    session: Session, manifest: Content | InputError, planned: Sequence[int] | None
) -> SessionState:
    number = session.number
    exposures = planned[number - 1] if planned and number <= len(planned) else None
    done = _exposures(session)
    if isinstance(manifest, InputError):
        return SessionState(number, "damaged", done, exposures, fault=str(manifest))
    names = {"aborted": "interrupted", "running": "running or killed"}
    status = str(names.get(manifest["status"], manifest["status"]))
    flagged = len(manifest["timing_flags"])
    return SessionState(number, status, done, exposures, manifest["started_at"], flagged)


def _exposures(session: Session) -> int:
    """Count the exposures that were shown whole."""
    try:
        rows = session.text_rows(TrialRow)
        return len({row["trial"] for row in rows if row["status"] == "completed"})
    except (InputError, KeyError):
        return 0


def _next_step(
    row: ParticipantRow, sessions: Sequence[SessionState], total: int | None
) -> tuple[str, list[str] | None]:
    """Return a participant's next step, and the options of `run`; None: nothing to run."""
    damaged = [each.number for each in sessions if each.status == "damaged"]
    if damaged:
        return f"session {damaged[0]} is damaged: vrcomfort verify says what to do", None
    if row.status in {"withdrawn", "excluded", ERASED, "completed"}:
        return "", None
    for each in sessions:
        if each.status in OPEN:
            return f"continue session {each.number}", ["--resume"]
    done = {each.number for each in sessions}
    number = next(n for n in range(1, len(done) + 2) if n not in done)
    if total is not None and number > total:
        return "nothing: all sessions are recorded", None
    return f"session {number}", []


def _command(
    study: Path, participant: str, manifest: Mapping[str, Any] | None, options: list[str]
) -> str:
    """Return the words to type; the protocol's file is wherever it was."""
    if manifest is None:
        return ""
    protocol = manifest["protocol"].get("file") or manifest["protocol"]["name"]
    words = ["vrcomfort", "run", protocol, "--participant", participant, "--out", str(study)]
    if manifest["respondent"] != "terminal":
        words += ["--respondent", manifest["respondent"]]
    return shlex.join([*words, *options])
