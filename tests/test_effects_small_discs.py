"""The small blur of each of many views: light that neighbours trade over the nearer one's disc."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.small_discs import share, trade
from tests.support.kernels import blur
from vrcomfort.optics.small_discs import grid_discs
from vrcomfort.optics.view_points import FEW

LIMIT_PX = 6.0
DISCS = grid_discs(LIMIT_PX)


@pytest.fixture
def rng():
    return np.random.default_rng(4)


def view(ctx, rgb, radius_px, **settings):
    return blur(ctx, "vrcomfort", rgb, radius_px, limit_px=LIMIT_PX, views=FEW, **settings)


@settings(max_examples=30)
@given(st.floats(0, LIMIT_PX))
def test_a_disc_on_the_grid_has_all_its_light_and_its_variance(radius_px):
    y, x = np.mgrid[-8:9, -8:9]
    part = share(np.hypot(x, y), radius_px, DISCS)
    part[8, 8] = 0.0
    variance = np.sum(part * x**2)
    assert np.all(part >= 0)
    assert part.sum() < 1
    # Between two entries of the table, which are a sixteenth of a pixel apart, it is not quite.
    assert variance == pytest.approx(radius_px**2 / 4, rel=0.03, abs=0.004)


@pytest.mark.parametrize("pixel_aspect", [1.0, 1.25])
def test_the_kernel_is_its_twin(ctx, rng, pixel_aspect):
    radius_px = rng.choice([-3.3, -0.4, 0.0, 0.6, 2.2, 2.3], size=(24, 40))
    rgb = rng.uniform(0, 4, size=(24, 40, 3))
    found = view(ctx, rgb, radius_px, pixel_aspect=pixel_aspect)
    np.testing.assert_allclose(found.rgb, trade(found.points, DISCS, pixel_aspect), atol=2**-9)


def test_a_constant_image_keeps_every_bit(ctx, rng):
    radius_px = rng.uniform(-LIMIT_PX, LIMIT_PX, size=(20, 30))
    found = view(ctx, np.full((20, 30, 3), 0.7), radius_px)
    np.testing.assert_array_equal(found.rgb, np.float16(0.7))


def test_what_is_in_focus_is_copied_bit_for_bit(ctx, rng):
    rgb = rng.uniform(0, 9, size=(17, 23, 3))
    found = view(ctx, rgb, 0.0, pixel_aspect=1.4)
    np.testing.assert_array_equal(found.rgb, rgb.astype(np.float16))


@pytest.mark.parametrize("radius_px", [0.3, 1.0, 3.0])
def test_a_lamp_keeps_its_light_and_gets_the_discs_variance(ctx, radius_px):
    rgb = np.zeros((31, 31, 3))
    rgb[15, 15] = 100.0
    spread = view(ctx, rgb, radius_px).rgb[..., 0].astype(float)
    x = np.arange(31) - 15
    assert spread.sum() == pytest.approx(100.0, rel=1e-3)
    assert np.sum(spread * x**2) / 100 == pytest.approx(radius_px**2 / 4, rel=0.03, abs=0.004)


def test_no_light_is_lost_where_surfaces_meet(ctx, rng):
    """Far from the rims of the image: a plate, a pole and a wall, each as blurred as it likes."""
    radius_px = np.full((48, 48), 2.5)
    radius_px[20:30, 12:30], radius_px[:, 24] = -1.5, 0.8
    rgb = np.zeros((48, 48, 3))
    rgb[10:-10, 10:-10] = rng.uniform(0, 8, size=(28, 28, 1))
    found = view(ctx, rgb, radius_px)
    assert found.rgb.sum() == pytest.approx(rgb.sum(), rel=1e-3)


def test_what_is_sharp_and_in_front_neither_leaks_nor_is_blurred(ctx):
    rgb = np.zeros((24, 24, 3))
    rgb[:, 12:] = 1.0
    for front in (slice(None, 12), slice(12, None)):
        radius_px = np.full((24, 24), 3.0)
        radius_px[:, front] = 0.0
        np.testing.assert_array_equal(view(ctx, rgb, radius_px).rgb, rgb)


@pytest.mark.parametrize("size_px", [(1, 1), (7, 5), (33, 17)])
def test_extremes_stay_within_the_image(ctx, rng, size_px):
    width, height = size_px
    rgb = 10 ** rng.uniform(-6, np.log10(65504), size=(height, width, 3))
    radius_px = rng.uniform(-LIMIT_PX, LIMIT_PX, size=(height, width))
    found = view(ctx, rgb, radius_px, pixel_aspect=1.5)
    given = found.points[..., :3]
    assert np.all(found.rgb >= given.min(axis=(0, 1)) * (1 - 2**-9))
    assert np.all(found.rgb <= given.max(axis=(0, 1)) * (1 + 2**-9))
