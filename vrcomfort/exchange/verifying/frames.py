"""Whether frames and gaze are those of the trials, in order and all there."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from vrcomfort.exchange.verifying.findings import Verified
from vrcomfort.records.attempts import TOLERANCE_S, Attempt, FramesOfAttempts, before, within
from vrcomfort.records.interruptions import SAFE_AFTER_S, Interruption
from vrcomfort.records.tables import RecordedRow
from vrcomfort.seen_time import UNTOLD_PERIODS, SeenState, SeenTime, ShownFrame

_RESTORE = "restore the file that was changed"
_BACKWARDS = "; the file was changed or mixed with another: restore it from a copy"


@dataclass
class Frames:
    """The content of ``frames.csv``: times, and frames of each attempt at a trial."""

    times: list[tuple[int, float]] = field(default_factory=list)
    """`xr_time_ns` and `session_s` of each."""
    of_attempt: Counter[Attempt] = field(default_factory=Counter)
    dropped: Counter[Attempt] = field(default_factory=Counter)
    seen: dict[Attempt, SeenTime] = field(default_factory=dict)
    """Until the last frame of each attempt."""
    longest_period_s: float = 0.0


def read_frames(
    rows: Iterable[RecordedRow],
    trials: Sequence[RecordedRow],
    under_way: Mapping[str, object] | None,
    found: Verified,
) -> Frames:
    """Read the frames, and check their order and that each belongs to an exposure on record."""
    of_attempts = FramesOfAttempts(trials)
    frames = Frames(of_attempt=of_attempts.counts)
    homeless: set[int] = set()
    for row in rows:
        _check_order(row, frames, found)
        frames.times.append((row["xr_time_ns"], row["session_s"]))
        if not row["trial"]:
            continue
        attempt = of_attempts.add(row)
        if attempt is not None:
            frames.dropped[attempt] += row["dropped"]
            frames.seen.setdefault(attempt, SeenTime()).add(ShownFrame.of_row(row.values))
            frames.longest_period_s = max(frames.longest_period_s, row["period_ns"] / 1e9)
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
    elif before(row["session_s"], before_s):
        message = f"session_s {row['session_s']} is before {before_s} in the row before"
        found.fault(row.file, message + _BACKWARDS, row.line)


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
    left = not_recorded
    for trial in trials:
        key = trial["trial"], trial["attempt"]
        lacking = trial["frames"] - frames.of_attempt[key]
        told = min(max(lacking, 0), left)
        left -= told
        if lacking != told:
            message = f"trial {key[0]}, attempt {key[1]} had {trial['frames']} frames"
            message = f"{message}, and frames.csv has {frames.of_attempt[key]} rows of it"
            found.fault(trial.file, f"{message}; restore frames.csv from a copy", trial.line)
        elif not lacking and trial["dropped"] != frames.dropped[key]:
            message = f"trial {key[0]}, attempt {key[1]} dropped {trial['dropped']} frames"
            message = f"{message}, and frames.csv says {frames.dropped[key]}"
            found.fault(trial.file, f"{message}; restore the file that was changed", trial.line)


def check_seen_time(
    trials: Iterable[RecordedRow],
    frames: Frames,
    found: Verified,
    *,
    limits_percent: Mapping[str, float],
    flagged: Mapping[Attempt, bool],
) -> None:
    """Check that the states of seen time are those of the frames, and sum to each exposure.

    Parameters
    ----------
    limits_percent
        State → the share above which an exposure is flagged; none where the study had no limits.
    flagged
        Attempt → whether ``timing.csv`` has it flagged.
    """
    # The session's clock is not the display's: an exposure begins and ends between two frames.
    tolerance_s = UNTOLD_PERIODS * frames.longest_period_s + TOLERANCE_S
    for trial in trials:
        if trial[SeenState.OFF.column] is None:  # of an older version, or killed
            continue
        key = trial["trial"], trial["attempt"]
        where = f"trial {key[0]}, attempt {key[1]}"
        elapsed_s, told = trial["end_s"] - trial["start_s"], SeenTime.of_cells(trial.values)
        if abs(told.seconds() - elapsed_s) > tolerance_s:
            message = f"{where} took {elapsed_s:.3f} s, and its states of seen time add up to"
            found.fault(trial.file, f"{message} {told.seconds():.3f} s; {_RESTORE}", trial.line)
        elif (again := frames.seen.get(key)) and frames.of_attempt[key] == trial["frames"]:
            again.end(elapsed_s)
            for state in SeenState:
                one_s, other_s = told.seconds(state), again.seconds(state)
                if abs(one_s - other_s) > tolerance_s:
                    message = f"{where}: {state.column} is {one_s:.3f}, and frames.csv says"
                    message = f"{message} {other_s:.3f}; {_RESTORE}"
                    found.fault(trial.file, message, trial.line)
        beyond = told.beyond(limits_percent) if limits_percent else []
        if beyond and not flagged.get(key, True):
            message = f"{where} is not flagged, and {beyond[0].column} is beyond the limit"
            found.fault(trial.file, f"{message}; {_RESTORE}", trial.line)


def check_times(
    rows: Iterable[RecordedRow],
    frames: Frames,
    found: Verified,
    *,
    every_frame: bool = False,
    gaps: bool = False,
    cut: Sequence[Cut] = (),
) -> None:
    """Check that gaze, hashes of images, or balls have the times of frames, in order.

    Parameters
    ----------
    every_frame
        One headset showed the whole session: a row for each frame.
    gaps
        Frames may be missing: those for which the disk was too slow.
    cut
        Where others may be missing.
    """
    at = count = 0
    last: RecordedRow | None = None
    for row in rows:
        last, count = row, count + 1
        while at < len(frames.times) and frames.times[at][0] < row["xr_time_ns"]:
            at += 1
        if gaps:
            continue
        if not _has_frame(row, frames, at) and not any(each.has(row) for each in cut):
            message = "frames.csv has no row of this time; restore the file that was changed"
            found.fault(row.file, message, row.line)
            return
    if last is not None and every_frame and count != len(frames.times):
        message = f"has {count} rows, and frames.csv {len(frames.times)}"
        found.fault(last.file, f"{message}; restore the shorter one from a copy", last.line)


def _has_frame(row: RecordedRow, frames: Frames, at: int) -> bool:
    if at == len(frames.times):
        return False
    time_ns, time_s = frames.times[at]
    return time_ns == row["xr_time_ns"] and within(row["session_s"], time_s, time_s)


class Cut(NamedTuple):
    """The time at the end of a run that was killed, of which no frames are left."""

    after_s: float
    until_s: float

    def has(self, row: RecordedRow) -> bool:
        """Return whether the frame of a row may be missing."""
        return before(self.after_s, row["session_s"]) and not before(self.until_s, row["session_s"])


def cuts(frames: Frames, interruptions: Iterable[Interruption], *, real_time: bool) -> list[Cut]:
    """Return where frames may be missing.

    Parameters
    ----------
    real_time
        The session's clock is the machine's: then no more is missing than what may wait to be
        synced. In `simulate` time runs as fast as it can, and nothing is synced before the end.
    """
    found = []
    times_s = [time_s for _, time_s in frames.times]
    for each in interruptions:
        if each.killed:
            at = bisect_left(times_s, each.session_s - TOLERANCE_S)
            after_s = times_s[at - 1] if at else -1.0
            if real_time and math.isfinite(each.session_s):
                after_s = max(after_s, each.session_s - SAFE_AFTER_S)
            found.append(Cut(after_s, each.session_s))
    return found


def check_clocks(
    rows: Iterable[RecordedRow], interruptions: Sequence[Interruption], found: Verified
) -> None:
    """Check that the session's clock and the system's go forwards together, in each run."""
    began_s = [each.session_s - TOLERANCE_S for each in interruptions]
    last: RecordedRow | None = None
    for row in rows:
        if last is not None and _run(row, began_s) == _run(last, began_s):
            for column, backwards in (
                ("session_s", before(row["session_s"], last["session_s"])),
                ("monotonic_ns", row["monotonic_ns"] < last["monotonic_ns"]),
            ):
                if backwards:
                    message = f"{column} {row[column]} is before {last[column]} in the row before"
                    found.fault(row.file, message + _BACKWARDS, row.line)
        last = row


def _run(row: RecordedRow, began_s: Sequence[float]) -> tuple[int, int]:
    """Return the run that a row is of."""
    return row["resumed"], bisect_right(began_s, row["session_s"])
