"""Settings that change while a condition is shown: the picture is that of the new value at once."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render.test_pipeline import SIZE, FrameAt
from tests.support.render import still_life
from vrcomfort.geometry import Pose, yaw_pitch_roll
from vrcomfort.protocol.adjustments import ADJUSTABLE, adjusted
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.output import read_rgb8
from vrcomfort.render.pipeline import StereoRenderer

FIXED = {"method": "fixed", "fixed_m": 2.0}
TURNING = {"from_deg_s": 0.0, "to_deg_s": 200.0}
LENS = {"max_radius_percent": 5.0}
BASES = {
    "focus.fixed_m": ({"focus": FIXED, "depth_of_field": {**LENS, "full_blur_m": 3.0}}, 2.5, 6.0),
    "focus.infinity_m": (
        {"focus": {"method": "nine_ray", "law": "linear"}, "depth_of_field": LENS},
        4.0,
        400.0,
    ),
    "depth_of_field.max_radius_percent": (
        {"focus": FIXED, "depth_of_field": {"full_blur_m": 3.0}},
        1.0,
        4.0,
    ),
    "depth_of_field.full_blur_m": ({"focus": FIXED, "depth_of_field": LENS}, 2.0, 9.0),
    "depth_of_field.full_blur_dioptre": (
        {"focus": FIXED, "depth_of_field": {**LENS, "law": "dioptre"}},
        0.2,
        0.6,
    ),
    "depth_of_field.aperture_m": (
        {"focus": FIXED, "depth_of_field": {**LENS, "law": "thin_lens"}},
        0.02,
        0.1,
    ),
    "depth_of_field.pupil_mm": (
        {"focus": {**FIXED, "fixed_m": 0.2}, "depth_of_field": {**LENS, "law": "eye"}},
        5.0,
        20.0,
    ),
    "depth_of_field.max_diameter_arcmin": (
        {"focus": FIXED, "depth_of_field": {**LENS, "full_blur_m": 1.0}},
        100.0,
        300.0,
    ),
    "depth_of_field.peripheral.unit_diameter_arcmin": (
        {"focus": FIXED, "depth_of_field": {**LENS, "peripheral": {}}},
        60.0,
        200.0,
    ),
    "motion_blur.shutter_fraction": ({"motion_blur": {"mode": "full"}}, 0.4, 1.0),
    "relocation_blur.duration_s": ({"relocation_blur": {}}, 0.06, 1.0),
    "speed_blur.max_sigma_arcmin": ({"speed_blur": {"turning": TURNING}}, 60.0, 120.0),
    "vignette.open_deg": ({"vignette": {"restricted_deg": 20.0}}, 40.0, 60.0),
    "vignette.restricted_deg": ({"vignette": {"turning": TURNING, "attack_s": 0.01}}, 20.0, 60.0),
    "vignette.feather_deg": ({"vignette": {"open_deg": 60.0, "restricted_deg": 20.0}}, 5.0, 30.0),
    "vignette.attack_s": ({"vignette": {"turning": TURNING}}, 0.05, 0.5),
    "vignette.release_s": ({"vignette": {"turning": TURNING, "attack_s": 0.0}}, 0.02, 1.0),
}
"""Setting → a condition in which it does something, and two values of it."""
for _effect, _from, _to in (
    ("motion_blur.fade_with_turning", "from_deg_s", "to_deg_s"),
    ("speed_blur.turning", "from_deg_s", "to_deg_s"),
    ("speed_blur.moving", "from_m_s", "to_m_s"),
    ("vignette.turning", "from_deg_s", "to_deg_s"),
    ("vignette.moving", "from_m_s", "to_m_s"),
):
    _table, _ramp = _effect.split(".")
    _ends = {_from: 0.0, _to: 6.0 if _from == "from_m_s" else 400.0}
    _more = {
        "motion_blur": {"mode": "full"},
        "speed_blur": {"max_sigma_arcmin": 120.0},
        "vignette": {"attack_s": 0.01, "restricted_deg": 10.0},
    }[_table]
    _high = _ends[_to]
    BASES[f"{_effect}.{_from}"] = ({_table: {**_more, _ramp: _ends}}, 0.1 * _high, 0.3 * _high)
    BASES[f"{_effect}.{_to}"] = ({_table: {**_more, _ramp: _ends}}, 0.5 * _high, _high)


def looks():
    """A head that turns and walks, and then rests."""
    for index, yaw_deg in enumerate((0.0, 1.5, 3.0, 3.0)):
        head = Pose((0, 0.8, -0.05 * min(index, 2)), yaw_pitch_roll(np.radians(yaw_deg), 0, 0))
        yield FrameAt(index, head)


def pictures(ctx, built_for, shown):
    renderer = StereoRenderer(ctx, SIZE, eyes=1)
    renderer.build(still_life(), built_for)
    if shown is not built_for:
        renderer.adjust(shown)
    found = []
    for frame in looks():
        result = renderer.render(frame, 0.0)
        found += [read_rgb8(eye) for eye in result.eyes]
    return np.array(found)


def test_each_setting_that_can_change_is_tried():
    assert set(BASES) == set(ADJUSTABLE)


@pytest.mark.parametrize("setting", ADJUSTABLE)
def test_a_value_that_was_adjusted_is_drawn_as_one_that_was_always_there(ctx, setting):
    tables, low, high = BASES[setting]
    condition = Condition.model_validate({"name": "c", **tables})
    before, after = (adjusted(condition, setting, value) for value in (high, low))
    expected = pictures(ctx, after, after)
    np.testing.assert_array_equal(pictures(ctx, before, after), expected)
    assert np.any(pictures(ctx, before, before) != expected)
