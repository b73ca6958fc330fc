"""Sessions that were interrupted and went on: whole ones are not called damaged, others still are.

The sessions of `torture.resumed` are stopped, killed, cut off and refused at random steps.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from tests.exchange.test_verify import sealed, told
from tests.session.test_sliders import PROTOCOL as SLIDING
from tests.session.test_sliders import TASK
from tests.support.exchange import SeesEyes, cell
from tests.support.resume import folder, go, rows
from tests.support.study import AheadHeadset, Scripted, tiny_protocol
from tests.support.tasks import do
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.records import ClockRow
from vrcomfort.records.rows import cell_text, csv_line

if hasattr(os, "fork"):
    from torture import resumed

SESSION = "sub-P01/ses-1"


@pytest.fixture(scope="module")
def cases(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("resumed")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="sessions are run in forks of this process")
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(len(resumed.FATES)) if hasattr(os, "fork") else ())
def test_a_session_that_went_on_is_whole_and_can_be_handed_on(cases: Path, seed: int) -> None:
    fate = resumed.FATES[seed % len(resumed.FATES)]
    found = resumed.judge(cases, seed, fate)
    assert (found.faults, found.lost) == ([], 0), found.name
    assert found.handed > 500


class Stopped(AheadHeadset):
    """Ctrl-C comes in the third second of the first exposure."""

    def __init__(self) -> None:
        super().__init__(interrupt_at=25)


def test_tasks_and_dials_are_each_in_their_own_order(tmp_path: Path) -> None:
    both = SLIDING.replace("[[sliders]]", f"{TASK}\n[[sliders]]").replace(
        'scenes = ["room.glb"]', 'scenes = ["room.glb"]\ntask = "shoot"'
    )
    do(tmp_path, both, headset=Stopped)
    do(tmp_path, both, resume=True)
    assert told(tmp_path / "S") == []
    file = tmp_path / "S" / SESSION / "dials.csv"
    cell(file, file.read_text().count("\n"), "resumed", "0")
    assert any(
        "dials.csv" in each and "rows of the next" in each for each in sealed(file.parents[2])
    )


def interrupted(tmp_path: Path, *, killed: bool, headset: Callable[[], AheadHeadset]) -> Path:
    """Interrupt the first exposure; return the session's folder."""
    begun = []

    def headset_for(*_: object) -> AheadHeadset:
        begun.append(1)
        made = headset()
        made.interrupt_at = 25 if len(begun) == 1 else None
        return made

    go(tmp_path, headset_for=headset_for)
    session = folder(tmp_path)
    if killed:
        file = session / "manifest.json"
        content = json.loads(file.read_text())
        (trial,) = rows(tmp_path, "trials")
        under_way = {
            name: int(trial[name]) if trial[name].isdecimal() else trial[name]
            for name in ("participant", "session", "period", "block", "trial", "condition",
                         "scene", "attempt", "resumed")
        }  # fmt: skip
        under_way["start_s"] = float(trial["start_s"])
        content |= {"status": "running", "finished_at": None, "under_way": under_way}
        file.write_text(json.dumps(content, indent=2))
        drop_last(session / "trials.csv", 1)
        drop_last(session / "timing.csv", 1)
    return session


def test_frames_of_a_training_are_of_no_exposure(tmp_path: Path) -> None:
    """Ctrl-C comes at the first line after the training was shown."""
    shown = []

    def trace(frame: FrameType, event: str, _: object) -> Any:
        runs, name = frame.f_code.co_filename.endswith("trial.py"), frame.f_code.co_name
        if event == "return" and name == "show":
            shown.append(name)
        elif event == "line" and runs and name == "_train_once" and shown:
            sys.settrace(None)
            raise KeyboardInterrupt
        return trace

    protocol = tiny_protocol(tmp_path)
    assert protocol.training_s
    sys.settrace(trace)
    try:
        assert go(tmp_path, protocol=protocol).status == "aborted"
    finally:
        sys.settrace(None)
    assert [row["frames"] for row in rows(tmp_path, "trials")] == ["0"]
    go(tmp_path, protocol=protocol, resume=True)
    assert told(tmp_path / "S") == []


def drop_last(file: Path, count: int) -> None:
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    file.write_text("".join(lines[:-count]), encoding="utf-8")


@pytest.mark.parametrize("killed", [True, False])
def test_gaze_without_its_frames_is_allowed_at_the_end_of_a_killed_run_alone(
    tmp_path: Path, killed: bool
) -> None:
    session = interrupted(tmp_path, killed=killed, headset=SeesEyes)
    drop_last(session / "frames.csv", 7)  # 0.7 s
    before = sealed(tmp_path / "S")
    assert any("frames.csv has no row of this time" in each for each in before) != killed
    go(tmp_path, resume=True, headset_for=lambda *_: SeesEyes())
    found = [each for each in told(tmp_path / "S") if "gaze.csv" in each]
    words = f"{SESSION}/gaze.csv, line 20: frames.csv has no row of this time"
    assert [each[: len(words)] for each in found] == ([] if killed else [words])


def test_not_more_frames_may_be_missing_than_wait_for_the_disk(tmp_path: Path) -> None:
    session = interrupted(tmp_path, killed=True, headset=SeesEyes)
    drop_last(session / "frames.csv", 14)  # 1.4 s
    go(tmp_path, resume=True, headset_for=lambda *_: SeesEyes())
    assert any("frames.csv has no row of this time" in each for each in told(tmp_path / "S"))


def test_time_goes_on_after_rows_whose_frames_are_missing(tmp_path: Path) -> None:
    session = interrupted(tmp_path, killed=True, headset=SeesEyes)
    last_ns = int(rows(tmp_path, "gaze")[-1]["xr_time_ns"])
    drop_last(session / "frames.csv", 7)
    go(tmp_path, resume=True, headset_for=lambda *_: SeesEyes())
    first = next(row for row in rows(tmp_path, "frames") if row["resumed"] == "1")
    assert int(first["xr_time_ns"]) > last_ns


def test_only_the_attempt_that_lacks_a_frame_is_named(tmp_path: Path) -> None:
    go(tmp_path, interrupt=(1, 25))
    go(tmp_path, resume=True)
    file = tmp_path / "S" / SESSION / "frames.csv"
    lines = file.read_text().splitlines(keepends=True)
    file.write_text("".join(lines[:15] + lines[16:]))
    (fault,) = sealed(tmp_path / "S")
    words = f"{SESSION}/trials.csv, line 2: trial 1, attempt 1 had 15 frames, and frames.csv has 14"
    assert fault.startswith(words)


def test_times_are_compared_as_far_as_they_are_recorded(tmp_path: Path) -> None:
    session = interrupted(tmp_path, killed=False, headset=SeesEyes)
    (trial,) = rows(tmp_path, "trials")
    start_s = float(trial["start_s"])
    rounded = {
        "trials.csv": ("end_s", 2, repr(start_s - 7e-15)),
        "gaze.csv": ("session_s", 12, repr(start_s + 7e-15)),
    }
    cell(session / "frames.csv", 12, "session_s", trial["start_s"])
    kept = (session / "frames.csv").read_text().splitlines(keepends=True)[:12]
    (session / "frames.csv").write_text("".join(kept))
    kept = (session / "gaze.csv").read_text().splitlines(keepends=True)[:12]
    (session / "gaze.csv").write_text("".join(kept))
    for name, (column, line, value) in rounded.items():
        cell(session / name, line, column, value)
    for name in ("trials.csv", "timing.csv"):
        cell(session / name, 2, "frames", "1")
    cell(session / "trials.csv", 2, "live_s", "0.1")
    assert [each for each in sealed(tmp_path / "S") if "events" not in each] == []
    cell(session / "gaze.csv", 12, "session_s", repr(start_s + 2e-6))
    assert any(
        "gaze.csv, line 12: frames.csv has no row" in each for each in sealed(tmp_path / "S")
    )


def test_an_answer_that_was_corrected_when_the_program_was_killed_is_whole(tmp_path: Path) -> None:
    """The row has the new answer, and the event of it was not written any more."""
    go(tmp_path, Scripted(interrupt_at_item="fatigue"))
    file = tmp_path / "S" / SESSION / "questionnaires.csv"
    line = file.read_text().count("\n")
    answered_s = float(rows(tmp_path, "questionnaires")[-1]["answered_s"])
    for column, value in (("response", "3"), ("answered_s", str(answered_s + 2))):
        cell(file, line, column, value)
    go(tmp_path, resume=True)
    assert told(tmp_path / "S") == []


def test_a_machine_that_was_started_again_between_two_runs_has_no_wrong_clock(tmp_path) -> None:
    for stop in ((1, 25), (1, 35), None):
        go(tmp_path, interrupt=stop, resume=stop != (1, 25))
    starts = [float(row["onset_s"]) for row in rows(tmp_path, "events")
              if row["name"] == "session_resumed"]  # fmt: skip
    clocks = [
        ClockRow(0.5, None, 9_000, 0, None, 1),
        ClockRow(starts[0] + 0.5, None, 8_000, 0, None, 1, resumed=1),
        ClockRow(starts[1] + 0.5, None, 100, 0, None, 1, resumed=1),
        ClockRow(starts[1] + 0.6, None, 200, 0, None, 1, resumed=1),
    ]
    file = tmp_path / "S" / SESSION / ClockRow.FILE
    lines = [csv_line(map(cell_text, row.cells())) for row in clocks]
    file.write_text(csv_line(ClockRow.columns()) + "".join(lines))
    assert sealed(tmp_path / "S") == []
    cell(file, 5, "monotonic_ns", "50")
    (fault,) = sealed(tmp_path / "S")
    assert "clocks.csv, line 5: monotonic_ns 50 is before 100" in fault


def test_a_participant_whose_program_was_killed_at_the_very_end_is_completed(tmp_path) -> None:
    go(tmp_path, sessions=[1, 2])
    study = tmp_path / "S"
    people = study / "participants.csv"
    people.write_text(people.read_text().replace("completed", "enrolled"))
    assert any("write completed" in each for each in told(study))
    (study / "sub-P01/ses-2/checksums.sha256").unlink()
    assert told(study) == []
    assert any("killed before" in str(each) for each in verify_study(study).notes)
    with pytest.raises(ValueError, match="all 2 sessions of P01 are recorded"):
        go(tmp_path, resume=True, sessions=None)
    assert "completed" in people.read_text()
