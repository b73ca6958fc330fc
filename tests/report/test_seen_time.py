"""What nobody saw changes no analysis: how long it took, and where heads and eyes were meanwhile.

A study is reported twice: as it was recorded, and after each time without a picture was made longer
and head, eyes and focus were put elsewhere in it. An analysis of a rating or an exposure that takes
elapsed for seen seconds, or frames that were not seen, differs. Nothing is listed here but what
says itself how long nothing was seen.
"""

from __future__ import annotations

import csv
import json
import math
import shutil
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.report import build_report
from tests.support.resume import go
from tests.support.study import (
    PROTOCOL,
    AheadHeadset,
    LateFocus,
    Picture,
    Scripted,
    read_rows,
    tiny_protocol,
)
from vrcomfort.frame import Frame, GazeHit, HeadsetEvent
from vrcomfort.geometry import Gaze, Pose, axis_angle
from vrcomfort.seen_time import FRAME_COLUMNS, UNSEEN, SeenState, ShownFrame, display_intervals

pytestmark = pytest.mark.slow

PEOPLE = 8
LONGER_S = 7
"""Added to each time in which nothing was seen."""
TIMES = {"session_s", "onset_s", "start_s", "end_s", "asked_s", "answered_s", "decided_s"}
"""Columns on the session's clock."""
CLOCKS_NS = {"xr_time_ns", "monotonic_ns", "unix_ns"}
SAYS_SO = {"not_live_s", "freezes", *(state.column for state in UNSEEN)}
"""What is reported of unseen time itself."""
PLAN = """name = "seen"
title = "What was seen"
outcomes = [
  "ratings.peak", "ratings.mean", "ratings.last", "ratings.area", "ratings.slope", "time_to_3",
  "frames.head_path_m", "frames.head_turning_deg", "frames.avatar_path_m",
  "frames.focus_travel_dioptre", "frames.focus_lag_dioptre", "frames.blur_changes",
  "trials.seen_s", "trials.live_s", "trials.unfocused_s", "trials.dropped_percent", "T",
]
[[measures]]
name = "time_to_3"
measure = "ratings.time_to"
threshold = 3
better = "higher"
[ratings]
instrument = "fms"
threshold = 3
times_s = [2.23, 4.71, 8.17]
[gaze_and_head]
during = ["shot"]
during_s = 1.47
spectrum_window_s = 2.0
zones = [0.3, 1.0]
"""
UNSEEN_FRAMES = {
    "not_drawn": {"should_render": False},
    "hidden": {"paused": True},
    "off": {"user_present": False},
}


class Interrupted(AheadHeadset):
    """A headset with an eye tracker, of whose frames some are not seen, in each way there is."""

    def __init__(self, seed: int) -> None:
        super().__init__()
        random = np.random.default_rng(seed)
        starts = 12 + 22 * np.arange(4) + random.integers(0, 12, 4)
        ways = random.permutation([*UNSEEN_FRAMES, "gap"])
        self._unseen = {
            int(start + n): str(way)
            for start, way in zip(starts, ways, strict=True)
            for n in range(1 if way == "gap" else int(random.integers(2, 7)))
        }
        self._random = random

    def frames(self) -> Iterator[Frame]:
        late_ns, yaw = 0, 0.0
        for plain in super().frames():
            way = self._unseen.get(plain.index, "")
            late_ns += 3_000_000_000 * (way == "gap")
            yaw += float(self._random.normal(0, 0.05))
            head = Pose(np.array([0.1 * yaw, 1.6, 0.0]), axis_angle([0.0, 1.0, 0.0], yaw))
            look = Pose(
                head.position, axis_angle([0.2, 1.0, 0.0], yaw + self._random.normal(0, 0.2))
            )
            if plain.index % 20 == 9:
                self.events.append(HeadsetEvent("shot"))
            yield replace(
                plain,
                predicted_display_time_ns=plain.predicted_display_time_ns + late_ns,
                head_pose=head,
                gaze=Gaze(look, valid=bool(self._random.random() < 0.9)),
                discontinuity=plain.discontinuity or way == "gap",
                **UNSEEN_FRAMES.get(way, {}),
            )


class Looks(LateFocus):
    """Names what is looked at: a lamp now and then, else a wall."""

    def render(self, frame: Frame, scene_time_s: float) -> Picture:
        """Return no picture, and the node of the frame's gaze."""
        hit = GazeHit(frame.index, 2.0, "lamp" if frame.index % 9 < 4 else "wall")
        return replace(super().render(frame, scene_time_s), seeks_gaze=True, gaze_hits=(hit,))


@dataclass
class Sickening(Scripted):
    """Rates higher and higher, some faster than others."""

    per_s: float = 0.5

    def rating(self, elapsed_s: float) -> int | None:
        """Return the rating, half a second after it was asked for."""
        return round(self.per_s * elapsed_s) if elapsed_s >= self.asked_s + 0.5 else None


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded")
    text = PROTOCOL.replace("every_s = 3.0\ntimeout_s = 2.0", "every_s = 1.0\ntimeout_s = 0.9")
    assert text != PROTOCOL
    protocol = tiny_protocol(folder, text)
    for person in range(PEOPLE):
        leaves_s = 6.0 if person % 4 == 3 else None
        go(
            folder,
            Sickening(per_s=0.3 + 0.07 * person, withdraw_at_s=leaves_s),
            participant=f"P{person:02}",
            protocol=protocol,
            headset_for=lambda *_, person=person: Interrupted(person),
            renderer=Looks(),
        )
    return folder / "S"


Row = dict[str, str]


def shown(row: Row) -> ShownFrame:
    numbers = {
        name: float(cell) if cell else None
        for name, cell in row.items()
        if name in FRAME_COLUMNS and name != "session_state"
    }
    return ShownFrame.of_row({**row, **numbers})


@dataclass(frozen=True)
class Unseen:
    """Where a session's times without a picture end, on its clock, and their states and trials."""

    ends_s: tuple[float, ...]
    states: tuple[SeenState, ...]
    trials: tuple[str, ...]

    @classmethod
    def of(cls, frames: list[Row]) -> Unseen:
        found = []
        for before, row in pairwise(frames):
            if before["trial"] == row["trial"]:
                for state, passed_ns in display_intervals(shown(before), shown(row)):
                    if state in UNSEEN and passed_ns:
                        found.append((float(row["session_s"]), state, row["trial"]))
        return cls(*zip(*found, strict=True))

    def later_s(self, time_s: float) -> int:
        """Return by how much later a time is, where each of them is longer."""
        return LONGER_S * bisect_right(self.ends_s, time_s + 1e-6)


def changed(row: Row, unseen: Unseen) -> Row:
    """Return a row of any table with later times."""
    new = dict(row)
    for name in TIMES & {name for name, cell in row.items() if cell}:
        new[name] = repr(float(row[name]) + unseen.later_s(float(row[name])))
    for name in CLOCKS_NS & row.keys() if row.get("session_s") else ():
        new[name] = str(int(row[name]) + 10**9 * unseen.later_s(float(row["session_s"])))
    if row.get("duration_s") and row.get("onset_s"):
        onset_s, length_s = float(row["onset_s"]), float(row["duration_s"])
        longer_s = unseen.later_s(onset_s + length_s) - unseen.later_s(onset_s)
        new["duration_s"] = repr(length_s + longer_s)
    for state, trial in zip(unseen.states, unseen.trials, strict=True):
        if state.column in row and row["trial"] == trial:
            new[state.column] = repr(float(new[state.column]) + LONGER_S)
    return new


ELSEWHERE = {
    **dict.fromkeys(("head_x_m", "avatar_x_m"), "40.0"),
    **dict.fromkeys(("head_qy", "head_qz", "head_qw", "direction_y", "direction_z"), "0.0"),
    **dict.fromkeys(("head_qx", "direction_x", "valid"), "1"),
    "hit_node": "nowhere",
    "focus_m": "0.3",
    "focus_raw_m": "9.0",
    "max_blur_px": "77.0",
}
"""What a frame has, and its gaze, that nobody saw."""


def put_elsewhere(row: Row) -> Row:
    return {**row, **{name: cell for name, cell in ELSEWHERE.items() if row.get(name)}}


def prolong(session: Path) -> int:
    """Make unseen times of a session longer, with other contents; return how many there were."""
    frames = read_rows(session / "frames.csv")
    unseen = Unseen.of(frames)
    nobody_saw = {row["xr_time_ns"] for row in frames if shown(row).state in UNSEEN}
    for file in session.glob("*.csv"):
        rows = read_rows(file)
        if file.name in {"frames.csv", "gaze.csv"}:
            rows = [put_elsewhere(r) if r["xr_time_ns"] in nobody_saw else r for r in rows]
        if rows:
            write(file, [changed(row, unseen) for row in rows])
    return len(unseen.ends_s)


def write(file: Path, rows: list[Row]) -> None:
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def differences(before: Any, after: Any, place: str = "") -> Iterator[str]:
    """Yield the places in which two results differ."""
    if isinstance(before, dict) and isinstance(after, dict):
        for name in before.keys() | after.keys():
            if name not in SAYS_SO:
                yield from differences(before.get(name), after.get(name), f"{place}/{name}")
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for number, each in enumerate(zip(before, after, strict=True)):
            yield from differences(*each, f"{place}/{number}")
    elif not alike(before, after):
        yield f"{place}: {before} became {after}"


def alike(before: Any, after: Any) -> bool:
    try:
        return math.isclose(float(before), float(after), rel_tol=1e-6, abs_tol=1e-6)
    except (TypeError, ValueError):
        return bool(before == after)


def reported(study: Path, out: Path) -> dict[str, Any]:
    """Return what a report says in numbers: results.json, and its tables by their names."""
    plan = out.with_suffix(".toml")
    plan.write_text(PLAN)
    build_report(study, out=out, plan=plan)
    tables = {str(file.relative_to(out)): read_rows(file) for file in out.rglob("*.csv")}
    return {"results.json": json.loads((out / "results.json").read_text()), **tables}


def test_longer_times_without_a_picture_change_nothing(study: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(study, tmp_path / "longer" / study.name)
    assert min(prolong(session) for session in copy.glob("sub-*/ses-*")) >= 4
    before, after = reported(study, tmp_path / "before"), reported(copy, tmp_path / "after")
    assert len(before) > 5
    assert list(differences(before, after)) == []
