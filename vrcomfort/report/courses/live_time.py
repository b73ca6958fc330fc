"""When a stimulus was live, from the frames of an exposure: what stood still does not count."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from vrcomfort.csv_table import number_or_none

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    from vrcomfort.report.study_data import StudyData

    Floats = NDArray[np.float64]

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
    """When the picture stood still, in live seconds, and for how long."""

    def at(self, time_s: float) -> float:
        """Return the live seconds at a time since the start."""
        return float(np.interp(time_s, self.since_start_s, self.live_s))

    @classmethod
    def of(cls, frames_s: Floats, period_s: Floats, length_s: float) -> LiveTime:
        """Return what frames say.

        Parameters
        ----------
        frames_s
            When each frame was shown, since the start of the exposure, ascending, shape (n,).
        period_s
            How long a frame is meant to be shown, shape (n,).
        length_s
            When the exposure ended, since its start.
        """
        ends = np.append(frames_s[1:], max(length_s, float(frames_s[-1])))
        passed = ends - frames_s
        late = passed > LATE_PERIODS * period_s
        shown = np.where(late, period_s, passed)
        knots = np.column_stack([frames_s, frames_s + shown]).ravel()
        live = np.concatenate([[0.0], np.cumsum(shown)])
        at_knots = np.column_stack([live[:-1], live[1:]]).ravel()
        still = passed - shown
        long = np.flatnonzero(still > SHORTEST_FREEZE_S)
        freezes = tuple((float(live[i + 1]), float(still[i])) for i in long)
        return cls(np.append(knots, ends[-1]), np.append(at_knots, live[-1]), freezes)


class LiveClock:
    """Reads frames.csv of those sessions alone in which time was lost."""

    def __init__(self, study: StudyData, folder: Path) -> None:
        self._files: dict[tuple[str, str], Path] = {}
        lost = {(t["participant"], t["session"]) for t in study.trials if _lost_s(t) > 0.05}
        if lost and folder.is_dir():
            for file in sorted(folder.rglob("frames.csv")):
                whose = _whose(file)
                if whose in lost:
                    self._files[whose] = file
        self._read: dict[tuple[str, str], pd.DataFrame] = defaultdict(pd.DataFrame)

    def of(self, key: tuple[str, ...], trial: Mapping[str, str]) -> LiveTime | None:
        """Return the live time of an exposure; None where nothing was lost, or no frame says it."""
        session = key[0], key[1]
        if _lost_s(trial) <= 0.05 or session not in self._files:
            return None
        if session not in self._read:
            self._read[session] = _frames(self._files[session])
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


def _whose(file: Path) -> tuple[str, str] | None:
    trials = file.with_name("trials.csv")
    if not trials.is_file():
        return None
    rows = pd.read_csv(trials, dtype=str, keep_default_na=False, nrows=1)
    if rows.empty or not {"participant", "session"} <= set(rows.columns):
        return None
    return str(rows["participant"].iloc[0]), str(rows["session"].iloc[0])


def _frames(file: Path) -> pd.DataFrame:
    header = pd.read_csv(file, nrows=0).columns
    if not set(_COLUMNS) <= set(header):
        return pd.DataFrame(columns=list(_COLUMNS), dtype=np.float64)
    rows = pd.read_csv(file, usecols=list(_COLUMNS), dtype=str, on_bad_lines="skip")
    numbers: pd.DataFrame = rows.apply(pd.to_numeric, errors="coerce").dropna()
    return numbers[numbers["should_render"] != 0]  # what nobody saw stood behind the frame before
