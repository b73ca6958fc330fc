"""Ctrl-C in the middle of what is written together."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from tests.support.session import go, manifest, rows
from tests.support.study import AheadHeadset, Scripted, frame
from vrcomfort.records import Recorder, TrialRow
from vrcomfort.stop_signals import uninterrupted


@pytest.fixture(autouse=True)
def _hears_control_c():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def control_c():
    os.kill(os.getpid(), signal.SIGINT)


def test_the_block_ends_before_control_c_is_heard():
    done = []

    @uninterrupted()
    def write():
        control_c()
        done.append("written")

    with pytest.raises(KeyboardInterrupt):
        write()
    assert done == ["written"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_control_c_again_is_heard_at_once():
    done = []

    @uninterrupted()
    def write():
        control_c()
        control_c()
        done.append("written")

    with pytest.raises(KeyboardInterrupt):
        write()
    assert done == []
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_error_in_the_block_does_not_hide_control_c():
    @uninterrupted()
    def write():
        control_c()
        raise OSError("the disk is full")

    with pytest.raises(KeyboardInterrupt) as caught:
        write()
    assert isinstance(caught.value.__context__, OSError)


def test_a_signal_that_is_ignored_stays_ignored():
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with uninterrupted():
        control_c()
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def test_another_thread_runs_the_block():
    done = []

    def work():
        with uninterrupted():
            done.append("written")

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == ["written"]


def test_control_c_beside_a_trials_row_keeps_what_is_said_of_the_trial(tmp_path, monkeypatch):
    """The row, its timing, the flag in the manifest and its event are there, or none is."""

    class Stutters(AheadHeadset):
        """Every fifth frame lasts twice as long."""

        def frames(self):
            for index in range(self.frames_left):
                yield frame(index, time_ns=(index + index // 5) * 100_000_000)

    write = Recorder.write

    def write_and_stop(self, *written):
        write(self, *written)
        if any(isinstance(row, TrialRow) for row in written):
            control_c()

    monkeypatch.setattr(Recorder, "write", write_and_stop)
    outcome = go(tmp_path, Scripted(), headset=Stutters)
    assert outcome.status == "aborted"
    assert rows(tmp_path, "trials.csv")[0]["status"] == "completed"
    assert rows(tmp_path, "timing.csv")[0]["flagged"] == "1"
    assert len(manifest(tmp_path)["timing_flags"]) == 1
    assert "timing_flag" in [row["name"] for row in rows(tmp_path, "events.csv")]
