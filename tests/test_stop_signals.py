"""Ctrl-C in the middle of what is written together."""

from __future__ import annotations

import os
import signal
import sys
import threading

import pytest

from tests.support.session import go, manifest, rows
from tests.support.study import AheadHeadset, LateFocus, Scripted, frame
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.records import Recorder, TrialRow
from vrcomfort.session import NoPictures, StillHeadset
from vrcomfort.stop_signals import interruptible, uninterrupted


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


def test_control_c_again_changes_nothing_and_the_third_is_heard_at_once():
    done = []

    @uninterrupted()
    def write():
        control_c()
        control_c()
        done.append("written")
        control_c()
        done.append("and more")

    with pytest.raises(KeyboardInterrupt):
        write()
    assert done == ["written"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_shutdown_and_a_closed_terminal_are_one_wish():
    heard = []
    before = {
        number: signal.signal(number, lambda number, _: heard.append(number))
        for number in (signal.SIGTERM, signal.SIGHUP)
    }
    try:
        with uninterrupted():
            for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGHUP, signal.SIGTERM):
                os.kill(os.getpid(), number)
            assert heard == []
        assert heard == [signal.SIGTERM]
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def test_a_signal_is_heard_where_the_block_waits_for_something():
    done = []

    def frames():
        for number in range(5):
            if number == 3:
                control_c()
            yield number

    def show():
        with uninterrupted():
            try:
                for number in interruptible(frames()):
                    done.append(number)
                    if number == 1:
                        control_c()
                    done.append("whole")
            finally:
                control_c()  # which the first does not let through
                done.append("closed")

    with pytest.raises(KeyboardInterrupt):
        show()
    assert done == [0, "whole", 1, "whole", "closed"]


def test_a_signal_that_comes_while_something_is_deleted_is_heard_after_it():
    class Deleted:
        def __del__(self):
            control_c()

    def frames():
        Deleted()
        while True:
            yield "a frame"

    hook = sys.unraisablehook
    with pytest.raises(KeyboardInterrupt), uninterrupted():
        list(interruptible(frames()))
    assert sys.unraisablehook is hook


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


class Late(LateFocus):
    """A renderer in which frames wait; `again` says how often Ctrl-C comes meanwhile."""

    again = 0

    def drain(self):
        for _ in range(self.again):
            control_c()
        return super().drain()


def stopped_by(tmp_path, presses):
    """Press Ctrl-C while the 20th frame is waited for, and again while frames are in flight.

    Returns how the session ended, and how many frames were shown.
    """
    renderer = Late()

    class Stopped(AheadHeadset):
        def frames(self):
            for each in super().frames():
                if each.index == 20:
                    renderer.again = presses - 1
                    control_c()
                yield each

    headset = Stopped()
    outcome = go(tmp_path, Scripted(), headset=lambda: headset, renderer=renderer)
    return outcome.status, headset.submitted


def test_two_ctrl_c_lose_no_frame_that_was_shown(tmp_path):
    assert stopped_by(tmp_path, 2) == ("aborted", 20)
    assert len(rows(tmp_path, "frames.csv")) == 20
    trial = rows(tmp_path, "trials.csv")[-1]
    assert (trial["abort_code"], manifest(tmp_path)["status"]) == ("operator", "aborted")
    assert verify_study(tmp_path / "S").faults == []


def test_a_third_ctrl_c_waits_for_nothing(tmp_path):
    assert stopped_by(tmp_path, 3) == ("aborted", 20)
    assert len(rows(tmp_path, "frames.csv")) < 20


def test_ctrl_c_ends_an_exposure_without_frames_where_it_comes(tmp_path):
    pressed_s = []

    def press(progress):
        if progress.step == "exposure" and progress.done and not pressed_s:
            pressed_s.append(progress.done)
            control_c()

    without = {"headset": StillHeadset, "renderer": NoPictures(), "jumps": True}
    assert go(tmp_path, Scripted(), progress=press, **without).status == "aborted"
    (trial,) = rows(tmp_path, "trials.csv")
    lasted_s = float(trial["end_s"]) - float(trial["start_s"])
    assert (trial["abort_code"], pressed_s) == ("operator", [pytest.approx(lasted_s)])
    assert lasted_s < 10.0
