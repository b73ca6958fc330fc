"""Faults of runtime and disk as an experimenter meets them: one sentence, and what was recorded."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.support.openxr import needs_monado
from tests.support.places import ROOT
from tests.support.study import read_rows, smoke_with
from tests.support.waiting import WAIT_S
from vrcomfort.csv_table import CsvTable
from vrcomfort.resources import data_folder

pytest.importorskip("xr", reason="pyopenxr is not installed")

pytestmark = needs_monado

FILES = ("trials", "timing", "questionnaires", "ratings", "frames", "events")
CLIENT = """
import os, sys
from itertools import count
import xr
from tests.support.openxr_layers import Interceptor, answer

waits = count()

def late(follow, *arguments):
    return xr.Result.TIMEOUT_EXPIRED if next(waits) > 60 else follow(*arguments)

def formats(_, session, capacity, found, numbers):
    found[0] = 1
    if capacity:
        numbers[0] = 0x881A
    return xr.Result.SUCCESS

layer = Interceptor(**{calls})
os.environ["XR_ENABLE_API_LAYERS"] = layer.name
from vrcomfort.cli import main
main()
"""


def command(folder: Path, calls: str = "{}") -> list[str]:
    answers = folder / "answers.txt"
    answers.write_text("0 1 2 3 " * 60)
    return [
        *(sys.executable, "-c", CLIENT.replace("{calls}", calls)),
        *("run", str(smoke_with(folder, 6.0)), "--participant", "P01"),
        *("--out", str(folder / "study"), "--headset", "openxr", "--size", "16x16", "--quiet"),
        *("--monado-trace", str(data_folder("scenes") / "temple_walk.csv")),
        *("--monado-answers", str(answers)),
    ]


def environment() -> dict[str, str]:
    root = ROOT
    return {**os.environ, "PYTHONPATH": f"{root}:{os.environ.get('PYTHONPATH', '')}"}


def sentence(said: str) -> str:
    """Return the only thing that a fault says; the runtime's own log is not ours."""
    assert "Traceback" not in said
    (line,) = [line for line in said.splitlines() if line.startswith("error: ")]
    return line


@pytest.mark.parametrize(
    ("calls", "words"),
    [
        (
            "{'xrGetSystem': answer(xr.Result.ERROR_FORM_FACTOR_UNAVAILABLE)}",
            "finds no headset; connect it, switch it on, then run again",
        ),
        (
            "{'xrCreateSession': answer(xr.Result.ERROR_GRAPHICS_DEVICE_INVALID)}",
            "run on the GPU that the headset is plugged into",
        ),
        ("{'xrEnumerateSwapchainFormats': formats}", "offers no SRGB8_ALPHA8 images"),
    ],
)
def test_what_cannot_start_is_said_and_records_nothing(
    tmp_path: Path, calls: str, words: str
) -> None:
    done = subprocess.run(
        command(tmp_path, calls),
        env=environment(),
        capture_output=True,
        text=True,
        timeout=WAIT_S,
        check=False,
    )
    assert done.returncode == 2
    assert words in sentence(done.stderr)
    assert not (tmp_path / "study" / "sub-P01" / "ses-1").exists()


def test_an_image_that_does_not_come_ends_the_session_and_keeps_it(tmp_path: Path) -> None:
    done = subprocess.run(
        command(tmp_path, "{'xrWaitSwapchainImage': late}"),
        env=environment(),
        capture_output=True,
        text=True,
        timeout=WAIT_S,
        check=False,
    )
    assert done.returncode == 3
    assert "it gave no image within 5 s" in sentence(done.stderr)
    folder = tmp_path / "study" / "sub-P01" / "ses-1"
    recorded = {name: read_rows(folder / f"{name}.csv") for name in FILES}
    assert len(recorded["events"]) > 3


def test_a_full_disk_ends_the_session_and_keeps_it(tmp_path: Path) -> None:
    folder = tmp_path / "study" / "sub-P01" / "ses-1"
    process = subprocess.Popen(
        command(tmp_path), env=environment(), stderr=subprocess.PIPE, text=True
    )
    frames = folder / "frames.csv"
    while not frames.exists() or frames.read_bytes().count(b"\n") < 4:
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)
    full = frames.stat().st_size
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (full, full))
    said = process.communicate(timeout=WAIT_S)[1]
    assert process.returncode == 2
    line = sentence(said)
    assert "cannot write: File too large; what was written before is kept" in line
    assert len(read_rows(folder / "questionnaires.csv")) == 16
    assert len(CsvTable.read(frames, appended=True).rows) >= 3  # the last row may be cut
