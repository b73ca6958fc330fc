"""Head logs of other programs come in with the poses that they were written from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.importing.head_logs import (
    UNITY_EULER,
    import_log,
    parse_log_mapping,
    suggest_log_mapping,
)
from vrcomfort.importing.head_logs.columns import groups_of, positions
from vrcomfort.traces.trace import Trace, read_trace

Poses = tuple[NDArray[np.float64], Rotation]
"""(n, 3) metres and rotations in OpenXR's frame: x right, y up, z back."""
SAMPLES, HZ = 400, 72.0
UNITY = np.diag([1.0, 1.0, -1.0])
"""Unity's coordinates from ours."""
UNREAL = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Unreal's (x ahead, y right, z up) from ours."""


def walk(seed: int = 5) -> Poses:
    """Return the head of a person who walks a bent way, looks about, nods and tips the head."""
    draw = np.random.default_rng(seed)
    time = np.arange(SAMPLES) / HZ
    waves = [
        sum(a * np.sin(2 * np.pi * f * time + p) for a, f, p in draw.uniform(0.2, 1, (3, 3)))
        for _ in range(3)
    ]
    heading = 0.6 * time + 0.5 * waves[0]
    turns = Rotation.from_euler("YXZ", np.stack([heading, 0.3 * waves[1], 0.1 * waves[2]], axis=1))
    ahead = np.stack([-np.sin(heading), np.zeros(SAMPLES), -np.cos(heading)], axis=1)
    places = np.cumsum(ahead / HZ, axis=0) + turns.apply([0.0, 0.08, -0.1]) + [0.3, 1.5, -0.4]
    return places, turns


def in_frame(poses: Poses, frame: NDArray[np.float64]) -> tuple[NDArray[np.float64], Rotation]:
    """Return positions and rotations as numbers of another frame: ``p' = F p``, ``R' = F R Fᵀ``."""
    places, turns = poses
    return places @ frame.T, Rotation.from_matrix(frame @ turns.as_matrix() @ frame.T)


def seconds(*, since: float = 0.0) -> NDArray[np.float64]:
    return since + np.arange(SAMPLES) / HZ


def write(
    file: Path, header: Sequence[str], columns: Iterable[Iterable[object]], separator: str = ","
) -> Path:
    rows = [header, *([str(cell) for cell in row] for row in zip(*columns, strict=True))]
    file.write_text("\n".join(separator.join(row) for row in rows) + "\n", encoding="utf-8")
    return file


def digits(values: Iterable[float], count: int = 9) -> list[str]:
    return [f"{value:.{count}f}" for value in values]


UXF_HEADER = ["time", "pos_x", "pos_y", "pos_z", "rot_x", "rot_y", "rot_z"]


def uxf(folder: Path, poses: Poses) -> Path:
    """Write UXF's tracker of the camera: seconds since the start, Unity's Euler angles."""
    places, turns = in_frame(poses, UNITY)
    y, x, z = turns.as_euler("YXZ", degrees=True).T % 360
    columns = [digits(seconds(since=7.32)), *map(digits, places.T), *map(digits, (x, y, z))]
    return write(folder / "main_camera_movement_T001.csv", UXF_HEADER, columns)


def uxf_quaternions(folder: Path, poses: Poses) -> Path:
    """Write the tracker of a fork of UXF: quaternions, a matrix beside them, untracked rows."""
    places, turns = in_frame(poses, UNITY)
    header = [*UXF_HEADER, "rot_w", *(f"wlm_{i}{k}" for i in range(2) for k in range(2))]
    columns = [digits(seconds()), *map(digits, places.T), *map(digits, turns.as_quat().T)]
    columns += [["0.5"] * SAMPLES for _ in range(4)]
    return write(folder / "head_movement_T001.csv", header, columns)


def quaternions(folder: Path, poses: Poses) -> Path:
    """Write a log of the Oculus SDK: w first, both hands beside the head, milliseconds."""
    places, turns = poses
    x, y, z, w = turns.as_quat().T
    header = ["LeftTouchPosX", "LeftTouchPosY", "LeftTouchPosZ", "HeadPosX", "HeadPosY", "HeadPosZ"]
    header += [f"HeadOrientation{axis}" for axis in "WXYZ"] + ["time_ms"]
    columns = [["0.1"] * SAMPLES, ["0.9"] * SAMPLES, ["-0.3"] * SAMPLES, *map(digits, places.T)]
    columns += [*map(digits, (w, x, y, z)), digits(seconds(since=1.7e9) * 1e3, 6)]
    return write(folder / "movement.csv", header, columns)


def decimal_commas(folder: Path, poses: Poses) -> Path:
    """Write a German log: semicolons, decimal commas, centimetres, radians, microseconds."""
    places, turns = in_frame(poses, UNITY)
    y, x, z = turns.as_euler("YXZ").T
    header = ["Zeit_us", "Kopf_Pos_x_cm", "Kopf_Pos_y_cm", "Kopf_Pos_z_cm"]
    header += ["Kopf_Rot_x_rad", "Kopf_Rot_y_rad", "Kopf_Rot_z_rad"]
    numbers = [seconds() * 1e6, *(places.T * 100), x, y, z]
    columns = [[text.replace(".", ",") for text in digits(values)] for values in numbers]
    return write(folder / "kopf_unity.csv", header, columns, ";")


def left_handed(folder: Path, poses: Poses) -> Path:
    """Write a log of Unreal: x ahead, y right, z up in centimetres, pitch, yaw and roll."""
    places, turns = in_frame(poses, UNREAL)
    z, y, x = turns.as_euler("ZYX", degrees=True).T
    header = ["Timestamp", "HMD.X", "HMD.Y", "HMD.Z", "HMD.Pitch", "HMD.Yaw", "HMD.Roll"]
    # Unreal's pitch looks up and its roll tips to the right, against its own left-hand rule.
    columns = [digits(seconds()), *map(digits, places.T * 100), *map(digits, (-y, z, -x))]
    return write(folder / "ue5_log.tsv", header, columns, "\t")


def vectors(folder: Path, poses: Poses) -> Path:
    """Write what Unity's `ToString` gives: vectors in parentheses, unquoted."""
    places, turns = in_frame(poses, UNITY)
    y, x, z = turns.as_euler("YXZ", degrees=True).T % 360
    together = [
        ["(" + ", ".join(f"{value:.9f}" for value in row) + ")" for row in table]
        for table in (places, np.stack([x, y, z], axis=1))
    ]
    stamps = [str(round(t * 1e9)) for t in seconds()]
    header = ["Timestamp(ns)", "GameTime", "HeadPosition", "HeadRotation"]
    return write(folder / "HeadLog.csv", header, [stamps, digits(seconds(), 3), *together])


def clock_times(folder: Path, poses: Poses) -> Path:
    """Write clock times over midnight, spaces between, no position."""
    _, turns = poses
    times = [np.datetime64("2024-05-01T23:59:58", "us") + round(t * 1e6) for t in seconds()]
    stamps = [str(each).split("T")[1] for each in times]
    header = ["clock", "openxr_qx", "openxr_qy", "openxr_qz", "openxr_qw"]
    return write(folder / "head.txt", header, [stamps, *map(digits, turns.as_quat().T)], " ")


LOGS: dict[str, Callable[[Path, Poses], Path]] = {
    each.__name__: each
    for each in (
        uxf, uxf_quaternions, quaternions, decimal_commas, left_handed, vectors, clock_times,
    )
}  # fmt: skip
CERTAIN = {"uxf", "uxf_quaternions", "vectors"}


def imported(file: Path, folder: Path) -> Trace:
    """Import a log as a person does who agrees with everything."""
    mapping, out = folder / "map.toml", folder / "trace.csv"
    runner = CliRunner()
    suggested = runner.invoke(app, ["import-trace", str(file), "--suggest", "--out", str(mapping)])
    assert suggested.exit_code == 0, suggested.output
    text = mapping.read_text(encoding="utf-8").replace('answer = ""', 'answer = "yes"')
    mapping.write_text(text, encoding="utf-8")
    made = runner.invoke(
        app, ["import-trace", str(file), "--mapping", str(mapping), "--out", str(out)]
    )
    assert made.exit_code == 0, made.output
    return read_trace(out)


@pytest.mark.parametrize("name", LOGS)
def test_poses_come_in_as_they_were(name: str, tmp_path: Path) -> None:
    poses = walk()
    trace = imported(LOGS[name](tmp_path, poses), tmp_path)
    places = np.tile([0, 1.6, 0], (SAMPLES, 1)) if name == "clock_times" else poses[0]
    np.testing.assert_allclose(trace.head.positions, places, atol=1e-6)
    apart = (Rotation.from_quat(trace.head.orientations).inv() * poses[1]).magnitude()
    assert np.max(apart) < 1e-6
    steps = np.diff(trace.time_ns) * 1e-9
    np.testing.assert_allclose(steps, 1 / HZ, atol=1e-6)
    assert np.flatnonzero(trace.cuts).tolist() == [0]


@pytest.mark.parametrize("name", sorted(CERTAIN))
def test_a_log_without_doubt_needs_no_mapping(name: str, tmp_path: Path) -> None:
    file, out = LOGS[name](tmp_path, walk()), tmp_path / "trace.csv"
    assert suggest_log_mapping(file).doubts == ()
    made = CliRunner().invoke(app, ["import-trace", str(file), "--out", str(out)])
    assert made.exit_code == 0, made.output
    assert len(read_trace(out)) == SAMPLES


def test_what_is_uncertain_is_asked_with_its_consequence(tmp_path: Path) -> None:
    file = quaternions(tmp_path, walk())
    (doubt,) = suggest_log_mapping(file).doubts
    assert "Which frame is it" in doubt.question
    assert "left and right turns" in doubt.stake.otherwise
    made = CliRunner().invoke(app, ["import-trace", str(file), "--out", str(tmp_path / "t.csv")])
    assert made.exit_code != 0
    assert not (tmp_path / "t.csv").exists()


def test_a_hand_is_not_taken_for_the_head_without_a_question(tmp_path: Path) -> None:
    file = uxf(tmp_path, walk())
    file = file.rename(tmp_path / "shuttle_movement_T001.csv")
    (doubt,) = suggest_log_mapping(file).doubts
    assert "poses of the head" in doubt.question


@pytest.mark.parametrize("frame", [UNITY, np.eye(3)])
def test_the_frame_is_the_one_in_which_heads_move_as_they_look(
    frame: NDArray[np.float64], tmp_path: Path
) -> None:
    places, turns = in_frame(walk(seed=8), frame)
    columns = [digits(seconds()), *map(digits, places.T), *map(digits, turns.as_quat().T)]
    header = ["time", *(f"head_p{a}" for a in "xyz"), *(f"head_r{a}" for a in "xyzw")]
    mapping = parse_log_mapping(
        suggest_log_mapping(write(tmp_path / "log.csv", header, columns)).text, None
    )
    assert mapping.axes.hand == ("left" if frame is UNITY else "right")


def rows_of(file: Path) -> list[str]:
    return file.read_text(encoding="utf-8").splitlines()


def test_gaps_untracked_rows_and_repeated_times(tmp_path: Path) -> None:
    file = uxf(tmp_path, walk())
    header, *rows = rows_of(file)
    untracked = rows[50].split(",")[0] + ",NA,NA,NA,NA,NA,NA"
    rows = [*rows[:50], untracked, *rows[51:100], rows[99], *rows[200:]]
    file.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    trace = imported(file, tmp_path)
    assert len(trace) == SAMPLES - 101
    assert np.flatnonzero(trace.cuts).tolist() == [0, 50, 99]


def test_one_trial_is_chosen_where_a_file_holds_several(tmp_path: Path) -> None:
    file = uxf(tmp_path, walk())
    header, *rows = rows_of(file)
    both = [f"{row},{trial}" for trial in (1, 2) for row in rows]
    file.write_text("\n".join([f"{header},trial_num", *both]) + "\n", encoding="utf-8")
    suggested = suggest_log_mapping(file)
    assert "goes back" in suggested.doubts[0].assumed
    assert "choose one by where" in suggested.doubts[0].assumed
    text = suggested.text.replace("[read]", '[where]\ntrial_num = "2"\n\n[read]')
    assert len(import_log(file, parse_log_mapping(text, None))) == SAMPLES


@pytest.mark.parametrize(
    ("change", "line", "column", "says"),
    [
        (("7.375555556", "x"), 6, "time", "'x' is not a time in s"),
        (("7.375555556", "inf"), 6, "time", "'inf' is not a time in s"),
        (("7.375555556", "1e300"), 6, "time", "'1e300' is not a time in s"),
        (("7.375555556", "7.3"), 6, "time", "time goes back by"),
        ((",", ";"), 6, None, "cells, the others have 7"),
    ],
)
def test_a_wrong_row_is_refused_with_its_place(
    change: tuple[str, str], line: int, column: str | None, says: str, tmp_path: Path
) -> None:
    file = uxf(tmp_path, walk())
    text = suggest_log_mapping(file).text
    rows = rows_of(file)
    rows[5] = rows[5].replace(*change)
    file.write_text("\n".join(rows) + "\n", encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        import_log(file, parse_log_mapping(text, None))
    assert (refusal.value.line, refusal.value.column) == (line, column)
    assert says in refusal.value.message


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "empty"),
        ("a,b\n1,2\n3,4\n", "orientation"),
        ("pos_x,pos_y,pos_z,rot_x,rot_y,rot_z\n0,1,0,0,0,0\n0,1,0,0,0,0\n", "no column of times"),
        (
            "frameCount,head_qx,head_qy,head_qz,head_qw\n0,0,0,0,1\n1,0,0,0,1\n2,0,0,0,1\n",
            "rate_hz",
        ),
        ("xr_time_ns,head_qw\n1,2\n2,2\n", "a trace already"),
    ],
)
def test_a_file_that_is_no_log_is_refused(content: str, says: str, tmp_path: Path) -> None:
    file = tmp_path / "file.csv"
    file.write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match=says):
        suggest_log_mapping(file)


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ('[time]\nunit = "s"', "needs column"),
        ('[time]\ncolumn = "t"\nunit = "frames"', "rate_hz go together"),
        ('[time]\ncolumn = "t"\n[axes]\nforward = "-x"', "three different axes"),
    ],
)
def test_a_mapping_that_cannot_be_is_refused(keys: str, says: str) -> None:
    text = f'format_version = 1\n{keys}\n[orientation]\nquaternion = ["a", "b", "c", "d"]\n'
    with pytest.raises(InputError, match=says):
        parse_log_mapping(text, None)


def test_frames_are_counted_at_their_rate(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("frame,qx,qy,qz,qw\n0,0,0,0,1\n9,0,0,0,1\n", encoding="utf-8")
    text = (
        'format_version = 1\ntime = { column = "frame", unit = "frames", rate_hz = 90 }\n'
        'orientation = { quaternion = ["qx", "qy", "qz", "qw"] }\n'
    )
    assert import_log(file, parse_log_mapping(text, None)).time_ns.tolist() == [0, 10**8]


def test_ticks_count_from_1970(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    ticks = 638_500_000_000_000_000
    rows = [f"{ticks + 111_111 * n},0,0,0,1" for n in range(3)]
    file.write_text("\n".join(["time,head_qx,head_qy,head_qz,head_qw", *rows]), encoding="utf-8")
    trace = suggest_log_mapping(file).trace
    assert trace is not None
    assert trace.time_ns[0] == (ticks - 621_355_968_000_000_000) * 100


def test_the_columns_of_unity_logs_are_known(tmp_path: Path) -> None:
    file = tmp_path / "log.txt"
    file.write_text("Time x y z alpha beta gamma \n0,1,2,3,0,90,0\n1,1,2,3,0,90,0\n")
    trace = import_log(file, UNITY_EULER)
    assert suggest_log_mapping(file).doubts == ()
    assert trace.head.positions[0].tolist() == [1, 2, -3]


def test_time_since_the_start_is_preferred_to_the_wall_clock(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    rows = [f"{1764381600000 + 11 * n},{12.5 + 0.0112 * n:.4f},0,0,0,1" for n in range(3)]
    heading = "WallClockMs,RealtimeSinceStartup,head_qx,head_qy,head_qz,head_qw"
    file.write_text("\n".join([heading, *rows]), encoding="utf-8")
    trace = suggest_log_mapping(file).trace
    assert trace is not None
    assert np.diff(trace.time_ns).tolist() == [11_200_000, 11_200_000]


def test_columns_that_are_called_positions_are_the_likeliest() -> None:
    named = [f"{stem}_{axis}" for stem in ("head", "head_position") for axis in "xyz"]
    found = positions(groups_of(named))
    assert found[0].columns == {axis: f"head_position_{axis}" for axis in "xyz"}
