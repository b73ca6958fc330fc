"""The kernels of the sources: their twins, pixels worked out by hand, and what each does wrong."""

from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.ndimage import label

from tests.oracles import half_resolution, poisson_taps, pyramid, scattering
from tests.support.effects import depth_of_field, seen, square_pixels, textures
from tests.support.kernels import FOCUS_M, blur
from vrcomfort.geometry import Pose, axis_angle, rotate
from vrcomfort.optics.blur_kernels import POISSON_12, POISSON_15, pyramid_levels
from vrcomfort.optics.circle_of_confusion import head_depth_slope
from vrcomfort.protocol.conditions import DepthOfField, Kernel
from vrcomfort.render.effects.depth_of_field.effect import DepthOfFieldPass
from vrcomfort.render.effects.depth_of_field.engine_kernels import disc_taps
from vrcomfort.render.effects.effect import EffectInputs

ENGINES = ("half_resolution_disc", "ring_gather", "separable_gaussian")
KERNELS = ("scatter", "poisson12", "poisson15_near", "mip", "mip_slices", *ENGINES)
radii = st.floats(-16, 16)


def twin(kernel, found, pixel_aspect):
    limit = {"max_radius_px": found.max_radius_px}
    aspect = {"pixel_aspect": pixel_aspect}
    made = {
        "scatter": lambda points: scattering.scatter(points, **aspect),
        "poisson12": lambda points: poisson_taps.poisson12(points, **aspect, **limit),
        "poisson15_near": lambda points: poisson_taps.poisson15_near(points, **aspect, **limit),
        "half_resolution_disc": lambda points: half_resolution.disc(points, **aspect, **limit),
        "ring_gather": lambda points: half_resolution.rings(points, **aspect, **limit),
        "separable_gaussian": lambda points: half_resolution.separable_gaussian(points, **aspect),
        "mip": lambda points: pyramid.mip(points, **limit),
        "mip_slices": lambda points: pyramid.mip(points, slices=True, **limit),
    }
    return made[kernel](found.points)


def test_the_taps_of_the_disc_are_its_middle_and_three_rings():
    away = np.round(np.linalg.norm(disc_taps(), axis=1) * 22).astype(int)
    assert away.tolist() == [0, *7 * [8], *14 * [15], *21 * [22]]


@pytest.fixture
def rng():
    return np.random.default_rng(1)


def columns(width=64, height=48):
    return np.arange(width)[None, :].repeat(height, axis=0)


def ulps(a, b):
    return np.abs(a.view("i2").astype(int) - b.view("i2").astype(int)).max()


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_kernel_is_its_twin(ctx, rng, kernel):
    rgb = rng.uniform(0, 1, (17, 16, 3)).astype("f2")
    radius = rng.uniform(-6, 6, (17, 16)) * rng.integers(0, 2, (17, 16))
    found = blur(ctx, kernel, rgb, radius, max_radius_px=6.0, pixel_aspect=1.25)
    # Half floats, and in pyramids one after the other.
    np.testing.assert_allclose(found.rgb, twin(kernel, found, 1.25), atol=2**-9)
    assert np.abs(found.rgb - rgb).max() > 0.1


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_constant_image_stays_constant(ctx, rng, kernel):
    rgb = np.tile(np.array([0.3, 1.7, 900.0], "f2"), (47, 61, 1))
    radius = rng.uniform(-7, 7, (47, 61))
    radius[:20] = np.linspace(-7, 7, 61)
    found = blur(ctx, kernel, rgb, radius, max_radius_px=7.0)
    assert ulps(found.rgb, rgb) <= (2 if kernel in ENGINES else 1), "half floats, pass after pass"


@pytest.mark.parametrize("kernel", KERNELS)
def test_what_is_in_focus_is_copied_bit_for_bit(ctx, rng, kernel):
    rgb = np.exp(rng.uniform(-14, 11, (21, 35, 3))).astype("f2")
    rgb[0] = 65504
    found = blur(ctx, kernel, rgb, 0.0, max_radius_px=8.0)
    np.testing.assert_array_equal(found.rgb.view("i2"), rgb.view("i2"))


def test_without_aperture_every_kernel_gives_the_pinhole_image(ctx, rng):
    rgb = np.exp(rng.uniform(-9, 11, (13, 21, 3))).astype("f2")
    distance_m = rng.uniform(0.1, 50, (13, 21))
    for kernel in get_args(Kernel):
        found = depth_of_field(ctx, rgb, distance_m, FOCUS_M, kernel=kernel, max_radius_percent=0)
        np.testing.assert_array_equal(found.view("i2"), rgb.view("i2"), err_msg=kernel)


@pytest.mark.parametrize("kernel", KERNELS)
def test_extremes_stay_finite_and_within_the_image(ctx, rng, kernel):
    for (width, height), max_radius_px in (((1, 1), 40.0), ((7, 5), 1e-3), ((33, 17), 3.0)):
        rgb = np.exp2(rng.uniform(-14, 15.99, (height, width, 3))).astype("f2")
        rgb[rng.random((height, width)) < 0.3] = 65504
        mixed = rng.uniform(-max_radius_px, max_radius_px, (height, width))
        for radius in (-max_radius_px, max_radius_px, mixed):
            out = blur(ctx, kernel, rgb, radius, max_radius_px=max_radius_px).rgb
            assert np.isfinite(out).all()
            assert out.max() <= rgb.max()
            assert out.min() >= rgb.min() * (1 - 2**-9)


@pytest.mark.parametrize(
    ("kernel", "radius_px"),
    [("scatter", 1.5), ("scatter", 6.4), ("poisson15_near", 1.5), ("poisson15_near", 4.0)],
)
def test_a_bright_patch_keeps_its_energy_and_gets_the_discs_variance(ctx, kernel, radius_px):
    rgb = np.zeros((48, 64, 3))
    rgb[22:26, 30:34] = 1.0
    found = blur(ctx, kernel, rgb, radius_px, max_radius_px=8.0).rgb[..., 0].astype(float)
    assert found.sum() == pytest.approx(16, rel=0.005)
    y, x = np.mgrid[-23.5:24, -31.5:32]
    for axis in (x, y):
        variance = np.sum(found * axis**2) / found.sum() - 15 / 12
        assert variance == pytest.approx(radius_px**2 / 4, rel=0.12, abs=0.2)


def test_twelve_turned_taps_keep_the_energy_on_average(ctx):
    """Each pixel has its own weights, so a single patch keeps it only on average over places."""
    rgb = np.where((columns(128, 96) // 4 + np.arange(96)[:, None] // 4) % 4 == 0, 1.0, 0.0)
    rgb = np.repeat(rgb[..., None], 3, axis=-1)
    found = blur(ctx, "poisson12", rgb, 5.0, max_radius_px=8.0).rgb.astype(float)
    inside = found[16:80, 16:112, 0]
    assert inside.mean() == pytest.approx(0.25, rel=0.03)


def test_scatter_spreads_one_pixel_over_its_disc(ctx):
    rgb = np.zeros((9, 9, 3))
    rgb[4, 4] = 1.0
    radius = np.where(rgb[..., 0] > 0, 2.0, 0.0)
    found = blur(ctx, "scatter", rgb, radius, max_radius_px=2.0).rgb[..., 0].astype(float)
    area = np.pi * (2**2 + 1 / 12)
    assert found[4, 4] == 1.0  # nothing else arrives there
    assert found[4, 5] == pytest.approx((1 / area) / (1 + 1 / area), abs=1e-3)
    assert found[4, 6] == pytest.approx((0.5 / area) / (1 + 0.5 / area), abs=1e-3)
    assert found[4, 7] == 0


def test_scatter_draws_discs_that_are_wider_than_a_drivers_points(ctx, rng):
    rgb = rng.uniform(0, 1, (12, 14, 3)).astype("f2")
    radius = rng.uniform(-9, 9, (12, 14)) * rng.integers(0, 2, (12, 14))
    widest = ctx.info["GL_POINT_SIZE_RANGE"][1]
    found = blur(ctx, "scatter", rgb, radius, max_radius_px=widest, pixel_aspect=1.25)
    np.testing.assert_allclose(found.rgb, twin("scatter", found, 1.25), atol=2**-9)


def test_the_nearer_side_does_not_matter_to_scatter(ctx):
    """No depth is asked: half a disc arrives at the edge, over a sharp pixel of weight 1."""
    left = columns() < 32
    rgb = np.where(left[..., None], [1.0, 0, 0], [0, 0, 1.0])
    for sign in (-1, 1):
        found = blur(ctx, "scatter", rgb, np.where(left, sign * 6.0, 0.0), max_radius_px=6.0).rgb
        profile = found[24, :, 0].astype(float)
        x = (np.arange(64) - 31.5)[32:38] / 6.0
        arriving = 0.5 - (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
        np.testing.assert_allclose(profile[32:38], arriving / (1 + arriving), atol=0.02)
        assert np.all(profile[39:] == 0)
        np.testing.assert_allclose(profile[:32], 1.0, atol=1e-3)  # sharp pixels do not spread


@pytest.fixture
def edge():
    """Red on the left, blue on the right, 32 columns each."""
    return np.where((columns() < 32)[..., None], [1.0, 0, 0], [0, 0, 1.0])


def test_turned_taps_make_noise_of_ghosts(ctx):
    """Hillaire et al. 2008, Fig. 2: a bright dot is seen twelve times, or scattered over the disc.

    Each ghost is one patch, of the four pixels between which a tap's colour is interpolated.
    """
    rgb = np.zeros((40, 40, 3))
    rgb[20, 20] = 1.0
    patches = {}
    for turned in (True, False):
        found = blur(ctx, "poisson12", rgb, 10.0, max_radius_px=10.0, rotate_taps=turned)
        expected = poisson_taps.poisson12(
            found.points, max_radius_px=found.max_radius_px, rotate_taps=turned
        )
        np.testing.assert_allclose(found.rgb, expected, atol=2**-9)
        patches[turned] = label(found.rgb[..., 0] > 0)[1]
    assert patches[False] == len(POISSON_12)  # one of them beside the dot itself
    assert patches[True] > 2 * patches[False]


def test_twelve_taps_do_not_leak_a_sharp_front(ctx, edge):
    front = columns() < 32
    found = blur(ctx, "poisson12", edge, np.where(front, 0.0, 6.0), max_radius_px=6.0).rgb
    np.testing.assert_array_equal(found[front], edge[front])
    # Half a pixel of it may be in a tap's bilinear colour, and one tap in a few ends there.
    assert found[:, 32:, 0].astype(float).mean(axis=0).max() < 0.05


def test_twelve_taps_keep_the_outline_of_a_blurred_front(ctx, edge):
    front = columns() < 32
    found = blur(ctx, "poisson12", edge, np.where(front, -6.0, 0.0), max_radius_px=6.0).rgb
    np.testing.assert_array_equal(found[~front], edge[~front])  # hard outside ...
    assert 0.3 < found[:, 31, 2].astype(float).mean() < 0.6  # ... mixed with the back inside
    assert np.all(found[:, 25, 2] == 0)


def test_a_nearer_tap_counts_as_far_as_it_is_blurred(ctx, edge):
    """A front blurred by half the largest circle, before a back that is blurred fully."""
    front = columns() < 32
    half = blur(ctx, "poisson12", edge, np.where(front, -4.0, 8.0), max_radius_px=8.0).rgb
    full = blur(ctx, "poisson12", edge, np.where(front, -8.0, 8.0), max_radius_px=8.0).rgb
    leaks = [found[:, 32, 0].astype(float).mean() for found in (half, full)]
    assert leaks[1] == pytest.approx(0.45, abs=0.06)  # 6 of 13
    assert leaks[0] == pytest.approx(3 / 10, abs=0.06)  # 6 · 0.5 of 1 + 6 · 0.5 + 6


def test_fifteen_taps_soften_a_blurred_front_and_what_is_beside_it(ctx):
    front = columns() < 32
    back = np.where(front, 0.0, columns() % 2)[..., None] * [0, 0, 1.0]
    rgb = np.where(front[..., None], [1.0, 0, 0], back)
    found = blur(ctx, "poisson15_near", rgb, np.where(front, -6.0, 0.0), max_radius_px=6.0).rgb
    red, blue = (found[20:28, :, channel].astype(float).mean(axis=0) for channel in (0, 2))
    assert 0.2 < red[32] < 0.6
    assert red[31] > red[32] > red[35]
    assert np.ptp(blue[33:37]) < 0.75  # the sharp stripes of the background are blurred with it
    np.testing.assert_array_equal(found[:, 44:], rgb[:, 44:].astype("f2"))


def test_fifteen_taps_leak_a_sharp_front(ctx, edge):
    front = columns() < 32
    found = blur(ctx, "poisson15_near", edge, np.where(front, 0.0, 6.0), max_radius_px=6.0).rgb
    np.testing.assert_array_equal(found[front], edge[front])
    assert found[24, 32, 0] > 0.3


def test_near_circles_widen_by_equation_2():
    radius = poisson_taps.spread_radius_px(
        [-4.0, 0.0, 0.0, 1.0, 7.0, -1.0], [2.0, 2.0, 6.0, 2.0, 2.0, 3.0], max_radius_px=8.0
    )
    np.testing.assert_allclose(radius, [4, 4, 8, 4, 7, 5])
    near = poisson_taps.near_mean_px([[-1.0] * 8 + [5.0, -4.0]])
    np.testing.assert_allclose(near, [[1.0, 2.0]])


@given(radii, st.floats(0, 16))
def test_a_spread_circle_is_never_narrower_than_its_own(radius_px, near_mean):
    spread = poisson_taps.spread_radius_px(radius_px, near_mean, max_radius_px=16.0)
    assert abs(radius_px) <= spread <= 16
    assert spread == abs(radius_px) or near_mean > 0


@given(radii, st.integers(1, 4), st.booleans())
def test_a_level_fades_in_as_the_radius_grows(radius_px, level, slices):
    here, wider = (pyramid.fade(r, level, slices=slices) for r in (abs(radius_px), 16.0))
    assert 0 <= here <= wider == 1
    assert pyramid.fade(0.0, level, slices=slices) == 0


@pytest.mark.parametrize("taps", [POISSON_12, POISSON_15])
def test_poisson_offsets_lie_apart_in_a_disc_of_diameter_1(taps):
    apart = np.linalg.norm(taps[:, None] - taps, axis=-1) + np.eye(len(taps))
    assert np.linalg.norm(taps, axis=-1).max() <= 0.5
    assert apart.min() > 0.2
    np.testing.assert_allclose(taps.mean(axis=0), 0, atol=1e-4)
    assert np.mean(np.sum(taps**2, axis=-1)) == pytest.approx(0.5**2 / 2, rel=1e-3)


@pytest.mark.parametrize("kernel", ["mip", "mip_slices"])
def test_pyramids_have_halos_and_hard_outlines(ctx, edge, kernel):
    left = columns() < 32
    halo = blur(ctx, kernel, edge, np.where(left, 0.0, 4.0), max_radius_px=4.0).rgb
    np.testing.assert_array_equal(halo[left], edge[left])
    assert 0.2 < halo[24, 32, 0] < 0.5  # a sharp front in blurred surroundings
    outline = blur(ctx, kernel, edge, np.where(left, -4.0, 0.0), max_radius_px=4.0).rgb
    np.testing.assert_array_equal(outline[~left], edge[~left])  # a blurred front


def test_a_level_is_blown_up_bilinearly(ctx):
    """Texels 4 px wide: a pixel lies an eighth or three eighths from their middles."""
    rgb = np.zeros((8, 16, 3))
    rgb[:, 8:12] = 1.0
    found = blur(ctx, "mip", rgb, 4.0, max_radius_px=4.0).rgb[4, :, 0]
    ramp = np.array([1, 3, 5, 7]) / 8
    np.testing.assert_allclose(found, [0] * 6 + [*ramp, *ramp[::-1]] + [0] * 2, atol=2**-10)


def test_slices_jump_where_a_level_begins_and_the_cross_fade_does_not(ctx):
    rgb = np.repeat((columns(64, 8) % 2)[..., None], 3, axis=-1).astype(float)
    radius = np.where(columns(64, 8) < 32, 1.41, 1.42)  # either side of the first billboard
    sharp_then_half = blur(ctx, "mip_slices", rgb, radius, max_radius_px=4.0).rgb[4, :, 0]
    np.testing.assert_array_equal(sharp_then_half[:32], rgb[4, :32, 0])
    np.testing.assert_array_equal(sharp_then_half[32:], 0.5)
    faded = blur(ctx, "mip", rgb, radius, max_radius_px=4.0).rgb[4, :, 0].astype(float)
    assert np.abs(faded[30:32] - faded[32:34]).max() < 0.01


@pytest.mark.parametrize("eye", [None, Pose((0.03, 0, -0.1), axis_angle([0, 1, 0], 0.1))])
def test_slices_stand_where_they_are_put_whatever_the_focus(ctx, rng, eye):
    """Sky, and something at the very lens, too; distances are those from the head."""
    rgb = rng.uniform(0, 1, (17, 23, 3)).astype("f2")
    distance_m = rng.choice([0.02, 0.9, 1.5, 2.5, 7.0, 3e4, np.inf], (17, 23))
    settings = {"kernel": "mip_slices", "slices_m": (1.0, 2.0, 5.0, 1000.0)}
    near, far = (
        depth_of_field(ctx, rgb, distance_m, focus_m, eye=eye, **settings) for focus_m in (0.5, 50)
    )
    np.testing.assert_array_equal(near, far)
    fov = square_pixels((23, 17))
    uv = np.stack(np.meshgrid((np.arange(23) + 0.5) / 23, (np.arange(17) + 0.5) / 17), axis=-1)
    where = eye or Pose()
    forward = rotate(where.inverse().orientation, [0, 0, -1])
    from_head_m = distance_m * head_depth_slope(fov, forward, uv) - where.position[2]
    expected = pyramid.sliced(rgb, from_head_m, settings["slices_m"])
    np.testing.assert_allclose(near, expected, atol=2**-9)


def test_a_far_focus_blurs_what_is_near_and_leaves_the_distance(ctx, rng):
    """The article's billboards with the Z-buffer's sense reversed: its extreme foreground blurs."""
    rgb = rng.uniform(0, 1, (24, 32, 3)).astype("f2")
    distance_m = np.where(np.arange(32) < 16, 0.5, 100.0) * np.ones((24, 1))
    settings = {"kernel": "mip_slices", "law": "dioptre", "max_radius_percent": 8.0}
    shown = depth_of_field(ctx, rgb, distance_m, 100.0, **settings)
    np.testing.assert_array_equal(shown[:, 16:], rgb[:, 16:])
    assert shown[:, :12].std() < 0.5 * rgb[:, :12].astype(float).std()


def test_slices_that_stand_still_know_no_largest_radius(ctx):
    """The circles of confusion that they do not follow limit nothing."""
    colour, depth = textures(ctx, np.zeros((8, 8, 3)), 30.0)
    focus = ctx.texture((1, 1), 4, np.full(4, 0.1, "f4").tobytes(), dtype="f4")
    found = {}
    for slices_m in (None, (1.0, 2.0, 3.0)):
        settings = DepthOfField(kernel="mip_slices", slices_m=slices_m)
        effect = DepthOfFieldPass(
            EffectInputs(ctx, settings, colour, {"depth": depth, "focus": focus})
        )
        effect.render(seen(square_pixels((8, 8))))
        found[slices_m] = effect.max_radius_px, len(effect.clamps())
    assert found == {None: (pytest.approx(0.14), 1), (1.0, 2.0, 3.0): (8.0, 0)}


def test_slices_that_do_not_recede_are_refused():
    with pytest.raises(ValidationError, match="must rise: the nearest billboard first"):
        DepthOfField(kernel="mip_slices", slices_m=(2.0, 1.0))


def test_every_texel_is_the_mean_of_the_pixels_it_covers(ctx, rng):
    """Odd sizes: the last texel of a level covers what is left."""
    rgb = rng.uniform(0, 1, (5, 7, 3)).astype("f2")
    found = blur(ctx, "mip_slices", rgb, 8.0, max_radius_px=8.0).rgb.astype(float)
    np.testing.assert_allclose(found, np.tile(rgb.astype(float).mean((0, 1)), (5, 7, 1)), atol=2e-3)
    level = pyramid.mean_level(np.arange(7.0)[None], 1)
    np.testing.assert_array_equal(level, [[0.5, 2.5, 4.5, 6.0]])


@pytest.mark.parametrize(("max_radius_px", "wanted"), [(0, 1), (2, 1), (2.1, 2), (16, 4), (1e9, 9)])
def test_the_last_level_is_at_least_as_blurred_as_the_widest_disc(max_radius_px, wanted):
    assert pyramid_levels(max_radius_px) == wanted


@pytest.mark.parametrize("radius_px", [1.0, 3.0, 8.0])
def test_a_pyramid_spreads_points_as_far_as_a_disc_on_average(radius_px):
    """Where a point lies in its texel matters to its blur; the mean over all places is a disc's."""
    places = np.arange(64, 72)
    moments = []
    for place in places:
        points = np.zeros((1, 136, 4))
        points[0, place, 0] = 1.0
        points[..., 3] = radius_px
        found = pyramid.mip(points, max_radius_px=8.0)[0, :, 0]
        moments.append([found.sum(), found @ (np.arange(136) - place) ** 2])
    np.testing.assert_allclose(np.mean(moments, axis=0), [1.0, radius_px**2 / 4], rtol=1e-12)


def test_fades_add_up_to_the_variance_of_the_disc():
    radius = np.linspace(0, 16, 200)
    variance = np.zeros(200)
    for level in range(1, 5):
        opacity = pyramid.fade(radius, level)
        variance = (1 - opacity) * variance + opacity * 4.0**level / 4
    np.testing.assert_allclose(variance, radius**2 / 4, atol=1e-12)


@pytest.mark.parametrize("kernel", ENGINES)
def test_engines_ways_blur_a_half_plane_behind_the_focus_about_as_wide_as_a_disc(ctx, kernel):
    rgb = np.where(columns() < 32, 1.0, 0.0)[..., None].repeat(3, axis=-1)
    found = blur(ctx, kernel, rgb, 6.0, max_radius_px=6.0).rgb[24, :, 0].astype(float)
    assert found[31] == pytest.approx(0.5, abs=0.12)
    assert found[32 - 12] > 0.97
    assert found[32 + 12] < 0.03
    assert (np.diff(found) <= 2**-9).all(), "no ghost, and no ring"


def test_the_gaussian_is_cut_off_where_the_engine_cuts_it(ctx):
    """A disc of 6 px has sigma 3: pixels up to 4.5, and the second of each pair, count."""
    rgb = np.zeros((64, 96, 3))
    rgb[30:34, 46:50] = 1.0
    found = blur(ctx, "separable_gaussian", rgb, 6.0, max_radius_px=8.0).rgb[..., 0].astype(float)
    assert found.sum() == pytest.approx(16, rel=0.02)
    away = np.arange(-6, 7)
    weight = np.exp(-0.5 * (away / 3) ** 2)
    expected = 15 / 12 + weight @ away**2 / weight.sum()
    y, x = np.mgrid[:64, :96] - np.array([31.5, 47.5])[:, None, None]
    for axis in (x, y):
        # Of the patch, and of the weights; reads between pixels spread by less than 1/4 each.
        variance = np.sum(found * axis**2) / found.sum()
        assert variance == pytest.approx(expected, abs=0.25)


@pytest.mark.parametrize("kernel", ENGINES)
def test_engines_ways_look_as_far_as_discs_go_and_no_farther(ctx, rng, kernel):
    """A limit that no disc reaches changes nothing: samples are not spread over it."""
    rgb = rng.uniform(0, 1, (48, 64, 3)).astype("f2")
    radius = np.linspace(2.0, 6.0, 64)[None].repeat(48, axis=0)
    near, far = (blur(ctx, kernel, rgb, radius, max_radius_px=px).rgb for px in (6.0, 18.0))
    np.testing.assert_allclose(near, far, atol=2**-8)


def test_rings_give_the_mean_over_a_disc_whose_centre_is_shifted_at_random(ctx):
    """A bright half plane behind the focus: far from its edge nothing, at it no bands but noise."""
    rgb = np.where(columns() < 32, 1.0, 0.0)[..., None].repeat(3, axis=-1)
    found = blur(ctx, "ring_gather", rgb, 8.0, max_radius_px=8.0).rgb[..., 0].astype(float)
    assert found[:, 20:44].std(axis=0).max() > 0.01
    reached = np.clip((31.5 - columns()[0]) / 8.0, -1.0, 1.0)
    covered = 0.5 + (reached * np.sqrt(1 - reached**2) + np.arcsin(reached)) / np.pi
    assert np.abs(found.mean(axis=0) - covered)[16:48].max() < 0.08
