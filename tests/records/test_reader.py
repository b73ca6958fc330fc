"""The reader of a study's folder: typed data frames, rows, lazy recordings, and their faults."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pandas as pd
import pytest

import vrcomfort
from tests.support.exchange import cell, with_gaze
from tests.support.places import ROOT
from vrcomfort.errors import InputError
from vrcomfort.recordings import pack_study
from vrcomfort.records import EventRow, TaskRow, TrialRow
from vrcomfort.records.reader import Study
from vrcomfort.records.recording import Memory

SESSION = "sub-P01/ses-1"
OLDER = ROOT / "tests" / "data" / "study_of_schema_1"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return with_gaze(tmp_path_factory.mktemp("whole"))


@pytest.fixture
def study(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "S"))


def lines_of(study: Path, name: str) -> int:
    return sum(file.read_text().count("\n") - 1 for file in study.rglob(name))


def test_a_study_is_its_sessions_in_order(whole: Path) -> None:
    sessions = Study(whole).sessions
    assert [(each.participant, each.number) for each in sessions] == [("P01", 1), ("P01", 2)]
    assert [each.manifest["session"] for each in sessions] == [1, 2]


def test_data_frames_have_every_row_and_the_types_of_the_schema(whole: Path) -> None:
    study = Study(whole)
    assert len(study.answers) == lines_of(whole, "questionnaires.csv")
    assert len(study.ratings) == lines_of(whole, "ratings.csv")
    assert list(study.trials["condition"]) == ["plain", "blur", "blur", "plain"]
    assert study.trials["trial"].dtype == "Int64"
    assert study.trials["end_s"].dtype == "float64"
    before = study.answers[study.answers["timepoint"] == "baseline"]
    assert before["condition"].isna().all()
    assert before["trial"].isna().all()


def test_events_have_the_participant_and_session_of_their_folder(whole: Path) -> None:
    begun = Study(whole).events.query("name == 'session_start'")
    assert [*zip(begun["participant"], begun["session"], strict=True)] == [("P01", 1), ("P01", 2)]


def test_columns_of_later_versions_are_blank_in_a_study_of_an_older_one() -> None:
    trials = Study(OLDER).trials
    assert trials["live_s"].isna().all()
    assert tuple(trials.columns) == TrialRow.columns()


def test_a_table_that_no_session_has_is_empty_with_its_columns(whole: Path) -> None:
    tasks = Study(whole).data_frame(TaskRow)
    assert tasks.empty
    assert tuple(tasks.columns) == TaskRow.columns()
    assert list(Study(whole).sessions[0].rows(TaskRow)) == []


def test_a_cell_that_cannot_be_is_told_with_its_place(study: Path) -> None:
    cell(study / SESSION / "trials.csv", 3, "start_s", "soon")
    with pytest.raises(InputError, match="'soon' is not a number") as caught:
        _ = Study(study).trials
    assert caught.value.file == study / SESSION / "trials.csv"
    assert (caught.value.line, caught.value.column) == (3, "start_s")
    with pytest.raises(InputError, match="line 3, column start_s: 'soon' is not a number"):
        list(Study(study).session("P01", 1).rows(TrialRow))


def test_a_half_written_row_is_left_out_with_a_warning(study: Path) -> None:
    file = study / SESSION / "ratings.csv"
    file.write_text(file.read_text()[:-4])
    with pytest.warns(UserWarning, match=r"ratings.csv, line \d+: the last row is half-written"):
        assert len(Study(study).ratings) == lines_of(study, "ratings.csv")


def test_tables_of_other_origin_keep_their_words(tmp_path: Path) -> None:
    text = "participant,session,item,response,age\nP1,pre,nausea,2,30\nP2,post,nausea,,41\n"
    (tmp_path / "questionnaires.csv").write_text(text)
    answers = Study(tmp_path).answers
    assert list(answers["session"]) == ["pre", "post"]
    assert list(answers["response"].dropna()) == [2]
    assert list(answers["age"]) == [30, 41]
    assert Study(tmp_path / "questionnaires.csv").answers.equals(answers)


def test_frames_are_a_relation_that_is_read_when_it_is_asked(study: Path) -> None:
    def counted() -> pd.DataFrame:
        found = Study(study).frames.aggregate("participant, session, count(*) AS n")
        return found.order("session").df()

    def rows(session: int) -> int:
        return lines_of(study / f"sub-P01/ses-{session}", "frames.csv")

    of_csv = counted()
    assert list(of_csv["n"]) == [rows(1), rows(2)]
    list(pack_study(study, Memory()))
    assert counted().equals(of_csv)
    session = Study(study).session("P01", 2)
    assert session.gaze.aggregate("count(*)").fetchall() == [(rows(2),)]
    assert len(session.recording().columns(["head_y_m"], Memory())["head_y_m"]) == rows(2)


def test_frames_of_a_killed_session_are_read_without_their_half_written_row(study: Path) -> None:
    file = study / SESSION / "frames.csv"
    file.write_text(file.read_text()[:-9])
    frames = Study(study).session("P01", 1).frames.filter("trial > 0")  # later than the copy made
    assert 0 < len(frames.df()) < lines_of(study / SESSION, "frames.csv")


def test_a_study_without_recordings_or_folder_says_so(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no recording of this kind"):
        _ = Study(tmp_path).frames
    with pytest.raises(InputError, match="there is no such file or folder"):
        Study(tmp_path / "nowhere")


def test_rows_are_values_in_their_order(whole: Path) -> None:
    events = list(Study(whole).session("P01", 1).rows(EventRow))
    assert events[0]["name"] == "session_start"
    assert [event["onset_s"] for event in events] == sorted(event["onset_s"] for event in events)


CSV_READERS = {
    "csv_table.py": "the table itself",
    "records/tables.py": "rows and tables of a study",
    "records/recording.py": "frames, gaze and long ratings, and the place of what is wrong in them",
    "recordings/ratings.py": "ratings, in parts, as a report sums them up",
    "traces/table.py": "head traces, of any program",
    "questionnaire/library.py": "answers, to find whose items they are",
    "questionnaire/tables.py": "answers that are scored, of any program",
    "importing/text_files.py": "tables of other programs, however they separate cells",
    "importing/head_logs/reading.py": "head logs of other programs, likewise",
    "records/checksums.py": "the columns of participants, to name those that were changed",
    "api/reports.py": "a first row, to tell a tidy file from others",
}
"""The modules that open CSV files, and of what."""


def test_the_tables_of_a_study_are_opened_in_one_place() -> None:
    root = Path(vrcomfort.__file__).parent
    opening = re.compile(r"Table\.(read|parts)\(|csv\.(reader|DictReader)\(|read_csv\(")
    found = {
        file.relative_to(root).as_posix()
        for file in root.rglob("*.py")
        if opening.search(file.read_text("utf-8"))
    }
    assert found == CSV_READERS.keys()
