"""Trace files: what is read, what is refused, and where the refusal points."""

import numpy as np
import pytest

from vrcomfort.errors import InputError
from vrcomfort.geometry import rotate
from vrcomfort.importing.head_logs import UNITY_EULER, import_log
from vrcomfort.records.shared_columns import pose_columns
from vrcomfort.traces.trace import read_trace, write_trace


def import_trace(path):
    return import_log(path, UNITY_EULER)


HEADER = "xr_time_ns,head_x_m,head_y_m,head_z_m,head_qx,head_qy,head_qz,head_qw"
ROWS = ["1000,0.1,1.6,0,0,0,0,1", "2000,0.2,1.6,0,0,0,0,1", "3000,0.3,1.6,0,0,0,0,1"]


@pytest.fixture
def write(tmp_path):
    def write(*lines, end="\n"):
        path = tmp_path / "trace.csv"
        path.write_bytes(("\n".join(lines) + end).encode())
        return path

    return write


def refusal(path, reader=read_trace):
    with pytest.raises(InputError) as caught:
        reader(path)
    return caught.value


@pytest.mark.smoke
def test_a_minimal_trace_has_times_and_head_poses(write):
    trace = read_trace(write(HEADER, *ROWS))
    assert trace.time_ns.tolist() == [1000, 2000, 3000]
    assert trace.head.positions[:, 0].tolist() == [0.1, 0.2, 0.3]
    assert trace.cuts.tolist() == [True, False, False]
    assert (trace.eyes, trace.avatar, trace.trial, trace.warnings) == (None, None, None, ())


def test_columns_may_come_in_any_order_among_others(write):
    header = "cpu_ms," + ",".join(reversed(HEADER.split(",")))
    rows = ["," + ",".join(reversed(row.split(","))) for row in ROWS]
    trace = read_trace(write(header, *rows))
    assert trace.time_ns.tolist() == [1000, 2000, 3000]


def test_nanoseconds_beyond_float_precision_stay_exact(write):
    late = 2**62 + 1
    trace = read_trace(write(HEADER, f"{late},0,1.6,0,0,0,0,1", f"{late + 1},0,1.6,0,0,0,0,1"))
    assert trace.time_ns.tolist() == [late, late + 1]


def test_changes_of_trial_and_marked_frames_are_cuts(write):
    rows = [f"{row},{mark}" for row, mark in zip(ROWS, ["1,0", "1,1", "2,0"], strict=True)]
    trace = read_trace(write(HEADER + ",trial,discontinuity", *rows))
    assert trace.cuts.tolist() == [True, True, True]
    assert trace.only_trial("1").time_ns.tolist() == [1000, 2000]
    with pytest.raises(InputError, match="no trial 'x'; it has: 1, 2"):
        trace.only_trial("x")


@pytest.mark.parametrize(
    ("row", "column", "says"),
    [
        ("2000,1e39,1.6,0,0,0,0,1", "head_x_m", "1e+39 m is more than 1000 km away"),
        ("2000,0,-1000001,0,0,0,0,1", "head_y_m", "m is more than 1000 km away; positions are"),
        ("2000,nan,1.6,0,0,0,0,1", "head_x_m", "'nan' is not a finite number"),
        ("2000,0,inf,0,0,0,0,1", "head_y_m", "'inf' is not a finite number"),
        ("2000,0,1.6,,0,0,0,1", "head_z_m", "this cell is empty"),
        ("2000,0,1.6,0,x,0,0,1", "head_qx", "'x' is not a finite number"),
        ("2000,0,1.6,0,0,0,0,1.1", "head_qx", "has length 1.1; a rotation needs length 1"),
        ("2000,0,1.6,0,0,0,0,0", "head_qx", "has length 0"),
        ("1000,0,1.6,0,0,0,0,1", "xr_time_ns", "time stands still"),
        ("900,0,1.6,0,0,0,0,1", "xr_time_ns", "time goes back by 100 ns"),
        ("2e3,0,1.6,0,0,0,0,1", "xr_time_ns", "'2e3' is not a whole number"),
        ("99999999999999999999,0,1.6,0,0,0,0,1", "xr_time_ns", "is not a whole number"),
    ],
)
def test_a_bad_cell_is_refused_with_its_place(write, row, column, says):
    error = refusal(write(HEADER, ROWS[0], row, ROWS[2]))
    assert (error.line, error.column) == (3, column)
    assert says in error.message


def test_a_missing_column_is_named(write):
    error = refusal(write("xr_time_ns,head_x_m", "1,2"))
    assert (error.line, error.column) == (1, "head_y_m")
    assert "the column 'head_y_m' is missing (and head_z_m" in error.message


def test_snap_turns_are_no_cuts_and_are_written_again(tmp_path, write):
    rows = [f"{row},{mark}" for row, mark in zip(ROWS, "021", strict=True)]
    trace = read_trace(write(HEADER + ",discontinuity", *rows))
    assert trace.cuts.tolist() == [True, False, True]
    assert trace.snap_turns.tolist() == [False, True, False]
    write_trace(trace, tmp_path / "again.csv")
    again = read_trace(tmp_path / "again.csv")
    assert again.cuts.tolist() == trace.cuts.tolist()
    assert again.snap_turns.tolist() == trace.snap_turns.tolist()


HAND = ",".join(pose_columns("left_hand"))


def test_a_hand_may_be_missing_in_some_rows(tmp_path, write):
    hands = ["0.1,1,-0.3,0,0,0,1", ",,,,,,", "0.2,1,-0.3,0,0,0,1"]
    rows = [f"{row},{hand}" for row, hand in zip(ROWS, hands, strict=True)]
    trace = read_trace(write(f"{HEADER},{HAND}", *rows))
    assert trace.right_hand is None
    np.testing.assert_array_equal(trace.left_hand.positions[:, 0], [0.1, np.nan, 0.2])
    write_trace(trace, tmp_path / "again.csv")
    again = read_trace(tmp_path / "again.csv")
    np.testing.assert_array_equal(again.left_hand.cells(), trace.left_hand.cells())


@pytest.mark.parametrize(
    ("hand", "column", "says"),
    [
        ("0.1,1,,0,0,0,1", "left_hand_z_m", "this cell is empty"),
        ("0.1,1,0,0,0,0,2", "left_hand_qx", "has length 2"),
    ],
)
def test_half_of_a_hand_is_refused_with_its_place(write, hand, column, says):
    error = refusal(write(f"{HEADER},{HAND}", f"{ROWS[0]},,,,,,,", f"{ROWS[1]},{hand}"))
    assert (error.line, error.column) == (3, column)
    assert says in error.message


def test_half_of_an_optional_pose_is_refused(write):
    error = refusal(write(HEADER + ",avatar_x_m", ROWS[0] + ",0"))
    assert error.column == "avatar_y_m"


def test_a_row_of_another_width_is_refused(write):
    error = refusal(write(HEADER, ROWS[0], "2000,0", ROWS[2]))
    assert error.line == 3
    assert "2 cells, the header has 8" in error.message


@pytest.mark.parametrize("last", ["3000,0.3,1.6", "3000,0.3,1.6,0,0,0,0,1"])
def test_a_half_written_last_line_is_reported_and_left_out(write, last):
    trace = read_trace(write(HEADER, *ROWS[:2], last, end=""))
    assert trace.time_ns.tolist() == [1000, 2000]
    assert "line 4: the last row is half-written" in trace.warnings[0]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"\x89PNG\r\n\x1a\n\x00\xff", "not a text file"),
        (b"glTF\x02\x00\x00\x00", "not a text file"),
        (b"", "the file is empty"),
        (HEADER.encode() + b"\n", "no complete row"),
        (HEADER.encode() + b",head_x_m\n", "column 'head_x_m' appears twice"),
        (b"Time x y z alpha beta gamma \n1,2,3,4,5,6,7\n", "import-trace FILE"),
    ],
)
def test_another_kind_of_file_is_refused(tmp_path, content, says):
    path = tmp_path / "file"
    path.write_bytes(content)
    assert says in refusal(path).message


def test_files_that_cannot_be_opened_are_refused(tmp_path):
    assert "no such file" in refusal(tmp_path / "none.csv").message
    assert "cannot be read" in refusal(tmp_path).message


def test_impossible_fields_of_view_are_refused(write):
    sides = ("left", "right", "up", "down")
    fovs = ",".join(f"{eye}_fov_{side}_rad" for eye in ("left", "right") for side in sides)
    error = refusal(write(f"{HEADER},{fovs}", ROWS[0] + ",-1,1,1,-1,-1,1,-1,1"))
    assert error.column == "right_fov_down_rad"


def test_writing_and_reading_back_is_exact(tmp_path, write):
    trace = import_trace(write(UNITY, *unity_rows(np.random.default_rng(3).random((5, 6)) * 90)))
    write_trace(trace, tmp_path / "again.csv")
    again = read_trace(tmp_path / "again.csv")
    assert np.array_equal(again.head.cells(), trace.head.cells())
    assert np.array_equal(again.time_ns, trace.time_ns)


UNITY = "Time x y z alpha beta gamma "


def unity_rows(samples):
    return [
        ",".join([f"{13 + 0.014 * i:.5f}", *(repr(v) for v in sample)])
        for i, sample in enumerate(np.asarray(samples, float).tolist())
    ]


@pytest.mark.parametrize(
    ("euler_deg", "forward"),
    [
        ([0, 0, 0], [0, 0, -1]),  # Unity looks along +z, which is our −Z
        ([0, 90, 0], [1, 0, 0]),  # a turn to the right
        ([30, 0, 0], [0, -0.5, -np.sqrt(0.75)]),  # Unity's positive x turn looks down
        ([30, 90, 45], [np.sqrt(0.75), -0.5, 0]),  # roll comes first and leaves forward alone
    ],
)
def test_unity_angles_become_our_directions(write, euler_deg, forward):
    trace = import_trace(write(UNITY, *unity_rows([[1, 2, 3, *euler_deg]])))
    assert trace.head.positions[0].tolist() == [1, 2, -3]
    np.testing.assert_allclose(rotate(trace.head.orientations[0], [0, 0, -1]), forward, atol=1e-15)


def test_unity_roll_tips_the_same_way(write):
    trace = import_trace(write(UNITY, *unity_rows([[0, 0, 0, 0, 0, 90]])))
    # A left-handed turn from x to y keeps tipping the head's right side up in our frame.
    np.testing.assert_allclose(rotate(trace.head.orientations[0], [1, 0, 0]), [0, 1, 0], atol=1e-15)


def test_unity_times_are_exact_nanoseconds(write):
    trace = import_trace(write(UNITY, "1700000000.123456789,0,0,0,0,0,0"))
    assert trace.time_ns.tolist() == [1_700_000_000_123_456_789]


@pytest.mark.parametrize(
    ("lines", "line", "column", "says"),
    [
        ([HEADER, *ROWS], 1, None, "a column 'Time' that is not there"),
        ([UNITY, "1,0,0,0,0,0,0", "x,0,0,0,0,0,0"], 3, "Time", "not a time in s"),
        ([UNITY, "1,0,0,0,0,0,0", "1e99,0,0,0,0,0,0"], 3, "Time", "not a time in s"),
        ([UNITY, "1,0,0,0,0,0,0", "1,0,0,0,0,0,0"], 3, "Time", "time stands still"),
        ([UNITY, "1,0,0,0,0,0,0", "1_0,0,0,0,0,0,0"], 3, "Time", "not a time in s"),
        ([UNITY, "1,0,0,0,0,0,0", "2,0,0,0,0,nan,0"], 3, "beta", "not a finite number"),
        ([UNITY, "1,0,0,1e39,0,0,0"], 2, "x", "1e+39 m is more than 1000 km away"),
    ],
)
def test_a_bad_unity_log_is_refused_with_its_place(write, lines, line, column, says):
    error = refusal(write(*lines), import_trace)
    assert (error.line, error.column) == (line, column)
    assert says in error.message
