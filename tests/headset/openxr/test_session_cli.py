"""Whole sessions from the command line, with a Monado runtime that follows a trace and a script."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from itertools import cycle, islice
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.support.openxr import (
    BEST_PRACTICES,
    VALIDATION,
    needs_monado,
    services_of,
    validation_environment,
)
from tests.support.places import ROOT
from tests.support.study import smoke_with
from tests.support.waiting import SESSION_S, WAIT_S
from vrcomfort.resources import data_folder

pytest.importorskip("xr", reason="pyopenxr is not installed")


pytestmark = needs_monado

TRACE = data_folder("scenes") / "temple_walk.csv"
SCRIPT = (0, 1, 2, 3)
LONG_S = 10.0
"""Of an exposure in the middle of which something is to happen, on a machine of any speed."""
HEAD_POSITION = ["head_x_m", "head_y_m", "head_z_m"]
HEAD_TURN = ["head_qx", "head_qy", "head_qz", "head_qw"]


CLIENT = """
import atexit, json, sys
from tests.support.openxr_best_practices import BestPractices
atexit.register(lambda said=BestPractices(): print(json.dumps(said.counts())))
from vrcomfort.cli import main
main()
"""
"""The command, which ends with what the best-practices layer has counted."""


def command(folder: Path, *more: str, exposure_s: float = 4.0) -> list[str]:
    """Return a rehearsal of the smoke study, whose exposures are long enough to rate in."""
    answers = folder / "answers.txt"
    answers.write_text(" ".join(map(str, SCRIPT * 60)) + "  # in the order of the questions\n")
    return [
        *("run", str(smoke_with(folder, exposure_s)), "--participant", "P01"),
        *("--out", str(folder / "study"), "--headset", "openxr", "--size", "64x80", "--quiet"),
        *("--monado-trace", str(TRACE), "--monado-answers", str(answers), *more),
    ]


def read(folder: Path, file: str) -> pd.DataFrame:
    return pd.read_csv(folder / "study" / "sub-P01" / "ses-1" / file, keep_default_na=False)


def run(*words: str) -> subprocess.CompletedProcess[str]:
    command = ["vrcomfort", *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=SESSION_S, check=False)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a whole session, run with both validation layers on."""
    folder = tmp_path_factory.mktemp("session")
    environment = {
        **os.environ,
        "PYTHONPATH": f"{ROOT}:{os.environ.get('PYTHONPATH', '')}",
        "XR_ENABLE_API_LAYERS": f"{VALIDATION}:{BEST_PRACTICES}",
        **validation_environment(folder / "validation.txt"),
    }
    done = subprocess.run(
        [sys.executable, "-c", CLIENT, *command(folder)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=SESSION_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    (folder / "best_practices.json").write_text(done.stdout.splitlines()[-1])
    return folder


def said(folder: Path) -> list[int]:
    """Return all answers on record, in the order in which they were given."""
    asked, rated = read(folder, "questionnaires.csv"), read(folder, "ratings.csv")
    rated = rated[rated["missed"] == 0]
    times = [*asked["answered_s"], *(rated["onset_s"] + rated["latency_s"].astype(float))]
    given = [*asked["response"], *rated["response"]]
    return [int(answer) for _, answer in sorted(zip(times, given, strict=True))]


def assert_follows_the_trace(shown: pd.DataFrame) -> None:
    """Each pose of an exposure is one of the trace's, and they come in the trace's order.

    The feed moves on by one sample for each frame, and begins the trace again at its end. A frame
    may still have the pose of the one before, where the driver had no time to read the newest.
    """
    fed, seen = (table[HEAD_POSITION].to_numpy() for table in (pd.read_csv(TRACE), shown))
    distance_m = np.abs(fed[None] - seen[:, None]).max(axis=2)
    assert distance_m.min(axis=1).max() <= 1e-6
    places = distance_m.argmin(axis=1)
    steps = np.diff(places) % len(fed)
    assert steps.sum() <= len(shown) + 1
    turned = pd.read_csv(TRACE)[HEAD_TURN].to_numpy()[places]
    along = np.abs((turned * shown[HEAD_TURN].to_numpy()).sum(axis=1))
    assert (along >= 1 - 1e-6).all()


def test_the_validation_layers_have_nothing_to_say_of_a_whole_session(session: Path) -> None:
    assert json.loads((session / "best_practices.json").read_text()) == {}
    said = (session / "validation.txt").read_text()
    assert "VALID_DEBUG" in said
    assert "VALID_ERROR" not in said
    assert "VALID_WARN" not in said
    events = set(read(session, "events.csv")["name"])
    assert "session_state" in events
    assert not {"openxr_warning", "openxr_error"} & events


def test_a_whole_session_records_the_trace_and_the_script_and_is_reported(
    session: Path, tmp_path: Path
) -> None:
    study = session / "study"
    manifest = json.loads((study / "sub-P01" / "ses-1" / "manifest.json").read_text())
    assert "Monado" in manifest["runtime"]
    assert manifest["headset"]["image_format"] == "SRGB8_ALPHA8"
    assert manifest["respondent"] == "panel"

    timepoints = read(session, "questionnaires.csv")["timepoint"].value_counts().to_dict()
    assert timepoints == {"baseline": 16, "post": 64}
    ratings = read(session, "ratings.csv")
    assert set(ratings["trial"]) == {1, 2, 3, 4}
    assert (ratings["missed"] == 0).sum() >= 2
    answers = said(session)
    assert answers == list(islice(cycle(SCRIPT), len(answers)))

    for _, shown in read(session, "frames.csv").groupby("trial"):
        assert_follows_the_trace(shown)
    timing = read(session, "timing.csv")
    assert timing["frames"].tolist() == read(session, "trials.csv")["frames"].tolist()
    assert (timing["interval_median_ms"].astype(float) >= 40).all()
    assert set(timing["gpu_median_ms"]) == {""}  # a software rasteriser

    reported = run("report", str(study), "--figures", "none", "--out", str(tmp_path / "report"))
    assert reported.returncode == 0, reported.stderr
    results = json.loads((tmp_path / "report" / "results.json").read_text())
    assert results["participants"]["n"] == 1
    assert results["quality"]["questionnaires"] == 5


def test_a_runtime_killed_in_an_exposure_is_told_and_the_session_goes_on(tmp_path: Path) -> None:
    process = subprocess.Popen(
        ["vrcomfort", *command(tmp_path, exposure_s=LONG_S)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    frames = tmp_path / "study" / "sub-P01" / "ses-1" / "frames.csv"
    while not frames.exists() or frames.read_bytes().count(b"\n") < 4:
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)
    (service,) = services_of(process.pid)
    os.kill(service, signal.SIGKILL)
    said_last = process.communicate(timeout=WAIT_S)[1]
    assert process.returncode == 3
    (sentence,) = [line for line in said_last.splitlines() if line.startswith("error:")]
    assert "the OpenXR runtime stopped in the middle of the session" in sentence
    assert sentence.endswith("run with --resume")
    assert "Traceback" not in said_last
    assert len(read(tmp_path, "questionnaires.csv")) == 16
    assert read(tmp_path, "trials.csv")["abort_code"].tolist() == ["runtime_lost"]
    shown = len(read(tmp_path, "frames.csv"))
    assert shown == read(tmp_path, "trials.csv")["frames"].sum() >= 3

    refused = run(*command(tmp_path, exposure_s=LONG_S))
    assert refused.returncode == 2
    assert "--resume" in refused.stderr
    resumed = run(*command(tmp_path, "--resume", exposure_s=LONG_S))
    assert resumed.returncode == 0, resumed.stderr
    trials = read(tmp_path, "trials.csv")
    assert trials["trial"].tolist() == [1, 1, 2, 3, 4]
    assert trials["resumed"].tolist() == [0, 1, 1, 1, 1]
    timepoints = read(tmp_path, "questionnaires.csv")["timepoint"].tolist()[::16]
    assert timepoints == ["baseline", "baseline", *["post"] * 4]
    told = ("--figures", "none", "--out", str(tmp_path / "r"))
    reported = run("report", str(tmp_path / "study"), *told)
    assert reported.returncode == 0, reported.stderr
