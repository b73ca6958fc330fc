"""What a run refuses before it looks for a headset, and what it says where there is none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.resume import go
from tests.support.study import AheadHeadset, Scripted, strict_about_gaze
from tests.support.waiting import WAIT_S
from vrcomfort.cli import main
from vrcomfort.protocol import load_protocol
from vrcomfort.records import only_run, read_participants
from vrcomfort.resources import data_folder

pytest.importorskip("xr", reason="pyopenxr is not installed")

PARTICIPANT = "--participant", "P01"


def refusal(folder: Path, *options: str, protocol: str = "smoke") -> str:
    """Return what a run says where no runtime is active; it must be one sentence, exit code 2."""
    nowhere = str(folder / "nowhere")
    command = [sys.executable, "-c", "from vrcomfort.cli import main; main()", "run", protocol]
    done = subprocess.run(
        [*command, *PARTICIPANT, "--out", str(folder / "S"), "--headset", "openxr", *options],
        env={**os.environ, "XR_RUNTIME_JSON": nowhere, "HOME": nowhere, "XDG_RUNTIME_DIR": nowhere},
        capture_output=True,
        text=True,
        timeout=WAIT_S,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith("error: ")
    return done.stderr


@pytest.mark.slow
def test_without_a_runtime_a_run_says_what_to_start_and_enrols_nobody(tmp_path: Path) -> None:
    assert "make it the active OpenXR runtime" in refusal(tmp_path)
    assert read_participants(tmp_path / "S") == []
    assert not (tmp_path / "S" / "sub-P01" / "ses-1").exists()


@pytest.mark.slow
def test_the_runtime_is_asked_for_an_eye_tracker_before_a_folder_is_made(tmp_path: Path) -> None:
    protocol = str(strict_about_gaze(tmp_path))
    assert "make it the active OpenXR runtime" in refusal(tmp_path, protocol=protocol)
    assert not (tmp_path / "S").exists()


@pytest.mark.slow
def test_a_second_run_of_a_participant_is_refused_before_a_headset_is_looked_for(
    tmp_path: Path,
) -> None:
    with only_run(tmp_path / "S", "P01"):
        assert f"P01 is being run by process {os.getpid()}" in refusal(tmp_path)


@pytest.mark.slow
def test_an_unfinished_session_is_refused_before_a_headset_is_looked_for(tmp_path: Path) -> None:
    def interrupted(*_: object) -> AheadHeadset:
        return AheadHeadset(interrupt_at=0)

    smoke = load_protocol("smoke")
    begun = go(tmp_path, Scripted(name="panel"), protocol=smoke, headset_for=interrupted)
    assert begun.status == "aborted"
    assert "continue it with run --resume" in refusal(tmp_path)
    assert "make it the active OpenXR runtime" in refusal(tmp_path, "--resume")


@pytest.mark.slow
def test_a_session_on_disk_is_refused_before_a_headset_is_looked_for(tmp_path: Path) -> None:
    go(tmp_path, protocol=load_protocol("smoke"))
    assert "never overwritten" in refusal(tmp_path, "--session", "1")
    assert "leave --resume out" in refusal(tmp_path, "--session", "1", "--resume")


TRACE = str(data_folder("scenes") / "temple_walk.csv")


@pytest.mark.parametrize(
    ("headset", "options", "words"),
    [
        ("desktop", ["--monado-trace", TRACE], "--monado-trace is for --headset openxr;"),
        ("playback", ["--monado-answers", TRACE], "--monado-answers is for --headset openxr;"),
        ("desktop", ["--mirror"], "--mirror is for --headset openxr; leave it out"),
        ("openxr", ["--one-eye"], "--one-eye is for --headset desktop; leave it out"),
        ("openxr", ["--trace", TRACE], "--trace is for --headset playback; leave it out"),
        ("desktop", ["--refresh-hz", "90"], "--refresh-hz is for --headset playback or"),
        ("playback", ["--respondent", "panel"], "for --headset openxr or --headset desktop;"),
        ("openxr", ["--monado-answers", TRACE], "--monado-answers needs --monado-trace"),
    ],
)
def test_options_that_mean_nothing_are_refused(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    headset: str,
    options: list[str],
    words: str,
) -> None:
    shared = ["--out", str(tmp_path / "S"), "--headset", headset]
    monkeypatch.setattr("sys.argv", ["vrcomfort", "run", "smoke", *PARTICIPANT, *shared, *options])
    with pytest.raises(SystemExit, match="2"):
        main()
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert words in said
