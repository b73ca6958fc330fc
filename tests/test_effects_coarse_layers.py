"""Very wide discs, which are drawn on wider texels: discs, not rings of dots, wherever they lie."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_effects_optics import evaluate

from tests.oracles import coarse_layers, tile_classes
from tests.oracles.tile_classes import Grid
from tests.support.effects import texels_of
from tests.support.kernels import blur, defocused
from vrcomfort.optics.gather_resolution import coarser_above_px
from vrcomfort.optics.tile_classes import RingTile
from vrcomfort.render.effects.depth_of_field.kernels.coarse_layers import CoarseLayers
from vrcomfort.render.effects.depth_of_field.kernels.ring_tiles import RingTiles
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import make_level

SIDE = 112
LIGHT = 1000.0
MIDDLE = SIDE // 2


def lamp(lamp_px, shift=(0, 0)):
    """Return an image that is black but for a lamp, and the middle of that lamp."""
    rgb = np.zeros((SIDE, SIDE, 3))
    y, x = MIDDLE + shift[0], MIDDLE + shift[1]
    rgb[y : y + lamp_px, x : x + lamp_px] = LIGHT / lamp_px**2
    return rgb, np.array([y, x]) + (lamp_px - 1) / 2


def away_px(middle, steps=1):
    """Return how far every pixel, or every part of one, is from there."""
    at = (np.arange(SIDE * steps) + 0.5) / steps - 0.5
    return np.hypot(at[:, None] - middle[0], at - middle[1])


def disc(radius_px, lamp_px, middle):
    """Return the lamp spread over its disc: each pixel's part of it, by 4 x 4 points."""
    shifts = np.arange(lamp_px) - (lamp_px - 1) / 2
    found = sum(
        (away_px(middle + np.array([y, x]), 4) <= radius_px).astype(float)
        for y in shifts
        for x in shifts
    )
    found = found.reshape(SIDE, 4, SIDE, 4).mean(axis=(1, 3))
    return LIGHT * found / found.sum()


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("radius_px", [8.0, 16.0, 24.0, 32.0])
@pytest.mark.parametrize("lamp_px", [1, 3])
def test_a_lamp_becomes_a_disc_not_a_ring_of_dots(ctx, lamp_px, radius_px, side):
    rgb, middle = lamp(lamp_px, (1, 2))
    ideal = disc(radius_px, lamp_px, middle)
    ours, mip = (
        blur(ctx, kernel, rgb, side * radius_px, limit_px=radius_px).rgb[..., 0].astype(float)
        for kernel in ("vrcomfort", "mip")
    )
    ours_rms, mip_rms = (np.sqrt(np.mean((each - ideal) ** 2)) for each in (ours, mip))
    assert ours_rms <= 0.7 * mip_rms
    assert ours.sum() == pytest.approx(LIGHT, rel=0.01)
    inside = ours[away_px(middle) < 0.7 * radius_px]
    assert inside.max() <= 1.1 * inside.mean()
    assert inside.min() >= 0.85 * inside.mean()


@pytest.mark.parametrize("radius_px", [13.0, 16.0, 24.0, 40.0])
def test_wide_texels_and_what_they_blur_by_themselves_make_up_the_disc(ctx, radius_px):
    """Variance, on average over where a lamp lies among texels."""
    found = []
    for shift in ((0, 0), (1, 2), (2, 3), (3, 1)):
        rgb, middle = lamp(1, shift)
        light = blur(ctx, "vrcomfort", rgb, radius_px, limit_px=radius_px).rgb[..., 0].astype(float)
        found.append(np.sum(light * away_px(middle) ** 2) / light.sum() / 2)
    assert np.mean(found) == pytest.approx(radius_px**2 / 4, rel=0.04)


@pytest.mark.parametrize("lamp_px", [1, 2, 3])
@pytest.mark.parametrize("shift", [(0, 0), (1, 2), (3, 3)])
@pytest.mark.parametrize("behind_px", [0.0, 20.0])
def test_a_lamp_in_the_air_keeps_its_light_wherever_it_lies(ctx, lamp_px, shift, behind_px):
    """Thin fronts are not lost between texels, nor counted for a whole one."""
    rgb, middle = lamp(lamp_px, shift)
    radius_px = np.where(rgb[..., 0] > 0, -24.0, behind_px)
    light = blur(ctx, "vrcomfort", rgb, radius_px, limit_px=24.0).rgb[..., 0].astype(float)
    around = away_px(middle) > 4
    assert light[around].sum() == pytest.approx(0.97 * LIGHT, rel=0.03)
    disc_ = light[around & (away_px(middle) < 17)]
    assert disc_.max() <= 1.1 * disc_.mean()
    assert disc_.min() >= 0.85 * disc_.mean()


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("radius_px", [16.0, 30.0])
def test_a_wide_front_spreads_softly_over_what_is_sharp(ctx, radius_px, side):
    """The disc's integral beside its rim, and the rim itself does not show in it."""
    across = side * (np.arange(SIDE) - MIDDLE + 0.5)
    near = np.broadcast_to(across < 0, (SIDE, SIDE))
    rgb = np.where(near[..., None], [1.0, 0, 0], [0, 0, 1.0])
    found = blur(ctx, "vrcomfort", rgb, np.where(near, -radius_px, 0.0), limit_px=radius_px)
    red = found.rgb[..., 0].astype(float)
    x = np.clip(across / radius_px, -1, 1)
    covered = 0.5 - (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
    outside = across > 0
    assert np.sqrt(np.mean((red - covered)[:, outside] ** 2)) <= 0.02
    assert np.all(red[:, across > 1.2 * radius_px + 4] == 0)
    assert np.abs(red - red[MIDDLE]).max() <= 0.01
    np.testing.assert_allclose(found.rgb.astype(float).sum(axis=-1), 1, atol=2e-3)


def test_lamps_on_the_rim_of_a_front_are_no_beads(ctx):
    """Within the discs of two lamps, one of them on the rim, before what is sharp."""
    near = np.broadcast_to(np.arange(SIDE) < MIDDLE, (SIDE, SIDE))
    rgb = np.zeros((SIDE, SIDE, 3))
    rgb[MIDDLE : MIDDLE + 3, MIDDLE - 3 : MIDDLE] = 100.0
    found = blur(ctx, "vrcomfort", rgb, np.where(near, -24.0, 0.0), limit_px=24.0)
    lit = found.rgb[..., 0].astype(float)
    inside = away_px((MIDDLE + 1, MIDDLE - 2)) < 18
    for part in (inside & near, inside & ~near):
        differences = np.abs(np.diff(lit, axis=0))[part[1:] & part[:-1]]
        assert differences.max() <= 0.1 * lit[part].mean()


@pytest.mark.parametrize("radius_px", [16.0, 30.0])
def test_something_sharp_does_not_leak_into_very_wide_blur(ctx, radius_px):
    """Nor do the gaps of a sharp fence close, or its poles grow."""
    x = np.broadcast_to(np.arange(SIDE), (SIDE, SIDE))
    fence = (x > 40) & ((x % 7 < 3) | (x > 80))
    rgb = np.where(fence[..., None], [10.0, 0, 0], [0, 0, 1.0])
    found = blur(ctx, "vrcomfort", rgb, np.where(fence, 0.0, radius_px), limit_px=radius_px).rgb
    assert found[~fence][:, 0].max() == 0
    np.testing.assert_array_equal(found[fence], rgb[fence])


@pytest.mark.parametrize("limit_px", [20.0, 45.0, 90.0])
def test_a_constant_image_stays_constant(ctx, limit_px):
    """On texels of 4, 8 and 16 px, with surfaces of every kind."""
    rng = np.random.default_rng(3)
    rgb = np.tile(np.array([0.3, 1.7, 900.0], "f2"), (SIDE, SIDE, 1))
    radius_px = limit_px * rng.uniform(-1, 1, (SIDE, SIDE))
    radius_px[:60] = np.linspace(-limit_px, limit_px, SIDE)
    radius_px[50:, :50] = limit_px
    found = blur(ctx, "vrcomfort", rgb, radius_px, limit_px=limit_px, pixel_aspect=1.2).rgb
    assert np.abs(found.view("i2").astype(int) - rgb.view("i2").astype(int)).max() <= 1


def test_the_widest_discs_are_discs_too(ctx):
    """On texels of 8 px."""
    rgb, middle = lamp(3)
    light = blur(ctx, "vrcomfort", rgb, 40.0, limit_px=40.0).rgb[..., 0].astype(float)
    inside = light[away_px(middle) < 28]
    np.testing.assert_allclose(inside, LIGHT / (np.pi * 40**2), rtol=0.09)


@pytest.mark.parametrize("pixel_aspect", [1.0, 1.5])
def test_tiles_of_wide_texels_are_their_twin(ctx, pixel_aspect):
    radius_px = np.zeros((90, 420))
    radius_px[20:40, 10:30], radius_px[60:90, 250:260] = 25.0, -14.0
    _, coc = defocused(ctx, np.ones((90, 420, 3)), radius_px, limit_px=25.0)
    tiles = RingTiles(ctx, coc, small_px=4.7)
    tiles.render(pixel_aspect)
    points, half = (make_level(ctx, coc, texel_px, "f4") for texel_px in (1, 2))
    inputs = {"colour_and_coc": points.texture, "dilated": tiles.dilated}
    coarse = CoarseLayers(ctx, coc, half, inputs, {"RINGS": 3, "SMALL_PX": 4.7})
    coarse.render(pixel_aspect)
    reach, kinds = (texels_of(each) for each in (tiles.dilated, coarse.classes))
    twin = tile_classes.coarse_tile_classes(
        reach[..., :2], Grid(coc.tile_px, pixel_aspect, margin_px=8), far_px=12.0
    )
    np.testing.assert_array_equal(kinds[..., 0], twin)
    assert {0, RingTile.HALF_RESOLUTION, RingTile.HALF_RESOLUTION | RingTile.LAYERS} == set(
        twin.ravel()
    )


def test_shared_formulas_are_their_twins(ctx):
    rng = np.random.default_rng(5)
    rows = np.stack([rng.uniform(-180, 180, 300), rng.uniform(0, 1, 300)], axis=-1)
    rows = np.concatenate([rows, np.zeros_like(rows)], axis=-1).astype("f4")
    packed = "packed_foreground(x.x, x.y)"
    call = f"vec4(disc_texels(x.x), {packed}, unpacked_foreground({packed}))"
    texels_, packed, radius, coverage = evaluate(ctx, "coarse.glsl", call, rows).T
    signed_px, part = rows[:, 0].astype(float), rows[:, 1].astype(float)
    np.testing.assert_allclose(texels_, coarse_layers.disc_texels(signed_px, 4), rtol=1e-5)
    np.testing.assert_allclose(packed, coarse_layers.packed_foreground(signed_px, part), atol=2e-3)
    np.testing.assert_allclose(radius, signed_px, atol=1 / 128 + 1e-6)
    np.testing.assert_allclose(coverage, part, atol=4e-3)


@given(st.floats(-250, 250), st.floats(0, 1))
def test_a_radius_and_a_coverage_fit_in_one_number(signed_px, coverage):
    radius, part = coarse_layers.unpacked_foreground(
        coarse_layers.packed_foreground(signed_px, coverage)
    )
    assert radius == pytest.approx(signed_px, abs=1 / 128)
    assert part == pytest.approx(coverage, abs=1e-9)


@pytest.mark.parametrize("rings", range(1, 9))
def test_wider_texels_are_for_wider_discs(rings):
    bounds = [coarser_above_px(rings, texel_px) for texel_px in (2, 4, 8)]
    assert bounds == sorted(set(bounds))
    for bound, texel_px in zip(bounds, (4, 8, 16), strict=True):
        assert coarse_layers.disc_texels(bound, texel_px) > 2
