"""Rated exposures: their ratings, how long they were watched, and how they ended."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from vrcomfort.csv_table import number_in
from vrcomfort.errors import InputError
from vrcomfort.frame import DROPPED_INTERVAL_PERIODS
from vrcomfort.recordings import GAP
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.names import natural
from vrcomfort.records.recording import Memory
from vrcomfort.report.possible import Possible
from vrcomfort.report.study_data import length_s, seen_s, trial_s, undone_attempts
from vrcomfort.seen_time import (
    FRAME_COLUMNS,
    SEEN,
    UNSEEN,
    SeenState,
    ShownFrame,
    display_intervals,
    passed_between_ns,
)
from vrcomfort.stats.rating_courses import RatingCourse

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Mapping

    from numpy.typing import NDArray

    from vrcomfort.recordings import RatingSeries
    from vrcomfort.records.reader import Session
    from vrcomfort.report.study_data import StudyData

    Floats = NDArray[np.float64]

ALL, COMPLETERS, CARRIED, WORST = "all available", "completers", "carried forward", "worst case"
"""Assumptions about withdrawals, as sensitivity analyses call them."""
MOST_UNPLACED_S = 0.05
"""Shorter differences of time and live time may be rounding, or a frame."""
SHORTEST_FREEZE_S = 0.5
"""As in a session: a picture that stands still for longer makes ratings missed that fall due."""
_COLUMNS = (
    *("session_s", "trial"),
    *(name for name in FRAME_COLUMNS if name != "session_state"),  # a menu hides no stimulus
)


@dataclass(frozen=True)
class LiveTime:
    """Seen seconds of one exposure by seconds since its start."""

    since_start_s: Floats
    live_s: Floats
    freezes: tuple[tuple[float, float], ...]
    """Onset in seen seconds, and length, of each time of a frozen picture."""

    def at(self, times_s: Floats) -> Floats:
        """Return the seen seconds at times since the start, in their shape."""
        return np.interp(times_s, self.since_start_s, self.live_s)

    @classmethod
    def of(cls, frames_s: Floats, shown_s: Floats, length_s: float) -> LiveTime:
        """Return the seen time of an exposure from the frames that were seen.

        Parameters
        ----------
        frames_s
            Display time of each frame, since the start of the exposure, ascending, shape (n,).
        shown_s
            For how long each was seen, shape (n,); at most until the next one.
        length_s
            Length of the exposure.
        """
        passed = _passed_s(frames_s, length_s)
        shown = np.minimum(shown_s, passed)
        # Seen time rises while a frame is shown, and stands still from there to the next frame.
        knots = np.column_stack([frames_s, frames_s + shown]).ravel()
        live = np.concatenate([[0.0], np.cumsum(shown)])
        at_knots = np.column_stack([live[:-1], live[1:]]).ravel()
        still = passed - shown
        long = np.flatnonzero(still > SHORTEST_FREEZE_S)
        freezes = tuple((float(live[i + 1]), float(still[i])) for i in long)
        end_s = frames_s[-1] + passed[-1]
        return cls(np.append(knots, end_s), np.append(at_knots, live[-1]), freezes)


def _passed_s(frames_s: Floats, length_s: float) -> Floats:
    """Return the time from each frame to the next, of the last one to the exposure's end."""
    return np.diff(frames_s, append=max(length_s, float(frames_s[-1])))


def _shown_s(frames: pd.DataFrame) -> Floats:
    """Return for how long each frame of an exposure was seen, inf until the next one's time.

    0 where nothing was seen of it.
    """
    blank = frames.astype(object).where(frames.notna(), None)
    cells = blank.assign(session_state=None).to_dict("records")
    rows = [ShownFrame.of_row({str(name): cell for name, cell in row.items()}) for row in cells]
    found = [0.0 if each.state in UNSEEN else each.period_ns / 1e9 for each in rows]
    for number, (before, frame) in enumerate(pairwise(rows)):
        seen = sum(ns for state, ns in display_intervals(before, frame) if state in SEEN)
        whole = seen == passed_between_ns(before, frame) and frame.state not in UNSEEN
        found[number] = np.inf if whole else seen / 1e9
    return np.array(found)


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
        if trial.get(SeenState.OFF.column):
            mine = mine.dropna(subset=["xr_time_ns"])
            shown = _shown_s(mine)
            mine, shown = mine[shown > 0], shown[shown > 0]
        else:  # before version 5: while frames are not visible, the one before stands
            mine, shown = mine[mine["should_render"] != 0], None
        if len(mine) < 2:
            return None
        at_s = mine["session_s"].to_numpy(dtype=np.float64) - start
        if shown is None:
            period_s = mine["period_ns"].to_numpy(dtype=np.float64) / 1e9
            late = _passed_s(at_s, end - start) > DROPPED_INTERVAL_PERIODS * period_s
            shown = np.where(late, period_s, np.inf)
        return LiveTime.of(at_s, shown, end - start)


def _lost_s(trial: Mapping[str, str]) -> float:
    length, seen = length_s(trial), seen_s(trial)
    return 0.0 if length is None or seen is None else length - seen


def _owner(session: Session) -> tuple[str, str]:
    """Return participant and session as ``trials.csv`` has them; blank where it has none."""
    row = next(session.text_rows(TrialRow), {})
    return row.get("participant", ""), row.get("session", "")


def _frames(session: Session) -> pd.DataFrame:
    """Return the frames; none of a damaged recording, which the page reports elsewhere."""
    try:
        columns = session.recording().columns(_COLUMNS, Memory())
    except InputError:
        columns = dict.fromkeys(_COLUMNS, np.empty(0))
    whole = ["session_s", "trial", "period_ns", "should_render"]
    return pd.DataFrame(columns).dropna(subset=whole)


Key = tuple[str, str, str, str]
"""Participant, session, trial and condition."""
ENDINGS = {"completed": "completed", "withdrawn": "withdrew", "stopped": "stop rule"}
INTERRUPTED, UNKNOWN = "interrupted", "not recorded"
FINISHED = (ENDINGS["completed"], UNKNOWN)
"""Endings of exposures that were watched to their end, as far as is known."""
LEFT = ("withdrew", "stop rule")
"""Endings that tell of discomfort."""
# A rating at an exposure's very end may be rounded beyond it.
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
        Length of the exposure: seen time, where that was recorded.
    ending
        One of `ENDINGS`, `INTERRUPTED` or `UNKNOWN`.
    not_live_s
        Seconds since the start that its times leave out: the picture was frozen or not visible.
    unplaced
        Whether no frames place these seconds; times of ratings are then those since the start.
    freezes
        Onset in seen seconds, and length, of each time of a frozen picture.
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
    def key(self) -> Key:
        """Return its key among all exposures."""
        return self.participant, self.session, self.trial, self.condition

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
    counts: Counter[str] = Counter()
    for each in study.ratings:
        counts[each.instrument] += each.response.size
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
        Seen time, from frames.

    Raises
    ------
    InputError
        If a time of trials.csv is no number.
    """
    trials = {_key(t): t for t in study.trials if t["participant"] not in without}
    rated: dict[Key, list[RatingSeries]] = defaultdict(list)
    numbered = {key[:3]: key for key in trials if key[2]}
    for each in study.ratings:
        if each.instrument == instrument and each.participant not in without:
            key = (each.participant, each.session, each.trial, each.condition)
            # The trial says the condition, of which a rating may be silent.
            rated[key if key in trials else numbered.get(key[:3], key)].append(each)
    usual_s = study.rating_intervals_s.get(instrument, math.inf)
    undone = undone_attempts(study)
    keys = sorted({*trials, *rated}, key=lambda key: tuple(map(natural, key)))
    positions: Counter[str] = Counter()
    found = []
    for key in keys:
        positions[key[0]] += 1
        trial = trials.get(key, {})
        # A withdrawal that the operator took back is an interruption.
        gone = _attempt(trial) not in undone
        position = positions[key[0]]
        series = _Series.of(rated[key], usual_s)
        found.append(_exposure(key, position, series, trial, clock, may_have_left=gone))
    return found


def possible_area(exposures: Iterable[RatedExposure], scale: Possible) -> Possible:
    """Return the range of areas under ratings on a scale, in points × s.

    They lie between that of the lowest rating throughout the shortest course and that of the
    highest throughout the longest.
    """
    whole = [e.course.answered.times_s for e in exposures if e.course.area() is not None]
    spans_s = [float(np.ptp(times_s)) for times_s in whole]
    if not spans_s or scale.low is None or scale.high is None:
        return Possible()
    ends = [r * each for r in (scale.low, scale.high) for each in (min(spans_s), max(spans_s))]
    return Possible(min(ends), max(ends))


def _key(row: Mapping[str, str]) -> Key:
    first, second, third, last = (
        row.get(name, "") for name in ("participant", "session", "trial", "condition")
    )
    return first, second, third, last


def _attempt(trial: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(trial.get(name, "") for name in ("participant", "session", "trial", "attempt"))


@dataclass(frozen=True)
class _Series:
    """The ratings of one exposure, in the order of time."""

    onset_s: Floats
    response: Floats
    usual_s: float
    """Interval at which ratings come; inf where they are not regular."""

    @property
    def gaps_s(self) -> Floats:
        """Return from when on a rating is missing, and when the next came, shape (gaps, 2)."""
        after = np.flatnonzero(np.diff(self.onset_s) > GAP * self.usual_s)
        if not after.size:
            return np.empty((0, 2))
        return np.column_stack([self.onset_s[after] + self.usual_s, self.onset_s[after + 1]])

    @classmethod
    def of(cls, series: list[RatingSeries], usual_s: float) -> _Series:
        """Return the ratings in the order of time; those of one time keep their order."""
        nothing = np.empty(0)
        onset_s = np.concatenate([each.onset_s for each in series] or [nothing])
        response = np.concatenate([each.response for each in series] or [nothing])
        if (np.diff(onset_s) < 0).any():
            order = np.argsort(onset_s, kind="stable")
            onset_s, response = onset_s[order], response[order]
        return cls(onset_s, response, usual_s)

    def within(self, start_s: float, end_s: float) -> _Series:
        """Return those of an exposure by time since its start."""
        first, last = start_s - _NEAR_S, end_s + _NEAR_S
        begin, end = np.searchsorted(self.onset_s, (first, np.nextafter(last, np.inf)))
        mine = slice(begin, end)
        return _Series(self.onset_s[mine] - start_s, self.response[mine], self.usual_s)

    def on(self, clock: LiveTime) -> _Series:
        """Return the ratings by seen time."""
        return _Series(clock.at(self.onset_s), self.response, self.usual_s)


def _exposure(
    key: Key,
    position: int,
    series: _Series,
    trial: dict[str, str],
    clock: LiveClock | None,
    *,
    may_have_left: bool,
) -> RatedExposure:
    start, end = (_number(trial, name) for name in ("start_s", "end_s"))
    if start is not None and end is not None:  # those of an earlier attempt lie before its start
        series = series.within(start, end)
    live = clock.of(key, trial) if clock and trial else None
    watched = trial_s(trial) if trial else None
    lost = 0.0
    if watched is not None and start is not None and end is not None:
        lost = max(end - start - watched, 0.0)
    if live is not None:
        series = series.on(live)
    times = np.maximum(series.onset_s, 0.0)
    ending = UNKNOWN
    if trial:
        ending = ENDINGS.get(trial["status"], INTERRUPTED) if may_have_left else INTERRUPTED
    return RatedExposure(
        participant=key[0],
        session=key[1],
        trial=key[2],
        condition=key[3],
        position=position,
        course=RatingCourse.of(times, series.response, gaps_s=series.gaps_s),
        ended_s=max(watched or 0.0, float(times[-1]) if times.size else 0.0),
        ending=ending,
        not_live_s=lost,
        unplaced=lost > MOST_UNPLACED_S and live is None,
        freezes=live.freezes if live else (),
    )


def _number(row: Mapping[str, str], name: str) -> float | None:
    text = row.get(name) or ""
    try:
        return number_in(text, words=True)
    except ValueError:
        who = row.get("participant", "")
        raise InputError(f"`{name}` of {who} is `{text}` in trials.csv; give a number") from None
