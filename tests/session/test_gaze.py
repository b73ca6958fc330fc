"""Gaze: written beside the frames, found again beside them, and never guessed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.support.session import run
from tests.support.study import (
    AheadHeadset,
    LateFocus,
    Scripted,
    frame,
    read_rows,
    strict_about_gaze,
    tiny_protocol,
)
from vrcomfort.api.playback import open_trace, require_recorded_gaze
from vrcomfort.cli import main
from vrcomfort.errors import InputError
from vrcomfort.frame import GazeHit
from vrcomfort.geometry import Gaze, Pose, normalize, rotate, turn_to, yaw_pitch_roll
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.protocol import Condition
from vrcomfort.records import (
    FrameRow,
    GazeRow,
    Machine,
    Manifest,
    Recorder,
    repair_session,
    session_folder,
)
from vrcomfort.records.study import now
from vrcomfort.resources import data_folder
from vrcomfort.session import VirtualClock
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.traces.gaze_track import LONGEST_NS, GazeTrack, read_gaze
from vrcomfort.traces.pose_track import PoseTrack
from vrcomfort.traces.trace import Trace, read_trace

FIRST = (
    "session_s,xr_time_ns,valid,origin_x_m,origin_y_m,origin_z_m,"
    "direction_x,direction_y,direction_z,hit_m"
)
HEADER = f"{FIRST},resumed"  # what a file had before schema version 4, and may have
EYE = (
    "{0}_valid,{0}_origin_x_m,{0}_origin_y_m,{0}_origin_z_m,"
    "{0}_direction_x,{0}_direction_y,{0}_direction_z,{0}_pupil_mm"
)
RECORDED = f"{FIRST},hit_node,effect_centre,{EYE.format('left')},{EYE.format('right')},resumed"


def looking(index: int) -> Gaze:
    """To the side by 0.1 rad per frame; every fifth frame is a blink."""
    pose = Pose(np.array([0.0, 1.6, 0.01 * index]), yaw_pitch_roll(0.1 * index, 0.05, 0.0))
    return Gaze(pose, valid=index % 5 != 4)


@dataclass
class TrackedHeadset(AheadHeadset):
    """`AheadHeadset` with an eye tracker."""

    def frames(self):
        for each in super().frames():
            yield replace(each, gaze=looking(each.index))


def record(tmp_path, headset):
    protocol = tiny_protocol(tmp_path)
    run(
        protocol,
        "P01",
        study=tmp_path / "S",
        load_scene=lambda source: source,
        headset_for=lambda *_: headset,
        renderer=LateFocus(),
        respondent=Scripted(),
        sessions=[1],
        clock=VirtualClock(),
    )
    return session_folder(tmp_path / "S", "P01", 1)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Return the folder of a session with an eye tracker that nobody changes."""
    return record(tmp_path_factory.mktemp("tracked"), TrackedHeadset())


@pytest.mark.smoke
def test_a_session_writes_one_row_per_frame(recorded):
    lines = (recorded / "gaze.csv").read_text().splitlines()
    assert lines[0] == RECORDED
    frames, gazes = (read_rows(recorded / name) for name in ("frames.csv", "gaze.csv"))
    assert [row["xr_time_ns"] for row in gazes] == [row["xr_time_ns"] for row in frames]
    assert [row["session_s"] for row in gazes] == [row["session_s"] for row in frames]
    blink, first = gazes[4], gazes[0]
    assert (blink["valid"], blink["origin_x_m"], blink["direction_z"]) == ("0", "", "")
    assert (first["valid"], first["origin_y_m"], first["hit_m"]) == ("1", "1.6", "")
    assert float(first["direction_z"]) == pytest.approx(-np.cos(0.05))


def test_playing_a_session_back_gives_its_gaze(recorded):
    trace = read_trace(recorded / "frames.csv").only_trial("1")
    headset = PlaybackHeadset(trace, image_size_px=(4, 4), loop=False)
    played = [each.gaze for each in headset.frames()]
    # Training was index 0 to 9 of the same headset's frames; the exposure goes on after it.
    shown = [looking(10 + index) for index in range(len(played))]
    assert len(played) == 100
    assert [gaze.valid for gaze in played] == [gaze.valid for gaze in shown]
    for gaze, wanted in zip(played, shown, strict=True):
        if wanted.valid:
            assert np.array_equal(gaze.pose.position, wanted.pose.position)
            assert np.allclose(gaze.pose.forward, wanted.pose.forward, atol=1e-15)


@pytest.mark.slow
def test_what_has_no_gaze_is_not_played_back_where_focus_follows_it(
    recorded, tmp_path, monkeypatch, capsys
):
    strict = strict_about_gaze(tmp_path)
    out, walk = tmp_path / "out", data_folder("scenes") / "temple_walk.csv"
    shown = ("--protocol", strict, "--condition", "gaze_19", "--scene", "temple")
    for command in (
        ("run", strict, "--participant", "P01", "--respondent", "simulated"),
        ("simulate", strict, "-n", "2", "--trace", walk),
        ("play", walk, *shown),
    ):
        arguments = [*map(str, command), "--size", "16x16", "--out", str(out)]
        monkeypatch.setattr("sys.argv", ["vrcomfort", *arguments])
        with pytest.raises(SystemExit):
            main()
        said = " ".join(capsys.readouterr().err.split())
        assert "in gaze_19" in said
        assert "what is played back has no gaze; give a frames.csv" in said
        assert not out.exists()
    follows = Condition(name="looks", focus={"method": "gaze"}, depth_of_field={})
    trace = read_trace(recorded / "frames.csv")
    require_recorded_gaze([follows], trace)
    with pytest.raises(InputError, match="in looks, and what is played back has no gaze"):
        require_recorded_gaze([follows], replace(trace, gaze=None))


def test_a_window_cannot_show_what_follows_the_gaze(tmp_path, monkeypatch, capsys):
    session = ("run", strict_about_gaze(tmp_path), "--participant", "P01", "--headset", "desktop")
    out = tmp_path / "out"
    monkeypatch.setattr("sys.argv", ["vrcomfort", *map(str, session), "--out", str(out)])
    with pytest.raises(SystemExit, match="2"):
        main()
    said = capsys.readouterr().err
    assert "follows the gaze in gaze_19, gaze_7, gaze_2, and this headset has no eye" in said
    assert not out.exists()


class LateHits(LateFocus):
    """Tells three frames late what a valid gaze meets: a chair, or sky."""

    def render(self, frame, scene_time_s):
        picture = super().render(frame, scene_time_s)
        hits = self.__dict__.setdefault("hits", [])
        if frame.gaze.valid:
            met = (None, "") if frame.index == 3 else (2.5, "chair")
            hits.append(GazeHit(frame.index, *met))
        due, hits[:] = hits[:-3], hits[-3:]
        centre = "gaze" if frame.gaze.valid else "held"
        return replace(
            picture, seeks_gaze=frame.gaze.valid, gaze_hits=tuple(due), effect_centre=centre
        )

    def drain_gaze_hits(self):
        return tuple(self.hits)


@pytest.mark.parametrize("blurs", [True, False])
def test_what_the_gaze_meets_is_written_in_every_condition(tmp_path, blurs):
    with Recorder(tmp_path, "P1", 1) as recorder:
        log, renderer = FrameLog(recorder), LateHits()
        renderer.begin(None, Condition(name="any", depth_of_field={} if blurs else None))
        for index in range(6):
            shown = replace(frame(index), gaze=looking(index))
            log.add(shown, renderer.render(shown, 0.0), trial=1, session_s=0.1 * index)
        log.finish(renderer.drain(), hits=renderer.drain_gaze_hits())
    rows = read_rows(recorder.folder / "gaze.csv")
    assert [row["hit_m"] for row in rows] == ["2.5"] * 3 + ["", "", "2.5"]  # sky, and a blink
    assert [row["hit_node"] for row in rows] == ["chair"] * 3 + ["", "", "chair"]
    assert [row["effect_centre"] for row in rows] == ["gaze"] * 4 + ["held", "gaze"]


def test_a_resumed_session_goes_on_in_the_same_file(tmp_path):
    shown = frame(0)
    row = FrameRow(
        0.0, 1, 100, 1, True, shown.head_pose, *shown.views, shown.avatar_pose,
        gaze=GazeRow(0.0, 1, looking(1)),
    )  # fmt: skip
    with Recorder(tmp_path, "P1", 1) as recorder:
        recorder.write(row)
    folder = recorder.folder
    protocol = tiny_protocol(tmp_path)
    Manifest("P1", 1, "ab", protocol, Machine(), {}, "scripted", 0, 10.0, now()).write(folder)
    with (folder / "gaze.csv").open("a") as file:
        file.write("0.1,2,1,0.0,")
    warnings = repair_session(folder, protocol.order.sequences[0].sessions[0]).warnings
    assert [warning.rpartition("/")[2] for warning in warnings] == [
        "gaze.csv, line 3: a half-written row was moved to gaze.csv.cut"
    ]
    with Recorder(tmp_path, "P1", 1, resumed=True) as recorder:
        recorder.write(replace(row, xr_time_ns=2, gaze=GazeRow(0.1, 2, looking(2))))
    assert [each["resumed"] for each in read_rows(folder / "gaze.csv")] == ["0", "1"]


def track(times_ns, valid=None) -> GazeTrack:
    count = len(times_ns)
    directions = normalize(np.stack([np.arange(count), np.zeros(count), -np.ones(count)], axis=1))
    kept = np.ones(count, bool) if valid is None else np.array(valid)
    return GazeTrack(np.array(times_ns, np.int64), kept, np.zeros((count, 3)), directions)


def test_the_nearest_sample_counts_and_an_old_one_does_not():
    seen = track([0, 10_000_000, 20_000_000], valid=[True, False, True])
    assert np.allclose(seen.at(4_000_000).pose.forward, [0, 0, -1])
    assert not seen.at(6_000_000).valid  # a blink is nearest
    assert np.allclose(seen.at(16_000_000).pose.forward, seen.directions[2])
    assert seen.at(20_000_000 + LONGEST_NS).valid
    assert not seen.at(20_000_001 + LONGEST_NS).valid
    assert not seen.at(-1 - LONGEST_NS).valid


@example((0.0, 1.3e-7, 1.0))
@example((0.0, 2e-12, 1.0))
@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 1e-3))
def test_turning_from_straight_ahead_gives_the_direction(vector):
    direction = normalize(vector)
    assert np.allclose(rotate(turn_to(direction), [0, 0, -1]), direction, atol=1e-11)


def gaze_file(tmp_path, *rows):
    file = tmp_path / "gaze.csv"
    file.write_text("\n".join([HEADER, *rows, ""]))
    return file


def test_a_file_of_blinks_is_read(tmp_path):
    seen = read_gaze(gaze_file(tmp_path, "0.0,5,0,,,,,,,,0", "0.1,9,0,,,,,,,,0"))
    assert not seen.at(5).valid


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("0.1,9,1,0,0,0,0,0,-2,,0", "line 3.*direction has length 2"),
        ("0.1,9,1,0,0,0,,0,-1,,0", "line 3.*direction_x.*empty"),
        ("0.1,4,1,0,0,0,0,0,-1,,0", "line 3.*goes back by 1 ns"),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(tmp_path, row, message):
    file = gaze_file(tmp_path, "0.0,5,0,,,,,,,,0", row)
    with pytest.raises(InputError, match=message):
        read_gaze(file)


def test_gaze_that_does_not_reach_along_the_trace_is_told_or_refused(tmp_path):
    walk = data_folder("scenes") / "temple_walk.csv"  # a sample each 13.9 ms, from 0 on
    begins = gaze_file(tmp_path, "0,0,1,0,0,0,0,0,-1,,0", "0,13888889,1,0,0,0,0,0,-1,,0")
    notes = []
    count = len(open_trace(walk, gaze=begins, note=notes.append))
    (note,) = notes
    assert f"{count - 5} of the trace's {count} samples have no gaze" in note
    later = gaze_file(tmp_path, "0,99000000000,1,0,0,0,0,0,-1,,0")
    with pytest.raises(InputError, match="of another recording"):
        open_trace(walk, gaze=later)


def test_a_missing_column_is_named(tmp_path):
    file = tmp_path / "gaze.csv"
    file.write_text("xr_time_ns,valid\n1,1\n")
    with pytest.raises(InputError, match="origin_x_m"):
        read_gaze(file)


def test_gaze_of_another_rate_is_looked_up_by_time():
    positions = np.tile([0.0, 1.6, 0.0], (4, 1))
    head = PoseTrack(positions, np.tile([0.0, 0.0, 0.0, 1.0], (4, 1)))
    times = np.arange(4) * 10_000_000
    trace = Trace(times, head, np.arange(4) == 0, gaze=track([0, 20_000_000]))
    frames = PlaybackHeadset(trace, image_size_px=(4, 4), loop=False).frames()
    ahead = [-each.gaze.pose.forward[2] for each in frames]
    assert np.allclose(ahead, [1, 1, np.sqrt(0.5), np.sqrt(0.5)])
