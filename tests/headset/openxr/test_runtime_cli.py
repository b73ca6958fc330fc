"""The smoke study from the command line, against our own runtime: to its end, stopped, resumed."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from itertools import cycle, islice
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.support.console import Doing, come_in, page_of, steer
from tests.support.openxr_runtime import library
from tests.support.places import ROOT
from tests.support.study import read_rows, smoke_with
from tests.support.waiting import SESSION_S, WAIT_S
from vrcomfort.resources import data_folder

pytest.importorskip("xr", reason="pyopenxr is not installed")

pytestmark = [pytest.mark.slow, pytest.mark.windows]

TRACE = data_folder("scenes") / "temple_walk.csv"
ANSWERS = (0, 1, 2, 3)
CLIENT = """
import ctypes, signal, sys, threading, time
from pathlib import Path
signal.signal(signal.SIGINT, signal.default_int_handler)  # jobs in a shell's background ignore it
from tests.support.openxr_runtime import ScriptedRuntime
from vrcomfort.headset import monado

def press_ctrl_c():
    while not (folder / "ctrl_c").exists():
        time.sleep(0.05)
    ctypes.windll.kernel32.GenerateConsoleCtrlEvent(0, 0)

folder = Path(sys.argv.pop(1))
script = (folder / "rules.txt").read_text()
monado.Monado = lambda: ScriptedRuntime(folder / "runtime", script)
if sys.platform == "win32":
    threading.Thread(target=press_ctrl_c, daemon=True).start()
from vrcomfort.cli import main
main()
"""
"""The command, whose rehearsals are in our own runtime."""
SLOW = "period_ns 50000000\n"
"""A display that software keeps up with."""
HEAD = ["head_x_m", "head_y_m", "head_z_m", "head_qx", "head_qy", "head_qz", "head_qw"]


def start(folder: Path, *more: str, rules: str = "", exposure_s: float = 1.0) -> subprocess.Popen:
    """Start a rehearsal of the smoke study."""
    library()
    (folder / "rules.txt").write_text(SLOW + rules)
    (folder / "ctrl_c").unlink(missing_ok=True)
    (folder / "answers.txt").write_text(" ".join(map(str, ANSWERS * 60)))
    run = [
        *("run", str(smoke_with(folder, exposure_s)), "--participant", "P01"),
        *("--out", str(folder / "study"), "--headset", "openxr", "--quiet"),
        *("--monado-trace", str(TRACE), "--monado-answers", str(folder / "answers.txt"), *more),
    ]
    root = str(ROOT)
    path = os.pathsep.join([root, os.environ.get("PYTHONPATH", "")])
    return subprocess.Popen(
        [sys.executable, "-c", CLIENT, str(folder), *run],
        env={**os.environ, "PYTHONPATH": path, "PYTHONUTF8": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        creationflags=getattr(subprocess, "CREATE_NEW_CONSOLE", 0),
    )


def vrcomfort(*words: object) -> str:
    command = [sys.executable, "-c", "from vrcomfort.cli import main; main()", *map(str, words)]
    done = subprocess.run(
        command, capture_output=True, text=True, encoding="utf-8", timeout=SESSION_S, check=False,
        env={**os.environ, "PYTHONUTF8": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def session_folder(folder: Path) -> Path:
    return folder / "study" / "sub-P01" / "ses-1"


def table(folder: Path, name: str) -> pd.DataFrame:
    return pd.read_csv(session_folder(folder) / name, keep_default_na=False)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a session that has run to its end."""
    folder = tmp_path_factory.mktemp("session")
    process = start(folder, rules=f"log {folder / 'log.txt'}\n")
    said = process.communicate(timeout=SESSION_S)[1]
    assert process.returncode == 0, said
    return folder


def test_a_whole_session_has_the_poses_that_were_fed_and_the_answers(session: Path) -> None:
    manifest = json.loads((session_folder(session) / "manifest.json").read_text("utf-8"))
    assert manifest["status"] == "completed"
    assert manifest["headset"]["binding"] == ("wgl" if sys.platform == "win32" else "egl")
    assert manifest["headset"]["depth_layer"] == "DEPTH_COMPONENT32F"
    assert manifest["headset"]["display_clock"] != "not told"
    assert manifest["timing_trust"].startswith("simulated")

    fed = pd.read_csv(TRACE)[HEAD].to_numpy()
    for _, shown in table(session, "frames.csv").groupby("trial"):
        poses = shown[HEAD].to_numpy()
        distance = np.abs(fed[None] - poses[:, None]).max(axis=2)
        assert distance.min(axis=1).max() <= 1e-6
        assert set(np.diff(distance.argmin(axis=1)) % len(fed)) == {1}

    asked = table(session, "questionnaires.csv")
    assert asked["timepoint"].value_counts().to_dict() == {"baseline": 16, "post": 64}
    given = asked["response"].tolist()
    assert given[:16] == list(islice(cycle(ANSWERS), 16))
    clocks = table(session, "clocks.csv")
    assert len(clocks) >= 4
    ahead_ns = clocks["xr_time_ns"].astype(float) - clocks["monotonic_ns"].astype(float)
    assert ahead_ns.max() - ahead_ns.min() <= 1e6 + 2 * clocks["took_ns"].astype(float).max()


def test_the_runtime_gets_depth_and_no_vibration_is_left_on(session: Path) -> None:
    said = (session / "log.txt").read_text().splitlines()
    shown = [line for line in said if line.startswith("frame") and " eyes 1 " in line]
    assert len(shown) >= len(table(session, "frames.csv"))
    assert all(line.endswith("depths 2") for line in shown)
    assert any(line.startswith("haptic /user/hand/right") for line in said)


def test_a_whole_session_is_replayed_verified_and_reported(session: Path, tmp_path: Path) -> None:
    study = session / "study"
    vrcomfort("verify", study)
    vrcomfort("play", session_folder(session), "--out", tmp_path / "played", "--trial", 1)
    played = json.loads((tmp_path / "played" / "replay.json").read_text("utf-8"))
    assert played["images_equal"] == played["images_compared"] > 0
    vrcomfort("report", study, "--figures", "none", "--out", tmp_path / "report")
    results = json.loads((tmp_path / "report" / "results.json").read_text("utf-8"))
    assert results["participants"]["n"] == 1
    assert results["quality"]["questionnaires"] == 5


def test_the_console_serves_its_page_while_the_session_runs(tmp_path: Path) -> None:
    process = start(tmp_path, "--console", "--respondent", "panel", exposure_s=600.0)
    assert process.stdout is not None
    said = ""
    while (found := re.search(r"once: (http://\S+)", said)) is None:
        line = process.stdout.readline()
        assert line, process.communicate()
        said += line
    origin, cookie = come_in(found[1])
    with page_of(origin, cookie) as page:
        steer(page, [Doing("waiting for the start", "start")], until=("exposure 1",))
    stop(process, tmp_path)
    said = process.communicate(timeout=WAIT_S)[1]
    assert process.returncode == 130, said
    assert "Traceback" not in said


def in_exposure(process: subprocess.Popen[str], folder: Path) -> None:
    """Wait until frames of an exposure are on disk."""
    frames = session_folder(folder) / "frames.csv"

    def recorded() -> bool:
        assert process.poll() is None, process.communicate()
        return frames.exists() and frames.read_bytes().count(b"\n") > 10

    while not recorded():  # a session may begin slowly: pytest's own timeout ends it
        time.sleep(0.02)


def stop(process: subprocess.Popen[str], folder: Path) -> None:
    """Stop a session as the keyboard does."""
    if sys.platform == "win32":
        (folder / "ctrl_c").touch()  # in its console, which is its own
    else:
        process.send_signal(signal.SIGINT)


def assert_kept(folder: Path, abort_code: str) -> None:
    """Assert that the records are closed, and have every row of the exposure."""
    manifest = json.loads((session_folder(folder) / "manifest.json").read_text("utf-8"))
    assert manifest["status"] == "aborted"
    *_, trial = read_rows(session_folder(folder) / "trials.csv")
    assert trial["abort_code"] == abort_code
    shown = [
        row for row in read_rows(session_folder(folder) / "frames.csv") if row["paused"] != "1"
    ]
    assert int(trial["frames"]) == sum(row["trial"] == trial["trial"] for row in shown)


def test_ctrl_c_ends_an_exposure_and_resume_goes_on(tmp_path: Path) -> None:
    process = start(tmp_path, exposure_s=5.0)
    in_exposure(process, tmp_path)
    stop(process, tmp_path)
    said = process.communicate(timeout=WAIT_S)[1]
    assert process.returncode == 130, said
    assert "Traceback" not in said
    assert "to go on, type: vrcomfort run" in said
    assert_kept(tmp_path, "operator")
    assert_resumes(tmp_path, exposure_s=5.0)


def assert_resumes(folder: Path, exposure_s: float) -> None:
    """Assert that a session goes on to its end, and that its records are whole."""
    resumed = start(folder, "--resume", exposure_s=exposure_s)
    said = resumed.communicate(timeout=SESSION_S)[1]
    assert resumed.returncode == 0, said
    trials = read_rows(session_folder(folder) / "trials.csv")
    done = [trial["trial"] for trial in trials if trial["status"] == "completed"]
    assert done == ["1", "2", "3", "4"]
    vrcomfort("verify", folder / "study")


def test_a_runtime_that_hangs_is_told_and_ctrl_c_ends_the_session(tmp_path: Path) -> None:
    process = start(tmp_path, exposure_s=600.0, rules="300 hang xrWaitFrame 600\n")
    assert process.stderr is not None
    for line in process.stderr:
        if "the OpenXR runtime has not answered xrWaitFrame for 5 s" in line:
            break
    stop(process, tmp_path)
    said = process.communicate(timeout=WAIT_S)[1]
    assert process.returncode == 130, said
    assert "Traceback" not in said
    assert "stopped; all that was recorded is kept" in said
    assert "to go on, type: vrcomfort run" in said
    assert_kept(tmp_path, "runtime_hung")


MANY = 50
"""So many exposures, and all faults are tried."""
FEWEST_FRAMES = 220
"""Of a whole session, on a machine that misses most of them: three for each of 80 answers."""
LOSSES = (
    "state loss_pending",
    "answer xrEndFrame -17",
    "instance_loss",
    "answer xrWaitFrame -13",
    "answer xrWaitSwapchainImage 1",
    "answer xrLocateViews -30",
    "answer xrSyncActions -2",
    "answer * -13",
)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Try few faults in the gate."""
    if "fault" in metafunc.fixturenames:
        many = int(metafunc.config.getoption("--exposures")) >= MANY
        metafunc.parametrize("fault", LOSSES if many else LOSSES[:2])


def test_a_fault_at_a_random_time_is_a_sentence_and_resume_goes_on(
    fault: str, tmp_path: Path
) -> None:
    frame = int(np.random.default_rng(LOSSES.index(fault)).integers(20, FEWEST_FRAMES))
    process = start(tmp_path, rules=f"{frame} {fault}\n")
    said = process.communicate(timeout=SESSION_S)[1]
    assert process.returncode == 3, said
    (sentence,) = [line for line in said.splitlines() if line.startswith("error: ")]
    assert "the OpenXR runtime stopped in the middle of the session" in sentence
    assert "to go on, type: vrcomfort run" in said
    assert "Traceback" not in said
    assert_resumes(tmp_path, exposure_s=1.0)
