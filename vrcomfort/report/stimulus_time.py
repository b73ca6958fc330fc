"""What frames and trials say of each condition: seconds seen as meant, movement, focus."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, Any

from vrcomfort.csv_table import whole_or_none
from vrcomfort.seen_time import SeenState

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vrcomfort.recordings import ExposureFrames
    from vrcomfort.report.study_data import StudyData

_BEFORE_5 = ("live_s", "frozen_s", "hidden_s", "unfocused_s")
"""The states that studies before version 5 of the schema tell apart."""
MOVEMENT = (
    "head_path_m", "head_turning_deg", "avatar_path_m", "focus_travel_dioptre",
    "focus_lag_dioptre", "blur_changes",
)  # fmt: skip


def recorded_states(study: StudyData) -> tuple[str, ...]:
    """Return the columns with the seconds of states that a study has."""
    later = any(trial.get(SeenState.OFF.column) for trial in study.trials)
    others = (state.column for state in SeenState if state.column not in _BEFORE_5)
    return (*_BEFORE_5, *others) if later else _BEFORE_5


def stimulus_time(study: StudyData, conditions: Iterable[str]) -> list[dict[str, Any]]:
    """Add up the seconds of each condition's exposures; blank (None) where none were recorded."""
    untracked, states = _untracked(study), recorded_states(study)
    found = []
    for condition in conditions:
        trials = [trial for trial in study.trials if trial["condition"] == condition]
        said = [trial for trial in trials if trial.get("live_s")]
        shown = sum(whole_or_none(trial.get("frames")) or 0 for trial in trials)
        dropped = sum(whole_or_none(trial.get("dropped")) or 0 for trial in trials)
        found.append({
            "condition": condition, "exposures": len(trials), "frames": shown,
            "dropped_percent": 100 * dropped / shown if shown else None,
            **{name: sum(float(t[name] or 0) for t in said) if said else None for name in states},
            **({} if "untracked_s" in states else {"untracked_s": untracked.get(condition)}),
        })  # fmt: skip
    return found if any(row["frames"] for row in found) else []


def _untracked(study: StudyData) -> dict[str, float]:
    """Add up by condition the frames in which the headset did not measure the head's pose."""
    seconds: dict[str, float] = defaultdict(float)
    for condition, frames in frames_by_condition(study):
        if frames.untracked_s is not None:
            seconds[condition] += frames.untracked_s
    return dict(seconds)


def frame_rows(study: StudyData) -> list[dict[str, Any]]:
    """Return what the frames of each exposure say, with its condition; a row an exposure."""
    states = {*recorded_states(study), SeenState.UNTRACKED.column}
    lacking = {state.column for state in SeenState} - states
    return [
        {
            "condition": condition,
            **{name: cell for name, cell in frames.cells().items() if name not in lacking},
        }
        for condition, frames in frames_by_condition(study)
    ]


def movement(study: StudyData, conditions: Iterable[str]) -> list[dict[str, Any]]:
    """Return the means over each condition's exposures of what their frames say."""
    found = []
    rows = frames_by_condition(study)
    for condition in conditions:
        mine = [frames for name, frames in rows if name == condition]
        means = {name: _mean(getattr(frames, name) for frames in mine) for name in MOVEMENT}
        if mine:
            found.append({"condition": condition, "exposures": len(mine), **means})
    return found


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def frames_by_condition(study: StudyData) -> list[tuple[str, ExposureFrames]]:
    """Return the condition of each exposure that counts, its last attempt, and its frames."""
    of = {_key(trial): trial["condition"] for trial in study.trials}
    keys = ((each.participant, each.session, each.trial, each.attempt) for each in study.frames)
    pairs = zip(keys, study.frames, strict=True)
    return [(of[key], frames) for key, frames in pairs if key in of]


def _key(trial: dict[str, str]) -> tuple[str, str, int, int]:
    number, attempt = whole_or_none(trial["trial"]) or 0, whole_or_none(trial.get("attempt")) or 1
    return trial["participant"], trial["session"], number, attempt
