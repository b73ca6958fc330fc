"""A report says what a study lacks: what is passed over in silence is taken for nothing."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

from tests.support.report import foreign, manifest
from tests.support.resume import go
from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.records import RatingRow, TrialRow
from vrcomfort.records.rows import Row, csv_line
from vrcomfort.report.build import choose_plan
from vrcomfort.report.derived_plan import plan_of
from vrcomfort.report.exposures import score_exposures
from vrcomfort.report.gaps import unreadable
from vrcomfort.report.quality import quality
from vrcomfort.report.stimulus_time import stimulus_time
from vrcomfort.report.study_data import read_study


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("whole")
    go(place)
    return place / "S"


@pytest.fixture
def study(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "S"))


def told(study: Path) -> tuple[str, ...]:
    return read_study(study).warnings


def test_a_whole_study_lacks_nothing(study: Path) -> None:
    assert told(study) == ()


@pytest.mark.parametrize(
    ("lost", "says"),
    [
        ("participants.csv", "participants.csv is missing or empty: withdrawals and"),
        ("dataset_description.json", "dataset_description.json is missing or not used: condit"),
        (
            "sub-P01/ses-1/manifest.json",
            "sub-P01/ses-1/manifest.json is missing or not used: w",
        ),
    ],
)
def test_a_file_that_is_missing_is_told(study: Path, lost: str, says: str) -> None:
    (study / lost).unlink()
    (note,) = told(study)
    assert note.startswith(says)
    assert note.endswith("; restore it from a copy")


@pytest.mark.parametrize("row_type", [TrialRow, RatingRow])
def test_a_column_that_a_table_lacks_is_blank(study: Path, row_type: type[Row]) -> None:
    file = study / "sub-P01/ses-1" / row_type.FILE
    whole = CsvTable.read(file)
    for place in range(len(whole.header)):
        rows = [[*row[:place], *row[place + 1 :]] for row in (whole.header, *whole.rows)]
        file.write_text("".join(map(csv_line, rows)), "utf-8")
        found = read_study(study)
        assert all(set(TrialRow.columns()) <= set(trial) for trial in found.trials)
        stimulus_time(found, found.labels)
        plan = plan_of(found)
        quality(found, score_exposures(found, plan), plan, [])
    assert whole.rows


@pytest.mark.parametrize("protocol", [{"x": 1}, None])
def test_a_study_whose_protocol_has_no_name_has_a_plan_of_its_own(study: Path, protocol) -> None:
    file = study / "dataset_description.json"
    content = json.loads(file.read_text("utf-8")) | {"protocol": protocol}
    file.write_text(json.dumps(content), "utf-8")
    assert choose_plan(read_study(study), None)


def test_a_description_that_says_nothing_is_told(study: Path) -> None:
    (study / "dataset_description.json").write_text("[1]", "utf-8")
    fault, note = told(study)
    said = "not used, because it is no whole study description: the whole should be an object"
    assert fault == f"dataset_description.json, line 1: {said} {{...}}"
    assert note.startswith("dataset_description.json is missing or not used")


def test_whoever_is_completed_has_a_session(study: Path) -> None:
    file = study / "participants.csv"
    text = file.read_text("utf-8")
    row = text.splitlines()[1].replace("enrolled", "completed").replace("P01", "P02")
    file.write_text(f"{text}{row}\n", "utf-8")
    (note,) = told(study)
    assert note.startswith("participants.csv: P02 is completed, and has no session here")


def test_whoever_has_two_statuses_has_none(study: Path) -> None:
    file = study / "participants.csv"
    text = file.read_text("utf-8")
    row = text.splitlines()[1]
    file.write_text(f"{text}{row}\n", "utf-8")
    assert told(study) == ()
    status = row.split(",")[2]
    file.write_text(f"{text}{row.replace(status, 'excluded')}\n", "utf-8")
    with pytest.raises(InputError, match=f"has P01 twice, as `{status}` and as `excluded`"):
        read_study(study)


def test_of_other_labs_folders_nothing_is_asked(tmp_path: Path) -> None:
    file = foreign(tmp_path / "a" / "questionnaires.csv", {"P1": {"a": 3}, "P2": {"a": 4}})
    (file.parent / "manifest.json").write_text(manifest("P1"), "utf-8")
    assert told(file.parent) == ()


def test_folders_that_cannot_be_read_are_told_and_a_whole_is_refused(
    study: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    listing, refused = os.scandir, study / "sub-P01"

    def scandir(folder: str | Path) -> object:
        if Path(folder) == refused:
            raise PermissionError(13, "Permission denied", str(folder))
        return listing(folder)

    monkeypatch.setattr(os, "scandir", scandir)
    said = "cannot be read: Permission denied"
    assert unreadable(study) == [f"sub-P01: {said}; nothing in it is in this report"]
    with pytest.raises(InputError, match=said):
        unreadable(refused)


def test_an_empty_file_is_told_as_such(run, tmp_path: Path) -> None:
    file = tmp_path / "answers.csv"
    file.touch()
    with pytest.raises(InputError, match="this file is empty"):
        read_study(file)
    code, _, err = run("score", file)
    assert (code, err.count("\n")) == (2, 1)
    assert "this file is empty" in err


def test_a_folder_is_no_file_of_answers(run, study: Path) -> None:
    code, _, err = run("score", study)
    assert (code, err.count("\n")) == (2, 1)
    assert "this is a folder; give a CSV of it, or a whole study to vrcomfort report" in err
