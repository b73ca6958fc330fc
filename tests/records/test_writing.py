"""Rows are written beside the frames: never late, never lost in silence."""

from __future__ import annotations

import os
import signal
import sys
import threading
import weakref
from pathlib import Path
from queue import SimpleQueue

import pytest

from tests.support.study import frame, read_rows
from vrcomfort.errors import InputError
from vrcomfort.geometry import Gaze
from vrcomfort.records import EventRow, FrameRow, GazeRow, RatingRow, Recorder, TrialRow
from vrcomfort.records.row_files import RowFiles

TRIAL = TrialRow("P1", 1, 1, 1, 1, "a", "s", 0.0, 1.0, "completed", None, 1, 0, 9, 0)


def frame_row(index: int) -> FrameRow:
    shown = frame(index)
    left, right = shown.views
    return FrameRow(
        index / 10, index, 100, 1, True, shown.head_pose, left, right, shown.avatar_pose,
        gaze=GazeRow(index / 10, index, Gaze(shown.head_pose)),
    )  # fmt: skip


def seconds(folder: Path) -> list[float]:
    return [float(row["session_s"]) for row in read_rows(folder / "frames.csv")]


class StuckDisk:
    """Takes what fits into a pipe, and the rest once somebody reads it."""

    def __init__(self, recorder: Recorder) -> None:
        self._pipe = recorder.folder / "pipe"
        self._file = recorder.folder / "frames.csv"
        os.mkfifo(self._pipe)
        self._reader = os.open(self._pipe, os.O_RDONLY | os.O_NONBLOCK)
        writer = os.open(self._pipe, os.O_WRONLY)
        os.dup2(writer, recorder._files["frames.csv"].fileno())
        os.close(writer)

    def heal(self) -> threading.Thread:
        os.set_blocking(self._reader, True)

        def copy() -> None:
            with self._file.open("ab") as whole:
                while content := os.read(self._reader, 1 << 16):
                    whole.write(content)
            os.close(self._reader)

        thread = threading.Thread(target=copy)
        thread.start()
        return thread


def test_a_stuck_disk_stops_no_frame_and_what_is_left_out_is_told(tmp_path):
    recorder = Recorder(tmp_path, "P1", 1, capacity=20)
    disk = StuckDisk(recorder)
    for index in range(400):
        recorder.write(frame_row(index))  # would wait forever, were it to wait
    recorder.write_soon(RatingRow("P1", 1, 1, "a", 1.0, 0.5, "fms", 3, 0))
    lost = recorder.frames_not_recorded
    assert 0 < lost < 400
    thread = disk.heal()
    recorder.write(TRIAL)
    recorder.write(frame_row(400))
    recorder.close()
    thread.join()
    kept = seconds(recorder.folder)
    assert len(kept) == 401 - lost
    assert kept == sorted(kept)
    seen = read_rows(recorder.folder / "gaze.csv")  # a frame and its gaze go together
    assert [float(row["session_s"]) for row in seen] == kept
    gaps = read_rows(recorder.folder / "events.csv")
    assert {gap["name"] for gap in gaps} == {"frames_not_recorded"}
    assert sum(int(gap["detail"].split()[0]) for gap in gaps) == lost
    last_s = float(gaps[-1]["onset_s"]) + float(gaps[-1]["duration_s"])
    assert last_s == pytest.approx(max({index / 10 for index in range(401)} - set(kept)))
    for name in ("ratings", "trials"):
        assert len(read_rows(recorder.folder / f"{name}.csv")) == 1


@pytest.fixture
def written(monkeypatch):
    """How many rows were written at a time, while those of frames wait for others for long."""
    sizes = SimpleQueue()
    write = RowFiles.write

    def counted(files, rows):
        write(files, rows)
        sizes.put(len(rows))

    monkeypatch.setattr(RowFiles, "write", counted)
    monkeypatch.setattr("vrcomfort.records.recorder.TOGETHER_S", 3600.0)
    return sizes


def test_rows_of_frames_are_written_together_before_a_row_that_somebody_waits_for(
    tmp_path, written
):
    with Recorder(tmp_path, "P1", 1, durability="session_end") as recorder:
        for index in range(5):
            recorder.write(frame_row(index))
        assert written.empty()
        recorder.write(TRIAL)
        assert seconds(recorder.folder) == [0.0, 0.1, 0.2, 0.3, 0.4]
    assert sum(written.get() for _ in range(written.qsize())) == 6


def test_no_row_is_kept_once_it_is_written(tmp_path):
    with Recorder(tmp_path, "P1", 1) as recorder:
        for index in range(20):
            row = frame_row(index)
            written = weakref.ref(row)
            recorder.write(row)
            del row
            recorder.flush()
            assert written() is None


def test_rows_of_frames_wait_no_longer_when_half_of_those_that_may_wait_are_there(
    tmp_path, written
):
    with Recorder(tmp_path, "P1", 1, durability="session_end", capacity=6) as recorder:
        for index in range(4):
            recorder.write(frame_row(index))
        assert written.get() == 4
        assert seconds(recorder.folder) == [0.0, 0.1, 0.2, 0.3]


def full(recorder: Recorder, name: str) -> None:
    device = os.open("/dev/full", os.O_WRONLY)
    os.dup2(device, recorder._files[name].fileno())
    os.close(device)


def test_a_disk_that_refused_a_frame_is_told_by_the_next_call_and_takes_other_rows(tmp_path):
    """But for the trial's row, which would count a frame that is not there."""
    recorder = Recorder(tmp_path, "P1", 1)
    full(recorder, "frames.csv")
    recorder.write(frame_row(0))
    with pytest.raises(InputError, match=r"frames\.csv: cannot write: No space left"):
        recorder.write(TRIAL, EventRow(0.0, 0.0, "end"))
    recorder.close()
    rows = {
        name: len(read_rows(recorder.folder / f"{name}.csv"))
        for name in ("events", "gaze", "trials")
    }
    assert rows == {"events": 1, "gaze": 0, "trials": 0}


def test_the_last_row_is_not_refused_in_silence(tmp_path):
    recorder = Recorder(tmp_path, "P1", 1)
    full(recorder, "frames.csv")
    recorder.write(frame_row(0))
    with pytest.raises(InputError, match="No space left"):
        recorder.close()


def test_an_error_elsewhere_is_told_before_that_of_the_disk(tmp_path):
    def run() -> None:
        with Recorder(tmp_path, "P1", 1) as recorder:
            full(recorder, "frames.csv")
            recorder.write(frame_row(0))
            raise ArithmeticError

    with pytest.raises(ArithmeticError):
        run()


def test_leaving_by_an_error_writes_what_waits(tmp_path):
    def run() -> None:
        with Recorder(tmp_path, "P1", 1) as recorder:
            for index in range(500):
                recorder.write(frame_row(index))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run()
    assert seconds(tmp_path / "sub-P1" / "ses-1") == [index / 10 for index in range(500)]


class PressedLock:
    """A lock in which Ctrl-C comes just when it is taken."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self.acquire, self.release, self.locked = (
            self._lock.acquire, self._lock.release, self._lock.locked
        )  # fmt: skip
        self.presses = 1

    def __enter__(self) -> None:
        self._lock.acquire()
        for _ in range(self.presses):
            self.presses = 0
            os.kill(os.getpid(), signal.SIGINT)

    def __exit__(self, *_: object) -> None:
        self._lock.release()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends itself no Ctrl-C")
def test_ctrl_c_leaves_no_lock_behind_that_the_writing_thread_waits_for(tmp_path, monkeypatch):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    recorder = Recorder(tmp_path, "P1", 1)
    lock = PressedLock()
    recorder.close()  # its thread waits for nothing any more
    monkeypatch.setattr(recorder._background, "_written", threading.Condition(lock))
    try:
        with pytest.raises(KeyboardInterrupt):
            recorder.flush()
    finally:
        signal.signal(signal.SIGINT, before)
    assert lock.presses == 0
    assert not lock.locked()
