"""Compares the files about a whole study with their checksums."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying.findings import Verified
from vrcomfort.exchange.verifying.moments import MOST_LOOKS
from vrcomfort.files import read_text, sha256_of
from vrcomfort.records.checksums import (
    CHECKSUMS,
    Checksum,
    changed_parts,
    listed_files,
    read_checksums,
)
from vrcomfort.records.session_rows import ParticipantRow
from vrcomfort.records.study import DESCRIPTION


def check_listed(study: Path, found: Verified) -> None:
    """Compare the files about the whole study with their checksums.

    Labs edit them: a change is a note, which names the columns or keys.
    """
    file = study / CHECKSUMS
    if not file.exists():
        found.note(file, "is missing (older versions wrote none): changes cannot be seen")
        return
    try:
        known = read_checksums(study)
    except InputError as error:
        found.refusal(error, file)
        return
    for each in (study / name for name in listed_files(known)):
        if _is_listed(each):
            found.intact.add(each)
        else:
            found.altered.add(each)
            _tell_change(each, known, found)


def _is_listed(file: Path) -> bool:
    """Return whether a file is as its list says; commands may change both meanwhile."""
    for _ in range(MOST_LOOKS):
        with suppress(InputError, OSError, KeyError):
            if read_checksums(file.parent)[file.name].fits(sha256_of(file)):
                return True
    return False


def _tell_change(file: Path, known: Mapping[str, Checksum], found: Verified) -> None:
    """Tell of a file about the whole study that is not as it was written."""
    kind = {DESCRIPTION: "keys", ParticipantRow.FILE: "columns"}.get(file.name)
    if kind is None:
        what = "has changed since the import" if file.exists() else "is missing"
        found.fault(file, f"{what}; restore it from a copy, or import again")
        return
    try:
        parts = changed_parts(known, file.name, read_text(file, "text"))
    except InputError:  # it is missing or damaged, which is told where its content is read
        return
    where = f"{kind} {', '.join(parts)}" if parts else "its form, not its content"
    message = f"was changed by hand, not by vrcomfort: {where}"
    found.note(file, f"{message}; nothing to do where that is right")
