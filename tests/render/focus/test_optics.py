"""Rays and what is estimated from them, as mathematics."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.focus import estimate_focus, gaze_focus, ray_directions
from vrcomfort.geometry import Pose, yaw_pitch_roll
from vrcomfort.optics.focus import GAZE_RING, gaze_tangents
from vrcomfort.protocol.conditions import Focus

means = st.sampled_from(["metres", "dioptres"])
distances = st.floats(0.05, 30_000.0)


def test_rays_are_a_centre_and_a_ring_of_eight():
    rays = ray_directions(2.0)
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    np.testing.assert_allclose(unit[0], [0, 0, -1])
    np.testing.assert_allclose(np.degrees(np.arccos(unit[1:] @ unit[0])), 2.0)
    around = np.degrees(np.arctan2(unit[1:, 1], unit[1:, 0])) % 360
    np.testing.assert_allclose(around, np.arange(8) * 45.0, atol=1e-9)


@given(distances, means)
def test_nine_equal_rays_keep_all_nine(distance, mean):
    raw, used = estimate_focus(np.full(9, distance), Focus(mean=mean))
    assert used.all()
    assert raw == pytest.approx(distance, rel=1e-12)


@given(st.lists(st.floats(0.2, 20.0), min_size=1, max_size=1), st.integers(0, 8), means)
def test_one_ray_to_the_sky_among_near_ones_is_dropped(near, ray, mean):
    distances = np.repeat(near, 9) * np.linspace(0.99, 1.01, 9)
    distances[ray] = np.inf
    raw, used = estimate_focus(distances, Focus(mean=mean))
    assert not used[ray]
    assert used.sum() >= 7
    assert 0.98 * near[0] <= raw <= 1.02 * near[0]


@given(means, st.floats(1.0, 1e6))
def test_all_sky_is_infinity(mean, infinity):
    raw, used = estimate_focus(np.full(9, np.inf), Focus(mean=mean, infinity_m=infinity))
    assert used.all()
    assert raw == pytest.approx(infinity, rel=1e-12)


@given(st.lists(distances, min_size=9, max_size=9), means)
def test_the_estimate_lies_within_the_rays_it_used(rays, mean):
    raw, used = estimate_focus(rays, Focus(mean=mean))
    assert used.sum() >= 5  # never fewer than the nearer half
    kept = np.array(rays)[used]
    assert kept.min() * (1 - 1e-12) <= raw <= kept.max() * (1 + 1e-12)


@given(st.lists(distances, min_size=9, max_size=9), st.permutations(range(9)), means)
def test_the_order_of_the_rays_does_not_matter(rays, order, mean):
    raw, used = estimate_focus(rays, Focus(mean=mean))
    again, used_again = estimate_focus(np.array(rays)[order], Focus(mean=mean))
    assert used_again.tolist() == used[list(order)].tolist()
    assert again == pytest.approx(raw, rel=1e-12)


def test_an_outlier_by_hand():
    # Median 2, deviations 0, 0.1 (×4), 0.2 (×3), 3: MAD 0.1, limit 3 · 0.14826 = 0.445.
    rays = [2.0, 1.9, 1.9, 2.1, 2.1, 1.8, 1.8, 2.2, 5.0]
    raw, used = estimate_focus(rays, Focus())
    assert used.tolist() == [True] * 8 + [False]
    assert raw == pytest.approx(np.mean(rays[:8]))


def test_the_mean_in_dioptres_is_harmonic():
    settings = Focus(mean="dioptres", outlier_mad=100.0)
    raw, _ = estimate_focus(np.repeat([1.0, 2.0, 4.0], 3), settings)
    assert raw == pytest.approx(9 / (3 + 3 / 2 + 3 / 4))


@given(st.floats(-1.0, 1.0), st.floats(-0.8, 0.8), st.floats(-3.0, 3.0), st.floats(0.0, 5.0))
def test_rays_around_a_line_of_sight_share_its_neighbourhood(yaw, pitch, roll, radius_deg):
    gaze = Pose(np.zeros(3), yaw_pitch_roll(yaw, pitch, roll))
    tangents = gaze_tangents(gaze, radius_deg)
    rays = np.concatenate([tangents, -np.ones((9, 1))], axis=1)
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    np.testing.assert_allclose(unit[0], gaze.forward, atol=1e-12)
    across = np.linalg.norm(np.cross(unit[1:], unit[0]), axis=1)
    np.testing.assert_allclose(across, np.sin(np.radians(GAZE_RING * radius_deg)), atol=2e-4)


def test_nobody_looks_at_right_angles_to_the_head():
    for yaw_deg, there in ((80.0, True), (86.0, False), (95.0, False), (180.0, False)):
        gaze = Pose(np.zeros(3), yaw_pitch_roll(np.radians(yaw_deg), 0, 0))
        assert (gaze_tangents(gaze, 1.5) is not None) is there


@given(st.lists(st.floats(0.05, 3e4), min_size=9, max_size=9))
def test_the_gaze_is_at_a_distance_that_is_there(distances_m):
    focus_m, used = gaze_focus(distances_m, 3e4)
    assert focus_m in distances_m
    assert (np.array(distances_m)[used] == focus_m).all()


def test_a_thin_thing_near_the_gaze_does_not_take_the_focus():
    distances_m = [0.5, 4.0, 4.0, 4.1, 0.5, 3.9, 4.0, np.inf, 0.5]
    assert gaze_focus(distances_m, 3e4)[0] == 4.0
