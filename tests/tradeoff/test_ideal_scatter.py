"""The ideal scatter against images that can be worked out by hand."""

import numpy as np
import pytest

from vrcomfort.optics.lens_sampling import lens_and_shutter
from vrcomfort.tradeoff.references import Pinhole, ideal_scatter

LENS = lens_and_shutter(1024, lens=True, shutter=False, seed=1)
SHUTTER = lens_and_shutter(512, lens=False, shutter=True, seed=1)


def flat(image, depth=0.01, radius=0.0, streak=(0.0, 0.0)):
    shape = image.shape[:2]
    return Pinhole(
        image,
        np.broadcast_to(np.float32(depth), shape),
        np.broadcast_to(np.asarray(radius, float), shape),
        np.broadcast_to(streak, (*shape, 2)),
    )


def half_plane(width=48, height=32):
    image = np.zeros((height, width, 3))
    image[:, : width // 2] = 1
    return image


@pytest.mark.slow
def test_a_point_becomes_an_even_disc():
    image = np.zeros((31, 31, 3))
    image[15, 15] = 1
    found = ideal_scatter(flat(image, radius=6.0), LENS)[..., 0]
    y, x = np.mgrid[:31, :31] - 15
    inside, outside = np.hypot(x, y) < 5, np.hypot(x, y) > 7
    np.testing.assert_allclose(found[inside], 1 / (np.pi * 36), rtol=0.35)
    assert np.mean(found[inside]) == pytest.approx(1 / (np.pi * 36), rel=0.02)
    assert not found[outside].any()
    assert found.sum() == pytest.approx(1, rel=0.01)


@pytest.mark.slow
def test_an_edge_is_the_disc_integral():
    found = ideal_scatter(flat(half_plane(), radius=5.0), LENS)[16, :, 0]
    x = np.clip((np.arange(48) - 23.5) / 5, -1, 1)
    covered = 0.5 - (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
    assert np.sqrt(np.mean((found - covered) ** 2)) < 0.005


def test_a_moving_edge_is_a_ramp():
    found = ideal_scatter(flat(half_plane(), streak=(8.0, 0.0)), SHUTTER)[16, :, 0]
    ramp = np.clip(0.5 - (np.arange(48) - 23.5) / 8, 0, 1)
    np.testing.assert_allclose(found, ramp, atol=0.01)


def test_a_point_that_moves_leaves_its_trace_along_its_way():
    image = np.zeros((15, 15, 3))
    image[7, 7] = 1
    found = ideal_scatter(flat(image, streak=(8.0, 8.0)), SHUTTER)[..., 0]
    y, x = np.nonzero(found)
    assert (np.abs(y - x) <= 1).all()
    assert (x.min(), x.max()) == (y.min(), y.max()) == (3, 11)


def test_in_focus_and_at_rest_nothing_changes():
    image = np.random.default_rng(0).random((9, 7, 3))
    np.testing.assert_allclose(ideal_scatter(flat(image), LENS[:8]), image, rtol=1e-12)


@pytest.mark.slow
def test_a_sharp_front_hides_a_blurred_back():
    """The white wall behind is out of focus, the black one before it is not: no light leaks."""
    image = half_plane()
    depth = np.where(image[..., 0] > 0, 0.01, 0.1)
    radius = np.where(image[..., 0] > 0, 5.0, 0.0)
    found = ideal_scatter(flat(image, depth, radius), LENS)
    assert not found[:, 24:].any()


@pytest.mark.slow
def test_a_blurred_front_spreads_over_a_sharp_back():
    image = half_plane()
    depth = np.where(image[..., 0] > 0, 0.1, 0.01)
    radius = np.where(image[..., 0] > 0, -5.0, 0.0)
    found = ideal_scatter(flat(image, depth, radius), LENS)[16, :, 0]
    x = np.clip((np.arange(48) - 23.5) / 5, -1, 1)
    covered = 0.5 - (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
    np.testing.assert_allclose(found, covered, atol=0.02)


@pytest.mark.slow
def test_what_was_hidden_continues_what_is_beside_it():
    """A blurred white post before a sharp black wall: the wall goes on behind it."""
    image = np.zeros((24, 48, 3))
    image[:, 20:30] = 1
    depth = np.where(image[..., 0] > 0, 0.1, 0.01)
    radius = np.where(image[..., 0] > 0, -4.0, 0.0)
    found = ideal_scatter(flat(image, depth, radius), LENS)[12, :, 0]
    x = np.arange(48) - 24.5
    edges = [np.clip((x + side) / 4, -1, 1) for side in (5, -5)]
    covered = [0.5 + (e * np.sqrt(1 - e**2) + np.arcsin(e)) / np.pi for e in edges]
    np.testing.assert_allclose(found, covered[0] - covered[1], atol=0.02)


def test_an_image_that_moves_away_altogether_still_shows_something():
    image = np.full((5, 4, 3), 0.25)
    found = ideal_scatter(flat(image, radius=50.0), [[1.0, 0.0, 0.0]])
    np.testing.assert_array_equal(found, image)


def test_a_slanted_wall_does_not_tear():
    """A near wall whose radius changes by half a pixel from pixel to pixel hides what is behind."""
    image = np.zeros((24, 48, 3))
    image[:, :8] = 1
    depth = np.where(np.arange(48) < 8, 0.001, 0.1) * np.ones((24, 1))
    radius = np.where(np.arange(48) < 8, 12.0, 0.5 * (np.arange(48) - 8.0)) * np.ones((24, 1))
    found = ideal_scatter(flat(image, depth, radius), LENS[:256])
    assert not found[:, 10:, 0].any()
    y, x = np.mgrid[:12, :12]  # slanted both ways, seen from one corner of the lens
    wall = (x < 8) & (y < 8)
    image = np.where(wall, 0.0, 1.0)[..., None] * np.ones(3)
    slanted = flat(image, np.where(wall, 0.1, 0.001), np.where(wall, 0.5 * (x + y), 0.0))
    found = ideal_scatter(slanted, [[0.7, 0.7, 0.0]])[..., 0]
    assert not found[3, 8]
    assert not found[7, 9]


def test_longer_sample_lists_begin_with_shorter_ones():
    for lens, shutter in ((True, True), (True, False), (False, True)):
        long = lens_and_shutter(37, lens=lens, shutter=shutter, seed=5)
        short = lens_and_shutter(10, lens=lens, shutter=shutter, seed=5)
        np.testing.assert_array_equal(long[:10], short)
        assert np.all(np.hypot(long[:, 0], long[:, 1]) <= 1 + 1e-12)
        assert np.all(np.abs(long[:, 2]) <= 0.5)
        assert bool(long[:, :2].any()) is lens
        assert bool(long[:, 2].any()) is shutter
