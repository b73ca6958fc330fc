"""Verifies one session: its files, its manifest, its rows, and that all of them tell the same."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import whole_or_none
from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying.answers import (
    check_answers,
    check_decisions,
    check_places,
    check_practice,
    check_texts,
)
from vrcomfort.exchange.verifying.findings import Verified, note_version, read
from vrcomfort.exchange.verifying.frames import (
    Frames,
    check_clocks,
    check_counts,
    check_seen_time,
    check_times,
    cuts,
    read_frames,
)
from vrcomfort.exchange.verifying.moments import read_moment
from vrcomfort.files import sha256_of
from vrcomfort.protocol import Trial
from vrcomfort.records.attempts import before, within
from vrcomfort.records.checksums import CHECKSUMS, read_checksums
from vrcomfort.records.exposure_rows import (
    OVER,
    BallRow,
    DialRow,
    PracticeRow,
    RatingRow,
    TaskRow,
    TimingRow,
    TrialRow,
)
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.interruptions import OF_FRAMES, Interruption, interruptions
from vrcomfort.records.recorder import is_begun
from vrcomfort.records.recording import Recording, parquet_of
from vrcomfort.records.rows import Row
from vrcomfort.records.schema import OPTIONAL_ROWS, SESSION_ROWS
from vrcomfort.records.session_rows import (
    ClockRow,
    EventRow,
    QuestionnaireRow,
    ScreeningRow,
    TextRow,
)
from vrcomfort.records.tables import RecordedRow

_OWN = {*(each.FILE for each in (*SESSION_ROWS, *OPTIONAL_ROWS)), "manifest.json", CHECKSUMS}
_PACKED = {parquet_of(Path(each.FILE)).name for each in (FrameRow, GazeRow)}
_BESIDE = {
    "cut": "half-written rows that a resumed session moved aside; nothing to do",
    "replaced": "what another program had put in the place of the recorded file; look at it, and "
    "move it out of the study",
    "schema": "the file as it was before it got the columns of a newer version; nothing to do",
}


def check_files(folder: Path, found: Verified) -> None:
    """Find files that do not belong into a session's folder."""
    for each in sorted(folder.iterdir()):
        beside = each.suffix.lstrip(".").rstrip("0123456789")
        if each.is_symlink():
            found.fault(each, "is a symbolic link; put the file itself here")
        elif each.name in _OWN:
            continue
        elif each.name in _PACKED:
            _check_packed(each, found)
        elif beside in _BESIDE and each.stem in _OWN:
            found.note(each, _BESIDE[beside])
        elif is_draft(each):
            if each.exists():  # still: a program that goes on puts it in its place
                found.note(each, "a draft that a killed program left; remove it")
        else:
            found.fault(each, "is no file of a session; move it out of the study")


def is_draft(file: Path) -> bool:
    """Return whether a file is to take another's place as a whole."""
    return file.name.startswith(".") and file.name.endswith(".new")


def _check_packed(file: Path, found: Verified) -> None:
    """Say so where a Parquet file is no longer read in the place of its CSV."""
    csv = file.with_suffix(".csv")
    if not csv.is_file():
        found.note(file, "its CSV is missing, and a Parquet file alone is no record")
    elif Recording.find(csv).note:
        found.note(file, "is not of its CSV as that is now, and not read; vrcomfort pack renews it")


def check_checksums(folder: Path, found: Verified, *, ended: bool) -> None:
    """Compare the files with their checksums at the end of the session.

    Parameters
    ----------
    ended
        Whether the session ended by itself, and so has checksums.
    """
    file = folder / CHECKSUMS
    if not file.exists():
        if ended:
            found.note(file, "is missing (older versions wrote none): changes cannot be seen")
        return
    try:
        known = read_checksums(folder)
    except InputError as error:
        found.refusal(error, file)
        return
    for name, checksum in known.items():
        each = folder / name
        if name in _PACKED and not each.exists():
            continue
        if not each.is_file() or each.is_symlink():
            found.altered.add(each)
            if name not in {row.FILE for row in SESSION_ROWS}:  # the others have been told
                found.fault(each, f"is missing, and {CHECKSUMS} has it; restore it from a copy")
        elif checksum.fits(sha256_of(each)):
            found.intact.add(each)
            found.counts["files unchanged since the session ended"] += 1
        else:
            message = f"has changed since the session ended ({CHECKSUMS}, line {checksum.line})"
            hint = "restore it from a copy, or write down why"
            if name in _PACKED:
                message = f"has changed since it was packed ({CHECKSUMS}, line {checksum.line})"
                hint = "remove it; vrcomfort pack writes it again"
            found.altered.add(each)
            found.fault(each, f"{message}; {hint}")
    for name in sorted(_OWN - known.keys() - {CHECKSUMS}):
        if (folder / name).exists():
            found.fault(folder / name, f"is not in {CHECKSUMS}: it came after the session's end")


_RESTORE = "restore the file that was changed"


@dataclass(frozen=True)
class Recorded:
    """The rows of one session but for frames and gaze."""

    trials: Sequence[RecordedRow]
    timing: Sequence[RecordedRow]
    answers: Sequence[RecordedRow]
    ratings: Sequence[RecordedRow]
    events: Sequence[RecordedRow]
    tasks: Sequence[RecordedRow] = ()
    dials: Sequence[RecordedRow] = ()
    attempts: Mapping[int, Sequence[RecordedRow]] = field(default_factory=dict)

    def all(self) -> Iterable[Sequence[RecordedRow]]:
        """Return the rows of each file."""
        rated = self.answers, self.ratings, self.tasks, self.dials
        return self.trials, self.timing, *rated, self.events


def verify_session(folder: Path, found: Verified) -> dict[str, Any] | None:
    """Verify a session's folder; return its manifest, None where it cannot be read."""
    check_files(folder, found)
    try:
        manifest, ends = read_moment(folder)
    except InputError as error:
        if not is_begun(folder):
            found.note(folder, "holds no row yet; a program has just made it, or was killed then")
            return None
        found.refusal(error, folder / "manifest.json")
        check_checksums(folder, found, ended=False)
        return None
    if ends is not None:
        found.ends[folder] = ends
    found.counts[f"sessions {manifest['status']}"] += 1
    version = manifest.get("schema_version", 1)
    note_version(folder, version, found)
    recorded = _read(folder, version, found)
    _check_manifest(folder / "manifest.json", manifest, recorded.events, found)
    _check_whose(manifest, recorded, found)
    _check_trials(recorded, manifest, found)
    _check_ratings(recorded, manifest, found)
    _check_doings(recorded, manifest, found)
    whole = manifest["status"] in {"completed", "ended", "withdrawn"} and not manifest.get(
        "earlier_runs"
    )
    check_answers(recorded.answers, recorded.events, recorded.trials, found, whole=whole)
    if (folder / ScreeningRow.FILE).exists():
        check_decisions(list(read(folder, ScreeningRow, version, found)), found)
    if (folder / TextRow.FILE).exists():
        check_texts(list(read(folder, TextRow, version, found)), recorded.attempts, found)
    if (folder / PracticeRow.FILE).exists():
        check_practice(list(read(folder, PracticeRow, version, found)), manifest, found)
    check_places(recorded.answers, recorded.attempts, manifest.get("settings") or {}, found)
    rows = read(folder, FrameRow, version, found)
    frames = read_frames(rows, recorded.trials, manifest.get("under_way"), found)
    if ends is not None:
        message = "the session is being run, or its program was killed; looked at up to row"
        message = f"{message} {len(frames.times)} of {FrameRow.FILE}"
        hint = "if it was killed: vrcomfort run … --resume goes on with it"
        found.note(folder / "manifest.json", f"{message}; {hint}")
    check_counts(recorded.trials, frames, found, not_recorded=_not_recorded(recorded.events))
    if not _not_recorded(recorded.events):
        flagged = {(row["trial"], row["attempt"]): row["flagged"] == 1 for row in recorded.timing}
        limits = (manifest.get("settings") or {}).get("flag_above_percent", {})
        check_seen_time(recorded.trials, frames, found, limits_percent=limits, flagged=flagged)
    stopped = interruptions(manifest, recorded.events)
    _check_of_frames(folder, manifest, recorded, frames, stopped, found)
    if (folder / ClockRow.FILE).exists():
        check_clocks(read(folder, ClockRow, version, found), stopped, found)
    check_checksums(folder, found, ended=manifest["status"] != "running")
    return manifest


def _check_of_frames(
    folder: Path,
    manifest: Mapping[str, Any],
    recorded: Recorded,
    frames: Frames,
    stopped: Sequence[Interruption],
    found: Verified,
) -> None:
    """Check the files with a row for a frame: gaze, hashes of images, targets."""
    version = manifest.get("schema_version", 1)
    whole = not stopped and not manifest.get("earlier_runs")
    cut = cuts(frames, stopped, real_time=manifest["respondent"] != "simulated")
    for row_type in OF_FRAMES:
        if (folder / row_type.FILE).exists():
            rows = read(folder, row_type, version, found)
            every = row_type is GazeRow and whole
            gaps = row_type is BallRow and _not_recorded(recorded.events) > 0
            check_times(rows, frames, found, every_frame=every, gaps=gaps, cut=cut)


def _read(folder: Path, version: int, found: Verified) -> Recorded:
    def rows(row_type: type[Row]) -> list[RecordedRow]:
        return list(read(folder, row_type, version, found))

    def there(row_type: type[Row]) -> list[RecordedRow]:
        return rows(row_type) if (folder / row_type.FILE).exists() else []

    trials = rows(TrialRow)
    attempts: dict[int, list[RecordedRow]] = {}
    for row in trials:
        attempts.setdefault(row["trial"], []).append(row)
    return Recorded(
        trials,
        rows(TimingRow),
        rows(QuestionnaireRow),
        rows(RatingRow),
        rows(EventRow),
        there(TaskRow),
        there(DialRow),
        attempts,
    )


def _check_manifest(
    file: Path, manifest: Mapping[str, Any], events: Sequence[RecordedRow], found: Verified
) -> None:
    status, names = manifest["status"], {event["name"] for event in events}
    protocol = manifest["protocol"]
    if protocol.get("text") and protocol["sha256"] != _sha256(protocol["text"]):
        message = "`protocol.sha256` is not that of `protocol.text`"
        found.fault(file, f"{message}; restore the manifest from a copy")
    finished = manifest.get("finished_at")
    if status == "running":
        return
    if status == "aborted":
        found.note(file, "the session was interrupted; vrcomfort run … --resume goes on with it")
    if finished is None:
        message = f"says {status} and not when (`finished_at`)"
        found.fault(file, f"{message}; restore the manifest from a copy")
    end = {"completed": "session_end", "ended": "ended", "withdrawn": "withdrawn"}.get(status)
    if end is not None and events and end not in names:
        message = f"says {status}, and events.csv has no event `{end}`"
        found.fault(file, f"{message}; restore the file that was changed")
    if status == "completed" and manifest.get("under_way"):
        found.fault(file, "says completed, and that an exposure is under way; restore it")
    flagged = [event for event in events if event["name"] == "timing_flag"]
    for event in flagged:
        if event["detail"] not in manifest["timing_flags"]:
            message = f"the manifest's `timing_flags` lack this ({event['detail']})"
            found.fault(event.file, f"{message}; restore the manifest from a copy", event.line)


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _check_whose(manifest: Mapping[str, Any], recorded: Recorded, found: Verified) -> None:
    """Check that each row is of this participant and session, and of a run in its order."""
    for rows in recorded.all():
        resumed = 0
        for row in rows:
            for column in ("participant", "session"):
                if column in row.values and row[column] != manifest[column]:
                    message = f"{column} is {row[column]}, and this folder is of"
                    message = f"{message} {column} {manifest[column]}"
                    found.fault(row.file, f"{message}; {_RESTORE}", row.line)
            if row["resumed"] < resumed:
                message = "is of the run before an interruption, and stands after rows of the next"
                found.fault(row.file, f"{message}; {_RESTORE}", row.line)
            resumed = row["resumed"]


def _check_trials(recorded: Recorded, manifest: Mapping[str, Any], found: Verified) -> None:
    """Compare trials with their timing and with the exposures in the event log."""
    timing = {(row["trial"], row["attempt"]): row for row in recorded.timing}
    exposures = [event for event in recorded.events if event["name"] == "exposure"]
    before_s = 0.0
    for number, attempts in recorded.attempts.items():
        for count, row in enumerate(attempts, start=1):
            if row["attempt"] != count:
                message = f"attempt {row['attempt']} at trial {number} stands in place {count}"
                found.fault(row.file, f"{message}; {_RESTORE}", row.line)
    for row in recorded.trials:
        if before(row["end_s"], row["start_s"]) or before(row["start_s"], before_s):
            message = f"goes from {row['start_s']} s to {row['end_s']} s after {before_s} s"
            found.fault(row.file, f"{message}; {_RESTORE}", row.line)
        before_s = row["end_s"]
        _check_timing(row, timing.pop((row["trial"], row["attempt"]), None), found)
        if row["status"] == "completed" and not any(_shows(e, row) for e in exposures):
            message = f"events.csv has no exposure `{row['condition']} in {row['scene']}` then"
            found.fault(row.file, f"{message}; {_RESTORE}", row.line)
    open_end = manifest["status"] in {"running", "aborted"}
    if not open_end:
        for key, row in timing.items():
            message = f"trials.csv has no attempt {key[1]} at trial {key[0]}"
            found.fault(row.file, f"{message}; restore that file from a copy", row.line)
    for event in exposures:
        if not open_end and not any(_shows(event, row) for row in recorded.trials):
            message = f"trials.csv has no row of this exposure ({event['detail']})"
            found.fault(event.file, f"{message}; restore that file from a copy", event.line)


def _shows(event: RecordedRow, trial: RecordedRow) -> bool:
    return bool(
        event["detail"] == f"{trial['condition']} in {trial['scene']}"
        and within(event["onset_s"], trial["start_s"], trial["end_s"])
    )


def _check_timing(trial: RecordedRow, timing: RecordedRow | None, found: Verified) -> None:
    if timing is None:
        if trial["abort_code"] != "killed":
            message = f"timing.csv has no row of trial {trial['trial']}, attempt {trial['attempt']}"
            found.fault(trial.file, f"{message}; restore that file from a copy", trial.line)
        return
    for column in ("condition", "frames", "dropped"):
        if trial["abort_code"] != "killed" and timing[column] != trial[column]:
            message = f"{column} is {timing[column]}, and trials.csv, line {trial.line}, says"
            found.fault(timing.file, f"{message} {trial[column]}; {_RESTORE}", timing.line)


def _check_ratings(recorded: Recorded, manifest: Mapping[str, Any], found: Verified) -> None:
    open_trial = (manifest.get("under_way") or {}).get("trial")
    for row in recorded.ratings:
        attempts = recorded.attempts.get(row["trial"], ())
        inside = any(within(row["onset_s"], each["start_s"], each["end_s"]) for each in attempts)
        if attempts and attempts[0]["condition"] != row["condition"]:
            message = f"condition is {row['condition']}, and trials.csv, line {attempts[0].line}"
            message = f"{message}, says {attempts[0]['condition']}"
            found.fault(row.file, f"{message}; {_RESTORE}", row.line)
        elif not inside and row["trial"] != open_trial:
            message = f"was asked at {row['onset_s']} s, when trial {row['trial']} was not shown"
            found.fault(row.file, f"{message}; {_RESTORE}", row.line)
        if (row["response"] is None) != (row["missed"] != 0):
            message = f"missed is {row['missed']}, and the response {row['response']}"
            found.fault(row.file, f"{message}; {_RESTORE}", row.line)


def _check_doings(recorded: Recorded, manifest: Mapping[str, Any], found: Verified) -> None:
    """Check that each row of a task or dial is of an attempt that was shown, and lies in it."""
    begun = manifest.get("under_way") or {}
    attempts = {(row["trial"], row["attempt"]): row for row in recorded.trials}
    for row in (*recorded.tasks, *recorded.dials):
        trial = attempts.get((row["trial"], row["attempt"]))
        if trial is None:
            if (row["trial"], row["attempt"]) != (begun.get("trial"), begun.get("attempt")):
                message = f"trials.csv has no attempt {row['attempt']} at trial {row['trial']}"
                found.fault(row.file, f"{message}; {_RESTORE}", row.line)
        elif row["condition"] != trial["condition"]:
            message = f"condition is {row['condition']}, and trials.csv, line {trial.line}, says"
            found.fault(row.file, f"{message} {trial['condition']}; {_RESTORE}", row.line)
        elif not within(row["onset_s"], trial["start_s"], trial["end_s"]):
            message = f"began at {row['onset_s']} s, when trial {row['trial']} was not shown"
            found.fault(row.file, f"{message}; {_RESTORE}", row.line)


def _not_recorded(events: Iterable[RecordedRow]) -> int:
    """Return how many frames have no row, as the events say."""
    words = (e["detail"].partition(" ")[0] for e in events if e["name"] == "frames_not_recorded")
    return sum(whole_or_none(word) or 0 for word in words)


def check_order(
    file: Path, rows: Iterable[Mapping[str, str]], planned: Sequence[Trial], found: Verified,
    *, completed: bool,
) -> None:  # fmt: skip
    """Check that a session's trials are those of its participant's order.

    Parameters
    ----------
    rows
        Of ``trials.csv``.
    completed
        The manifest says so: every trial must have been shown whole.
    """
    done: set[int] = set()
    for line, row in enumerate(rows, start=2):
        number = whole_or_none(row["trial"]) or 0
        if not 1 <= number <= len(planned):
            message = f"this participant's order has {len(planned)} trials, and no {number}"
            found.fault(file, f"{message}; {_RESTORE}", line)
            continue
        trial = planned[number - 1]
        for column, wanted in (("condition", trial.condition), ("scene", trial.scene)):
            if row[column] != wanted:
                message = f"trial {number} is planned with {column} {wanted}, not {row[column]}"
                found.fault(file, f"{message}; {_RESTORE}", line)
        if row["status"] in OVER:
            done.add(number)
    lacking = sorted(set(range(1, len(planned) + 1)) - done)
    if completed and lacking:
        message = f"manifest.json says completed, and trial {lacking[0]} was not shown whole"
        found.fault(file, f"{message}; {_RESTORE}")
