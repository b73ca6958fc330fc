"""What other devices are told waits for nobody; a serial port gets a byte for each exposure."""

from __future__ import annotations

import os
import sys
import threading
import time

import pytest

from tests.support.waiting import WAIT_S
from vrcomfort.errors import InputError
from vrcomfort.exchange.queued import Queued
from vrcomfort.exchange.ttl import TtlOutlet, byte_of

needs_a_terminal = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pty")


def test_work_is_done_in_order_and_whoever_gives_it_does_not_wait() -> None:
    done: list[int] = []
    gate = threading.Event()
    queued = Queued("test", capacity=3)
    queued.put(gate.wait)
    while queued._work.qsize():  # until the thread hangs in it
        time.sleep(0.001)
    for number in range(10):
        queued.put(lambda number=number: done.append(number))
    assert done == []
    assert queued.take_left_out() == 7
    gate.set()
    queued.close(WAIT_S)
    assert done == [0, 1, 2]
    assert queued.take_left_out() == 0


def test_work_that_fails_is_counted_and_the_rest_is_done() -> None:
    done: list[str] = []
    queued = Queued("test")
    queued.put(lambda: 1 // 0)
    queued.put(lambda: done.append("after"))
    queued.close(WAIT_S)
    assert done == ["after"]
    assert queued.take_left_out() == 1


@needs_a_terminal
@pytest.mark.smoke
def test_a_serial_port_gets_a_byte_as_an_exposure_begins_and_ends() -> None:
    pytest.importorskip("serial", reason="pyserial is not installed")
    ours, theirs = os.openpty()
    with TtlOutlet(os.ttyname(theirs)) as outlet:
        for trial in (0, 3, 500):
            outlet.begin_exposure(trial, "plain", None)
            outlet.end_exposure(trial)
    got = b""
    while len(got) < 6:  # a terminal passes them on when it has time
        got += os.read(ours, 100)
    os.close(ours)
    os.close(theirs)
    assert list(got) == [1, 129, 4, 132, 127, 255]
    assert outlet.take_left_out() == 0
    assert len({byte_of(trial) for trial in range(127)}) == 127


def test_a_port_that_is_not_there_is_refused_in_a_sentence() -> None:
    pytest.importorskip("serial", reason="pyserial is not installed")
    says = r"the serial port /dev/none cannot be opened: .*No such file"
    with pytest.raises(InputError, match=says):
        TtlOutlet("/dev/none")


def test_without_pyserial_a_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(InputError, match=r"pip install pyserial$"):
        TtlOutlet("COM3")
