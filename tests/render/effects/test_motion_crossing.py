"""Motion blur where a front goes one way and what is behind it another, faster or slower."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles import motion
from tests.render.effects.test_optics import evaluate
from tests.support.effects import motion_blur, motion_blur_pass, texels_of
from vrcomfort.optics.motion import sampling_of

WIDTH, HEIGHT, FINER = 160, 128, 2
WHOLE = {"shutter_fraction": 1.0, "max_radius_percent": 20.0, "samples": 16}
FRONTS = {
    "bar": lambda _, y: np.abs(y) < 16,
    "thin bar": lambda _, y: np.abs(y) < 1,
    "box": lambda x, y: (np.abs(x) < 20) & (np.abs(y) < 20),
}
"""From the middle of the image, px; the thin one is in no tile alone."""
UP, SIDEWAYS = (0.0, 1.0), (1.0, 0.0)
DIAGONAL, OTHER_DIAGONAL = (0.75, 0.75), (-0.75, 0.75)


def covered(shape, finer=1):
    """Return whether each of `finer` x `finer` points of each pixel is on the front."""
    y, x = (np.mgrid[: HEIGHT * finer, : WIDTH * finer] + 0.5) / finer
    return FRONTS[shape](x - WIDTH / 2, y - HEIGHT / 2)


@cache
def brute_force(shape, velocity, instants=41):
    """Return (h, w): how long the front is before each pixel while it goes by, of the shutter."""
    mask = covered(shape, FINER).astype(float)
    instant = (np.arange(instants) + 0.5) / instants - 0.5
    moved = np.rint(instant[:, None] * np.array(velocity)[::-1] * FINER).astype(int)
    mean = np.mean([np.roll(mask, tuple(step), axis=(0, 1)) for step in moved], axis=0)
    return mean.reshape(HEIGHT, FINER, WIDTH, FINER).mean(axis=(1, 3))


def of_front(ctx, shape, front_velocity, back_velocity, **settings):
    """Return (h, w): how much of each blurred pixel is the front's."""
    front = covered(shape)[..., None]
    rgb, distance_m = np.where(front, [1.0, 0, 0], [0, 0, 1.0]), np.where(front[..., 0], 0.5, 5.0)
    velocity = np.where(front, front_velocity, back_velocity)
    blurred = motion_blur(ctx, rgb, distance_m, velocity, **WHOLE | settings).astype(float)
    np.testing.assert_allclose(blurred.sum(axis=-1), 1, atol=2e-3)
    return blurred[..., 0]


def assert_swept(found, shape, velocity):
    """Check a front's rim and all that is found of it outside against brute force."""
    alpha, outside = brute_force(shape, velocity), ~covered(shape)
    rim = (alpha > 1e-3) & (alpha < 0.999)
    if rim.any():
        assert np.sqrt(np.mean((found - alpha)[rim] ** 2)) < 0.02
    assert found[outside].sum() == pytest.approx(alpha[outside].sum(), rel=0.03, abs=1e-3)


@pytest.mark.parametrize(
    ("front_way", "back_way", "back_px"),
    [
        *((UP, SIDEWAYS, back_px) for back_px in (0.0, 19.0, 21.0, 40.0)),
        (SIDEWAYS, UP, 40.0),
        (DIAGONAL, OTHER_DIAGONAL, 21.0),
        (UP, DIAGONAL, 19.0),
    ],
)
@pytest.mark.parametrize("shape", FRONTS)
def test_a_front_sweeps_over_what_goes_another_way(ctx, shape, front_way, back_way, back_px):
    velocity = tuple(20.0 * v for v in front_way)
    found = of_front(ctx, shape, velocity, back_px * np.array(back_way))
    assert_swept(found, shape, velocity)


@pytest.mark.parametrize("back_px", [12.0, 28.0, 40.0, -40.0])
@pytest.mark.parametrize("shape", FRONTS)
def test_a_front_sweeps_over_what_goes_the_same_way(ctx, shape, back_px):
    velocity = (0.0, 20.0)
    assert_swept(of_front(ctx, shape, velocity, [0.0, back_px]), shape, velocity)


@pytest.mark.parametrize("samples", [4, 8, 32])
def test_a_crossing_front_is_found_with_any_number_of_samples(ctx, samples):
    velocity = (0.0, 20.0)
    found = of_front(ctx, "box", velocity, [40.0, 0.0], samples=samples)
    assert_swept(found, "box", velocity)


@pytest.mark.parametrize("ways_deg", [(90, 0), (90, 40), (90, -60), (75, -15)])
def test_of_two_fronts_before_what_is_still_each_is_found_once(ctx, ways_deg):
    """Neither sweeps over what the other does; tiles between them are in reach of both."""
    x, y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    left, right = ((x >= start) & (x < start + 36) & (np.abs(y - 63.5) < 16) for start in (40, 96))
    turn = np.radians(ways_deg)
    ways = np.stack([np.cos(turn), np.sin(turn)], axis=-1) * [[20], [34]]
    either = [left[..., None], right[..., None]]
    rgb = np.select(either, [[1.0, 0, 0], [0, 1.0, 0]], [0, 0, 1.0])
    distance_m = np.where(left | right, 0.5, 5.0)
    blurred = motion_blur(ctx, rgb, distance_m, np.select(either, ways, 0.0), **WHOLE)
    light = blurred.astype(float).sum(axis=(0, 1))
    np.testing.assert_allclose(light[:2], 36 * 32, rtol=0.015)


@pytest.mark.parametrize("way", [[0.0, 20.0], [0.0, 6.0], [20.0, 20.0]])
def test_a_tile_tells_the_slower_of_two_that_cross(ctx, way):
    """All tiles have the faster back in them; the limit shortens nothing here."""
    front = covered("thin bar")[..., None]
    back = np.array([40.0, 0.0])
    effect = motion_blur_pass(
        ctx, np.ones((HEIGHT, WIDTH, 3)), 2.0, np.where(front, way, back), **WHOLE
    )
    longest, crossing = map(texels_of, effect._method.tiles)
    columns = longest.shape[1]
    beside = slice(2, 6)  # rows of tiles with the bar, which lies on the rim of two, and next to it
    np.testing.assert_array_equal(longest[beside, :, :3], [[[*back / 2, 2]] * columns] * 4)
    np.testing.assert_array_equal(crossing[beside], [[np.array(way) / 2] * columns] * 4)
    np.testing.assert_array_equal(crossing[1], 0)  # a tile lies between, farther than it goes


@pytest.mark.parametrize("way", [[-40.0, 0.0], [10.0, 0.0], [40.0, 7.0], [0.0, 0.0], [0.0, 0.4]])
def test_nothing_crosses_where_all_go_along_one_line(ctx, way):
    velocity = np.where(covered("bar")[..., None], way, [40.0, 0.0])
    effect = motion_blur_pass(ctx, np.ones((HEIGHT, WIDTH, 3)), 2.0, velocity, **WHOLE)
    longest, crossing = map(texels_of, effect._method.tiles)
    assert (longest[..., 2] == 2).any()
    np.testing.assert_array_equal(crossing, 0)


def test_shader_thresholds_are_the_twins(ctx, rng):
    """On either side of each, 1 part in 1000 away."""
    x = rng.uniform(0, 1, (300, 4)).astype("f4") * np.float32([20, 2, 10, 3])
    x[:100, 3] = motion.jump_px(x[:100, 2]) * rng.choice([0.999, 1.001], 100)
    x[100:200, :2] *= (motion.LEAST_PX / np.hypot(*x[100:200, :2].T))[:, None]
    x[100:200, :2] *= rng.choice([0.999, 1.001], 100)[:, None]
    kinds = evaluate(ctx, "motion_tile_classes.glsl", "vec4(class_of(x.xy, x.z, x.w))", x)[:, 0]
    alike = [
        motion.moves_alike(r[:2], shortest_px=r[2], steepness_px=r[3]) for r in x.astype(float)
    ]
    assert set(kinds.tolist()) == {0.0, 1.0, 2.0}
    np.testing.assert_array_equal(kinds == 1, alike)
    of_one_tile = "vec4(may_be_complex(vec3(length(x.xy), x.w, x.z)))"
    mixed = evaluate(ctx, "motion_tile_classes.glsl", of_one_tile, x)[:, 0]
    np.testing.assert_array_equal(mixed == 1, kinds == 2)
    call = "vec4(tolerance_px(x.x), jump_px(x.x), LEAST_PX, 0)"
    tolerance, jump, least, _ = evaluate(ctx, "motion_tile_classes.glsl", call, x).T
    np.testing.assert_allclose(tolerance, motion.tolerance_px(x[:, 0]), rtol=1e-6)
    np.testing.assert_allclose(jump, motion.jump_px(x[:, 0]), rtol=1e-6)
    np.testing.assert_array_equal(least, motion.LEAST_PX)


def test_kinds_of_frames_are_the_twins(ctx, rng):
    """On either side of each threshold."""
    x = rng.uniform(0, 30, (400, 4)).astype("f4")  # shortest, longest, two slopes
    x[:, 1] = np.maximum(x[:, 0], x[:, 1])
    x[:, 2] = np.exp(rng.uniform(-1, 1, 400))
    x[:, 3] = np.exp(rng.uniform(-0.5, 2, 400)) / x[:, 2]
    for samples in (8, 16):
        how = sampling_of(samples, 640)
        names = ("ONE_STEP_PX", how.one_step_px), ("HALVES", int(how.halves))
        call = "vec4(kind_of(x.x, x.y, x.zw))"
        found = evaluate(ctx, "frame_kinds.glsl", call, x, defines=names)[:, 0]
        wanted = [motion.frame_kind(*row[:2], row[2:], how) for row in x.astype(float)]
        np.testing.assert_array_equal(found, wanted)
        assert set(wanted) == ({0, 1, 2, 3} if samples == 8 else {0, 1})


def test_shader_crossings_and_shares_are_the_twins(ctx, rng):
    x = (rng.normal(0, 1, (400, 4)) * 10 ** rng.uniform(-1, 2, (400, 1))).astype("f4")
    x[:100, :2] = x[:100, 2:] * rng.uniform(-1, 1, (100, 1))  # along the line
    x[100:110, :2] = 0
    u, line = x[:, :2].astype(float), x[:, 2:].astype(float)
    other = np.float32([-3.0, 11.0])
    call = (
        "vec4(beside_px(x.xy, x.zw), crosses(x.xy, x.zw), share_along(x.xy, x.zw, b.xy),"
        " share_along(x.xy, x.zw, vec2(0.0)))"
    )
    constants = [[0] * 4, [*other, 0, 0]]
    found = evaluate(ctx, "motion_tile_classes.glsl", call, x, constants=constants).T
    beside, crosses, share, alone = found
    scale = np.hypot(*u.T)
    np.testing.assert_allclose(
        beside, motion.beside_px(u, line), rtol=1e-5, atol=1e-6 * scale.max()
    )
    clear = np.abs(motion.beside_px(u, line) - motion.LEAST_PX - 0.2 * scale) > 1e-5 * (1 + scale)
    np.testing.assert_array_equal(crosses[clear], motion.crosses(u, line)[clear])
    np.testing.assert_allclose(share, motion.share_along(u, line, other), atol=1e-4)
    np.testing.assert_array_equal(alone, 1)
    call = "vec4(farther_beside(b.xy, x.xy, x.zw), 0, 0)"
    farther = evaluate(ctx, "motion_tile_classes.glsl", call, x, constants=constants)[:, :2]
    second = motion.beside_px(line, other) > motion.beside_px(u, other)
    np.testing.assert_array_equal(farther, np.where(second[:, None], x[:, 2:], x[:, :2]))


degrees = st.floats(0, 360)


@given(degrees, degrees, st.floats(12, 168), st.floats(0.5, 300))
def test_a_front_counts_once_along_two_lines(front_deg, first_deg, apart_deg, length_px):
    ways = np.radians([front_deg, first_deg, first_deg + apart_deg])
    u, first, second = np.stack([np.cos(ways), np.sin(ways)], axis=-1) * [[length_px], [7], [30]]
    shares = motion.share_along(u, first, second), motion.share_along(u, second, first)
    assert sum(shares) == pytest.approx(1)
    assert min(shares) >= 0
    for line, other in ((first, second), (second, first)):
        assert motion.share_along(line, line, other) == 1
        assert motion.share_along(-line, other, line) == pytest.approx(0, abs=1e-12)
    assert motion.share_along(u, first, -second) == pytest.approx(shares[0])
    assert motion.share_along([-first[1], first[0]], first, second) == pytest.approx(0, abs=1e-9)


@pytest.fixture
def rng():
    return np.random.default_rng(1)
