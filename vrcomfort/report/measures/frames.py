"""Measures of what the frames of an exposure say: the head's path, its turning, focus changes.

Frames of an exposure are those of its last attempt. A step counts between two frames that follow
each other in it, where both poses are known and nothing jumped in between.
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
import pandas as pd

from vrcomfort.errors import InputError
from vrcomfort.report.measures.model import Measure, Quantity, Value, exactly

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from numpy.typing import NDArray

    from vrcomfort.report.study_data import StudyData

    Floats = NDArray[np.float64]

CHUNK_ROWS = 200_000
_HEAD = ("head_x_m", "head_y_m", "head_z_m")
_TURN = ("head_qx", "head_qy", "head_qz", "head_qw")
_AVATAR = ("avatar_x_m", "avatar_y_m", "avatar_z_m")
_ALWAYS = ("session_s", "trial", "discontinuity")


class _Rule(NamedTuple):
    """How steps are taken from rows, and what is made of them for each exposure."""

    columns: tuple[str, ...]
    steps: Callable[[Floats], Floats]
    """Rows (n, columns) → what lies between each and the next one, shape (n − 1,)."""


def _path(rows: Floats) -> Floats:
    return np.asarray(np.linalg.norm(np.diff(rows, axis=0), axis=1), dtype=np.float64)


def _turned_deg(rows: Floats) -> Floats:
    """Return the angle between successive unit quaternions."""
    units = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    before, after = units[:-1], units[1:]
    apart = np.minimum(
        np.linalg.norm(after - before, axis=1), np.linalg.norm(after + before, axis=1)
    )
    return np.asarray(np.degrees(4 * np.arcsin(np.clip(apart / 2, 0, 1))), dtype=np.float64)


def _dioptres(rows: Floats) -> Floats:
    return np.asarray(np.abs(np.diff(1 / rows[:, 0])), dtype=np.float64)


def _changes(rows: Floats) -> Floats:
    changed: Floats = (np.diff(rows[:, 0]) != 0).astype(np.float64)
    return changed


_RULES = {
    "head_path_m": _Rule(_HEAD, _path),
    "head_turning_deg": _Rule(_TURN, _turned_deg),
    "avatar_path_m": _Rule(_AVATAR, _path),
    "focus_travel_dioptre": _Rule(("focus_m",), _dioptres),
    "blur_changes": _Rule(("max_blur_px",), _changes),
}
QUANTITIES = {
    "head_path_m": Quantity("Path of the head", "m", "", "the sum of the head’s steps in the room"),
    "head_turning_deg": Quantity(
        "Turning of the head", "°", "", "the sum of the angles that the head turned by"
    ),
    "avatar_path_m": Quantity(
        "Path through the scene", "m", "", "the sum of the steps of what carries the head, jumps "
        "left out",
    ),
    "focus_travel_dioptre": Quantity(
        "Focus changes", "D", "", "the sum of the changes of the focus distance, in dioptres"
    ),
    "blur_changes": Quantity(
        "Changes of the blur limit", "", "", "how often the largest blur of the condition changed"
    ),
}  # fmt: skip


class Frames:
    """``frames.csv``, read only where a plan names one of its quantities."""

    quantities: ClassVar[dict[str, Quantity]] = QUANTITIES

    def values(self, study: StudyData, measure: Measure) -> Iterator[Value]:
        """Yield the value of each exposure of which there are frames."""
        rule = _RULES[measure.quantity]
        files = sorted(study.source.rglob("frames.csv")) if study.source.is_dir() else []
        if not files:
            raise InputError(f"the study has no frames.csv, of which {measure.name} is measured")
        sums: dict[tuple[str, str, str], float] = {}
        trials = {(t["participant"], t["session"], t["trial"]): t for t in study.trials}
        for file in files:
            whose = _whose(file)
            if whose is not None:
                mine = {key[2]: t for key, t in trials.items() if key[:2] == whose}
                sums |= {(*whose, t): total for t, total in _sums(file, rule, mine).items()}
        for key, trial in trials.items():
            found = exactly(sums[key]) if key in sums else None
            reason = "" if found is not None else "no frames say it"
            yield Value(*key, trial["condition"], found, reason)


def _whose(file: Path) -> tuple[str, str] | None:
    trials = file.with_name("trials.csv")
    if not trials.is_file():
        return None
    rows = pd.read_csv(trials, dtype=str, keep_default_na=False, on_bad_lines="skip", nrows=1)
    if rows.empty or not {"participant", "session"} <= set(rows.columns):
        return None
    return str(rows["participant"].iloc[0]), str(rows["session"].iloc[0])


def _sums(file: Path, rule: _Rule, trials: dict[str, dict[str, str]]) -> dict[str, float]:
    """Return trial → sum of its steps; nothing of a trial without two frames that say it."""
    needed = [*_ALWAYS, *rule.columns]
    header = pd.read_csv(file, nrows=0, on_bad_lines="skip").columns
    if not set(needed) <= set(header):
        return {}
    parts = pd.read_csv(
        file, usecols=needed, dtype=str, keep_default_na=False, on_bad_lines="skip",
        chunksize=CHUNK_ROWS,
    )  # fmt: skip
    sums: dict[str, float] = defaultdict(float)
    before: pd.DataFrame | None = None
    for part in parts:
        rows = part if before is None else pd.concat([before, part])
        for trial, total in _steps(rows, rule, trials).items():
            sums[trial] += total
        before = part.tail(1)
    return dict(sums)


def _steps(rows: pd.DataFrame, rule: _Rule, trials: dict[str, dict[str, str]]) -> dict[str, float]:
    numbers = rows[list(rule.columns)].apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
    at_s = pd.to_numeric(rows["session_s"], errors="coerce").to_numpy(dtype=float)
    trial = rows["trial"].to_numpy()
    jumped = ~rows["discontinuity"].isin(["0", ""]).to_numpy()
    with np.errstate(divide="ignore", invalid="ignore"):
        steps = rule.steps(numbers)
    found: dict[str, float] = {}
    for name, said in trials.items():
        inside = (trial == name) & _of_last_attempt(at_s, said)
        counts = inside[:-1] & inside[1:] & ~jumped[1:] & np.isfinite(steps)
        if counts.any():
            found[name] = float(steps[counts].sum())
    return found


def _of_last_attempt(at_s: Floats, trial: dict[str, str]) -> NDArray[np.bool_]:
    try:
        start, end = float(trial["start_s"]), float(trial["end_s"])
    except (KeyError, ValueError):
        return np.ones(at_s.shape, dtype=bool)
    return (at_s >= start - 1e-6) & (at_s <= end + 1e-6)
