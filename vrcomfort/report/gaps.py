"""Missing and unreadable files of a study folder."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence
    from pathlib import Path

    from vrcomfort.records.choice import SessionName
    from vrcomfort.records.json_file import DescribedShape, ManifestShape

_RESTORE = "restore it from a copy"


def unreadable(source: Path) -> list[str]:
    """Say which folders of a study cannot be read; their files would be passed over in silence.

    Raises
    ------
    InputError
        If none can, as the whole cannot be read.
    """
    refused: list[OSError] = []
    for _ in os.walk(source, onerror=refused.append):
        pass
    found = []
    for error in refused:
        folder = str(error.filename)
        message = f"cannot be read: {error.strerror}"
        if folder == str(source):
            raise InputError(f"{message}; ask for access, or choose another folder", file=source)
        name = folder.removeprefix(f"{source}/")
        found.append(f"{name}: {message}; nothing in it is in this report")
    return found


def gaps(
    source: Path,
    description: DescribedShape | None,
    participants: Sequence[Mapping[str, str]],
    manifests: Sequence[ManifestShape],
    without: Collection[SessionName] = (),
) -> list[str]:
    """Name missing files of a study that vrcomfort recorded; of other folders, none.

    Parameters
    ----------
    description
        That of dataset_description.json; None where there is none, or a damaged one.
    manifests
        Those that are used.
    without
        Sessions that are left out on request, of which nothing is missing.
    """
    if not manifests and (description is None or "seed" not in description.model_fields_set):
        return []
    sessions = sorted(each for each in source.glob("sub-*/ses-*") if each.is_dir())
    if not sessions:
        return []
    found = []
    if description is None or not description.model_fields_set:
        message = "conditions are called as in the protocol"
        found.append(f"dataset_description.json is missing or not used: {message}; {_RESTORE}")
    if not participants:
        message = "withdrawals and exclusions are unknown"
        found.append(f"participants.csv is missing or empty: {message}; {_RESTORE}")
    left_out = {each.folder(source) for each in without}
    used = {f"sub-{each.participant}/ses-{each.session}" for each in manifests}
    for folder in sessions:
        name = folder.relative_to(source).as_posix()
        if (
            folder not in left_out
            and name not in used
            and not _is_unreadable(folder / "manifest.json")
        ):
            message = "whether its participant was simulated is not known, and taken for no"
            found.append(f"{name}/manifest.json is missing or not used: {message}; {_RESTORE}")
    begun = {folder.parent.name.removeprefix("sub-") for folder in sessions}
    found += [
        f"participants.csv: {each['participant']} is completed, and has no session here; restore "
        "the folder"
        for each in participants
        if each.get("status") == "completed" and each["participant"] not in begun
    ]
    return found


def _is_unreadable(file: Path) -> bool:
    """Return whether a file's folder cannot be read, which `unreadable` tells."""
    try:
        file.is_file()
    except OSError:
        return True
    return False
