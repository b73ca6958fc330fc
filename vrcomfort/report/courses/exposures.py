"""Exposures with the ratings given in them, how long they were watched, and how they ended."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vrcomfort.csv_table import number_in
from vrcomfort.errors import InputError
from vrcomfort.report.ordering import natural
from vrcomfort.report.study_data import trial_s
from vrcomfort.report.withdrawals import undone_attempts
from vrcomfort.stats.rating_courses import RatingCourse

if TYPE_CHECKING:
    from collections.abc import Container, Mapping

    from vrcomfort.report.courses.live_time import LiveClock
    from vrcomfort.report.study_data import StudyData

Key = tuple[str, str, str, str]
"""Participant, session, trial and condition."""
ENDINGS = {"completed": "completed", "withdrawn": "withdrew", "stopped": "stop rule"}
INTERRUPTED, UNKNOWN = "interrupted", "not recorded"
LEFT = ("withdrew", "stop rule")
"""Endings that say something of how somebody felt."""
_NEAR_S = 1e-6


@dataclass(frozen=True)
class RatedExposure:
    """One exposure.

    Parameters
    ----------
    position
        Its place among the participant's exposures, from 1.
    course
        Its ratings; empty where nothing was rated.
    ended_s
        How long the stimulus was watched: live time, where that was recorded.
    ending
        One of `ENDINGS`, `INTERRUPTED` or `UNKNOWN`.
    not_live_s
        Seconds since the start that are not in its times, because nothing moved or was seen.
    unplaced
        Such seconds there were, and no frame says when: times of ratings are those since the start.
    freezes
        When the picture stood still, in live seconds, and for how long.
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
        """Return whether somebody left early, or was stopped because of a rating."""
        return self.ending in LEFT


def rated_instrument(study: StudyData, wanted: str) -> str:
    """Return the instrument whose ratings are analysed: the one named, or the most rated.

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
    """Return every exposure of trials.csv or with ratings, in the order in which people met them.

    Parameters
    ----------
    without
        Participants that are left out.
    clock
        Says what was live, where frames do.

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
    met: Counter[str] = Counter()
    found = []
    for key in keys:
        met[key[0]] += 1
        trial = trials.get(key, {})
        gone = _attempt(trial) not in undone
        found.append(_exposure(key, met[key[0]], rows[key], trial, clock, may_have_left=gone))
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


MOST_UNPLACED_S = 0.05
"""So much less live time than time may be rounding, or a frame."""


def _rating(row: dict[str, str]) -> tuple[float, float]:
    """Return when a rating fell due and what it was, NaN if it was missed."""
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
