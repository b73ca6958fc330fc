"""Recordings of hours are read and played in the memory that their numbers need."""

from __future__ import annotations

import csv
import tracemalloc
from itertools import islice

import numpy as np
import pytest

from vrcomfort.errors import InputError
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.importing.head_logs import UNITY_EULER, import_log
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.shared_columns import HANDS
from vrcomfort.traces import table
from vrcomfort.traces.gaze_track import read_gaze
from vrcomfort.traces.trace import read_trace, write_trace

ROWS_AT_ONCE = 128
FEW, MANY = 3 * ROWS_AT_ONCE, 35 * ROWS_AT_ONCE + 7


@pytest.fixture(autouse=True)
def small_parts(monkeypatch):
    monkeypatch.setattr(table, "ROWS_AT_ONCE", ROWS_AT_ONCE)


def recording(path, rows: int, *, hands: bool = False, **changed):
    """Write a frames.csv as a session does; `changed` has column → (row → cell)."""
    columns = FrameRow.columns()
    cells = dict.fromkeys(columns, "0.25") | {"period_ns": "10000000", "rays_used": "1" * 9}
    cells |= {name: "1.0" if name.endswith("_qw") else "0.0" for name in columns if "_q" in name}
    for side in ("left", "right"):
        cells |= {f"{side}_fov_left_rad": "-0.8", f"{side}_fov_down_rad": "-0.8"}
    cells["discontinuity"] = "0"
    if not hands:
        cells |= dict.fromkeys(HANDS, "")
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        for row in range(rows):
            cells |= {"xr_time_ns": f"{10**7 * row}", "trial": f"{1 + row // 1500}"}
            cells["head_x_m"] = repr(row / 7)
            now = {name: change[row] for name, change in changed.items() if row in change}
            writer.writerow((cells | now).values())
    return path


def peak_bytes(path) -> int:
    tracemalloc.start()
    read_trace(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak


@pytest.mark.slow
@pytest.mark.parametrize("hands", [False, True])
def test_a_longer_trace_needs_the_memory_of_its_numbers_and_of_one_part(tmp_path, hands):
    few = peak_bytes(recording(tmp_path / "few.csv", FEW, hands=hands))
    many = peak_bytes(recording(tmp_path / "many.csv", MANY, hands=hands))
    numbers = 2 + 7 + 14 + 8 + 7 + 1  # time and period, head, eyes, fields of view, avatar, trial
    numbers += 14 if hands else 0
    # All numbers, and once more those of one group while its parts are joined.
    assert (many - few) / (MANY - FEW) < 8 * (numbers + 14) + 8


def test_parts_are_one_trace(tmp_path):
    trace = read_trace(recording(tmp_path / "frames.csv", MANY, discontinuity={1100: "1"}))
    assert len(trace) == MANY
    np.testing.assert_array_equal(trace.time_ns, 10**7 * np.arange(MANY))
    np.testing.assert_array_equal(trace.head.positions[:, 0], np.arange(MANY) / 7)
    expected = {0, 1100, *range(1500, MANY, 1500)}
    assert set(np.flatnonzero(trace.cuts).tolist()) == expected
    assert trace.trial[1499:1501] == ("1", "2")
    assert trace.eyes[1].orientations.shape == (MANY, 4)
    assert trace.fovs.shape == (MANY, 2, 4)
    assert trace.warnings == ()


@pytest.mark.slow
def test_writing_a_trace_and_reading_it_changes_no_byte(tmp_path):
    trace = read_trace(recording(tmp_path / "frames.csv", MANY))
    write_trace(trace, tmp_path / "once.csv")
    write_trace(read_trace(tmp_path / "once.csv"), tmp_path / "twice.csv")
    once = (tmp_path / "once.csv").read_bytes()
    assert once == (tmp_path / "twice.csv").read_bytes()
    assert once.count(b"\n") == MANY + 1


@pytest.mark.parametrize("row", [ROWS_AT_ONCE, ROWS_AT_ONCE + 1, 2 * ROWS_AT_ONCE - 1])
def test_a_fault_between_or_in_parts_has_its_line(tmp_path, row):
    times = {row: f"{10**7 * (row - 1)}"}
    path = recording(tmp_path / "a.csv", 2 * ROWS_AT_ONCE, xr_time_ns=times)
    with pytest.raises(InputError, match="time stands still") as caught:
        read_trace(path)
    assert (caught.value.line, caught.value.column) == (row + 2, "xr_time_ns")


@pytest.mark.parametrize("rows", [ROWS_AT_ONCE - 1, ROWS_AT_ONCE, ROWS_AT_ONCE + 1])
def test_a_half_row_at_the_end_of_a_part_is_left_out_and_told(tmp_path, rows):
    path = recording(tmp_path / "a.csv", rows)
    with path.open("a") as stream:
        stream.write("1,2,3")
    trace = read_trace(path)
    assert len(trace) == rows
    assert len(trace.warnings) == 1
    assert f"line {rows + 2}: the last row is half-written" in trace.warnings[0]


def test_gaze_and_logs_of_other_programs_are_read_in_parts_too(tmp_path):
    gaze = tmp_path / "gaze.csv"
    rows = "".join(f"{10**7 * k},1,0,0,0,0,0,-1\n" for k in range(MANY))
    columns = "origin_x_m,origin_y_m,origin_z_m,direction_x,direction_y,direction_z"
    gaze.write_text(f"xr_time_ns,valid,{columns}\n{rows}")
    track = read_gaze(gaze)
    assert len(track.time_ns) == len(track.origins) == MANY
    assert track.valid.all()
    log = tmp_path / "log.txt"
    log.write_text(
        "Time x y z alpha beta gamma\n" + "".join(f"{k},0,1,0,0,9,0\n" for k in range(MANY))
    )
    trace = import_log(log, UNITY_EULER)
    assert len(trace) == MANY
    assert np.flatnonzero(trace.cuts).tolist() == [0]


def test_playing_takes_no_memory_for_what_is_to_come(tmp_path):
    trace = read_trace(recording(tmp_path / "frames.csv", MANY))
    headset = PlaybackHeadset(trace, image_size_px=(8, 8), loop=False)
    tracemalloc.start()
    for frame in islice(headset.frames(), 500):
        headset.submit(frame, None)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 100_000
