"""How much of each condition was seen as it was meant: live, frozen, hidden, untracked time."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, Any

import pandas as pd

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from vrcomfort.report.study_data import StudyData

SEEN = ("live_s", "frozen_s", "hidden_s", "unfocused_s")
_CHUNK_ROWS = 500_000
_COLUMNS = ("trial", "period_ns", "head_tracked")


def stimulus_time(
    study: StudyData, conditions: Iterable[str], frames: Iterable[Path]
) -> list[dict[str, Any]]:
    """Add up the seconds of each condition's exposures; blank (None) where none were recorded.

    Parameters
    ----------
    frames
        The study's ``frames.csv`` files, which say whether the head was tracked.
    """
    untracked = _untracked(study, frames)
    found = []
    for condition in conditions:
        trials = [trial for trial in study.trials if trial["condition"] == condition]
        said = [trial for trial in trials if trial.get("live_s")]
        shown = sum(_whole(trial.get("frames")) for trial in trials)
        dropped = sum(_whole(trial.get("dropped")) for trial in trials)
        found.append({
            "condition": condition, "exposures": len(trials), "frames": shown,
            "dropped_percent": 100 * dropped / shown if shown else None,
            **{name: sum(float(t[name] or 0) for t in said) if said else None for name in SEEN},
            "untracked_s": untracked.get(condition),
        })  # fmt: skip
    return found if any(row["frames"] for row in found) else []


def _untracked(study: StudyData, frames: Iterable[Path]) -> dict[str, float]:
    """Add up by condition the frames in which the headset did not measure the head's pose."""
    of = {(t["participant"], t["session"], t["trial"]): t["condition"] for t in study.trials}
    seconds: dict[str, float] = defaultdict(float)
    for file in frames:
        whose = _whose(file)
        if whose is None:
            continue
        for trial, lost in _lost_s(file).items():
            condition = of.get((*whose, trial))
            if condition is not None:
                seconds[condition] += lost
    return dict(seconds)


def _whose(file: Path) -> tuple[str, str] | None:
    """Return participant and session of the folder of a ``frames.csv``."""
    trials = file.with_name("trials.csv")
    if not trials.is_file():
        return None
    table = pd.read_csv(trials, dtype=str, keep_default_na=False, on_bad_lines="skip", nrows=1)
    if table.empty or not {"participant", "session"} <= set(table.columns):
        return None
    return str(table["participant"].iloc[0]), str(table["session"].iloc[0])


def _lost_s(file: Path) -> dict[str, float]:
    """Return trial → seconds of frames without tracking; 0 where all had it."""
    lost: dict[str, float] = defaultdict(float)
    header = pd.read_csv(file, nrows=0, on_bad_lines="skip").columns
    if not set(_COLUMNS) <= set(header):
        return lost
    parts = pd.read_csv(
        file, usecols=list(_COLUMNS), dtype=str, keep_default_na=False, on_bad_lines="skip",
        chunksize=_CHUNK_ROWS,
    )  # fmt: skip
    for rows in parts:
        part = rows[rows["head_tracked"].isin(["0", "1"])]
        period_s = pd.to_numeric(part["period_ns"], errors="coerce").fillna(0) * 1e-9
        untracked = period_s.where(part["head_tracked"] == "0", 0.0)
        for trial, seconds in untracked.groupby(part["trial"]).sum().items():
            lost[str(trial)] += float(seconds)
    return lost


def _whole(text: str | None) -> int:
    return int(text) if text and text.lstrip("-").isdigit() else 0
