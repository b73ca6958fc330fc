"""The focus estimate and the refocus laws, as mathematics."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from vrcomfort.optics.focus import estimate_focus, ray_directions, refocus
from vrcomfort.protocol.conditions import Focus

means = st.sampled_from(["metres", "dioptres"])
laws = st.sampled_from(["linear", "linear_dioptre", "instant"])
distances = st.floats(0.05, 30_000.0)
times = st.floats(0.0, 1.0)


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


@given(distances, distances, times, times, laws)
def test_two_steps_are_one_step_of_their_summed_time(start, target, first, second, law):
    settings = Focus(law=law)
    middle = refocus(start, target, first, settings)
    twice = refocus(middle, target, second, settings)
    assert 1 / twice == pytest.approx(
        1 / refocus(start, target, first + second, settings), abs=1e-9
    )


@given(distances, distances, times, laws)
def test_refocusing_never_passes_its_target_nor_turns_away(start, target, dt, law):
    focus = refocus(start, target, dt, Focus(law=law))
    tolerance = 1e-12 * max(start, target)
    assert min(start, target) - tolerance <= focus <= max(start, target) + tolerance


@given(distances, distances, laws)
def test_focus_arrives_and_stays(start, target, law):
    settings = Focus(law=law)
    assert refocus(target, target, 0.01, settings) == pytest.approx(target, rel=1e-15)
    assert refocus(start, target, 1e3, settings) == pytest.approx(target, rel=1e-15)


@given(distances, distances, st.sampled_from(["linear", "linear_dioptre"]))
def test_no_time_means_no_change(start, target, law):
    assume(start != target)
    assert refocus(start, target, 0.0, Focus(law=law)) == pytest.approx(start, rel=1e-15)


def test_the_papers_law_takes_half_a_second_from_the_sky():
    settings = Focus()
    assert refocus(30_000.0, 1.0, 0.25, settings) == pytest.approx(15_000.0)
    assert refocus(30_000.0, 1.0, 0.5, settings) == 1.0
    # 10 m to 1 m at 60 km/s is done in 0.15 ms.
    assert refocus(10.0, 1.0, 0.149e-3, settings) > 1.0
    assert refocus(10.0, 1.0, 0.151e-3, settings) == 1.0


def test_the_dioptre_law_takes_half_a_second_from_the_sky_to_one_metre():
    settings = Focus(law="linear_dioptre")
    assert refocus(30_000.0, 0.1, 0.5, settings) == pytest.approx(1.0, rel=1e-4)
    assert refocus(1.0, 0.1, 0.5, settings) == pytest.approx(0.5)
