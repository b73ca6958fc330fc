"""Each eye through XR_FB_eye_tracking_social, as structures have it: no runtime here has eyes."""

from __future__ import annotations

import numpy as np
import pytest

from vrcomfort.geometry import Pose, yaw_pitch_roll

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from vrcomfort.cli import doctor
from vrcomfort.headset.openxr import actions
from vrcomfort.headset.openxr.capabilities import SystemFacts
from vrcomfort.headset.openxr.instance import Runtime
from vrcomfort.headset.openxr.native import pose_to_xr

LEFT = Pose((-0.03, 1.6, 0.0), yaw_pitch_roll(-0.05, 0.1, 0.0))
RIGHT = Pose((0.03, 1.6, 0.0), yaw_pitch_roll(0.05, 0.1, 0.0))


def found(*, left=True, right=True, time_ns=7):
    gazes = xr.EyeGazesFB(time=time_ns)
    for index, (pose, seen) in enumerate(((LEFT, left), (RIGHT, right))):
        gazes.gaze[index] = xr.EyeGazeFB(is_valid=seen, gaze_pose=pose_to_xr(pose))
    return gazes


def test_what_the_runtime_writes_is_what_is_read(monkeypatch):
    """Through the call that a session makes: space and time go out, both eyes come back."""
    asked = []

    def get(tracker, info, gazes):
        asked.append((tracker, info._obj.time))
        answer = found(right=False)
        gazes._obj.gaze[0], gazes._obj.gaze[1] = answer.gaze[0], answer.gaze[1]
        gazes._obj.time = answer.time
        return 0

    monkeypatch.setattr(xr, "create_eye_tracker_fb", lambda *_: "tracker")
    monkeypatch.setattr(actions, "native_extension", lambda *_: get)
    monkeypatch.setattr(actions, "watched", lambda call, *words: call(*words))
    eyes = actions.EachEye(xr.Instance(), xr.Session())
    (left, right), time_ns = eyes.read(xr.Space(), 1234)
    assert asked == [("tracker", 1234)]
    assert time_ns == 7
    assert np.allclose(left.pose.position, LEFT.position, atol=1e-7)
    assert np.allclose(left.pose.forward, LEFT.forward, atol=1e-6)
    assert (left.valid, right.valid) == (True, False)
    assert left.pupil_mm is None


def test_without_a_combined_gaze_both_eyes_make_one():
    gaze = actions.combined_gaze(actions.eyes_from_xr(found()), 7)
    assert gaze.valid
    assert np.allclose(gaze.pose.position, [0.0, 1.6, 0.0], atol=1e-7)
    # Converging eyes: between them, straight ahead and up.
    assert gaze.pose.forward[0] == pytest.approx(0.0, abs=1e-7)
    assert gaze.pose.forward[1] == pytest.approx(np.sin(0.1), abs=2e-4)
    assert gaze.time_ns == 7


@pytest.mark.parametrize("seen", [{"left": False}, {"right": False}])
def test_one_eye_is_no_gaze_of_both(seen):
    gaze = actions.combined_gaze(actions.eyes_from_xr(found(**seen)), 7)
    assert not gaze.valid
    assert [eye.valid for eye in gaze.eyes] == [seen.get("left", True), seen.get("right", True)]


def test_a_runtime_without_the_extension_has_no_eyes():
    assert not Runtime(xr.Instance(), 1, frozenset()).has_each_eye


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        ({"gaze": False, "each_eye": False}, {"eye tracker": "none"}),
        ({"gaze": True, "each_eye": False}, {"eye tracker": "there", "each eye": "not told apart"}),
        (
            {"gaze": True, "each_eye": True},
            {"eye tracker": "there", "each eye": "XR_FB_eye_tracking_social; no pupils"},
        ),
    ],
)
def test_doctor_says_what_is_known_of_eyes(facts, words):
    findings = doctor._openxr_headset(SystemFacts("headset", (1, 1), **facts))
    told = {each.part: each.found for each in findings if each.part != "headset"}
    assert told == words
