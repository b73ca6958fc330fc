"""Ctrl-C, as the terminal sends it, to commands that are at work."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

SENTENCE = "error: stopped; what was already written stays\n"


def start(*program: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, *map(str, program)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


HEARS = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
"""For tests in the background, where a shell has Ctrl-C ignored."""


def command(*words: object) -> subprocess.Popen[str]:
    return start("-c", f"{HEARS}from vrcomfort.cli import main; main()", *words)


def stop(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    """Send Ctrl-C to the whole group, as a terminal does."""
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    return process.returncode, out, err


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("questionnaires.csv", ("report", "FOLDER", "--out", "OUT")),
        ("trace.csv", ("play", "FILE", "--scene", "temple", "--size", "64x80", "--out", "OUT")),
        ("answers.csv", ("score", "ssq", "FILE")),
    ],
    ids=["report", "play", "score"],
)
def test_ctrl_c_is_answered_in_one_sentence(tmp_path: Path, name: str, words: tuple[str, ...]):
    """The file to read is a pipe: who can open its other end knows that the command reads it."""
    file = tmp_path / "in" / name
    file.parent.mkdir()
    os.mkfifo(file)
    places = {"FOLDER": file.parent, "FILE": file, "OUT": tmp_path / "out"}
    process = command(*(places.get(word, word) for word in words))
    with file.open("wb"):
        assert stop(process) == (130, "", SENTENCE)


def test_ctrl_c_in_a_session_is_answered_after_the_session(tmp_path: Path):
    words = ("smoke", "-n", 1, "--size", "16x16", "--out", tmp_path / "study")
    process = command("simulate", *words)
    wait_for(tmp_path / "study" / "sub-P01" / "ses-1" / "trials.csv", process, lines=2)
    code, out, err = stop(process)
    assert code == 130
    assert "aborted (stopped by the operator)" in out
    assert err == f"note: the same command goes on where this was stopped\n{SENTENCE}"


def test_ctrl_c_in_a_trade_off_ends_its_processes_without_a_word_of_theirs(tmp_path: Path):
    folders = ("--cache", tmp_path / "cache", "--out", tmp_path / "out")
    process = command("tradeoff", "--quick", "--jobs", 2, *folders)
    wait_for(tmp_path / "out", process)
    assert stop(process) == (130, "", SENTENCE)


def test_processes_do_not_wait_for_their_work_after_ctrl_c(tmp_path: Path):
    file = tmp_path / "program.py"
    file.write_text(
        f"""{HEARS}
import time
from vrcomfort.tradeoff.workers import workers
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


@pytest.mark.parametrize("module", ["vrcomfort.cli.app", "pydantic", "vrcomfort.cli.tradeoff"])
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
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def wait_for(path: Path, process: subprocess.Popen[str], *, lines: int = 0) -> None:
    """Wait until the command has made a folder, or a file of so many lines."""
    while not path.exists() or (lines and path.read_bytes().count(b"\n") < lines):
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
