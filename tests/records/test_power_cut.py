"""What is on the disk when the power goes: never less than what was promised."""

from __future__ import annotations

import os
import threading
import time
from collections import Counter
from pathlib import Path

import pytest

from tests.support.resume import folder, go
from tests.support.study import Scripted, frame
from tests.support.waiting import WAIT_S, wait_for
from vrcomfort.geometry import Gaze
from vrcomfort.records import (
    EventRow,
    FrameRow,
    GazeRow,
    QuestionnaireRow,
    RatingRow,
    Recorder,
    TimingRow,
    TrialRow,
)
from vrcomfort.records.row_files import SYNC_EVERY_S
from vrcomfort.records.session_rows import GazeValidationRow

TRIAL = TrialRow("P1", 1, 1, 1, 1, "a", "s", 0.0, 1.0, "completed", None, 1, 0, 9, 0)
RATING = RatingRow("P1", 1, 1, "a", 1.0, 0.5, "fms", 3, 0)
TIMING = TimingRow("P1", 1, 1, "a", 1, 9, 0, *[None] * 10, flagged=0)


def frame_row(index: int) -> FrameRow:
    shown = frame(index)
    left, right = shown.views
    return FrameRow(
        index / 10, index, 100, 1, True, shown.head_pose, left, right, shown.avatar_pose,
        gaze=GazeRow(index / 10, index, Gaze(shown.head_pose)),
    )  # fmt: skip


class Disk:
    """Remembers what was in each file when it was last synced: all that a power cut leaves."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.safe: dict[str, bytes] = {}
        self.syncs: Counter[str] = Counter()
        self.order: list[str] = []
        self.names: dict[Path, set[str]] = {}
        self.works = threading.Event()
        self.works.set()
        for name in ("fsync", "fdatasync"):
            monkeypatch.setattr(f"os.{name}", self._sync)

    def _sync(self, descriptor: int) -> None:
        assert self.works.wait(WAIT_S)
        path = Path(f"/proc/self/fd/{descriptor}").readlink()
        if path.is_dir():
            self.names[path] = {each.name for each in path.iterdir()}
            return
        self.safe[path.name] = path.read_bytes()
        self.syncs[path.name] += 1
        self.order.append(path.name)

    def rows(self, name: str) -> int:
        return max(0, self.safe.get(name, b"").count(b"\n") - 1)

    def until(self, name: str, rows: int) -> None:
        """Wait until so many rows are safe."""
        wait_for(lambda: self.rows(name) >= rows, lambda: f"{name} is not synced")


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Disk:
    return Disk(monkeypatch)


VALIDATION = GazeValidationRow(
    "P1", 1, 1, 1, 1, 0.0, 1, "left", 0.0, 0.0, 1.0, 9, 90.0, 0.5, 0.1, 0.1
)


@pytest.mark.parametrize("row", [RATING, EventRow(0.0, 0.0, "start"), TRIAL, VALIDATION])
def test_a_row_that_is_waited_for_is_safe(tmp_path, disk, row):
    with Recorder(tmp_path, "P1", 1) as recorder:
        recorder.write(row)
        assert disk.rows(row.FILE) == 1


def test_a_rating_in_an_exposure_is_safe_soon_and_no_frame_waits(tmp_path, disk):
    with Recorder(tmp_path, "P1", 1) as recorder:
        disk.works.clear()  # whoever waited for it would wait for ever
        for index in range(100):
            recorder.write(frame_row(index))
        recorder.write_soon(RATING)
        recorder.write_soon(EventRow(0.0, 0.0, "focused"))
        disk.works.set()
        disk.until("ratings.csv", 1)
        disk.until("events.csv", 1)


def test_frames_gaze_and_timing_are_safe_within_the_second_without_another_row(tmp_path, disk):
    with Recorder(tmp_path, "P1", 1) as recorder:
        before = disk.syncs["frames.csv"]
        for index in range(20):
            recorder.write(frame_row(index))
        recorder.write_soon(TIMING)
        disk.until("frames.csv", 20)
        assert disk.syncs["frames.csv"] - before < 20, "at each row"
        disk.until("gaze.csv", 20)
        disk.until("timing.csv", 1)
        assert SYNC_EVERY_S <= 1.0


def test_rows_that_arrive_together_share_a_sync(tmp_path, disk):
    with Recorder(tmp_path, "P1", 1) as recorder:
        recorder.flush()
        before = disk.syncs["ratings.csv"]
        disk.works.clear()
        for _ in range(50):
            recorder.write_soon(RATING)
        disk.works.set()
        recorder.flush()
        assert disk.rows("ratings.csv") == 50
        assert disk.syncs["ratings.csv"] - before <= 3


def test_a_trials_row_is_safe_after_all_that_belongs_to_it(tmp_path, disk):
    with Recorder(tmp_path, "P1", 1) as recorder:
        for index in range(30):
            recorder.write(frame_row(index))
        recorder.write_soon(RATING)
        disk.order.clear()
        recorder.write(TIMING, TRIAL)
        rows = {name: disk.rows(f"{name}.csv") for name in ("frames", "gaze", "timing", "ratings")}
        assert rows == {"frames": 30, "gaze": 30, "timing": 1, "ratings": 1}
        assert set(disk.order[:-1]) >= {"frames.csv", "gaze.csv", "timing.csv"}
        assert disk.order[-1] == "trials.csv"


def test_a_simulated_session_is_synced_at_its_end_alone(tmp_path, disk):
    with Recorder(tmp_path, "P1", 1, durability="session_end") as recorder:
        recorder.write(frame_row(0), RATING, TRIAL)
        time.sleep(2 * SYNC_EVERY_S)
        assert not disk.syncs
        recorder.sync()
        assert disk.rows("trials.csv") == disk.rows("frames.csv") == 1
    assert set(disk.syncs.values()) == {1}


def test_the_names_of_files_and_folders_are_safe(tmp_path, disk):
    study = tmp_path / "new" / "study"
    with Recorder(study, "P1", 1) as recorder:
        recorder.write(frame_row(0))
        recorder.flush()
    assert "new" in disk.names[tmp_path]
    assert "study" in disk.names[tmp_path / "new"]
    assert "sub-P1" in disk.names[study]
    assert "ses-1" in disk.names[study / "sub-P1"]
    assert {"frames.csv", "gaze.csv", "events.csv"} <= disk.names[recorder.folder]


@pytest.mark.parametrize("durability", ["each_row", "session_end"])
def test_a_session_whose_manifest_says_completed_has_lost_nothing(tmp_path, disk, durability):
    went = go(tmp_path, durability=durability)
    assert went.status == "enrolled"
    completed = [i for i, name in enumerate(disk.order) if "manifest.json" in name][-1]
    assert b'"status": "completed"' in disk.safe[".manifest.json.new"]
    assert not {f"{name}.csv" for name in ("ratings", "frames", "trials")} & set(
        disk.order[completed:]
    )
    for name in ("trials", "timing", "questionnaires", "ratings", "frames", "events"):
        file = folder(tmp_path) / f"{name}.csv"
        assert disk.safe[file.name] == file.read_bytes()
    assert "manifest.json" in disk.names[folder(tmp_path)]
    assert "participants.csv" in disk.names[tmp_path / "S"]


def test_every_answer_is_safe_before_the_next_is_asked(tmp_path, disk):
    answered = []

    class Watches(Scripted):
        def ask(self, form, heard):
            for item in form.instrument.items:
                heard(item.name, 1, 2.0)
                answered.append(item)
                assert disk.rows(QuestionnaireRow.FILE) == len(answered)

    go(tmp_path, Watches())
    assert len(answered) == 64


def test_a_disk_that_cannot_sync_is_told(tmp_path, monkeypatch):
    def broken(_: int) -> None:
        raise OSError(5, "Input/output error")

    with Recorder(tmp_path, "P1", 1) as recorder:
        recorder.write(RATING)
        monkeypatch.setattr("os.fdatasync", broken)
        with pytest.raises(ValueError, match=r"ratings\.csv: cannot write: Input/output error"):
            recorder.write(RATING)
        monkeypatch.undo()
        recorder.write(RATING)
    assert (recorder.folder / "ratings.csv").read_bytes().count(b"\n") == 4


def test_what_a_full_disk_refused_is_written_when_there_is_room(tmp_path):
    recorder = Recorder(tmp_path, "P1", 1)
    recorder.flush()
    descriptor = recorder._files["ratings.csv"].fileno()
    kept, device = os.dup(descriptor), os.open("/dev/full", os.O_WRONLY)
    os.dup2(device, descriptor)
    with pytest.raises(ValueError, match="No space left"):
        recorder.write(RATING)
    os.dup2(kept, descriptor)
    os.close(kept)
    os.close(device)
    recorder.write(RATING)
    recorder.close()
    assert (recorder.folder / "ratings.csv").read_bytes().count(b"\n") == 3
    assert "recorder" not in {thread.name for thread in threading.enumerate()}
