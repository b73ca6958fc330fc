"""`vrcomfort run --console`: a session that outlives its console, and is ended from it."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path

import pytest
from websockets.exceptions import ConnectionClosed

from tests.support.console import Doing, come_in, page_of, steer
from tests.support.console_session import PROTOCOL, RunningSession, running_session
from tests.support.study import read_rows
from tests.support.waiting import wait_for
from vrcomfort.exchange.verifying import verify_study

SHORT = (
    PROTOCOL.replace("exposure_s = 4.0", "exposure_s = 1.0")
    .replace("every_s = 1.2", "every_s = 0.2")
    .replace("timeout_s = 1.1", "timeout_s = 0.1")
)
START = Doing("waiting for the start", "start")


def servers_of(session: RunningSession) -> list[int]:
    """Return the console's servers among the processes that a session has started."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has ended meanwhile
            parent = int(stat.read_text().rpartition(") ")[2].split()[1])
            words = (stat.parent / "cmdline").read_text()
            if parent == session.process.pid and "vrcomfort.console.server" in words:
                found.append(int(stat.parent.name))
    return found


@pytest.mark.slow
def test_a_session_outlives_its_console_and_goes_on_with_the_same_page(tmp_path):
    with running_session(tmp_path, protocol=SHORT) as session:
        origin, cookie = come_in(session.next_address())
        with page_of(origin, cookie) as page:
            steer(page, [START], until=("exposure 1", "(post)"))  # it may have passed unseen
            (server,) = wait_for(lambda: servers_of(session))
            os.kill(server, signal.SIGKILL)
            with pytest.raises(ConnectionClosed):
                steer(page, [])
        with page_of(origin, cookie) as page:
            steer(page, [Doing("(post)", "note", "back again")])
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


def test_answers_cannot_be_entered_on_a_console_that_is_not_there(tmp_path, run):
    words = ["run", "smoke", "--participant", "P01", "--out", str(tmp_path / "S")]
    code, _, said = run(*words, "--respondent", "console")
    assert code == 2
    wanted = "--respondent console needs --console, where answers are entered"
    assert wanted in " ".join(said.split())
