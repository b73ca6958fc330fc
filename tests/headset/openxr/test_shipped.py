"""Each shipped protocol in a Monado runtime, with pictures: all steps, exposures of a second.

One session of each, with a simulated participant who answers, does the tasks and looks; the head
follows a trace through the runtime.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.support.openxr import needs_monado
from tests.support.shortened import EXPOSURE_S, SHIPPED, assert_whole, first_person, shortened
from tests.support.waiting import SESSION_S
from vrcomfort.protocol import load_protocol
from vrcomfort.resources import data_folder

pytest.importorskip("xr", reason="pyopenxr is not installed")

pytestmark = needs_monado

TRACE = data_folder("scenes") / "temple_walk.csv"


def run(*words: object) -> None:
    command = ["vrcomfort", *map(str, words), "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SESSION_S, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_protocol_is_shown_whole_through_the_runtime(
    name: str, tmp_path: Path
) -> None:
    file = shortened(name, tmp_path)
    protocol, study, rehearsed = load_protocol(file), tmp_path / "study", tmp_path / "rehearsed"
    short = ("--exposure-s", EXPOSURE_S)
    headset = ("--headset", "openxr", "--monado-trace", TRACE, "--size", "48x60")
    person = ("--participant", "P01", "--respondent", "simulated", *first_person(protocol))
    run("run", file, *person, *headset, *short, "--out", study)
    run("simulate", file, "-n", 1, "--no-draw", *short, "--out", rehearsed)
    assert_whole(study, protocol, rehearsed)
