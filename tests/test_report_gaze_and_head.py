"""Gaze and head motion of a study stand on its page where the plan asks, and are those recorded."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from tests.support.recordings import PERIOD_NS
from tests.support.report import build_report, carnegie_like
from vrcomfort.report.exposures import score_exposures
from vrcomfort.report.gaze_and_head import look_at
from vrcomfort.report.gaze_and_head.exposures import read_motion
from vrcomfort.report.plan import read_plan
from vrcomfort.report.study_data import read_study

PLAN = """name = "looked"
title = "Where people looked"
outcomes = ["T"]
[gaze_and_head]
zones = [0.3, 0.6, 1.0]
during = ["shooting"]
spectrum_window_s = 2.0
z_scores = true
"""
SECONDS, AHEAD_DEG, AWAY_DEG = 8.0, 2.0, 20.0
HALF = 0.7
"""Half angles of the images, in radians."""


def recorded(folder, trial: int = 1) -> None:
    """Write 8 s in which the head sways by 5° at 1 Hz, and the eyes look ahead, then away."""
    n = round(SECONDS * 1e9 / PERIOD_NS)
    at_s = np.arange(n) * PERIOD_NS / 1e9
    yaw = np.radians(5 * np.sin(2 * np.pi * at_s))  # to the left, about +Y
    table = pd.DataFrame({
        "session_s": 100.0 * trial + at_s, "xr_time_ns": np.arange(n) * PERIOD_NS,
        "period_ns": PERIOD_NS, "trial": trial, "dropped": 0, "discontinuity": 0,
        "head_x_m": 0.0, "head_y_m": 1.6, "head_z_m": 0.01 * np.sin(2 * np.pi * at_s),
        "head_qx": 0.0, "head_qy": np.sin(yaw / 2), "head_qz": 0.0, "head_qw": np.cos(yaw / 2),
    })  # fmt: skip
    for eye in ("left", "right"):
        for side, sign in (("left", -1), ("right", 1), ("up", 1), ("down", -1)):
            table[f"{eye}_fov_{side}_rad"] = sign * HALF
    table.to_csv(folder / "frames.csv", index=False)
    away = np.radians(np.where(at_s < SECONDS / 2, AHEAD_DEG, AWAY_DEG))
    right = away - yaw  # in the stage
    valid = np.ones(n, dtype=int)
    valid[10:20] = 0
    gaze = pd.DataFrame({
        "session_s": table["session_s"], "xr_time_ns": table["xr_time_ns"], "valid": valid,
        "origin_x_m": 0.0, "origin_y_m": 1.6, "origin_z_m": 0.0,
        "direction_x": np.sin(right), "direction_y": 0.0, "direction_z": -np.cos(right),
    })  # fmt: skip
    gaze.loc[valid == 0, "direction_x"] = np.nan
    gaze.to_csv(folder / "gaze.csv", index=False)
    event = f"onset_s,duration_s,name\n{100 * trial + 4.5},2,shooting\n"
    (folder / "events.csv").write_text(event)


@pytest.fixture
def study(tmp_path):
    folder = carnegie_like(tmp_path / "study").folder
    recorded(folder / "sub-P01" / "ses-1")
    return folder


def found_in(study, text=PLAN):
    data, plan = read_study(study), read_plan(text, None)
    return look_at(data, plan, score_exposures(data, plan), ["dof_off", "dof_on"])


def test_directions_are_those_of_the_eyes_in_the_head(study):
    trial = {"trial": "1", "start_s": "100", "end_s": "190"}
    (motion,) = read_motion(study / "sub-P01" / "ses-1" / "frames.csv", [trial])
    assert motion is not None
    known = motion.in_head[motion.valid]
    angles = np.degrees(np.arctan2(known[:, 0], -known[:, 2]))
    assert sorted(set(np.round(angles, 6))) == [AHEAD_DEG, AWAY_DEG]
    assert np.ptp(motion.head[:, 3]) == pytest.approx(10, abs=0.05)
    assert motion.half_widths[0] == pytest.approx(np.tan(HALF))


def test_shares_fixations_and_spectra_are_those_recorded(study):
    found = found_in(study)
    (row,) = found.exposures
    n = round(SECONDS * 1e9 / PERIOD_NS)
    assert (row["participant"], row["condition"]) == ("P01", "dof_off")
    assert row["gaze_valid_share"] == pytest.approx(1 - 10 / n)
    shares = {(z["situation"], z["zone"]): z["share"] for z in found.zones}
    half = np.tan(np.radians([AHEAD_DEG, AWAY_DEG])) / np.tan(HALF)
    assert half[0] < 0.3 < half[1] < 0.6
    ahead = (n / 2 - 10) / (n - 10)
    assert shares["whole exposure", 0.3] == pytest.approx(ahead, abs=0.003)
    assert shares["whole exposure", 0.6] == 1
    assert shares["shooting", 0.3] == 0  # from 4.5 s to 6.5 s they look away
    # The head's turning moves the gaze by at most 5° × 2π a second: below 32°/s, not below 30.
    # A sine of amplitude 5 has a root mean square of 5/√2.
    assert row["yaw_deg_rms_0.5_2_hz"] == pytest.approx(5 / np.sqrt(2), rel=0.02)
    assert row["head_z_m_rms_0.5_2_hz"] == pytest.approx(0.01 / np.sqrt(2), rel=0.02)
    slow = found_in(study, PLAN + "velocity_deg_s = 32.0\n").exposures[0]
    # a blink between 10 and 20 frames, and one saccade of 18° at 4 s
    assert slow["fixations"] == 3
    assert row["fixations"] > 3
    peak = max((r for r in found.spectra if r["signal"] == "yaw_deg"), key=lambda r: r["density"])
    assert peak["frequency_hz"] == pytest.approx(1.0)
    shown = found.maps["dof_off"]
    assert shown.share.sum() == pytest.approx(1)
    assert {each["condition"] for each in found.z_scores} == {"dof_off", "dof_on"}


def test_a_damaged_recording_is_told_and_left_out(study):
    file = study / "sub-P01" / "ses-1" / "gaze.csv"
    file.write_text(file.read_text().replace(",1,0.0,1.6", ",x,0.0,1.6", 1))
    found = found_in(study)
    assert found.exposures == []
    (note,) = found.notes
    assert note.startswith("sub-P01/ses-1/gaze.csv, line 2, column valid")


@pytest.mark.slow
def test_the_page_has_a_section_where_the_plan_asks(study, tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    made = build_report(study, plan=plan, out=tmp_path / "report")
    page = made.index.read_text()
    assert 'id="gaze"' in page
    assert "standardised within each person" in page
    (row,) = json.loads(made.results.read_text())["gaze_and_head"]["conditions"]
    assert f"{row['yaw_rms_deg']:.3f}" in page
    names = {each.name for each in (*made.tables, *made.figures)}
    wanted = {"gaze_and_head.csv", "gaze_zones.csv", "head_spectra.csv", "z_scores.csv"}
    assert wanted | {"gaze_zones.svg", "gaze_maps.svg", "head_spectra.svg"} <= names
