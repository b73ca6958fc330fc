"""Patterns of few bilinear reads against discs, in float64."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles import pyramid
from tests.oracles.taps import extent_px, fade
from vrcomfort.optics import taps


@pytest.mark.parametrize("count", [4, 6, 9, 10, 12, 16, 64])
def test_taps_have_the_mean_and_the_variance_of_the_disc(count):
    offsets = taps.tap_offsets(count)
    assert offsets.shape == (count, 2)
    np.testing.assert_allclose(offsets.mean(axis=0), 0, atol=1e-9)
    np.testing.assert_allclose(offsets.T @ offsets / count, np.eye(2) / 4, atol=1e-9)


def test_bilinear_reads_have_the_variance_that_is_taken_off_the_taps():
    """A tent read at every place between texels: x(1 − x) has the mean 1/6."""
    between = (np.arange(1000) + 0.5) / 1000
    read = np.mean(between * (1 - between))
    assert taps.read_variance_px2(1, 1) == pytest.approx(read, rel=1e-4)
    quarter = np.var(np.arange(4)) + 16 * read + 4 * read
    assert taps.read_variance_px2(4, 2) == pytest.approx(quarter, rel=1e-4)


@given(
    st.sampled_from([(6, 1), (8, 1), (12, 1), (24, 1), (8, 2), (16, 2), (32, 2)]),
    st.floats(0.0, 20.0),
)
def test_reads_from_the_middles_of_texels_are_as_wide_as_the_disc(pattern, radius_px):
    """Each read is two texels: their mean square distance, averaged over the taps."""
    count, texel_px = pattern
    law = taps.spread(count, texel_px, texel_px)
    # As wide left of the middle as right of it, where rounding leaves the last digits.
    places = np.abs(extent_px(radius_px, law) / texel_px * taps.tap_offsets(count))
    below = np.floor(places)
    part = places - below
    read = np.mean((1 - part) * below**2 + part * (below + 1) ** 2) * texel_px**2
    own = law.near_px2 / 4
    assert max(radius_px, 2 * own**0.5) / 2 == pytest.approx((read + own) ** 0.5, rel=0.06)


def test_the_pattern_grows_with_the_disc_and_without_a_jump():
    radius_px = np.linspace(0, 8, 2001)
    for pattern in ((6, 1, 1), (16, 1, 1), (16, 2, 2), (16, 4, 2)):
        found_px = extent_px(radius_px, taps.spread(*pattern))
        assert found_px[0] == 0
        assert np.all(np.diff(found_px) >= 0)
        # Where reads count in full, the root of a difference starts steeply.
        assert np.diff(found_px).max() < 0.2


def test_a_cross_fade_of_half_the_image_is_as_wide_as_the_disc():
    """Nothing up to 0.5 px; from there to 2 px linear in variance, as the pyramid's levels are."""
    radius_px = np.linspace(0, 3, 301)
    opacity = fade(radius_px)
    assert np.all(opacity[radius_px <= 0.5] == 0)
    assert np.all(opacity[radius_px >= 2] == 1)
    np.testing.assert_allclose(opacity, pyramid.fade(radius_px, 1), atol=0.07)
