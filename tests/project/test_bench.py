"""`make bench` starts: its cases are settings that protocols may have."""

import json
import os
import subprocess
import sys

import pytest

from bench.many_answers import PARTS
from tests.support.places import ROOT
from vrcomfort.report import build


def test_the_parts_of_a_report_that_are_timed_are_functions():
    assert all(callable(getattr(build, name)) for name in PARTS.values())


@pytest.mark.slow
def test_the_benchmarks_and_their_cases_are_made():
    shown = subprocess.run(
        [sys.executable, "-W", "error", "-m", "bench", "--help"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert shown.returncode == 0, shown.stderr
    assert "requires" in shown.stdout


@pytest.mark.slow
def test_a_side_of_the_comparison_draws_records_and_counts():
    scenes = ROOT / "scenes"
    wanted = {
        "scene": str(scenes / "temple.glb"),
        "trace": str(scenes / "temple_walk.csv"),
        "effects": False,
    }
    shown = subprocess.run(
        [sys.executable, str(ROOT / "bench" / "frame_worker.py"), json.dumps(wanted)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        input="2\n",
        capture_output=True,
        text=True,
        check=False,
    )
    assert shown.returncode == 0, shown.stderr
    counts, laps = map(json.loads, shown.stdout.splitlines())
    assert 0 < counts["scene draws"] < counts["draws"] < counts["calls"]
    assert len(laps) == 2
    assert all(0 < lap["loop_s"] < 1 and lap["opengl_s"] > 0 for lap in laps)


@pytest.mark.slow
def test_frames_are_timed_on_whatever_gpu_there_is(tmp_path):
    asked = ["--out", str(tmp_path), "--sizes", "32x40", "--scenes", "temple"]
    shown = subprocess.run(
        [sys.executable, "-W", "error", "-m", "bench.gpu", *asked, "--methods", "ours 36 samples"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert shown.returncode == 0, shown.stderr
    told = json.loads((tmp_path / "gpu.json").read_text())
    plain, ours, *_ = (row for row in told["rows"] if row["effect"] == "depth_of_field")
    assert plain["effect ms"] == plain["bytes per pixel"] == 0
    assert 0 < ours["effect ms"] < ours["frame ms"]
    assert ours["copy ms"] < ours["effect ms"]
    assert "GPU: " in told["notes"][0]
