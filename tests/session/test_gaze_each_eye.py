"""Gaze of each eye: recorded, played back, validated and simulated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.session.test_gaze_validation import PROTOCOL, Ahead, do
from tests.support.study import Scripted, frame, read_rows
from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.frame import MEAN_IPD_M
from vrcomfort.geometry import EyeGaze, Gaze, Pose, normalize, turn_to, yaw_pitch_roll
from vrcomfort.protocol.simulation import SimulatedEyes
from vrcomfort.records import FrameRow, GazeRow, Recorder
from vrcomfort.respondent.simulated_eyes import EyePair
from vrcomfort.traces.gaze_quality import angles_deg
from vrcomfort.traces.gaze_track import read_gaze


def looking(index: int) -> Gaze:
    """The left eye alone in every third frame, no eye in every fifth; the right has no pupil."""
    both = Pose((0.0, 1.6, 0.0), yaw_pitch_roll(0.01 * index, 0.0, 0.0))
    left = Pose((-0.03, 1.6, 0.0), yaw_pitch_roll(0.01 * index - 0.02, 0.0, 0.0))
    right = Pose((0.03, 1.6, 0.0), yaw_pitch_roll(0.01 * index + 0.02, 0.0, 0.0))
    shut = index % 5 == 4
    one = EyeGaze(left, valid=not shut, pupil_mm=None if shut else 3.0 + 0.1 * index)
    other = EyeGaze(right, valid=not shut and index % 3 != 2)
    return Gaze(both, valid=one.valid and other.valid, eyes=(one, other))


def written(folder, gazes):
    with Recorder(folder, "P1", 1) as recorder:
        for index, gaze in enumerate(gazes):
            shown = frame(index)
            time_ns = shown.predicted_display_time_ns + 1
            row = FrameRow(
                0.1 * index, time_ns, 100, 1, True, shown.head_pose, *shown.views,
                shown.avatar_pose, gaze=GazeRow(0.1 * index, time_ns, gaze),
            )  # fmt: skip
            recorder.write(row)
    return recorder.folder / "gaze.csv"


def test_each_eye_is_played_back_as_it_was_recorded(tmp_path):
    file = written(tmp_path, [looking(index) for index in range(20)])
    track = read_gaze(file)
    for index, row in enumerate(read_rows(file)):
        wanted, seen = looking(index), track.at(int(row["xr_time_ns"]))
        assert seen.valid == wanted.valid
        for eye, other in zip(seen.eyes, wanted.eyes, strict=True):
            assert (eye.valid, eye.pupil_mm) == (other.valid, other.pupil_mm)
            if other.valid:
                assert np.array_equal(eye.pose.position, other.pose.position)
                assert np.allclose(eye.pose.forward, other.pose.forward, atol=1e-15)
    assert {row["right_pupil_mm"] for row in read_rows(file)} == {""}


def test_a_tracker_that_tells_no_eye_apart_leaves_blanks(tmp_path):
    file = written(tmp_path, [replace(looking(index), eyes=(None, None)) for index in range(3)])
    for row in read_rows(file):
        assert {cell for name, cell in row.items() if name.startswith(("left_", "right_"))} == {""}
    assert read_gaze(file).eyes == (None, None)
    only_left = [replace(looking(index), eyes=(looking(index).eyes[0], None)) for index in range(3)]
    left, right = read_gaze(written(tmp_path / "left", only_left)).at(1).eyes
    assert left.valid
    assert right is None


@pytest.mark.parametrize(
    ("column", "cell", "message"),
    [
        ("left_direction_x", "2.0", "line 2.*direction has length"),
        ("left_origin_y_m", "", "line 2.*left_origin_y_m.*empty"),
        ("left_pupil_mm", "-1.0", "line 2.*a pupil has a diameter above 0 mm"),
        ("left_pupil_mm", "wide", "line 2.*not a finite number"),
    ],
)
def test_a_wrong_eye_is_refused_with_its_place(tmp_path, column, cell, message):
    file = written(tmp_path, [looking(0)])
    header, row = (line.split(",") for line in file.read_text().splitlines())
    row[header.index(column)] = cell
    file.write_text(",".join(header) + "\n" + ",".join(row) + "\n")
    with pytest.raises(InputError, match=message):
        read_gaze(file)


def test_half_of_the_columns_of_an_eye_is_told(tmp_path):
    file = written(tmp_path, [looking(0)])
    file.write_text(file.read_text().replace("left_pupil_mm", "pupil"))
    with pytest.raises(InputError, match="'left_pupil_mm' is missing although"):
        read_gaze(file)


def off_by(right_deg: float) -> Pose:
    return Pose(orientation=yaw_pitch_roll(-np.radians(right_deg), 0.0, 0.0))


class TwoEyes(Ahead):
    """A tracker whose left eye is 0.5° off to the right, and whose right eye is never seen.

    Both look at a point straight ahead of the head, 1 m away.
    """

    def frames(self):
        for each in super().frames():
            left = each.head_pose @ Pose((-0.03, 0.0, 0.0))
            ahead = (each.head_pose @ Pose((0.0, 0.0, -1.0))).position
            way = Pose(left.position, turn_to(normalize(ahead - left.position))) @ off_by(0.5)
            eyes = EyeGaze(way), EyeGaze(Pose(), valid=False)
            yield replace(each, gaze=Gaze(each.head_pose, eyes=eyes))


def test_a_validation_says_how_far_each_eye_is_off(tmp_path):
    text = PROTOCOL.replace("[gaze_validation]", "[gaze_validation]\nattempts = 1")
    text = text.replace("[0.0, 0.0, 1.0], [10.0, 0.0, 1.0], [0.0, 8.0, 2.0], [-10.0, -5.0, 3.0]",
                        "[0.0, 0.0, 1.0]")  # fmt: skip
    still = text.replace("[gaze_validation]", "[gaze_validation]\nlimit_deg = 5.0")
    do(tmp_path, still, headset=TwoEyes, respondent=Scripted())
    found = read_rows(tmp_path / "S/sub-P01/ses-1/gaze_validation.csv")
    by_eye = {row["eye"]: row for row in found if row["validation"] == "1" and not row["point"]}
    assert list(by_eye) == ["combined", "left", "right"]
    # The head turns a little while the point stands: both are off by that, one by 0.5 besides.
    both, left = (float(by_eye[eye]["accuracy_deg"]) for eye in ("combined", "left"))
    assert abs(abs(left - both) - 0.5) < 0.25
    assert by_eye["right"]["accuracy_deg"] == ""
    assert by_eye["right"]["valid_percent"] == "0.0"
    assert [by_eye[eye]["good"] for eye in by_eye] == ["1", "", ""]
    assert not verify_study(tmp_path / "S").faults


def test_simulated_trackers_are_off_differently_for_each_eye(tmp_path):
    text = PROTOCOL.replace(
        "error_deg = 0.0", "error_deg = 0.0\neye_error_deg = 0.8\nnoise_deg = 0.0"
    )
    do(tmp_path, text)
    found = read_rows(tmp_path / "S/sub-P01/ses-1/gaze_validation.csv")
    means = {row["eye"]: float(row["accuracy_deg"]) for row in found if not row["point"]}
    # Both eyes together wander by 0.15° alone; each has its own offset besides.
    assert means["combined"] < 0.4
    assert means["left"] > means["combined"] + 0.2
    assert means["right"] > means["combined"] + 0.2
    assert means["left"] != pytest.approx(means["right"], abs=0.02)
    gaze = read_rows(tmp_path / "S/sub-P01/ses-1/gaze.csv")
    pupils = [float(row["left_pupil_mm"]) for row in gaze if row["left_valid"] == "1"]
    assert np.mean(pupils) == pytest.approx(4.0, abs=0.02)
    assert {row["left_valid"] for row in gaze} == {"0", "1"}  # blinks


def test_simulated_eyes_converge_on_what_they_look_at():
    settings = SimulatedEyes(noise_deg=0.0)
    pair = EyePair(settings, np.random.default_rng(1), np.zeros((2, 2)))
    head = Pose((0.2, 1.6, 0.1), yaw_pitch_roll(0.3, -0.1, 0.05))
    point = (head @ Pose((0.1, 0.05, -0.6))).position
    left, right = pair.look(head, point)
    apart = left.pose.position - right.pose.position
    assert np.linalg.norm(apart) == pytest.approx(MEAN_IPD_M)
    for eye in (left, right):
        wanted = normalize(point - eye.pose.position)
        assert angles_deg(eye.pose.forward, wanted) == pytest.approx(0.0, abs=1e-6)
    assert float(angles_deg(left.pose.forward, right.pose.forward)) > 5.0  # 6° at 0.6 m


def test_an_offset_of_an_eye_is_the_angle_that_it_says():
    settings = SimulatedEyes(noise_deg=0.0)
    pair = EyePair(settings, np.random.default_rng(1), np.array([[1.0, 0.0], [0.0, -0.5]]))
    left, right = pair.look(Pose(), np.array([0.0, 0.0, -1e6]))
    right_deg = np.degrees(np.arctan2(left.pose.forward[0], -left.pose.forward[2]))
    assert right_deg == pytest.approx(1.0, abs=1e-4)
    assert np.degrees(np.arcsin(right.pose.forward[1])) == pytest.approx(-0.5, abs=1e-4)
