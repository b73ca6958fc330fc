"""Small discs as reads that cover them: the twin's bounds, the shader against it, and the dial."""

import numpy as np
import pytest
from scipy.signal import fftconvolve

from tests.oracles.disc_footprint import covered
from tests.support.effects import depth_of_field
from vrcomfort.geometry import Fov
from vrcomfort.optics import disc_footprint
from vrcomfort.render.effects.depth_of_field.kernels.tap_gather import TEXELS


def read_parts(reads, size=25):
    """Return the (size, size) part of each pixel in a mean of (n, 3) bilinear reads."""
    parts = np.zeros((size, size))
    low = np.floor(reads[:, :2]).astype(int)
    share = reads[:, :2] - low
    for y, x in np.ndindex(2, 2):
        part = np.where([x, y], share, 1 - share).prod(axis=1) * reads[:, 2]
        np.add.at(parts, (low[:, 1] + y + size // 2, low[:, 0] + x + size // 2), part)
    return parts


def disc_parts(radius_px, size=25, steps=32):
    """Return the (size, size) part of a disc that lies on each pixel."""
    at = (np.arange(size * steps) + 0.5) / steps - size / 2
    inside = np.hypot(at[:, None], at) <= radius_px
    parts = inside.reshape(size, steps, size, steps).mean(axis=(1, 3))
    return parts / parts.sum()


@pytest.mark.parametrize(("width_px", "most"), [(1, 0.12), (2, 0.27)])
@pytest.mark.parametrize("taps", [13, 24, 49])
def test_each_texel_of_a_disc_counts_once(width_px, most, taps):
    """No pixel differs from the light that a disc gives it by more than such a part of a pixel."""
    found = disc_footprint.footprint(taps, width_px, tallest=1.0)
    assert 2 * len(found.pairs) + 1 <= taps
    for radius_px in np.linspace(0.5 + width_px / 2, found.widest_px, 7):
        reads = covered(radius_px, found, width_px)
        error = np.abs(read_parts(reads) - disc_parts(radius_px)).max()
        assert error <= most / (np.pi * radius_px**2), radius_px
        np.testing.assert_allclose(reads[:, 2] @ reads[:, :2], 0, atol=1e-12)


@pytest.mark.parametrize(("width_px", "least"), [(1, 1.0), (2, 0.9)])
def test_half_a_pixel_is_the_pixel(width_px, least):
    reads = covered(0.5, disc_footprint.footprint(16, width_px), width_px)
    assert read_parts(reads)[12, 12] >= least


@pytest.mark.parametrize("width_px", [1, 2])
def test_taller_pixels_have_reads_to_the_end_of_the_disc(width_px):
    found = disc_footprint.footprint(24, width_px)
    reads = covered(found.widest_px, found, width_px, disc_footprint.TALLEST)
    variance = reads[:, 2] @ reads[:, :2] ** 2
    assert variance[1] / variance[0] == pytest.approx(disc_footprint.TALLEST**2, rel=0.06)


def blurred(ctx, rgb, radius_px, taps, pixel_aspect=1.0):
    """Return (h, w) float64 of the first channel, all of (h, w) as much out of focus."""
    height, width = rgb.shape
    tangent = 0.9
    across = float(np.arctan(tangent * width / height * pixel_aspect))
    up = float(np.arctan(tangent))
    settings = {"law": "dioptre", "full_blur_dioptre": 0.5, "taps": taps}
    settings["max_radius_percent"] = 100 * radius_px / width
    image = np.repeat(rgb[..., None], 3, axis=-1)
    fov = Fov(-across, across, up, -up)
    return depth_of_field(ctx, image, np.inf, 2.0, fov=fov, **settings)[..., 0].astype(float)


@pytest.mark.parametrize("pixel_aspect", [1.0, 1.25])
@pytest.mark.parametrize(
    ("taps", "radius_px", "width_px"), [(14, 0.8, 1), (14, 2.5, 1), (14, 3.25, 2), (6, 2.1, 2)]
)
def test_the_shader_covers_discs_as_the_twin_does(ctx, taps, radius_px, width_px, pixel_aspect):
    """Of texels, of 2 x 2 each, and of these spread, where there are no others (the last)."""
    rgb = np.zeros((25, 49))
    rgb[12, 24] = 1.0
    found = disc_footprint.footprint(TEXELS * taps + 1 if width_px == 1 else taps, width_px)
    expected = read_parts(covered(radius_px, found, width_px, pixel_aspect))
    image = blurred(ctx, rgb, radius_px, taps, pixel_aspect)[:, 12:37]
    # A texture's own interpolation has 8 bits.
    np.testing.assert_allclose(image, expected, rtol=1e-3, atol=1e-5 if width_px == 1 else 1e-3)


@pytest.mark.parametrize("lamp_px", [1, 3])
@pytest.mark.parametrize("radius_px", [1, 1.5, 2, 2.3, 2.6, 3, 3.5, 5, 6, 7, 9, 12, 14, 16])
def test_more_taps_never_show_small_lamps_worse(ctx, lamp_px, radius_px):
    """Errors fall along the dial, or rise by 1 dB at most."""
    rgb = np.zeros((128, 168))
    for y, x in np.random.default_rng(5).integers(24, 102, (12, 2)):
        rgb[y : y + lamp_px, x + 20 : x + 20 + lamp_px] = 1.0
    ideal = fftconvolve(rgb, disc_parts(radius_px, size=35), mode="same")
    errors = [
        np.sqrt(np.mean((blurred(ctx, rgb, radius_px, taps) - ideal) ** 2))
        for taps in (2, 6, 8, 14, 16, 24, 48)
    ]
    least = np.minimum.accumulate(errors)
    assert np.all(20 * np.log10(errors / least) <= 1), errors


def test_wide_discs_are_the_same_whatever_is_far_away(ctx):
    """A front far to the left makes tiles whose taps are far apart: they reach nothing here."""
    rng = np.random.default_rng(3)
    rgb = rng.uniform(0, 1, (96, 192, 3))
    # Radii of about 7 to 8 px: halves of points weigh colours by how alike these are.
    distance_m = 1 / rng.uniform(0.0, 0.12, (96, 192))
    settings = {"law": "dioptre", "full_blur_dioptre": 1.0, "max_radius_percent": 100 * 8 / 192}
    alone, beside = (
        depth_of_field(ctx, rgb, each, 1.0, taps=8, **settings)
        for each in (distance_m, np.where(np.arange(192) < 16, 0.55, distance_m))
    )
    np.testing.assert_array_equal(alone[:, 48:], beside[:, 48:])
    assert np.abs(alone - beside)[:, :24].max() > 0.1
