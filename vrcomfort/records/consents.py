"""Consents of participants, each with its date and version of the text: ``consents.csv``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.files import sha256_of
from vrcomfort.protocol import Protocol
from vrcomfort.records.disk import replace_text
from vrcomfort.records.rows import csv_line
from vrcomfort.records.session_rows import ConsentRow
from vrcomfort.records.study import access_of, changing_participants, now
from vrcomfort.records.tables import read_table


@dataclass(frozen=True)
class Given:
    """A consent as an experimenter enters it; without a day, it was given today."""

    version: str
    on: str | None = None


def read_consents(study: Path) -> list[ConsentRow]:
    """Return all consents of a study, in order.

    Raises
    ------
    InputError
        If the file is damaged.
    """
    file = study / ConsentRow.FILE
    if not file.exists():
        return []
    found = read_table(file, appended=False)
    found.require(list(ConsentRow.columns()))
    rows = []
    for line, row in zip(found.lines, found.dicts(), strict=True):
        if not re.fullmatch(r"\d{4}-\d\d-\d\d", row["given_on"]):
            raise found.fault(f"{row['given_on'][:40]!r} is no day; mend it", line, "given_on")
        rows.append(ConsentRow(**{name: row[name] for name in ConsentRow.columns()}))
    return rows


def required_consent(
    protocol: Protocol, study: Path, participant: str, given: Given | None, *, simulated: bool
) -> ConsentRow | None:
    """Return the consent that is to be entered before a session; None where nothing is.

    Raises
    ------
    InputError
        If the participant has not consented in the protocol's version, or what is entered cannot
        be.
    """
    wanted = protocol.consent
    if wanted is None:
        if given is not None:
            message = f"protocol {protocol.name} asks for no consent; leave --consent out"
            raise InputError(f"{message}, or add [consent]", file=protocol.file)
        return None
    text = text_sha256(protocol)
    before = [row for row in read_consents(study) if row.participant == participant]
    of_this = [row for row in before if row.version == wanted.version]
    if of_this and of_this[-1].text_sha256 != text:
        message = f"the text of consent `{wanted.version}` has changed since {participant} gave it"
        raise InputError(f"{message}; give the new text another version", file=protocol.file)
    if given is None and simulated:
        given = Given(wanted.version)
    if given is not None:
        return _entered(wanted.version, participant, given, text, of_this)
    if of_this:
        return None
    raise InputError(_missing(wanted.version, participant, before), file=protocol.file)


def _missing(version: str, participant: str, before: Sequence[ConsentRow]) -> str:
    if before:
        last = before[-1]
        message = f"{participant} consented in version `{last.version}` on {last.given_on}, and the"
        message = f"{message} protocol asks for `{version}` now: ask again"
    else:
        message = f"{participant} has not consented; the protocol asks for version `{version}`"
    return f"{message}; when consent is given: --consent {version}"


def _entered(
    version: str, participant: str, given: Given, text: str, of_this: Sequence[ConsentRow]
) -> ConsentRow | None:
    if given.version != version:
        message = f"the protocol asks for consent in version `{version}`, not `{given.version}`"
        raise InputError(f"{message}; let the participant read that one")
    on = given.on or datetime.now(UTC).date().isoformat()
    try:
        day = date.fromisoformat(on)
    except ValueError:
        raise InputError(f"--consented-on {on!r} is not a date; write it as 2026-03-01") from None
    if day > datetime.now(UTC).date():
        raise InputError(f"--consented-on {on} is in the future; write the day it was given")
    if of_this:
        return None
    return ConsentRow(participant, version, day.isoformat(), text, now())


def text_sha256(protocol: Protocol) -> str:
    """Return the hash of the text that the protocol names; blank where it names none."""
    if protocol.consent is None or not protocol.consent.file:
        return ""
    beside = protocol.file.parent if protocol.file else Path()
    return sha256_of(beside / protocol.consent.file)


def erase_consents(study: Path, participant: str) -> None:
    """Delete a participant's consents."""
    with changing_participants(study):
        rows = read_consents(study)
        left = [row for row in rows if row.participant != participant]
        if len(left) < len(rows):
            _write(study, left)


def note_consent(study: Path, row: ConsentRow) -> None:
    """Write a consent down; it is on the disk at return."""
    with changing_participants(study):
        _write(study, [*read_consents(study), row])


def _write(study: Path, rows: Sequence[ConsentRow]) -> None:
    lines = [csv_line(ConsentRow.columns())]
    lines += [csv_line(each.cells()) for each in rows]
    replace_text(study / ConsentRow.FILE, "".join(lines), access_of(study))
