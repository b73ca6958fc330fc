"""Whether frames and gaze are those of the trials, in order and all there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from vrcomfort.exchange.verifying.findings import Verified
from vrcomfort.records.recorded_rows import RecordedRow

_EPSILON_S = 1e-6
_BACKWARDS = "; the file was changed or mixed with another: restore it from a copy"


@dataclass
class Frames:
    """What was read of ``frames.csv``: times, and frames of each attempt at a trial."""

    times: list[tuple[int, float]] = field(default_factory=list)
    """`xr_time_ns` and `session_s` of each."""
    of_attempt: Counter[tuple[int, int]] = field(default_factory=Counter)
    dropped: Counter[tuple[int, int]] = field(default_factory=Counter)


def read_frames(
    rows: Iterable[RecordedRow],
    trials: Mapping[int, Sequence[RecordedRow]],
    under_way: Mapping[str, object] | None,
    found: Verified,
) -> Frames:
    """Read the frames, and check their order and that each belongs to an exposure on record."""
    frames = Frames()
    homeless: set[int] = set()
    for row in rows:
        _check_order(row, frames, found)
        frames.times.append((row["xr_time_ns"], row["session_s"]))
        if not row["trial"]:
            continue
        attempt = _attempt(row, trials.get(row["trial"], ()))
        if attempt is not None:
            frames.of_attempt[attempt] += 1
            frames.dropped[attempt] += row["dropped"]
        elif row["trial"] not in homeless and not _is_under_way(row, under_way):
            homeless.add(row["trial"])
            message = f"belongs to no attempt at trial {row['trial']} in trials.csv"
            message = f"{message}; restore the file that was changed"
            found.fault(row.file, message, row.line)
    return frames


def _check_order(row: RecordedRow, frames: Frames, found: Verified) -> None:
    if not frames.times:
        return
    before_ns, before_s = frames.times[-1]
    if row["xr_time_ns"] <= before_ns:
        message = f"xr_time_ns {row['xr_time_ns']} is not after {before_ns} in the row before"
        found.fault(row.file, message + _BACKWARDS, row.line)
    elif row["session_s"] < before_s - _EPSILON_S:
        message = f"session_s {row['session_s']} is before {before_s} in the row before"
        found.fault(row.file, message + _BACKWARDS, row.line)


def _attempt(row: RecordedRow, attempts: Sequence[RecordedRow]) -> tuple[int, int] | None:
    for each in reversed(attempts):  # one that was redone ends when the next begins
        if each["start_s"] - _EPSILON_S <= row["session_s"] <= each["end_s"] + _EPSILON_S:
            return each["trial"], each["attempt"]
    return None


def _is_under_way(row: RecordedRow, under_way: Mapping[str, object] | None) -> bool:
    return under_way is not None and row["trial"] == under_way.get("trial")


def check_counts(
    trials: Iterable[RecordedRow], frames: Frames, found: Verified, *, not_recorded: int
) -> None:
    """Compare the rows of ``frames.csv`` with the counts in ``trials.csv``.

    Parameters
    ----------
    not_recorded
        Frames that the events say have no row: so many may be missing.
    """
    missing = 0
    for trial in trials:
        key = trial["trial"], trial["attempt"]
        lacking = trial["frames"] - frames.of_attempt[key]
        missing += max(lacking, 0)
        if lacking < 0 or missing > not_recorded:
            message = f"trial {key[0]}, attempt {key[1]} had {trial['frames']} frames"
            message = f"{message}, and frames.csv has {frames.of_attempt[key]} rows of it"
            found.fault(trial.file, f"{message}; restore frames.csv from a copy", trial.line)
        elif not lacking and trial["dropped"] != frames.dropped[key]:
            message = f"trial {key[0]}, attempt {key[1]} dropped {trial['dropped']} frames"
            message = f"{message}, and frames.csv says {frames.dropped[key]}"
            found.fault(trial.file, f"{message}; restore the file that was changed", trial.line)


def check_times(
    rows: Iterable[RecordedRow],
    frames: Frames,
    found: Verified,
    *,
    every_frame: bool = False,
    gaps: bool = False,
) -> None:
    """Check that gaze, hashes of images, or balls have the times of frames, in order.

    Parameters
    ----------
    every_frame
        One headset showed the whole session: a row for each frame.
    gaps
        Frames may be missing: those for which the disk was too slow.
    """
    at = count = 0
    last: RecordedRow | None = None
    for row in rows:
        last, count = row, count + 1
        while at < len(frames.times) and frames.times[at][0] < row["xr_time_ns"]:
            at += 1
        if gaps:
            continue
        if at == len(frames.times) or frames.times[at] != (row["xr_time_ns"], row["session_s"]):
            message = "frames.csv has no row of this time; restore the file that was changed"
            found.fault(row.file, message, row.line)
            return
    if last is not None and every_frame and count != len(frames.times):
        message = f"has {count} rows, and frames.csv {len(frames.times)}"
        found.fault(last.file, f"{message}; restore the shorter one from a copy", last.line)


def check_clocks(rows: Iterable[RecordedRow], found: Verified) -> None:
    """Check that the session's clock and the system's go forwards together."""
    before: RecordedRow | None = None
    for row in rows:
        if before is not None and row["resumed"] == before["resumed"]:
            for column in ("session_s", "monotonic_ns"):
                if row[column] < before[column]:
                    message = f"{column} {row[column]} is before {before[column]} in the row before"
                    found.fault(row.file, message + _BACKWARDS, row.line)
        before = row
