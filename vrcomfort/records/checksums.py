"""``checksums.sha256``: of a session its files at its end, of a study the files about all of it.

It has the form of the program ``sha256sum``, so ``sha256sum --check checksums.sha256`` reads it.
Lines that begin with # are comments to that program. The first is the checksum of the lines after
it; of a study's files others are those of each column or key, so that a change can be named, and of
a session those of Parquet files, which may be removed.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from vrcomfort.errors import InputError
from vrcomfort.escaping import escape_unprintable
from vrcomfort.files import read_text, sha256_of
from vrcomfort.json_text import parse_json
from vrcomfort.records.disk import Access, replace_text

CHECKSUMS = "checksums.sha256"
_LINE = re.compile(r"([0-9a-f]{64})  ([^/\\]+)")
_COMMENT = re.compile(r"# ([0-9a-f]{64})  (.+)")
_BELOW = "the lines below"
_PART = ": "
"""Between the name of a file and that of a column or key."""


class Checksum(NamedTuple):
    """The SHA-256 of a file, and the 1-based line that says it.

    Parameters
    ----------
    old_sha256
        Of the text before, while a program replaces the file; else blank.
    """

    sha256: str
    line: int
    old_sha256: str = ""

    def fits(self, sha256: str) -> bool:
        """Return whether a file is as it was written."""
        return sha256 in {self.sha256, self.old_sha256}


def write_checksums(folder: Path, access: Access) -> None:
    """Write the checksums of a session's files after its end.

    Parquet files are left out: `vrcomfort pack` enters those that it makes.

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


def replace_listed(file: Path, text: str, access: Access) -> None:
    """Replace a file of a study's folder, and its checksums.

    Whenever the program is killed, one of those on the list is that of the file. A list that is
    damaged stays as it is.

    Raises
    ------
    InputError
        If the disk refuses; the old file stays.
    """
    folder, name = file.parent, file.name
    try:
        known = read_checksums(folder) if (folder / CHECKSUMS).exists() else {}
    except InputError:  # which `vrcomfort verify` tells
        replace_text(file, text, access)
        return
    others = {
        each: known[each].sha256 for each in known if each.partition(_PART)[0] != name
    } | checksums_of(name, text)
    if name in known:
        _write(folder, others, access, being_replaced={name: known[name].sha256})
    replace_text(file, text, access)
    _write(folder, others, access)


def checksums_of(name: str, text: str) -> dict[str, str]:
    """Return the checksums of a text as a file of a name, and of its columns or keys."""
    read = _EDITED.get(name)
    parts = read(text) if read else {}
    return {name: _sha256(text)} | {
        f"{name}{_PART}{escape_unprintable(part)}": _sha256(content)
        for part, content in parts.items()
    }


def _is_no_record(name: str) -> bool:
    """Return whether a line is a comment: of a column or key, or of a copy that can be removed."""
    return _PART in name or name.endswith(".parquet")


def listed_files(known: Iterable[str]) -> list[str]:
    """Return the names of files in a list, which has columns and keys as well."""
    return [name for name in known if _PART not in name]


def changed_parts(known: Mapping[str, Checksum], name: str, text: str) -> list[str]:
    """Return the columns or keys of a text that are others than the list has, or not there."""
    begin = f"{name}{_PART}"
    listed = {each: known[each].sha256 for each in known if each.startswith(begin)}
    now = {each: sha256 for each, sha256 in checksums_of(name, text).items() if each != name}
    changed = (each for each in {**listed, **now} if listed.get(each) != now.get(each))
    return [each.removeprefix(begin) for each in changed]


def _columns(text: str) -> dict[str, str]:
    try:
        rows = list(csv.reader(io.StringIO(text, newline="")))
    except csv.Error:
        return {}
    header = rows[0] if rows else []
    return {
        name: json.dumps([row[at : at + 1] for row in rows[1:]]) for at, name in enumerate(header)
    }


def _keys(text: str) -> dict[str, str]:
    try:
        content = parse_json(text, Path("dataset_description.json"))
    except ValueError:
        return {}
    if not isinstance(content, dict):
        return {}
    return {name: json.dumps(value) for name, value in content.items()}


_EDITED: Mapping[str, Callable[[str], dict[str, str]]] = {
    "participants.csv": _columns,
    "dataset_description.json": _keys,
}
"""Files that labs edit."""


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode(errors="replace")).hexdigest()


def read_checksums(folder: Path) -> dict[str, Checksum]:
    """Return file name → checksum; of a study also ``participants.csv: status`` → checksum.

    Raises
    ------
    InputError
        If a line is none, or the list is another than was written.
    """
    file = folder / CHECKSUMS
    found: dict[str, Checksum] = {}
    text = read_text(file, "list of checksums")
    lines = text.removesuffix("\n").split("\n")
    for number, line in enumerate(lines, start=1):
        parts = _LINE.fullmatch(line) or _COMMENT.fullmatch(line)
        if parts is None:
            message = "this is not a checksum and file name; restore the file from a copy"
            raise InputError(message, file=file, line=number)
        if parts[2] != _BELOW:
            old = found.get(parts[2])
            found[parts[2]] = Checksum(parts[1], number, old.sha256 if old else "")
        elif parts[1] != _sha256(text.partition("\n")[2]):
            message = "this list is not as it was written; restore it from a copy"
            raise InputError(message, file=file)
    return found


def _write(
    folder: Path,
    known: Mapping[str, str],
    access: Access,
    being_replaced: Mapping[str, str] | None = None,
) -> None:
    lines = [f"{sha256}  {name}\n" for name, sha256 in (being_replaced or {}).items()]
    lines += [
        f"{'# ' if _is_no_record(name) else ''}{known[name]}  {name}\n" for name in sorted(known)
    ]
    text = "".join(lines)
    replace_text(folder / CHECKSUMS, f"# {_sha256(text)}  {_BELOW}\n{text}", access)
