"""Takes up the files of a session that was interrupted, so that they can be continued."""

from __future__ import annotations

import csv
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import plain_digits
from vrcomfort.errors import InputError
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.manifest import read_manifest
from vrcomfort.records.mend import mend
from vrcomfort.records.recorder import OPTIONAL_ROWS, SESSION_ROWS, csv_line, refused
from vrcomfort.records.rows import (
    EventRow,
    QuestionnaireRow,
    RatingRow,
    Row,
    TrialRow,
    cell_text,
)
from vrcomfort.records.withdrawal import ENDED_THE_STUDY, undone_trials

Cells = Mapping[str, str]


@dataclass(frozen=True)
class Interrupted:
    """An interrupted session, as far as it came.

    Parameters
    ----------
    done
        Exposures that need not be shown again: up to the last one that was completed.
    attempts
        trial → how often it was begun.
    session_s, xr_time_ns
        The last times on record (no frame: None).
    manifest
        What the manifest says.
    warnings
        What was half-written and has been cut off, one sentence each.
    answered
        (trial or None, timepoint, instrument) → names of the items that have a row.
    last_trial
        The trial that ended last, if it was not aborted; else None.
    ended_by
        What ended the participant's study in that trial: ``withdrawn`` or ``stopped``; else None.
    exposure_ended_s_ago
        How long ago that trial ended, by the wall clock; None where nothing tells.
    """

    done: int
    attempts: Mapping[int, int]
    session_s: float
    xr_time_ns: int | None
    manifest: Mapping[str, Any] = field(repr=False)
    warnings: tuple[str, ...]
    answered: Mapping[tuple[int | None, str, str], frozenset[str]] = field(default_factory=dict)
    last_trial: int | None = None
    ended_by: str | None = None
    exposure_ended_s_ago: float | None = None


def take_up(folder: Path) -> Interrupted:
    """Mend the files of an interrupted session and return how far it came.

    A half-written last row goes to a file beside (``frames.csv.cut``). An exposure that was under
    way when the program was killed gets its row in ``trials.csv`` (abort code "killed").

    Raises
    ------
    InputError
        If a file is damaged, or from a version with other columns.
    """
    manifest = read_manifest(folder)
    trials_written_s = _modified_s(folder / TrialRow.FILE)
    cuts = [mend(folder / row_type.FILE, row_type.columns()) for row_type in SESSION_ROWS]
    files = [(folder / row_type.FILE, row_type.columns()) for row_type in OPTIONAL_ROWS]
    cuts += [mend(file, columns) for file, columns in files if file.exists()]
    begun = manifest.get("under_way")
    frames = _Frames.read(folder, begun)
    end_s = max(_latest(folder), default=0.0)
    trials = list(_rows(folder, TrialRow))
    if begun and not any(_is_attempt(row, begun) for row in trials):
        trials.append(_killed(folder, begun, frames, end_s))
    last_trial, ended_by = _last_trial(trials, undone_trials(manifest))
    return Interrupted(
        done=max((int(row["trial"]) for row in trials if row["status"] == "completed"), default=0),
        attempts=Counter(int(row["trial"]) for row in trials),
        session_s=end_s,
        xr_time_ns=frames.last_ns,
        manifest=manifest,
        warnings=tuple(cut for cut in cuts if cut),
        answered=_answered(folder),
        last_trial=last_trial,
        ended_by=ended_by,
        exposure_ended_s_ago=_seconds_since(manifest, last_trial, trials_written_s),
    )


def _last_trial(
    trials: Sequence[Cells], undone: set[tuple[int, int]]
) -> tuple[int | None, str | None]:
    """Return the trial that ended last, and what ended the study in it.

    None for one that was aborted, or whose withdrawal was undone: it is shown again.
    """
    if trials and (int(trials[-1]["trial"]), int(trials[-1]["attempt"])) in undone:
        return None, None
    if not trials or trials[-1]["status"] not in {"completed", *ENDED_THE_STUDY}:
        return None, None
    status = trials[-1]["status"]
    return int(trials[-1]["trial"]), status if status in ENDED_THE_STUDY else None


def _answered(folder: Path) -> dict[tuple[int | None, str, str], frozenset[str]]:
    found: dict[tuple[int | None, str, str], set[str]] = {}
    for row in _rows(folder, QuestionnaireRow):
        trial = int(row["trial"]) if row["trial"] else None
        found.setdefault((trial, row["timepoint"], row["instrument"]), set()).add(row["item"])
    return {key: frozenset(items) for key, items in found.items()}


def _modified_s(file: Path) -> float | None:
    return file.stat().st_mtime if file.exists() else None


def _seconds_since(
    manifest: Mapping[str, Any], trial: int | None, written_s: float | None
) -> float | None:
    """Return how long ago a trial ended: by the manifest, or by when its row was written."""
    ended = manifest.get("exposure_ended") or {}
    if trial is not None and ended.get("trial") == trial:
        written_s = datetime.fromisoformat(ended["at"]).timestamp()
    return None if written_s is None else max(time.time() - written_s, 0.0)


_NUMBERS: Mapping[type[Row], Mapping[str, type[int | float]]] = {
    FrameRow: {"session_s": float, "xr_time_ns": int, "trial": int, "dropped": int},
    TrialRow: {"trial": int, "attempt": int, "end_s": float},
    QuestionnaireRow: {"answered_s": float},
    RatingRow: {"onset_s": float, "latency_s": float},
    EventRow: {"onset_s": float, "duration_s": float},
}


def _rows(folder: Path, row_type: type[Row]) -> Iterator[dict[str, str]]:
    """Yield the rows of a file whose numbers are numbers; a latency may be blank."""
    file = folder / row_type.FILE
    with file.open(encoding="utf-8-sig", newline="") as stream:
        reader = csv.DictReader(stream)
        for row in reader:
            for column, kind in _NUMBERS[row_type].items():
                if not _reads_as(kind, row[column] or ("0" if column == "latency_s" else "")):
                    message = f"{row[column]!r} is not a number; mend it first"
                    raise InputError(message, file=file, line=reader.line_num, column=column)
            yield row


def _reads_as(kind: type[int | float], cell: str) -> bool:
    try:
        kind(plain_digits(cell))
    except ValueError:
        return False
    return True


@dataclass
class _Frames:
    """The end of ``frames.csv``, and the frames of the exposure that was under way."""

    last_ns: int | None = None
    shown: int = 0
    dropped: int = 0

    @classmethod
    def read(cls, folder: Path, begun: Mapping[str, Any] | None) -> _Frames:
        found, row = cls(), None
        for row in _rows(folder, FrameRow):
            if begun and _is_of(row, begun):
                found.shown += 1
                found.dropped += int(row["dropped"])
        found.last_ns = int(row["xr_time_ns"]) if row else None
        return found


def _is_of(frame: Cells, begun: Mapping[str, Any]) -> bool:
    return bool(
        int(frame["trial"]) == begun["trial"] and float(frame["session_s"]) >= begun["start_s"]
    )


def _is_attempt(row: Cells, begun: Mapping[str, Any]) -> bool:
    return bool(int(row["trial"]) == begun["trial"] and int(row["attempt"]) == begun["attempt"])


def _latest(folder: Path) -> Iterable[float]:
    """Yield the last time of each file."""
    ends: dict[type[Row], Callable[[Cells], float]] = {
        FrameRow: lambda row: float(row["session_s"]),
        TrialRow: lambda row: float(row["end_s"]),
        QuestionnaireRow: lambda row: float(row["answered_s"]),
        RatingRow: lambda row: float(row["onset_s"]) + float(row["latency_s"] or 0),
        EventRow: lambda row: float(row["onset_s"]) + float(row["duration_s"]),
    }
    for row_type, end_s in ends.items():
        yield max(map(end_s, _rows(folder, row_type)), default=0.0)


def _killed(
    folder: Path, begun: Mapping[str, Any], frames: _Frames, end_s: float
) -> dict[str, str]:
    """Write the row of an exposure that a killed program could not write."""
    row = TrialRow(
        **begun,
        end_s=end_s,
        status="aborted",
        abort_code="killed",
        frames=frames.shown,
        dropped=frames.dropped,
    )
    cells = [cell_text(cell) for cell in row.cells()]
    try:
        with (folder / TrialRow.FILE).open("a", encoding="utf-8", newline="") as stream:
            stream.write(csv_line(cells))
    except OSError as error:
        raise refused(folder / TrialRow.FILE, error) from error
    return dict(zip(TrialRow.columns(), cells, strict=True))
