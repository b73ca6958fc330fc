"""A runtime that hangs is told, and Ctrl-C is answered while the main thread is deaf in C."""

from __future__ import annotations

import re
import select
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.support.places import ROOT
from tests.support.signals import hear_all
from tests.support.waiting import WAIT_S, wait_for
from vrcomfort.headset.watchdog import RuntimeCalls, Watchdog

DEAF = """
import ctypes, sys
from pathlib import Path
from vrcomfort.cli import stopping
from vrcomfort.headset.watchdog import RUNTIME_CALLS, Watchdog

libc = ctypes.CDLL(None)
mutex = ctypes.create_string_buffer(64)

def say(sentence):
    print(sentence, flush=True)

def hang(name):
    RUNTIME_CALLS.begin(name)
    libc.pthread_mutex_lock(mutex)  # the second time it waits for ever, and heeds no signal

libc.pthread_mutex_lock(mutex)
patience_s = float(sys.argv[2])
dog = Watchdog(say, notice_s=0.3, patience_s=patience_s, go_on="to go on, type: run --resume")
with stopping.heard(), dog as watchdog:
    watchdog.last_acts.append(lambda: Path("last").write_text("done"))
    with watchdog.guard(lambda: Path("closed").write_text("by " + sys.argv[1])):
        if sys.argv[1] == "session":
            hang("xrWaitFrame")
    hang("xrDestroySession")
"""


def start(folder: Path, where: str, patience_s: float = 600.0) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", DEAF, where, str(patience_s)]
    environment = {"PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, preexec_fn=hear_all,  # noqa: PLW1509 - no thread is in the way
    )  # fmt: skip


def said_of(process: subprocess.Popen[str]) -> str:
    said, wrong = process.communicate(timeout=WAIT_S)
    assert wrong == ""
    return said


@pytest.mark.skipif(sys.platform == "win32", reason="the client hangs by POSIX means")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signals_close_the_records_while_the_main_thread_hangs(
    tmp_path: Path, number: signal.Signals, code: int
) -> None:
    process = start(tmp_path, "session")
    assert process.stdout
    line = process.stdout.readline()
    assert "has not answered xrWaitFrame for 0.3 s" in line
    assert "Ctrl-C ends the session and closes its records" in line
    assert process.poll() is None
    process.send_signal(number)
    assert said_of(process).splitlines() == [
        "stopped; all that was recorded is kept",
        "to go on, type: run --resume",
    ]
    assert process.returncode == code
    assert (tmp_path / "closed").read_text() == "by session"
    assert (tmp_path / "last").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="the client hangs by POSIX means")
def test_a_hung_runtime_is_given_up_when_patience_is_over(tmp_path: Path) -> None:
    process = start(tmp_path, "session", patience_s=0.5)
    assert "has not answered xrWaitFrame" in said_of(process)
    assert process.returncode == 3
    assert (tmp_path / "closed").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="the client hangs by POSIX means")
def test_after_the_records_are_closed_nobody_waits_for_a_hung_runtime(tmp_path: Path) -> None:
    process = start(tmp_path, "teardown")
    said = said_of(process)
    assert "has not answered xrDestroySession for 0.3 s; the program ends without it" in said
    assert "to go on" not in said  # the session has told that itself, if there is anything to do
    assert process.returncode == 3
    assert not (tmp_path / "closed").exists()  # the session had closed them itself


class Watched:
    """A watchdog in this process, whose end of the program is only written down."""

    def __init__(self, patience_s: float = 600.0) -> None:
        self.calls, self.said = RuntimeCalls(), list[str]()
        self.left: list[int] = []
        self.dog = Watchdog(
            self.said.append,
            calls=self.calls,
            notice_s=0.2,
            patience_s=patience_s,
            leave=self._leave,
        )

    def _leave(self, code: int) -> None:
        self.left.append(code)
        self.calls.under_way = None  # there is no program any more


def test_a_call_that_returns_after_all_is_told_and_recorded() -> None:
    watched = Watched()
    with watched.dog:
        watched.calls.begin("xrWaitFrame")
        wait_for(lambda: len(watched.said) == 1)
        watched.calls.end()
        wait_for(lambda: len(watched.said) == 2)
    told = r"the OpenXR runtime answers again: xrWaitFrame returned after ([\d.]+) s"
    assert (found := re.search(told, watched.said[1])) is not None
    assert float(found[1]) >= 0.2
    assert len(watched.calls.stalls) == 1
    assert watched.left == []


def test_short_calls_are_nothing_to_speak_of_however_many_there_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = SimpleNamespace(now_s=0.0, sleep=time.sleep, monotonic=lambda: clock.now_s)
    monkeypatch.setattr("vrcomfort.headset.watchdog.time", clock)
    watched = Watched()
    with watched.dog:
        for _ in range(6):
            watched.calls.begin("xrWaitFrame")
            clock.now_s += 0.15
            time.sleep(0.15)  # the watchdog looks every 0.1 s
            watched.calls.end()
    assert watched.said == []


def test_a_call_that_a_signal_brings_back_waits_for_a_slow_watchdog(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a busy machine it may be late: then the call must not come back first."""
    listen = select.select

    def slowly(*arguments: Any) -> Any:
        time.sleep(0.6)
        return listen(*arguments)

    monkeypatch.setattr(select, "select", slowly)
    before = signal.signal(signal.SIGINT, lambda *_: None)
    watched, signalled, returned = Watched(), threading.Event(), threading.Event()

    def call() -> None:
        watched.calls.begin("xrWaitFrame")
        assert signalled.wait(WAIT_S)
        watched.calls.end()
        returned.set()

    caller = threading.Thread(target=call)
    try:
        with watched.dog, watched.dog.guard(lambda: None):
            caller.start()
            wait_for(lambda: watched.said)
            signal.raise_signal(signal.SIGINT)
            signalled.set()
            wait_for(lambda: watched.left == [130])
            assert not returned.is_set()
            watched.calls.held = False
            caller.join()
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_call_that_returns_while_the_records_are_being_closed_goes_no_further() -> None:
    watched = Watched(patience_s=0.3)
    closing, close = threading.Event(), threading.Event()
    returned: list[float] = []

    def call() -> None:
        watched.calls.begin("xrWaitFrame")
        assert closing.wait(WAIT_S)
        watched.calls.end()
        returned.append(time.monotonic())

    def slowly() -> None:
        closing.set()
        assert close.wait(WAIT_S)

    caller = threading.Thread(target=call)
    with watched.dog, watched.dog.guard(slowly):
        caller.start()
        assert closing.wait(WAIT_S)
        time.sleep(0.2)
        assert returned == []
        close.set()
        wait_for(lambda: watched.left == [3])
        watched.calls.held = False
        caller.join()
