"""The version of what a study folder holds, and what each version added."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.records.frame_rows import EYE_GAZES
from vrcomfort.records.pose_columns import HANDS

SCHEMA_VERSION = 4
"""Written into manifests and study descriptions. What has none is of version 1."""

ADDED_COLUMNS: Mapping[int, Mapping[str, tuple[str, ...]]] = {
    2: {
        "trials.csv": ("missed_refreshes", "live_s", "frozen_s", "hidden_s", "unfocused_s"),
        "frames.csv": ("head_valid", "head_tracked", "session_state", "missed_refreshes"),
    },
    3: {"frames.csv": HANDS},
    4: {
        "gaze.csv": ("hit_node", "effect_centre", *EYE_GAZES),
        "trials.csv": ("part",),
        "questionnaires.csv": ("part",),
    },
}
"""What each version has and the one before has not. A folder of an older version that is continued
gets them, blank: what they say was not recorded."""


def columns_of_version(version: int, file_name: str, columns: tuple[str, ...]) -> tuple[str, ...]:
    """Return those of a file's present `columns` that it had in an older version."""
    later = {
        column
        for added, files in ADDED_COLUMNS.items()
        if added > version
        for column in files.get(file_name, ())
    }
    return tuple(column for column in columns if column not in later)


def check_schema_version(content: Mapping[str, Any], file: Path) -> None:
    """Refuse what a newer version of this program has written.

    Raises
    ------
    InputError
        If the version is newer.
    """
    version = content.get("schema_version", 1)
    if type(version) is int and version > SCHEMA_VERSION:
        message = f"this was written in schema version {version}, and this vrcomfort knows up to"
        raise InputError(f"{message} {SCHEMA_VERSION}; install a newer vrcomfort", file=file)
