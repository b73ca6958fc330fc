"""The formulas of both effects: mathematics in NumPy, and the shaders against it."""

import moderngl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles import gather, motion
from tests.oracles.circle_of_confusion import disc_area_px, disc_weight
from vrcomfort.geometry import Fov
from vrcomfort.gpu import shaders
from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.optics.motion import sampling_of

LAWS = ("linear", "dioptre")
distances = st.floats(0.01, 1e5)
EVALUATE = """#version 450 core
#define LAW_{law}
#define EXACT_PX 3.0
#define WIDER 1.5
#define LEVELS 4
#define FADED 0.85
{includes}
uniform sampler2D arguments;
uniform vec4 constants[2];
out vec4 result;
void main() {{
    vec4 x = texelFetch(arguments, ivec2(gl_FragCoord.xy), 0);
    vec4 a = constants[0], b = constants[1];
    result = {expression};
}}
"""


def evaluate(
    ctx, include, expression, arguments, *, constants=((0,) * 4,) * 2, law="linear", defines=()
):
    """Return (n, 4) results of a GLSL expression in x (row of `arguments`), a and b.

    `include` names files of shaders/include, in order; `defines` are pairs of names and values.
    """
    rows = np.asarray(arguments, "f4")
    for name in (*include.split(), "eyes.glsl", "corner.glsl"):
        ctx.includes[name] = shaders.source(f"include/{name}")
    lines = [f"#define {name} {value}" for name, value in defines]
    includes = "\n".join(lines + [f'#include "{name}"' for name in include.split()])
    text = EVALUATE.format(includes=includes, expression=expression, law=law.upper())
    program = ctx.program(shaders.source("common/fullscreen.vert"), text)
    if "constants" in program:
        program["constants"].write(np.asarray(constants, "f4").tobytes())
    source = ctx.texture((len(rows), 1), 4, rows.tobytes(), dtype="f4")
    target = ctx.framebuffer([ctx.texture((len(rows), 1), 4, dtype="f4")])
    target.use()
    source.use(0)
    ctx.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
    return np.frombuffer(target.read(components=4, dtype="f4"), "f4").reshape(-1, 4)


@given(distances, distances, st.sampled_from(LAWS))
def test_radius_has_the_sign_of_the_defocus_and_stays_in_its_limit(distance_m, focus_m, law):
    radius = coc.signed_radius_px(
        0.02 / distance_m, law=law, focus_m=focus_m, near_m=0.02, max_radius_px=11.2, full_blur=2
    )
    assert abs(radius) <= 11.2
    nearer = min(distance_m, 3e4) < min(focus_m, 3e4)
    assert (radius < 1e-6) if nearer else (radius > -1e-6)


def test_radius_is_the_papers_law():
    settings = {"focus_m": 2.0, "near_m": 0.05, "max_radius_px": 10.0}
    depth = 0.05 / np.array([1.0, 2.0, 4.0, 100.0])
    linear = coc.signed_radius_px(depth, law="linear", full_blur=4.0, **settings)
    np.testing.assert_allclose(linear, [-2.5, 0, 5, 10], atol=1e-12)
    dioptre = coc.signed_radius_px(depth, law="dioptre", full_blur=1.0, **settings)
    np.testing.assert_allclose(dioptre, [-5, 0, 2.5, 4.9], atol=1e-12)


def test_a_far_focus_keeps_a_far_range_sharp_in_metres():
    settings = {"law": "linear", "near_m": 0.02, "max_radius_px": 10.0, "full_blur": 10.0}
    depth = 0.02 / np.array([5.0, 6e3, 8e3, 10e3])
    radius = coc.signed_radius_px(depth, focus_m=8e3, **settings)
    np.testing.assert_allclose(radius, [-9.99375, -2.5, 0, 2.5], atol=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_sky_is_as_far_as_infinity(law):
    settings = {"law": law, "near_m": 0.02, "max_radius_px": 11.2, "full_blur": 2.0}
    for focus_m in (3e4, 1e9, np.inf):
        sky = coc.signed_radius_px(0.0, focus_m=focus_m, **settings)
        np.testing.assert_allclose(sky, 0, atol=1e-6)
    assert coc.signed_radius_px(0.0, focus_m=0.05, **settings) == 11.2


@given(st.floats(-0.6, 0.6), st.floats(-0.9, 0.9), st.floats(-0.9, 0.9), st.floats(0.1, 100))
def test_depth_is_measured_along_the_heads_axis(cant_rad, tangent_x, tangent_y, distance_m):
    forward_in_view = np.array([np.sin(cant_rad), 0, -np.cos(cant_rad)])
    point_in_view = distance_m * np.array([tangent_x, tangent_y, -1])
    fov = Fov(*np.arctan([-1.2, 1.0, 0.95, -1.1]))
    uv = [(tangent_x + 1.2) / 2.2, (tangent_y + 1.1) / 2.05]
    slope = coc.head_depth_slope(fov, forward_in_view, uv)
    np.testing.assert_allclose(slope * distance_m, point_in_view @ forward_in_view, atol=1e-9)


@given(st.floats(0, 40), st.floats(0.5, 8))
def test_disc_area_is_the_integral_of_its_weight(radius_px, softness_px):
    edges = np.linspace(0, radius_px + softness_px, 4001)
    middle = (edges[1:] + edges[:-1]) / 2
    rings = 2 * np.pi * middle * np.diff(edges)
    integral = np.sum(rings * disc_weight(middle, radius_px, softness_px))
    np.testing.assert_allclose(disc_area_px(radius_px, softness_px), integral, rtol=2e-3)


def test_a_disc_of_half_a_pixel_covers_its_own_pixel_only():
    distance = np.hypot(*np.mgrid[-2:3, -2:3])
    expected = (distance == 0).astype(float)
    np.testing.assert_array_equal(disc_weight(distance, 0.5), expected)


clip = st.tuples(*[st.floats(-1e6, 1e6, width=32)] * 4).map(np.array)


@given(clip, clip, st.floats(1e-3, 1e5))
def test_velocity_is_finite_and_bounded(now, before, w):
    now[3] = w
    velocity = motion.velocity_px(now, before, (640, 800))
    assert np.linalg.norm(velocity) <= motion.SPEED_LIMIT_PX * (1 + 1e-12)


def test_velocity_is_the_projected_difference():
    now, before = np.array([0.2, 0.4, 0.0, 2.0]), np.array([0.0, 0.4, 0.0, 4.0])
    np.testing.assert_allclose(motion.velocity_px(now, before, (640, 800)), [32, 40])


def test_a_point_from_behind_the_eye_comes_from_its_rim():
    now, before = np.array([0.5, 0.0, 0.0, 1.0]), np.array([0.1, 0.0, 0.0, -1.0])
    velocity = motion.velocity_px(now, before, (640, 800))
    assert velocity[0] < -10_000
    assert velocity[1] == 0


def test_half_velocity_is_half_the_shutter_and_clamps_without_turning():
    streak = motion.half_velocity_px(
        [[8, 0], [300, -400], [0, 0]], shutter_fraction=0.5, max_radius_px=32
    )
    np.testing.assert_allclose(streak, [[2, 0], [19.2, -25.6], [0, 0]])


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("near_m", [0.001, 0.02, 1.0])
def test_shader_radius_is_the_twin(ctx, law, near_m, rng):
    """Within 1e-5 relative or 0.001 px of float64 where the depth itself resolves that."""
    depth = (near_m / np.geomspace(near_m, 3e4, 200)).astype("f4")
    slope = np.where(np.arange(200) % 2, 1.0, rng.uniform(0.7, 1.3, 200)).astype("f4")
    for focus_m in (0.05, 1.0, 10.0, 1e3):
        full_blur = 10.0 if law == "linear" else 2.0
        x = np.stack([depth, slope, 0 * depth, 0 * depth], axis=-1)
        constants = [[near_m, focus_m, 0, 3e4], [11.2 / full_blur, 11.2, 0, 0]]
        call = "vec4(signed_radius_px(x.x, a.x * x.y, a.y, a.z, a.w, b.x, b.y))"
        shader = evaluate(ctx, "coc.glsl", call, x, constants=constants, law=law)[:, 0]
        twin = coc.signed_radius_px(
            depth, law=law, focus_m=focus_m, near_m=np.float64(np.float32(near_m)), slope=slope,
            max_radius_px=np.float64(np.float32(11.2)), full_blur=full_blur,
        )  # fmt: skip
        # A rounded slope moves the point by 6e-8 of its distance, in metres too.
        np.testing.assert_allclose(shader, twin, rtol=1e-5, atol=1e-3)


@pytest.mark.smoke
def test_shader_radius_survives_a_focus_that_is_no_number(ctx):
    x = [[0.0, 0, 0, 0], [0.02, 0, 0, 0], [1.0, 0, 0, 0]]
    constants = [[0.02, np.nan, 0, 3e4], [5.6, 11.2, 0, 0]]
    call = "vec4(signed_radius_px(x.x, a.x, a.y, a.z, a.w, b.x, b.y))"
    np.testing.assert_allclose(
        evaluate(ctx, "coc.glsl", call, x, constants=constants)[:, 0], [0, -11.2, -11.2], rtol=1e-4
    )


def test_the_part_of_a_light_that_is_a_lamp_grows_from_eight_to_sixteen_times_white(ctx):
    """Of the brightest channel, whichever it is."""
    x = [[0, 0, 0, 1], [8, 8, 8, 1], [0, 10, 0, 1], [12, 0, 3, 1], [1, 2, 14, 1], [99, 1, 1, 1]]
    found = evaluate(ctx, "coc.glsl", "vec4(lamp_part(x))", x)[:, 0]
    assert found.tolist() == [0, 0, 0.25, 0.5, 0.75, 1]


def test_shader_disc_and_slope_are_the_twins(ctx, rng):
    x = rng.uniform(0, 12, (100, 4))
    x[:, 2] = rng.uniform(0.5, 4, 100)
    result = evaluate(
        ctx, "coc.glsl", "vec4(disc_weight(x.x, x.y, x.z), disc_area_px(x.y, x.z), 0, 0)", x
    )
    x = x.astype("f4")
    for row, (weight, area, *_) in zip(x, result, strict=True):
        np.testing.assert_allclose(weight, disc_weight(row[0], row[1], row[2]), atol=1e-5)
        np.testing.assert_allclose(area, disc_area_px(row[1], row[2]), rtol=1e-5)
    uv = rng.uniform(0, 1, (100, 4))
    fov = Fov(-0.8, 0.6, 0.7, -0.9)
    constants = [fov.tangents, [0.3, 0.1, -0.95, 0]]
    slope = evaluate(
        ctx, "coc.glsl", "vec4(head_depth_slope(a, b.xyz, x.xy))", uv, constants=constants
    )
    np.testing.assert_allclose(
        slope[:, 0], coc.head_depth_slope(fov, [0.3, 0.1, -0.95], uv[:, :2]), rtol=1e-5
    )


def test_shader_fronts_and_discs_are_the_twins(ctx, rng):
    x = rng.uniform(-12, 12, (300, 4)).astype("f4")
    x[:100, 1] = x[:100, 0] * rng.uniform(0.85, 1.0, 100)  # about the same surface
    p, q, _, _ = x.T.astype("f8")
    include = "eyes.glsl coc.glsl discs.glsl"
    call = "vec4(nearer(x.x, x.y), margin_px(x.x), slack_of(abs(x.x)), grid_radius_px(abs(x.x)))"
    is_front, margin, slack, grid = evaluate(ctx, include, call, x).T
    np.testing.assert_allclose(slack, gather.slack_px(p), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(margin, gather.margin_px(p), rtol=1e-5)
    np.testing.assert_allclose(is_front, gather.nearer(p, q), atol=1e-4)
    np.testing.assert_allclose(grid, gather.grid_radius_px(abs(p)), rtol=1e-5)
    assert ((is_front > 0) & (is_front < 1)).any()
    call = "vec4(disc_share(abs(x.x), abs(x.y)), disc_texels(abs(x.x), 2.0), 0.0, 0.0)"
    share, texels, _, _ = evaluate(ctx, include, call, x).T
    np.testing.assert_allclose(share, gather.disc_share(abs(p), abs(q)), rtol=1e-4, atol=1e-5)
    assert 0.1 < np.mean((share > 0) & (share < 1 / (q**2 + 1 / 12))) < 0.9
    np.testing.assert_allclose(texels, gather.disc_texels(abs(p), 2), rtol=1e-5)


def test_a_point_is_in_front_between_one_margin_and_two():
    """By hand: at 4 px the margin is 0.2 px, below 2.5 px it is an eighth."""
    found = gather.nearer(4.0, [4.5, 3.8, 3.7, 3.6, 0.0])
    np.testing.assert_allclose(found, [0, 0, 0.5, 1, 1], atol=1e-12)
    np.testing.assert_allclose(gather.nearer(-1.0, [-1.125, -1.1875, -1.25]), [0, 0.5, 1])


def test_shader_velocity_and_streak_are_the_twins(ctx, rng):
    x = rng.uniform(-3, 3, (200, 4))
    now = np.array([0.3, -0.2, 0.0, 1.5], "f4")
    call = "vec4(velocity_px(a, x, b.xy), half_velocity_px(x.xy * 30.0, 0.5, 16.0))"
    result = evaluate(ctx, "velocity.glsl", call, x, constants=[now, [640, 800, 0, 0]])
    x = x.astype("f4")
    twin = motion.velocity_px(np.broadcast_to(now, x.shape), x, (640, 800))
    np.testing.assert_allclose(result[:, :2], twin, rtol=1e-4, atol=0.01)
    streak = motion.half_velocity_px(30 * x[:, :2], shutter_fraction=0.5, max_radius_px=16)
    np.testing.assert_allclose(result[:, 2:], streak, rtol=1e-5, atol=1e-5)


@given(st.floats(0.01, 40))
def test_the_times_over_all_pixels_are_the_whole_streak(reach):
    pixels = np.arange(-42, 43)
    times = motion.time_over(pixels, reach)
    np.testing.assert_allclose(times.sum(), 2 * reach, atol=1e-9)
    np.testing.assert_array_equal(times[np.abs(pixels) >= reach + 1], 0)
    np.testing.assert_allclose(times[np.abs(pixels) <= reach - 1], 1, atol=1e-12)


@given(st.floats(0.01, 400), st.integers(2, 64), st.sampled_from([320, 640, 1832]))
def test_reads_share_a_streak_evenly(reach, samples, width_px):
    """All of it, centred, as wide as it is long, with no more reads than asked for."""
    how = sampling_of(samples, width_px)
    weights = motion.streak_weights(reach, samples=samples, width_px=width_px)
    pixels = np.arange(len(weights)) - len(weights) // 2
    assert weights.sum() == pytest.approx(1)
    assert weights @ pixels == pytest.approx(0, abs=1e-9)
    beyond = np.abs(pixels) > np.ceil(reach) + 1
    assert weights[beyond].sum() == pytest.approx(0, abs=1e-12)
    if reach <= min(how.one_step_px, 2 * how.pairs + 0.5):  # no pixel is passed over
        assert weights[np.abs(pixels) <= reach - 1].min(initial=1) > 0
    assert how.taps + how.parts <= max(samples + 3, 6)
    assert how.taps * how.parts >= 0.6 * samples
    assert 2 * how.pairs + 1 <= how.taps + how.parts + 1


def test_shader_time_over_is_the_twin(ctx, rng):
    x = rng.uniform(0, 12, (100, 4)).astype("f4")
    result = evaluate(ctx, "velocity.glsl", "vec4(time_over(x.x, x.y))", x)
    np.testing.assert_allclose(result[:, 0], motion.time_over(x[:, 0], x[:, 1]), atol=1e-6)


@pytest.fixture
def rng():
    return np.random.default_rng(1)
