"""Hairlines, beads and flicker: counted where they are, and only there."""

import numpy as np
import pytest

from vrcomfort.tradeoff.error_measures import flicker, high_pass, off_median

SIZE = 80


def grey(value=0.5):
    return np.full((SIZE, SIZE, 3), value)


def test_an_even_error_has_nothing_fine_and_a_hairline_has():
    assert np.abs(high_pass(grey(0.2))).max() == pytest.approx(0)
    line = grey(0.0)
    line[:, 40] = 1.0
    # What a Gaussian of 1 px leaves of a line: 1 less its middle weight.
    assert high_pass(line)[40, 40, 0] == pytest.approx(1 - 1 / (2 * np.pi) ** 0.5, abs=1e-3)


def test_single_pixels_are_counted_by_how_far_they_are_off():
    shown, radius = grey(), np.full((SIZE, SIZE), 11.0)
    shown[30, 30] += 3 / 255
    shown[50, 50] -= 5 / 255
    shown[60, 60] += 1 / 255
    found = off_median(shown, radius)
    assert found == (SIZE * SIZE, 2, 1)
    assert off_median(shown, radius, (slice(45, 70), slice(45, 70))) == (25 * 25, 1, 1)


def test_a_hairline_is_off_its_median_and_an_edge_is_not():
    radius = np.full((SIZE, SIZE), 20.0)
    line, edge = grey(), grey()
    line[:, 40] += 0.1
    edge[:, 40:] += 0.1
    assert off_median(line, radius).over_4 == SIZE
    assert off_median(edge, radius).over_2 == 0


def test_only_wide_blur_is_looked_at():
    shown, radius = grey(), np.full((SIZE, SIZE), 11.0)
    shown[30, 30] += 0.1
    radius[40, 40] = 9.0  # within 20 px of the pixel
    found = off_median(shown, radius)
    assert (found.wide_px, found.over_2) == (SIZE * SIZE - 41 * 41, 0)
    assert off_median(shown, -np.full((SIZE, SIZE), 11.0)).over_4 == 1


def test_flicker_is_what_changes():
    assert not flicker(grey(0.3), grey(0.3)).any()
    np.testing.assert_allclose(flicker(grey(0.1), grey(0.4)), 0.3)
