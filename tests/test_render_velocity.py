from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.motion import velocity_px
from tests.support.render import at, box, eye, floor, glowing, scene, wall
from vrcomfort.geometry import Pose, axis_angle, quaternion_multiply, yaw_pitch_roll
from vrcomfort.render.camera import EyeCamera, PreviousCamera
from vrcomfort.render.camera_motion import previous_eye_pose
from vrcomfort.render.output import distance_m, read_depth, read_texture
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.animation import Animation, Channel
from vrcomfort.scene.data import Scene

SIZE = (64, 64)
SAMPLE_0 = (0.375, 0.125)
"""Place of the lowest of four samples in its pixel: on floors and upright walls the nearest."""
GREEN = glowing((0.0, 1.0, 0.0))


def velocities(ctx, content, camera, previous, *, time_s=0.0):
    scene_pass = ScenePass(ctx, content, SIZE, velocity=True, velocity_dtype="f4")
    scene_pass.render(camera, time_s, previous)
    return read_texture(scene_pass.velocity).astype(np.float64), read_depth(scene_pass.depth)


def expected(camera: EyeCamera, previous: PreviousCamera, depth):
    """Return float64 velocities of static things where their depth was sampled."""
    clip_from_view = camera.clip_from_view()
    column, row = np.meshgrid(np.arange(64), 63 - np.arange(64))
    x, y = (column + SAMPLE_0[0]) / 32 - 1, (row + SAMPLE_0[1]) / 32 - 1
    # Directions for the sky; tangents are 1, so NDC are slopes.
    far = depth == 0
    d = np.where(far, 1.0, distance_m(np.where(far, 1, depth), camera.near_m).astype(np.float64))
    view = np.stack([x * d, y * d, -d, ~far], axis=-1)
    before_from_now = previous.world_from_eye.inverse().matrix() @ camera.world_from_eye.matrix()
    before = view @ (clip_from_view @ before_from_now).T
    return velocity_px(view @ clip_from_view.T, before, SIZE)


def cluttered(offset=(0.0, 0.0, 0.0)) -> Scene:
    x, y, z = offset
    nodes = [at(x, y, z - 3), at(x - 1, y + 0.5, z - 5), at(x, y - 1, z, mesh=(1,))]
    return scene(nodes, [box(1), floor(40)], [GREEN])


@pytest.mark.parametrize("offset", [(0, 0, 0), (30.0, 0, -20.0)])
def test_static_velocity_is_the_difference_of_projections(ctx, offset):
    origin = np.array(offset, dtype=float)
    camera = eye(origin)
    before = Pose(origin + np.array([0.03, -0.01, 0.05]), yaw_pitch_roll(0.02, -0.01, 0.015))
    previous = PreviousCamera(before, 0.0)
    found, depth = velocities(ctx, cluttered(offset), camera, previous)
    reference = expected(camera, previous, depth)
    allowed = np.maximum(0.01, 1e-5 * np.linalg.norm(reference, axis=-1, keepdims=True))
    assert np.linalg.norm(reference, axis=-1).max() > 0.5
    assert np.all(np.abs(found - reference) <= allowed)


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
