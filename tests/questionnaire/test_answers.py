"""An answer is on the disk before the next is asked, and a correction takes its place."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.report import build_report
from tests.support.resume import go, rows
from tests.support.study import Scripted
from tests.support.waiting import WAIT_S
from vrcomfort.errors import InputError
from vrcomfort.records import QuestionnaireRow, Recorder
from vrcomfort.respondent import Form, Heard

KILLED = """
import os, signal, sys
from pathlib import Path
sys.path[:0] = sys.argv[2:]
from tests.support.resume import go
from tests.support.study import Scripted

class Dies(Scripted):
    def ask(self, form, heard):
        def hear(item, *answer):
            heard(item, *answer)
            if form.timepoint == "post" and item == "eyestrain":
                os.kill(os.getpid(), signal.SIGKILL)
        super().ask(form, hear)

go(Path(sys.argv[1]), Dies())
"""


class Corrects(Scripted):
    """Goes back to the second and the first item at the end of each questionnaire."""

    def ask(self, form: Form, heard: Heard) -> None:
        super().ask(form, heard)
        heard("fatigue", 3, 1.0)
        heard("general_discomfort", None, 1.0)
        heard("fatigue", 2, 1.0)


@pytest.mark.slow
def test_a_program_killed_at_a_question_has_kept_every_answer(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(tmp_path), *sys.path], timeout=WAIT_S, check=False
    )
    assert done.returncode == -signal.SIGKILL
    kept = [(row["timepoint"], row["item"]) for row in rows(tmp_path, "questionnaires")[16:]]
    assert kept == [
        ("post", item) for item in ("general_discomfort", "fatigue", "headache", "eyestrain")
    ]
    assert go(tmp_path, resume=True).sessions == (1,)
    asked = rows(tmp_path, "questionnaires")
    assert [row["resumed"] for row in asked[15:21]] == ["0"] * 5 + ["1"]
    again = [row["timepoint"] for row in asked[20:]]
    assert again == ["post"] * 12 + ["baseline"] * 16 + ["post"] * 16 + ["recovery"] * 16
    build_report(tmp_path / "S", out=tmp_path / "report")


def test_a_correction_takes_the_place_of_the_answer(tmp_path: Path) -> None:
    go(tmp_path, Corrects())
    asked = rows(tmp_path, "questionnaires")
    for start in range(0, len(asked), 16):
        sheet = asked[start : start + 16]
        assert [row["order"] for row in sheet] == [str(n) for n in range(1, 17)]
        assert [row["response"] for row in sheet] == ["", "2", *"11111111111111"]
        assert float(sheet[1]["answered_s"]) == float(sheet[15]["answered_s"]) + 3
    said = [row["detail"] for row in rows(tmp_path, "events") if row["name"] == "answer"]
    assert said[16:19] == [
        "baseline ssq fatigue: 3",
        "baseline ssq general_discomfort: rather not say",
        "baseline ssq fatigue: 2",
    ]


def answered(item: str, response: int) -> QuestionnaireRow:
    return QuestionnaireRow(
        "P01", 1, None, None, None, None, "baseline", "ssq", item, response, 0.0, 1.0, 1
    )


def test_a_correction_in_a_resumed_session_leaves_the_row_before_alone(tmp_path: Path) -> None:
    with Recorder(tmp_path, "P01", 1) as recorder:
        recorder.write(answered("nausea", 1))
    with Recorder(tmp_path, "P01", 1, resumed=True) as recorder:
        recorder.write(answered("nausea", 1), answered("vertigo", 1))
        recorder.replace(answered("nausea", 1), answered("nausea", 3))
        recorder.write(answered("burping", 0))
    lines = (recorder.folder / "questionnaires.csv").read_text().splitlines()[1:]
    ends = [line.split(",", 8)[8] for line in lines]
    assert ends == [
        "nausea,1,0.0,1.0,1,,0",
        "nausea,3,0.0,1.0,1,,1",
        "vertigo,1,0.0,1.0,1,,1",
        "burping,0,0.0,1.0,1,,1",
    ]


def test_a_disk_that_refuses_a_correction_keeps_the_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    with Recorder(tmp_path, "P01", 1) as recorder:
        recorder.write(answered("nausea", 1))
        monkeypatch.setattr("os.fsync", full)
        with pytest.raises(InputError, match=r"questionnaires.csv: cannot write: No space left"):
            recorder.replace(answered("nausea", 1), answered("nausea", 3))
        monkeypatch.undo()
        recorder.write(answered("vertigo", 2))
    lines = (recorder.folder / "questionnaires.csv").read_text().splitlines()[1:]
    assert [line.split(",")[8:10] for line in lines] == [["nausea", "1"], ["vertigo", "2"]]
