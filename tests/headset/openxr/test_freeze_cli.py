"""A runtime that stands still for five seconds of a ten-second exposure: time is told apart."""

from __future__ import annotations

import json
import os
import signal
import time
from pathlib import Path
from statistics import median

import pytest

from tests.headset.openxr.test_hang_cli import Session, session
from tests.support.openxr import needs_monado
from tests.support.study import read_rows
from tests.support.waiting import WAIT_S

pytest.importorskip("xr", reason="pyopenxr is not installed")

pytestmark = needs_monado

FROZEN_S, SHOWN_S = 5.0, 10.0
PERIODS = 2
"""How many frame periods the live time may be off."""
RATINGS = "every_s = 1.0\ntimeout_s = 0.9"


def frozen_session(running: Session) -> float:
    """Stop the runtime in the first exposure; return for how long it stood still."""
    running.wait_for(lambda: running.frames() >= 5)
    service = running.service
    os.kill(service, signal.SIGSTOP)
    stopped_s = time.monotonic()
    time.sleep(FROZEN_S)
    os.kill(service, signal.SIGCONT)
    still_s = time.monotonic() - stopped_s
    running.wait_for(lambda: (running.folder / "trials.csv").read_bytes().count(b"\n") > 1)
    return still_s


def test_a_freeze_is_flagged_and_its_ratings_are_missed(tmp_path: Path) -> None:
    with session(tmp_path, exposure_s=SHOWN_S, ratings=RATINGS) as running:
        still_s = frozen_session(running)
        running.process.send_signal(signal.SIGINT)
        assert running.process.wait(WAIT_S) == 130
    trial = read_rows(running.folder / "trials.csv")[0]
    frames = [row for row in read_rows(running.folder / "frames.csv") if row["trial"] == "1"]
    period_s = median(int(row["period_ns"]) for row in frames) / 1e9
    off_s = PERIODS * period_s
    assert trial["status"] == "completed"
    # The runtime is slow for a while after it: then frames come at half rate.
    moving_s = float(trial["live_s"]) + float(trial["half_rate_s"])
    assert moving_s >= (len(frames) - 1) * period_s - off_s
    assert moving_s <= SHOWN_S - still_s + off_s
    # The last frame may come late, too.
    shown_s = [int(row["xr_time_ns"]) / 1e9 for row in frames]
    late_s = max(shown_s[-1] - shown_s[0] - SHOWN_S, 0.0)
    whole_s = moving_s + float(trial["frozen_s"])
    assert whole_s == pytest.approx(SHOWN_S + late_s, abs=off_s)
    missed = int(trial["missed_refreshes"])
    assert float(trial["frozen_s"]) >= still_s - off_s
    assert missed == pytest.approx(whole_s / period_s - len(frames), abs=PERIODS)
    flags = json.loads((running.folder / "manifest.json").read_text())["timing_flags"]
    assert "the picture stood still for" in flags[0]
    assert read_rows(running.folder / "timing.csv")[0]["flagged"] == "1"
    ratings = [row for row in read_rows(running.folder / "ratings.csv") if row["trial"] == "1"]
    assert len(ratings) == 9, "each rating that was due has its row"
    assert sum(int(row["missed"]) for row in ratings) >= 4
