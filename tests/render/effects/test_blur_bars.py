"""What the kernel promises, measured on images that can be worked out: energy, rims, both eyes."""

import numpy as np
import pytest

from tests.oracles import gather, layers
from tests.support.effects import depth_of_field, textures
from tests.support.kernels import blur
from vrcomfort.optics.blur_kernels import exact_px
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.effect import DepthOfFieldPass
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.tradeoff.image_error import hdr_flip

WIDE = {"max_radius_percent": 5.0, "law": "dioptre", "full_blur_dioptre": 1.0}
"""At 128 px: 6.4 px of radius per dioptre and at most."""
WIDTH, HEIGHT = 128, 96


def at_radius(radius_px):
    """Return the distance behind a focus of 1 m at which the radius is that."""
    return 1 / (1 - radius_px / 6.4) if radius_px < 6.4 else np.inf


def scatter(rgb, radius_px):
    """Return the ideal: every pixel's square spread over its disc, all at one distance."""
    size = int(np.ceil(np.max(radius_px))) + 1
    steps = (np.arange(16) + 0.5) / 16 - 0.5
    grid = np.arange(-size, size + 1)
    x = (grid[:, None] + steps).ravel()
    inside = np.hypot(x[:, None], x[None, :]) <= max(radius_px, 1e-9)
    weights = inside.reshape(len(grid), 16, len(grid), 16).mean(axis=(1, 3))
    weights /= weights.sum()
    padded = np.pad(rgb, ((size, size), (size, size), (0, 0)), mode="edge")
    return sum(
        weights[j, i] * padded[j : j + rgb.shape[0], i : i + rgb.shape[1]]
        for j in range(len(grid))
        for i in range(len(grid))
        if weights[j, i] > 0
    )


def half_resolution(rgb, radius_px):
    """Return what a kernel that works at half resolution gives, its own blur being perfect."""
    small = rgb.reshape(HEIGHT // 2, 2, WIDTH // 2, 2, 3).mean(axis=(1, 3))
    blurred = scatter(small, radius_px / 2)
    y, x = (np.arange(n) / 2 - 0.25 for n in (HEIGHT, WIDTH))
    for axis, at in ((0, y), (1, x)):
        low = np.floor(at).astype(int)
        share = (at - low).reshape([-1 if a == axis else 1 for a in range(3)])
        ends = [np.clip(low + k, 0, blurred.shape[axis] - 1) for k in (0, 1)]
        first, second = (np.take(blurred, end, axis=axis) for end in ends)
        blurred = first * (1 - share) + second * share
    return blurred


def textured(seed=3):
    """Return radiance with detail at every scale down to a pixel."""
    rng = np.random.default_rng(seed)
    layers = [
        np.kron(rng.uniform(0, 1, (HEIGHT // n, WIDTH // n, 3)), np.ones((n, n, 1)))
        for n in (1, 2, 4, 8)
    ]
    return np.mean(layers, axis=0)


def shares(radius_px, pixel_aspect=1.0):
    """Return the part of a disc that lies on each pixel around it, (15, 15)."""
    steps = np.arange(-7.5, 7.5, 1 / 20) + 1 / 40
    inside = np.hypot(steps[:, None] / pixel_aspect, steps) <= radius_px
    weights = inside.reshape(15, 20, 15, 20).mean(axis=(1, 3))
    return weights / weights.sum()


@pytest.mark.parametrize("pixel_aspect", [1.0, 1.25])
@pytest.mark.parametrize("radius_px", [0.525, 0.7, 0.9, 1.1, 1.5, 4.6])
def test_discs_on_the_grid_are_discs(radius_px, pixel_aspect):
    """Each pixel has the part of a disc that lies on it, but for one pixel's part in 50.

    That disc is up to 0.1 px narrower (wider where it hardly leaves its pixel).
    """
    y, x = np.mgrid[-7:8, -7:8]
    grid = gather.grid_radius_px(radius_px)
    found = gather.disc_share(np.hypot(x, y / pixel_aspect), grid)
    found /= found.sum()
    widths = radius_px + np.linspace(-0.1, 0.05, 16)
    errors = [np.abs(found - shares(width, pixel_aspect)).max() for width in widths]
    assert min(errors) <= 0.02
    assert np.abs(found - shares(radius_px, pixel_aspect)).max() <= 0.1


def test_a_disc_of_half_a_pixel_is_its_pixel():
    assert gather.disc_share(1.0, gather.grid_radius_px(0.5)) == pytest.approx(0, abs=1e-12)
    assert gather.disc_share(1.0, gather.grid_radius_px(0.55)) > 0.01


@pytest.mark.parametrize("radius_px", [0.75, 1.0, 3.0])
def test_the_shares_of_a_disc_are_its_light(radius_px):
    """Integrated over the plane, by rings of radius a: π times a disc's share is π."""
    away, step = np.linspace(0, 5, 20_001, retstep=True)
    share = gather.disc_share(away, gather.grid_radius_px(radius_px))
    assert np.sum(2 * np.pi * away * share) * step == pytest.approx(np.pi, rel=1e-3)


@pytest.mark.parametrize("radius_px", [0.55, 0.75, 1.0, 2.0])
def test_small_blur_is_far_better_than_half_resolution(ctx, radius_px):
    """Discs of up to 4 px across, where most of what is seen in a headset lies."""
    rgb = textured()
    ideal = scatter(rgb, radius_px)
    ours = depth_of_field(ctx, rgb, at_radius(radius_px), 1.0, **WIDE)
    halved = half_resolution(rgb, radius_px)
    inside = slice(8, -8)
    errors = [
        hdr_flip(image[inside, inside], ideal[inside, inside], pixels_per_degree=16)
        for image in (ours, halved)
    ]
    assert errors[0] <= 0.3 * errors[1], errors


@pytest.mark.parametrize("radius_px", [0.8, 1.9, 3.2, 6.4])
def test_bright_points_keep_their_energy(ctx, radius_px):
    """Nothing weighs bright pixels down, so a lamp spreads all its light."""
    rgb = np.zeros((HEIGHT, WIDTH, 3))
    for y, x in ((30, 41), (47, 64), (61, 90)):
        rgb[y : y + 2, x : x + 2] = 1000.0
    blurred = depth_of_field(ctx, rgb, at_radius(radius_px), 1.0, samples=128, **WIDE)
    assert blurred.astype(float).sum() == pytest.approx(rgb.sum(), rel=0.005)


@pytest.mark.parametrize("radius_px", [1.2, 3.0, 6.4])
def test_both_eyes_see_the_same_blur(ctx, radius_px):
    """A view moved by whole pixels is blurred to the same, moved: no noise of the screen."""
    rgb = textured()
    moved = [np.roll(rgb, shift, axis=1) for shift in (0, 7)]
    left, right = (
        depth_of_field(ctx, image, at_radius(radius_px), 1.0, **WIDE).astype(float)
        for image in moved
    )
    truths = [scatter(image, radius_px) for image in moved]
    inside = (slice(16, -16), slice(16, -16))
    errors = [left - truths[0], np.roll(right - truths[1], -7, axis=1)]
    first, second = (error[inside].ravel() for error in errors)
    screen = (right - truths[1])[inside].ravel()
    rivalry = np.mean(np.abs(first - second))
    shower_door = np.corrcoef(first, screen)[0, 1] - np.corrcoef(first, second)[0, 1]
    assert shower_door <= 0.05
    # Half resolution is tied to pixels: odd shifts change wide blur, by less than its error.
    assert rivalry <= (0 if radius_px <= 2 else np.mean(np.abs(first)))


@pytest.mark.parametrize("pixel_aspect", [1.0, 1.25])
@pytest.mark.parametrize("spread", [0.0, 1.0])
def test_discs_of_a_few_pixels_are_summed_as_the_twin_sums_them(ctx, pixel_aspect, spread):
    """Surfaces that mix, and a single one (a way of its own)."""
    rng = np.random.default_rng(2)
    rgb = rng.uniform(0, 1, (23, 21, 3)).astype("f2")
    rgb[4:6, 9] = 900.0
    radius = 3.9 - spread * rng.uniform(0, 7.8, (23, 21)) * rng.integers(0, 2, (23, 21))
    found = blur(
        ctx, "vrcomfort", rgb, radius, max_radius_px=4.0, pixel_aspect=pixel_aspect, samples=128
    )
    expected = layers.layered(found.points, pixel_aspect=pixel_aspect)
    off = np.abs(found.rgb - expected) > 1e-4 + 2e-3 * np.abs(expected)
    assert off.mean() < 0.03
    np.testing.assert_allclose(found.rgb, expected, rtol=0.1, atol=0.01)
    assert np.abs(found.rgb - rgb).max() > 0.1


@pytest.mark.parametrize("radius_px", [3.0, 3.7])
def test_a_lamp_of_one_pixel_becomes_a_disc_not_spots(ctx, radius_px):
    """Every pixel of the disc is lit alike, on one surface and before a background alike."""
    rgb = np.full((HEIGHT, WIDTH, 3), 0.1)
    rgb[48, 64] = 200.0
    y, x = np.mgrid[-48:48, -64:64]
    away = np.hypot(x, y)
    for distance in (at_radius(radius_px), np.where(x < 20, at_radius(radius_px), 1.0)):
        lit = depth_of_field(ctx, rgb, distance, 1.0, samples=128, **WIDE).astype(float)[..., 0]
        inside = lit[away < radius_px - 0.55] - 0.1
        np.testing.assert_allclose(inside, 200 / (np.pi * radius_px**2), rtol=0.05)
        np.testing.assert_allclose(lit[away > radius_px + 0.6][:1000], 0.1, rtol=2e-3)


def test_more_samples_are_closer_to_the_ideal(ctx):
    """Until every pixel of a disc counts; then they change nothing."""
    rgb = textured()
    rgb[30:60:10, 20:110:10] = 20.0
    inside = slice(12, -12)
    for radius_px in (3.2, 4.5, 6.4):
        ideal = scatter(rgb, radius_px)
        found = [
            depth_of_field(ctx, rgb, at_radius(radius_px), 1.0, samples=samples, **WIDE)
            for samples in (16, 36, 128)
        ]
        few, some, many = (
            np.sqrt(np.mean((each.astype(float) - ideal)[inside, inside] ** 2)) for each in found
        )
        assert few >= some >= many, radius_px
        assert many <= 0.04
        for samples, each in zip((16, 36, 128), found, strict=True):
            if radius_px <= 0.85 * exact_px(samples):
                np.testing.assert_array_equal(each, found[-1])


@pytest.mark.parametrize(
    ("width_px", "limit_percent", "textures_"), [(100, 1.0, 6), (100, 5.0, 8), (130, 9.0, 9)]
)
def test_depth_of_field_owns_no_more_textures_than_it_needs(
    ctx, count_objects, width_px, limit_percent, textures_
):
    """Points, two of tiles, two of the widest disc, the result; where discs can be wide also
    levels, and what is gathered at half resolution.
    """
    rgb = np.zeros((3, width_px, 3))
    colour, depth = textures(ctx, rgb, 1.0)
    focus = ctx.texture((1, 1), 4, np.ones(4, "f4").tobytes(), dtype="f4")
    before = count_objects()
    settings = DepthOfField(max_radius_percent=limit_percent)
    effect = DepthOfFieldPass(EffectInputs(ctx, settings, colour, {"depth": depth, "focus": focus}))
    after = count_objects()
    assert after["Texture"] - before["Texture"] == textures_
    del effect
