"""Gaze and head motion against numbers worked out by hand, and SciPy."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import welch
from scipy.stats import sem, zscore

from vrcomfort.stats.gaze_and_head import (
    angles_deg,
    band_power,
    fixations,
    head_spectrum,
    saliency_map,
    steps_deg,
    unit_vectors,
    zone_holding,
    zone_ratios,
    zone_shares,
)
from vrcomfort.stats.means import z_scored


def looking(azimuth_deg, elevation_deg=0.0):
    """Return unit vectors at these angles."""
    return unit_vectors(*np.broadcast_arrays(np.asarray(azimuth_deg, float), elevation_deg))


def test_angles_are_those_of_the_direction():
    azimuth, elevation = angles_deg(looking([10.0, -170.0], [20.0, -5.0]))
    assert azimuth == pytest.approx([10, -170])
    assert elevation == pytest.approx([20, -5])
    assert steps_deg(looking([0.0, 3.0, 3.0])) == pytest.approx([3, 0])


def test_a_zone_of_ratio_one_half_is_half_as_high_and_wide_as_the_image():
    half = np.tile(np.tan(np.radians([45.0, 40.0])), (5, 1))
    at = np.degrees(np.arctan(0.5))
    up = np.degrees(np.arctan(0.25 * np.tan(np.radians(40))))
    ways = looking([0.0, at, 45.0, 0.0, 180.0], [0.0, 0.0, 0.0, up, 0.0])
    ratios = zone_ratios(ways, half)
    assert ratios == pytest.approx([0, 0.5, 1, 0.25, np.inf])
    seconds = np.array([1.0, 1.0, 2.0, 4.0, 2.0])
    assert zone_shares(ratios, seconds, (0.1, 0.3, 0.51, 1.01)) == pytest.approx(
        [0.1, 0.5, 0.6, 0.8]
    )


def test_a_zone_that_holds_a_share_is_the_smallest_one():
    ratios, seconds = np.array([0.4, 0.1, 0.2, 0.8]), np.array([1.0, 5.0, 2.0, 2.0])
    assert zone_holding(ratios, seconds, 0.5) == 0.1
    assert zone_holding(ratios, seconds, 0.7) == 0.2
    assert zone_holding(ratios, seconds, 0.75) == 0.4
    assert zone_holding(ratios, seconds, 0.9) == 0.8
    assert np.isnan(zone_holding(ratios[:0], seconds[:0], 0.5))


def as_published_by_dispersion(times, x, y, dispersion, duration_s):
    """Salvucci & Goldberg (2000), Figure 3: the I-DT algorithm, word by word."""
    points, found = list(range(len(times))), []
    while points:
        # "Initialize window over first points to cover the duration threshold"
        window = [points[0]]
        while times[window[-1]] - times[window[0]] < duration_s - 1e-9:
            if len(window) == len(points):
                return found
            window.append(points[len(window)])

        def wide(those):
            return np.ptp(x[those]) + np.ptp(y[those]) > dispersion

        if wide(window):
            points = points[1:]  # "Remove first point from points"
            continue
        while len(window) < len(points) and not wide([*window, points[len(window)]]):
            window.append(points[len(window)])
        found.append((window[0], window[-1]))  # "Note a fixation at the centroid of the window"
        points = points[len(window) :]
    return found


def as_published_by_velocity(times, x, threshold):
    """Salvucci & Goldberg (2000), Figure 1: the I-VT algorithm along a line."""
    slow = np.abs(np.diff(x)) / np.diff(times) < threshold
    groups, start = [], None
    for place, is_slow in enumerate([*slow, False]):
        if is_slow and start is None:
            start = place
        if not is_slow and start is not None:
            groups.append((start, place))
            start = None
    return groups


@pytest.mark.parametrize("seed", range(5))
def test_fixations_are_those_of_the_published_algorithms(seed):
    random = np.random.default_rng(seed)
    jumps = random.random(400) < 0.04
    x = np.cumsum(np.where(jumps, random.normal(0, 6, 400), random.normal(0, 0.08, 400)))
    times, valid = 0.01 * np.arange(400), np.ones(400, dtype=bool)
    ours = fixations(times, looking(x), valid, algorithm="i_dt", dispersion_deg=1.0)
    published = as_published_by_dispersion(times, x, np.zeros(400), 1.0, 0.1)
    assert len(ours) >= 10
    assert [(each.start_s, each.samples) for each in ours] == [
        (pytest.approx(times[a]), b - a + 1) for a, b in published
    ]
    ours = fixations(times, looking(x), valid, velocity_deg_s=30.0)
    published = [(a, b) for a, b in as_published_by_velocity(times, x, 30.0) if b - a >= 10]
    assert len(ours) > 5
    assert [(each.start_s, each.samples) for each in ours] == [
        (pytest.approx(times[a]), b - a + 1) for a, b in published
    ]


PERIOD_S = 0.01
STEADY = np.r_[np.zeros(30), np.linspace(0, 10, 7)[1:-1], np.full(25, 10.0)]
"""Azimuths: 0.3 s at 0°, a saccade of 10° in 60 ms, 0.25 s at 10°."""


@pytest.mark.parametrize("algorithm", ["i_vt", "i_dt"])
def test_two_fixations_and_a_saccade(algorithm):
    times = PERIOD_S * np.arange(len(STEADY))
    valid = np.ones(len(times), dtype=bool)
    one, two = fixations(times, looking(STEADY, 5.0), valid, algorithm=algorithm)
    assert (one.start_s, one.duration_s, one.samples) == pytest.approx((0, 0.29, 30))
    assert (two.start_s, two.duration_s, two.samples) == pytest.approx((0.35, 0.24, 25))
    assert (one.azimuth_deg, two.azimuth_deg) == pytest.approx((0, 10))
    assert two.elevation_deg == pytest.approx(5)


@pytest.mark.parametrize("algorithm", ["i_vt", "i_dt"])
def test_blinks_and_gaps_end_a_fixation_and_short_ones_are_none(algorithm):
    times = PERIOD_S * np.arange(60)
    times[45:] += 0.2
    valid = np.ones(60, dtype=bool)
    valid[20:25] = False
    found = fixations(times, looking(np.zeros(60)), valid, algorithm=algorithm)
    assert [each.samples for each in found] == [20, 20, 15]
    long = fixations(times, looking(np.zeros(60)), valid, algorithm=algorithm, shortest_s=0.18)
    assert [each.samples for each in long] == [20, 20]
    cuts = np.arange(60) == 33
    cut = fixations(times, looking(np.zeros(60)), valid, cuts=cuts, algorithm=algorithm)
    assert [each.samples for each in cut] == [20, 12, 15]  # 8 samples before it are too short


def test_thresholds_are_in_degrees():
    drift = 20.0 * PERIOD_S * np.arange(50)  # 20°/s
    times, valid = PERIOD_S * np.arange(50), np.ones(50, dtype=bool)
    assert len(fixations(times, looking(drift), valid, velocity_deg_s=21)) == 1
    assert fixations(times, looking(drift), valid, velocity_deg_s=19) == []
    # 2.2° in 0.11 s: eleven steps of 0.2°
    wide = fixations(times, looking(drift), valid, algorithm="i_dt", dispersion_deg=2.21)
    assert wide[0].samples == 12
    assert fixations(times, looking(drift), valid, algorithm="i_dt", dispersion_deg=1.9) == []
    high = looking(drift, 60.0)  # azimuths are half as wide there
    assert fixations(times, high, valid, algorithm="i_dt", dispersion_deg=1.9)[0].samples >= 18


def test_a_map_has_the_time_where_the_gaze_was():
    ways = looking([0.5, 10.5, 70.0], [0.5, -5.5, 0.0])
    found = saliency_map(ways, np.array([3.0, 1.0, 1.0]), half_extent_deg=(20, 15), sigma_deg=0.5)
    assert found.share.shape == (30, 40)
    assert found.share.sum() + found.outside == pytest.approx(1)
    assert found.outside == pytest.approx(0.2)
    row, column = np.unravel_index(found.share.argmax(), found.share.shape)
    assert (found.elevation_deg[row], found.azimuth_deg[column]) == (0.5, 0.5)
    turned = saliency_map(
        looking([175.5]), np.ones(1), centre_deg=-179.0, half_extent_deg=(20, 15), sigma_deg=0.5
    )
    assert turned.azimuth_deg[turned.share.sum(axis=0).argmax()] == -5.5
    right = found.azimuth_deg > 6
    assert found.share[:, right].sum() == pytest.approx(0.2)


def test_z_scores_are_scipys_within_each_person():
    random = np.random.default_rng(3)
    values = random.normal(size=(6, 4)) * np.arange(1, 7)[:, None]
    people = [f"P{i}" for i in range(6) for _ in range(4)] + ["P9", "P9"]
    conditions = [*"abcd" * 6, "a", "b"]
    found = z_scored(people, conditions, [*values.ravel(), 5.0, 5.0])
    expected = zscore(values, axis=1, ddof=1)
    for place, name in enumerate("abcd"):
        assert found[name].mean == pytest.approx(expected[:, place].mean())
        assert found[name].standard_error == pytest.approx(sem(expected[:, place]))
        assert (found[name].n, found[name].people) == (6, 6)
        assert found[name].standard_error_of_people == pytest.approx(sem(expected[:, place]))


def test_values_of_one_person_share_an_error_over_people():
    # z of P1: −1, 1, … in pairs: −.866, .866, −.866, .866; of P2 the same for twice the values
    values, conditions = [1.0, 3.0, 1.0, 3.0] * 2, [*"aabb"] * 2
    found = z_scored([*["P1"] * 4, *["P2"] * 4], conditions, values)
    assert (found["a"].n, found["a"].people) == (4, 2)
    assert found["a"].standard_error == pytest.approx(sem([-(0.75**0.5), 0.75**0.5] * 2))
    assert found["a"].standard_error_of_people == pytest.approx(0)


def test_bands_that_meet_add_up_to_the_variance():
    times, values = moved(60)
    found = head_spectrum(times, values, times < 0, period_s=1 / RATE_HZ)
    assert found is not None
    edges = [0.0, 0.5, 1.3, 2.0, RATE_HZ / 2 + 1]
    parts = [float(band_power(found, low, high)) for low, high in pairwise(edges)]
    step = found.frequency_hz[1]
    assert sum(parts) == pytest.approx(step * found.density.sum() - step / 2 * found.density[0])
    assert sum(parts) == pytest.approx(values.var(), rel=0.02)


RATE_HZ = 72.0


def moved(seconds: float, seed: int = 1):
    times = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    noise = 0.001 * np.random.default_rng(seed).normal(size=len(times))
    return times, 0.02 * np.sin(2 * np.pi * 1.25 * times) + noise


def test_a_spectrum_without_dropped_frames_is_scipys():
    times, values = moved(60)
    found = head_spectrum(times, values, times < 0, period_s=1 / RATE_HZ)
    frequency, density = welch(values, fs=RATE_HZ, nperseg=288)
    assert found is not None
    assert found.frequency_hz == pytest.approx(frequency)
    assert found.density == pytest.approx(density, rel=1e-6)
    assert (found.filled, found.left_out) == (0, 0)
    assert found.windows == 29
    # A sine of amplitude 0.02 has a power of 0.0002.
    assert band_power(found, 0.5, 2.0) == pytest.approx(0.0002, rel=0.02)


def test_dropped_frames_are_filled_and_long_gaps_are_not():
    times, values = moved(60)
    kept = np.random.default_rng(2).random(len(times)) > 0.1
    kept[[0, -1]] = True
    kept[1500:1800] = False  # 4 s in which nothing was recorded
    found = head_spectrum(times[kept], values[kept], times[kept] < 0, period_s=1 / RATE_HZ)
    assert found is not None
    assert found.filled == pytest.approx(1 - kept.sum() / (len(times) - 300), abs=1e-3)
    assert band_power(found, 0.5, 2.0) == pytest.approx(0.0002, rel=0.05)
    cut = np.zeros(len(times), dtype=bool)
    cut[::200] = True  # no stretch is as long as a window
    assert head_spectrum(times, values, cut, period_s=1 / RATE_HZ) is None


def test_columns_have_a_spectrum_each():
    times, values = moved(20)
    both = head_spectrum(times, np.column_stack([values, 2 * values]), times < 0, period_s=1 / 72)
    assert both is not None
    assert both.density[:, 1] == pytest.approx(4 * both.density[:, 0])
