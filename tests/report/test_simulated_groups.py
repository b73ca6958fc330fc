"""A study of two groups from `simulate` to its page."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.support.places import ROOT
from tests.support.report import build_report
from vrcomfort.cli.app import app
from vrcomfort.resources import data_folder

pytestmark = pytest.mark.slow
PLAN = ROOT / "docs" / "plans" / "groups_before_and_after.toml"
GROUPS = """
[[groups]]
name = "without"
conditions = ["plain"]
[[groups]]
name = "with"
conditions = ["dof"]
"""


def protocol(folder: Path) -> Path:
    """Write the smoke test with two of its conditions, one for each group."""
    text = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    start, end = text.index('[[conditions]]\nname = "motion"'), text.index("[order]")
    file = folder / "two_groups.toml"
    file.write_text(text[:start] + text[end:] + GROUPS, encoding="utf-8")
    return file


def test_two_groups_from_simulate_to_page(tmp_path: Path) -> None:
    study = tmp_path / "study"
    options = ["-n", "8", "--size", "48x60", "--seed", "3", "--quiet", "--out", str(study)]
    app(["simulate", str(protocol(tmp_path)), *options], standalone_mode=False)
    built = build_report(study, plan=PLAN, out=tmp_path / "report")
    results = json.loads(built.results.read_text())
    groups = [row for row in results["comparisons"] if row["design"] == "independent"]
    assert [(row["outcome"], row["n_a"], row["n_b"]) for row in groups] == [
        ("T", 4, 4), ("ratings.peak", 4, 4), ("frames.head_turning_deg", 4, 4),
    ]  # fmt: skip
    before = next(row for row in results["comparisons"] if row["design"] == "paired")
    assert (before["outcome"], before["n_a"], before["test"]) == ("T", 8, "paired_t")
    assert results["correlations"][0]["n"] == 8
    assert "Mann–Whitney test (exact)" in built.index.read_text()
