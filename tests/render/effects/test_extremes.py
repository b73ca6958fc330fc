"""Both effects in whole frames at the ends of every range: finite, bounded, and exact where due."""

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles import motion
from tests.render.effects.test_optics import evaluate
from tests.support.render import at, eye, glowing, scene, wall
from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, Pose, View, axis_angle
from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.render.output import read_depth, read_linear
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Environment, Material, Node, Primitive, Scene
from vrcomfort.tradeoff.brute_force import read_rgb

LENS_FIRST, STREAKS_FIRST = ("depth_of_field", "motion_blur"), ("motion_blur", "depth_of_field")

SUN = (60_000.0, 60_000.0, 60_000.0)
FOV = Fov(-0.9, 0.7, 0.8, -0.85)


def around(distance_m):
    """Return a scene of triangles on all sides, every other one glowing, some huge and close."""
    rng = np.random.default_rng(5)
    corners = rng.normal(0, 1, (40, 3, 3)) * np.geomspace(0.03, distance_m, 40)[:, None, None]
    halves = [
        Primitive(
            positions=half.reshape(-1, 3).astype(np.float32),
            normals=np.tile(np.float32([0, 1, 0]), (60, 1)),
            uvs=np.zeros((60, 2), np.float32),
            colors=None,
            indices=np.arange(60, dtype=np.uint32).reshape(-1, 3),
            material=material,
        )
        for material, half in enumerate((corners[::2], corners[1::2]))
    ]
    glowing = Material(emissive=SUN, double_sided=True)
    plain = Material(double_sided=True)
    return Scene("around", (Node("all", mesh=(0, 1)),), tuple(halves), (glowing, plain))


SKY = Scene("sky", (), (), (), environment=Environment(sky_zenith=SUN, sky_horizon=(0, 0, 0)))


def views(head):
    eyes = (Pose(np.array([x, 0.0, 0.0])) for x in (-0.0315, 0.0315))
    return tuple(View(head @ eye, FOV) for eye in eyes)


def two_frames(step_m, turn_rad):
    heads = (Pose(np.array(step_m), axis_angle([0.3, 1, 0.1], turn_rad)), Pose())
    return [
        Frame(
            index=index,
            predicted_display_time_ns=index * 11_111_111,
            period_ns=11_111_111,
            head_pose=head,
            views=views(head),
            avatar_pose=Pose(),
            discontinuity=index == 0,
        )
        for index, head in enumerate(heads)
    ]


def last_images(ctx, scene, condition, size_px, frames):
    """Return (sharp, blurred) of both eyes of the last frame."""
    renderer = StereoRenderer(ctx, size_px)
    renderer.build(scene, condition)
    found = []
    for frame in frames:
        found.clear()
        renderer.render(
            frame,
            frame.index / 90,
            lambda _, images: found.append((read_rgb(images.pinhole), read_rgb(images.linear))),
        )
    return found


def condition(focus_m, law, order=LENS_FIRST, **lens):
    return Condition(
        name="extreme",
        focus=Focus(method="fixed", fixed_m=focus_m),
        depth_of_field=DepthOfField(law=law, **lens),
        motion_blur=MotionBlur(mode="full", shutter_fraction=1.0, max_radius_percent=20.0),
        effect_order=order,
    )


@pytest.mark.parametrize(
    ("scene", "size_px"),
    [
        (SKY, (7, 5)),
        (around(1.0), (1, 1)),
        (around(1.0), (61, 43)),
        (around(30_000.0), (7, 5)),
        (around(30_000.0), (61, 43)),
    ],
    ids=["sky", "near, one pixel", "near", "far, few pixels", "far"],
)
def test_every_output_is_finite_and_bounded(ctx, size_px, scene):
    """Through the points: the head jumps by metres, so that much was behind the eye before."""
    frames = two_frames([0.4, 0.2, -3.0], 1.5)
    for law in ("linear", "dioptre"):
        for focus_m, order in ((0.05, STREAKS_FIRST), (30_000.0, LENS_FIRST)):
            wide = condition(focus_m, law, order, max_radius_percent=10.0)
            for sharp, blurred in last_images(ctx, scene, wide, size_px, frames):
                assert np.isfinite(blurred).all()
                assert blurred.min() >= 0
                assert blurred.max() <= max(sharp.max() * 1.001, 1e-6)


def test_sky_at_infinite_focus_stays_as_it_is(ctx):
    still = two_frames([0.0, 0.0, 0.0], 0.0)
    for law in ("linear", "dioptre"):
        for sharp, blurred in last_images(ctx, SKY, condition(30_000.0, law), (31, 23), still):
            np.testing.assert_array_equal(blurred, sharp)


def test_no_aperture_and_no_motion_is_the_pinhole_image(ctx):
    still = two_frames([0.0, 0.0, 0.0], 0.0)
    closed = condition(1.0, "dioptre", max_radius_percent=0.0)
    for sharp, blurred in last_images(ctx, around(10.0), closed, (31, 23), still):
        np.testing.assert_array_equal(blurred, sharp)


@pytest.mark.parametrize("law", ["linear", "dioptre"])
def test_discs_of_half_a_pixel_leave_the_image_bit_for_bit(ctx, law):
    """An aperture so small that no disc leaves its pixel: the pass is there and changes nothing."""
    still = two_frames([0.0, 0.0, 0.0], 0.0)
    tiny = condition(1.0, law, max_radius_percent=0.5 / 31 * 100 * 0.999)
    assert tiny.depth_of_field.max_radius_percent > 0
    for sharp, blurred in last_images(ctx, around(10.0), tiny, (31, 23), still):
        np.testing.assert_array_equal(blurred, sharp)


@pytest.mark.parametrize(("near_m", "samples"), [(0.001, 4), (0.02, 2), (1.0, 4)])
def test_thirty_kilometres_and_five_metres_less_differ(ctx, near_m, samples):
    """Through many samples and the resolve, at every near plane."""
    found = []
    for distance_m in (30_000.0, 29_995.0):
        content = scene([at(0, 0, -distance_m)], [wall(1e5)], [glowing((1.0, 1.0, 1.0))])
        scene_pass = ScenePass(ctx, content, (4, 4), velocity=False, samples=samples)
        scene_pass.render(replace(eye(), near_m=near_m), 0.0)
        found.append(near_m / read_depth(scene_pass.depth)[1, 1])
    np.testing.assert_allclose(found, [30_000, 29_995], atol=0.01)


def test_a_surface_whose_normal_has_no_length_is_lit_as_if_it_faced_the_eye(ctx):
    images = []
    for length in (0.0, 1.0):
        square = wall(4)
        normals = np.tile(np.float32([0, 0, length]), (4, 1))
        content = scene(
            [at(0, 0, -3e4)],
            [replace(square, positions=square.positions * 1e5, normals=normals)],
            [Material(double_sided=True)],
            environment=Environment(sun_irradiance=(0, 0, 0)),
        )
        scene_pass = ScenePass(ctx, content, (5, 5), velocity=False)
        scene_pass.render(eye(), 0.0)
        images.append(read_linear(scene_pass.colour))
    # Pixels beside the middle look at a slant, where facing the eye is not facing +Z.
    np.testing.assert_allclose(images[0][2, 2], images[1][2, 2], rtol=2e-3)
    assert images[0].min() > 0.1


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("law", ["linear", "dioptre"])
def test_radii_are_accurate_at_every_range(ctx, law, seed):
    """Of float64: 1e-5 or 0.001 px up to 100 px, and 1e-5 at any size beyond 2 % from focus."""
    rng = np.random.default_rng(seed)
    near_m, offset_m = float(rng.choice([0.001, 0.02, 1.0])), float(rng.choice([0.0, -0.05, 0.05]))
    focus_m = float(np.float32(rng.choice([0.06, 1.0, 10 ** rng.uniform(-1, 4.4), 30_000.0])))
    least_m = max(near_m, 0.06)
    distance_m = 10 ** rng.uniform(np.log10(least_m), np.log10(3e4), 400)
    distance_m[::3] = np.clip(focus_m * (1 + rng.normal(0, 0.02, 134)), least_m, None)
    depth = (near_m / distance_m).astype("f4")
    rows = np.zeros((400, 4), "f4")
    rows[:, 0] = depth
    single = [np.float64(np.float32(each)) for each in (near_m, offset_m, 3e4)]
    for max_radius_px, rate in ((100.0, 10 ** rng.uniform(0, 3)), (1e6, 10 ** rng.uniform(2, 5))):
        constants = np.float32([[near_m, focus_m, offset_m, 3e4], [rate, max_radius_px, 0, 0]])
        call = "vec4(signed_radius_px(x.x, a.x, a.y, a.z, a.w, b.x, b.y))"
        found = evaluate(ctx, "coc.glsl", call, rows, constants=constants, law=law)[:, 0]
        twin = coc.signed_radius_px(
            depth,
            law=law,
            focus_m=focus_m,
            near_m=single[0],
            offset_m=single[1],
            infinity_m=single[2],
            max_radius_px=max_radius_px,
            full_blur=max_radius_px / np.float64(constants[1, 0]),
        )
        off_px = np.abs(found - twin)
        if max_radius_px == 100.0:
            assert (off_px <= np.maximum(1e-5 * np.abs(twin), 1e-3)).all()
        from_head_m = np.minimum(near_m / depth.astype("f8") + offset_m, single[2])
        apart = np.abs(from_head_m - focus_m) > 0.02 * focus_m
        assert apart.sum() > 100
        assert (off_px[apart] <= 1e-5 * np.abs(twin[apart])).all()


def test_time_over_a_pixel_is_the_twin(ctx):
    """From streaks far below a pixel to 1e4 px, within 1e-6 of a pixel and of the reach."""
    rng = np.random.default_rng(2)
    rows = np.zeros((400, 4), "f4")
    rows[:, 1] = 10 ** rng.uniform(-3, 4, 400)
    rows[:, 0] = rows[:, 1] * rng.choice([-1, 1], 400) + rng.uniform(-2, 2, 400)
    rows[::3, 0] *= rng.random(134)
    found = evaluate(ctx, "velocity.glsl", "vec4(time_over(x.x, x.y))", rows)[:, 0]
    twin = motion.time_over(rows[:, 0].astype("f8"), rows[:, 1].astype("f8"))
    assert (np.abs(found - twin) <= 1e-6 * (1 + rows[:, 1])).all()
    assert found.min() >= -1e-6
    assert found.max() <= 1 + 1e-6


def test_a_turned_head_blurs_nothing_where_rotation_is_cancelled(ctx):
    turned = two_frames([0.0, 0.0, 0.0], np.pi / 2)
    steady = MotionBlur(mode="rotation_cancelled", shutter_fraction=1.0)
    wanted = Condition(name="steady", motion_blur=steady)
    for sharp, blurred in last_images(ctx, around(10.0), wanted, (31, 23), turned):
        np.testing.assert_array_equal(blurred, sharp)
    full = wanted.model_copy(update={"motion_blur": steady.model_copy(update={"mode": "full"})})
    for sharp, blurred in last_images(ctx, around(10.0), full, (31, 23), turned):
        assert np.any(blurred != sharp)


def test_a_cut_blurs_nothing(ctx):
    frames = [replace(frame, discontinuity=True) for frame in two_frames([1.0, 0.0, 0.0], 1.0)]
    moving = Condition(name="cut", motion_blur=MotionBlur(mode="full", shutter_fraction=1.0))
    for sharp, blurred in last_images(ctx, around(10.0), moving, (31, 23), frames):
        np.testing.assert_array_equal(blurred, sharp)
