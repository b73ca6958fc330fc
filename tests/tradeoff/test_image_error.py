"""Errors of images: known differences give known numbers."""

import math

import numpy as np
import pytest

from vrcomfort.errors import InputError
from vrcomfort.geometry import Fov
from vrcomfort.tradeoff.image_error import (
    accuracy,
    hdr_flip,
    margin_px,
    pixels_per_degree,
    psnr_db,
    rms,
    ssim,
)


@pytest.fixture
def image():
    return np.random.default_rng(3).uniform(0, 4, (40, 50, 3))


def test_psnr_has_a_fixed_peak(image):
    assert rms(image + 0.1, image) == pytest.approx(0.1)
    assert psnr_db(image + 0.1, image) == pytest.approx(20)
    assert psnr_db(image * 100 + 0.1, image * 100) == pytest.approx(20)
    assert psnr_db(image + 0.1, image, peak=10.0) == pytest.approx(40)
    assert psnr_db(image, image) == math.inf


def test_flip_is_zero_for_equal_images_and_grows_with_the_difference(image):
    assert hdr_flip(image, image, pixels_per_degree=8.0) == 0
    small, large = (hdr_flip(image * f, image, pixels_per_degree=8.0) for f in (1.05, 1.5))
    assert 0 < small < large < 1


def test_flip_judges_a_crop_on_the_same_scale(image):
    """Exposures do not follow the image: a highlight elsewhere changes nothing here."""
    bright = image.copy()
    bright[:3, :3] = 60_000
    dim = hdr_flip(bright * [1, 1, 1.2], bright, pixels_per_degree=8.0)
    assert dim == pytest.approx(
        hdr_flip(image * [1, 1, 1.2], image, pixels_per_degree=8.0), rel=0.05
    )


def test_accuracy_knows_how_good_its_reference_is(image):
    noise = np.random.default_rng(4).normal(0, 0.02, (2, *image.shape))
    halves = (image + noise[0], image + noise[1])
    found = accuracy(image + 0.3, halves, pixels_per_degree=8.0)
    assert found.reference_rms == pytest.approx(0.02 / math.sqrt(2), rel=0.05)
    assert found.rms == pytest.approx(0.3, rel=0.01)
    assert found.counts
    assert not accuracy(image + 0.05, halves, pixels_per_degree=8.0).counts


def test_a_few_pixels_of_the_sun_are_not_the_whole_error(image):
    """A pixel above radiance 8, one whose halves differ and a margin of an eighth are left out."""
    halves = image.copy(), image.copy()
    for half in halves:
        half[20, 25] = 60_000
    halves[1][21, 25, 0] += 0.3
    test = image + 0.1
    test[:, :7] += 9
    found = accuracy(test, halves, pixels_per_degree=8.0)
    assert (found.margin_px, found.compared_px, found.left_out_px) == (7, 26 * 36 - 2, 2)
    assert found.rms == pytest.approx(0.1, rel=0.01)
    assert found.reference_rms == 0
    dark = accuracy(test, halves, pixels_per_degree=8.0, exposure=1e-4)
    assert dark.left_out_px == 0


@pytest.mark.parametrize("size_px", [(1, 1), (160, 40), (2, 9)])
def test_an_image_that_is_all_margin_is_refused(size_px):
    with pytest.raises(InputError, match="nothing can be compared"):
        margin_px(size_px)
    assert margin_px((160, 41)) == 20


def ssim_by_the_formula(a, b):
    """Return SSIM (Wang et al. 2004) of two (h, w) images, window by window."""
    offset = np.arange(-5, 6)
    weight = np.exp(-(offset[:, None] ** 2 + offset**2) / (2 * 1.5**2))
    weight /= weight.sum()
    found = []
    for y in range(5, a.shape[0] - 5):
        for x in range(5, a.shape[1] - 5):
            p, q = (image[y - 5 : y + 6, x - 5 : x + 6] for image in (a, b))
            mean_p, mean_q = (weight * p).sum(), (weight * q).sum()
            var_p, var_q = (weight * (p - mean_p) ** 2).sum(), (weight * (q - mean_q) ** 2).sum()
            cov = (weight * (p - mean_p) * (q - mean_q)).sum()
            up = (2 * mean_p * mean_q + 0.01**2) * (2 * cov + 0.03**2)
            found.append(up / ((mean_p**2 + mean_q**2 + 0.01**2) * (var_p + var_q + 0.03**2)))
    return np.mean(found)


def test_ssim_is_the_formula():
    a, b = np.random.default_rng(5).uniform(0, 1, (2, 15, 17))
    grey = [np.repeat(image[..., None], 3, axis=-1) for image in (a, 0.7 * a + 0.3 * b)]
    expected = ssim_by_the_formula(a, 0.7 * a + 0.3 * b)
    assert ssim(*grey) == pytest.approx(expected, rel=1e-9)


def test_ssim_of_equal_images_is_one_however_small(image):
    assert ssim(image, image) == pytest.approx(1)
    assert ssim(image[:4, :3], image[:4, :3]) == pytest.approx(1)
    assert ssim(image, 4 - image) < 0.1


def test_pixels_per_degree_of_a_known_view():
    fov = Fov(*np.radians([-45, 45, 45, -45]))
    assert pixels_per_degree(fov, (640, 640)) == pytest.approx(320 * math.pi / 180)


def test_images_must_have_three_channels(image):
    with pytest.raises(InputError, match="height, width, 3"):
        rms(image[..., 0], image[..., 0])
