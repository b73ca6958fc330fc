"""Shipped protocols with every step that they have, and exposures of a second: what is to remain.

The simulated participant feels nothing, so that none leaves, and is quick enough to shoot within a
second. Everything else is the protocol's own.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pandas as pd

from tests.support.study import smoke_with
from vrcomfort.design import build_design
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.protocol import Protocol, load_protocol
from vrcomfort.records import read_manifest
from vrcomfort.resources import data_folder

SHIPPED = sorted(path.stem for path in data_folder("protocols").glob("*.toml"))
EXPOSURE_S = 1.0
FRAMES = 4
"""Of an exposure on the playback headset."""

_FEELS_NOTHING = """
[simulation]
rate_per_min = 0.0
hazard_per_min = 0.0
question_hazard = 0.0
screened_out = 0.0
reaction_s = 0.2
aim_sd_deg = 0.1
aim_lag_s = 0.0
"""


def shortened(name: str, folder: Path) -> Path:
    """Write a shipped protocol for a simulated participant who stays, to be shown for EXPOSURE_S.

    Those of `smoke` are lengthened: a busy machine may show one of 0.1 s in a single frame.
    """
    file = folder / "shortened.toml"
    shipped = data_folder("protocols") / f"{name}.toml"
    if name == "smoke":
        shipped = smoke_with(folder, EXPOSURE_S)
    file.write_text(f'include = ["{shipped}"]\n{_FEELS_NOTHING}', encoding="utf-8")
    assert load_protocol(file).longest_s >= EXPOSURE_S
    return file


def first_person(protocol: Protocol) -> list[str]:
    """Return the options that say of P01 what the protocol has to know of everybody."""
    known = build_design(protocol).simulated_covariates(1)
    return [word for name, value in known.items() for word in ("--covariate", f"{name}={value}")]


def assert_whole(study: Path, protocol: Protocol, rehearsed: Path) -> None:
    """Each session of P01 has all that its protocol asks for, and nothing in it is wrong.

    Parameters
    ----------
    rehearsed
        The same protocol from `simulate --no-draw`: what is asked, and when.
    """
    assert not verify_study(study).faults
    folders = sorted((study / "sub-P01").glob("ses-*"))
    assert folders
    planned = build_design(protocol).plan(1)[0].sessions
    for folder, trials in zip(folders, planned, strict=False):  # a runtime shows the first alone
        assert read_manifest(folder)["status"] == "completed"
        other = rehearsed / "sub-P01" / folder.name
        assert _asked(folder) == _asked(other)
        assert len(_table(folder, "trials")) == len(trials)
        assert _column(folder, "trials", "condition") == _column(other, "trials", "condition")
        assert set(_column(folder, "ratings", "trial")) == set(_column(other, "ratings", "trial"))
        _assert_frames(folder, protocol)
        _assert_tasks(folder, other)
        _assert_gaze(folder, protocol)


def _table(folder: Path, name: str) -> pd.DataFrame:
    return pd.read_csv(folder / f"{name}.csv", keep_default_na=False)


def _column(folder: Path, name: str, column: str) -> list[object]:
    return _table(folder, name)[column].tolist()


def _asked(folder: Path) -> list[tuple[object, ...]]:
    columns = ["trial", "timepoint", "instrument", "item"]
    return sorted(map(tuple, _table(folder, "questionnaires")[columns].astype(str).to_numpy()))


def _assert_frames(folder: Path, protocol: Protocol) -> None:
    trials, frames = _table(folder, "trials"), _table(folder, "frames")
    assert set(trials["status"]) == {"completed"}
    counted = Counter(frames["trial"])
    for row in trials.itertuples():
        shown = frames[frames["trial"] == row.trial]
        assert counted[row.trial] == row.frames > 0
        assert float(row.end_s) > float(row.start_s)
        effects = protocol.condition(row.condition)
        if effects.depth_of_field is not None:
            assert (shown["focus_m"] != "").all()
            assert (shown["max_blur_px"].astype(float) > 0).all()
    trained = bool(protocol.training_s)  # an image is kept of its first frame, not of the trial's
    assert set(_column(folder, "images", "trial")) >= set(trials["trial"][int(trained) :])
    assert (counted[0] > 0) == (trained or protocol.gaze_validation is not None)


def _assert_tasks(folder: Path, rehearsed: Path) -> None:
    """Assert that each trial with a task was scored, and that what can be shot was shot at."""
    assert (folder / "tasks.csv").exists() == (rehearsed / "tasks.csv").exists()
    if not (folder / "tasks.csv").exists():
        return
    done, other = _table(folder, "tasks"), _table(rehearsed, "tasks")
    scored = done[done["kind"] == "trial"]
    wanted = other[other["kind"] == "trial"]
    assert scored[["trial", "task"]].to_numpy().tolist() == (
        wanted[["trial", "task"]].to_numpy().tolist()
    )
    shots = done[done["kind"] == "shot"]
    assert len(shots) > 0
    assert shots["hit"].astype(int).sum() > 0
    met = done[done["kind"] == "target"]["hit"].astype(int).sum()
    assert met == scored["hits"].astype(int).sum()


def _assert_gaze(folder: Path, protocol: Protocol) -> None:
    """Assert that simulated eyes have a row a frame, and were validated where that is asked."""
    looks = protocol.simulation.eyes is not None
    assert (folder / "gaze.csv").exists() == looks
    if looks:
        gaze, frames = _table(folder, "gaze"), _table(folder, "frames")
        assert gaze["xr_time_ns"].tolist() == frames["xr_time_ns"].tolist()
        seen = gaze[(gaze["valid"] == 1) & (frames["should_render"] == 1)]
        assert len(seen) > 0.5 * len(gaze)
        assert (seen["left_valid"] == 1).all()
        met = seen[(seen["hit_node"] != "").to_numpy() & (frames["trial"] > 0)[seen.index]]
        assert len(met) > 0  # in a room, not in the sky
    settings = protocol.gaze_validation
    assert (folder / "gaze_validation.csv").exists() == (settings is not None)
    if settings is not None:
        rows = _table(folder, "gaze_validation")
        points = set(rows[rows["point"] != ""]["point"].astype(int))
        assert points == set(range(1, len(settings.points) + 1))
        assert set(rows["eye"]) == {"combined", "left", "right"}
        means = rows[(rows["point"] == "") & (rows["eye"] == "combined")]
        assert means["good"].tolist()[-1] == "1"
