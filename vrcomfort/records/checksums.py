"""``checksums.sha256`` of a session: its files at its end.

It has the form of the program ``sha256sum``, so ``sha256sum --check checksums.sha256`` reads it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from vrcomfort.errors import InputError
from vrcomfort.files import read_text, sha256_of
from vrcomfort.records.disk import Access, replace_text

CHECKSUMS = "checksums.sha256"
_LINE = re.compile(r"([0-9a-f]{64})  ([^/\\]+)")


class Checksum(NamedTuple):
    """The SHA-256 of a file, and the 1-based line that says it."""

    sha256: str
    line: int


def write_checksums(folder: Path, access: Access) -> None:
    """Write the checksums of a session's files after its end.

    Parquet files are left out: they are copies that can be made again.

    Raises
    ------
    InputError
        If the disk refuses.
    """
    files = [each for each in folder.iterdir() if each.is_file() and not each.is_symlink()]
    names = [each.name for each in files if each.suffix != ".parquet" and each.name[0] != "."]
    _write(folder, {name: sha256_of(folder / name) for name in names if name != CHECKSUMS}, access)


def update_checksums(folder: Path, names: Iterable[str], access: Access) -> None:
    """Write the checksums of some files after an operator's command; the others stay.

    A list that is damaged stays as it is: `vrcomfort verify` tells of it.

    Raises
    ------
    InputError
        If the disk refuses.
    """
    if not (folder / CHECKSUMS).exists():
        return
    try:
        known = {name: each.sha256 for name, each in read_checksums(folder).items()}
    except InputError:
        return
    known |= {name: sha256_of(folder / name) for name in names if (folder / name).exists()}
    _write(folder, known, access)


def remove_checksums(folder: Path) -> None:
    """Take the checksums away from a session that goes on: they would not hold."""
    (folder / CHECKSUMS).unlink(missing_ok=True)


def read_checksums(folder: Path) -> dict[str, Checksum]:
    """Return file name → checksum.

    Raises
    ------
    InputError
        If a line is none.
    """
    file = folder / CHECKSUMS
    found: dict[str, Checksum] = {}
    lines = read_text(file, "list of checksums").removesuffix("\n").split("\n")
    for number, line in enumerate(lines, start=1):
        parts = _LINE.fullmatch(line)
        if parts is None:
            message = "this is no checksum and file name; restore the file from a copy"
            raise InputError(message, file=file, line=number)
        found[parts[2]] = Checksum(parts[1], number)
    return found


def _write(folder: Path, known: dict[str, str], access: Access) -> None:
    text = "".join(f"{known[name]}  {name}\n" for name in sorted(known))
    replace_text(folder / CHECKSUMS, text, access)
