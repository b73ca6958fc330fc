"""`vrcomfort tradeoff --effects NAME` of effects without ground truth, and `render --set`."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import pytest

from vrcomfort.protocol.conditions import EFFECTS
from vrcomfort.render import graph
from vrcomfort.tradeoff import effect_costs
from vrcomfort.tradeoff.methods import EFFECTS as JUDGED


def test_every_effect_is_measured_somewhere():
    assert {*JUDGED, *effect_costs.NAMES} == {*EFFECTS, "both"}


@pytest.mark.slow
def test_effects_have_costs_and_traffic_in_a_table(run, tmp_path):
    names = ",".join(effect_costs.NAMES)
    asked = ("--effects", names, "--scene", "temple", "--quick", "--rounds", 1)
    code, _, err = run("tradeoff", *asked, "--size", "32x40", "--out", tmp_path, "--quiet")
    assert (code, err) == (0, "")
    with (tmp_path / "effects.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["effect"] for row in rows] == list(effect_costs.NAMES)
    for row in rows:
        assert float(row["cost"]) > 1
        assert int(row["draws"]) >= int(row["passes"]) >= 1
        assert float(row["bytes_per_pixel"]) >= 8 + 8  # colour is read and written
        assert float(row["reads_per_pixel"]) >= 1
    assert "| temple | vignette |" in (tmp_path / "effects.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (("vignette,focus",), "tables of different kinds"),
        (("vignette,motion_blur",), "tables of different kinds"),
        (("vignette", "--flicker"), "takes --scene, --size, --rounds and --quick alone"),
        (("vignettte",), "there is no 'vignettte'; there are: depth_of_field, motion_blur, both"),
    ],
)
def test_what_cannot_be_measured_together_is_refused(run, tmp_path, asked, said):
    code, _, err = run("tradeoff", "--effects", *asked, "--out", tmp_path)
    assert code == 2
    assert said in err
    assert not list(tmp_path.iterdir())


def test_an_effect_that_draws_nothing_as_it_is_measured_is_refused(run, tmp_path, monkeypatch):
    idle = replace(graph.EFFECTS["vignette"], measured={"open_deg": 180.0})
    monkeypatch.setitem(graph.EFFECTS, "vignette", idle)
    asked = ("--effects", "vignette", "--scene", "temple", "--size", "32x40")
    code, _, err = run("tradeoff", *asked, "--out", tmp_path / "out", "--quiet")
    assert code == 2
    assert "vignette is not measured: neither turning nor moving narrows the field" in err


def drawn(run, tmp_path, *settings):
    options = [word for each in settings for word in ("--set", each)]
    out = tmp_path / "picture"
    code, _, err = run("render", "--scene", "temple", "--size", "32x40", *options, "--out", out)
    assert code == 0, err
    return json.loads((out / "meta.json").read_text(encoding="utf-8")), err


@pytest.mark.slow
def test_any_setting_of_a_condition_can_be_set_for_a_picture(run, tmp_path):
    found, _ = drawn(run, tmp_path, "vignette.open_deg=60", "depth_of_field.kernel=mip")
    assert found["condition"]["vignette"]["open_deg"] == 60.0
    assert found["condition"]["depth_of_field"]["kernel"] == "mip"
    assert found["condition"]["depth_of_field"]["law"] == "dioptre"  # the picture's own
    assert "vignette" in found["passes"]
    found, said = drawn(run, tmp_path, "motion_blur=none", "focus.zone_ratio=0.5", "quality=fast")
    assert found["condition"]["motion_blur"] is None
    assert found["condition"]["depth_of_field"]["samples"] == 12
    assert 'focus.zone_ratio does nothing with method = "nine_ray"' in said


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("vignette.opn_deg=60", "no setting `opn_deg` in vignette; did you mean `open_deg`?"),
        ("vignet.open_deg=60", "there is no setting `vignet`; did you mean `vignette`?"),
        ("vignette=60", "vignette is a table; write vignette.speed_of=…, or vignette=none"),
        ("vignette.open_deg", "changes nothing; write vignette.open_deg=60"),
        ("vignette.open_deg=wide", "`open_deg`: should be a number, got 'wide'"),
        ("vignette.open_deg=270", "`open_deg`: should be less than or equal to 180"),
        ("vignette.turning.from_deg_s=3", "`to_deg_s` is missing in [vignette.turning]"),
        ("focus.fixed_m.x=3", "there is no setting `x` in focus.fixed_m"),
    ],
)
def test_a_setting_that_cannot_be_is_refused_before_anything_is_made(run, tmp_path, setting, said):
    out = tmp_path / "picture"
    code, _, err = run("render", "--scene", "temple", "--set", setting, "--out", out)
    assert code == 2
    assert said in err
    assert "Traceback" not in err
    assert not out.exists()
