from __future__ import annotations

import json
import math
import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.study import frame, read_rows, tiny_protocol
from vrcomfort.design import build_design
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose
from vrcomfort.records import (
    EventRow,
    FrameRow,
    Machine,
    Manifest,
    ParticipantRow,
    QuestionnaireRow,
    RatingRow,
    Recorder,
    TrialRow,
    enrol,
    open_study,
    read_participants,
    recorded_sessions,
    set_status,
)
from vrcomfort.records.rows import cell_text
from vrcomfort.records.shared_columns import pose_columns


def frame_row(**changes) -> FrameRow:
    shown = frame(3)
    values = {
        "session_s": 0.1 + 0.2,
        "xr_time_ns": 3,
        "period_ns": 11_111_111,
        "trial": 1,
        "should_render": True,
        "head": shown.head_pose,
        "left": shown.views[0],
        "right": shown.views[1],
        "avatar": shown.avatar_pose,
    }
    return FrameRow(**(values | changes))


def test_the_columns_are_those_of_the_design():
    assert ",".join(TrialRow.columns()) == (
        "participant,session,period,block,trial,condition,scene,start_s,end_s,status,"
        "abort_code,attempt,resumed,frames,dropped,missed_refreshes,live_s,frozen_s,hidden_s,"
        "unfocused_s,part,off_s,not_drawn_s,half_rate_s,untracked_s"
    )
    assert ",".join(QuestionnaireRow.columns()) == (
        "participant,session,period,block,trial,condition,timepoint,instrument,item,"
        "response,asked_s,answered_s,order,part,resumed"
    )
    assert ",".join(RatingRow.columns()) == (
        "participant,session,trial,condition,onset_s,latency_s,instrument,response,missed,resumed"
    )
    assert EventRow.columns() == ("onset_s", "duration_s", "name", "detail", "resumed")
    assert ParticipantRow.columns() == ("participant", "sequence", "status", "enrolled_at", "note")
    columns = FrameRow.columns()
    assert columns[:6] == (
        "session_s", "xr_time_ns", "period_ns", "trial", "should_render", "head_x_m",
    )  # fmt: skip
    assert columns[11] == "head_qw"
    assert columns[12:14] == ("left_x_m", "left_y_m")
    assert columns[26:28] == ("left_fov_left_rad", "left_fov_right_rad")
    assert columns[34] == "avatar_x_m"
    assert columns[40:46] == (
        "avatar_qw", "head_valid", "head_tracked", "session_state", "focus_m", "focus_raw_m"
    )  # fmt: skip
    assert columns[-24:-19] == (
        "cpu_ms", "gpu_ms", "dropped", "missed_refreshes", "discontinuity"
    )  # fmt: skip
    hands = (*pose_columns("left_hand"), *pose_columns("right_hand"))
    late = ("resumed", "user_present", "paused", "wait_ms", "swapchain_wait_ms")
    assert columns[-19:] == (*hands, *late)
    assert len(set(columns)) == len(columns) == len(frame_row().cells())


def test_poses_come_back_from_their_cells():
    pose = Pose(np.array([0.1, 1.7, -1 / 3]), np.array([0.1, 0.2, 0.3, 0.9]))
    row = frame_row(head=pose)
    cells = dict(zip(row.columns(), map(cell_text, row.cells()), strict=True))
    numbers = np.array([float(cells[name]) for name in pose_columns("head")])
    again = Pose(numbers[:3], numbers[3:])
    assert np.array_equal(again.position, pose.position)
    assert np.allclose(again.orientation, pose.orientation, atol=1e-15)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_floats_come_back_exactly(value):
    assert float(cell_text(value)) == value
    assert cell_text(np.float64(value)) == cell_text(value)


def test_what_is_missing_is_blank():
    assert [cell_text(value) for value in (None, math.nan, math.inf, 0, 0.0, True)] == [
        "", "", "", "0", "0.0", "1",
    ]  # fmt: skip


def test_rows_are_in_the_file_before_it_is_closed(tmp_path):
    with Recorder(tmp_path, "P1", 1) as recorder:
        recorder.write(EventRow(0.0, 0.0, "start", 'two\nlines, "quoted"'))
        found = read_rows(recorder.folder / "events.csv")
        recorder.write(frame_row(rays_m=tuple(range(1, 10)), rays_used="011111111"))
        recorder.flush()
        frames = read_rows(recorder.folder / "frames.csv")
    assert found[0]["detail"] == 'two lines, "quoted"'
    assert frames[0]["session_s"] == repr(0.1 + 0.2)
    assert frames[0]["rays_used"] == "011111111"
    assert frames[0]["gpu_ms"] == ""


def test_a_session_is_never_overwritten(tmp_path):
    with Recorder(tmp_path, "P1", 1) as recorder:
        recorder.write(EventRow(0.0, 0.0, "start"))
    before = (recorder.folder / "events.csv").read_bytes()
    with pytest.raises(InputError, match="never overwritten"):
        Recorder(tmp_path, "P1", 1)
    assert (recorder.folder / "events.csv").read_bytes() == before
    assert recorded_sessions(tmp_path, "P1") == [1]


def test_a_full_disk_is_told_and_earlier_rows_stay(tmp_path):
    recorder = Recorder(tmp_path, "P1", 1)
    recorder.write(EventRow(0.0, 0.0, "start"))
    with open("/dev/full", "w") as device:  # noqa: PTH123
        os.dup2(device.fileno(), recorder._files["trials.csv"].fileno())
    with pytest.raises(
        InputError, match="No space left on device; what was written before is kept"
    ):
        recorder.write(
            TrialRow("P1", 1, 1, 1, 1, "a", "s", 0.0, 1.0, "completed", None, 1, 0, 9, 0)
        )
    recorder.close()
    assert len(read_rows(recorder.folder / "events.csv")) == 1


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "study").write_text("a file where the study should be")
    with pytest.raises(InputError, match="cannot write"):
        Recorder(tmp_path / "study", "P1", 1)


def test_enrolment_keeps_sequences_and_fills_the_places_of_those_who_left(tmp_path):
    protocol = tiny_protocol(tmp_path)
    open_study(tmp_path / "S", protocol)
    design = build_design(protocol)
    first = enrol(tmp_path / "S", design, "P01")
    assert enrol(tmp_path / "S", design, "P01") == first
    set_status(tmp_path / "S", "P01", "withdrawn", "session 1: sick")
    (row,) = read_participants(tmp_path / "S")
    assert (row.status, row.note) == ("withdrawn", "session 1: sick")
    with pytest.raises(InputError, match="P01 is withdrawn"):
        enrol(tmp_path / "S", design, "P01")


def test_a_damaged_list_of_participants_is_told_and_not_rewritten(tmp_path):
    protocol = tiny_protocol(tmp_path)
    open_study(tmp_path / "S", protocol)
    enrol(tmp_path / "S", build_design(protocol), "P01")
    file = tmp_path / "S" / "participants.csv"
    cut = file.read_bytes()[:-1]
    file.write_bytes(cut)
    with pytest.raises(InputError, match="half-written") as caught:
        enrol(tmp_path / "S", build_design(protocol), "P02")
    assert caught.value.line == 2
    assert file.read_bytes() == cut


def test_names_that_cannot_be_folders_and_studies_that_are_others(tmp_path):
    protocol = tiny_protocol(tmp_path)
    open_study(tmp_path / "S", protocol)
    open_study(tmp_path / "S", protocol)
    for name in ("../P01", "A" * 65):
        with pytest.raises(InputError, match="1 to 64 letters and digits"):
            enrol(tmp_path / "S", build_design(protocol), name)
    other = protocol.model_copy(update={"name": "other"})
    with pytest.raises(InputError, match="holds a study with protocol `tiny`"):
        open_study(tmp_path / "S", other)


def test_the_manifest_holds_the_protocol_and_what_was_overridden(tmp_path):
    protocol = tiny_protocol(tmp_path)
    machine = Machine(gpu="llvmpipe", shaders={"scene/scene.frag": "ab12"})
    manifest = Manifest("P1", 1, "ab", protocol, machine, {}, "simulated", 7, 0.5, "now")
    manifest.write(tmp_path)
    content = json.loads((tmp_path / "manifest.json").read_text())
    assert content["protocol"]["text"] == protocol.toml
    assert content["protocol"]["sha256"] == protocol.sha256
    assert content["settings"]["conditions"][1]["depth_of_field"]["max_radius_percent"] == 1.75
    assert (content["exposure_override_s"], content["seed"]) == (0.5, 7)
    assert content["shaders"] == {"scene/scene.frag": "ab12"}
    assert content["timing_trust"] == "lockstep"
    assert "numpy" in content["versions"]
