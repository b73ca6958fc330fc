"""Repairs the files of an interrupted session, and returns its progress."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

from vrcomfort.errors import InputError
from vrcomfort.files import open_file, read_text
from vrcomfort.protocol import Trial
from vrcomfort.records.appended_file import AppendedFile
from vrcomfort.records.attempts import FramesOfAttempts
from vrcomfort.records.checksums import remove_checksums
from vrcomfort.records.disk import (
    OWNER,
    Access,
    open_new,
    refuse_links,
    refused,
    replace_text,
    sync_folder,
)
from vrcomfort.records.exposure_rows import OVER, PracticeRow, TrialRow
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.interruptions import KEPT, OF_FRAMES
from vrcomfort.records.json_file import damaged
from vrcomfort.records.reader import Session
from vrcomfort.records.rows import Row, csv_line
from vrcomfort.records.schema import OPTIONAL_ROWS, SCHEMA_VERSION, SESSION_ROWS, columns_of_version
from vrcomfort.records.session_rows import QuestionnaireRow
from vrcomfort.records.tables import RecordedRow, split_line, text_rows


def repair_table(folder: Path, row_type: type[Row], access: Access) -> str | None:
    """Leave the whole rows in a file, or a header where there is not even that.

    The half-written last row of a file (NUL bytes, after a power cut) is moved to the end of a
    file beside it, whose name has ``.cut`` appended. A file of an older schema gets the columns
    that it lacks, blank; it stays as it was beside, with ``.schema1`` (its version) appended.

    Returns
    -------
    str or None
        What was cut off, in one sentence.

    Raises
    ------
    InputError
        If the header is another, a row before the last is broken, the file is a symbolic link, or
        the disk refuses.
    """
    file, columns = folder / row_type.FILE, row_type.columns()
    try:
        refuse_links(folder, file)
        if not file.exists() or not file.stat().st_size:
            _begin(file, columns, access)
            return None
        written = file.stat()
        cut = _repaired(file, columns, access)
        os.utime(file, ns=(written.st_atime_ns, written.st_mtime_ns))  # when its last row came
    except OSError as error:
        raise refused(file, error) from error
    return cut


def _begin(file: Path, columns: tuple[str, ...], access: Access) -> None:
    again = AppendedFile(file, access, fresh=True, header=csv_line(columns))
    try:
        again.sync()
        sync_folder(file.parent)
    finally:
        again.close()


def _repaired(file: Path, columns: tuple[str, ...], access: Access) -> str | None:
    version, there = _schema_of(file, columns)
    whole, lines = _whole_rows(file, there)
    cut = _cut(file, whole, lines, there, access) if whole < file.stat().st_size else None
    if there != columns:
        _add_columns(file, columns, access, kept=f"{file.name}.schema{version}")
    return cut


def _schema_of(file: Path, columns: tuple[str, ...]) -> tuple[int, tuple[str, ...]]:
    """Return the newest schema version with the columns of a file's header, and these columns."""
    with open_file(file) as stream:
        header = stream.readline()
    for version in range(SCHEMA_VERSION, 0, -1):
        older = columns_of_version(version, file.name, columns)
        if header == csv_line(older).encode():
            return version, older
    return SCHEMA_VERSION, columns


def _add_columns(file: Path, columns: tuple[str, ...], access: Access, *, kept: str) -> None:
    """Put blank cells where a file is without a column; as it was, it is called `kept`."""
    lines = [csv_line(row.get(column, "") for column in columns) for row in text_rows(file)]
    beside = file.with_name(kept)
    beside.unlink(missing_ok=True)
    try:
        beside.hardlink_to(file)
    except OSError:  # a file system without links
        shutil.copyfile(file, beside)
    replace_text(file, csv_line(columns) + "".join(lines), access)


def _whole_rows(file: Path, columns: tuple[str, ...]) -> tuple[int, int]:
    """Return how many bytes and lines are whole; at most one line is not."""
    whole = lines = 0
    broken = False
    with open_file(file) as stream:
        for line in stream:
            if broken:
                raise InputError("this row is damaged; repair it first", file=file, line=lines + 1)
            cells = _cells(line)
            broken = cells is None or (lines > 0 and len(cells) != len(columns))
            if not broken and not lines and cells != list(columns):
                message = "this file has other columns: it is from another version of vrcomfort"
                raise InputError(f"{message}; resume the session with that one", file=file, line=1)
            whole += 0 if broken else len(line)
            lines += not broken
    return whole, lines


def _cells(line: bytes) -> list[str] | None:
    """Return the cells of a whole line."""
    if not line.endswith(b"\n"):
        return None
    try:
        return split_line(line)
    except ValueError:
        return None


def _cut(file: Path, whole: int, lines: int, columns: tuple[str, ...], access: Access) -> str:
    beside = file.with_name(f"{file.name}.cut")
    with (
        file.open("r+b") as stream,
        os.fdopen(open_new(beside, access, os.O_WRONLY | os.O_APPEND), "ab") as rest,
    ):
        stream.seek(whole)
        rest.write(stream.read().rstrip(b"\n") + b"\n")
        rest.flush()
        os.fsync(rest.fileno())  # first: it must be somewhere
        sync_folder(file.parent)
        stream.seek(whole)
        stream.truncate()
        stream.write(b"" if lines else csv_line(columns).encode())
        stream.flush()
        os.fsync(stream.fileno())
    return f"{file}, line {lines + 1}: a half-written row was moved to {beside.name}"


ENDED_THE_STUDY = ("withdrawn", "stopped")
"""Statuses of the trial in which a participant's study ended."""
_DECIMALS = 9
"""Of times on record; a sum of two may have more."""
_TRIAL_STATUS = ("completed", "withdrawn", "stopped", "aborted", "skipped")


class Practised(NamedTuple):
    """How far a block of practice came in a session."""

    begun: int
    """Number of the last repetition on record."""
    whole: int
    """How many of them were shown to their ends."""
    over: bool
    """Whether it is not to be shown again."""


@dataclass(frozen=True)
class Interrupted:
    """An interrupted session, as far as it came.

    Parameters
    ----------
    done
        Exposures that need not be shown again: up to the last one that was completed or skipped.
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
        The trial that ended last, if it was not aborted or skipped; else None.
    ended_by
        What ended the participant's study, or session, in that trial: ``withdrawn`` or ``stopped``;
        else None.
    ended_session
        Whether that was the session alone.
    exposure_ended_s_ago
        How long ago that trial ended, by the wall clock; None where nothing tells.
    practised
        Name of a block of practice → how far it came.
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
    ended_session: bool = False
    exposure_ended_s_ago: float | None = None
    practised: Mapping[str, Practised] = field(default_factory=dict)


def repair_session(folder: Path, planned: Sequence[Trial], access: Access = OWNER) -> Interrupted:
    """Mend the files of an interrupted session and return how far it came.

    A half-written last row goes to a file beside (``frames.csv.cut``). An exposure that was under
    way when the program was killed gets its row in ``trials.csv`` (abort code "killed").

    Parameters
    ----------
    planned
        The session's trials, in the participant's order.

    Raises
    ------
    InputError
        If a file is damaged, from a version with other columns, or tells of a trial that is not
        planned.
    """
    session = Session(folder)
    manifest = session.manifest
    trials_written_s = _modified_s(folder / TrialRow.FILE)
    begun = manifest.get("under_way")
    if begun:
        _check_begun(folder, begun, planned)
    remove_checksums(folder)
    there = [each for each in OPTIONAL_ROWS if (folder / each.FILE).exists()]
    cuts = [repair_table(folder, row_type, access) for row_type in (*SESSION_ROWS, *there)]
    whose = {"participant": manifest["participant"], "session": manifest["session"]}
    trials = list(_checked_trials(session, planned, whose))
    frames = _Frames.read(session, trials, begun)
    end_s = max(_ends(session, whose), default=0.0)
    end_s = round(max(end_s, frames.last_s), _DECIMALS)
    attempts: dict[int, int] = {}
    for row in trials:
        attempts[row["trial"]] = max(row["attempt"], attempts.get(row["trial"], 0))
    if begun and attempts.get(begun["trial"], 0) < begun["attempt"]:
        _write_killed(folder, begun, frames, end_s, planned[begun["trial"] - 1].part, access)
        attempts[begun["trial"]] = begun["attempt"]
    last_trial, ended_by, code = _last_trial(trials, begun, undone_trials(manifest))
    return Interrupted(
        done=max((row["trial"] for row in trials if row["status"] in OVER), default=0),
        attempts=attempts,
        session_s=end_s,
        xr_time_ns=frames.last_ns,
        manifest=manifest,
        warnings=tuple(cut for cut in cuts if cut),
        answered=_answered(session, whose),
        last_trial=last_trial,
        ended_by=ended_by,
        ended_session=(code or "").endswith("_session"),
        exposure_ended_s_ago=_seconds_since(manifest, last_trial, trials_written_s),
        practised=_practised(session, whose),
    )


def _last_trial(
    trials: Sequence[RecordedRow],
    begun: Mapping[str, Any] | None,
    undone: set[tuple[int, int]],
) -> tuple[int | None, str | None, str | None]:
    """Return the last trial that ended, the status with which it ended the study, and its code.

    None for one that was aborted, or whose withdrawal was undone (it is shown again), and for one
    that an operator has skipped (nothing is owed to it).
    """
    last = trials[-1] if trials else None
    if (
        last is None
        or last["status"] in {"aborted", "skipped"}
        or (last["trial"], last["attempt"]) in undone
    ):
        return None, None, None
    if begun and (begun["trial"], begun["attempt"]) != (last["trial"], last["attempt"]):
        return None, None, None  # the next exposure had begun: nothing was owed to this one
    status = last["status"]
    return last["trial"], status if status in ENDED_THE_STUDY else None, last["abort_code"]


def undone_trials(manifest: Mapping[str, Any]) -> set[tuple[int, int]]:
    """Return (trial, attempt) of exposures with an undone withdrawal."""
    undone: Iterable[Mapping[str, Any]] = manifest.get("withdrawals_undone") or ()
    return {(each["trial"], each["attempt"]) for each in undone if each.get("trial")}


def _answered(
    session: Session, whose: Mapping[str, Any]
) -> dict[tuple[int | None, str, str], frozenset[str]]:
    found: dict[tuple[int | None, str, str], set[str]] = {}
    for row in _of(whose, session.rows(QuestionnaireRow, repaired=True)):
        key = (row["trial"], row["timepoint"], row["instrument"])
        found.setdefault(key, set()).add(row["item"])
    return {key: frozenset(items) for key, items in found.items()}


def _practised(session: Session, whose: Mapping[str, Any]) -> dict[str, Practised]:
    """Return how far each block of practice came."""
    found: dict[str, Practised] = {}
    for row in _of(whose, session.rows(PracticeRow, repaired=True)):
        before = found.get(row["practice"], Practised(0, 0, over=False))
        begun = max(before.begun, row["repetition"])
        whole = before.whole + int(row["met"] is not None)
        found[row["practice"]] = Practised(begun, whole, before.over or row["over"] == 1)
    return found


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


def _check_begun(folder: Path, begun: Mapping[str, Any], planned: Sequence[Trial]) -> None:
    file = folder / "manifest.json"
    for column, fault in _unplanned(begun, planned):
        text, path = read_text(file, "manifest"), ("under_way", column)
        raise damaged(file, "manifest", f"`under_way.{column}`: {fault}", text=text, path=path)


def _unplanned(
    row: RecordedRow | Mapping[str, Any], planned: Sequence[Trial]
) -> Iterator[tuple[str, str]]:
    """Yield the differences between a trial's row and the participant's order."""
    number = row["trial"]
    if not 1 <= number <= len(planned):
        yield "trial", f"this participant's order has {len(planned)} trials, and no {number}"
        return
    trial = planned[number - 1]
    for column, there in (("condition", trial.condition), ("scene", trial.scene)):
        if row[column] != there:
            yield column, f"trial {number} is planned with {there!r}, not {row[column]!r}"


def _checked_trials(
    session: Session, planned: Sequence[Trial], whose: Mapping[str, Any]
) -> Iterator[RecordedRow]:
    """Yield the rows of trials that were planned, each attempt once and none skipped."""
    seen: set[tuple[int, int]] = set()
    done = 0
    for row in _of(whose, session.rows(TrialRow, repaired=True)):
        for column, fault in _unplanned(row, planned):
            raise row.fault(fault, column)
        attempt = row["trial"], row["attempt"]
        if attempt in seen or row["attempt"] < 1:
            raise row.fault(f"trial {attempt[0]}, attempt {attempt[1]} cannot be here", "attempt")
        if row["status"] not in _TRIAL_STATUS:
            raise row.fault(f"{row['status'][:40]!r} is no status of a trial", "status")
        if row["trial"] > done + 1:
            raise row.fault(f"trial {done + 1} was not completed before", "trial")
        seen.add(attempt)
        done = max(done, row["trial"] if row["status"] in OVER else 0)
        yield row


def _of(whose: Mapping[str, Any], rows: Iterator[RecordedRow]) -> Iterator[RecordedRow]:
    """Yield rows that are of this participant and session."""
    for row in rows:
        for column, this in whose.items():
            if row.values.get(column, this) != this:
                raise row.fault(f"this folder is of {column} {this}", column)
        yield row


@dataclass
class _Frames:
    """The end of ``frames.csv``, and the frames of the exposure that was under way."""

    last_ns: int | None = None
    last_s: float = 0.0
    shown: int = 0
    dropped: int = 0

    @classmethod
    def read(
        cls, session: Session, trials: Sequence[RecordedRow], begun: Mapping[str, Any] | None
    ) -> _Frames:
        found = cls()
        under_way = (begun["trial"], begun["attempt"]) if begun else None
        of_attempts = FramesOfAttempts([*trials, *([begun] if begun else [])])
        for row in session.rows(FrameRow, repaired=True):
            attempt = of_attempts.add(row)
            if attempt is not None and attempt == under_way:
                found.shown += 1
                found.dropped += row["dropped"]
            found._meet(row)
        for row_type in OF_FRAMES:  # a power cut may have left them without their frame
            for row in session.rows(row_type, repaired=True):
                found._meet(row)
        return found

    def _meet(self, row: RecordedRow) -> None:
        self.last_ns = max(row["xr_time_ns"], self.last_ns or row["xr_time_ns"])
        self.last_s = max(self.last_s, row["session_s"])


def _ends(session: Session, whose: Mapping[str, Any]) -> Iterator[float]:
    """Yield when each thing on record was over, but for frames."""
    for each in KEPT:
        if each.row_type not in (FrameRow, *OF_FRAMES):
            for row in _of(whose, session.rows(each.row_type, repaired=True)):
                yield sum(row[part] or 0.0 for part in each.over_s)


def _write_killed(
    folder: Path,
    begun: Mapping[str, Any],
    frames: _Frames,
    end_s: float,
    part: str | None,
    access: Access,
) -> None:
    """Write the row of an exposure that a killed program could not write."""
    row = TrialRow(
        **begun,
        end_s=end_s,
        status="aborted",
        abort_code="killed",
        frames=frames.shown,
        dropped=frames.dropped,
        part=part,
    )
    file = folder / TrialRow.FILE
    try:
        header = csv_line(TrialRow.columns())
        trials = AppendedFile(file, access, fresh=False, header=header)
    except OSError as error:
        raise refused(file, error) from error
    try:
        trials.append(csv_line(row.cells()))
        trials.sync()
    finally:
        trials.close()
