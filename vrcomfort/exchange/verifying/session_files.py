"""The files of one session's folder: which are there, and whether they are as they were."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying.findings import Verified
from vrcomfort.records.checksums import CHECKSUMS, read_checksums, sha256_of
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.recording import Recording, parquet_of
from vrcomfort.records.schema import OPTIONAL_ROWS, SESSION_ROWS

_OWN = {*(each.FILE for each in (*SESSION_ROWS, *OPTIONAL_ROWS)), "manifest.json", CHECKSUMS}
_PACKED = {parquet_of(Path(each.FILE)).name for each in (FrameRow, GazeRow)}
_BESIDE = {
    "cut": "half-written rows that a resumed session moved aside; nothing to do",
    "replaced": "what another program had put in the place of the recorded file; look at it, and "
    "move it out of the study",
    "schema": "the file as it was before it got the columns of a newer version; nothing to do",
}


def check_files(folder: Path, found: Verified) -> None:
    """Find files that do not belong into a session's folder."""
    for each in sorted(folder.iterdir()):
        beside = each.suffix.lstrip(".").rstrip("0123456789")
        if each.is_symlink():
            found.fault(each, "is a symbolic link; put the file itself here")
        elif each.name in _OWN:
            continue
        elif each.name in _PACKED:
            _check_packed(each, found)
        elif beside in _BESIDE and each.stem in _OWN:
            found.note(each, _BESIDE[beside])
        elif each.name.startswith(".") and each.name.endswith(".new"):
            found.note(each, "a draft that a killed program left; remove it")
        else:
            found.fault(each, "is no file of a session; move it out of the study")


def _check_packed(file: Path, found: Verified) -> None:
    """Say so where a Parquet file is no longer read in the place of its CSV."""
    csv = file.with_suffix(".csv")
    if not csv.is_file():
        found.note(file, "its CSV is missing, and a Parquet file alone is no record")
    elif Recording.find(csv).note:
        found.note(file, "is not of its CSV as that is now, and not read; vrcomfort pack renews it")


def check_checksums(folder: Path, found: Verified, *, ended: bool) -> None:
    """Compare the files with what they were when the session ended.

    Parameters
    ----------
    ended
        Whether the session ended by itself, and so has checksums.
    """
    file = folder / CHECKSUMS
    if not file.exists():
        if ended:
            found.note(file, "is missing (older versions wrote none): changes cannot be seen")
        return
    try:
        known = read_checksums(folder)
    except InputError as error:
        found.refusal(error, file)
        return
    for name, checksum in known.items():
        each = folder / name
        if not each.is_file() or each.is_symlink():
            if name not in {row.FILE for row in SESSION_ROWS}:  # the others have been told
                found.fault(each, f"is missing, and {CHECKSUMS} has it; restore it from a copy")
        elif sha256_of(each) == checksum.sha256:
            found.counts["files as they were when their session ended"] += 1
        else:
            message = f"has changed since the session ended ({CHECKSUMS}, line {checksum.line})"
            found.fault(each, f"{message}; restore it from a copy, or write down why")
    for name in sorted(_OWN - known.keys() - {CHECKSUMS}):
        if (folder / name).exists():
            found.fault(folder / name, f"is not in {CHECKSUMS}: it came after the session's end")
