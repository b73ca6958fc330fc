"""`vrcomfort erase`: nothing that identifies stays, and the study stays whole."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.support.resume import go
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.designs import design_of
from vrcomfort.exchange.psych_ds import export_psych_ds
from vrcomfort.exchange.status import status_of
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.records import read_participants
from vrcomfort.records.consents import ConsentRow, note_consent, read_consents
from vrcomfort.records.erasure import erase
from vrcomfort.records.participants import add_note
from vrcomfort.records.reader import Study
from vrcomfort.records.study import enrolment_of
from vrcomfort.report.study_data import read_study


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a study of Anna77 and Bert88, with notes that name Anna77."""
    place = tmp_path_factory.mktemp("erased")
    for name in ("Anna77", "Bert88"):
        go(place, participant=name, sessions=[1, 2])
    study = place / "S"
    add_note(study, "Anna77", "the mayor's daughter")
    add_note(study, "Bert88", "came with Anna77; Anna771 is nobody")
    for name in ("Anna77", "Bert88"):
        note_consent(study, ConsentRow(name, "1", "2026-01-01", "", "2026-01-01"))
    (study / "sub-Anna77/ses-1/frames.parquet").write_bytes(b"PAR1")
    return study


@pytest.fixture
def study(recorded: Path, tmp_path: Path) -> Path:
    return shutil.copytree(recorded, tmp_path / "S")


def test_nothing_of_the_person_stays_and_the_study_is_whole(run, study: Path, tmp_path: Path):
    before = {row.participant: row for row in read_participants(study)}
    code, out, err = run("erase", study, "Anna77", "--yes")
    assert code == 0, err
    assert "2 sessions. erased1 is the row that stays" in out
    assert "not reached: " in err
    for each in study.rglob("*"):
        assert "sub-Anna77" not in str(each)
        if each.is_file():
            content = each.read_bytes().replace(b"Anna771", b"")
            assert b"Anna77" not in content, each
            assert b"mayor" not in content, each
    gone, left = read_participants(study)
    assert (gone.participant, gone.status, gone.enrolled_at) == ("erased1", "erased", "")
    assert gone.sequence == before["Anna77"].sequence
    assert gone.note.startswith("erased on 20")
    assert "came with [erased]; Anna771 is nobody" in left.note
    assert [row.participant for row in read_consents(study)] == ["Bert88"]
    assert verify_study(study).faults == []
    assert {row["participant"] for row in read_study(study).participants} == {"Bert88"}
    export_psych_ds(study, tmp_path / "export")
    anonymise(study, tmp_path / "copy", AnonymisingOptions())
    assert verify_study(tmp_path / "copy").faults == []
    for folder in (tmp_path / "export", tmp_path / "copy"):
        assert not any(b"erased1" in f.read_bytes() for f in folder.rglob("*") if f.is_file())


def test_nothing_is_erased_where_nobody_can_be_asked(run, study: Path):
    code, _, err = run("erase", study, "Anna77")
    assert code == 2
    assert "--yes erases Anna77" in err
    assert (study / "sub-Anna77").is_dir()


def test_the_orders_of_the_next_stay_what_they_are_where_somebody_leaves(study: Path):
    design = design_of(Study(study).session("Bert88", 1).manifest)
    rows = read_participants(study)
    left = [(r.sequence, "withdrawn" if r.participant == "Anna77" else r.status) for r in rows]
    erase(study, "Anna77")
    now = [enrolment_of(row) for row in read_participants(study)]
    was = [enrolment_of(row).__class__(*each) for row, each in zip(rows, left, strict=True)]
    assert design.assign(now) == design.assign(was)
    assert status_of(study).statuses == {"erased": 1, "completed": 1}


def test_what_still_names_the_person_is_listed(run, study: Path):
    (study / "report").mkdir()
    (study / "report/results.json").write_text('{"worst": "Anna77"}')
    code, _, err = run("erase", study, "Anna77", "--yes")
    assert code == 0
    assert f"{Path('report/results.json')} still names Anna77" in err
    assert err.count("still names") == 1


def test_an_erasure_that_was_interrupted_is_completed_by_the_same_command(study: Path):
    shutil.rmtree(study / "sub-Anna77/ses-1")
    assert erase(study, "Anna77").sessions == 1
    (study / "sub-Anna77").mkdir()
    assert erase(study, "Anna77").row == ""
    assert not (study / "sub-Anna77").exists()
    with pytest.raises(InputError, match="no participant Anna77"):
        erase(study, "Anna77")
    assert [row.participant for row in read_participants(study)] == ["erased1", "Bert88"]
