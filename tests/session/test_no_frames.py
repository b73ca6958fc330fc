"""Simulated sessions without frames: the same people and answers, and no time spent."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.support.session import go, manifest, rows
from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.api.simulation import simulate_sessions
from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.geometry import rotate
from vrcomfort.protocol import load_protocol
from vrcomfort.records.json_file import indented
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.session import NoPictures, StillHeadset
from vrcomfort.traces.gaze_quality import angles_deg


def simulated(tmp_path, study, **more):
    protocol = tiny_protocol(tmp_path)
    person = SimulatedRespondent(protocol.simulation, participant="P01", seed=0)
    return go(tmp_path, person, study=study, **more)


@pytest.mark.slow
def test_answers_and_ratings_are_those_of_a_session_with_frames(tmp_path):
    simulated(tmp_path, "S")
    simulated(tmp_path, "J", headset=StillHeadset, renderer=NoPictures(), jumps=True)
    for session in (1, 2):
        with_frames = rows(tmp_path, "questionnaires.csv", session)
        without = rows(tmp_path, "questionnaires.csv", session, "J")
        said = [(row["trial"], row["item"], row["response"]) for row in with_frames]
        assert [(row["trial"], row["item"], row["response"]) for row in without] == said
        seen = rows(tmp_path, "ratings.csv", session)
        jumped = rows(tmp_path, "ratings.csv", session, "J")
        assert [row["response"] for row in jumped] == [row["response"] for row in seen]
        assert len(jumped) == 4  # two exposures of 10 s, asked every 3 s with 2 s to answer
        for a, b in zip(seen, jumped, strict=True):
            # A question waits for a frame, and an answer for another; here nothing does.
            assert float(a["onset_s"]) == pytest.approx(float(b["onset_s"]), abs=0.5)
    assert not verify_study(tmp_path / "J").faults


def test_exposures_last_as_long_and_have_no_frames(tmp_path):
    simulated(tmp_path, "S", headset=StillHeadset, renderer=NoPictures(), jumps=True)
    for row in rows(tmp_path, "trials.csv"):
        assert float(row["end_s"]) - float(row["start_s"]) == pytest.approx(10.0)
        assert (row["frames"], row["live_s"]) == ("0", "10.0")
    assert rows(tmp_path, "frames.csv") == []
    assert manifest(tmp_path)["headset"]["name"] == "none"


def test_whoever_withdraws_does_so_at_their_own_moment(tmp_path):
    text = PROTOCOL + "\n[simulation]\nrate_per_min = 600.0\nhazard_per_min = 1000.0\n"
    protocol = tiny_protocol(tmp_path, text)
    (outcome,) = simulate_sessions(
        protocol, participants=1, out=tmp_path / "W", seed=None,
        size_px=(16, 16), exposure_s=None, frames=False,
    )  # fmt: skip
    assert outcome.status == "withdrawn"
    (trial,) = rows(tmp_path, "trials.csv", study="W")
    assert trial["status"] == "withdrawn"
    assert 0 < float(trial["end_s"]) - float(trial["start_s"]) < 10


def test_a_study_without_frames_goes_on_without_frames_alone(tmp_path):
    play = {"size_px": (32, 40), "out": tmp_path / "study"}
    protocol = load_protocol("carnegie_2015")
    simulate_sessions(protocol, participants=1, frames=False, **play)
    with pytest.raises(InputError, match="begun with --no-draw"):
        simulate_sessions(protocol, participants=2, **play)
    more = simulate_sessions(protocol, participants=2, frames=False, **play)
    assert [each.participant for each in more] == ["P02"]
    with pytest.raises(InputError, match="plays no head trace"):
        simulate_sessions(protocol, participants=3, refresh_hz=20.0, frames=False, **play)


def test_a_task_is_done_without_frames_and_its_rows_are_whole(tmp_path):
    protocol = load_protocol("hillaire_2008")
    simulate_sessions(
        protocol,
        participants=1,
        frames=False,
        exposure_s=15.0,
        size_px=(16, 16),
        out=tmp_path / "S",
    )
    assert rows(tmp_path, "frames.csv") == []
    found = rows(tmp_path, "tasks.csv")
    sums = [row for row in found if row["kind"] == "trial"]
    trials = [row["trial"] for row in rows(tmp_path, "trials.csv")]
    assert [row["trial"] for row in sums] == trials
    assert len(trials) > 1
    for row in sums:
        own = [each for each in found if each["trial"] == row["trial"]]
        assert int(row["shots"]) == sum(each["kind"] == "shot" for each in own) > 0
        assert int(row["hits"]) == sum(
            each["kind"] == "target" and each["hit"] == "1" for each in own
        )
        assert row["deaths"] != ""
    assert not verify_study(tmp_path / "S").faults


def test_heads_of_simulated_eyes_turn_to_what_they_are_to_look_at(tmp_path):
    """So they look closer to the middle of the view the more there is to shoot (Hillaire 2008)."""
    protocol = load_protocol("hillaire_2008_gaze")
    shown = {"exposure_s": 2.0, "size_px": (16, 16)}
    simulate_sessions(protocol, participants=1, frames=False, out=tmp_path / "S", **shown)
    frames, gaze = (rows(tmp_path, name) for name in ("frames.csv", "gaze.csv"))
    aside_deg = {"1": [], "3": []}  # navigation, and four opponents
    for frame, look in zip(frames, gaze, strict=True):
        if look["valid"] == "1" and frame["trial"] in aside_deg:
            head = [float(frame[f"head_q{axis}"]) for axis in "xyzw"]
            ahead = rotate(head, [0.0, 0.0, -1.0])
            way = [float(look[f"direction_{axis}"]) for axis in "xyz"]
            aside_deg[frame["trial"]].append(float(angles_deg(ahead, np.array(way))))
    medians = {trial: np.median(found) for trial, found in aside_deg.items()}
    assert medians["3"] < 0.5 * medians["1"]
    turned = [{frame["head_qy"] for frame in frames if frame["trial"] == k} for k in aside_deg]
    assert len(turned[0]) == 1 < len(turned[1])
    assert not verify_study(tmp_path / "S").faults


def test_ratings_can_come_at_the_beginning_and_at_the_end(tmp_path):
    text = PROTOCOL.replace("every_s = 3.0", "every_s = 3.0\nat_start = true\nat_end = true")
    assert text != PROTOCOL
    protocol = tiny_protocol(tmp_path, text)
    simulate_sessions(
        protocol, participants=1, out=tmp_path / "R", size_px=(16, 16), frames=False
    )  # fmt: skip
    trials = rows(tmp_path, "trials.csv", study="R")
    asked = rows(tmp_path, "ratings.csv", study="R")
    due = [
        float(row["onset_s"]) - float(trials[0]["start_s"]) for row in asked if row["trial"] == "1"
    ]
    assert due == pytest.approx([0.0, 3.0, 6.0, 8.0])  # 10 s, with 2 s to answer


def test_a_manifest_is_written_as_json_writes_it():
    content = {"a": {"b": [1, 2.5, None, 'ü\n"x"'], "c": {}}, "d": [], "e": True, "f": [[1], {}]}
    for _ in range(2):  # the second from what was written before
        assert indented(content) == json.dumps(content, indent=2, ensure_ascii=False)
