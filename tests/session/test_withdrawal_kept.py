"""Who has withdrawn, or was stopped, is not exposed again, whatever fails just then."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.resume import attempts, folder, go, manifest, rows
from tests.support.study import AheadHeadset, LateFocus, Scripted, frame
from vrcomfort.errors import InputError
from vrcomfort.records import read_participants, set_status, undo_withdrawal


def test_a_program_that_died_before_the_list_was_written_exposes_nobody_again(tmp_path: Path):
    go(tmp_path, Scripted(withdraw_at_s=2.0))
    set_status(tmp_path / "S", "P01", "enrolled")
    with pytest.raises(InputError, match="withdrawn from this study; if that was a slip"):
        go(tmp_path, sessions=[2])
    assert [row.status for row in read_participants(tmp_path / "S")] == ["withdrawn"]


def test_ctrl_c_after_a_withdrawal_does_not_undo_it(tmp_path: Path):
    class StopsThenCtrlC(Scripted):
        def ask(self, form, heard):
            if form.after_withdrawal:
                raise KeyboardInterrupt
            super().ask(form, heard)

    go(tmp_path, StopsThenCtrlC(withdraw_at_s=2.0))
    assert [row[3] for row in attempts(tmp_path)] == ["withdrawn"]
    assert go(tmp_path, resume=True).status == "withdrawn"
    assert len(attempts(tmp_path)) == 1


def test_a_renderer_that_fails_after_a_withdrawal_does_not_hide_it(tmp_path: Path):
    class Fails(LateFocus):
        drained = 0

        def drain(self):
            self.drained += 1
            if self.drained == 2:  # after training comes the exposure
                raise InputError("the disk is full")
            return super().drain()

    with pytest.raises(InputError, match="the disk is full"):
        go(tmp_path, Scripted(withdraw_at_s=2.0), renderer=Fails())
    assert [(row[3], row[4]) for row in attempts(tmp_path)] == [("withdrawn", "participant")]
    assert go(tmp_path, resume=True).status == "withdrawn"
    assert len(attempts(tmp_path)) == 1


def test_a_withdrawal_is_heard_while_the_headset_is_off(tmp_path: Path):
    class TakenOff(AheadHeadset):
        def frames(self):
            for index in range(self.frames_left):
                assert index < 100, "nobody listens"
                yield replace(frame(index), paused=index >= 40)

    class Leaves(Scripted):
        calls = 0

        def update(self, elapsed_s: float) -> None:
            self.calls += 1
            self.withdraw_at_s = 0.0 if self.calls > 50 else None
            super().update(elapsed_s)

    assert go(tmp_path, Leaves(), headset_for=lambda *_: TakenOff()).status == "withdrawn"


def test_a_jump_of_poses_uses_up_no_exposure(tmp_path: Path):
    class Jumps(AheadHeadset):
        """A trace with five seconds cut out."""

        def frames(self):
            for index in range(self.frames_left):
                late = index >= 40
                time_ns = (index + 50 * late) * 100_000_000
                yield replace(frame(index, time_ns=time_ns), discontinuity=index in {0, 40})

    go(tmp_path, headset_for=lambda *_: Jumps())
    trial = rows(tmp_path, "trials")[0]
    assert float(trial["live_s"]) == pytest.approx(10.0, abs=0.2)
    assert float(trial["hidden_s"]) == pytest.approx(4.9, abs=0.2)


def test_an_undoing_is_told_once(tmp_path: Path):
    go(tmp_path, Scripted(withdraw_at_s=2.0), exposure_s=1.0)
    undo_withdrawal(tmp_path / "S", "P01", "a slip")
    file = folder(tmp_path) / "manifest.json"
    content = json.loads(file.read_text())
    content["started_at"] = "2020-01-01T00:00:00+00:00"
    content["withdrawals_undone"][0]["at"] = "2021-01-01T00:00:00+00:00"
    file.write_text(json.dumps(content))
    go(tmp_path, Scripted(interrupt_at_item="nausea"), resume=True)
    assert manifest(tmp_path)["status"] == "aborted"
    go(tmp_path, resume=True)
    told = [row for row in rows(tmp_path, "events") if row["name"] == "withdrawal_undone"]
    assert len(told) == 1
