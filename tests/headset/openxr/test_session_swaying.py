"""A whole session under a runtime's own simulated head, which sways, with nobody to feed it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.support.openxr import (
    BEST_PRACTICES,
    VALIDATION,
    fresh_monado,
    needs_monado,
    validation_environment,
)
from tests.support.places import ROOT
from tests.support.study import smoke_with
from tests.support.waiting import SESSION_S

pytest.importorskip("xr", reason="pyopenxr is not installed")


pytestmark = needs_monado

CLIENT = """
import atexit, json, sys
from tests.support.openxr_best_practices import BestPractices
atexit.register(lambda said=BestPractices(): print(json.dumps(said.counts())))
from vrcomfort.cli import main
main()
"""
"""The command, which ends with what the best-practices layer has counted."""


def test_a_simulated_participant_goes_through_a_session_under_a_swaying_head(
    tmp_path: Path,
) -> None:
    report = tmp_path / "validation.txt"
    environment = {
        "PYTHONPATH": f"{ROOT}:{os.environ.get('PYTHONPATH', '')}",
        "XR_ENABLE_API_LAYERS": f"{VALIDATION}:{BEST_PRACTICES}",
        **validation_environment(report),
    }
    words = [
        *("run", str(smoke_with(tmp_path, 4.0)), "--participant", "P01", "--quiet"),
        *("--out", str(tmp_path / "study"), "--headset", "openxr", "--size", "64x80"),
        *("--respondent", "simulated"),
    ]
    with fresh_monado(tmp_path, sways=True):
        done = subprocess.run(
            [sys.executable, "-c", CLIENT, *words],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=SESSION_S,
            check=False,
        )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout.splitlines()[-1]) == {}
    said = report.read_text()
    assert "VALID_DEBUG" in said
    assert not any(word in said for word in ("VALID_ERROR", "VALID_WARN"))

    folder = tmp_path / "study" / "sub-P01" / "ses-1"
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["status"] == "completed"
    assert 0.05 < manifest["headset"]["ipd_m"] < 0.08
    trials = pd.read_csv(folder / "trials.csv")
    assert trials["status"].tolist() == ["completed"] * 4
    frames = pd.read_csv(folder / "frames.csv")
    for _, shown in frames.groupby("trial"):
        head = shown[["head_x_m", "head_y_m", "head_z_m"]].to_numpy()
        assert np.ptp(head, axis=0).max() > 0.01  # it sways
    events = set(pd.read_csv(folder / "events.csv")["name"])
    assert not {"openxr_warning", "openxr_error"} & events
    assert "head_found" in events
