"""A session in a real window, on an X server without a monitor, by real key presses."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import StringIO
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.support.waiting import WAIT_S, wait_for
from tests.support.x_server import XServer, x_server
from vrcomfort.geometry import yaw_pitch_roll

SPEED_M_S = 1.4
PROTOCOL = """
name = "window"
title = "Two exposures in a window"
participants = 2
exposure_s = 300.0
scenes = ["temple"]
conditions = [{ name = "a" }, { name = "b" }]
order = { rule = "williams" }
questionnaires = [{ timepoint = "baseline", when = "session_start" }]
ratings = { instrument = "fms", every_s = 2.0, timeout_s = 294.0 }  # comes three times
"""


class Study:
    """What the session has written so far."""

    def __init__(self, folder: Path, process: subprocess.Popen[str]) -> None:
        self._folder, self._process = folder, process

    def read(self, file: str) -> pd.DataFrame:
        """Return the rows that are whole: another may just be written."""
        path = self._folder / "study" / "sub-P01" / "ses-1" / file
        whole = path.read_text().rpartition("\n")[0] if path.exists() else ""
        return pd.read_csv(StringIO(whole), keep_default_na=False) if whole else pd.DataFrame()

    def wait(self, file: str, enough: Callable[[pd.DataFrame], bool]) -> pd.DataFrame:
        """Return a table when it holds enough."""
        until_s = time.monotonic() + WAIT_S
        while True:
            over = self._process.poll() is not None or time.monotonic() > until_s
            table = self.read(file)
            if len(table) and enough(table):
                return table
            if over:
                break
            time.sleep(0.05)
        self._process.terminate()
        pytest.fail(f"{file} never came to hold enough: {self._process.communicate()}")

    def wait_for_rows(self, file: str, count: int) -> pd.DataFrame:
        return self.wait(file, lambda table: len(table) >= count)


@contextmanager
def session(server: XServer, folder: Path, *options: str) -> Iterator[Study]:
    protocol = folder / "window.toml"
    protocol.write_text(PROTOCOL)
    program = "from vrcomfort.cli import main; main()"
    command = [
        *(sys.executable, "-c", program, "run", str(protocol), "--participant", "P01"),
        *("--out", str(folder / "study"), "--headset", "desktop", "--size", "96x120", *options),
    ]
    with subprocess.Popen(
        command,
        env=server.environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield Study(folder, process)
            process.wait(timeout=WAIT_S)
            assert process.returncode == 0, process.communicate()
        finally:
            process.terminate()


def answer_questionnaire(server: XServer, study: Study) -> list[int]:
    """Answer all items of the SSQ by number, and confirm by arrow keys."""
    values = [index % 4 for index in range(16)]
    study.wait_for_rows("events.csv", 1)
    for index, value in enumerate(values):
        server.do("key", str(value), "Return")
        study.wait("events.csv", lambda table, n=index: (table["name"] == "answer").sum() > n)
    server.do("key", "Down", "Return")  # the first arrow comes to "All correct"
    study.wait_for_rows("questionnaires.csv", 16)
    return values


@pytest.mark.slow
def test_a_session_is_answered_and_walked_with_keys_and_mouse(tmp_path: Path) -> None:
    with x_server(tmp_path) as server, session(server, tmp_path) as study:
        values = answer_questionnaire(server, study)
        answer_ratings(server, study)
        server.do("keydown", "w")
        study.wait("frames.csv", lambda table: table["avatar_z_m"].iloc[-1] < -0.5)
        server.do("keyup", "w")
        turn_with_mouse(server, study)
        server.do("key", "Escape", "Escape", "y")
        study.wait_for_rows("trials.csv", 1)

    asked = study.read("questionnaires.csv")
    assert asked["response"].astype(int).tolist() == values
    ratings = study.read("ratings.csv")
    assert set(ratings["response"][ratings["missed"] == 0].astype(int)) == {17}
    assert study.read("trials.csv")["status"].tolist() == ["withdrawn"]
    frames = study.read("frames.csv")
    place = frames[["avatar_x_m", "avatar_y_m", "avatar_z_m"]].to_numpy()
    passed_s = np.diff(frames["xr_time_ns"]) / 1e9
    assert (np.linalg.norm(np.diff(place, axis=0), axis=1) <= SPEED_M_S * passed_s + 1e-6).all()
    tilted = frames[["head_qx", "head_qy", "head_qz", "head_qw"]].iloc[-1].to_numpy()
    assert tilted == pytest.approx(yaw_pitch_roll(0.0, -3 * 10 * 0.0022, 0.0), abs=1e-9)
    assert (frames[["head_x_m", "head_z_m"]] == 0).all(axis=None)


def turn_with_mouse(server: XServer, study: Study) -> None:
    """Turn left and look down in three moves, each small enough for the little window."""
    server.do("mousemove_relative", "--", -4, 0)  # the first tells only where the mouse is
    for move in (1, 2, 3):
        server.do("mousemove_relative", "--", -40, 10)
        turned = np.sin((move * 40 - 1) * 0.0022 / 2)
        study.wait("frames.csv", lambda table, qy=turned: table["avatar_qy"].iloc[-1] > qy)


def answer_ratings(server: XServer, study: Study) -> None:
    """Answer each rating that the exposure asks for, with two digits; wait until it is taken."""
    for number in (1, 2, 3):
        # A first digit that came before it is asked would be lost.
        study.wait(
            "frames.csv",
            lambda table, s=2 * number + 0.5: np.ptp(table["session_s"][table["trial"] == 1]) > s,
        )
        if len(study.read("ratings.csv")) < number:  # else it was missed: the picture stood still
            server.do("key", "1", "7", "Return")
        study.wait_for_rows("ratings.csv", number)


CLIENT = """
import sys
from itertools import islice
import moderngl, numpy as np
from vrcomfort.geometry import Pose
from vrcomfort.headset.desktop import DesktopHeadset, DesktopSettings
from vrcomfort.headset.window import Window
from vrcomfort.gpu.gl import check_errors, prepare

layout, columns = sys.argv[1], int(sys.argv[2])
settings = DesktopSettings(image_size_px=(64, 80), layout=layout)
with Window("test", settings.window_size_px) as window:
    ctx = prepare(window.context())
    headset = DesktopHeadset(ctx, window, settings)
    noise = [np.random.default_rng(eye).bytes(64 * 80 * 4) for eye in (0, 1)]
    eyes = [ctx.texture((64, 80), 4, each) for each in noise]
    for frame in islice(headset.frames(), 10):
        headset.submit(frame, eyes)
    check_errors(ctx)
    print("shown", flush=True)
    sys.stdin.readline()
"""


@pytest.mark.parametrize(("layout", "columns"), [("side_by_side", 2), ("one_eye", 1)])
def test_the_window_shows_the_images_as_they_are(tmp_path: Path, layout: str, columns: int) -> None:
    command = [sys.executable, "-c", CLIENT, layout, str(columns)]
    with (
        x_server(tmp_path) as server,
        subprocess.Popen(
            command,
            env=server.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        ) as client,
    ):
        assert client.stdout is not None
        assert client.stdout.readline() == "shown\n"
        wait_for(lambda: shows(server.picture(), columns))  # the server draws when it has time
        client.communicate("\n")


def shows(screen: np.ndarray, columns: int) -> bool:
    """Return whether the eyes' noise stands on the screen, pixel by pixel."""
    lit = np.argwhere(screen.any(axis=2))
    if not len(lit):
        return False
    top, left = lit.min(axis=0)
    shown = screen[top : top + 80, left : left + 64 * columns]
    eyes = [np.random.default_rng(eye).bytes(64 * 80 * 4) for eye in range(columns)]
    noise = [np.frombuffer(each, np.uint8).reshape(80, 64, 4)[::-1, :, :3] for each in eyes]
    return np.array_equal(shown, np.hstack(noise))


@pytest.mark.slow
@pytest.mark.smoke
def test_without_a_display_one_sentence_says_what_to_do(tmp_path: Path) -> None:
    server = XServer(":4242", tmp_path)
    protocol = tmp_path / "window.toml"
    protocol.write_text(PROTOCOL)
    program = "from vrcomfort.cli import main; main()"
    command = [sys.executable, "-c", program, "run", str(protocol), "--participant", "P01"]
    done = subprocess.run(
        [*command, "--out", str(tmp_path / "study"), "--headset", "desktop"],
        env=server.environment, capture_output=True, text=True, timeout=WAIT_S, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "start Xvfb" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_preflight_shows_the_dearest_condition_in_the_window(tmp_path: Path) -> None:
    program = "from vrcomfort.cli import main; main()"
    command = [sys.executable, "-c", program, "preflight", "smoke", "--out", str(tmp_path / "S")]
    with x_server(tmp_path) as server:
        done = subprocess.run(
            [*command, *("--headset", "desktop", "--size", "64x80", "--seconds", "0.5")],
            env=server.environment, capture_output=True, text=True, timeout=WAIT_S, check=False,
        )  # fmt: skip
    found = json.loads((tmp_path / "S" / "preflight.json").read_text())
    parts = {each["part"]: each for each in found["findings"]}
    assert done.returncode == (2 if found["outcome"] == "refuse" else 0), done.stderr
    assert "Traceback" not in done.stderr
    assert found["headset"] == "desktop"
    assert found["apparatus"]["image size of an eye"] == "64×80"
    assert found["timing"]["frames"] > 0
    assert parts["stop"]["found"] == "by keyboard"
    assert {name for name, each in parts.items() if each["outcome"] == "refuse"} <= {"rate holds"}
