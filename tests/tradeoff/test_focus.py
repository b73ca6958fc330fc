"""`vrcomfort tradeoff --effects focus`: what a search for the focus costs, and how wrong it is."""

from __future__ import annotations

import csv

import pytest

from vrcomfort.tradeoff import focus_search
from vrcomfort.tradeoff.focus_search import zone_errors


@pytest.mark.slow
def test_a_finer_zone_errs_less_and_the_finest_not_at_all(monkeypatch):
    monkeypatch.setattr(focus_search, "ZONE_SIDES_PX", (4, 64, 256))
    monkeypatch.setattr(focus_search, "REFERENCE_SIDE_PX", 256)
    for ratio in (0.25, 0.5):
        rows = [row for row in zone_errors("temple", 3, lambda: None) if row.zone_ratio == ratio]
        coarse, fine, same = (row.largest_dioptre for row in rows)
        assert coarse > fine > same == 0


@pytest.mark.slow
def test_the_command_writes_its_tables(monkeypatch, run, tmp_path):
    monkeypatch.setattr(focus_search, "REFERENCE_SIDE_PX", 64)
    monkeypatch.setattr(focus_search, "ZONE_SIDES_PX", (16, 32))
    asked = ("--effects", "focus", "--scene", "temple", "--quick", "--rounds", 1)
    code, out, err = run("tradeoff", *asked, "--size", "32x40", "--out", tmp_path)
    assert (code, err) == (0, "")
    assert "focus.md" in out
    with (tmp_path / "focus_costs.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["search"], row["zone_ratio"], row["zone_mean_on"]) for row in rows] == [
        ("no blur", "", ""),
        ("fixed", "", ""),
        ("autofocus_zone", "0.25", "cpu"),
        ("autofocus_zone", "0.25", "gpu"),
        ("autofocus_zone", "0.5", "cpu"),
        ("autofocus_zone", "0.5", "gpu"),
        ("nine_ray", "", ""),
    ]
    for row in rows:
        assert float(row["frames_per_s"]) * float(row["frame_ms"]) == pytest.approx(1e3)
    assert "64×64 px" in (tmp_path / "focus.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("option", [("--lens", "7"), ("--flicker",), ("--eyes", "1")])
def test_what_focus_does_not_take_is_refused(run, tmp_path, option):
    code, _, err = run("tradeoff", "--effects", "focus", *option, "--out", tmp_path)
    assert code == 2
    assert "--effects focus takes --scene" in err
    assert not list(tmp_path.iterdir())
