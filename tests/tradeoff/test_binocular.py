"""Binocular errors on pairs of images whose disparity is known."""

import numpy as np
import pytest

from vrcomfort.geometry import Fov, Pose, axis_angle
from vrcomfort.tradeoff.error_measures import (
    EyeDepth,
    binocular_error,
    correspondence,
    radius_mismatch_px,
)

SIZE_PX = (96, 48)
FOV = Fov(*np.arctan([-1.0, 1.0, 0.5, -0.5]))  # focal length 48 px both ways
NEAR_M = 0.1
IPD_M = 0.0625


def eyes(distance_m, **turned):
    """Return both eyes in front of a wall: its disparity is 3 m / distance in pixels."""
    depth = np.full(SIZE_PX[::-1], NEAR_M / np.broadcast_to(distance_m, SIZE_PX[::-1]))
    half = np.array([IPD_M / 2, 0, 0])
    return (
        EyeDepth(Pose(-half, **turned), FOV, depth, NEAR_M),
        EyeDepth(Pose(half, **turned), FOV, depth, NEAR_M),
    )


def noise(seed=0):
    return np.random.default_rng(seed).normal(size=(*SIZE_PX[::-1], 3))


def surface_anchored(image, disparity_px):
    """Return what the right eye has of an error that sits on the wall."""
    return np.roll(image, -disparity_px, axis=1)


def test_a_wall_moves_left_by_focal_length_times_ipd_over_distance():
    pairs = correspondence(*eyes(0.5))
    np.testing.assert_allclose(pairs.left - pairs.right, [[6, 0]] * len(pairs.left), atol=1e-9)
    assert len(pairs.left) == (96 - 6) * 48, "what is outside the right image is left out"


def test_turning_the_head_changes_nothing():
    pairs = correspondence(*eyes(0.5, orientation=axis_angle([0, 0, 1], 0.3)))
    there = Pose(orientation=axis_angle([0, 0, 1], 0.3))
    assert len(pairs.left)
    straight = correspondence(*(eye._replace(pose=there @ eye.pose) for eye in eyes(0.5)))
    np.testing.assert_allclose(
        straight.left - straight.right, [[6, 0]] * len(straight.left), atol=1e-9
    )


def test_the_sky_has_no_disparity():
    left, right = (eye._replace(depth=np.zeros(SIZE_PX[::-1])) for eye in eyes(1.0))
    pairs = correspondence(left, right)
    np.testing.assert_allclose(pairs.left, pairs.right, atol=1e-12)


def test_what_only_one_eye_sees_is_left_out():
    """A post of 10 px at 0.5 m before a wall at 3 m: beside it each eye sees other wall."""
    left, right = eyes(3.0)
    post = [eye.depth.copy() for eye in (left, right)]
    post[0][:, 40:50] = post[1][:, 34:44] = NEAR_M / 0.5
    pairs = correspondence(left._replace(depth=post[0]), right._replace(depth=post[1]))
    seen = set(pairs.left[:, 0])
    assert set(range(40, 50)) <= seen
    # The right eye's post hides what the left eye sees at 35 to 44 (disparity 1 px); the left
    # eye's own post covers 40 to 49 of it.
    assert not seen & set(range(36, 40))


def test_noise_on_the_screen_is_a_shower_door():
    image = noise()
    found = binocular_error(correspondence(*eyes(0.5)), image, image)
    assert found.shower_door == pytest.approx(1.0, abs=0.03)
    assert found.rivalry == pytest.approx(2 / np.sqrt(np.pi), rel=0.03)


def test_noise_on_the_surface_is_none():
    image = noise()
    right = surface_anchored(image, 6)
    found = binocular_error(correspondence(*eyes(0.5)), image, right)
    assert found.shower_door == pytest.approx(-1.0, abs=0.03)
    assert found.rivalry == 0


def test_no_error_is_no_binocular_error():
    zero = np.zeros((*SIZE_PX[::-1], 3))
    assert binocular_error(correspondence(*eyes(0.5)), zero, zero) == (0.0, 0.0)


def test_nothing_seen_by_both_is_not_a_number():
    pairs = correspondence(*eyes(0.5), margin_px=24)
    assert not len(pairs.left)
    assert np.isnan(binocular_error(pairs, noise(), noise()).rivalry)
    assert np.isnan(radius_mismatch_px(pairs, noise()[..., 0], noise()[..., 0]))


def test_radii_that_are_affine_on_the_image_are_compared_between_pixels():
    """At 0.8 m the disparity is 3.75 px; interpolating a ramp is exact."""
    pairs = correspondence(*eyes(0.8))
    ramp = np.broadcast_to(np.arange(96.0), SIZE_PX[::-1])
    assert radius_mismatch_px(pairs, ramp, ramp) == pytest.approx(3.75)
    assert radius_mismatch_px(pairs, ramp, ramp + 3.75) == pytest.approx(0, abs=1e-9)
