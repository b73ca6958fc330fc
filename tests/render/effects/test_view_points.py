"""Where the views through a lens are, and how much each is blurred: no OpenGL."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vrcomfort.geometry import Array
from vrcomfort.optics.lens_sampling import (
    FEW,
    FEW_RADIUS,
    OVERLAP,
    WIDEST_OF_MANY,
    disc_edge,
    edge_error,
    view_points,
    view_radius,
    with_moments,
)


@pytest.mark.slow
@settings(max_examples=40)
@given(st.integers(3, 256), st.floats(0, 1.5))
def test_points_and_blur_have_the_moments_of_the_lens(count, over_blur):
    radius = view_radius(count, over_blur)
    points = view_points(count, radius)
    assert points.shape == (count, 2)
    np.testing.assert_allclose(points.mean(axis=0), 0, atol=1e-12)
    moments = points.T @ points / count + np.eye(2) * radius**2 / 4
    np.testing.assert_allclose(moments, np.eye(2) / 4, atol=1e-9)
    assert np.hypot(*points.T).max() < 1.1


def test_two_views_have_the_middle_of_the_lens_and_its_width_along_their_line():
    radius = view_radius(2)
    points = view_points(2, radius)
    np.testing.assert_allclose(points[0], -points[1])
    assert points[0] @ points[0] + radius**2 / 4 == pytest.approx(0.25)


def test_one_view_is_the_pinhole_blurred_over_the_lens():
    np.testing.assert_array_equal(view_points(1, 1.0), [[0, 0]])
    assert view_radius(1, 0.5) == 1.0


def test_the_blur_of_a_view_falls_with_their_number_and_is_at_most_the_lens():
    radii = [view_radius(count) for count in range(1, 257)]
    assert np.all(np.diff(radii) <= 0)
    assert radii[2] == FEW_RADIUS
    many = OVERLAP / np.sqrt(np.arange(FEW, 257))
    np.testing.assert_allclose(radii[FEW - 1 :], np.minimum(many, WIDEST_OF_MANY))
    assert view_radius(16, 0.5) == OVERLAP / 8
    assert view_radius(4, 4.0) == 1.0


@pytest.mark.parametrize("away", [-1.0, -0.4, 0.0, 0.7, 1.0])
def test_the_edge_of_a_disc_is_its_area(away):
    x = np.linspace(-1, 1, 200_001)
    area = np.mean(np.sqrt(1 - x**2) * (x <= away)) * 2 * 2 / np.pi
    assert disc_edge(away) == pytest.approx(area, abs=1e-4)


def test_a_lens_makes_no_error_and_a_pinhole_a_large_one():
    assert edge_error(np.zeros((1, 2)), 1.0) == 0.0
    beyond = np.linspace(0, 1.2, 10_001)
    step = np.sqrt(np.mean(disc_edge(-beyond) ** 2))
    assert edge_error(np.zeros((1, 2)), 0.0) == pytest.approx(step, rel=0.05)


def test_more_views_make_less_error_at_an_edge():
    counts = (16, 32, 64, 128, 256)
    errors = [edge_error(view_points(n, view_radius(n)), view_radius(n)) for n in counts]
    assert np.all(np.diff(errors) < 0), errors
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope < -0.55


def sunflower(count: int) -> Array:
    """Return (count, 2) points spread over the unit disc, with its mean and second moments.

    Notes
    -----
    Vogel, "A better way to construct the sunflower head", 1979. Against these, the same count of R2
    points through `concentric_disc` has 3 to 6 times the error at an edge, because their moments
    are off.
    """
    index = np.arange(count)
    angle = index * np.pi * (3 - math.sqrt(5))
    radius = np.sqrt((index + 0.5) / count)
    return with_moments(radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1))


@pytest.mark.parametrize("count", [16, 64, 256])
def test_rings_make_two_thirds_of_the_error_of_a_sunflower_of_the_same_moments(count):
    radius = view_radius(count)
    flower = sunflower(count) * np.sqrt(1 - radius**2)
    assert edge_error(view_points(count, radius), radius) < 0.67 * edge_error(flower, radius)


@pytest.mark.parametrize("count", [2, 4, 5, 6, 7])
def test_no_two_points_of_a_ring_share_a_row_or_column(count):
    """Edges of rooms lie along rows and columns: each point counts for such an edge."""
    points = view_points(count, 0.5)
    on_ring = points[np.hypot(*points.T) > 1e-9]
    for axis in (0, 1):
        assert np.diff(np.sort(on_ring[:, axis])).min() > 0.05
