"""Writes the files of a report in place of those of an earlier one."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.files import read_text
from vrcomfort.json_text import parse_json
from vrcomfort.records.session_rows import QuestionnaireRow

RESULTS = "results.json"
_REMOVABLE = re.compile(r"tables/[a-z_]+\.csv|figures/[^/\\]+\.(svg|png|pdf)")
_NOT_IN_FILE_NAMES = str.maketrans(
    {sign: f"%{ord(sign):02X}" for sign in (*'/\\%:*?"<>|', *map(chr, range(32)), "\x7f")}
)
LONGEST_BYTES = 160
"""Of a file's name, in UTF-8; file systems end at 255, some archives earlier."""


def file_name(name: str) -> str:
    """Return a name as a file can have it: the conditions of a study may be called anything.

    One that is too long is cut, and told apart from others by the hash of the whole.
    """
    name = name.translate(_NOT_IN_FILE_NAMES)
    encoded = name.encode()
    if len(encoded) <= LONGEST_BYTES:
        return name
    digest = hashlib.sha256(encoded).hexdigest()[:12]
    return f"{encoded[: LONGEST_BYTES - 13].decode(errors='ignore')}-{digest}"


def write_report(out: Path, files: Mapping[str, str | bytes]) -> None:
    """Write a report; remove the tables and figures of the one before that this does not have.

    All texts are on the disk before the first file is removed or replaced, so a full disk or
    Ctrl-C leaves the earlier report as it was. results.json, which says what there is to remove,
    is replaced first: whenever the program is killed, it lists every file of a report in `out`.

    Parameters
    ----------
    files
        Path in `out` → text or bytes.

    Raises
    ------
    InputError
        If `out` cannot be written.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=".report-", dir=out) as folder:
            written = Path(folder)
            for name, text in files.items():
                _make_room(written / name)
                (written / name).write_bytes(text if isinstance(text, bytes) else text.encode())
            for name in _of_the_report_before(out) - files.keys():
                (out / name).unlink(missing_ok=True)
            for name in sorted(files, key=lambda name: name != RESULTS):
                _make_room(out / name)
                (written / name).replace(out / name)
    except OSError as error:
        raise InputError(f"cannot write the report: {error.strerror}", file=out) from error


def name_of_study(source: Path) -> str:
    """Return the name of a report's source: the study's folder, or the file of answers."""
    path = source.resolve()
    return path.parent.name if path.name == QuestionnaireRow.FILE else path.name


def refuse_another_study(out: Path, name: str) -> None:
    """Refuse a folder that holds the report of a study of another name.

    Raises
    ------
    InputError
        Names that study.
    """
    study = _report_before(out).get("study")
    before = study.get("source", name) if isinstance(study, dict) else name
    if before != name:
        message = f"holds the report of another study, {before}"
        raise InputError(f"{message}; choose another output folder, or replace it", file=out)


def _make_room(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)


def _of_the_report_before(out: Path) -> set[str]:
    """Return the tables and figures that results.json lists, if it is that of a report."""
    listed = _report_before(out).get("files")
    names = listed if isinstance(listed, list) else []
    return {name for name in names if isinstance(name, str) and _REMOVABLE.fullmatch(name)}


def _report_before(out: Path) -> dict[str, Any]:
    """Return results.json in a folder, if it is that of a report."""
    try:
        found: Any = parse_json(read_text(out / RESULTS, "report"), out / RESULTS)
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) and "software" in found else {}
