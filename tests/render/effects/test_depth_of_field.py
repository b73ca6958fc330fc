"""Depth of field on images whose blur can be worked out by hand."""

import numpy as np
import pytest

from tests.support.effects import Lens, depth_of_field, rgb_of, seen, square_pixels, textures
from tests.support.kernels import blur
from vrcomfort.geometry import Fov, Pose, axis_angle
from vrcomfort.optics import blur_kernels
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.effect import DepthOfFieldPass
from vrcomfort.render.effects.effect import EffectInputs

WIDE = {"max_radius_percent": 5.0, "law": "dioptre", "full_blur_dioptre": 1.0}
"""At 128 px: 6.4 px of radius per dioptre and at most."""


@pytest.fixture
def rng():
    return np.random.default_rng(1)


def columns(width=128, height=96):
    return np.arange(width)[None, :].repeat(height, axis=0)


def ulps(a, b):
    return np.abs(a.view("i2").astype(int) - b.view("i2").astype(int)).max()


SAMPLES = [16, 36, 128]
"""The ends of the dial and what is taken unless set."""


@pytest.mark.parametrize("samples", SAMPLES)
def test_a_constant_image_stays_constant(ctx, rng, samples):
    rgb = np.tile(np.array([0.3, 1.7, 900.0], "f2"), (96, 128, 1))
    distance = np.exp(rng.uniform(-1, 4, (96, 128)))
    distance[:40] = np.linspace(0.3, 9, 128)
    blurred = depth_of_field(ctx, rgb, distance, 1.0, samples=samples, **WIDE)
    assert ulps(blurred, rgb) <= 1


@pytest.mark.parametrize("samples", SAMPLES)
def test_a_constant_sky_stays_constant(ctx, samples):
    """Everything equally out of focus: the filtered half-resolution way."""
    rgb = np.tile(np.array([0.3, 1.7, 60_000.0], "f2"), (45, 63, 1))
    settings = {"max_radius_percent": 10.0, "full_blur_m": 1.0, "samples": samples}
    blurred = depth_of_field(ctx, rgb, np.inf, 1.0, **settings)
    assert ulps(blurred, rgb) <= 1


@pytest.mark.parametrize("samples", SAMPLES)
def test_small_blur_is_an_exact_copy_unless_something_wider_reaches_it(ctx, rng, samples):
    rgb = rng.uniform(0, 1, (96, 128, 3)).astype("f2")
    # Radii: 6.4 px in front of columns 0 to 31, at most 0.48 px elsewhere.
    distance = np.where(columns() < 32, 0.5, rng.uniform(0.93, 1.08, (96, 128)))
    blurred = depth_of_field(ctx, rgb, distance, 1.0, samples=samples, **WIDE)
    untouched = columns() >= 32 + 9
    np.testing.assert_array_equal(blurred[untouched], rgb[untouched])
    touched = columns() == 33
    assert np.mean(np.abs(blurred[touched].astype(float) - rgb[touched])) > 0.05


@pytest.mark.parametrize("samples", SAMPLES)
def test_a_sharp_foreground_does_not_leak(ctx, samples):
    bar = np.abs(columns() - 64) < 10
    rgb = np.where(bar[..., None], [10.0, 0, 0], [0, 0, 1.0])
    distance = np.where(bar, 1.0, np.inf)
    blurred = depth_of_field(ctx, rgb, distance, 1.0, samples=samples, **WIDE).astype(float)
    assert blurred[~bar][:, 0].max() <= 10.0 / 255 / 10
    np.testing.assert_array_equal(blurred[bar], rgb[bar])


@pytest.mark.parametrize(
    ("near_is_left", "radius_px", "samples", "rms"),
    [
        (True, 1.5, 16, 0.04),
        (False, 12.0, 16, 0.04),
        (True, 6.4, 36, 0.03),
        (False, 3.0, 36, 0.03),
        (True, 1.5, 128, 0.02),
        (False, 12.0, 128, 0.02),
    ],
)
def test_a_blurred_foreground_is_the_disc_integral_at_its_edge(
    ctx, near_is_left, radius_px, samples, rms
):
    near = (columns() < 64) == near_is_left
    rgb = np.where(near[..., None], [1.0, 0, 0], [0, 0, 1.0])
    settings = WIDE | {"max_radius_percent": radius_px / 1.28, "samples": samples}
    blurred = depth_of_field(ctx, rgb, np.where(near, 0.5, 1.0), 1.0, **settings).astype(float)
    offset = (np.arange(128) - 63.5) * (1 if near_is_left else -1) / radius_px
    x = np.clip(offset, -1, 1)
    covered = 0.5 - (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
    profile = blurred[48]
    assert np.sqrt(np.mean((profile[:, 0] - covered)[50:78] ** 2)) <= rms
    np.testing.assert_allclose(profile.sum(axis=-1), 1, atol=2e-3)
    assert np.all(profile[:, 0][offset > 1.3 + 0.5 / radius_px] == 0)


@pytest.mark.parametrize(("samples", "radius_px"), [(36, 3.3), (72, 4.7), (256, 9.0), (72, 16.0)])
@pytest.mark.parametrize(("aspect", "upwards"), [(1.25, True), (2.5, False)])
def test_a_front_reaches_over_all_tiles_however_tall_pixels_are(
    ctx, samples, radius_px, aspect, upwards
):
    """Its edge lies between two tiles; radii are widths, so that more rows than columns blur."""
    near = np.arange(96)[:, None].repeat(64, axis=1) < 24
    near = near[::-1] if upwards else near
    rgb = np.where(near[..., None], 1.0, [0.0, 0.0, 0.0])
    settings = {"samples": samples, "pixel_aspect": aspect, "max_radius_px": radius_px}
    found = blur(ctx, "vrcomfort", rgb, np.where(near, -radius_px, 0.0), **settings)
    x = np.clip((np.arange(96) - 23.5) / (radius_px * aspect), -1, 1)
    covered = 0.5 - (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
    column = found.rgb[::-1, 32, 0] if upwards else found.rgb[:, 32, 0]
    np.testing.assert_allclose(column[24:], covered[24:], atol=0.03)


BESIDE_FOCUS = [(-4.0, 6.0), (-9.0, 9.0), (-3.0, 3.0)]
ON_ONE_SIDE = [(3.0, 9.0), (1.5, 4.0), (-9.0, -3.0), (-4.0, -1.5)]
"""Signed radii in px of a front and of what is behind it, of one sign in the latter."""


@pytest.mark.parametrize(
    ("samples", "radii_px", "rms"),
    [
        *((16, each, 0.04) for each in BESIDE_FOCUS[:2] + ON_ONE_SIDE[:2]),
        *((36, each, 0.03) for each in BESIDE_FOCUS[1:] + ON_ONE_SIDE[2:]),
        *((128, each, 0.02) for each in BESIDE_FOCUS[1:] + ON_ONE_SIDE),
    ],
)
def test_an_edge_has_the_disc_of_the_front_whatever_is_behind(ctx, samples, radii_px, rms):
    front_px, back_px = radii_px
    is_front = columns(192) < 96
    rgb = np.where(is_front[..., None], [1.0, 0, 0], [0, 0, 1.0])
    settings = WIDE | {"max_radius_percent": 100 * 12 / 192, "samples": samples}
    distance_m = 1 / (1 - np.where(is_front, front_px, back_px) / 12)
    blurred = depth_of_field(ctx, rgb, distance_m, 1.0, **settings).astype(float)
    x = np.clip((np.arange(192) - 95.5) / abs(front_px), -1, 1)
    covered = 0.5 - (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
    assert np.sqrt(np.mean((blurred[48, :, 0] - covered)[78:114] ** 2)) <= rms


def texel_variance_px2(radius_px, samples):
    """Return that of a pixel, or of a texel of half resolution where discs are summed there."""
    return (1 if radius_px <= blur_kernels.exact_px(samples) else 4) / 12


@pytest.mark.parametrize(("radius_px", "aspect"), [(1.5, 1.25), (3.0, 1.0), (6.4, 1.25)])
@pytest.mark.parametrize("samples", SAMPLES)
def test_bokeh_is_a_disc_that_keeps_the_energy(ctx, radius_px, aspect, samples):
    """Round in angle: taller in pixels where pixels are narrower than high."""
    rgb = np.zeros((96, 128, 3))
    rgb[45:51, 61:67] = 1.0
    distance = 1 / (1 - radius_px / 6.4) if radius_px < 6.4 else np.inf
    tangent = np.tan(0.8)
    horizontal = float(np.arctan(tangent * 128 / 96 * aspect))
    fov = Fov(-horizontal, horizontal, 0.8, -0.8)
    blurred = depth_of_field(ctx, rgb, distance, 1.0, fov=fov, samples=samples, **WIDE)[..., 0]
    blurred = blurred.astype(float)
    assert blurred.sum() == pytest.approx(36, rel=0.01)
    y, x = np.mgrid[-47.5:48, -63.5:64]
    exact = radius_px <= blur_kernels.exact_px(samples)
    # Second moments: those of the disc and of a texel, plus those of the 6 x 6 square.
    for axis, scale in ((x, 1.0), (y, aspect)):
        moment = np.sum(blurred * axis**2) / blurred.sum() - 35 / 12
        expected = (radius_px * scale) ** 2 / 4 + texel_variance_px2(radius_px, samples)
        assert moment == pytest.approx(expected, rel=0.12, abs=0.23 if exact else 0.55)
    assert abs(np.sum(blurred * x * y)) / blurred.sum() < 0.1


@pytest.mark.parametrize(
    ("samples", "radius_px"),
    [(16, 1.0), (16, 2.0), (16, 3.0), (16, 5.0), (36, 3.0), (36, 5.0), (128, 5.0)],
)
def test_blur_from_half_the_image_is_as_wide_as_the_disc(ctx, samples, radius_px):
    """On average over where things lie among the texels of half the image."""
    variances = []
    for shift in (0, 1):
        rgb = np.zeros((96, 128, 3))
        rgb[44 + shift : 52 + shift, 60 + shift : 68 + shift] = 1.0
        distance = 1 / (1 - radius_px / 6.4)
        spot = depth_of_field(ctx, rgb, distance, 1.0, samples=samples, **WIDE)[..., 0].astype(
            float
        )
        y, x = np.mgrid[-47.5:48, -63.5:64]
        for axis in (x, y):
            variances.append(np.sum(spot * (axis - shift) ** 2) / spot.sum() - 63 / 12)
    expected = radius_px**2 / 4 + texel_variance_px2(radius_px, samples)
    assert np.mean(variances) == pytest.approx(expected, rel=0.07, abs=0.06)


@pytest.mark.parametrize("samples", SAMPLES)
def test_frames_before_do_not_change_an_image(ctx, rng, samples):
    """Tiles look as far as the widest disc of this frame reaches."""
    rgb = rng.uniform(0, 1, (96, 128, 3)).astype("f2")
    colour, depth = textures(ctx, rgb, np.exp(rng.uniform(-0.5, 2, (96, 128))))
    focus = ctx.texture((1, 1), 4, dtype="f4")

    def images(*focus_m):
        settings = DepthOfField(samples=samples, **WIDE)
        effect = DepthOfFieldPass(
            EffectInputs(ctx, settings, colour, {"depth": depth, "focus": focus})
        )
        for each in focus_m:
            focus.write(np.full(4, each, "f4").tobytes())
            fov = square_pixels((128, 96))
            effect.render(seen(fov))
            yield rgb_of(effect.target)

    (far,), (near,) = images(1.5), images(0.4)
    np.testing.assert_array_equal(list(images(1.5, 0.4, 1.5)), [far, near, far])


def test_depth_runs_along_the_heads_axis_in_canted_eyes(ctx, rng):
    """A plane across the head's axis at the focus distance is sharp in an eye turned outwards."""
    rgb = rng.uniform(0, 1, (96, 128, 3)).astype("f2")
    cant = axis_angle([0.0, 1.0, 0.0], 0.3)
    fov = Fov(-0.8, 0.8, 0.65, -0.65)
    tangent = np.linspace(-1, 1, 257)[1::2] * np.tan(0.8)
    eye = Pose(np.array([-0.03, 0.0, -0.05]), cant)
    slope = np.cos(0.3) + np.sin(0.3) * tangent
    distance = (2.0 - 0.05) / slope
    settings = WIDE | {"full_blur_dioptre": 0.05}
    blurred = depth_of_field(ctx, rgb, distance, 2.0, fov=fov, eye=eye, **settings)
    np.testing.assert_array_equal(blurred, rgb)
    assert np.any(depth_of_field(ctx, rgb, distance, 2.0, fov=fov, **settings) != rgb)


@pytest.mark.parametrize(
    ("width", "height", "law", "samples"),
    [(1, 1, "linear", 128), (7, 5, "dioptre", 36), (67, 35, "dioptre", 16)],
)
def test_extremes_stay_finite_and_within_their_range(ctx, rng, width, height, law, samples):
    settings = {
        "law": law,
        "samples": samples,
        "max_radius_percent": 5.0,
        "full_blur_m": 0.1,
        "full_blur_dioptre": 0.1,
    }
    rgb = np.exp2(rng.uniform(-20, 15.99, (height, width, 3)))
    rgb[rng.random((height, width)) < 0.2] = 65504
    rgb[rng.random((height, width)) < 0.2] = 0
    lens = Lens(ctx, (width, height), **settings)
    for near_m in (0.001, 1.0):
        far = np.exp(rng.uniform(np.log(near_m), np.log(3e4), (height, width)))
        for distance in (np.inf, near_m, np.where(far > 10, np.inf, far), far):
            for focus_m in (0.05, 1.0, 3e4, np.inf, np.nan):
                out = lens.blur(rgb, distance, focus_m, near_m=near_m)
                assert np.isfinite(out).all()
                assert out.max() <= 65504
                assert out.min() >= 0


@pytest.mark.parametrize("samples", [16, 36])
@pytest.mark.parametrize(("max_radius_px", "aspect"), [(2.4, 1.0), (9.0, 1.5), (20.0, 1.0)])
def test_nothing_of_the_frame_before_is_left(ctx, rng, samples, max_radius_px, aspect):
    """Tiles of which nothing is needed are not drawn: what they still hold must not be seen."""
    width, height = 203, 149
    settings = {
        "law": "dioptre",
        "full_blur_dioptre": 1.0,
        "max_radius_percent": max_radius_px / 2.03,
    }
    tangent = np.tan(0.8)
    horizontal = float(np.arctan(tangent * width / height * aspect))
    fov = Fov(-horizontal, horizontal, 0.8, -0.8)
    sharp = np.full((height, width), 1.0)
    for _ in range(12):
        x, y, size = rng.integers(0, width), rng.integers(0, height), rng.integers(1, 12)
        sharp[y : y + size, x : x + size] = 1 / (1 - rng.uniform(-1, 1))
    rgb = rng.uniform(0, 1, (height, width, 3))

    def blurred(frames):
        colour, depth = textures(ctx, *frames[0])
        focus = ctx.texture((1, 1), 4, np.ones(4, "f4").tobytes(), dtype="f4")
        lens = DepthOfField(samples=samples, **settings)
        effect = DepthOfFieldPass(EffectInputs(ctx, lens, colour, {"depth": depth, "focus": focus}))
        for frame in frames:
            for into, new in zip((colour, depth), textures(ctx, *frame), strict=True):
                into.write(new.read())
            effect.render(seen(fov))
        return rgb_of(effect.target)

    before = np.full((height, width, 3), 60_000.0), 0.5
    found, expected = blurred([before, (rgb, sharp)]), blurred([(rgb, sharp)])
    np.testing.assert_array_equal(found, expected)
    assert found.max() <= 1
    changed = np.mean(found != rgb.astype("f2"))
    assert 0.02 < changed < 0.9
