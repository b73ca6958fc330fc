"""A recorded file that another program removes, replaces or cuts while the session is recorded."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.records.test_power_cut import frame_row
from tests.support.session import go, manifest, rows
from tests.support.study import AheadHeadset, Scripted, read_rows
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.operator_interface import SessionProgress
from vrcomfort.records import EventRow, QuestionnaireRow, Recorder, TrialRow

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows lets nobody remove or replace a file that is open"
)

Change = Callable[[Path], None]


def replace(file: Path) -> None:
    """Do what an editor does that saves an older content."""
    draft = file.with_suffix(".draft")
    draft.write_text("older\n")
    draft.replace(file)


def events(recorder: Recorder, first: int, last: int) -> None:
    recorder.write(*(EventRow(float(each), 0.0, "said", "a, b") for each in range(first, last)))


def onsets(file: Path) -> list[float]:
    return [float(row["onset_s"]) for row in read_rows(file)]


@pytest.mark.parametrize("change", [Path.unlink, replace], ids=["removed", "replaced"])
@pytest.mark.parametrize("durability", ["each_row", "session_end"])
def test_no_row_is_lost_with_a_file(tmp_path, change: Change, durability) -> None:
    with Recorder(tmp_path, "P1", 1, durability=durability) as recorder:
        file = recorder.folder / "events.csv"
        events(recorder, 0, 50)
        recorder.flush()
        change(file)
        events(recorder, 50, 60)
        recorder.sync()
        (found,) = recorder.take_external_changes()
        events(recorder, 60, 70)
    assert onsets(file) == [float(each) for each in range(70)]
    assert not found.lost
    assert f"{file}: another program has re" in found.sentence
    assert recorder.take_external_changes() == []
    aside = file.with_name("events.csv.replaced1")
    assert change is Path.unlink or aside.read_text() == "older\n"


def test_a_file_of_frames_is_put_back_while_frames_come(tmp_path) -> None:
    with Recorder(tmp_path, "P1", 1) as recorder:
        for index in range(30):
            recorder.write(frame_row(index))
            if index == 10:
                recorder.sync()
                for name in ("frames.csv", "gaze.csv"):
                    (recorder.folder / name).unlink()
    for name in ("frames.csv", "gaze.csv"):
        assert len(read_rows(recorder.folder / name)) == 30


@pytest.mark.parametrize("kept_bytes", [0, 60])
def test_rows_that_were_cut_off_are_told_and_what_follows_can_be_read(tmp_path, kept_bytes) -> None:
    with Recorder(tmp_path, "P1", 1) as recorder:
        file = recorder.folder / "events.csv"
        events(recorder, 0, 50)
        with file.open("r+b") as stream:
            stream.truncate(kept_bytes)
        events(recorder, 50, 60)
        (found,) = recorder.take_external_changes()
        assert found.lost
        events(recorder, 60, 70)
    assert onsets(file)[-20:] == [float(each) for each in range(50, 70)]


def test_a_correction_finds_its_row_in_a_file_that_was_removed(tmp_path) -> None:
    def answer(item: str, response: int) -> QuestionnaireRow:
        return QuestionnaireRow(
            "P1", 1, None, None, None, None, "post", "ssq", item, response, 0.5, 1.25, 1
        )

    with Recorder(tmp_path, "P1", 1) as recorder:
        file = recorder.folder / "questionnaires.csv"
        recorder.write(answer("nausea", 1), answer("sweating", 2))
        for response in (2, 3):
            file.unlink()
            recorder.replace(answer("nausea", response - 1), answer("nausea", response))
    found = [(row["item"], row["response"]) for row in read_rows(file)]
    assert found == [("nausea", "3"), ("sweating", "2")]


def run_and_change(tmp_path: Path, change: Change) -> tuple[list[str], tuple[str, ...]]:
    """Change events.csv at the 50th frame of an exposure; return the notices and what was lost."""
    told: list[str] = []
    file = tmp_path / "S" / "sub-P01" / "ses-1" / "events.csv"

    class Headset(AheadHeadset):
        def frames(self):
            for each in super().frames():
                if each.index == 50 and not told and file.exists():
                    changes.pop()(file) if changes else None
                yield each

    changes = [change]

    def tell(progress: SessionProgress) -> None:
        if progress.step == "notice":
            told.append(progress.text)

    outcome = go(tmp_path, Scripted(), headset=Headset, sessions=[1], progress=tell)
    assert not changes
    return told, outcome.lost


@pytest.mark.parametrize("change", [Path.unlink, replace], ids=["removed", "replaced"])
def test_a_session_goes_on_tells_it_at_once_and_is_whole(tmp_path, change: Change) -> None:
    told, lost = run_and_change(tmp_path, change)
    (event,) = (row for row in rows(tmp_path, "events.csv") if row["name"] == "file_put_back")
    assert [event["detail"]] == told == manifest(tmp_path)["changed_while_recorded"]
    assert lost == ()
    assert verify_study(tmp_path / "S").faults == []


def test_a_session_whose_rows_were_cut_off_says_so_at_its_end(tmp_path) -> None:
    told, lost = run_and_change(tmp_path, lambda file: file.write_text(""))
    (event,) = (row for row in rows(tmp_path, "events.csv") if row["name"] == "rows_lost")
    assert [event["detail"]] == told == list(lost)


def test_the_exit_code_says_that_rows_are_lost(tmp_path, run, monkeypatch) -> None:
    write = Recorder.write

    def write_and_cut(self, *written):
        write(self, *written)
        if any(isinstance(row, TrialRow) for row in written):
            (self.folder / "events.csv").write_text("")

    monkeypatch.setattr(Recorder, "write", write_and_cut)
    study = tmp_path / "S"
    code, _, err = run("simulate", "smoke", "-n", 1, "--no-draw", "--out", study)
    assert code == 2
    assert "events.csv: another program has cut off the last" in err
    assert "these rows are lost" in err
