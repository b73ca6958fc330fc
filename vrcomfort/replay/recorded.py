"""Reads a recorded session for its replay: frames, exposures, conditions, ratings and hashes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.geometry import Array
from vrcomfort.protocol import Condition
from vrcomfort.protocol.photodiode import Photodiode
from vrcomfort.records import (
    EventRow,
    FrameRow,
    ImageRow,
    RatingRow,
    TaskRow,
    TrialRow,
    read_manifest,
)
from vrcomfort.records.frame_rows import CUT
from vrcomfort.records.recorded_rows import RecordedRow, read_rows
from vrcomfort.records.schema import SCHEMA_VERSION, check_schema_version
from vrcomfort.settings import in_words
from vrcomfort.traces.table import Table, read_parts
from vrcomfort.traces.trace import Trace, read_trace

VALIDATION = "gaze_validation"
"""The event of a validation of the eye tracker."""
_EPSILON_S = 1e-6
"""Of session times in files."""


@dataclass(frozen=True)
class Rating:
    """An answer in an exposure; `response` is None where none came in time."""

    onset_s: float
    answered_s: float
    instrument: str
    response: int | None


@dataclass(frozen=True)
class RecordedExposure:
    """One attempt at a trial, with the training before it.

    Parameters
    ----------
    status
        As in ``trials.csv``; blank where the program was killed in it.
    first, shown, end
        Rows of the session's frames: from the first (of the training, if there is one), from the
        first of the exposure itself, to the one after the last.
    start_s, end_s
        Of the session's clock.
    ratings
        In the order of their questions.
    """

    trial: int
    attempt: int
    condition: str
    scene: str
    status: str
    first: int
    shown: int
    end: int
    start_s: float
    end_s: float
    ratings: tuple[Rating, ...] = ()


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
    hashes
        `xr_time_ns` → hashes of the left and the right image.
    notes
        What is not known of this session, a sentence each.
    """

    folder: Path
    manifest: Mapping[str, Any]
    conditions: Mapping[str, Condition]
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
    def photodiode(self) -> Photodiode | None:
        """Return the patch that was shown."""
        settings = self.manifest.get("settings", {}).get("photodiode")
        return None if settings is None else Photodiode.model_validate(settings)

    def scene(self, name: str) -> str:
        """Return the scene that a trial's `scene` means: the one of a view, or itself."""
        views = self.manifest.get("settings", {}).get("views", ())
        return str(next((each["scene"] for each in views if each["name"] == name), name))

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
    manifest = read_manifest(folder)
    check_schema_version(manifest, folder / "manifest.json")
    frames = _Frames.read(folder / FrameRow.FILE)
    trace = replace(read_trace(folder / FrameRow.FILE), cuts=frames.cuts)
    attempts = list(_attempts(folder, manifest))
    ratings = [*_ratings(folder)]
    exposures = tuple(_exposures(attempts, frames, ratings, _validated_until_s(folder)))
    if not exposures:
        raise InputError("no frame of an exposure is recorded here", file=folder)
    return RecordedSession(
        folder,
        manifest,
        _conditions(folder, manifest),
        trace,
        frames.session_s,
        frames.drawn,
        frames.missed_refreshes,
        exposures,
        _hashes(folder),
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


@dataclass(frozen=True, eq=False)
class _Frames:
    """What a trace does not keep of ``frames.csv``."""

    session_s: Array
    trial: NDArray[np.int64]
    drawn: NDArray[np.bool_]
    cuts: NDArray[np.bool_]
    missed_refreshes: NDArray[np.int64]

    @classmethod
    def read(cls, file: Path) -> _Frames:
        parts = list(read_parts(file, _require_columns))
        joined = [np.concatenate(column) for column in zip(*map(_columns, parts), strict=True)]
        frames = cls(*joined)
        frames.cuts[0] = True
        return frames


def _require_columns(table: Table) -> None:
    table.require(["session_s", "trial", "should_render", "discontinuity", "dropped"])


def _columns(table: Table) -> tuple[Any, ...]:
    dropped = table.integers("dropped")
    if table.has(["missed_refreshes"]):
        cells = table.text("missed_refreshes")
        known = [int(cell) if cell.strip().isdecimal() else -1 for cell in cells]
        missed = np.where(dropped > 0, np.array(known, dtype=np.int64), 0)
    else:
        missed = np.where(dropped > 0, -1, 0)
    return (
        table.floats(["session_s"])[:, 0],
        table.integers("trial"),
        table.integers("should_render") != 0,
        # Not as a trace has it: training goes over into the first exposure without a cut.
        table.integers("discontinuity") == CUT,
        missed,
    )


def _attempts(folder: Path, manifest: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Yield the rows of ``trials.csv``, and what is known of an exposure that was cut short."""
    table = CsvTable.read(folder / TrialRow.FILE, appended=True)
    table.require(["trial", "attempt", "condition", "scene", "start_s", "end_s", "status"])
    seen = set()
    for row in table.dicts():
        try:
            known = {
                **row,
                "trial": int(row["trial"]),
                "attempt": int(row["attempt"]),
                "start_s": float(row["start_s"]),
                "end_s": float(row["end_s"]),
            }
        except ValueError as error:
            message = f"a trial's numbers cannot be read ({error}); `vrcomfort verify` says where"
            raise InputError(message, file=folder / TrialRow.FILE) from error
        seen.add((known["trial"], known["attempt"]))
        yield known
    begun = manifest.get("under_way")
    if begun and (begun["trial"], begun["attempt"]) not in seen:
        yield {**begun, "end_s": np.inf, "status": ""}


def _validated_until_s(folder: Path) -> list[float]:
    """Return when each validation of the eye tracker ended: its frames are of no exposure."""
    if not (folder / EventRow.FILE).exists():
        return []
    return [
        row["onset_s"] + row["duration_s"]
        for row in _rows(folder, EventRow)
        if row["name"] == VALIDATION
    ]


def _exposures(
    attempts: Sequence[Mapping[str, Any]],
    frames: _Frames,
    ratings: Sequence[Rating],
    validated_until_s: Sequence[float],
) -> Iterator[RecordedExposure]:
    """Yield the attempts of which a frame is recorded."""
    before_s = -np.inf
    for row in attempts:
        start_s, end_s = row["start_s"] - _EPSILON_S, row["end_s"] + _EPSILON_S
        inside = (frames.session_s >= start_s) & (frames.session_s <= end_s)
        rows = np.flatnonzero(inside & (frames.trial == row["trial"]))
        if len(rows):
            shown, end = int(rows[0]), int(rows[-1]) + 1
            ends_s = [each - _EPSILON_S for each in validated_until_s if each <= row["start_s"]]
            before_s = max([before_s, *ends_s])
            trained = (frames.trial[:shown] == 0) & (frames.session_s[:shown] >= before_s)
            others = np.flatnonzero(~trained)
            first = int(others[-1]) + 1 if len(others) else 0
            told = tuple(each for each in ratings if start_s <= each.onset_s <= end_s)
            yield RecordedExposure(
                row["trial"],
                row["attempt"],
                row["condition"],
                row["scene"],
                row["status"],
                first,
                shown,
                end,
                row["start_s"],
                min(row["end_s"], float(frames.session_s[end - 1])),
                told,
            )
        before_s = row["end_s"] - _EPSILON_S


def _ratings(folder: Path) -> Iterator[Rating]:
    file = folder / RatingRow.FILE
    if not file.exists():
        return
    for row in _rows(folder, RatingRow):
        late_s = row["latency_s"]
        answered_s = row["onset_s"] + (late_s or 0.0)
        yield Rating(row["onset_s"], answered_s, row["instrument"], row["response"])


def _hashes(folder: Path) -> dict[int, tuple[str, str]]:
    if not (folder / ImageRow.FILE).exists():
        return {}
    rows = _rows(folder, ImageRow)
    return {row["xr_time_ns"]: (row["left_hash"], row["right_hash"]) for row in rows}


def _rows(folder: Path, row_type: Any) -> Iterator[RecordedRow]:
    """Yield the rows of a file but for a half-written last one."""
    try:
        yield from read_rows(folder, row_type)
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        return  # the last row of a program that was killed


def _conditions(folder: Path, manifest: Mapping[str, Any]) -> dict[str, Condition]:
    """Return name → condition as the session had it, with all settings."""
    file = folder / "manifest.json"
    found = {}
    for settings in manifest.get("settings", {}).get("conditions", ()):
        try:
            condition = Condition.model_validate(settings)
        except ValidationError as error:
            made_with = manifest.get("versions", {}).get("vrcomfort", "an older version")
            message = f"condition {settings.get('name')!r} has settings that this version does not"
            message = f"{message} know ({in_words(error.errors()[0])}); replay the session with the"
            raise InputError(f"{message} vrcomfort that ran it: {made_with}", file=file) from error
        found[condition.name] = condition
    if not found:
        raise InputError("the manifest has no conditions; restore it from a copy", file=file)
    return found


def _notes(folder: Path, manifest: Mapping[str, Any]) -> Iterator[str]:
    version = manifest.get("schema_version", 1)
    if version < SCHEMA_VERSION:
        yield (
            f"{folder}: recorded in schema version {version} (now {SCHEMA_VERSION}): what later "
            "versions record besides is not known of it"
        )
    if lost := manifest.get("frames_not_recorded", 0):
        yield f"{folder}: {lost} frames that were shown have no row; they cannot be shown again"
    if (folder / TaskRow.FILE).exists():
        yield f"{folder}: balls of tasks are not drawn again; images with them are not as recorded"
    if not (folder / ImageRow.FILE).exists():
        yield f"{folder}: no images were hashed; whether they are the same cannot be told"
