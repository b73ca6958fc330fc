"""Both effects in whole frames at the ends of every range: finite, bounded, and exact where due."""

from dataclasses import replace

import numpy as np
import pytest

from vrcomfort.geometry import Fov, Pose, View, axis_angle
from vrcomfort.headset.base import Frame
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.render.reference import read_rgb
from vrcomfort.render.scene_data import Environment, Material, Node, Primitive, Scene

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
    renderer.begin(scene, condition)
    found = []
    for frame in frames:
        found.clear()
        renderer.render(
            frame,
            frame.index / 90,
            lambda _, images: found.append((read_rgb(images.pinhole), read_rgb(images.linear))),
        )
    return found


def condition(focus_m, law, order="depth_of_field_first", **lens):
    return Condition(
        name="extreme",
        focus=Focus(method="fixed", fixed_m=focus_m),
        depth_of_field=DepthOfField(law=law, **lens),
        motion_blur=MotionBlur(mode="full", shutter_fraction=1.0, max_radius_percent=20.0),
        effect_order=order,
    )


@pytest.mark.parametrize("size_px", [(1, 1), (7, 5), (61, 43)])
@pytest.mark.parametrize("scene", [SKY, around(1.0), around(30_000.0)], ids=["sky", "near", "far"])
def test_every_output_is_finite_and_bounded(ctx, size_px, scene):
    """Through the points: the head jumps by metres, so that much was behind the eye before."""
    frames = two_frames([0.4, 0.2, -3.0], 1.5)
    for law in ("linear", "dioptre"):
        for focus_m, order in ((0.05, "motion_blur_first"), (30_000.0, "depth_of_field_first")):
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
