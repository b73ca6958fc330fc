"""Reads a study into which a session is being recorded as it was at one moment."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vrcomfort.records.interruptions import WRITTEN_IN_ORDER
from vrcomfort.records.manifest import read_manifest

MOST_LOOKS = 3
"""What is wrong is looked at so often, where a program writes meanwhile."""
_MOST_TRIES = 20


def read_moment(folder: Path) -> tuple[dict[str, Any], Mapping[str, int] | None]:
    """Return a session's manifest and, while it is running, how much of each file is of one moment.

    A row is written after those that it relies on. So the sizes are taken from the last file to the
    first: whatever a row refers to is there. They count where the manifest did not change.

    Raises
    ------
    InputError
        If the manifest is damaged.
    """
    manifest = read_manifest(folder)
    ends: dict[str, int] = {}
    for _ in range(_MOST_TRIES):
        if manifest["status"] != "running":
            return manifest, None
        files = [folder / name for name in reversed(WRITTEN_IN_ORDER)]
        ends = {each.name: each.stat().st_size for each in files if each.exists()}
        before, manifest = manifest, read_manifest(folder)
        if manifest == before:
            break
    return manifest, ends


def state_of(folder: Path) -> set[tuple[str, int, int]]:
    """Return name, number and size of each file of a session."""
    try:
        return {(f.name, f.lstat().st_ino, f.lstat().st_size) for f in folder.iterdir()}
    except OSError:
        return set()
