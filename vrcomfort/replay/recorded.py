"""Reads a recorded session for its replay: its exposures, its conditions, hashes of images."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from vrcomfort.errors import InputError
from vrcomfort.geometry import Array
from vrcomfort.protocol import Condition
from vrcomfort.protocol.viewing import Photodiode
from vrcomfort.records import (
    BallRow,
    FrameRow,
    ImageRow,
    Session,
    TaskRow,
    TrialRow,
)
from vrcomfort.records.schema import SCHEMA_VERSION
from vrcomfort.replay.exposures import RecordedExposure, read_exposures
from vrcomfort.replay.frame_facts import read_frames
from vrcomfort.settings import in_words
from vrcomfort.traces.trace import Trace


@dataclass(frozen=True, eq=False)
class RecordedSession:
    """A session that can be shown again.

    Parameters
    ----------
    trace
        Where the head, eyes, hands and gaze were in each frame.
    session_s
        (n,) of each frame.
    drawn
        (n,) bool: the runtime wanted a picture.
    missed_refreshes
        (n,) refreshes that passed before each frame; -1 where only `dropped` says that some did.
    photodiode
        The patch that was shown.
    hashes
        `xr_time_ns` → hashes of the left and the right image.
    notes
        What is not known of this session, a sentence each.
    """

    folder: Path
    manifest: Mapping[str, Any]
    conditions: Mapping[str, Condition]
    photodiode: Photodiode | None
    trace: Trace
    session_s: Array
    drawn: NDArray[np.bool_]
    missed_refreshes: NDArray[np.int64]
    exposures: tuple[RecordedExposure, ...]
    hashes: Mapping[int, tuple[str, str]]
    notes: tuple[str, ...] = ()

    @property
    def size_px(self) -> tuple[int, int]:
        """Return the size of one eye's image."""
        width, height = self.manifest["headset"]["image_size_px"]
        return int(width), int(height)

    @property
    def refresh_hz(self) -> float:
        """Return the display's rate; the most common one where it was not recorded."""
        return float(self.manifest["headset"].get("refresh_hz") or 72.0)

    def scene(self, name: str) -> str:
        """Return the scene that a trial's `scene` means: the one of a view, or itself."""
        views = self.manifest.get("settings", {}).get("views", ())
        return str(next((each["scene"] for each in views if each["name"] == name), name))

    def highest(self, dial: str) -> float:
        """Return the highest value of an adjustment: passes that can show it show all others.

        Raises
        ------
        InputError
            If the session's protocol has no such adjustment.
        """
        for each in self.manifest.get("settings", {}).get("adjustments", ()):
            if each["name"] == dial:
                return float(each["range"][1])
        message = f"the manifest has no adjustment {dial!r}, which dials.csv names"
        raise InputError(f"{message}; restore it from a copy", file=self.folder / "manifest.json")

    def condition(self, name: str) -> Condition:
        """Return a condition of the session's protocol.

        Raises
        ------
        InputError
            If it has no such condition.
        """
        if name not in self.conditions:
            known = ", ".join(self.conditions)
            raise InputError(f"this session's protocol has no condition {name!r}; it has: {known}")
        return self.conditions[name]


def read_session(folder: Path) -> RecordedSession:
    """Read a session's folder, such as ``STUDY/sub-P01/ses-1``.

    Raises
    ------
    InputError
        If it is no session's folder, holds no frames, a file is damaged, or its settings are not
        those of this version.
    """
    require_session(folder)
    session = Session(folder)
    manifest = session.manifest
    patch = manifest.get("settings", {}).get("photodiode")
    trace, frames = read_frames(folder / FrameRow.FILE)
    exposures = read_exposures(session, trace, frames)
    if not exposures:
        raise InputError("no frame of an exposure is recorded here", file=folder)
    if "image_size_px" not in manifest.get("headset", {}):
        message = "the manifest does not say the size of the images; restore it from a copy"
        raise InputError(message, file=folder / "manifest.json")
    return RecordedSession(
        folder,
        manifest,
        _conditions(folder, manifest),
        None if patch is None else _as_then(Photodiode, patch, "the patch", folder, manifest),
        trace,
        frames.session_s,
        frames.drawn,
        frames.missed_refreshes,
        exposures,
        _hashes(session),
        (*_notes(folder, manifest), *trace.warnings),
    )


def require_session(folder: Path) -> None:
    """Refuse a folder that is no session's, or has nothing that could be shown again.

    Raises
    ------
    InputError
        Says what is missing.
    """
    if not (folder / "manifest.json").is_file():
        sessions = sorted(folder.glob("sub-*/ses-*") if folder.is_dir() else ())
        sessions = sessions or sorted(folder.glob("ses-*"))
        hint = f"such as {sessions[0]}" if sessions else "such as STUDY/sub-P01/ses-1"
        raise InputError(f"is no session's folder; give one, {hint}", file=folder)
    for row_type in (FrameRow, TrialRow):
        if not (folder / row_type.FILE).is_file():
            message = f"{row_type.FILE} is missing, and without it nothing can be shown again"
            raise InputError(f"{message}; restore it from a copy", file=folder)


def _hashes(session: Session) -> dict[int, tuple[str, str]]:
    rows = session.rows(ImageRow)
    return {row["xr_time_ns"]: (row["left_hash"], row["right_hash"]) for row in rows}


def _conditions(folder: Path, manifest: Mapping[str, Any]) -> dict[str, Condition]:
    """Return name → condition as the session had it, with all settings."""
    found = {}
    for settings in manifest.get("settings", {}).get("conditions", ()):
        what = f"condition {settings['name']!r}"
        condition = _as_then(Condition, settings, what, folder, manifest)
        found[condition.name] = condition
    if not found:
        message = "the manifest has no conditions; restore it from a copy"
        raise InputError(message, file=folder / "manifest.json")
    return found


_Model = TypeVar("_Model", bound=BaseModel)


def _as_then(
    model: type[_Model],
    settings: Mapping[str, Any],
    what: str,
    folder: Path,
    manifest: Mapping[str, Any],
) -> _Model:
    """Return settings as the session had them.

    Raises
    ------
    InputError
        If this version does not know them.
    """
    try:
        return model.model_validate(settings)
    except ValidationError as error:
        made_with = manifest.get("versions", {}).get("vrcomfort", "an older version")
        message = f"{what} has settings that this version does not know"
        message = f"{message} ({in_words(error.errors()[0])}); replay the session with the"
        message = f"{message} vrcomfort that ran it: {made_with}"
        raise InputError(message, file=folder / "manifest.json") from error


def _notes(folder: Path, manifest: Mapping[str, Any]) -> Iterator[str]:
    version = manifest.get("schema_version", 1)
    if version < SCHEMA_VERSION:
        yield (
            f"{folder}: recorded in schema version {version} (now {SCHEMA_VERSION}): what later "
            "versions record besides is not known of it"
        )
    if lost := manifest.get("frames_not_recorded", 0):
        yield f"{folder}: {lost} frames that were shown have no row; they cannot be shown again"
    if (folder / TaskRow.FILE).exists() and not (folder / BallRow.FILE).exists():
        yield f"{folder}: there is no {BallRow.FILE}; balls that its tasks showed are not drawn"
    if not (folder / ImageRow.FILE).exists():
        yield f"{folder}: no images were hashed; whether they are the same cannot be told"
