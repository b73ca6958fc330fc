import zlib

import numpy as np
import pytest

from vrcomfort.gpu import gl
from vrcomfort.optics import dither, tone
from vrcomfort.render.display import noise_texture, tone_map_pass
from vrcomfort.render.output import read_rgb8


def shown(ctx, radiance, exposure=0.7):
    """Return an image of half floats, whose lowest row is first: 8 bits, and its exact values."""
    height, width = radiance.shape[:2]
    source = gl.color_texture(ctx, (width, height))
    source.write(radiance.tobytes())
    tone_map = tone_map_pass(
        ctx,
        radiance=source,
        blue_noise=noise_texture(ctx),
        size_px=(width, height),
        exposure=exposure,
    )
    tone_map.render()
    light = radiance[::-1, :, :3].astype(np.float64)
    return read_rgb8(tone_map.target), tone.tone_mapped(light, exposure=exposure)


def test_shader_and_twins_agree(ctx):
    rng = np.random.default_rng(1)
    radiance = (10 ** rng.uniform(-4, 4.8, (32, 32, 4))).astype(np.float16)
    radiance[0, 0] = 0
    radiance[0, 1] = 65504
    image, display = shown(ctx, radiance)
    # A step of dither, and what float32 pow() is off by.
    assert np.abs(image - display * 255).max() <= 1.01
    assert (image != dither.dithered(display)).mean() < 0.01
    assert not image[-1, 0].any()  # black stays black


def test_a_dark_gradient_has_no_bands(ctx):
    """Means of 8×8 pixels follow light from 1.3 to 4 of 255; without dither they are 0.4 off."""
    light = np.linspace(0.008, 0.014, 512).astype(np.float16)
    radiance = np.ascontiguousarray(np.broadcast_to(light[:, None], (128, 512, 4)))
    image, display = shown(ctx, radiance, exposure=1.0)

    def worst_mean(codes):
        off = (codes - display * 255)[..., 0]
        return np.abs(off.reshape(16, 8, 64, 8).mean(axis=(1, 3))).max()

    assert worst_mean(np.round(display * 255)) > 0.4
    assert worst_mean(image) < 0.07
    assert np.abs(image - display * 255).max() < 1.001
    assert (image == image[..., :1]).all()  # grey stays grey
    np.testing.assert_array_equal(image, shown(ctx, radiance, exposure=1.0)[0])  # every frame, eye


def test_the_noise_is_blue_and_the_same_on_every_machine():
    """Below 0.2 cycles per pixel it has a tenth of white noise's power, and no line."""
    noise = dither.blue_noise()
    assert len(np.unique(noise)) == noise.size
    assert zlib.crc32((noise * noise.size).astype("<i2").tobytes()) == 2153336796
    cycles = np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(dither.SIDE)]))
    low = (cycles > 0) & (cycles < 0.2)
    for level in np.linspace(0.2, 0.8, 7):
        dots = np.floor(level + noise)
        power = np.abs(np.fft.fft2(dots - dots.mean())) ** 2 / dots.size / dots.var()
        assert power[low].mean() < 0.1
        assert power[low].max() < 1.0


def test_values_of_eight_bits_stay():
    codes = np.arange(256, dtype=np.uint8).repeat(3 * 64).reshape(256, 64, 3)
    np.testing.assert_array_equal(dither.dithered(codes / 255), codes)


def test_base_colours_come_through():
    # A surface that reflects 4 % on top of its colour shows just its colour.
    color = np.array([0.6, 0.3, 0.1])
    np.testing.assert_allclose(tone.pbr_neutral(color + 0.04), color)


def test_the_curve_is_continuous_rises_and_stays_below_one():
    values = np.linspace(0, 100, 200_001)
    curve = tone.pbr_neutral(np.stack([values] * 3, axis=-1))[:, 0]
    assert np.all(np.diff(curve) >= 0)
    assert np.diff(curve).max() < 1e-3
    assert curve[-1] < 1


@pytest.mark.parametrize(("linear", "encoded"), [(0, 0), (0.5, 0.735357), (1, 1), (7, 1)])
def test_srgb(linear, encoded):
    assert tone.srgb_encoded(linear) == pytest.approx(encoded, abs=1e-6)
