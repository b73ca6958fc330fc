from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.motion import velocity_px
from tests.oracles.raycast import cast
from tests.support.render import at, box, eye, floor, glowing, scene, wall
from vrcomfort.geometry import Pose, axis_angle, clip_from_view, quaternion_multiply, yaw_pitch_roll
from vrcomfort.gpu import gl
from vrcomfort.render.camera import EyeCamera, PreviousCamera, previous_eye_pose
from vrcomfort.render.output import read_depth, read_texture
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.animation import Animation, Channel
from vrcomfort.scene.data import Scene

SIZE = (64, 64)
PLACES = np.array([[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]])
"""Of the four samples in a pixel."""
GREEN = glowing((0.0, 1.0, 0.0))


def velocities(ctx, content, camera, previous, *, time_s=0.0):
    scene_pass = ScenePass(ctx, content, SIZE, velocity=True, velocity_dtype="f4")
    scene_pass.render(camera, time_s, previous)
    return read_texture(scene_pass.velocity).astype(np.float64), read_depth(scene_pass.depth)


def nearest_samples(content, camera, time_s):
    """Return (h, w, 4) homogeneous view positions where rays meet something, the sky with w = 0.

    Of the four samples of each pixel the one whose depth is the greatest, by ray casting.
    """
    width, height = SIZE
    column, row = np.meshgrid(np.arange(width), height - 1 - np.arange(height))
    at_px = np.stack([column, row], axis=-1)[..., None, :] + PLACES
    # Tangents are 1, so NDC are slopes.
    slopes = at_px / (np.array(SIZE) / 2) - 1
    view = np.concatenate([slopes, -np.ones((*slopes.shape[:-1], 1))], axis=-1)
    eye_pose = camera.world_from_eye
    rays = (view @ eye_pose.matrix()[:3, :3].T).reshape(-1, 3)
    origins = np.broadcast_to(eye_pose.position, rays.shape)
    along = cast(content, time_s, origins, rays, head=camera.head).reshape(view.shape[:-1])
    inverse = np.linalg.norm(view, axis=-1) / along  # 1 / distance along the axis; 0 for the sky
    which = inverse.argmax(axis=-1)[..., None]
    nearest = np.take_along_axis(view, which[..., None], axis=2)[:, :, 0]
    return np.concatenate([nearest, np.take_along_axis(inverse, which, axis=2)], axis=-1)


def expected(view, camera: EyeCamera, previous: PreviousCamera, moved=None):
    """Return float64 velocities of view positions; `moved` is world-before from world-now."""
    projection = clip_from_view(camera.fov, camera.near_m)
    before = previous.world_from_eye.inverse().matrix() @ (np.eye(4) if moved is None else moved)
    before_from_now = before @ camera.world_from_eye.matrix()
    clip_before = view @ (projection @ before_from_now).T
    return velocity_px(view @ projection.T, clip_before, SIZE)


def assert_as_cast(found, depth, view, camera, reference):
    """Check velocities where the renderer sees what the rays do: but for a few rims everywhere."""
    same = np.abs(depth - camera.near_m * view[..., 3]) <= 1e-4 * depth + 1e-9
    assert same.mean() > 0.99
    speed = np.linalg.norm(reference, axis=-1, keepdims=True)
    wrong = np.abs(found - reference) > np.maximum(0.01, 1e-5 * speed)
    assert speed[same].max() > 0.5
    assert not wrong[same].any()


def cluttered(offset=(0.0, 0.0, 0.0)) -> Scene:
    x, y, z = offset
    nodes = [at(x, y, z - 3), at(x - 1, y + 0.5, z - 5), at(x, y - 1, z, mesh=(1,))]
    return scene(nodes, [box(1), floor(40)], [GREEN])


LOOKS = [(0.3, -0.7, 0.2), (-0.2, -0.05, 0.1)]
"""Yaw, pitch, roll: the last sees the floor up to its horizon."""


@pytest.mark.parametrize(("look", "offset"), [(LOOKS[0], (0, 0, 0)), (LOOKS[1], (30.0, 0, -20.0))])
def test_static_velocity_is_that_of_the_sample_whose_depth_counts(ctx, look, offset):
    """At silhouettes and at grazing angles as well: depth differs from sample to sample there."""
    origin = np.array(offset, dtype=float)
    content, camera = cluttered(offset), eye(origin, yaw_pitch_roll(*look))
    turned = yaw_pitch_roll(*np.add(look, [0.02, -0.01, 0.015]))
    previous = PreviousCamera(Pose(origin + np.array([0.03, -0.01, 0.05]), turned), 0.0)
    found, depth = velocities(ctx, content, camera, previous)
    view = nearest_samples(content, camera, 0.0)
    assert_as_cast(found, depth, view, camera, expected(view, camera, previous))


@pytest.mark.parametrize("look", LOOKS)
def test_what_moves_has_the_velocity_of_the_sample_whose_depth_counts(ctx, look):
    """A box that slides and turns before an eye that does so, too; nothing else is there."""
    keys = np.array([[0.0, 0, -2.5], [1.0, 0.3, -2.2]])
    turns = np.array([yaw_pitch_roll(0.0, 0.5, 0), yaw_pitch_roll(0.9, 0.3, 0.2)])
    channels = (
        Channel(0, "translation", np.array([0.0, 1.0]), keys, "LINEAR"),
        Channel(0, "rotation", np.array([0.0, 1.0]), turns, "LINEAR"),
    )
    content = scene(
        [at(0, 0, -2.5, moving=True)], [box(1)], [GREEN],
        animations=(Animation("tumble", channels, 1.0),),
    )  # fmt: skip
    camera = eye((0.1, 0.2, 0.0), yaw_pitch_roll(*look))
    previous = PreviousCamera(Pose((0.13, 0.19, 0.05), yaw_pitch_roll(*np.add(look, 0.01))), 0.4)
    found, depth = velocities(ctx, content, camera, previous, time_s=0.5)
    view = nearest_samples(content, camera, 0.5)
    before, now = (content.world_from_node(t)[0] for t in (0.4, 0.5))
    box_seen = (view[..., 3] > 0)[..., None]
    reference = np.where(
        box_seen,
        expected(view, camera, previous, before @ np.linalg.inv(now)),
        expected(view, camera, previous),
    )
    assert box_seen.sum() > 100
    assert_as_cast(found, depth, view, camera, reference)


def test_the_driver_says_where_samples_are(ctx):
    colour = gl.color_texture(ctx, SIZE, samples=4)
    many = ctx.framebuffer([colour])
    many.use()
    np.testing.assert_array_equal(gl.sample_places(ctx, 4), PLACES)


@pytest.mark.parametrize("degrees", [1.0, 30.0, 90.0])
def test_cancelled_head_rotation_is_exactly_still(ctx, degrees):
    stage = Pose((12.3, 0.1, -7.7), axis_angle([0.0, 1.0, 0.0], 0.3))
    head = Pose((0.2, 1.6, -0.4), yaw_pitch_roll(0.4, 0.1, -0.05))
    turn = axis_angle([0.3, 0.9, 0.1], np.radians(degrees))
    turned = Pose(head.position, quaternion_multiply(head.orientation, turn))
    head_from_eye = Pose((0.0315, 0, 0))
    pose = previous_eye_pose(
        "rotation_cancelled",
        world_from_stage=stage,
        stage_from_head=turned,
        head_from_eye=head_from_eye,
        previous_world_from_stage=stage,
        previous_stage_from_head=head,
    )
    camera = eye()
    camera = replace(camera, world_from_eye=stage @ turned @ head_from_eye)
    position = camera.world_from_eye.position + camera.world_from_eye.forward * 3
    found, depth = velocities(ctx, cluttered(position), camera, PreviousCamera(pose, 0.0))
    assert (depth > 0).any()
    assert np.all(found == 0)


def test_without_a_previous_frame_nothing_moves(ctx):
    found, _ = velocities(ctx, cluttered(), eye((0.1, 0.2, 0.3)), None)
    assert np.all(found == 0)


def sliding(**settings) -> Scene:
    """Return a wall at 2 m that moves 1 m to the right per second."""
    keys = np.array([[0.0, 0, -2], [10.0, 0, -2]])
    channel = Channel(0, "translation", np.array([0.0, 10.0]), keys, "LINEAR")
    node = at(0, 0, -2, moving=True, **settings)
    return scene([node], [wall(2)], [GREEN], animations=(Animation("slide", (channel,), 10.0),))


def test_what_moves_by_itself_has_velocity(ctx):
    camera = eye()
    previous = PreviousCamera(camera.world_from_eye, 0.9)
    found, depth = velocities(ctx, sliding(), camera, previous, time_s=1.0)
    # 0.1 m per frame at 2 m, 32 px per unit of slope.
    np.testing.assert_allclose(found[depth > 0] - [1.6, 0], 0, atol=1e-4)
    assert np.all(found[depth == 0] == 0)


def test_head_locked_things_take_their_velocity_in_head_space(ctx):
    camera = eye((5, 1, 2), yaw_pitch_roll(0.5, 0.2, 0.1))
    jumped = PreviousCamera(Pose((-3, 0, 1), yaw_pitch_roll(-0.5, 0, 0)), 0.9)
    still = scene([at(0, 0, -2, head_locked=True)], [wall(2)], [GREEN])
    found, depth = velocities(ctx, still, camera, jumped, time_s=1.0)
    assert (depth > 0).any()
    assert np.all(found[depth > 0] == 0)
    found, depth = velocities(ctx, sliding(head_locked=True), camera, jumped, time_s=1.0)
    np.testing.assert_allclose(found[depth > 0] - [1.6, 0], 0, atol=1e-4)


def test_points_behind_the_previous_eye_and_huge_speeds_stay_finite(ctx):
    camera = eye((0, 0, 0))
    for before in (
        Pose((0, 0, -50)),
        Pose((1e6, 0, 0)),
        Pose((0, 0, 0), yaw_pitch_roll(np.pi, 0, 0)),
        Pose((0, -1.0, 0)),
    ):
        found, _ = velocities(ctx, cluttered(), camera, PreviousCamera(before, 0.0))
        assert np.isfinite(found).all()
        assert np.linalg.norm(found, axis=-1).max() <= 16384.5


def test_half_float_velocities_hold_the_limit(ctx):
    scene_pass = ScenePass(ctx, cluttered(), SIZE, velocity=True)
    scene_pass.render(eye(), 0.0, PreviousCamera(Pose((1e6, 0, 0)), 0.0))
    assert np.isfinite(read_texture(scene_pass.velocity)).all()


def test_views_are_unchanged_by_asking_for_velocity(ctx):
    images = []
    for velocity in (False, True):
        scene_pass = ScenePass(ctx, cluttered(), SIZE, velocity=velocity)
        scene_pass.render(eye(), 0.0)
        images.append(read_texture(scene_pass.colour))
    np.testing.assert_array_equal(*images)
