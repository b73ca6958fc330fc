"""A whole session under Monado, run from the console alone; and shown again as it was."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import av
import pytest

from tests.support.openxr import needs_monado
from tests.support.places import ROOT
from tests.support.study import read_rows
from tests.support.waiting import SESSION_S

pytest.importorskip("xr", reason="pyopenxr is not installed")
pytestmark = [*needs_monado, pytest.mark.slow]

SCRIPT = ROOT / "scripts" / "session_from_console.py"


def test_a_session_is_steered_from_the_console_and_replayed_beside_another_condition(
    tmp_path: Path,
) -> None:
    words = [sys.executable, str(SCRIPT), str(tmp_path), "64x80"]
    told = subprocess.run(words, capture_output=True, text=True, timeout=SESSION_S, check=False)
    assert told.returncode == 0, told.stdout + told.stderr

    session = tmp_path / "study" / "sub-P01" / "ses-1"
    assert json.loads((session / "manifest.json").read_text())["status"] == "completed"
    events = {row["name"] for row in read_rows(session / "events.csv")}
    steered = {
        "pause",
        *(f"operator_{what}" for what in ("start", "pause", "redo", "note", "rate")),
    }
    assert steered <= events
    trials = read_rows(session / "trials.csv")
    assert [(row["trial"], row["attempt"], row["abort_code"]) for row in trials] == [
        ("1", "1", "redone"),
        ("1", "2", ""),
        ("2", "1", ""),
    ]
    assert float(trials[0]["hidden_s"]) > 0.2  # the pause
    answers = read_rows(session / "questionnaires.csv")
    assert [int(row["response"]) for row in answers] == [index % 4 for index in range(16)] * 2
    clocks = read_rows(session / "clocks.csv")
    assert all(row["xr_time_ns"] for row in clocks)

    found = re.search(r"(\d+) of (\d+) recorded images are equal", told.stdout)
    assert found is not None
    equal, compared = map(int, found.groups())
    assert compared >= 3  # the first frames of three attempts, and what came 30 frames later
    assert equal == compared
    frames = [row for row in read_rows(session / "frames.csv") if row["should_render"] == "1"]
    with av.open(str(tmp_path / "both.mp4")) as container:
        decoded = list(container.decode(video=0))
    assert len(decoded) == len(frames)
    assert decoded[0].width == 2 * 64
