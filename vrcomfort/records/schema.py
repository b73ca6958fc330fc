"""The version of what a study folder holds, and what each version added."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.records.frame_rows import EYE_GAZES
from vrcomfort.records.pose_columns import HANDS

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
"""What each version has and the one before has not: a new column is declared here, in a new
version. Older studies stay whole without it. A folder of an older version that is continued gets
them, blank: what they say was not recorded."""

SCHEMA_VERSION = max(ADDED_COLUMNS)
"""Written into manifests and study descriptions. What has none is of version 1."""


def columns_of_version(version: int, file_name: str, columns: tuple[str, ...]) -> tuple[str, ...]:
    """Return those of a file's present `columns` that it had in an older version."""
    later = later_columns(version, [file_name]).get(file_name, [])
    return tuple(column for column in columns if column not in later)


def later_columns(version: int, files: Iterable[str]) -> dict[str, list[str]]:
    """Return file → the columns that it got after a version, of files that got any."""
    later: dict[str, list[str]] = {name: [] for name in files}
    for added, columns_of in ADDED_COLUMNS.items():
        for name, columns in columns_of.items():
            if added > version and name in later:
                later[name] += columns
    return {name: columns for name, columns in later.items() if columns}


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
