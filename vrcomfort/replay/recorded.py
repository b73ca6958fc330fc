"""Reads a recorded session for its replay: frames, exposures, conditions and hashes of images."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from vrcomfort.errors import InputError
from vrcomfort.geometry import Array, HiddenAreas, hidden_areas_of
from vrcomfort.protocol import Condition
from vrcomfort.protocol.viewing import Photodiode
from vrcomfort.records import (
    BallRow,
    DialRow,
    EventRow,
    FrameRow,
    ImageRow,
    RatingRow,
    Session,
    TaskRow,
    TrialRow,
)
from vrcomfort.records.frame_rows import CUT
from vrcomfort.records.recording import Memory
from vrcomfort.records.schema import SCHEMA_VERSION
from vrcomfort.records.tables import RecordedRow
from vrcomfort.scene.markers import Shown
from vrcomfort.settings import in_words
from vrcomfort.traces.trace import Trace, read_trace


@dataclass(frozen=True, eq=False)
class FrameFacts:
    """Columns of ``frames.csv`` that a trace does not have.

    Parameters
    ----------
    session_s, trial
        (n,) of each frame.
    drawn
        (n,) bool: the runtime wanted a picture.
    missed_refreshes
        (n,) refreshes that passed before each frame; -1 where only `dropped` says that some did.
    """

    session_s: Array
    trial: NDArray[np.int64]
    drawn: NDArray[np.bool_]
    missed_refreshes: NDArray[np.int64]


_FILLED = ("session_s", "trial", "should_render", "discontinuity", "dropped")
_MISSED = "missed_refreshes"


def read_frames(session: Session) -> tuple[Trace, FrameFacts]:
    """Return the trace, and the rest.

    Raises
    ------
    InputError
        If a column is missing, or a cell is not what its column holds.
    """
    file = session.folder / FrameRow.FILE
    trace = read_trace(file)
    there = session.header(FrameRow)
    for name in _FILLED:
        if name not in there:
            raise InputError("the column is missing", file=file, line=1, column=name)
    cells = session.recording().columns((*_FILLED, _MISSED), Memory())
    for name in _FILLED:
        for row in np.flatnonzero(~np.isfinite(cells[name]))[:1]:
            message = "this cell is empty; it needs a number"
            raise InputError(message, file=file, line=int(row) + 2, column=name)
    # Not as a trace has it: training goes over into the first exposure without a cut.
    cuts = cells["discontinuity"] == CUT
    cuts[0] = True
    counted = np.where(cells[_MISSED] >= 0, cells[_MISSED], -1)  # not where it is not recorded
    facts = FrameFacts(
        cells["session_s"],
        cells["trial"].astype(np.int64),
        cells["should_render"] != 0,
        np.where(cells["dropped"] > 0, counted, 0).astype(np.int64),
    )
    return replace(trace, cuts=cuts), facts


TRAINING = "training"
"""The event of it, before the first exposure."""
_EPSILON_S = 1e-6
"""Of session times in files."""


@dataclass(frozen=True)
class RecordedRating:
    """An answer in an exposure; `response` is None where none came in time."""

    onset_s: float
    answered_s: float
    instrument: str
    response: int | None


@dataclass(frozen=True)
class Turned:
    """A value of a setting of the condition, which a dial changed; drawn from then on."""

    since_s: float
    dial: str
    setting: str
    value: float


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
    turned
        What the participant adjusted, in order; the first is where the dial began.
    balls
        (`xr_time_ns`, ball) from which frame on each ball of its task is drawn so, in order.
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
    ratings: tuple[RecordedRating, ...] = ()
    balls: tuple[tuple[int, Shown], ...] = ()
    turned: tuple[Turned, ...] = ()


def read_exposures(
    session: Session, trace: Trace, frames: FrameFacts
) -> tuple[RecordedExposure, ...]:
    """Return the attempts of which a frame is recorded, in order.

    Raises
    ------
    InputError
        If a file of the session's is damaged.
    """
    return tuple(
        _exposures(
            _attempts(session.rows(TrialRow), session.manifest),
            trace.time_ns,
            frames,
            [_rating(row) for row in session.rows(RatingRow)],
            [_ball(row) for row in session.rows(BallRow)],
            [row for row in session.rows(DialRow) if row["setting"]],
            _trained_from_s(session),
        )
    )


def _attempts(
    trials: Iterable[RecordedRow], manifest: Mapping[str, Any]
) -> Iterator[Mapping[str, Any] | RecordedRow]:
    """Yield the rows of ``trials.csv``, and the known facts of an exposure that was cut short."""
    seen = set()
    for row in trials:
        seen.add((row["trial"], row["attempt"]))
        yield row
    begun = manifest.get("under_way")
    if begun and (begun["trial"], begun["attempt"]) not in seen:
        yield {**begun, "end_s": np.inf, "status": ""}


def _trained_from_s(session: Session) -> list[float]:
    """Return when each training began.

    Other frames that are no trial's (of practice, or of what is measured before a trial) are not
    shown again.
    """
    return [event["onset_s"] for event in session.rows(EventRow) if event["name"] == TRAINING]


def _exposures(
    attempts: Iterable[Mapping[str, Any] | RecordedRow],
    times_ns: NDArray[np.int64],
    frames: FrameFacts,
    ratings: Sequence[RecordedRating],
    balls: Sequence[tuple[int, Shown]],
    dials: Sequence[RecordedRow],
    trained_from_s: Sequence[float],
) -> Iterator[RecordedExposure]:
    """Yield the attempts of which a frame is recorded."""
    before_s = -np.inf
    for row in attempts:
        start_s, end_s = row["start_s"] - _EPSILON_S, row["end_s"] + _EPSILON_S
        inside = (frames.session_s >= start_s) & (frames.session_s <= end_s)
        rows = np.flatnonzero(inside & (frames.trial == row["trial"]))
        if len(rows):
            shown, end = int(rows[0]), int(rows[-1]) + 1
            began_s = [each for each in trained_from_s if before_s <= each <= row["start_s"]]
            since_s = min(began_s, default=np.inf) - _EPSILON_S
            trained = (frames.trial[:shown] == 0) & (frames.session_s[:shown] >= since_s)
            others = np.flatnonzero(~trained)
            first = int(others[-1]) + 1 if len(others) else 0
            told = tuple(each for each in ratings if start_s <= each.onset_s <= end_s)
            from_ns, to_ns = times_ns[shown], times_ns[end - 1]
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
                tuple(each for each in balls if from_ns <= each[0] <= to_ns),
                tuple(_turned(row, dials)),
            )
        before_s = row["end_s"] - _EPSILON_S


def _turned(
    attempt: Mapping[str, Any] | RecordedRow, dials: Sequence[RecordedRow]
) -> Iterator[Turned]:
    key = attempt["trial"], attempt["attempt"]
    for row in dials:
        if (row["trial"], row["attempt"]) == key and row["kind"] in {"start", "change"}:
            yield Turned(row["onset_s"], row["dial"], row["setting"], row["value"])


def _rating(row: RecordedRow) -> RecordedRating:
    answered_s = row["onset_s"] + (row["latency_s"] or 0.0)
    return RecordedRating(row["onset_s"], answered_s, row["instrument"], row["response"])


def _ball(row: RecordedRow) -> tuple[int, Shown]:
    return row["xr_time_ns"], Shown(*(row[name] for name in Shown._fields))


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
    hidden
        What the lens of each eye never showed: it was not drawn.
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
    hidden: HiddenAreas = (None, None)
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
    trace, frames = read_frames(session)
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
        _hidden(folder, manifest),
        (*_notes(folder, manifest), *trace.warnings),
    )


def _hidden(folder: Path, manifest: Mapping[str, Any]) -> HiddenAreas:
    """Return the session's visibility mask, which it was drawn with.

    Raises
    ------
    InputError
        If it is damaged.
    """
    try:
        return hidden_areas_of(manifest["headset"])
    except (ValueError, KeyError, TypeError) as error:
        message = "headset.visibility_mask is damaged; restore it from a copy"
        raise InputError(message, file=folder / "manifest.json") from error


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
