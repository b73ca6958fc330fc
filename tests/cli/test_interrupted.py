"""Ctrl-C, SIGTERM and a closed terminal, as they come to commands that are at work."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import shlex
import signal
import subprocess
import sys
import termios
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from tests.support.signals import hear_all
from tests.support.waiting import WAIT_S, wait_for
from vrcomfort.cli import stopping
from vrcomfort.cli.options import typed_words

SENTENCE = "error: stopped; what was already written stays\n"


def start(*program: object, before: Callable[[], None] = hear_all) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, *map(str, program)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=before,  # noqa: PLW1509 - no threads here
    )


MAIN = "from vrcomfort.cli import main; main()"
HELD = f"""
import time
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.records import Recorder, TrialRow

write, frames, done = Recorder.write, PlaybackHeadset.frames, []

def write_and_see(recorder, *rows):
    write(recorder, *rows)
    done.extend(row for row in rows if isinstance(row, TrialRow))

def frames_until_a_trial_is_done(headset):
    for frame in frames(headset):
        while done:
            time.sleep(0.05)
        yield frame

Recorder.write, PlaybackHeadset.frames = write_and_see, frames_until_a_trial_is_done
{MAIN}
"""
"""The command, whose second exposure never ends: a signal comes into it, however late."""


READING = f"""
import sys, time
from pathlib import Path

file = Path(sys.argv.pop(1))

def hold(event, arguments):
    if event == "open" and str(arguments[0]) == str(file):
        file.with_name("opened").touch()
        while True:  # a signal before a long sleep would be heard after it
            time.sleep(0.05)

sys.addaudithook(hold)
{MAIN}
"""
"""The command, which never gets further than to open a file: a signal comes while it reads."""


def command(*words: object) -> subprocess.Popen[str]:
    return start("-c", MAIN, *words)


def held_in_the_second_exposure(session: Path, *words: object) -> subprocess.Popen[str]:
    process = start("-c", HELD, *words)
    wait_for_lines(session / "trials.csv", process, 2)
    return process


def stop(process: subprocess.Popen[str], *numbers: int) -> tuple[int, str, str]:
    """Send Ctrl-C, or other signals at once, to the whole group, as a terminal does."""
    os.killpg(process.pid, signal.SIGSTOP)
    for number in numbers or (signal.SIGINT,):
        os.killpg(process.pid, number)
    os.killpg(process.pid, signal.SIGCONT)
    out, err = process.communicate(timeout=WAIT_S)
    return process.returncode, out, err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("questionnaires.csv", ("report", "FOLDER", "--quiet", "--out", "OUT")),
        (
            "trace.csv",
            ("play", "FILE", "--scene", "temple", "--quiet", "--size", "64x80", "--out", "OUT"),
        ),
        ("answers.csv", ("score", "ssq", "FILE")),
    ],
    ids=["report", "play", "score"],
)
def test_ctrl_c_is_answered_in_one_sentence(tmp_path: Path, name: str, words: tuple[str, ...]):
    file = tmp_path / "in" / name
    file.parent.mkdir()
    file.write_text("participant\n", encoding="utf-8")
    places = {"FOLDER": file.parent, "FILE": file, "OUT": tmp_path / "out"}
    process = start("-c", READING, file, *(places.get(word, word) for word in words))
    wait_for_lines(file.with_name("opened"), process, 0)
    assert stop(process) == (130, "", SENTENCE)


@pytest.mark.slow
@pytest.mark.smoke
def test_ctrl_c_in_a_session_is_answered_after_the_session(tmp_path: Path):
    study = tmp_path / "study"
    words = ("simulate", "smoke", "-n", 1, "--size", "16x16", "--out", study)
    process = held_in_the_second_exposure(study / "sub-P01" / "ses-1", *words)
    code, out, err = stop(process)
    assert code == 130
    assert "aborted (stopped by the operator)" in out
    assert err.endswith(f"note: the same command goes on where this was stopped\n{SENTENCE}")


@pytest.mark.slow
def test_a_shutdown_that_comes_while_something_is_deleted_is_heard_after_it(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(stopping, "_last", stopping._last)  # other tests of the process ask for it

    class Deleted:
        def __del__(self):
            os.kill(os.getpid(), signal.SIGTERM)

    def run():
        Deleted()
        while True:
            pass

    with pytest.raises(KeyboardInterrupt), stopping.heard():
        run()
    assert stopping.exit_code() == 128 + signal.SIGTERM


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_shutdown_and_a_closed_terminal_end_a_session_as_ctrl_c_does(
    tmp_path: Path, number: signal.Signals
):
    study = tmp_path / "study"
    words = ("simulate", "smoke", "-n", 1, "--size", "16x16", "--out", study)
    process = held_in_the_second_exposure(study / "sub-P01" / "ses-1", *words)
    code, out, err = stop(process, number)
    assert code == 128 + number
    assert "aborted (stopped by the operator)" in out
    assert err.endswith(SENTENCE)
    manifest = json.loads((study / "sub-P01" / "ses-1" / "manifest.json").read_text())
    assert manifest["status"] == "aborted"


@pytest.mark.slow
def test_sigterm_and_sighup_of_one_shutdown_are_one_wish(tmp_path: Path):
    study = tmp_path / "study"
    words = ("simulate", "smoke", "-n", 1, "--size", "16x16", "--out", study)
    process = held_in_the_second_exposure(study / "sub-P01" / "ses-1", *words)
    code, _, err = stop(process, signal.SIGTERM, signal.SIGHUP)
    assert code in {143, 129}
    assert err.endswith(SENTENCE)


@pytest.mark.slow
def test_a_session_whose_terminal_goes_away_is_closed(tmp_path: Path):
    """The window is shut: SIGHUP comes, and there is nothing left to write to."""
    study = tmp_path / "study"
    words = ("run", "smoke", "--participant", "P01", "--out", study, "--size", "16x16")
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", MAIN, *map(str, words)],
        stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
        preexec_fn=lambda: (hear_all(), fcntl.ioctl(0, termios.TIOCSCTTY, 0)),  # noqa: PLW1509
    )  # fmt: skip
    os.close(theirs)
    said = b""
    while b"General discomfort" not in said:
        said += os.read(ours, 4096)
    os.close(ours)
    assert process.wait(WAIT_S) == 129
    manifest = json.loads((study / "sub-P01" / "ses-1" / "manifest.json").read_text())
    assert manifest["status"] == "aborted"


SHUT = """
import signal, sys
from vrcomfort.cli import app, stopping

def command(**_):
    sys.stdin.read()
    try:
        with stopping.heard():
            signal.raise_signal(signal.SIGHUP)
    finally:
        print("Withdrawn? ", end="")

app.app = command
app.main()
"""
"""Asks something when its terminal has gone away, which it has when its input ends."""


def test_what_a_closed_terminal_does_not_show_leaves_the_exit_code_alone():
    ours, theirs = pty.openpty()
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    process = subprocess.Popen(
        [sys.executable, "-c", SHUT],
        stdin=subprocess.PIPE, stdout=theirs, stderr=theirs, env=buffered,
        preexec_fn=hear_all,  # noqa: PLW1509 - no threads here
    )  # fmt: skip
    os.close(theirs)
    os.close(ours)
    process.stdin.close()
    assert process.wait(WAIT_S) == 129


@pytest.mark.slow
def test_what_is_ignored_from_the_start_stays_ignored(tmp_path: Path):
    """As with nohup, or in the background of a shell."""

    def ignore() -> None:
        hear_all()
        for number in (signal.SIGINT, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)

    words = ("simulate", "smoke", "-n", 1, "--size", "16x16", "--out", tmp_path / "study")
    process = start("-c", MAIN, *words, before=ignore)
    wait_for_lines(tmp_path / "study" / "sub-P01" / "ses-1" / "trials.csv", process, 2)
    code, out, _ = stop(process, signal.SIGINT, signal.SIGHUP)
    assert code == 0
    assert "completed" in out


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_run_says_which_words_go_on(tmp_path: Path, number: signal.Signals, code: int):
    study = tmp_path / "my study"
    words = ["run", "smoke", "--participant", "P01", "--out", str(study)]
    words += ["--respondent", "simulated", "--seed", "3", "--size", "16x16"]
    process = held_in_the_second_exposure(study / "sub-P01" / "ses-1", *words)
    status, _, err = stop(process, number)
    assert status == code
    told = shlex.split(err.partition("to go on, type: ")[2].splitlines()[0])
    assert told[:1] == ["vrcomfort"]
    assert told[-1] == "--resume"
    assert set(words) < set(told)
    goes_on = command(*told[1:])
    assert "P01 (s1): session 1 recorded, completed" in goes_on.communicate(timeout=WAIT_S)[0]


@pytest.mark.slow
def test_ctrl_c_in_a_trade_off_ends_its_processes_without_a_word_of_theirs(tmp_path: Path):
    folders = ("--cache", tmp_path / "cache", "--out", tmp_path / "out")
    process = command("tradeoff", "--quick", "--quiet", "--jobs", 2, *folders)
    wait_for_lines(tmp_path / "cache", process, 0)  # results of a first case
    assert stop(process) == (130, "", SENTENCE)


def test_processes_do_not_wait_for_their_work_after_ctrl_c(tmp_path: Path):
    file = tmp_path / "program.py"
    file.write_text(
        """
import time
from vrcomfort.workers import workers
if __name__ == "__main__":
    try:
        with workers(2, None) as work:
            for _ in work(time.sleep, [0.0, 3600.0, 3600.0]):
                print("working", flush=True)
    except KeyboardInterrupt:
        print("heard")
        raise SystemExit(130)
""",
        encoding="utf-8",
    )
    process = start(file)
    assert process.stdout is not None
    assert process.stdout.readline() == "working\n"
    assert stop(process) == (130, "heard\n", "")


@pytest.mark.parametrize("module", ["vrcomfort.cli.app", "pydantic", "vrcomfort.cli.design"])
def test_ctrl_c_while_modules_are_imported_ends_without_a_word(module: str) -> None:
    program = f"""
import os, signal, sys
class CtrlC:
    def find_spec(self, name, *_):
        if name == "{module}":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, CtrlC())
from vrcomfort.cli import main
from vrcomfort.resources import data_folder
sys.argv = ["vrcomfort", "design", "smoke", "-n", "2"]
main()
"""
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, check=False, capture_output=True, text=True, preexec_fn=hear_all)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def wait_for_lines(path: Path, process: subprocess.Popen[str], lines: int) -> None:
    """Wait until the command has made a file of so many lines, or a folder (0)."""

    def there() -> bool:
        ended = process.poll() is not None
        if path.exists() and (not lines or path.read_bytes().count(b"\n") >= lines):
            return True
        assert not ended, process.communicate()
        return False

    wait_for(there)


def test_each_covariate_is_typed_again_as_it_was():
    told = []
    program = typer.Typer()

    @program.command()
    def go(ctx: typer.Context, covariate: Annotated[list[str], typer.Option()]):
        del covariate
        told.append(shlex.split(typed_words(ctx))[1:])

    words = ["--covariate", "age=30", "--covariate", "hand=left one"]
    assert CliRunner().invoke(program, words).exit_code == 0
    assert told == [words]
