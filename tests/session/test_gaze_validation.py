"""Gaze: how good a tracker is, sessions that end where it is not, and simulated eyes."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.support.protocols import ASKED_AFTER_EACH, NOBODY_LEAVES, protocol_text
from tests.support.session import run
from tests.support.study import AheadHeadset, LateFocus, Scripted, read_rows, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.geometry import Gaze, Pose, normalize, turn_to, yaw_pitch_roll
from vrcomfort.protocol.simulation import SimulatedEyes
from vrcomfort.records import read_participants
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.respondent.simulated_eyes import Eyes
from vrcomfort.traces.gaze_quality import angles_deg, quality_of

PROTOCOL = protocol_text(
    """\
[gaze_validation]
points = [[0.0, 0.0, 1.0], [10.0, 0.0, 1.0], [0.0, 8.0, 2.0], [-10.0, -5.0, 3.0]]
""",
    ASKED_AFTER_EACH,
    f"{NOBODY_LEAVES}[simulation.eyes]\nerror_deg = 0.0\n",
    name="looks",
    exposure_s=2.0,
    keys="break_s = 5.0\n",
)


class Ahead(AheadHeadset):
    """Twenty frames a second, of a head 1.6 m high that turns a little."""

    def frames(self):
        for each in super().frames():
            turn = yaw_pitch_roll(0.1 * np.sin(each.index / 40), 0.0, 0.0)
            head = Pose((0.0, 1.6, 0.0), turn)
            yield replace(
                each,
                head_pose=head,
                period_ns=50_000_000,
                predicted_display_time_ns=each.index * 50_000_000,
            )


def do(folder, text=PROTOCOL, *, headset=Ahead, respondent=None, **more):
    protocol = tiny_protocol(folder, text)
    who = respondent or SimulatedRespondent(protocol.simulation, participant="P01", seed=0)
    return run(
        protocol,
        "P01",
        study=folder / "S",
        respondent=who,
        load_scene=lambda _: None,
        headset_for=lambda *_: headset(),
        renderer=LateFocus(),
        **more,
    )


def rows(folder, name="gaze_validation.csv"):
    found = read_rows(folder / "S/sub-P01/ses-1" / name)
    return [row for row in found if row.get("eye", "combined") == "combined"]


def off(towards, right_deg, up_deg):
    """Return directions that many degrees beside (n, 3) others."""
    beside = [
        Pose(orientation=turn_to(t)) @ Pose(orientation=yaw_pitch_roll(*np.radians([-r, u]), 0.0))
        for t, r, u in zip(towards, right_deg, up_deg, strict=True)
    ]
    return np.array([each.forward for each in beside])


def test_accuracy_is_the_offset_and_precision_the_spread_of_known_noise():
    rng = np.random.default_rng(1)
    n = 2_000
    towards = np.tile(normalize(np.array([0.2, -0.1, -1.0])), (n, 1))
    gaze = off(towards, 1.0 + 0.2 * rng.standard_normal(n), 0.2 * rng.standard_normal(n))
    found = quality_of(gaze, towards)
    # Noise of 0.2° along two axes: 0.2 √2 from the mean, √2 of that from sample to sample.
    assert found.precision_sd_deg == pytest.approx(0.2 * np.sqrt(2), rel=0.05)
    assert found.precision_rms_deg == pytest.approx(0.2 * 2, rel=0.05)
    assert found.accuracy_deg == pytest.approx(1.0 + 0.2**2 / 2, rel=0.02)


def test_a_head_that_turns_makes_a_steady_gaze_no_less_precise():
    ways = np.array([[np.sin(a), 0.1, -np.cos(a)] for a in np.linspace(0, 0.5, 100)])
    towards = normalize(ways)
    found = quality_of(off(towards, np.full(100, 0.5), np.zeros(100)), towards)
    assert found.accuracy_deg == pytest.approx(0.5, abs=1e-6)
    assert found.precision_rms_deg == pytest.approx(0.0, abs=1e-3)


def test_nothing_is_said_where_the_eyes_were_not_seen():
    assert quality_of(np.zeros((0, 3)), np.zeros((0, 3))) == (None, None, None)


class Slow(Ahead):
    """Three frames a second."""

    def frames(self):
        for each in super().frames():
            ns = 350_000_000
            yield replace(each, period_ns=ns, predicted_display_time_ns=each.index * ns)


def test_all_points_are_shown_and_eyes_are_on_them_at_any_frame_rate(tmp_path):
    assert do(tmp_path, headset=Slow).status == "completed"
    points = [row for row in rows(tmp_path) if row["point"]]
    assert len(points) == 8
    for row in points:
        assert int(row["samples"]) >= 1
        assert not row["accuracy_deg"] or float(row["accuracy_deg"]) < 0.6  # blank: a blink


@pytest.fixture(scope="module")
def looked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("looks")
    text = PROTOCOL.replace("error_deg = 0.0", "error_deg = 0.4\nnoise_deg = 0.2")
    assert do(folder, text).status == "completed"
    return folder


def test_every_point_has_a_row_and_the_mean_one_before_the_first_exposure_and_after_breaks(looked):
    found = rows(looked)
    assert [(row["validation"], row["before_trial"], row["point"]) for row in found] == [
        (count, count, point) for count in "12" for point in ["1", "2", "3", "4", ""]
    ]
    places = {(row["right_deg"], row["up_deg"], row["distance_m"]) for row in found[:4]}
    assert places == {
        ("0.0", "0.0", "1.0"),
        ("10.0", "0.0", "1.0"),
        ("0.0", "8.0", "2.0"),
        ("-10.0", "-5.0", "3.0"),
    }
    for row in found:
        assert 0.05 < float(row["accuracy_deg"]) < 1.5
        assert 0.2 < float(row["precision_rms_deg"]) < 0.8  # noise of 0.2° twice, and wandering
        assert float(row["valid_percent"]) > 80  # but for blinks
    mean = np.mean([float(row["accuracy_deg"]) for row in found[5:9]])
    assert float(found[9]["accuracy_deg"]) == pytest.approx(mean, abs=1e-3)
    assert found[9]["good"] == "1"
    (person,) = read_participants(looked / "S")
    assert float(dict(person.others)["gaze_validation_error_deg"]) == pytest.approx(mean, abs=2e-3)


def test_the_error_is_no_covariate_and_the_study_is_whole(looked, tmp_path):
    (person,) = read_participants(looked / "S")
    assert person.covariates == {}
    assert not verify_study(looked / "S").faults
    anonymise(looked / "S", tmp_path / "shared", AnonymisingOptions(seed=1, keep_gaze=True))
    (file,) = (tmp_path / "shared").rglob("gaze_validation.csv")
    assert len(read_rows(file)) == 3 * 10  # both eyes, left, right
    assert not verify_study(tmp_path / "shared").faults


def test_a_copy_without_gaze_does_not_tell_its_error(looked, tmp_path):
    anonymise(looked / "S", tmp_path / "shared", AnonymisingOptions(seed=1))
    assert not list((tmp_path / "shared").rglob("gaze*"))
    assert "gaze_validation_error_deg" not in (tmp_path / "shared/participants.csv").read_text()
    assert not verify_study(tmp_path / "shared").faults


def test_gaze_of_simulated_eyes_stands_beside_every_frame(looked):
    gaze, frames = rows(looked, "gaze.csv"), rows(looked, "frames.csv")
    assert [row["xr_time_ns"] for row in gaze] == [row["xr_time_ns"] for row in frames]
    closed = sum(row["valid"] == "0" for row in gaze) / len(gaze)
    assert 0.005 < closed < 0.12  # 0.15 s of 4.15


ABOVE = PROTOCOL.replace("error_deg = 0.0", "error_deg = 20.0")


def test_a_session_ends_where_the_error_stays_above_the_limit(tmp_path):
    outcome = do(tmp_path, ABOVE, headset=Slow)
    assert "limit is 1.5 degrees" in outcome.note
    found = [(row["attempt"], row["good"]) for row in rows(tmp_path) if not row["point"]]
    assert found == [("1", "0"), ("2", "0")]
    assert rows(tmp_path, "trials.csv") == []
    events = [row["name"] for row in rows(tmp_path, "events.csv")]
    assert events.count("gaze_validation") == 2
    assert "ended" in events
    assert not verify_study(tmp_path / "S").faults


def test_an_error_may_only_be_noted(tmp_path):
    text = ABOVE.replace("[gaze_validation]", '[gaze_validation]\nabove = "note"\nattempts = 1')
    assert do(tmp_path, text, headset=Slow).status == "completed"
    assert len(rows(tmp_path, "trials.csv")) == 2


class Tracked(Slow):
    """A tracker that sees the eyes straight ahead, whatever they look at."""

    def frames(self):
        for each in super().frames():
            yield replace(each, gaze=Gaze(each.head_pose))


def test_a_gaze_that_does_not_follow_is_as_far_off_as_the_points_are(tmp_path):
    text = PROTOCOL.replace("[gaze_validation]", '[gaze_validation]\nabove = "note"\nattempts = 1')
    assert do(tmp_path, text, headset=Tracked, respondent=Scripted()).status == "completed"
    by_place = {(row["right_deg"], row["up_deg"]): row for row in rows(tmp_path) if row["point"]}
    # The head turns a little between the appearance of a point and its end.
    assert float(by_place["10.0", "0.0"]["accuracy_deg"]) == pytest.approx(10.0, abs=3.0)
    assert float(by_place["0.0", "0.0"]["accuracy_deg"]) == pytest.approx(0.0, abs=3.0)


def test_a_headset_without_eye_tracker_is_told_and_the_session_goes_on(tmp_path):
    text = PROTOCOL.replace("[simulation.eyes]\nerror_deg = 0.0", "")
    assert do(tmp_path, text, headset=Slow).status == "completed"
    events = [row["name"] for row in rows(tmp_path, "events.csv")]
    assert events.count("gaze_not_validated") == 2
    assert not (tmp_path / "S/sub-P01/ses-1/gaze_validation.csv").exists()


def simulated(seconds=100.0, rate_hz=125.0, point=None, **settings):
    eyes = Eyes(SimulatedEyes(error_deg=0.0, **settings), np.random.default_rng(4), np.zeros(2))
    times = np.arange(0.0, seconds, 1 / rate_hz)
    return times, [eyes.look(float(t), Pose(), point) for t in times]


@pytest.mark.slow
def test_simulated_eyes_fixate_jump_and_blink():
    times, gaze = simulated(noise_deg=0.0)
    valid = np.array([each.valid for each in gaze])
    blinks = np.flatnonzero(valid[:-1] & ~valid[1:])
    assert len(blinks) == pytest.approx(100 / 4.15, rel=0.4)
    looks = np.array([each.pose.forward for each in gaze])
    speeds = angles_deg(looks[1:], looks[:-1]) * 125
    seen = valid[1:] & valid[:-1]
    still = speeds[seen] < 1.0
    assert 0.75 < still.mean() < 0.95  # fixations of 0.34 s on average, saccades of 0.05
    assert speeds[seen].max() > 150
    # Lengths of fixations: the median of the log-normal, as far as blinks do not cut them.
    changes = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    lengths = np.array([b - a for a, b in pairwise(changes)][::2]) / 125
    assert np.median(lengths) == pytest.approx(0.3, rel=0.25)
    aside = np.degrees(np.arctan2(looks[valid][:, 0], -looks[valid][:, 2]))
    assert aside.std() == pytest.approx(10.0, rel=0.2)
    assert np.all(np.diff(times) > 0)


def test_simulated_eyes_go_to_what_is_to_be_looked_at():
    _, gaze = simulated(seconds=6.0, point=np.array([1.0, 0.5, -2.0]), noise_deg=0.0)
    looks = np.array([each.pose.forward for each in gaze if each.valid])[100:]
    wanted = np.broadcast_to(normalize(np.array([1.0, 0.5, -2.0])), looks.shape)
    assert np.median(angles_deg(looks, wanted)) < 0.5


def test_the_same_person_looks_the_same_way_again():
    first, again = (simulated(seconds=1.0)[1] for _ in range(2))
    assert [each.pose.numbers for each in first] == [each.pose.numbers for each in again]


def test_simulated_eyes_go_on_where_time_begins_again():
    """Each step of a session may have frames of its own, whose times begin at 0."""
    eyes = Eyes(
        SimulatedEyes(error_deg=0.0, noise_deg=0.0, spread_deg=(0.0, 0.0), blink_every_s=3600.0),
        np.random.default_rng(4),
        np.zeros(2),
    )
    for step in range(60):
        before = eyes.look(step / 20, Pose(), None).pose.forward
    aside = np.array([-1.0, 0.0, -1.0])
    looks = [eyes.look(step / 20, Pose(), aside).pose.forward for step in range(20)]
    assert angles_deg(looks[0], before) < 1.0
    assert max(angles_deg(look, np.array([0.0, 0.0, -1.0])) for look in looks) < 46.0
    assert angles_deg(looks[8], aside / math.sqrt(2)) < 1.0


def test_points_that_go_before_the_eyes_have_settled_are_refused(tmp_path):
    assert "[gaze_validation]\n" in PROTOCOL
    text = PROTOCOL.replace("[gaze_validation]\n", "[gaze_validation]\nsettle_s = 29.0\n")
    with pytest.raises(InputError, match="make `settle_s` shorter than `each_s`"):
        tiny_protocol(tmp_path, text)
