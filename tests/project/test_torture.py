"""`make torture` notices what it is made to notice: lost rows, tracebacks, hangs."""

from __future__ import annotations

import json
import os
import pkgutil
import sys
from collections import Counter
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import torture
from tests.support.waiting import WAIT_S
from torture import __main__ as command
from torture import inputs, shim, victim
from torture.case import HANG, OTHER, TRACEBACK, Outcome, Result, Rig
from torture.damaged import damage
from torture.mutate import worse
from torture.rows import PARTICIPANT, Rows, by_file, missing, session_folder
from torture.session import Ended, Findings, running_since
from torture.worker import workers
from vrcomfort.records import EventRow, QuestionnaireRow, RatingRow, Recorder


def test_each_torture_is_registered() -> None:
    modules = [each.name for each in pkgutil.iter_modules(torture.__path__)]
    made = {name for name in modules if hasattr(import_module(f"torture.{name}"), "torture")}
    assert made == set(command.TORTURES)


def answer(item: str, response: int = 1) -> QuestionnaireRow:
    return QuestionnaireRow(
        "P01", 1, None, None, None, None, "post", "ssq", item, response, 0.5, 1.25, 1
    )


@pytest.fixture
def recorder_put_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a test wrap the methods of recorders, as a victim does for the rest of its life."""
    for method in ("write", "write_soon", "replace"):
        monkeypatch.setattr(Recorder, method, getattr(Recorder, method))


def recorded(study: Path, *, forgetful: bool) -> Rows:
    """Record a few rows before an observer; return what it was told."""
    reading, writing = os.pipe()
    if forgetful:
        victim.forget()
    victim.observe(victim.Observer(writing), 0.0)
    with Recorder(study, PARTICIPANT, 1) as recorder:
        recorder.write(answer("nausea"), answer("sweating"))
        recorder.replace(answer("nausea"), answer("nausea", 2))
        for number in range(10):
            recorder.write_soon(EventRow(float(number), 0.0, "answer", 'a "quoted, word"'))
        recorder.write_soon(RatingRow("P01", 1, 1, "plain", 0.1, None, "fms", None, 1))
    os.close(writing)
    rows: Rows = Counter()
    with os.fdopen(reading) as lines:
        for word in map(json.loads, lines):
            key = word["file"], tuple(word["cells"].items())
            rows[key] += -1 if word["kind"] == "gone" else 1
    return +rows


def test_a_recorder_that_keeps_all_rows_has_lost_none(
    recorder_put_back: None, tmp_path: Path
) -> None:
    rows = recorded(tmp_path, forgetful=False)
    assert by_file(rows) == "10 of events.csv, 2 of questionnaires.csv, 1 of ratings.csv"
    assert not missing(rows, tmp_path)


def test_rows_that_a_recorder_forgets_are_counted_as_lost(
    recorder_put_back: None, tmp_path: Path
) -> None:
    found = Findings()
    found.rows("after the end", recorded(tmp_path, forgetful=True), tmp_path)
    outcome = found.outcome(name="forgetful", seed=0, folder=tmp_path)
    assert (outcome.handed, outcome.lost, outcome.happened) == (13, 2, "lost rows")
    assert outcome.detail == "after the end: lost 2 of events.csv"
    result = Result("signals", [Outcome("fine", 1), outcome], "")
    assert not result.passed
    assert result.row()["rows lost"] == 2


def test_a_row_cut_in_half_or_overwritten_with_zeros_is_lost(
    recorder_put_back: None, tmp_path: Path
) -> None:
    rows = recorded(tmp_path, forgetful=False)
    file = session_folder(tmp_path) / "events.csv"
    content = file.read_bytes()
    for damaged in (content[:-1], content[:-9] + bytes(9), content[:-9] + bytes(8) + b"\n"):
        file.write_bytes(damaged)
        assert missing(rows, tmp_path).total() == 1


@pytest.mark.parametrize(
    ("ended", "fault"),
    [
        (Ended(0, ""), ""),
        (Ended(2, "note: this\nerror: that; do this\n"), ""),
        (Ended(2, "note: this\n"), OTHER),
        (Ended(2, "error: this\nerror: that\n"), OTHER),
        (Ended(1, "error: this\n"), OTHER),
        (Ended(1, "Traceback (most recent call last):\n...\nKeyError: 'x'\n"), TRACEBACK),
        (Ended(None, "error: this\n"), HANG),
    ],
)
def test_the_end_of_a_command_is_judged(ended: Ended, fault: str) -> None:
    assert ended.fault({0, 2})[0] == fault


def test_time_in_which_the_machine_stood_still_does_not_count_as_time_to_write() -> None:
    cut_ns, beat_ns = 20 * 10**9, 20_000_000
    steady = [cut_ns - number * beat_ns for number in range(1, 100)]
    assert running_since(steady, cut_ns, 0.2) == cut_ns - 10 * beat_ns
    stood_still = [each for each in steady if each < cut_ns - 5 * beat_ns]
    hung = [cut_ns - beat_ns, *(each - 10**10 for each in stood_still)]
    assert running_since(hung, cut_ns, 0.2) < cut_ns - 10**10
    assert running_since([], cut_ns, 0.2) == 0


def test_workers_tell_tracebacks_hangs_and_ends_apart_and_go_on(tmp_path: Path) -> None:
    limits: dict[str, Any] = {"name": "case {}".format, "gigabytes": 3}
    cases = "tests.support.torture_cases"
    with (
        workers(cases, tmp_path, case_s=WAIT_S, **limits) as patient,
        workers(cases, tmp_path / "hangs", case_s=1.0, **limits) as hurried,
    ):
        found = [
            (hurried if number == 2 else patient).run(number, 7) for number in (0, 1, 2, 3, 4, 5, 0)
        ]
    assert [each.fault for each in found] == ["", TRACEBACK, HANG, OTHER, TRACEBACK, OTHER, ""]
    assert [found[index].name for index in (0, 1, 2, 5)] == [
        "fine 7 in worker", "falls", "case 2", "wrong",
    ]  # fmt: skip
    assert "KeyError: 'sickness'" in found[1].detail
    assert "MemoryError" in found[4].detail


def test_the_shim_forgets_what_was_not_synced(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("fsync", "fdatasync"):
        monkeypatch.setattr(os, name, getattr(os, name))  # to be put back
    study = tmp_path / "study"
    study.mkdir()
    shim.install(study, tmp_path / "disk")
    with (study / "a.csv").open("w") as synced, (study / "b.csv").open("w") as written:
        synced.write("one\n")
        written.write("two\n")
        synced.flush()
        written.flush()
        os.fsync(synced.fileno())
        synced.write("three\n")
        synced.flush()
        (study / "a.csv").rename(study / "c.csv")  # nothing is synced after it
        (study / "d.csv").touch()
    shim.remains(tmp_path / "disk", tmp_path / "after")
    left = {file.name: file.read_text() for file in (tmp_path / "after").iterdir()}
    assert left == {"a.csv": "one\n", "b.csv": ""}


@pytest.mark.parametrize("name", inputs.KINDS)
def test_what_is_made_worse_is_good_before(tmp_path: Path, name: str) -> None:
    kind = inputs.KINDS[name]
    for content in kind.good():
        for beside, other in kind.beside().items():
            (tmp_path / beside).write_bytes(other)
        file = tmp_path / kind.name
        file.write_bytes(content)
        kind.read(file)


def test_the_same_seed_makes_the_same_cases(tmp_path: Path) -> None:
    assert Rig(tmp_path, 3).seeds("inputs", 4) == Rig(tmp_path, 3).seeds("inputs", 9)[:4]
    assert Rig(tmp_path, 3).seeds("inputs", 4) != Rig(tmp_path, 4).seeds("inputs", 4)
    content = b"a,b\n1,2\n3,4\n"
    one, two = ([worse(content, ".csv", np.random.default_rng(5)) for _ in "12"] for _ in "12")
    assert one == two
    for folder in ("one", "two"):
        place = session_folder(tmp_path / folder)
        place.mkdir(parents=True)
        (place / "manifest.json").write_text('{"status": "running", "memory": {"a": 1}}')
        (place / "trials.csv").write_text("trial,status\n1,completed\n")
        damage(tmp_path / folder, 1000, np.random.default_rng(6))
    files = [sorted((tmp_path / name).rglob("*.*")) for name in ("one", "two")]
    assert [each.read_bytes() for each in files[0]] == [each.read_bytes() for each in files[1]]


@pytest.mark.parametrize(
    ("outcome", "code"),
    [(Outcome("a", 1, handed=5), 0), (Outcome("a", 1, handed=5, lost=1, detail="why"), 1),
     (Outcome("a", 1, fault=HANG), 1), (Outcome("a", 1, never_asked=4), 1)],
)  # fmt: skip
def test_the_exit_code_says_whether_anything_was_lost(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    outcome: Outcome,
    code: int,
) -> None:
    monkeypatch.setattr(
        command, "TORTURES", {"signals": lambda _: Result("signals", [outcome], "how")}
    )
    monkeypatch.setattr(command, "_prepare", lambda: None)
    monkeypatch.setattr(command, "_gpu", lambda: "a GPU")
    monkeypatch.setattr(sys, "argv", ["torture", "--out", str(tmp_path), "--only", "signals"])
    with pytest.raises(SystemExit) as ended:
        command.main()
    assert ended.value.code == code
    markdown = (tmp_path / "torture.md").read_text()
    assert f"| signals | 1 | {outcome.handed} | {outcome.lost} |" in markdown
    (written,) = json.loads((tmp_path / "torture.json").read_text())["tortures"]
    assert written["of"][0]["happened"] == outcome.happened
    assert ("signals: a (seed 1)" in capsys.readouterr().out) == bool(code)


def test_nothing_done_is_nothing_passed() -> None:
    assert not Result("runtime", [], "not installed").passed


def test_only_a_patient_torture_goes_on_after_its_limit(tmp_path: Path) -> None:
    for patient, count in ((False, 0), (True, 3)):
        rig = Rig(tmp_path, patient=patient)
        done = list(rig.all("name", 3, lambda number, seed: Outcome(str(number), seed), limit_s=0))
        assert len(done) == count
