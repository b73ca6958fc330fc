"""What is printed: data as it is, one sentence for each matter, progress where nobody watches."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console
from rich.table import Table

from tests.support.session import run
from tests.support.study import AheadHeadset, LateFocus, Scripted
from tests.support.waiting import read_until_closed, wait_for
from vrcomfort.cli import main, terminal
from vrcomfort.protocol import load_protocol
from vrcomfort.questionnaire import Answers, Instrument, Item
from vrcomfort.resources import data_folder
from vrcomfort.respondent import Exposure, Form, TerminalRespondent

HOSTILE = "[/0.5 D] [bold]x[/bold] [link=https://a.b]y[/link] :smile:"
"""Closes what was not open, and opens what rich would take for a style."""


@pytest.fixture
def say(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Return what runs a command and gives (exit code, everything that it said)."""

    def call(*words: object, stdin: str = "") -> tuple[int, str]:
        monkeypatch.setattr("sys.argv", ["vrcomfort", *map(str, words)])
        monkeypatch.setattr("sys.stdin", StringIO(stdin))
        monkeypatch.setenv("COLUMNS", "400")
        code = 0
        try:
            main()
        except SystemExit as end:
            code = int(end.code or 0)
        out, err = capsys.readouterr()
        return code, out + err

    return call


@pytest.fixture
def protocol(tmp_path: Path) -> Path:
    """Return a protocol whose labels look like markup."""
    text = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    text = text.replace('title = "Every', f'title = "{HOSTILE} Every')
    text = text.replace('label = "No blur"', f'label = "{HOSTILE}"')
    file = tmp_path / "[bold] smoke.toml"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.slow
def test_labels_in_brackets_are_shown_as_they_are(say, protocol: Path, tmp_path: Path) -> None:
    code, said = say("passes", protocol, "--size", "16x16")
    assert code == 0
    assert HOSTILE in said
    assert say("design", protocol, "-n", 2)[0] == 0
    folder = tmp_path / "[/0.5 D]"
    code, said = say("simulate", protocol, "-n", 1, "--size", "16x16", "--out", folder)
    assert code == 0
    assert str(folder / "sub-P01") in said
    code, said = say("report", folder, "--figures", "none", "--out", tmp_path / "[link=x] report")
    assert code == 0
    assert "[link=x] report" in said


@pytest.mark.slow
def test_a_session_in_the_terminal_shows_brackets(say, protocol: Path, tmp_path: Path) -> None:
    words = ("--participant", "P01", "--size", "16x16", "--out", tmp_path / "[/x]")
    stdin = "\n".join(["0"] * 16 + [""]) + "\n"
    code, said = say("run", protocol, *words, stdin=stdin * 5)
    assert code == 0
    assert str(tmp_path / "[/x]") in said


def test_questions_in_brackets_are_asked_as_they_are() -> None:
    answers = Answers(0, 2, labels=("[/none]", "b", "[c]"))
    item = Item("a", f"{HOSTILE} item", answers)
    scale = Instrument("x", "X", HOSTILE, f"{HOSTILE} now", (item,), answers, (), "a")
    shown, lines = StringIO(), iter(["1", ""])
    console = Console(file=shown, width=300, markup=False, emoji=False)
    person = TerminalRespondent(console, read_line=lambda _: next(lines), waiting_line=lambda: None)
    person.start_exposure(Exposure(1, 1, "[/room]", "c", 1.0))
    person.prompt(scale, 0.0, 1.0)
    person.ask(Form(scale, "[/post]"), lambda *_: None)
    for text in (HOSTILE, "[/none]", "[/room]", "[/post]", f"{HOSTILE} item"):
        assert text in shown.getvalue()


def test_names_in_brackets_in_a_refusal_are_shown_as_they_are(say, tmp_path: Path) -> None:
    file = tmp_path / "[bold].csv"
    file.write_text("[bold]\n1\n", encoding="utf-8")
    code, said = say("score", "ssq", file)
    assert code == 2
    assert f"error: {file}, line 1: no column" in said
    assert say("run", "[openxr]", "--participant", "P01", "--out", tmp_path / "s")[1].startswith(
        "error: "
    )


@pytest.mark.slow
def test_a_mixed_study_says_so_at_once(say, tmp_path: Path) -> None:
    study = tmp_path / "study"
    run(
        load_protocol("smoke"),
        "P01",
        study=study,
        respondent=Scripted(name="terminal"),
        load_scene=lambda source: source,
        headset_for=lambda *_: AheadHeadset(),
        renderer=LateFocus(),
    )
    words = ("run", "smoke", "--size", "16x16", "--respondent", "simulated", "--out", study)
    _, said = say(*words, "--participant", "P02")
    assert "note: this study has real participants (P01) and gets simulated ones now" in said
    _, said = say(*words, "--participant", "P03")
    first, *others = [line for line in said.splitlines() if line.startswith("note:")]
    assert first.startswith("note: this study has real participants (P01)")
    assert all(other.startswith("note: sessions differ in the ") for other in others)


def test_the_time_left_is_that_of_the_pace_so_far() -> None:
    assert terminal.time_left(10, 1, 4) == ", about 30 s left"
    assert terminal.time_left(60, 1, 11) == ", about 10 min left"
    for passed_s, done, total in ((10, 0, 4), (10, 4, 4), (10, 1, None), (0.1, 3, 4)):
        assert terminal.time_left(passed_s, done, total) == ""


def test_work_in_a_pipe_says_now_and_then_how_far_it_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(terminal, "SILENT_S", 0.05)
    monkeypatch.setattr(terminal, "LINE_EVERY_S", 3600.0)
    with terminal.progress_bar("drawn", 4, quiet=False, unit="frames") as advance:
        advance(3)
        said = wait_for(lambda: capsys.readouterr().err)
    assert said == "drawn: 3 of 4 frames ...\n"


def test_quick_and_quiet_work_says_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with terminal.progress_bar("drawn", 4, quiet=False) as advance:
        advance()
    monkeypatch.setattr(terminal, "SILENT_S", 0.0)
    with terminal.progress_bar("drawn", 4, quiet=True) as advance:
        advance()
    assert capsys.readouterr().err == ""


PROMPT_BESIDE_A_BAR = """
from vrcomfort.cli.terminal import dialogue, progress_bar
with progress_bar("exposure 1", 60, quiet=False, unit="s") as advance:
    advance(5)
    dialogue().print("[/0.5 D] How sick? (10 s)", style="bold")
    advance(1)
"""


def test_a_prompt_beside_a_bar_stands_on_a_line_of_its_own() -> None:
    ours, theirs = pty.openpty()
    command = [sys.executable, "-c", PROMPT_BESIDE_A_BAR]
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "100"}
    with subprocess.Popen(command, stdout=theirs, stderr=theirs, env=environment) as shown:
        os.close(theirs)
        text = read_until_closed(ours).decode()
    os.close(ours)
    assert shown.returncode == 0, text
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text)
    lines = [line for line in re.split(r"[\r\n]+", plain) if "How sick" in line]
    assert [line.strip() for line in lines] == ["[/0.5 D] How sick? (10 s)"]
    assert "exposure 1: 6 of 60 s" in plain


def test_tables_in_a_pipe_break_no_words(monkeypatch, capsys):
    monkeypatch.delenv("COLUMNS", raising=False)
    words = [f"rotation_cancelled_and_faded_{number}" for number in range(12)]
    table = Table(*words)
    for word in words:
        table.add_row(word, "what it is, in a sentence that would be wrapped in a window" * 2)
    terminal.console(wrap=True).print(table)
    printed = capsys.readouterr().out
    assert all(printed.count(f" {word} ") == 2 for word in words)
    assert len(printed.splitlines()) == 4 + len(words)


def test_tables_fit_into_a_window_whose_width_is_known(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "60")
    table = Table("a", "b")
    table.add_row("words " * 20, "more " * 20)
    terminal.console(wrap=True).print(table)
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 60
