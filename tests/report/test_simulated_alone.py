"""Studies of tasks alone and of preferences alone, from `simulate` to their pages."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.places import ROOT
from tests.support.report import build_report
from vrcomfort.cli.app import app

pytestmark = pytest.mark.slow
PLANS = ROOT / "docs" / "plans"
PROTOCOL = """\
name = "alone"
title = "Nothing but this is asked"
exposure_s = {exposure_s}
scenes = ["depths"]

[[conditions]]
name = "plain"
label = "No blur"

[[conditions]]
name = "blur"
label = "Depth of field"
[conditions.depth_of_field]

[order]
rule = "latin_square"
"""
TASK = """
task = "shoot"
"""
AIMING = """
[[tasks]]
name = "shoot"
kind = "aiming"
every_s = 0.7
shown_s = 0.6
jitter_s = 0.0

[simulation]
hazard_per_min = 0.0
reaction_s = 0.15
task_effects = { blur = 1.6 }
"""
CHOICES = """
[[questionnaires]]
instrument = "preference"
timepoint = "preference"
when = "session_end"
compares = "session"

[simulation]
hazard_per_min = 0.0
question_hazard = 0.0
liking = { blur = 3.0 }
"""


def simulated(folder: Path, protocol: str, people: int) -> Path:
    """Simulate a study of small pictures and return its folder."""
    file, study = folder / "alone.toml", folder / "study"
    file.write_text(protocol, encoding="utf-8")
    small = ["--size", "32x40", "--refresh-hz", "20", "--seed", "3", "--quiet"]
    app(
        ["simulate", str(file), "-n", str(people), *small, "--out", str(study)],
        standalone_mode=False,
    )
    return study


def reported(study: Path, plan: str, out: Path) -> tuple[dict[str, Any], str]:
    """Return results and page of a study's report."""
    built = build_report(study, plan=PLANS / f"{plan}.toml", out=out)
    return json.loads(built.results.read_text()), built.index.read_text()


def test_tasks_alone_from_simulate_to_page(tmp_path: Path) -> None:
    text = TASK + PROTOCOL.format(exposure_s=1.5) + AIMING
    study = simulated(tmp_path, text, 6)
    results, page = reported(study, "aiming_only", tmp_path / "report")
    (slower, *_) = results["tests"]
    assert (slower["outcome"], slower["n"]) == ("tasks.reaction_s", 6)
    # Blur makes them 1.6 times as slow, and all six of them slower: p = 2 / 2⁶.
    means = [slower["descriptives"][slower[side]]["mean"] for side in "ab"]
    assert means[0] > 1.3 * means[1]
    assert slower["p"] == pytest.approx(2 / 2**6)
    (of_time, *_) = [row for row in results["comparisons"] if row["test"] == "paired_t"]
    assert of_time["difference"]["estimate"] > 0
    assert results["correlations"][0]["people"] == 6
    assert results["z_scores"][0]["people"] == 6
    assert 'id="tests"' in page


def test_preferences_alone_from_simulate_to_page(tmp_path: Path) -> None:
    text = PROTOCOL.format(exposure_s=0.1) + CHOICES
    study = simulated(tmp_path, text, 8)
    results, page = reported(study, "choices_only", tmp_path / "report")
    fun, realism = results["preferences"]
    assert fun["a"] + fun["b"] + fun["none"] == fun["n"] == 8
    assert fun["a"] > fun["b"]
    assert realism["n"] == 8
    assert "More fun" in page
    assert results["tests"] == []
    assert results["notices"] == results["quality"]["reading"] == []
