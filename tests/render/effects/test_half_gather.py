"""Twelve samples: blur at half resolution loses no light, and nothing in focus leaks or changes."""

import numpy as np
import pytest
from pydantic import ValidationError

from tests.render.effects.test_optics import evaluate
from tests.support.effects import depth_of_field, texels_of
from tests.support.kernels import blur, defocused
from vrcomfort.gpu.shaders import constant
from vrcomfort.optics import blur_kernels
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.half_gather import HalfImage

ENDS = "HAS_END", "HAS_WIDE_END"
WIDTH, HEIGHT = 160, 96


def blurred(ctx, rgb, distance_m, radius_px, focus_m=1.0):
    """Return (h, w, 3); something at infinity has this radius with focus at 1 m."""
    lens = {
        "law": "dioptre",
        "full_blur_dioptre": 1.0,
        "max_radius_percent": 100 * radius_px / rgb.shape[1],
    }
    found = depth_of_field(
        ctx, rgb, distance_m, focus_m, samples=12, max_diameter_arcmin=None, **lens
    )
    return found.astype(float)


def picture(seed=0, size_px=(WIDTH, HEIGHT), peak=4.0):
    width, height = size_px
    return np.random.default_rng(seed).uniform(0, peak, (height, width, 3)).astype("f2")


def surfaces(seed=0, size_px=(WIDTH, HEIGHT)):
    """Return (h, w) distances of rectangles before and behind the focus, in it and infinite."""
    random = np.random.default_rng(seed)
    width, height = size_px
    distance = np.full((height, width), np.inf)
    for metres in (4.0, 1.0, 0.7, 0.55, 1.0, 1.3):
        x, y = random.integers(0, width), random.integers(0, height)
        distance[y : y + height // 3, x : x + width // 3] = metres
    return distance


@pytest.mark.parametrize("radius_px", [1.0, 3.0, 8.0, 15.0])
def test_a_constant_image_stays_constant(ctx, radius_px):
    found = blurred(ctx, np.full((HEIGHT, WIDTH, 3), 0.3), surfaces(), radius_px)
    np.testing.assert_allclose(found, np.float16(0.3), atol=2**-11)


def test_what_is_in_focus_is_unchanged_where_nothing_nearer_is_blurred(ctx):
    """A patch in focus before blurred ground: bit for bit, up to its edge."""
    distance = np.full((HEIGHT, WIDTH), np.inf)
    distance[31:62, 45:90] = 1.0
    rgb = picture()
    found = blurred(ctx, rgb, distance, 12.0)
    np.testing.assert_array_equal(found[31:62, 45:90], rgb[31:62, 45:90])
    assert np.abs(found - rgb)[:20].mean() > 0.1


@pytest.mark.parametrize("radius_px", [1.5, 3.0, 6.0, 12.0])
def test_nothing_leaks_from_a_sharp_foreground(ctx, radius_px):
    """White in focus beside black at infinity; its edge lies on an odd pixel."""
    rgb = np.zeros((HEIGHT, WIDTH, 3))
    rgb[:, :75] = 1.0
    distance = np.where(np.arange(WIDTH) < 75, 1.0, np.inf)[None].repeat(HEIGHT, 0)
    found = blurred(ctx, rgb, distance, radius_px)
    assert found[:, 75:].max() <= 1 / 255
    assert found[:, :75].min() == 1.0


@pytest.mark.parametrize("radius_px", [6.0, 10.0, 15.0])
def test_a_blurred_foreground_spreads_over_what_is_in_focus(ctx, radius_px):
    """A near half plane over a sharp one: beside its edge the share of the lens that it covers."""
    rgb = np.zeros((HEIGHT, WIDTH, 3))
    rgb[:, :80] = 1.0
    distance = np.where(np.arange(WIDTH) < 80, 0.5, 1.0)[None].repeat(HEIGHT, 0)
    row = blurred(ctx, rgb, distance, radius_px)[HEIGHT // 2, :, 0]
    away = (np.arange(WIDTH) + 0.5 - 80) / radius_px
    inside = np.clip(away, -1, 1)
    covered = (np.arccos(inside) - inside * np.sqrt(1 - inside**2)) / np.pi
    beside = (away > 0) & (away < 1.3)
    np.testing.assert_allclose(row[beside], covered[beside], atol=0.12)
    assert np.all(np.diff(row[beside]) < 0.03), "it falls"


def test_a_small_near_disc_spreads_over_what_is_in_focus(ctx):
    """Beside a white half plane of -1.6 px, by hand: taps at 0.75 (1.6^2 - 0.3)^0.5 = 1.127 px.

    Half a pixel beyond the edge two are 1.041 px to the left, on the half plane: each is 1 of 9.
    Two are 0.431 px to the left, between pixels, of which the left one has a share of 0.431 and a
    radius of -0.690 px: they count 2 (0.690 - 0.5) / 1.1 = 0.345, with a light of 0.431.
    """
    rgb = np.zeros((HEIGHT, WIDTH, 3))
    rgb[:, :80] = 1.0
    radii = np.where(np.arange(WIDTH) < 80, -1.6, 0.0)[None].repeat(HEIGHT, 0)
    lit = blur(ctx, "vrcomfort", rgb, radii, max_radius_px=16.0, samples=12).rgb.astype(float)
    by_hand = (2 * 1.0 + 2 * 0.345 * 0.431) / 9
    np.testing.assert_allclose(lit[40:56, 80], by_hand, atol=0.01)
    assert (lit[:, 82:] == 0).all()


def test_a_narrow_disc_behind_the_focus_does_not_shine_in_a_wide_one(ctx):
    """A bright board of 6 px before a black wall of 40 px: its corner lies in odd texels."""
    y, x = np.mgrid[:160, :160]
    board = (x < 81) & (y < 81)
    rgb = np.where(board, 5.0, 0.0)[..., None] * np.ones(3)
    radii = np.where(board, 6.0, 40.0)
    lit = blur(ctx, "vrcomfort", rgb, radii, max_radius_px=40.0, samples=12).rgb.astype(float)
    beyond = np.hypot(np.maximum(x - 80, 0), np.maximum(y - 80, 0)) > 20
    assert lit[beyond].max() <= 1 / 255


def test_a_tile_says_whether_something_wide_ends_in_it(ctx):
    """Tiles of 8 px, four of each with radii of -9, -7 and 9 px, one in focus, and one of -9 px.

    What ends between two tiles counts to the left one.
    """
    bits = {name: int(constant("tile_classes.glsl", name)) for name in ENDS}
    assert bits["HAS_END"] == 1 << int(constant("levels.glsl", "LEVEL_BITS")), "as near_rows.frag"
    radii = np.zeros((8, 40))
    radii[:, [0, 1, 2, 3]], radii[:, [8, 9, 10, 11]], radii[:, [16, 17, 18, 19]] = -9.0, -7.0, 9.0
    radii[:, 32:] = -9.0
    rgb = np.ones((*radii.shape, 3))
    _, coc = defocused(ctx, rgb, radii, max_radius_px=16.0, samples=12)
    image = HalfImage(coc)
    image.find()
    kinds = texels_of(image.tiles)[0, :, 3].astype(int)
    found = {name: [bool(kind & bit) for kind in kinds] for name, bit in bits.items()}
    assert found["HAS_WIDE_END"] == [True, False, False, True, False]
    assert found["HAS_END"] == [True, True, True, True, False]
    np.testing.assert_allclose(texels_of(image.reach[0]["widest"]), 9 * np.sqrt(2), rtol=0.02)


@pytest.mark.parametrize("radius_px", [1.5, 2.8, 5.0, 9.0, 14.0])
def test_a_lamp_keeps_its_light_and_gets_the_width_of_a_disc(ctx, radius_px):
    """One surface: four places within a tile, so that no texel is preferred."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    for across, down in ((64, 40), (67, 43), (71, 46), (73, 49)):
        rgb = np.zeros((HEIGHT, WIDTH, 3))
        rgb[down : down + 2, across : across + 2] = 50.0
        found = blurred(ctx, rgb, np.inf, radius_px)[..., 0]
        assert found.sum() == pytest.approx(200, rel=0.02)
        for place, middle in ((x, across + 1), (y, down + 1)):
            variance = float((found * (place - middle) ** 2).sum() / found.sum())
            near = 0.12 if radius_px < 10 else 0.2  # wider discs have as few as ten texels
            assert variance == pytest.approx(radius_px**2 / 4 + 1 / 3, rel=near)


@pytest.mark.parametrize("size_px", [(1, 1), (3, 5), (2, 200), (515, 9)])
def test_at_any_size_and_focus_light_stays_within_that_of_the_image(ctx, size_px):
    rgb = picture(1, size_px, peak=65504.0)
    distance = np.where(surfaces(1, size_px) == 1.3, 1e-3, surfaces(1, size_px))
    for focus_m in (1e-3, 1.0, 1e4):
        found = blurred(ctx, rgb, distance, 0.05 * size_px[0], focus_m)
        assert np.isfinite(found).all()
        assert found.min() >= float(rgb.min()) * (1 - 2**-10)
        assert found.max() <= float(rgb.max()) * (1 + 2**-10)


def test_numbers_between_the_two_engines_are_refused():
    assert DepthOfField(samples=12).samples == 12
    with pytest.raises(ValidationError, match="gathered at half resolution"):
        DepthOfField(samples=13)


@pytest.mark.parametrize(
    ("radius_px", "lamp_px"), [(5.0, 1.5), (5.0, 7.0), (10.0, 3.0), (17.0, 1.5), (17.0, 7.0)]
)
def test_a_near_lamp_before_what_is_in_focus_keeps_its_light(ctx, radius_px, lamp_px):
    """However coarse the texels are that it shares with what is in focus."""
    y, x = np.mgrid[:128, :128] + 0.5
    lamp = np.hypot(x - 65.3, y - 62.2) < lamp_px
    rgb = np.where(lamp, 280.0, 0.2)[..., None] * np.ones(3)
    radii = np.where(lamp, -radius_px, 0.0)
    lit = blur(ctx, "vrcomfort", rgb, radii, max_radius_px=18.0, samples=12).rgb.astype(float)
    assert (lit - 0.2).sum() == pytest.approx((rgb - 0.2).sum(), rel=0.08)


def test_a_near_lamp_beside_a_wider_disc_stays_as_wide_as_it_is(ctx):
    y, x = np.mgrid[:160, :160] + 0.5
    away = np.hypot(x - 81.3, y - 78.2)
    rgb = np.where(away < 2, 200.0, 0.05)[..., None] * np.ones(3)
    radii = np.where(away < 2, -6.0, np.where(x < 50, -35.0, 0.0))
    lit = blur(ctx, "vrcomfort", rgb, radii, max_radius_px=35.0, samples=12).rgb.astype(float)
    assert lit[away > 14].max() < 0.5
    assert lit[away < 3].min() > 10


def test_a_near_lamp_has_no_bright_lines_where_sharp_and_blurred_things_meet(ctx):
    """Before a fence in focus and a wall far behind it: nothing outshines the lamp's disc."""
    y, x = np.mgrid[:160, :160] + 0.5
    lamp = np.hypot(x - 81.3, y - 78.2) < 3
    fence = (x + 0.3 * y) % 23 < 9
    rgb = np.where(lamp, 280.0, np.where(fence, 0.5, 0.1))[..., None] * np.ones(3)
    radii = np.where(lamp, -12.0, np.where(fence, 0.0, 9.0))
    lit = blur(ctx, "vrcomfort", rgb, radii, max_radius_px=18.0, samples=12).rgb.astype(float)
    disc = 280 * lamp.sum() / (np.pi * 12**2)
    assert lit.max() < 2 * disc
    assert lit[np.hypot(x - 81.3, y - 78.2) > 20].max() < 0.6


def test_a_thin_near_bar_lets_what_is_beside_it_be_seen(ctx):
    """A border in focus goes on behind a bar whose disc is much wider than the bar."""
    y, x = np.mgrid[:160, :160] + 0.5
    bar = np.abs(y - 81) < 3
    rgb = np.where(bar, 0.0, np.where(x < 80, 0.1, 0.8))[..., None] * np.ones(3)
    radii = np.where(bar, -35.0, 0.0)
    lit = blur(ctx, "vrcomfort", rgb, radii, max_radius_px=35.0, samples=12).rgb[..., 0]
    beside, inside = lit[[72, 89]].mean(axis=0), lit[79:83].mean(axis=0)
    clear = np.abs(x[0] - 80) > 6
    np.testing.assert_allclose(inside[clear], beside[clear], atol=0.06)


def test_what_a_wide_near_bar_hides_has_no_step_along_coarse_texels(ctx):
    """White and black in focus beside a bar of 64 px: between them it passes from one to the other.

    Seen beside it on the coarsest level are texels of 16 px whose middles are 40 px to either side.
    """
    _, x = np.mgrid[:160, :160] + 0.5
    bar = np.abs(x - 80) < 32
    rgb = np.where(bar, 0.0, np.where(x < 80, 1.0, 0.0))[..., None] * np.ones(3)
    radii = np.where(bar, -35.0, 0.0)
    lit = blur(ctx, "vrcomfort", rgb, radii, max_radius_px=35.0, samples=12).rgb[80, :, 0]
    steps = np.abs(np.diff(lit.astype(float)))[52:108]
    assert steps.max() < 0.03
    assert steps.sum() > 0.3


def test_a_lamp_s_light_keeps_its_disc_in_texels_that_it_shares(ctx):
    """Behind the focus both are one surface there: its radius is that of most of the light."""
    y, x = np.mgrid[:160, :160] + 0.5
    lamp = np.hypot(x - 81.3, y - 78.2) < 4
    rgb = np.where(lamp, 200.0, 0.05)[..., None] * np.ones(3)
    radii = np.where(lamp, 7.0, 35.0)
    lit = blur(ctx, "vrcomfort", rgb, radii, max_radius_px=35.0, samples=12).rgb.astype(float)
    assert lit[np.hypot(x - 81.3, y - 78.2) > 35].max() < 0.1


def test_a_radius_carries_how_much_its_surface_covers(ctx):
    """In steps of a sixty-fourth of it, in front of the focus and behind it, or next to it."""
    parts = [1.0, 0.9, 0.75, 0.5, 0.25, 0.1, 0.02, 0.0]
    kept = [1.0, 1.0, 0.75, 0.5, 0.25, 0.125, 1 / 64, 1 / 64]
    given = np.array([(r, part, 0, 0) for r in (-17.0, 0.0, 40.0) for part in parts], "f4")
    written = "with_coverage(x.x, coverage_code(x.y), x.x > 1.0)"
    call = (
        f"vec4({written}, coverage_of({written}), float(is_small({written})), coverage_of_code(2u))"
    )
    found = evaluate(ctx, "half_coverage.glsl", call, given)
    np.testing.assert_allclose(found[:, 0], given[:, 0], rtol=1 / 64, atol=2e-3)
    np.testing.assert_array_equal(found[:, 1], kept * 3)
    np.testing.assert_array_equal(found[:, 2], given[:, 0] > 1)
    np.testing.assert_array_equal(found[:, 3], 0.5)


def test_images_of_half_the_size_share_each_disc(ctx):
    x = np.zeros((300, 4), "f4")
    x[:, 0] = np.linspace(0.5, 60, 300)
    parts = ", ".join(f"half_level_part({level}, x.x)" for level in range(4))
    defines = {"LEVELS": 4, "TEXELS_PER_PX": blur_kernels.HALF_TEXELS_PER_PX}.items()
    files = "eyes.glsl coc.glsl discs.glsl half_levels.glsl"
    found = evaluate(ctx, files, f"vec4({parts})", x, defines=defines)
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=1e-5)
    assert (found > 0).sum(axis=1).max() == 2
    # As many texels as a radius of 2.8 of them has, but for the finest and the coarsest image.
    level, radius = np.nonzero(found[:, 1:3] > 0)[1] + 1, x[np.nonzero(found[:, 1:3] > 0)[0], 0]
    assert (radius / 2.0 ** (level + 1)).min() > 1.3
    assert (radius / 2.0 ** (level + 1)).max() < 3.1
    narrower = evaluate(ctx, files, "vec4(narrowed_px(x.x, 2.0))", x, defines=defines)[:, 0]
    assert (narrower < x[:, 0]).all()
    wide = x[:, 0] > 4
    np.testing.assert_allclose(x[wide, 0] ** 2 - narrower[wide] ** 2, 3.2, rtol=1e-3)


@pytest.mark.parametrize("radius_px", [1.7, 2.9, -6.0, 13.0])
def test_a_depth_discontinuity_out_of_reach_changes_nothing(ctx, radius_px):
    """Plain means beside it are those of the shader that asks what is nearer."""
    rgb = picture()
    radii = np.full((HEIGHT, WIDTH), radius_px)
    plain = blur(ctx, "vrcomfort", rgb, radii, max_radius_px=16.0, samples=12).rgb.astype(float)
    radii[40:50, 70:80] = 0.0
    lit = blur(ctx, "vrcomfort", rgb, radii, max_radius_px=16.0, samples=12).rgb.astype(float)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    away = np.hypot(np.maximum(abs(x - 74.5) - 4.5, 0), np.maximum(abs(y - 44.5) - 4.5, 0))
    beyond = away > 1.3 * abs(radius_px) + 10
    np.testing.assert_array_equal(lit[beyond & (away > 40)], plain[beyond & (away > 40)])
    # Small discs have five taps instead of eight.
    near = 0.45 if abs(radius_px) < 3.5 else 0.02
    np.testing.assert_allclose(lit[beyond], plain[beyond], atol=near)
