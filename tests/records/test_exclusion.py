"""Exclusions, notes and the fit of the headset: why, when, and taken back."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from tests.session.test_screening import CALM, Decider, decisions, screen
from tests.support.resume import rows
from tests.support.study import read_rows
from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.records import read_participants
from vrcomfort.records.participants import add_note, exclude, undo_exclusion
from vrcomfort.report.study_data import read_study

FITTED = CALM + "[headset]\nipd_range_m = [0.058, 0.072]\n"


def row_of(folder):
    (row,) = read_participants(folder / "S")
    return row


@pytest.fixture
def study(tmp_path):
    screen(tmp_path, Decider(), CALM)
    return tmp_path


def test_an_exclusion_has_its_reason_and_is_taken_back_to_what_was(study):
    assert row_of(study).status == "completed"
    exclude(study / "S", "P01", "fell asleep; twice")
    assert row_of(study).status == "excluded"
    assert "fell asleep; twice" in row_of(study).note
    assert {row["status"] for row in read_study(study / "S").participants} == {"excluded"}
    assert not verify_study(study / "S").faults
    with pytest.raises(InputError, match="is excluded already"):
        exclude(study / "S", "P01", "again")
    with pytest.raises(InputError, match="P01 is excluded from this study"):
        screen(study, Decider(), CALM)
    assert undo_exclusion(study / "S", "P01", "it was P10") == "completed"
    row = row_of(study)
    assert row.status == "completed"
    assert row.note.index("fell asleep") < row.note.index("exclusion undone")
    with pytest.raises(InputError, match="is completed, not excluded"):
        undo_exclusion(study / "S", "P01", "again")


def test_who_withdrew_is_withdrawn_again(tmp_path):
    screen(tmp_path, Decider(withdraw_at_s=0.5), CALM)
    exclude(tmp_path / "S", "P01", "no data")
    assert undo_exclusion(tmp_path / "S", "P01", "there are some") == "withdrawn"


def test_an_exclusion_by_hand_can_be_taken_back_too(study):
    file = study / "S/participants.csv"
    file.write_text(file.read_text(encoding="utf-8").replace("completed", "excluded"))
    assert undo_exclusion(study / "S", "P01", "by mistake") == "enrolled"


def test_notes_are_added_with_their_date(study):
    add_note(study / "S", "P01", "wears glasses, -3 D")
    add_note(study / "S", "P01", 'said "too bright"')
    note = row_of(study).note
    assert "wears glasses, -3 D; " in note
    assert note.endswith('said "too bright"')
    assert row_of(study).status == "completed"


@pytest.mark.parametrize("act", [exclude, undo_exclusion, add_note])
def test_each_needs_a_text_and_a_participant(study, act):
    with pytest.raises(InputError, match="is empty; say why"):
        act(study / "S", "P01", "  ")
    with pytest.raises(InputError, match="no participant P77"):
        act(study / "S", "P77", "why")


def test_the_commands(study):
    folder = str(study / "S")
    for words in (
        ["note", folder, "P01", "left-handed"],
        ["exclude", folder, "P01", "--reason", "fell asleep"],
        ["undo-exclusion", folder, "P01", "--reason", "it was P10"],
    ):
        assert CliRunner().invoke(app, words).exit_code == 0
    assert row_of(study).status == "completed"
    assert all(each in row_of(study).note for each in ("left-handed", "fell asleep", "P10"))


@pytest.mark.parametrize(
    ("ipd_m", "rule"),
    [
        (0.0579, "distance between pupils in mm below 58"),
        (0.0721, "distance between pupils in mm above 72"),
    ],
)
def test_an_ipd_that_does_not_fit_is_told_before_the_exposure(tmp_path, ipd_m, rule):
    person = Decider(False)
    screen(tmp_path, person, FITTED, ipd_measured_m=ipd_m)
    assert decisions(tmp_path) == [(rule, pytest.approx(1000 * ipd_m), "stop")]
    assert f"is {1000 * ipd_m:g}, " in person.questions[0]
    assert rows(tmp_path, "trials") == []
    anonymise(tmp_path / "S", tmp_path / "shared", AnonymisingOptions(seed=1))
    (file,) = (tmp_path / "shared").rglob("screening.csv")
    assert [(row["rule"], row["value"]) for row in read_rows(file)] == [(rule, "")]
    assert not verify_study(tmp_path / "shared").faults


@pytest.mark.parametrize("ipd_m", [None, 0.058, 0.064, 0.072])
def test_an_ipd_that_fits_is_not(tmp_path, ipd_m):
    screen(tmp_path, Decider(), FITTED, ipd_measured_m=ipd_m)
    assert not (tmp_path / "S/sub-P01/ses-1/screening.csv").exists()


def test_a_range_rises(tmp_path):
    with pytest.raises(InputError, match="the least distance first"):
        screen(tmp_path, Decider(), FITTED.replace("[0.058, 0.072]", "[0.072, 0.058]"))
