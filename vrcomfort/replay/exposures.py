"""Reads the exposures of a recorded session: their frames, their ratings, the balls of tasks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrcomfort.records import BallRow, DialRow, EventRow, RatingRow, Session, TrialRow
from vrcomfort.records.tables import RecordedRow
from vrcomfort.replay.frame_facts import FrameFacts
from vrcomfort.scene.markers import Shown
from vrcomfort.traces.trace import Trace

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
