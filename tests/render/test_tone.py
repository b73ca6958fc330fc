import numpy as np
import pytest

from vrcomfort.gpu import gl
from vrcomfort.optics import tone
from vrcomfort.render.display import ToneMapPass
from vrcomfort.render.output import read_rgb8


def test_shader_and_twin_agree(ctx):
    rng = np.random.default_rng(1)
    radiance = (10 ** rng.uniform(-4, 4.8, (32, 32, 4))).astype(np.float16)
    radiance[0, 0] = 0
    radiance[0, 1] = 65504
    source = gl.color_texture(ctx, (32, 32))
    source.write(radiance.tobytes())
    tone_map = ToneMapPass(ctx, radiance=source, size_px=(32, 32), exposure=0.7)
    tone_map.render()
    expected = tone.tone_mapped(radiance[::-1, :, :3].astype(np.float64), exposure=0.7) * 255
    # Half a step of rounding, and what float32 pow() is off by.
    assert np.abs(read_rgb8(tone_map.target) - expected).max() <= 0.51


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
