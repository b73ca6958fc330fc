"""The ready studies after Hillaire et al. 2008 and Mantiuk et al. 2011: the papers' numbers."""

from itertools import pairwise

import pytest

from tests.support.render import still_life
from vrcomfort.protocol import load_protocol
from vrcomfort.protocol.conditions import Condition, Focus
from vrcomfort.render.graph import plan_effect, plan_focus
from vrcomfort.session.manifest_writer import limits


def test_hillaire_in_numbers():
    study = load_protocol("hillaire_2008")
    assert (study.participants, study.exposure_s, study.training_s) == (30, 300.0, 240.0)
    blur = study.condition("blur_on")
    focus, lens = blur.focus, blur.depth_of_field
    assert (focus.method, focus.zone_ratio, focus.mean) == ("autofocus_zone", 0.25, "metres")
    weights = (focus.semantic_min, focus.semantic_max, focus.gauss_centre, focus.gauss_border)
    assert weights == (0.004, 1.0, 1.0, 0.7)
    assert (focus.law, focus.cutoff_hz) == ("low_pass", 5.0)
    assert lens.law == "thin_lens"
    assert lens.peripheral.exponent == 2.0
    # D_max: 11 px of 1280 over 90°, whose focal length is 640 px.
    assert lens.max_diameter_arcmin == pytest.approx(59.09, abs=0.005)
    assert study.condition("blur_off").depth_of_field is None
    for one in study.order.sequences:  # who begins with what: protocol/test_protocols_of_sources.py
        first, second = [trial.condition for trial in one.trials[:2]], one.trials[2:]
        assert set(first) == {"blur_on", "blur_off"}
        trials = [trial.condition for trial in second]
        assert len(trials) == 6
        assert all(before != after for before, after in pairwise(trials))


def test_mantiuk_in_numbers():
    study = load_protocol("mantiuk_2011")
    assert (study.participants, study.exposure_s) == (21, 15.0)
    by_gaze = [c for c in study.conditions if c.focus.method == "gaze"]
    openings = [c.depth_of_field.aperture_m for c in by_gaze]
    assert openings == pytest.approx([19 * 0.003, 7 * 0.003, 2 * 0.003])  # the unit is ours
    for condition in by_gaze:
        assert (condition.focus.law, condition.focus.duration_s) == ("duration", 0.37)
        assert condition.focus.gaze_radius_deg == 1.5
    for condition in study.conditions:
        assert condition.depth_of_field.law == "thin_lens"
        assert condition.depth_of_field.distance_offset_m == 0.6
    script = study.condition("no_tracker").focus
    assert script.method == "scripted"
    assert study.training_s == 0  # the scripts' time begins with the scene
    assert set(script.scripts) == set(study.scenes)  # "predefined for each scene"
    for view, written in script.scripts.items():
        assert written[-1][0] <= study.length_s(view)
        assert study.condition("no_tracker", view).focus.script == written


def test_the_plan_says_how_focus_is_found():
    scene = still_life()
    zone = load_protocol("hillaire_2008").condition("blur_on")
    reason = plan_focus(scene, zone).reason
    assert "0.25 of the image's sides, drawn in 64×64 px and averaged by the GPU in 7" in reason
    assert "peripheral" in plan_effect("depth_of_field", scene, zone).reason
    gaze = load_protocol("mantiuk_2011").condition("gaze_7")
    assert "needs an eye tracker; nine rays ahead without one" in plan_focus(scene, gaze).reason
    strict = gaze.model_copy(update={"focus": Focus(method="gaze")})
    assert "the session stops without one" in plan_focus(scene, strict).reason


def test_the_manifest_says_that_nine_rays_may_stand_in_for_the_gaze():
    noted = [line for line in limits(load_protocol("mantiuk_2011")) if "eye tracker" in line]
    assert len(noted) == 3


@pytest.mark.parametrize(("level", "limited"), [("balanced", True), ("reference", False)])
def test_the_manifest_says_whether_there_is_a_largest_radius(level, limited):
    study = load_protocol("smoke")
    lens = {"name": "lens", "quality": level, "depth_of_field": {"law": "dioptre"}}
    (said,) = limits(study.model_copy(update={"conditions": (Condition.model_validate(lens),)}))
    assert ("circle of confusion at most 1.75 %" in said) == limited
    assert ("have no largest radius" in said) != limited
