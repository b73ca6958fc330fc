"""Rated exposures: their ratings, how long they were watched, and how they ended."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from vrcomfort.csv_table import number_in, number_or_none
from vrcomfort.errors import InputError
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.names import natural
from vrcomfort.records.recording import Memory
from vrcomfort.report.study_data import trial_s
from vrcomfort.report.withdrawals import undone_attempts
from vrcomfort.stats.rating_courses import RatingCourse

if TYPE_CHECKING:
    from collections.abc import Container, Mapping

    from numpy.typing import NDArray

    from vrcomfort.records.reader import Session
    from vrcomfort.report.study_data import StudyData

    Floats = NDArray[np.float64]

ALL, COMPLETERS, CARRIED, WORST = "all available", "completers", "carried forward", "worst case"
"""Assumptions about withdrawals, as sensitivity analyses call them."""
MOST_UNPLACED_S = 0.05
"""Shorter differences of time and live time may be rounding, or a frame."""
SHORTEST_FREEZE_S = 0.5
"""As in a session: a picture that stands still for longer makes ratings missed that fall due."""
LATE_PERIODS = 1.2
"""A frame that stands for longer stood still for all but its period."""
_COLUMNS = ("session_s", "trial", "period_ns", "should_render")


@dataclass(frozen=True)
class LiveTime:
    """Live seconds of one exposure by seconds since its start."""

    since_start_s: Floats
    live_s: Floats
    freezes: tuple[tuple[float, float], ...]
    """Onset in live seconds, and length, of each time of a frozen picture."""

    def at(self, time_s: float) -> float:
        """Return the live seconds at a time since the start."""
        return float(np.interp(time_s, self.since_start_s, self.live_s))

    @classmethod
    def of(cls, frames_s: Floats, period_s: Floats, length_s: float) -> LiveTime:
        """Return the live time of an exposure from its frames.

        Parameters
        ----------
        frames_s
            Display time of each frame, since the start of the exposure, ascending, shape (n,).
        period_s
            Period of each frame, shape (n,).
        length_s
            Length of the exposure.
        """
        ends = np.append(frames_s[1:], max(length_s, float(frames_s[-1])))
        passed = ends - frames_s
        late = passed > LATE_PERIODS * period_s
        shown = np.where(late, period_s, passed)
        # Live time rises while a frame is shown, and stands still from there to the next frame.
        knots = np.column_stack([frames_s, frames_s + shown]).ravel()
        live = np.concatenate([[0.0], np.cumsum(shown)])
        at_knots = np.column_stack([live[:-1], live[1:]]).ravel()
        still = passed - shown
        long = np.flatnonzero(still > SHORTEST_FREEZE_S)
        freezes = tuple((float(live[i + 1]), float(still[i])) for i in long)
        return cls(np.append(knots, ends[-1]), np.append(at_knots, live[-1]), freezes)


class LiveClock:
    """Reads frames.csv of those sessions alone in which time was lost."""

    def __init__(self, study: StudyData) -> None:
        lost = {
            (t["participant"], t["session"]) for t in study.trials if _lost_s(t) > MOST_UNPLACED_S
        }
        recorded = study.recorded_sessions if lost else ()
        named = {_owner(session): session for session in recorded}
        self._sessions = {owner: named[owner] for owner in lost & named.keys()}
        self._read: dict[tuple[str, str], pd.DataFrame] = {}

    def of(self, key: tuple[str, ...], trial: Mapping[str, str]) -> LiveTime | None:
        """Return the live time of an exposure; None without lost time, or without frames of it."""
        session = key[0], key[1]
        if _lost_s(trial) <= MOST_UNPLACED_S or session not in self._sessions:
            return None
        if session not in self._read:
            self._read[session] = _frames(self._sessions[session])
        frames = self._read[session]
        start, end = float(trial["start_s"]), float(trial["end_s"])
        mine = frames[(frames["trial"] == float(trial["trial"])) & (frames["session_s"] >= start)]
        mine = mine[mine["session_s"] <= end].sort_values("session_s")
        if len(mine) < 2:
            return None
        at_s = mine["session_s"].to_numpy(dtype=np.float64) - start
        return LiveTime.of(at_s, mine["period_ns"].to_numpy(dtype=np.float64) / 1e9, end - start)


def _lost_s(trial: Mapping[str, str]) -> float:
    start, end, live = (
        number_or_none(trial.get(name) or "") for name in ("start_s", "end_s", "live_s")
    )
    return 0.0 if start is None or end is None or live is None else end - start - live


def _owner(session: Session) -> tuple[str, str]:
    """Return participant and session as ``trials.csv`` has them; blank where it has none."""
    row = next(session.text_rows(TrialRow), {})
    return row.get("participant", ""), row.get("session", "")


def _frames(session: Session) -> pd.DataFrame:
    """Return the visible frames; none of a damaged recording, which the page reports elsewhere."""
    try:
        columns = session.recording().columns(_COLUMNS, Memory())
    except InputError:
        columns = dict.fromkeys(_COLUMNS, np.empty(0))
    frames = pd.DataFrame(columns).dropna()
    # While frames are not visible, the one before stands.
    return frames[frames["should_render"] != 0]


Key = tuple[str, str, str, str]
"""Participant, session, trial and condition."""
ENDINGS = {"completed": "completed", "withdrawn": "withdrew", "stopped": "stop rule"}
INTERRUPTED, UNKNOWN = "interrupted", "not recorded"
LEFT = ("withdrew", "stop rule")
"""Endings that tell of discomfort."""
_NEAR_S = 1e-6


@dataclass(frozen=True)
class RatedExposure:
    """One exposure with its ratings.

    Parameters
    ----------
    position
        Its place among the participant's exposures, from 1.
    course
        Its ratings; empty where nothing was rated.
    ended_s
        Length of the exposure: live time, where that was recorded.
    ending
        One of `ENDINGS`, `INTERRUPTED` or `UNKNOWN`.
    not_live_s
        Seconds since the start that its times leave out: the picture was frozen or not visible.
    unplaced
        Whether no frames place these seconds; times of ratings are then those since the start.
    freezes
        Onset in live seconds, and length, of each time of a frozen picture.
    """

    participant: str
    session: str
    trial: str
    condition: str
    position: int
    course: RatingCourse
    ended_s: float
    ending: str
    not_live_s: float = 0.0
    unplaced: bool = False
    freezes: tuple[tuple[float, float], ...] = ()

    @property
    def left(self) -> bool:
        """Return whether the participant withdrew, or the stop rule ended the exposure."""
        return self.ending in LEFT


def rated_instrument(study: StudyData, wanted: str) -> str:
    """Return the instrument of the analysed ratings: the one named, or the most rated.

    Raises
    ------
    InputError
        If the one named was not rated.
    """
    counts = Counter(row.get("instrument", "") for row in study.ratings)
    if wanted and wanted not in counts:
        there = ", ".join(sorted(counts)) or "none"
        raise InputError(f"nothing was rated with `{wanted}`; ratings are of: {there}")
    return wanted or next((name for name, _ in counts.most_common(1)), "")


def rated_exposures(
    study: StudyData,
    instrument: str,
    *,
    without: Container[str] = (),
    clock: LiveClock | None = None,
) -> list[RatedExposure]:
    """Return the exposures of trials.csv and of ratings, in their order for each participant.

    Parameters
    ----------
    without
        Excluded participants.
    clock
        Live time, from frames.

    Raises
    ------
    InputError
        If a cell of ratings.csv is no number.
    """
    trials = {_key(t): t for t in study.trials if t["participant"] not in without}
    rows: dict[Key, list[dict[str, str]]] = defaultdict(list)
    for row in study.ratings:
        mine = row.get("instrument", "") == instrument
        if mine and row.get("participant", "") not in without:
            rows[_key(row)].append(row)
    undone = undone_attempts(study)
    keys = sorted({*trials, *rows}, key=lambda key: tuple(map(natural, key)))
    positions: Counter[str] = Counter()
    found = []
    for key in keys:
        positions[key[0]] += 1
        trial = trials.get(key, {})
        # A withdrawal that the operator took back is an interruption.
        gone = _attempt(trial) not in undone
        position = positions[key[0]]
        found.append(_exposure(key, position, rows[key], trial, clock, may_have_left=gone))
    return found


def _key(row: Mapping[str, str]) -> Key:
    first, second, third, last = (
        row.get(name, "") for name in ("participant", "session", "trial", "condition")
    )
    return first, second, third, last


def _attempt(trial: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(trial.get(name, "") for name in ("participant", "session", "trial", "attempt"))


def _exposure(
    key: Key,
    position: int,
    rows: list[dict[str, str]],
    trial: dict[str, str],
    clock: LiveClock | None,
    *,
    may_have_left: bool,
) -> RatedExposure:
    start, end = (_number(trial, name) for name in ("start_s", "end_s"))
    pairs = [(onset, rating) for onset, rating in map(_rating, rows)]
    if start is not None and end is not None:  # those of an earlier attempt lie before its start
        pairs = [(t - start, r) for t, r in pairs if start - _NEAR_S <= t <= end + _NEAR_S]
    live = clock.of(key, trial) if clock and trial else None
    watched = trial_s(trial) if trial else None
    lost = 0.0
    if watched is not None and start is not None and end is not None:
        lost = max(end - start - watched, 0.0)
    if live is not None:
        pairs = [(live.at(t), r) for t, r in pairs]
    times = [max(t, 0.0) for t, _ in pairs]
    ending = UNKNOWN
    if trial:
        ending = ENDINGS.get(trial["status"], INTERRUPTED) if may_have_left else INTERRUPTED
    return RatedExposure(
        participant=key[0],
        session=key[1],
        trial=key[2],
        condition=key[3],
        position=position,
        course=RatingCourse.of(times, [r for _, r in pairs]),
        ended_s=max(watched or 0.0, *times) if times else watched or 0.0,
        ending=ending,
        not_live_s=lost,
        unplaced=lost > MOST_UNPLACED_S and live is None,
        freezes=live.freezes if live else (),
    )


def _rating(row: dict[str, str]) -> tuple[float, float]:
    """Return the onset and the value of a rating; NaN if it was missed."""
    onset = _number(row, "onset_s")
    if onset is None:
        who = row.get("participant", "")
        raise InputError(f"a rating of {who} in ratings.csv has no onset_s; give seconds")
    response = None if row.get("missed", "") not in {"", "0"} else _number(row, "response")
    return onset, float("nan") if response is None else response


def _number(row: Mapping[str, str], name: str) -> float | None:
    text = row.get(name) or ""
    try:
        return number_in(text, words=True)
    except ValueError:
        who = row.get("participant", "")
        raise InputError(
            f"`{name}` of {who} is `{text}` in ratings.csv or trials.csv; give a number"
        ) from None
