"""Sessions that something interrupts, and what continues them."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pytest

from tests.support import resume
from tests.support.places import ROOT
from tests.support.report import build_report
from tests.support.resume import attempts, folder, manifest, rows
from tests.support.study import PROTOCOL, AheadHeadset, Scripted, read_rows, tiny_protocol
from tests.support.waiting import WAIT_S
from vrcomfort.errors import InputError, RuntimeLostError
from vrcomfort.records import Recorder
from vrcomfort.respondent import Form, Heard, SimulatedRespondent
from vrcomfort.traces.trace import read_trace

go = partial(resume.go, exposure_s=1.0)
"""Ten frames an exposure, and one of training."""

FILES = ("trials", "timing", "questionnaires", "ratings", "frames", "events")


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    folder = tmp_path_factory.mktemp("interrupted")
    assert go(folder, interrupt=(2, 3)).status == "aborted"
    return folder


@pytest.fixture
def interrupted(once, tmp_path):
    """The session was interrupted in the second exposure, in its third frame."""
    shutil.copytree(once, tmp_path, dirs_exist_ok=True)


@pytest.mark.usefixtures("interrupted")
def test_an_interrupted_session_goes_on_at_the_next_exposure(tmp_path):
    before = {name: len(rows(tmp_path, name)) for name in FILES}
    end_s = float(rows(tmp_path, "trials")[-1]["end_s"])
    assert go(tmp_path, resume=True).sessions == (1,)
    assert attempts(tmp_path) == [
        ("1", "1", "0", "completed", ""),
        ("2", "1", "0", "aborted", "operator"),
        ("2", "2", "1", "completed", ""),
    ]
    asked = [(r["timepoint"], r["trial"], r["resumed"]) for r in rows(tmp_path, "questionnaires")]
    assert asked[::16] == [
        ("baseline", "", "0"),
        ("post", "1", "0"),
        ("baseline", "", "1"),
        ("post", "2", "1"),
        ("recovery", "", "1"),
    ]
    for name in FILES:
        flags = [row["resumed"] for row in rows(tmp_path, name)]
        later = len(flags) - before[name]
        assert later > 0
        assert flags == ["0"] * before[name] + ["1"] * later
    again = rows(tmp_path, "questionnaires")[32]
    assert float(again["asked_s"]) == end_s


@pytest.mark.usefixtures("interrupted")
def test_a_continued_session_is_one_trace_and_keeps_the_facts_of_all_runs(tmp_path):
    go(tmp_path, interrupt=(1, 2), resume=True)
    assert go(tmp_path, resume=True).status == "enrolled"
    assert [row[1:4] for row in attempts(tmp_path)] == [
        ("1", "0", "completed"),
        ("1", "0", "aborted"),
        ("2", "1", "aborted"),
        ("3", "1", "completed"),
    ]
    frames = rows(tmp_path, "frames")
    times = [int(row["xr_time_ns"]) for row in frames]
    assert times == sorted(set(times))
    seconds = [float(row["session_s"]) for row in frames]
    assert seconds == sorted(seconds)
    assert len(read_trace(folder(tmp_path) / "frames.csv").time_ns) == 1 + 10 + 3 + 2 + 10
    content = manifest(tmp_path)
    assert [each["status"] for each in content["earlier_runs"]] == ["aborted", "aborted"]
    assert {each["headset"]["name"] for each in content["earlier_runs"]} == {"ahead"}
    assert (content["status"], content["memory"], content["under_way"]) == ("completed", None, None)


@pytest.mark.usefixtures("interrupted")
def test_an_unfinished_session_is_refused_with_the_way_out(tmp_path):
    for sessions in ([1], None):
        with pytest.raises(InputError, match=r"session 1 of P01 was interrupted.*run --resume"):
            go(tmp_path, sessions=sessions)
    assert len(attempts(tmp_path)) == 2


def test_there_must_be_something_to_resume(tmp_path):
    with pytest.raises(InputError, match="leave --resume out"):
        go(tmp_path, resume=True)
    go(tmp_path)
    with pytest.raises(InputError, match="leave --resume out"):
        go(tmp_path, resume=True)


def test_all_sessions_that_are_left_follow_the_resumed_one(tmp_path):
    go(tmp_path, interrupt=(1, 3))
    outcome = go(tmp_path, sessions=None, resume=True)
    assert (outcome.status, outcome.sessions) == ("completed", (1, 2))


def test_an_exposure_that_was_completed_is_not_shown_again(tmp_path):
    go(tmp_path, Scripted(interrupt_at_item="nausea"))
    go(tmp_path, resume=True)
    assert [row[:3] for row in attempts(tmp_path)] == [("1", "1", "0"), ("2", "1", "1")]


def test_after_the_last_exposure_only_the_end_is_asked(tmp_path):
    @dataclass
    class LeavesAtTheEnd(Scripted):
        def rest(self, _duration_s: float) -> None:
            raise KeyboardInterrupt

    go(tmp_path, LeavesAtTheEnd())
    go(tmp_path, resume=True)
    asked = [(r["timepoint"], r["resumed"]) for r in rows(tmp_path, "questionnaires")][::16]
    assert asked == [("baseline", "0"), ("post", "0"), ("post", "0"), ("recovery", "1")]


def test_a_runtime_that_goes_away_is_a_reason_of_its_own(tmp_path):
    class Leaves(AheadHeadset):
        def frames(self):
            yield from AheadHeadset(frames_left=8).frames()
            raise RuntimeLostError("the runtime stopped")

    with pytest.raises(RuntimeLostError):
        go(tmp_path, headset_for=lambda *_: Leaves())
    assert attempts(tmp_path) == [("1", "1", "0", "aborted", "runtime_lost")]
    assert len(rows(tmp_path, "frames")) == 8
    go(tmp_path, resume=True)
    assert attempts(tmp_path)[1:] == [
        ("1", "2", "1", "completed", ""),
        ("2", "1", "1", "completed", ""),
    ]


KILL = """
import os, signal, sys, time
sys.path[:0] = {paths}
from pathlib import Path
from tests.support import resume as tests

class Killed(tests.AheadHeadset):
    def frames(self):
        yield from tests.AheadHeadset(frames_left=60).frames()
        while written() < 57:  # frames of a headset come slower than rows are written
            time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGKILL)

def written():
    whole = (tests.folder(Path({folder!r})) / "frames.csv").read_text().rpartition("\\n")[0]
    return sum(line.split(",")[3] == "2" for line in whole.splitlines())

begun = []
def headset_for(*_):
    begun.append(1)
    return Killed() if len(begun) == 2 else tests.AheadHeadset()

tests.go(Path({folder!r}), headset_for=headset_for)
"""


@pytest.mark.slow
def test_a_killed_program_loses_nothing_but_its_last_rows(tmp_path):
    root = ROOT
    script = KILL.format(paths=[str(root)], folder=str(tmp_path))
    done = subprocess.run([sys.executable, "-c", script], check=False, timeout=WAIT_S)
    assert done.returncode == -signal.SIGKILL
    assert attempts(tmp_path) == [("1", "1", "0", "completed", "")]
    kept = sum(row["trial"] == "2" for row in rows(tmp_path, "frames"))
    assert kept == 57  # the focus of three had not come
    outcome = resume.go(tmp_path, resume=True)
    assert outcome.warnings == ()
    assert attempts(tmp_path)[1:] == [
        ("2", "1", "0", "aborted", "killed"),
        ("2", "2", "1", "completed", ""),
    ]
    assert rows(tmp_path, "trials")[1]["frames"] == str(kept)
    (earlier,) = manifest(tmp_path)["earlier_runs"]
    assert (earlier["status"], earlier["finished_at"]) == ("killed", None)


@pytest.mark.parametrize("tail", [b"1,2,3\n", b"\xc3"])
@pytest.mark.usefixtures("interrupted")
def test_a_half_written_row_is_told_and_kept_beside(tmp_path, tail):
    file = folder(tmp_path) / "frames.csv"
    whole = file.read_bytes()
    file.write_bytes(whole + tail)
    outcome = go(tmp_path, resume=True)
    (warning,) = outcome.warnings
    line = whole.count(b"\n") + 1
    assert f"frames.csv, line {line}: a half-written row" in warning
    assert file.read_bytes().startswith(whole)
    assert file.with_name("frames.csv.cut").read_bytes() == tail.rstrip(b"\n") + b"\n"
    assert "row_cut_off" in {row["name"] for row in rows(tmp_path, "events")}


def test_files_that_were_not_even_begun_are_begun(tmp_path):
    go(tmp_path, interrupt=(1, 3))
    (folder(tmp_path) / "ratings.csv").write_bytes(b"particip")
    (folder(tmp_path) / "timing.csv").unlink()
    go(tmp_path, resume=True)
    assert len(rows(tmp_path, "ratings")) == 4
    assert len(rows(tmp_path, "timing")) == 2


@pytest.mark.usefixtures("interrupted")
def test_a_row_broken_in_the_middle_is_left_to_people(tmp_path):
    file = folder(tmp_path) / "events.csv"
    lines = file.read_bytes().splitlines(keepends=True)
    broken = b"".join([*lines[:2], b"1,2\n", *lines[3:]])
    file.write_bytes(broken)
    with pytest.raises(InputError, match="broken") as caught:
        go(tmp_path, resume=True)
    assert caught.value.line == 3
    assert file.read_bytes() == broken


def test_a_continuation_is_of_the_same_session(tmp_path):
    go(tmp_path, interrupt=(2, 3), exposure_s=2.0)
    other = tiny_protocol(tmp_path, PROTOCOL + "\n# changed\n")
    for changed, says in (
        ({"protocol": other}, "another text of this protocol"),
        ({"seed": 3}, "begun with seed 0"),
        ({"exposure_s": 5.0}, "exposures of 2 s"),
        ({"respondent": simulated(tmp_path)}, "with --respondent scripted, not simulated"),
    ):
        with pytest.raises(InputError, match=says):
            go(tmp_path, resume=True, **{"exposure_s": None, **changed})
    go(tmp_path, resume=True, protocol=tiny_protocol(tmp_path), exposure_s=None)
    assert manifest(tmp_path)["exposure_s"] == 2.0


def simulated(tmp_path: Path) -> SimulatedRespondent:
    settings = tiny_protocol(tmp_path).simulation.model_copy(update={"rate_per_min": 2.0})
    return SimulatedRespondent(settings, participant="P01", seed=0)


def test_the_random_state_is_that_of_the_last_boundary(tmp_path):
    somebody = simulated(tmp_path)
    somebody.start_session(1)
    go(tmp_path, somebody, interrupt=(2, 3))
    memory = manifest(tmp_path)["memory"]
    assert memory["sickness"] > 0
    for copy in ("A", "B"):
        shutil.copytree(tmp_path / "S", tmp_path / copy)
        go(tmp_path, simulated(tmp_path), resume=True, study=copy)
    for name in FILES:
        one, two = (folder(tmp_path, copy) / f"{name}.csv" for copy in ("A", "B"))
        assert one.read_bytes() == two.read_bytes()
    again = simulated(tmp_path)
    again.start_session(1)
    fresh = again.memory()
    again.recall(memory)
    assert again.memory() == memory != fresh


@dataclass
class Answers(Scripted):
    """Gives one answer everywhere before an exposure, and another after it."""

    before: int = 0
    after: int = 1

    def ask(self, form: Form, heard: Heard) -> None:
        for item in form.instrument.items:
            heard(item.name, self.before if form.timepoint == "baseline" else self.after, 2.0)


def test_the_report_takes_the_last_attempt_and_the_baseline_of_its_run(tmp_path):
    go(tmp_path, Answers(before=0, after=1), interrupt=(2, 3))
    go(tmp_path, Answers(before=2, after=3), interrupt=(1, 3), resume=True)
    go(tmp_path, Answers(before=1, after=3), resume=True)
    build_report(tmp_path / "S", out=tmp_path / "R")
    scores = read_rows(tmp_path / "R" / "tables" / "scores.csv")
    plain, blur = (float(row["T"]) for row in scores)
    assert plain > 0
    assert blur == pytest.approx(2 * plain)
    quality = json.loads((tmp_path / "R" / "results.json").read_text())["quality"]
    assert quality["frames"]["shown"] == 20


def test_a_session_that_recorded_nothing_is_begun_again(tmp_path):
    """As a program leaves it that is killed, or finds the disk full, before the manifest."""
    Recorder(tmp_path / "S", "P01", 1).close()
    (folder(tmp_path) / ".manifest.json.new").write_text("{", encoding="utf-8")
    trials = folder(tmp_path) / "trials.csv"
    trials.write_text(trials.read_text()[:5])
    assert go(tmp_path).sessions == (1,)
    assert len(attempts(tmp_path)) == 2
    (folder(tmp_path) / "manifest.json").unlink()
    with pytest.raises(InputError, match="session 1 of P01 was interrupted"):
        go(tmp_path)


@pytest.mark.usefixtures("interrupted")
def test_a_number_that_is_none_is_left_to_people(tmp_path):
    file = folder(tmp_path) / "trials.csv"
    file.write_text(file.read_text().replace("P01,1,1,1,1,", "P01,1,1,1,one,"))
    with pytest.raises(InputError, match="'one' is not a number; mend it first") as caught:
        go(tmp_path, resume=True)
    assert (caught.value.file, caught.value.line, caught.value.column) == (file, 2, "trial")


@pytest.mark.usefixtures("interrupted")
def test_a_damaged_manifest_is_left_to_people(tmp_path):
    file = folder(tmp_path) / "manifest.json"
    file.write_text('{"status": "aborted"}')
    with pytest.raises(InputError, match="this manifest is damaged; restore it") as caught:
        go(tmp_path, resume=True)
    assert caught.value.file == file
