"""Studies that are handed to other labs: recorded with gaze, damaged a line at a time."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.support.resume import go
from tests.support.study import PROTOCOL, AheadHeadset, tiny_protocol
from vrcomfort.frame import Frame
from vrcomfort.geometry import EyeGaze, Gaze, Pose

Change = Callable[[str], str]


class SeesEyes(AheadHeadset):
    """A headset with an eye tracker and hands, which loses either now and then."""

    def frames(self) -> Iterator[Frame]:
        for each in super().frames():
            seen = each.index % 7 != 3
            left_eye = EyeGaze(each.head_pose, seen, pupil_mm=3.5)
            gaze = Gaze(each.head_pose, valid=seen, eyes=(left_eye, None))
            left = Pose(np.array([-0.2, 1.1, -0.3])) if each.index % 5 else None
            yield replace(each, gaze=gaze, hands=(left, Pose(np.array([0.2, 1.1, -0.3]))))


PRACTICE = """
[[practice]]
name = "look"
trials = [{ scene = "room.glb", condition = "blur" }, { scene = "room.glb", condition = "plain" }]
exposure_s = 1.0
"""


def with_gaze(tmp_path: Path, more: str = "") -> Path:
    """Return a study whose participant's eyes and hands were tracked in both sessions.

    `more` is added to its protocol.
    """
    protocol = tiny_protocol(tmp_path, PROTOCOL + more)
    go(tmp_path, sessions=[1, 2], headset_for=lambda *_: SeesEyes(), protocol=protocol)
    return tmp_path / "S"


def edit(file: Path, line: int, change: Change) -> None:
    """Change one line (1-based) of a file."""
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    lines[line - 1] = change(lines[line - 1])
    file.write_text("".join(lines), encoding="utf-8")


def cell(file: Path, line: int, column: str, value: str) -> None:
    """Write one cell of a CSV file that has no quoted cells in that line."""
    names = file.read_text(encoding="utf-8").splitlines()[0].split(",")

    def changed(text: str) -> str:
        cells = text.rstrip("\n").split(",")
        cells[names.index(column)] = value
        return ",".join(cells) + "\n"

    edit(file, line, changed)


def errors_of(dataset: Path) -> list[dict[str, str]]:
    """Return what BIDS' own validator finds wrong."""
    validator = Path(sys.executable).with_name("bids-validator-deno")
    said = subprocess.run(
        [validator, "--format", "json", "--max-rows", "-1", dataset],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    found = json.loads(said.stdout)
    assert found["summary"]["totalFiles"] > 10
    return [each for each in found["issues"]["issues"] if each["severity"] == "error"]
