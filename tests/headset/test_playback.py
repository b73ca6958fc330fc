"""Playback: the same frames every time, at exact times, with cuts where poses jump."""

import time
from itertools import islice

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose, axis_angle, slerp, yaw_pitch_roll
from vrcomfort.headset.playback import PlaybackHeadset, default_fovs
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.rows import cell_text, csv_line
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.traces.pose_track import PoseTrack
from vrcomfort.traces.trace import Trace, read_trace

SIZE = (64, 80)


def turning_trace(times_ns, **more):
    """A head that walks along +x and turns left, 0.1 rad per sample."""
    n = len(times_ns)
    cuts = np.zeros(n, bool)
    cuts[0] = True
    return Trace(
        **{
            "time_ns": np.array(times_ns, np.int64),
            "head": PoseTrack(
                np.stack([np.arange(n) * 0.1, np.full(n, 1.6), np.zeros(n)], axis=1),
                axis_angle(np.array([[0.0, 1.0, 0.0]]), np.arange(n) * 0.1),
            ),
            "cuts": cuts,
        }
        | more
    )


def play(trace, count, **settings):
    return list(islice(PlaybackHeadset(trace, image_size_px=SIZE, **settings).frames(), count))


def poses(frames):
    return [
        [(*p.position, *p.orientation) for p in (f.head_pose, f.avatar_pose, *eyes(f))]
        for f in frames
    ]


def eyes(frame):
    return [view.pose for view in frame.views]


TEN_MS = turning_trace(range(5_000_000, 105_000_000, 10_000_000))


def test_the_traces_own_rate_gives_its_samples():
    frames = play(TEN_MS, 10)
    assert [f.predicted_display_time_ns for f in frames] == TEN_MS.time_ns.tolist()
    assert [f.head_pose for f in frames] == [TEN_MS.head.pose(i) for i in range(10)]
    assert [f.index for f in frames] == list(range(10))
    assert [f.discontinuity for f in frames] == [True] + [False] * 9


@pytest.mark.smoke
def test_another_rate_interpolates_at_its_display_times():
    frames = play(TEN_MS, 12, refresh_hz=120)
    for k, frame in enumerate(frames[:11]):
        place = round(k * 1e9 / 120) / 1e7
        before = int(place)
        expected = slerp(
            TEN_MS.head.orientations[before],
            TEN_MS.head.orientations[min(before + 1, 9)],
            place - before,
        )
        np.testing.assert_allclose(frame.head_pose.orientation, expected, atol=1e-15)
        np.testing.assert_allclose(frame.head_pose.position[0], place * 0.1, atol=1e-12)
        assert frame.period_ns == 8_333_333
    assert frames[11].discontinuity


@given(hz=st.sampled_from([59.94, 60.0, 72.0, 89.53, 90.0, 120.0]), k=st.integers(0, 40))
def test_time_does_not_drift(hz, k):
    long = turning_trace([0, 3_600_000_000_000])
    headset = PlaybackHeadset(long, image_size_px=SIZE, refresh_hz=hz)
    frames = list(islice(headset.frames(), k + 1))
    assert abs(frames[k].predicted_display_time_ns - k * 1e9 / hz) <= 0.5 + 1e-3


def test_playing_twice_gives_the_same_poses():
    first, second = (poses(play(TEN_MS, 50, refresh_hz=72)) for _ in range(2))
    assert first == second


def test_the_loop_is_a_cut_and_time_runs_on():
    frames = play(TEN_MS, 25)
    assert [f.index for f in frames if f.discontinuity] == [0, 10, 20]
    assert np.diff([f.predicted_display_time_ns for f in frames]).tolist() == [10_000_000] * 24
    assert frames[10].head_pose == frames[0].head_pose


def test_without_loop_the_frames_end_with_the_trace():
    assert len(play(TEN_MS, 99, loop=False)) == 10
    assert len(play(TEN_MS, 99, loop=False, refresh_hz=50)) == 5
    assert len(play(TEN_MS, 99, max_frames=3)) == 3


def test_a_change_of_trial_is_a_cut_that_no_pose_is_interpolated_across():
    cuts = np.arange(10) % 5 == 0
    frames = play(turning_trace(TEN_MS.time_ns, cuts=cuts), 16, refresh_hz=200)
    at = [f.head_pose.position[0] for f in frames]
    assert [i for i, f in enumerate(frames) if f.discontinuity] == [0, 9]
    assert not any(0.401 < x < 0.499 for x in at)
    assert np.unique(np.diff([f.predicted_display_time_ns for f in frames])).tolist() == [5_000_000]


def test_a_trace_without_a_world_is_anchored_at_the_spawn_point():
    spawn = Pose(np.array([3.0, 0.5, -7.0]), axis_angle([0.0, 1.0, 0.0], 1.0))
    trace = turning_trace(
        TEN_MS.time_ns[:1],
        head=PoseTrack(np.array([[5.0, 1.6, 2.0]]), yaw_pitch_roll(2.0, 0.4, 0.1)[None]),
    )
    (frame,) = play(trace, 1, spawn=spawn)
    world_from_head = frame.avatar_pose @ frame.head_pose
    np.testing.assert_allclose(world_from_head.position, [3.0, 2.1, -7.0], atol=1e-12)
    np.testing.assert_allclose(
        abs(world_from_head.orientation @ yaw_pitch_roll(1.0, 0.4, 0.1)), 1, atol=1e-12
    )


@pytest.mark.parametrize("pitch", [-np.pi / 2, np.pi / 2])
def test_a_head_that_looks_straight_up_or_down_still_has_a_heading(pitch):
    trace = turning_trace(
        TEN_MS.time_ns[:1],
        head=PoseTrack(np.array([[0.0, 1.6, 0.0]]), yaw_pitch_roll(0.7, pitch, 0.0)[None]),
    )
    (frame,) = play(trace, 1)
    np.testing.assert_allclose(
        abs(frame.avatar_pose.orientation @ axis_angle([0.0, 1.0, 0.0], -0.7)), 1, atol=1e-12
    )


def test_eyes_are_an_ipd_apart_beside_the_head():
    (frame,) = play(TEN_MS, 1, ipd_m=0.07)
    left, right = (pose.position - frame.head_pose.position for pose in eyes(frame))
    np.testing.assert_allclose(left, [-0.035, 0, 0], atol=1e-15)
    np.testing.assert_allclose(right, [0.035, 0, 0], atol=1e-15)


@pytest.mark.parametrize("size", [(640, 800), (320, 400), (1, 1), (7, 5)])
def test_default_frusta_have_square_pixels_and_mirror_each_other(size):
    left, right = default_fovs(size)
    a, b, up, down = left.tangents
    assert (b - a) / size[0] == pytest.approx((up - down) / size[1])
    assert (right.left, right.right) == (-left.right, -left.left)


def test_a_session_has_one_clock_over_several_runs():
    headset = PlaybackHeadset(TEN_MS, image_size_px=SIZE)
    first = list(islice(headset.frames(), 3))
    headset.place(spawn=Pose(np.array([1.0, 0.0, 0.0])))
    second = list(islice(headset.frames(), 2))
    assert [f.index for f in first + second] == [0, 1, 2, 3, 4]
    assert second[0].predicted_display_time_ns == 35_000_000
    assert second[0].discontinuity
    assert second[0].head_pose == first[0].head_pose
    assert second[0].avatar_pose.position[0] == first[0].avatar_pose.position[0] + 1


class Rows(list):
    """What a session's recorder is given."""

    def write(self, *rows):
        self.extend(rows)


def record(frames, path):
    """Write the frames as a session does, with blanks where no focus was found."""
    rows = Rows()
    log = FrameLog(rows)
    for frame in frames:
        log.add(frame, None, trial=1, session_s=frame.predicted_display_time_ns * 1e-9)
    log.finish()
    cells = [FrameRow.columns(), *([cell_text(cell) for cell in row.cells()] for row in rows)]
    path.write_text("".join(map(csv_line, cells)), encoding="utf-8")


@pytest.mark.parametrize("replay_hz", [None, 89.53])
def test_a_recorded_session_plays_back_bit_for_bit(tmp_path, replay_hz):
    spawn = Pose(np.array([0.1, 0.2, 0.3]), axis_angle([0.0, 1.0, 0.0], 0.3))
    frames = play(TEN_MS, 40, refresh_hz=89.53, spawn=spawn)
    record(frames, tmp_path / "frames.csv")
    trace = read_trace(tmp_path / "frames.csv")
    again = play(trace, 40, refresh_hz=replay_hz, ipd_m=0.5, spawn=Pose())
    assert poses(again) == poses(frames)
    assert [(f.views[0].fov, f.views[1].fov) for f in again] == [
        (f.views[0].fov, f.views[1].fov) for f in frames
    ]
    assert [f.predicted_display_time_ns for f in again] == [
        f.predicted_display_time_ns for f in frames
    ]
    assert [f.period_ns for f in again] == [f.period_ns for f in frames]
    assert [f.discontinuity for f in again] == [f.discontinuity for f in frames]
    assert frames[9].discontinuity  # the loop


@pytest.mark.parametrize("hz", [0.0, -1.0, float("nan"), float("inf"), 1e30])
def test_an_impossible_rate_is_refused(hz):
    with pytest.raises(InputError, match="above 0 and at most 10000 Hz"):
        play(TEN_MS, 1, refresh_hz=hz)


def test_in_real_time_no_frame_comes_early():
    trace = turning_trace(range(0, 100_000_000, 10_000_000))
    begun_s = time.monotonic()
    assert len(play(trace, 9, real_time=True)) == 9
    assert time.monotonic() - begun_s >= 0.075  # eight periods of 10 ms


def test_a_recorded_snap_turn_is_played_again_and_never_half(tmp_path):
    """At twice the rate no frame stands between before and after; nothing else is cut."""
    yaws = np.radians([0.0, 0.0, 30.0, 30.0])
    turns = np.array([False, False, True, False])
    avatar = PoseTrack(np.zeros((4, 3)), axis_angle(np.array([[0.0, 1.0, 0.0]]), yaws))
    trace = turning_trace(range(0, 40_000_000, 10_000_000), avatar=avatar, snap_turns=turns)
    record(play(trace, 4), tmp_path / "frames.csv")
    for played, rate, count in (
        (trace, None, 4), (trace, 200, 6), (read_trace(tmp_path / "frames.csv"), 200, 6),
    ):  # fmt: skip
        frames = play(played, count, refresh_hz=rate)
        assert [frame.snap_turn for frame in frames].count(True) == 1
        assert [frame.discontinuity for frame in frames] == [True] + [False] * (count - 1)
        at = [frame.snap_turn for frame in frames].index(True)
        for number, frame in enumerate(frames):
            np.testing.assert_allclose(
                frame.avatar_pose.orientation, avatar.orientations[2 * (number >= at)], atol=1e-12
            )


def test_hands_are_played_where_they_are_known():
    """Half way between two samples a hand is between them, if both know it."""
    places = np.array([[0.0, 1, 0], [0.2, 1, 0], [np.nan] * 3, [0.4, 1, 0]])
    turns = np.where(np.isnan(places[:, :1]), np.nan, [[0.0, 0, 0, 1]])
    trace = turning_trace(range(0, 40_000_000, 10_000_000), right_hand=PoseTrack(places, turns))
    for rate, expected in (
        (None, [0.0, 0.2, None, 0.4]),
        (200, [0.0, 0.1, 0.2, None, None, None, 0.4]),
    ):
        frames = play(trace, len(expected), refresh_hz=rate)
        found = [frame.hands[1] and frame.hands[1].position[0] for frame in frames]
        assert [None if x is None else round(x, 9) for x in found] == expected
        assert all(frame.hands[0] is None for frame in frames)


def test_recorded_hands_play_again_and_hands_never_seen_are_none(tmp_path):
    places = np.array([[0.0, 1, 0], [np.nan] * 3, [0.4, 1, 0.125]])
    turns = np.where(np.isnan(places[:, :1]), np.nan, [[0.0, 0.6, 0, 0.8]])
    trace = turning_trace(range(0, 30_000_000, 10_000_000), right_hand=PoseTrack(places, turns))
    frames = play(trace, 3)
    record(frames, tmp_path / "frames.csv")
    recorded = read_trace(tmp_path / "frames.csv")
    assert recorded.left_hand is None
    assert [frame.hands for frame in play(recorded, 3)] == [frame.hands for frame in frames]
