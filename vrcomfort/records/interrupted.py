"""Takes up the files of a session that was interrupted, so that they can be continued."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import plain_digits
from vrcomfort.errors import InputError
from vrcomfort.records.disk import refused
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.manifest import read_manifest
from vrcomfort.records.mend import mend
from vrcomfort.records.row_files import OPTIONAL_ROWS, SESSION_ROWS
from vrcomfort.records.rows import (
    EventRow,
    QuestionnaireRow,
    RatingRow,
    Row,
    TrialRow,
    cell_text,
    csv_line,
)

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
    """

    done: int
    attempts: Mapping[int, int]
    session_s: float
    xr_time_ns: int | None
    manifest: Mapping[str, Any] = field(repr=False)
    warnings: tuple[str, ...]


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
    cuts = [mend(folder / row_type.FILE, row_type.columns()) for row_type in SESSION_ROWS]
    files = [(folder / row_type.FILE, row_type.columns()) for row_type in OPTIONAL_ROWS]
    cuts += [mend(file, columns) for file, columns in files if file.exists()]
    begun = manifest.get("under_way")
    frames = _Frames.read(folder, begun)
    end_s = max(_latest(folder), default=0.0)
    trials = list(_rows(folder, TrialRow))
    if begun and not any(_is_attempt(row, begun) for row in trials):
        trials.append(_killed(folder, begun, frames, end_s))
    return Interrupted(
        done=max((int(row["trial"]) for row in trials if row["status"] == "completed"), default=0),
        attempts=Counter(int(row["trial"]) for row in trials),
        session_s=end_s,
        xr_time_ns=frames.last_ns,
        manifest=manifest,
        warnings=tuple(cut for cut in cuts if cut),
    )


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
