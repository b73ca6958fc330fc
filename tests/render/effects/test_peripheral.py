"""Blur that grows from the head's axis outwards, after Hillaire et al. 2008."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles import circle_of_confusion as coc
from tests.support.effects import coc_passes_of, depth_of_field, seen, square_pixels
from vrcomfort.geometry import Fov, Pose, axis_angle, focal_length_px
from vrcomfort.protocol import DepthOfField
from vrcomfort.protocol.conditions import Peripheral

NEAR_M = 0.02
LEFT_EYE = Fov(*np.arctan([-1.2, 0.9, 1.0, -1.1]).tolist())
WIDE_EDGE = Peripheral(unit_diameter_arcmin=600.0)


@given(st.floats(-20, 20), st.floats(-20, 20), st.floats(-1, 1))
def test_peripheral_blur_keeps_signs_and_their_order(one, other, cosine):
    shape = {"unit_px": 7.0, "exponent": 2.0, "max_radius_px": 25.0}
    a, b = coc.with_peripheral_px([one, other], cosine, **shape)
    assert abs(a) >= min(abs(one), 25.0)
    assert abs(a) <= 25.0
    assert (a < 0) == (one < 0)
    if one < other:
        assert a <= b


def test_peripheral_blur_is_equation_5():
    shape = {"unit_px": 4.0, "exponent": 2.0, "max_radius_px": 50.0}
    cosines = np.cos(np.radians([0.0, 30.0, 60.0, 90.0, 120.0]))
    found = coc.with_peripheral_px(np.array([0.0, -1.0, 0.0, 1.0, -1.0]), cosines, **shape)
    at_30 = 4 * (2 / np.sqrt(3) - 1) ** 2
    np.testing.assert_allclose(found, [0, -1 - at_30, 4, 50, -50], atol=1e-9)


def test_peripheral_blur_on_the_gpu_grows_from_the_heads_axis(ctx):
    """In an eye that is turned outwards and sees more on one side, too."""
    size_px = (60, 48)
    shape = Peripheral(exponent=2.0, unit_diameter_arcmin=300.0)
    settings = DepthOfField(law="eye", pupil_mm=0.0, max_radius_percent=10, peripheral=shape)
    effect = coc_passes_of(ctx, settings, 3.0, 2.0, size_px)
    turned = Pose(np.zeros(3), axis_angle([0.0, 1.0, 0.0], 0.2))
    effect.render(seen(LEFT_EYE, near_m=NEAR_M, head_from_eye=turned).camera)
    found = (
        np.frombuffer(effect.colour_and_coc.read(), "f2").reshape(48, 60, 4)[..., 3].astype(float)
    )
    left, right, up, down = LEFT_EYE.tangents
    x = left + (right - left) * (np.arange(60) + 0.5) / 60
    y = down + (up - down) * (np.arange(48) + 0.5) / 48
    rays = np.stack([*np.meshgrid(x, y), np.full((48, 60), -1.0)], axis=-1)
    ahead = turned.inverse().matrix()[:3, :3] @ [0.0, 0.0, -1.0]
    cosine = rays @ ahead / np.linalg.norm(rays, axis=-1)
    unit_px = np.tan(np.radians(2.5)) * focal_length_px(LEFT_EYE, size_px)[0]
    twin = coc.with_peripheral_px(
        np.zeros_like(cosine), cosine, unit_px=unit_px, exponent=2, max_radius_px=6
    )
    np.testing.assert_allclose(found, twin, rtol=2e-3, atol=2e-3)
    assert found.max() > 1.0


def test_a_limit_on_peripheral_blur_is_told(ctx):
    """With how wide it would have been in the middle of the outermost tiles."""
    size_px = (64, 64)
    fov = square_pixels(size_px)
    shape = Peripheral(exponent=2.0, unit_diameter_arcmin=600.0)
    settings = DepthOfField(law="eye", pupil_mm=0.0, max_radius_percent=1, peripheral=shape)
    effect = coc_passes_of(ctx, settings, 3.0, 2.0, size_px)
    effect.render(seen(fov, near_m=NEAR_M, head_from_eye=Pose()).camera)
    corner = 7 / 8 * np.array(fov.tangents)[[1, 2]]
    over = np.sqrt(1 + corner @ corner) - 1
    widest_px = np.tan(np.radians(5.0)) * focal_length_px(fov, size_px)[0] * over**2
    assert widest_px > 0.64
    assert effect.largest_radius_px() == pytest.approx(widest_px, rel=1e-3)
    assert effect.clamps()[0].endswith("limited to 0.6 px")


def test_peripheral_blur_alone_leaves_the_middle_as_it_is(ctx):
    rgb = np.random.default_rng(3).uniform(0, 1, (96, 128, 3)).astype("f2")
    settings = {"law": "eye", "pupil_mm": 0.0, "max_radius_percent": 5.0}
    blurred = depth_of_field(ctx, rgb, 2.0, 1.0, peripheral=WIDE_EDGE, **settings)
    np.testing.assert_array_equal(blurred[36:60, 48:80], rgb[36:60, 48:80])
    assert np.std(blurred[:12, :12].astype(float)) < 0.8 * np.std(rgb[:12, :12].astype(float))


def test_peripheral_blur_mixes_no_far_light_into_the_sharp_middle(ctx):
    """In front of or behind the focus by a hair: a sharp thing stays free of the blurred rest."""
    rgb = np.full((96, 128, 3), 10.0)
    rgb[:, 58:70] = 0.0
    for thing_m in (0.999, 1.001):
        distance = np.full((96, 128), 1e4)
        distance[:, 58:70] = thing_m
        settings = {"law": "dioptre", "full_blur_dioptre": 1.0, "max_radius_percent": 5.0}
        shape = Peripheral(unit_diameter_arcmin=60.0)
        out = depth_of_field(ctx, rgb, distance, 1.0, peripheral=shape, **settings)
        assert out[36:60, 58:70].max() == 0.0
