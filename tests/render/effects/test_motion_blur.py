"""Motion blur on images whose streaks can be worked out by hand."""

import numpy as np
import pytest

from tests.oracles.motion import frame_kind, halved_weights, streak_weights
from tests.support.effects import motion_blur, motion_blur_pass, rgb_of, seen, texels_of
from vrcomfort.geometry import Pose, axis_angle
from vrcomfort.optics.motion import sampling_of
from vrcomfort.protocol.conditions import TurnRamp
from vrcomfort.render.camera import HeadStep

METHODS = pytest.mark.parametrize("method", ["reconstruction", "per_pixel"])
WHOLE = {"shutter_fraction": 1.0, "max_radius_percent": 10.0}
"""At 128 px: half streaks of at most 12.8 px."""


@pytest.fixture
def rng():
    return np.random.default_rng(2)


def columns(width=128, height=96):
    return np.arange(width)[None, :].repeat(height, axis=0)


@METHODS
@pytest.mark.smoke
def test_what_does_not_move_is_copied_exactly(ctx, rng, method):
    rgb = np.exp(rng.uniform(-9, 11, (37, 61, 3))).astype("f2")
    blurred = motion_blur(ctx, rgb, rng.uniform(0.1, 50, (37, 61)), 0.0, method=method, **WHOLE)
    np.testing.assert_array_equal(blurred.view("i2"), rgb.view("i2"))


@METHODS
def test_a_closed_shutter_copies_exactly(ctx, rng, method):
    rgb = rng.uniform(0, 9, (37, 61, 3)).astype("f2")
    blurred = motion_blur(ctx, rgb, 1.0, 30.0, shutter_fraction=0.0, method=method)
    np.testing.assert_array_equal(blurred, rgb)


@METHODS
def test_a_constant_image_stays_constant(ctx, rng, method):
    rgb = np.tile(np.array([0.3, 1.7, 900.0], "f2"), (96, 128, 1))
    velocity = rng.normal(0, 10, (96, 128, 2))
    blurred = motion_blur(
        ctx, rgb, rng.uniform(0.3, 9, (96, 128)), velocity, method=method, **WHOLE
    )
    assert np.abs(blurred.view("i2").astype(int) - rgb.view("i2")).max() <= 1


@pytest.mark.parametrize(("axis", "speed_px"), [(0, 4.0), (1, 12.0), (0, 20.0)])
@METHODS
def test_an_edge_becomes_a_ramp_as_long_as_the_streak(ctx, axis, speed_px, method):
    position = columns() if axis == 0 else columns(96, 128).T
    middle = position.shape[1 - axis] // 2
    rgb = np.where(position < middle, 1.0, 0.0)[..., None].repeat(3, axis=-1)
    velocity = speed_px * np.eye(2)[axis]
    blurred = motion_blur(ctx, rgb, 2.0, velocity, method=method, **WHOLE)[..., 0].astype(float)
    profile = blurred[48] if axis == 0 else blurred[:, 64]
    offset = np.arange(len(profile)) - (middle - 0.5)
    expected = np.clip(0.5 - offset / speed_px, 0, 1)
    np.testing.assert_allclose(profile, expected, atol=0.08)
    assert np.sqrt(np.mean((profile - expected)[middle - 20 : middle + 20] ** 2)) < 0.03


@pytest.mark.parametrize("shutter_fraction", [0.25, 0.5])
@METHODS
def test_the_shutter_sets_the_length(ctx, shutter_fraction, method):
    rgb = np.where(columns() == 64, 1.0, 0.0)[..., None].repeat(3, axis=-1)
    settings = WHOLE | {"shutter_fraction": shutter_fraction, "method": method}
    line = motion_blur(ctx, rgb, 2.0, [32.0, 0.0], samples=32, **settings)[48, :, 0].astype(float)
    x = np.arange(128) - 64
    assert line.sum() == pytest.approx(1, rel=0.02)
    assert np.sum(line * x) == pytest.approx(0, abs=0.05)  # centred on the frame's own pose
    width = np.sqrt(12 * np.sum(line * x**2))
    assert width == pytest.approx(32 * shutter_fraction, rel=0.1)


def test_a_still_foreground_stays_sharp_and_does_not_bleed(ctx):
    """Such as a thing that is locked to the head, before a world that rushes by."""
    bar = np.abs(columns() - 64) < 10
    rgb = np.where(bar[..., None], [1.0, 0, 0], [0, 0, 1.0])
    velocity = np.where(bar[..., None], 0.0, [20.0, 0.0])
    blurred = motion_blur(ctx, rgb, np.where(bar, 0.5, 5.0), velocity, **WHOLE).astype(float)
    np.testing.assert_array_equal(blurred[bar], rgb[bar])
    assert blurred[~bar][:, 0].max() <= 1 / 255


def test_a_moving_foreground_sweeps_over_a_still_background(ctx):
    bar = np.abs(columns() - 63.5) < 16
    rgb = np.where(bar[..., None], [1.0, 0, 0], [0, 0, 1.0])
    velocity = np.where(bar[..., None], [16.0, 0.0], 0.0)
    blurred = motion_blur(ctx, rgb, np.where(bar, 0.5, 5.0), velocity, **WHOLE).astype(float)
    offset = np.abs(np.arange(128) - 63.5) - 16  # from the edge, outwards
    expected = np.clip(0.5 - offset / 16, 0, 1)
    np.testing.assert_allclose(blurred[48, :, 0], expected, atol=0.08)
    np.testing.assert_allclose(blurred[48].sum(axis=-1), 1, atol=2e-3)


def test_a_plain_gather_does_not_know_who_hides_whom(ctx):
    """What the reconstruction is for: these are the plain gather's halo and its hard edge."""
    bar = np.abs(columns() - 63.5) < 16
    rgb = np.where(bar[..., None], [1.0, 0, 0], [0, 0, 1.0])
    distance = np.where(bar, 0.5, 5.0)
    plain = {**WHOLE, "method": "per_pixel", "samples": 20}
    behind = motion_blur(ctx, rgb, distance, np.where(bar[..., None], 0, [20.0, 0]), **plain)
    # 2 px outside the bar, 7.5 of the 20 px of the streak lie on it.
    assert behind[48, 63 - 18, 0] == pytest.approx(7.5 / 20, abs=1 / 20)
    before = motion_blur(ctx, rgb, distance, np.where(bar[..., None], [20.0, 0], 0), **plain)
    np.testing.assert_array_equal(before[48, :48], [[0, 0, 1]] * 48)
    assert before[48, 48, 0] == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize(
    ("half_velocity_px", "samples"),
    [
        (0.4, 2),
        (0.4, 16),
        (1.3, 4),
        (5.0, 2),
        (5.0, 4),
        (5.0, 8),
        (7.8, 8),
        (7.8, 16),
        (11.6, 4),
        (11.6, 8),
    ],
)
def test_a_point_is_spread_as_the_twin_says(ctx, half_velocity_px, samples):
    rgb = np.where(columns() == 64, 1.0, 0.0)[..., None].repeat(3, axis=-1)
    line = motion_blur(ctx, rgb, 2.0, [2 * half_velocity_px, 0.0], samples=samples, **WHOLE)[
        48, :, 0
    ]
    reach_px, how = float(np.float16(half_velocity_px)), sampling_of(samples, 128)
    if frame_kind(reach_px, reach_px, (0, 1e6), how) == 2:
        weights = [halved_weights(reach_px, at, [64], how)[0] for at in range(128)]
        np.testing.assert_allclose(line, weights, atol=2e-3)
        assert np.sum(weights) == pytest.approx(1, abs=2e-2)
        return
    weights = streak_weights(reach_px, samples=samples, width_px=128)
    n = len(weights) // 2
    np.testing.assert_allclose(line[64 - n : 65 + n], weights, atol=2e-3)
    assert line.astype(float).sum() == pytest.approx(1, abs=5e-3)


def test_halved_averages_lie_along_the_streak(ctx, rng):
    """Where all moves up and down, they are those of a frame on its side."""
    rgb = rng.uniform(0, 1, (128, 128, 3))
    across = motion_blur(ctx, rgb, 2.0, [23.0, 0.0], samples=8, **WHOLE)
    up = motion_blur(ctx, rgb.transpose(1, 0, 2)[::-1], 2.0, [0.0, 23.0], samples=8, **WHOLE)
    np.testing.assert_allclose(up[::-1].transpose(1, 0, 2), across, atol=2e-3)
    rows = motion_blur(ctx, rgb[:, :1].repeat(128, axis=1), 2.0, [23.0, 0.0], samples=8, **WHOLE)
    np.testing.assert_allclose(rows, rgb[:, :1].repeat(128, axis=1), atol=1e-3)


def waves(at_px):
    """Return (h, w, 3) of crossing waves with periods from 3 to 11 px, at (h, w, 2) places."""
    periods = np.array([[3.1, 17.0], [7.0, 4.3], [-5.0, 3.7], [11.0, 40.0]])
    phases = np.tensordot(at_px, 2 * np.pi / periods.T, axes=1)
    return np.repeat(1 + np.cos(phases).mean(axis=-1, keepdims=True), 3, axis=-1)


@pytest.mark.slow
def test_more_samples_are_closer(ctx):
    """The streak's own average is known where the image is made of waves."""
    places = np.stack(np.meshgrid(np.arange(128.0), np.arange(96.0)), axis=-1)
    image = waves(places)

    def error(velocity, samples):
        exact = np.mean([waves(places + t * velocity) for t in np.linspace(-0.5, 0.5, 65)], axis=0)
        blurred = motion_blur(ctx, image, 2.0, velocity, samples=samples, **WHOLE)
        return np.sqrt(np.mean((blurred - exact)[16:-16, 16:-16] ** 2))

    velocities = np.array([[17.0, 9.0], [22.0, 3.0], [7.0, 20.0], [9.0, -8.0]])
    errors = [np.mean([error(v, samples) for v in velocities]) for samples in (2, 4, 8, 16, 32)]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 4 * errors[2] > 6 * errors[4]


def comb(profile, half_velocity_px, edge):
    """Return the most by which a blurred edge bends from pixel to pixel, less than its two ends."""
    offset = np.arange(len(profile)) + 0.5 - edge
    inside = np.abs(offset) < half_velocity_px - 2
    return np.abs(np.diff(profile, 2))[inside[1:-1]].max()


@pytest.mark.parametrize("samples", [8, 16, 32])
@pytest.mark.parametrize("half_velocity_px", [6.5, 11.0])
@pytest.mark.parametrize("passes_by", [False, True])
def test_a_moving_edge_is_a_ramp_and_no_comb(ctx, samples, half_velocity_px, passes_by):
    """Also in tiles where who hides whom is looked at: a slower thing goes by above."""
    rgb = np.where(columns() < 64, 1.0, 0.0)[..., None].repeat(3, axis=-1)
    other = (columns() > 60) & (columns() < 68) & (np.arange(96)[:, None] < 40) & passes_by
    speed_px = 2 * half_velocity_px
    velocity = np.where(other[..., None], [0.5 * speed_px, 0.0], [speed_px, 0.0])
    effect = motion_blur_pass(
        ctx, rgb, np.where(other, 0.5, 5.0), velocity, samples=samples, **WHOLE
    )
    if passes_by:
        assert texels_of(effect._method.tiles[0])[44 // 16, 64 // 16, 2] == 2
    profile = rgb_of(effect.target)[44, :, 0].astype(float)
    assert np.all(np.diff(profile) <= 1e-3)
    how = sampling_of(samples, 128)
    # A ramp steps by 1 / (2 * half_velocity_px). Where all moves alike, each sample is a step.
    most = 0.6 / (2 * half_velocity_px) if passes_by else 2 / (how.taps * how.parts)
    assert comb(profile, half_velocity_px, 64) < most


def test_a_cubic_read_makes_nothing_brighter_or_darker_than_it_is(ctx, rng):
    rgb = np.where(rng.random((96, 128, 1)) < 0.1, 60_000.0, 1.0).repeat(3, axis=-1)
    blurred = motion_blur(ctx, rgb, 2.0, [3.0, 1.3], samples=32, **WHOLE)
    assert blurred.min() >= 0.999
    assert blurred.max() <= 60_032


def test_tiles_are_told_by_what_can_be_seen_in_them(ctx, rng):
    """Still at the left, all moving alike in the middle, two that pass each other at the right."""
    height, width = 64, 512
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    speed = np.where(x < 160, 0.0, np.where(x < 320, 10.0, np.where(y % 8 < 4, 10.0, -10.0)))
    effect = motion_blur_pass(
        ctx,
        rng.uniform(0, 1, (height, width, 3)),
        2.0,
        np.stack([speed, 0 * speed], axis=-1),
        shutter_fraction=1.0,
        max_radius_percent=3.0,
    )
    longest, _ = effect._method.tiles
    kinds = np.frombuffer(longest.read(), "f2").reshape(longest.height, longest.width, 4)[1, :, 2]
    assert longest.size == (32, 4)
    assert kinds[:9].tolist() == [0] * 9
    assert kinds[12:18].tolist() == [1] * 6
    assert kinds[21:].tolist() == [2] * 11


@pytest.mark.parametrize("slowest_px", [0.0, 60.0])
def test_streaks_that_grow_slowly_across_the_image_hide_nothing(ctx, rng, slowest_px):
    """As where the camera goes forward: 0.4 px more for each pixel, no jump; depth is not asked."""
    x = np.arange(256.0)[None, :].repeat(64, axis=0)
    velocity = np.stack([slowest_px + 0.4 * np.abs(x - 128), 0 * x], axis=-1)
    rgb = rng.uniform(0, 1, (64, 256, 3))
    any_depth, other = (
        motion_blur(ctx, rgb, rng.uniform(1, 9, (64, 256)), velocity, shutter_fraction=1.0)
        for _ in range(2)
    )
    np.testing.assert_array_equal(any_depth, other)
    assert np.abs(any_depth - rgb).max() > 0.1


def test_a_small_thing_that_passes_is_found_in_a_frame_of_even_streaks(ctx, rng):
    """One tile of them all; which way it goes, and where it is, are of no account."""
    rgb = rng.uniform(0, 1, (96, 128, 3))
    velocity = np.full((96, 128, 2), [6.0, 0.0])
    velocity[50:54, 70:74] = [0.0, -5.0]
    near = np.where(velocity[..., :1] == 0, 0.5, 5.0)[..., 0]
    in_front, behind = (
        motion_blur(ctx, rgb, depth, velocity, **WHOLE) for depth in (near, 6 - near)
    )
    changed = np.abs(in_front - behind).max(axis=-1) > 0.02
    assert changed[46:58, 66:78].any()
    assert not changed[:40].any()


def turning(deg_s):
    """Return a step of a head that turns at this speed, its stage turning the other way."""
    turn = Pose(orientation=axis_angle([0, 1, 0], np.radians(deg_s / 90)))
    return HeadStep(Pose(), turn, Pose(), turn.inverse(), 1 / 90)


def test_streaks_fade_while_the_head_turns(ctx, rng):
    fade = TurnRamp(from_deg_s=60, to_deg_s=180)
    rgb = rng.uniform(0, 1, (40, 60, 3)).astype("f2")
    lengths = {}
    for deg_s in (0, 60, 90, 120, 180, 400):
        effect = motion_blur_pass(
            ctx, rgb, 2.0, [8.0, 0.0], step=turning(deg_s), fade_with_turning=fade, **WHOLE
        )
        lengths[deg_s] = effect.longest_half_velocity_px()
        if deg_s >= 180:
            np.testing.assert_array_equal(rgb_of(effect.target), rgb)
    assert lengths == pytest.approx({0: 4, 60: 4, 90: 3, 120: 2, 180: 0, 400: 0}, rel=1e-3)
    cut = motion_blur_pass(ctx, rgb, 2.0, [8.0, 0.0], fade_with_turning=fade, **WHOLE)
    assert cut.longest_half_velocity_px() == pytest.approx(4, rel=1e-3)


@METHODS
def test_the_limit_shortens_and_says_so(ctx, rng, method):
    rgb = rng.uniform(0, 1, (96, 128, 3))
    effect = motion_blur_pass(ctx, rgb, 2.0, [80.0, 60.0], method=method, **WHOLE)
    assert effect.max_radius_px == pytest.approx(12.8)
    assert effect.longest_half_velocity_px() == pytest.approx(50, rel=1e-3)
    assert effect.clamps() == (
        "motion blur: half streaks of up to 50.0 px were shortened to 12.8 px",
    )
    gentle = motion_blur_pass(ctx, rgb, 2.0, [3.0, 4.0], method=method, **WHOLE)
    known = {"reconstruction": 2.5, "per_pixel": 0.0}[method]
    assert gentle.longest_half_velocity_px() == pytest.approx(known, rel=1e-3)
    assert gentle.clamps() == ()


@pytest.mark.parametrize("slow_px", [3.0, 11.0])
def test_a_frame_is_the_same_whatever_came_before(ctx, rng, slow_px):
    """A fast frame before it widens no search and no step of this one."""
    rgb, far = rng.uniform(0, 1, (96, 128, 3)), rng.uniform(0.4, 5, (96, 128))
    slow = np.where(columns()[..., None] % 40 < 20, [slow_px, 0.0], [0.0, -slow_px])
    alone = motion_blur_pass(ctx, rgb, far, slow, **WHOLE)
    after = motion_blur_pass(ctx, rgb, far, slow, **WHOLE)
    after._method._velocity.write(np.full((96, 128, 2), 300, "f2").tobytes())
    after.render(seen())
    after._method._velocity.write(slow.astype("f2").tobytes())
    after.render(seen())
    assert rgb_of(after.target).tobytes() == rgb_of(alone.target).tobytes()
    assert after.longest_half_velocity_px() > 100


def test_the_longest_streak_is_remembered_over_frames(ctx, rng):
    """The second frame's are half as long."""
    rgb = rng.uniform(0, 1, (20, 30, 3))
    fade = TurnRamp(from_deg_s=60, to_deg_s=180)
    effect = motion_blur_pass(ctx, rgb, 2.0, [8.0, 0.0], fade_with_turning=fade, **WHOLE)
    effect.render(seen(step=turning(120)))
    assert effect.longest_half_velocity_px() == pytest.approx(4, rel=1e-3)


@METHODS
def test_the_same_input_gives_the_same_bytes(ctx, rng, method):
    rgb, distance = rng.uniform(0, 1, (50, 70, 3)), rng.uniform(0.4, 5, (50, 70))
    velocity = rng.normal(0, 6, (50, 70, 2))
    first, second = (
        motion_blur(ctx, rgb, distance, velocity, method=method, **WHOLE) for _ in range(2)
    )
    assert first.tobytes() == second.tobytes()
