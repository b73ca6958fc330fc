"""Gaze and head motion of a study stand on its page where the plan asks, and are those recorded."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from tests.support import gazed
from tests.support.places import ROOT
from tests.support.recordings import PERIOD_NS
from tests.support.report import build_report, carnegie_like
from vrcomfort.errors import InputError
from vrcomfort.recordings import pack_study
from vrcomfort.records.recording import Memory
from vrcomfort.report.gaze_and_head import analyse_gaze_and_head
from vrcomfort.report.gaze_and_head.exposures import read_motion
from vrcomfort.report.plan_files import read_plan
from vrcomfort.report.study_data import read_study, with_frames

PLAN = """name = "looked"
title = "Where people looked"
outcomes = ["T"]
z_scores = ["T"]
[gaze_and_head]
zones = [0.3, 0.6, 1.0]
during = ["shot"]
during_s = 2.0
spectrum_window_s = 2.0
"""
DOCUMENTED = ROOT / "docs" / "plans" / "gaze_and_head.toml"
SECONDS, AHEAD_DEG, AWAY_DEG = 5.0, 2.0, 20.0
HALF = 0.7
"""Half angles of the images, in radians."""
N = round(SECONDS * 1e9 / PERIOD_NS)


def recorded(folder, *, avatar_deg=0.0, ahead_share=0.5, trial=1):
    """Write 5 s in which the head sways by 5° at 1 Hz, and the eyes look ahead, then away."""
    at_s = np.arange(N) * PERIOD_NS / 1e9
    yaw = np.radians(5 * np.sin(2 * np.pi * at_s))  # to the left, about +Y
    turn = np.radians(avatar_deg) / 2
    table = pd.DataFrame({
        "session_s": 100.0 * trial + at_s, "xr_time_ns": np.arange(N) * PERIOD_NS,
        "period_ns": PERIOD_NS, "trial": trial, "dropped": 0, "discontinuity": 0,
        "head_x_m": 0.0, "head_y_m": 1.6, "head_z_m": 0.01 * np.sin(2 * np.pi * at_s),
        "head_qx": 0.0, "head_qy": np.sin(yaw / 2), "head_qz": 0.0, "head_qw": np.cos(yaw / 2),
        "avatar_x_m": 3.0, "avatar_y_m": 0.0, "avatar_z_m": 0.0, "avatar_qx": 0.0,
        "avatar_qy": -np.sin(turn), "avatar_qz": 0.0, "avatar_qw": np.cos(turn),
    })  # fmt: skip
    for eye in ("left", "right"):
        for side, sign in (("left", -1), ("right", 1), ("up", 1), ("down", -1)):
            table[f"{eye}_fov_{side}_rad"] = sign * HALF
    table.to_csv(folder / "frames.csv", index=False)
    away = np.radians(np.where(at_s < SECONDS * ahead_share, AHEAD_DEG, AWAY_DEG))
    right = away - yaw  # in the stage
    valid = np.ones(N, dtype=int)
    valid[10:20] = 0
    gaze = pd.DataFrame({
        "session_s": table["session_s"], "xr_time_ns": table["xr_time_ns"], "valid": valid,
        "origin_x_m": 0.0, "origin_y_m": 1.6, "origin_z_m": 0.0,
        "direction_x": np.sin(right), "direction_y": 0.0, "direction_z": -np.cos(right),
    })  # fmt: skip
    gaze.loc[valid == 0, "direction_x"] = np.nan
    gaze.to_csv(folder / "gaze.csv", index=False)
    event = f"onset_s,duration_s,name\n{100 * trial + 2.75},,shot\n"
    (folder / "events.csv").write_text(event)


@pytest.fixture
def study(tmp_path):
    folder = carnegie_like(tmp_path / "study", people=4).folder
    recorded(folder / "sub-P01" / "ses-1")
    return folder


def found_in(study, text=PLAN, *, read=read_study):
    plan = read_plan(text, None)
    return analyse_gaze_and_head(read(study), plan.gaze_and_head, ["dof_off", "dof_on"])


def shares_of(found):
    return {(z.situation, z.during, z.zone): z.share for z in found.zones}


def test_directions_are_those_of_the_eyes_in_the_head_and_in_the_world(tmp_path):
    recorded(tmp_path, avatar_deg=30.0)
    trial = {"trial": "1", "start_s": "100", "end_s": "190"}
    (motion,) = read_motion(tmp_path / "frames.csv", [trial])
    assert motion is not None
    known = motion.in_head[motion.valid]
    angles = np.degrees(np.arctan2(known[:, 0], -known[:, 2]))
    assert sorted(set(np.round(angles, 6))) == [AHEAD_DEG, AWAY_DEG]
    assert np.ptp(motion.head[:, 3]) == pytest.approx(10, abs=0.05)
    assert motion.half_widths[0] == pytest.approx(np.tan(HALF))
    # The avatar has turned by 30° to the right: so has everything in the world.
    first = motion.in_world[0]
    assert np.degrees(np.arctan2(first[0], -first[2])) == pytest.approx(30 + AHEAD_DEG)
    assert np.degrees(np.arctan2(motion.forward[0][0], -motion.forward[0][2])) == pytest.approx(30)
    assert motion.place[0] == pytest.approx([3, 1.6, 0])


def test_frames_without_a_known_head_are_left_out_and_cuts_before_them_stay(tmp_path):
    recorded(tmp_path)
    table = pd.read_csv(tmp_path / "frames.csv")
    table["head_valid"] = 1
    table.loc[100:104, "head_valid"] = 0
    table.loc[102, "discontinuity"] = 1
    table.loc[200, "head_x_m"] = np.nan
    table.to_csv(tmp_path / "frames.csv", index=False)
    trial = {"trial": "1", "start_s": "100", "end_s": "190"}
    (motion,) = read_motion(tmp_path / "frames.csv", [trial])
    assert len(motion.time_s) == N - 6
    assert np.flatnonzero(motion.cuts).tolist() == [0, 100]


def test_shares_fixations_and_spectra_are_those_recorded(study):
    found = found_in(study, read=lambda folder: with_frames(read_study(folder)))
    (row,) = found.exposures
    assert (row.keys.participant, row.keys.condition, row.keys.scene) == (
        "P01",
        "dof_off",
        "temple",
    )
    assert row.gaze_valid_share == pytest.approx(1 - 10 / N)
    half = np.tan(np.radians([AHEAD_DEG, AWAY_DEG])) / np.tan(HALF)
    assert half[0] < 0.3 < half[1] < 0.6
    ahead = (N / 2 - 10) / (N - 10)
    shares = shares_of(found)
    assert shares["dof_off", "", 0.3] == pytest.approx(ahead, abs=0.003)
    assert shares["dof_off", "", 0.6] == 1
    assert shares["dof_off", "shot", 0.3] == 0  # from 2.75 s to 4.75 s they look away
    assert row.zones.zone_of_75_percent == pytest.approx(half[1])
    # A sine of amplitude 5 has a root mean square of 5/√2; the bins at the edges count half.
    assert row.bands.rms["yaw_deg_rms_0.5_2_hz"] == pytest.approx(5 / np.sqrt(2), rel=0.05)
    assert row.bands.rms["head_z_m_rms_0.5_2_hz"] == pytest.approx(0.01 / np.sqrt(2), rel=0.05)
    # The head's turning moves the gaze by at most 5° × 2π a second: below 32°/s, not below 30.
    slow = found_in(study, PLAN + "velocity_deg_s = 32.0\n")
    # A blink between 10 and 20 frames, and one saccade of 18° at 2.5 s.
    assert slow.exposures[0].fixations.fixations == len(slow.fixations) == 3
    assert row.fixations.fixations > 3
    peak = max((r for r in found.spectra if r.signal == "yaw_deg"), key=lambda r: r.density)
    assert peak.frequency_hz == pytest.approx(1.0)
    assert found.maps["dof_off"].share.sum() == pytest.approx(1)
    # 5° and 1 cm there and back: four amplitudes a second.
    assert row.head_turning_deg_per_min == pytest.approx(60 * 20, rel=0.01)
    assert row.head_path_m_per_min == pytest.approx(60 * 0.04, rel=0.01)


def test_shots_of_a_task_are_events(study):
    session = study / "sub-P01" / "ses-1"
    (session / "events.csv").unlink()
    rows = ["participant,trial,condition,kind,onset_s", "P01,1,dof_off,target,100.1"]
    rows += ["P01,1,dof_off,shot,100.5", "P01,1,dof_off,shot,102.75"]
    (session / "tasks.csv").write_text("\n".join(rows) + "\n")
    shares = shares_of(found_in(study))
    # Two seconds of looking ahead (the blink is before), two of looking away.
    assert shares["dof_off", "shot", 0.3] == pytest.approx(0.5, abs=0.01)


def test_every_person_counts_alike(study):
    recorded(study / "sub-P01" / "ses-2", ahead_share=1.0, trial=2)
    recorded(study / "sub-P03" / "ses-1", ahead_share=1.0)
    recorded(study / "sub-P03" / "ses-2", ahead_share=1.0, trial=2)
    found = found_in(study, PLAN.replace("[0.3, 0.6, 1.0]", "[0.3]"))
    rows = {(z.situation, z.during): z for z in found.zones}
    ahead = (N / 2 - 10) / (N - 10)
    met = {(row.keys.participant, row.keys.condition) for row in found.exposures}
    assert len(met) == len(found.exposures) == 4
    everybody = rows["", ""]
    # P01: one exposure of each kind; P03: all ahead.
    assert everybody.share == pytest.approx(((ahead + 1) / 2 + 1) / 2, abs=0.003)
    assert everybody.people == 2
    spread = abs((ahead + 1) / 2 - 1) / 2  # half the difference of two
    assert everybody.standard_error == pytest.approx(spread, abs=0.003)
    assert [s.people for s in found.situations] == [2, 2]


def test_a_map_of_fixations_is_one_scenes_from_one_place(study):
    recorded(study / "sub-P03" / "ses-1", avatar_deg=90.0)
    file = study / "sub-P04" / "ses-1" / "frames.csv"
    recorded(file.parent)
    table = pd.read_csv(file)
    table["head_x_m"] = 5.0
    table.to_csv(file, index=False)
    found = found_in(study, PLAN + "velocity_deg_s = 40.0\n")
    (view,) = found.viewpoints
    assert view.row.scene == "temple"
    # P04's head is five metres away.
    assert (view.row.exposures, view.row.elsewhere) == (2, 1)
    assert view.row.position_m == pytest.approx([3, 1.6, 0], abs=1e-6)
    assert view.row.centre_deg == pytest.approx(45, abs=0.5)  # between 0° and 90° to the right
    azimuth, share = view.map.azimuth_deg, view.map.share.sum(axis=0)
    # P01's fixations at 2° and 20° of the world are 43° and 25° left of the middle; the fixations
    # at 92° and 110° of P03 47° to the right, and outside.
    assert share[azimuth < 0].sum() == pytest.approx(2 * share[azimuth > 0].sum(), rel=0.15)
    assert view.map.outside == pytest.approx(0.25, abs=0.03)


def on_nodes(session, names, *, undrawn=0):
    """Name what is under the gaze of a recording, frame by frame; the last are not drawn."""
    gaze = pd.read_csv(session / "gaze.csv", dtype=str)
    gaze["hit_node"] = names
    gaze.to_csv(session / "gaze.csv", index=False)
    frames = pd.read_csv(session / "frames.csv")
    frames["should_render"] = (np.arange(N) < N - undrawn).astype(int)
    frames.to_csv(session / "frames.csv", index=False)


def nodes_of(found):
    return {(row.situation, row.node): row for row in found.nodes}


def test_the_share_of_each_node_is_that_of_the_time_in_which_the_gaze_was_known(study):
    session = study / "sub-P01" / "ses-1"
    # The gaze is not valid from 10 to 20, whatever the cells say, and the last 40 are not drawn.
    names = np.array(["a tree, tall"] * 110 + ["door"] * 100 + [""] * (N - 210))
    on_nodes(session, names, undrawn=40)
    rows = nodes_of(found_in(study))
    counted = N - 10 - 40
    assert [row.node for row in rows.values()][-1] == ""
    for name, frames in (("a tree, tall", 100), ("door", 100), ("", counted - 200)):
        row = rows["dof_off", name]
        assert row.share == pytest.approx(frames / counted)
        assert (row.standard_error, row.people) == (None, 1)


def test_people_who_never_looked_at_a_node_count_as_zero(study):
    recorded(study / "sub-P01" / "ses-2", trial=2)
    recorded(study / "sub-P03" / "ses-1")
    recorded(study / "sub-P04" / "ses-1")  # without a column of nodes
    on_nodes(study / "sub-P01" / "ses-1", "door")
    on_nodes(study / "sub-P01" / "ses-2", "tree")
    on_nodes(study / "sub-P03" / "ses-1", "tree")
    found = found_in(study)
    met = {(row.keys.participant, row.keys.condition) for row in found.exposures}
    assert met == {("P01", "dof_off"), ("P03", "dof_off"), ("P01", "dof_on"), ("P04", "dof_on")}
    said = {at: (row.share, row.people) for at, row in nodes_of(found).items()}
    assert said["dof_off", "door"] == said["dof_off", "tree"] == (0.5, 2)
    assert said["dof_on", "tree"] == (1.0, 1)  # P04's nodes are not known


def test_few_nodes_are_shown_and_the_others_summed(study):
    session = study / "sub-P01" / "ses-1"
    lengths = np.arange(14) + 5
    names = np.concatenate([np.repeat([f"n{k:02d}" for k in range(14)], lengths), [""] * N])[:N]
    recorded(session)
    on_nodes(session, np.roll(names, 30))
    found = found_in(study)
    rows = [row for row in found.results.nodes if row.situation == "dof_off"]
    most = [f"n{k:02d}" for k in range(13, 3, -1)]
    assert [row.node for row in rows] == [*most, "", "4 others"]
    assert sum(row.share for row in rows) == pytest.approx(1)
    assert rows[-1].share == pytest.approx((5 + 6 + 7 + 8) / (N - 10))
    assert len(found.nodes) == 15


def test_a_packed_recording_says_the_same_of_nodes(study):
    names = np.array(["door", "a tree, tall", ""])[np.arange(N) // 7 % 3]
    on_nodes(study / "sub-P01" / "ses-1", names)
    rows = found_in(study).nodes
    assert list(pack_study(study, Memory()))
    assert (study / "sub-P01" / "ses-1" / "gaze.parquet").is_file()
    assert found_in(study).nodes == rows


@pytest.mark.parametrize("names", [None, ""])
def test_without_names_of_nodes_there_is_no_table_of_them(study, names):
    if names is not None:
        on_nodes(study / "sub-P01" / "ses-1", names)
    found = found_in(study)
    assert (len(found.exposures), found.nodes, found.shown) == (1, [], [])


def test_situations_can_be_scenes(study):
    plan = PLAN + 'situations = "scene"\n'
    assert {z.situation for z in found_in(study, plan).zones} == {"temple"}


def test_situations_can_be_tasks(study):
    plan = (
        PLAN + 'situations = "task"\n[gaze_and_head.labels]\nnone = "Navigation"\nshoot = "Fight"\n'
    )
    assert {z.situation for z in found_in(study, plan).zones} == {"Navigation"}
    rows = ["participant,session,trial,condition,task,kind,onset_s"]
    rows += ["P01,1,1,dof_off,shoot,shot,100.5"]
    (study / "sub-P01" / "ses-1" / "tasks.csv").write_text("\n".join(rows) + "\n")
    assert {z.situation for z in found_in(study, plan).zones} == {"Fight"}


def test_a_damaged_recording_is_told_and_left_out(study):
    file = study / "sub-P01" / "ses-1" / "gaze.csv"
    file.write_text(file.read_text().replace(",1,0.0,1.6", ",x,0.0,1.6", 1))
    found = found_in(study)
    assert found.exposures == []
    (note,) = found.notes
    assert note.startswith("sub-P01/ses-1/gaze.csv, line 2, column valid")


def test_z_scores_are_of_outcomes_of_the_plan():
    with pytest.raises(InputError, match=r"`N` is not among the outcomes"):
        read_plan(PLAN.replace('z_scores = ["T"]', 'z_scores = ["N"]'), None)


@pytest.mark.slow
def test_the_page_has_a_section_where_the_plan_asks(tmp_path):
    study = gazed.write(tmp_path / "study", people=6, seconds=6.0)
    made = build_report(study, plan=DOCUMENTED, out=tmp_path / "report", forms=("svg",))
    page = made.index.read_text()
    assert 'id="gaze"' in page
    assert "standardised within each person" in page
    results = json.loads(made.results.read_text())
    for row in results["gaze_and_head"]["nodes"]:
        share, error = 100 * row["share"], 100 * row["standard_error"]
        assert f"<td>{share:.1f} % ± {error:.1f}</td>" in page
    assert {row["node"] for row in results["gaze_and_head"]["nodes"]} == {
        "door",
        "left wall",
        "right wall",
        "floor",
        "",
    }
    assert "<td>nothing (the sky)</td>" in page
    rows = results["gaze_and_head"]["situations"]
    assert [row["people"] for row in rows] == [6, 6]
    assert all(f"{row['yaw_deg_rms_0.5_2_hz']:.3f}" in page for row in rows)
    at_a_quarter = {
        (row["situation"], row["during"]): row["share"]
        for row in results["gaze_and_head"]["zones"]
        if row["zone"] == 0.25
    }
    assert at_a_quarter["still", "shot"] > at_a_quarter["still", ""] + 0.05
    assert [(each["n"], each["people"]) for each in results["z_scores"]] == [(12, 6), (12, 6)]
    assert "gaze_validation_error_deg" in results["mixed_models"][0]["terms"]
    names = {path.name for path in (*made.tables, *made.figures)}
    assert names >= {
        "gaze_and_head.csv", "gaze_zones.csv", "gaze_nodes.csv", "fixations.csv",
        "head_spectra.csv", "z_scores.csv",
        "gaze_zones.svg", "gaze_maps.svg", "gaze_fixations.svg", "head_spectra.svg",
        "standardised.svg",
    }  # fmt: skip
