"""Stimulus time of each condition from frames and trials, with movement and focus."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from vrcomfort.csv_table import number_or_none, whole_or_none
from vrcomfort.recordings import ExposureFrames
from vrcomfort.report.rows import HIDDEN, INLINE, as_json
from vrcomfort.report.study_data import SIMULATED
from vrcomfort.seen_time import SeenState

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vrcomfort.report.study_data import StudyData

_BEFORE_5 = ("live_s", "frozen_s", "hidden_s", "unfocused_s")
"""The states that studies before version 5 of the schema tell apart."""


@dataclass(frozen=True)
class ConditionTime:
    """Seen time of a condition.

    Parameters
    ----------
    seconds
        State of seen time → seconds; None where none were recorded.
    frame_ms
        Time of a frame → mean over exposures, of each exposure's median or 95th percentile; empty
        where nobody wore a headset.
    """

    condition: str
    exposures: int
    frames: int
    dropped_percent: float | None
    seconds: dict[str, float | None] = field(metadata=INLINE)
    frame_ms: dict[str, float | None] = field(default_factory=dict, metadata=INLINE)


@dataclass(frozen=True)
class ConditionMovement:
    """How the head moved and focus changed: means over the exposures of a condition."""

    condition: str
    exposures: int
    head_path_m: float | None
    head_turning_deg: float | None
    avatar_path_m: float | None
    focus_travel_dioptre: float | None
    focus_lag_dioptre: float | None
    blur_changes: float | None


@dataclass(frozen=True)
class FrameMeasures:
    """Measures from the frames of an exposure.

    Parameters
    ----------
    cells
        The same by column: without the states of seen time that the study does not tell apart.
    """

    condition: str
    frames: ExposureFrames = field(metadata=HIDDEN)
    cells: dict[str, str | int | float | None] = field(metadata=INLINE)


def recorded_states(study: StudyData) -> tuple[str, ...]:
    """Return the columns with the seconds of states that a study has."""
    later = any(trial.get(SeenState.OFF.column) for trial in study.trials)
    others = (state.column for state in SeenState if state.column not in _BEFORE_5)
    return (*_BEFORE_5, *others) if later else _BEFORE_5


def stimulus_time(study: StudyData, conditions: Iterable[str]) -> list[ConditionTime]:
    """Add up the seconds of each condition's exposures; blank (None) where none were recorded."""
    untracked, states = _untracked(study), recorded_states(study)
    found = []
    for condition in conditions:
        trials = [trial for trial in study.trials if trial["condition"] == condition]
        shown = sum(whole_or_none(trial.get("frames")) or 0 for trial in trials)
        dropped = sum(whole_or_none(trial.get("dropped")) or 0 for trial in trials)
        said = [trial for trial in trials if trial.get("live_s")]
        seconds = {n: sum(float(t[n] or 0) for t in said) if said else None for n in states}
        seconds.setdefault("untracked_s", untracked.get(condition))
        share = 100 * dropped / shown if shown else None
        times = _frame_ms(study, condition)
        found.append(ConditionTime(condition, len(trials), shown, share, seconds, times))
    return found if any(row.frames for row in found) else []


FRAME_TIMES = ("cpu_median_ms", "cpu_p95_ms", "gpu_median_ms", "gpu_p95_ms")
"""Columns of timing.csv."""


def _frame_ms(study: StudyData, condition: str) -> dict[str, float | None]:
    """Return the means of a condition's frame times, of sessions with people in a headset."""
    worn = {
        (each.participant, str(each.session))
        for each in study.manifests
        if each.respondent != SIMULATED
    }
    rows = [
        row
        for row in study.timing
        if row["condition"] == condition and (row["participant"], row["session"]) in worn
    ]
    times = {name: _mean(number_or_none(row[name]) for row in rows) for name in FRAME_TIMES}
    return times if any(each is not None for each in times.values()) else {}


def _untracked(study: StudyData) -> dict[str, float]:
    """Add up by condition the frames in which the headset did not measure the head's pose."""
    seconds: dict[str, float] = defaultdict(float)
    for row in frame_measures(study):
        if row.frames.untracked_s is not None:
            seconds[row.condition] += row.frames.untracked_s
    return dict(seconds)


def movement(study: StudyData, conditions: Iterable[str]) -> list[ConditionMovement]:
    """Return each condition's mean measures of frames over its exposures."""
    found = []
    rows = frame_measures(study)
    for condition in conditions:
        mine = [row.frames for row in rows if row.condition == condition]
        if mine:
            row = ConditionMovement(
                condition,
                len(mine),
                head_path_m=_mean(each.head_path_m for each in mine),
                head_turning_deg=_mean(each.head_turning_deg for each in mine),
                avatar_path_m=_mean(each.avatar_path_m for each in mine),
                focus_travel_dioptre=_mean(each.focus_travel_dioptre for each in mine),
                focus_lag_dioptre=_mean(each.focus_lag_dioptre for each in mine),
                blur_changes=_mean(each.blur_changes for each in mine),
            )
            found.append(row)
    return found


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def frame_measures(study: StudyData) -> list[FrameMeasures]:
    """Return the measures of frames of the last attempt at each exposure."""
    of = {_key(trial): trial["condition"] for trial in study.trials}
    keys = ((each.participant, each.session, each.trial, each.attempt) for each in study.frames)
    pairs = zip(keys, study.frames, strict=True)
    states = {*recorded_states(study), SeenState.UNTRACKED.column}
    lacking = {state.column for state in SeenState} - states
    return [
        FrameMeasures(
            of[key],
            frames,
            {name: cell for name, cell in as_json(frames).items() if name not in lacking},
        )
        for key, frames in pairs
        if key in of
    ]


def _key(trial: dict[str, str]) -> tuple[str, str, int, int]:
    number, attempt = whole_or_none(trial["trial"]) or 0, whole_or_none(trial.get("attempt")) or 1
    return trial["participant"], trial["session"], number, attempt
