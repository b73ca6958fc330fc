"""`vrcomfort run --console`: a session that outlives its console, and is ended from it."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("starlette", reason="vrcomfort[console] is not installed")

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from tests.support.console import WAIT_S, Doing, PageSocket, come_in, steer
from tests.support.console_session import PROTOCOL, RunningSession, running_session
from tests.support.study import read_rows
from vrcomfort.console import process
from vrcomfort.exchange.verifying import verify_study

SHORT = (
    PROTOCOL.replace("exposure_s = 4.0", "exposure_s = 1.0")
    .replace("every_s = 1.2", "every_s = 0.2")
    .replace("timeout_s = 1.1", "timeout_s = 0.1")
)
START = Doing("waiting for the start", "start")


@contextmanager
def page_of(origin: str, cookie: str) -> Iterator[PageSocket]:
    headers = {"Cookie": cookie}
    with connect(f"ws{origin[4:]}/session", origin=origin, additional_headers=headers) as socket:
        yield PageSocket(socket)


def children_of(session: RunningSession) -> list[int]:
    number = session.process.pid
    tasks = Path(f"/proc/{number}/task").iterdir()
    words = " ".join((task / "children").read_text() for task in tasks)
    return [int(word) for word in words.split()]


@pytest.mark.slow
def test_a_session_outlives_its_console_and_goes_on_with_the_same_page(tmp_path):
    with running_session(tmp_path, protocol=SHORT) as session:
        origin, cookie = come_in(session.next_address())
        with page_of(origin, cookie) as page:
            steer(page, [START], until="exposure 1")
            (server,) = children_of(session)
            os.kill(server, signal.SIGKILL)
            with pytest.raises(ConnectionClosed):
                steer(page, [])
        deadline = time.monotonic() + WAIT_S
        while True:
            try:
                with page_of(origin, cookie) as page:
                    steer(page, [Doing("(post)", "note", "back again")])
                break
            except (OSError, ConnectionClosed):
                assert time.monotonic() < deadline
                time.sleep(0.1)
        assert session.ended() == 0
    told = "".join(session.lines)
    assert "the console's server ended (killed by signal 9); the session goes on" in told
    trials = read_rows(session.ses / "trials.csv")
    assert [row["status"] for row in trials] == ["completed", "completed"]
    events = [row["detail"] for row in read_rows(session.ses / "events.csv")]
    assert any(detail.endswith("back again") for detail in events)
    assert verify_study(tmp_path / "study").faults == []


@pytest.mark.slow
def test_an_abort_on_the_console_ends_the_command_like_control_c(tmp_path):
    with running_session(tmp_path, "--respondent", "simulated", protocol=SHORT) as session:
        origin, cookie = come_in(session.next_address())
        with page_of(origin, cookie) as page:
            states = steer(page, [Doing("waiting for the start", "abort", "no show")])
        assert states[-1]["ended"] == "aborted"
        assert session.ended() == 130
    assert "to go on, type:" in "".join(session.lines)
    assert "stopped by A: no show" in (tmp_path / "study" / "participants.csv").read_text()


def test_without_the_packages_the_console_is_refused_in_a_sentence(tmp_path, monkeypatch, run):
    found = process.importlib.util.find_spec
    monkeypatch.setattr(
        process.importlib.util, "find_spec", lambda name: None if name == "uvicorn" else found(name)
    )
    words = ["run", "smoke", "--participant", "P01", "--out", str(tmp_path / "S"), "--console"]
    code, _, said = run(*words)
    assert code == 2
    wanted = "--console needs uvicorn, which is not installed; type: pip install"
    assert wanted in " ".join(said.split())
    assert not (tmp_path / "S").exists()


def test_answers_cannot_be_entered_on_a_console_that_is_not_there(tmp_path, run):
    words = ["run", "smoke", "--participant", "P01", "--out", str(tmp_path / "S")]
    code, _, said = run(*words, "--respondent", "console")
    assert code == 2
    wanted = "--respondent console needs --console, where answers are entered"
    assert wanted in " ".join(said.split())
