"""A runtime that hangs in the middle of a session, as the experimenter meets it."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.support.openxr import needs_monado, services_of
from tests.support.signals import hear_all
from tests.support.study import read_rows, smoke_with
from tests.support.waiting import SESSION_S, WAIT_S, wait_for
from vrcomfort.resources import data_folder

pytest.importorskip("xr", reason="pyopenxr is not installed")

pytestmark = needs_monado

CLIENT = "from vrcomfort.cli import main; main()"


class Session:
    """A rehearsal in a process of its own, whose runtime can be stopped."""

    def __init__(self, folder: Path, exposure_s: float = 6.0, ratings: str = "") -> None:
        self.folder = folder / "study" / "sub-P01" / "ses-1"
        self.said = folder / "said.txt"
        answers = folder / "answers.txt"
        answers.write_text("0 1 2 3 " * 60)
        protocol = smoke_with(folder, exposure_s)
        if ratings:
            text = protocol.read_text()
            protocol.write_text(re.sub(r"every_s = .*\ntimeout_s = .*", ratings, text))
        command = [
            *(sys.executable, "-c", CLIENT),
            *("run", str(protocol), "--participant", "P01"),
            *("--out", str(folder / "study"), "--headset", "openxr", "--size", "16x16", "--quiet"),
            *("--monado-trace", str(data_folder("scenes") / "temple_walk.csv")),
            *("--monado-answers", str(answers)),
        ]
        with self.said.open("w") as out:
            self.process = subprocess.Popen(
                command, stdout=subprocess.DEVNULL, stderr=out,
                preexec_fn=hear_all,  # noqa: PLW1509 - no thread is in the way
            )  # fmt: skip

    @property
    def service(self) -> int:
        (service,) = services_of(self.process.pid)
        return service

    def wait_for(self, holds: Callable[[], object]) -> None:
        """Wait for something that comes before the session ends."""

        def held() -> bool:
            ended = self.process.poll() is not None
            if holds():
                return True
            assert not ended, self.said.read_text()
            return False

        wait_for(held, self.said.read_text)

    def frames(self) -> int:
        file = self.folder / "frames.csv"
        return max(file.read_bytes().count(b"\n") - 1, 0) if file.exists() else 0

    def lines(self, start: str = "") -> list[str]:
        lines = self.said.read_text().rpartition("\n")[0].splitlines()  # those that are whole
        return [line for line in lines if line.startswith(start) and "vrcomfort" not in line]


@contextmanager
def session(folder: Path, **options: Any) -> Iterator[Session]:
    """Yield a session, and leave nothing of it behind."""
    running = Session(folder, **options)
    try:
        yield running
    finally:
        for service in services_of(running.process.pid):
            os.kill(service, signal.SIGKILL)
        running.process.kill()
        running.process.wait()


def test_ctrl_c_ends_a_session_whose_runtime_hangs_and_closes_its_records(tmp_path: Path) -> None:
    with session(tmp_path, exposure_s=60.0) as running:
        running.wait_for(lambda: running.frames() >= 20)
        service = running.service
        os.kill(service, signal.SIGSTOP)
        running.wait_for(lambda: running.lines("note: the OpenXR runtime has not"))
        (sentence,) = running.lines("note: the OpenXR")
        assert "for 5 s" in sentence
        assert "Ctrl-C ends the session" in sentence
        assert json.loads((running.folder / "manifest.json").read_text())["status"] == "running"
        running.process.send_signal(signal.SIGINT)
        assert running.process.wait(WAIT_S) == 130
        assert "Traceback" not in running.said.read_text()
        assert re.search(r"to go on, type: .*--resume\n", running.said.read_text())
        wait_for(lambda: not Path(f"/proc/{service}").exists())

    assert json.loads((running.folder / "manifest.json").read_text())["status"] == "aborted"
    (trial,) = read_rows(running.folder / "trials.csv")
    assert trial["abort_code"] == "runtime_hung"
    assert int(trial["frames"]) == len(read_rows(running.folder / "frames.csv")) >= 20
    assert "runtime_hung" in [row["name"] for row in read_rows(running.folder / "events.csv")]
    assert len(read_rows(running.folder / "questionnaires.csv")) == 16


def test_a_session_goes_on_where_the_runtime_answers_again(tmp_path: Path) -> None:
    with session(tmp_path) as running:
        running.wait_for(lambda: running.frames() >= 20)
        service = running.service
        os.kill(service, signal.SIGSTOP)
        running.wait_for(lambda: running.lines("note: the OpenXR runtime has not"))
        os.kill(service, signal.SIGCONT)
        running.wait_for(lambda: running.lines("note: the OpenXR runtime answers again"))
        assert running.process.wait(SESSION_S) == 0
    events = read_rows(running.folder / "events.csv")
    (stall,) = [row["detail"] for row in events if row["name"] == "runtime_stalled"]
    assert (found := re.search(r"returned after ([\d.]+) s", stall)) is not None
    assert float(found[1]) >= 5.0
    assert json.loads((running.folder / "manifest.json").read_text())["status"] == "completed"


def test_a_runtime_that_hangs_at_the_end_does_not_hold_the_program(tmp_path: Path) -> None:
    with session(tmp_path, exposure_s=60.0) as running:
        running.wait_for(lambda: running.frames() >= 20)
        service = running.service
        running.process.send_signal(signal.SIGINT)
        os.kill(service, signal.SIGSTOP)
        assert running.process.wait(WAIT_S) == 130
        assert "Traceback" not in running.said.read_text()
    assert json.loads((running.folder / "manifest.json").read_text())["status"] == "aborted"
    assert len(read_rows(running.folder / "trials.csv")) == 1
