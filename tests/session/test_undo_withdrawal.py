"""A withdrawal that was a slip of the hand is taken back by an operator."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from tests.support import session
from tests.support.session import manifest, rows, status
from tests.support.study import Scripted
from vrcomfort.errors import InputError
from vrcomfort.records import undo_withdrawal
from vrcomfort.report.study_data import read_study
from vrcomfort.report.withdrawals import find_withdrawals

go = partial(session.go, exposure_s=1.0)


def withdrawn(tmp_path: Path) -> Path:
    """Return a study whose participant withdrew in the first exposure of the first session."""
    outcome = go(tmp_path, Scripted(withdraw_at_s=1.0))
    assert outcome.status == "withdrawn"
    return tmp_path / "S"


def test_the_session_goes_on_and_everything_stays_on_record(tmp_path: Path) -> None:
    study = withdrawn(tmp_path)
    before = rows(tmp_path, "events.csv")
    assert undo_withdrawal(study, "P01", "pressed q instead of 1") == 1
    assert manifest(tmp_path)["status"] == "aborted"
    now, note = status(tmp_path)
    assert now == "enrolled"
    assert "pressed q instead of 1" in note
    assert find_withdrawals(read_study(study)) == []
    assert go(tmp_path, Scripted(), resume=True, sessions=[1]).status in {"enrolled", "completed"}
    assert manifest(tmp_path)["status"] == "completed"
    events = rows(tmp_path, "events.csv")
    assert events[: len(before)] == before
    assert "withdrawal_undone" in [row["name"] for row in events[len(before) :]]
    (kept,) = manifest(tmp_path)["withdrawals_undone"]
    assert (kept["reason"], kept["trial"]) == ("pressed q instead of 1", 1)
    trials = [(row["trial"], row["attempt"], row["status"]) for row in rows(tmp_path, "trials.csv")]
    assert trials[:2] == [("1", "1", "withdrawn"), ("1", "2", "completed")]
    assert find_withdrawals(read_study(study)) == []


def test_a_withdrawal_at_a_question_can_be_undone(tmp_path: Path) -> None:
    assert go(tmp_path, Scripted(withdraw_at_item="fatigue")).status == "withdrawn"
    undo_withdrawal(tmp_path / "S", "P01", "a slip")
    assert go(tmp_path, Scripted(), resume=True, sessions=[1]).status in {"enrolled", "completed"}
    assert [row["trial"] for row in rows(tmp_path, "trials.csv")][:2] == ["1", "2"]


def test_who_withdraws_again_has_withdrawn(tmp_path: Path) -> None:
    study = withdrawn(tmp_path)
    undo_withdrawal(study, "P01", "a slip")
    assert go(tmp_path, Scripted(withdraw_at_s=1.0), resume=True).status == "withdrawn"
    assert status(tmp_path)[0] == "withdrawn"
    (found,) = find_withdrawals(read_study(study))
    assert found.participant == "P01"


def test_only_a_withdrawal_can_be_undone(tmp_path: Path) -> None:
    study = withdrawn(tmp_path)
    with pytest.raises(InputError, match="no participant P02"):
        undo_withdrawal(study, "P02", "a slip")
    with pytest.raises(InputError, match="the text is empty; say why"):
        undo_withdrawal(study, "P01", " ")
    undo_withdrawal(study, "P01", "a slip")
    with pytest.raises(InputError, match="P01 is enrolled, not withdrawn"):
        undo_withdrawal(study, "P01", "a slip")
