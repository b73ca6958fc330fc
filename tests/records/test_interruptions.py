"""What an interruption may leave: one declaration, which recorder, resume and verify follow."""

from __future__ import annotations

import os
import re
from functools import partial
from pathlib import Path

import pytest

from tests.support.places import ROOT
from tests.support.resume import folder, go, rows
from vrcomfort.records.interruptions import (
    KEPT,
    OF_FRAMES,
    SAFE_AFTER_S,
    SAFE_AT_ONCE_S,
    SYNC_EVERY_S,
)
from vrcomfort.records.rows import csv_line, declared
from vrcomfort.records.schema import OPTIONAL_ROWS, SESSION_ROWS
from vrcomfort.records.session_rows import GazeValidationRow

if hasattr(os, "fork"):
    from torture import resumed, steps

DOCS = ROOT / "docs" / "reliability.md"


def test_each_file_of_a_session_says_what_is_kept_of_it() -> None:
    assert {each.row_type for each in KEPT} == {*SESSION_ROWS, *OPTIONAL_ROWS}
    assert len({each.row_type for each in KEPT}) == len(KEPT)
    for number, each in enumerate(KEPT):
        names = {column.name for column in declared(each.row_type)}
        assert set(each.over_s) <= names
        assert each.relies_on <= {before.row_type.FILE for before in KEPT[:number]}
        assert each.safe_after_s > SYNC_EVERY_S or each.safe_after_s == SAFE_AT_ONCE_S


def test_the_page_names_the_files_that_are_synced_later() -> None:
    (row,) = (line for line in DOCS.read_text().splitlines() if line.startswith("| power cut |"))
    later = {each.row_type.FILE for each in KEPT if each.safe_after_s == SAFE_AFTER_S}
    assert set(re.findall(r"`(\w+\.csv)`", row)) == later
    assert f"younger than {SAFE_AT_ONCE_S:g} s, or {SAFE_AFTER_S:g} s in" in row
    assert {each.FILE for each in OF_FRAMES} == {
        "gaze.csv",
        "images.csv",
        "hand_joints.csv",
        "balls.csv",
        "part_times.csv",
    }


def test_time_goes_on_after_everything_on_record(tmp_path: Path) -> None:
    """Of a killed run the validation of the gaze may be the last that is on the disk."""
    go(tmp_path, interrupt=(1, 25))
    late = GazeValidationRow(
        "P01", 1, 1, 1, 1, 400.0, 1, "left", 0.0, 0.0, 1.0, 9, 90.0, 0.5, 0.1, 0.1
    )
    file = folder(tmp_path) / late.FILE
    file.write_text(csv_line(late.columns()) + csv_line(late.cells()))
    go(tmp_path, resume=True)
    began = [row["onset_s"] for row in rows(tmp_path, "events") if row["name"] == "session_resumed"]
    assert [float(each) for each in began] == [400.0]


def test_time_begins_at_zero_where_nothing_is_on_record(tmp_path: Path) -> None:
    go(tmp_path, interrupt=(1, 0))
    for file in folder(tmp_path).glob("*.csv"):
        file.write_text(file.read_text().partition("\n")[0] + "\n")
    go(tmp_path, resume=True)
    began = [row["onset_s"] for row in rows(tmp_path, "events") if row["name"] == "session_resumed"]
    assert [float(each) for each in began] == [0.0]


@pytest.fixture(scope="module")
def whole_bytes(tmp_path_factory: pytest.TempPathFactory) -> int:
    """Return how many bytes a whole session takes."""
    return resumed.length(tmp_path_factory.mktemp("whole"), "full disk")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="sessions are run in forks of this process")
@pytest.mark.parametrize("share", [0.1, 0.8])
def test_a_disk_that_was_full_and_has_room_again_leaves_a_whole_session(
    tmp_path: Path, whole_bytes: int, share: float
) -> None:
    study = tmp_path / "case" / "study"
    study.parent.mkdir()
    size_bytes = int(share * whole_bytes)
    fate = steps.Fate("full disk", size_bytes)
    code, _ = steps.run(partial(resumed.work, study, resume=False), fate, study.parent)
    assert code == steps.REFUSED
    assert "No space left" in (study.parent / "said.txt").read_text()
    begun = (study / "sub-P01" / "ses-1" / "manifest.json").exists()
    room = steps.Fate("none")
    code, _ = steps.run(partial(resumed.work, study, resume=begun), room, study.parent)
    assert code == 0
    assert resumed.called_damaged(study, study.parent) == []
