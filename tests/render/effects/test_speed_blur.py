"""The blur that grows with speed: how fast a head goes, and what the Gaussian does to pixels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tests.oracles.gaussian import gaussian_weights
from tests.support.effects import rgb_of, seen, square_pixels, textures
from vrcomfort.geometry import Fov, Pose, axis_angle, focal_length_px
from vrcomfort.optics.motion import ramp, sigma_px, speed_m_s, turn_deg_s
from vrcomfort.protocol.conditions import MoveRamp, SpeedBlur, TurnRamp
from vrcomfort.render.camera import HeadStep, speed_share
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.effects.speed_blur import SpeedBlurPass

TURNING = TurnRamp(from_deg_s=40, to_deg_s=120)
MOVING = MoveRamp(from_m_s=1, to_m_s=3)
FULL = HeadStep(Pose(), Pose((1.0, 0, 0)), Pose(), Pose(), 0.1)
"""10 m/s: full strength where moving counts at all."""

axis = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array).filter(lambda v: np.linalg.norm(v) > 0.1)


def yaw(deg, position=(0.0, 0.0, 0.0)):
    return Pose(position, axis_angle([0, 1, 0], np.radians(deg)))


@given(axis, st.floats(0, 170), axis, st.floats(0, 170), st.floats(0.001, 1))
def test_turning_speed_is_the_angle_over_the_time(about, angle_deg, around, start_deg, seconds):
    before = Pose(orientation=axis_angle(around, np.radians(start_deg)))
    now = before @ Pose(orientation=axis_angle(about, np.radians(angle_deg)))
    assert turn_deg_s(before, now, seconds=seconds) == pytest.approx(angle_deg / seconds, abs=1e-3)


def test_speeds_without_time_between_frames_are_zero():
    assert turn_deg_s(Pose(), yaw(90), seconds=0.0) == 0
    assert speed_m_s(Pose(), Pose((1.0, 0, 0)), seconds=0.0) == 0


def test_a_ramp_is_linear_between_its_ends():
    assert [ramp(x, 2, 4) for x in (0, 2, 3, 3.5, 4, 9)] == [0, 0, 0.5, 0.75, 1, 1]


def test_a_ramp_that_falls_is_refused():
    for ends in ({"from_deg_s": 50, "to_deg_s": 50}, {"from_deg_s": 60, "to_deg_s": 50}):
        with pytest.raises(ValidationError, match="`to_deg_s` must be more than `from_deg_s`"):
            TurnRamp(**ends)
    with pytest.raises(ValidationError, match="`to_m_s` must be more than `from_m_s`"):
        MoveRamp(from_m_s=2, to_m_s=1)


def test_the_larger_ramp_wins_and_an_absent_one_does_not_count():
    step = HeadStep(yaw(0), yaw(8, (0.15, 0, 0)), Pose(), Pose(), 0.1)  # 80 deg/s, 1.5 m/s
    assert speed_share(SpeedBlur(turning=TURNING, moving=MOVING), step) == pytest.approx(0.5)
    assert speed_share(SpeedBlur(turning=TURNING), step) == pytest.approx(0.5)
    assert speed_share(SpeedBlur(moving=MOVING), step) == pytest.approx(0.25)
    assert speed_share(SpeedBlur(), step) == 0
    assert speed_share(SpeedBlur(turning=TURNING, moving=MOVING), None) == 0


def test_head_and_avatar_are_told_apart():
    """The stage turns back by what the head turns: the scene is still, the head is not."""
    step = HeadStep(yaw(0), yaw(8), yaw(0), yaw(-8), 0.1)
    found = {
        of: speed_share(SpeedBlur(speed_of=of, turning=TURNING), step)
        for of in ("head", "avatar", "both")
    }
    assert found == pytest.approx({"head": 0.5, "avatar": 0.5, "both": 0.0})
    walk = HeadStep(Pose(), Pose(), Pose(), Pose((0.0, 0, -0.2)), 0.1)
    found = {
        of: speed_share(SpeedBlur(speed_of=of, moving=MOVING), walk)
        for of in ("head", "avatar", "both")
    }
    assert found == pytest.approx({"head": 0.0, "avatar": 0.5, "both": 0.5})


@given(st.floats(0.01, 40))
def test_weights_sum_to_one_and_have_the_width(sigma):
    weights = gaussian_weights(sigma)
    offset = np.arange(len(weights)) - len(weights) // 2
    assert weights.sum() == pytest.approx(1)
    if sigma > 1:
        assert np.sqrt(np.sum(weights * offset**2)) == pytest.approx(sigma, rel=0.03)


def test_an_angle_is_as_many_pixels_as_the_lens_says():
    assert sigma_px(60.0, 1000.0) == pytest.approx(17.455, abs=1e-3)


def blurred(ctx, rgb, step=FULL, fov=None, **settings):
    size_px = rgb.shape[1], rgb.shape[0]
    colour, _ = textures(ctx, rgb, 1.0)
    wanted = SpeedBlur(moving=MOVING, **settings)
    effect = SpeedBlurPass(EffectInputs(ctx, wanted, colour))
    effect.render(seen(fov or square_pixels(size_px), step=step))
    return rgb_of(effect.target)


def test_a_point_becomes_the_twins_gaussian(ctx):
    """Wide pixels: the focal lengths differ, so do the two sigmas; the angle is the same."""
    rgb = np.zeros((41, 51, 3))
    rgb[20, 25] = 1
    fov = Fov(-0.4, 0.4, 0.5, -0.5)
    found = blurred(ctx, rgb, fov=fov, max_sigma_arcmin=120).astype(float)[..., 0]
    x, y = (gaussian_weights(sigma_px(120, f)) for f in focal_length_px(fov, (51, 41)))
    expected = np.zeros((41, 51))
    half_x, half_y = len(x) // 2, len(y) // 2
    expected[20 - half_y : 21 + half_y, 25 - half_x : 26 + half_x] = np.outer(y, x)
    assert half_x != half_y
    np.testing.assert_allclose(found, expected, atol=2e-4)


@pytest.mark.parametrize("step", [None, HeadStep(*[Pose()] * 4, 1 / 90)], ids=["cut", "rest"])
def test_at_rest_the_copy_is_exact(ctx, step):
    rgb = np.exp(np.random.default_rng(4).uniform(-9, 11, (37, 61, 3))).astype("f2")
    np.testing.assert_array_equal(blurred(ctx, rgb, step).view("i2"), rgb.view("i2"))


def test_a_constant_image_stays_constant(ctx):
    rgb = np.tile(np.array([0.3, 1.7, 900.0], "f2"), (33, 47, 1))
    found = blurred(ctx, rgb, max_sigma_arcmin=120)
    assert np.abs(found.view("i2").astype(int) - rgb.view("i2")).max() <= 1


@pytest.mark.parametrize("size_px", [(1, 1), (7, 5), (131, 67)])
@pytest.mark.parametrize("sigma_arcmin", [1e-3, 3.0, 120.0])
def test_extremes_stay_finite_and_within_their_range(ctx, size_px, sigma_arcmin):
    rng = np.random.default_rng(3)
    rgb = np.exp2(rng.uniform(-20, 15.99, (size_px[1], size_px[0], 3)))
    rgb[rng.random(rgb.shape[:2]) < 0.3] = 65504
    found = blurred(ctx, rgb, max_sigma_arcmin=sigma_arcmin)
    assert np.isfinite(found).all()
    assert found.min() >= 0
    assert found.max() <= 65504
