"""The GPU's nine rays against an independent ray cast, along the shipped walks."""

import numpy as np
import pytest

from tests.oracles.focus import estimate_focus, ray_directions
from tests.oracles.raycast import cast
from vrcomfort.geometry import Pose
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.rules import make_focus_pass
from vrcomfort.render.focus.search import HeadView
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.trace import read_trace

SETTINGS = Focus(law="instant")
POSES = 24


@pytest.fixture(scope="module", params=["temple", "mountain"])
def scene(request):
    return load_scene(request.param)


def walk(scene):
    """Times and world-from-head poses, evenly along the shipped walk."""
    trace = read_trace(data_folder("scenes") / f"{scene.name}_walk.csv")
    places = np.linspace(0, len(trace) - 1, POSES).astype(int)
    return [
        (float(trace.time_ns[i]) * 1e-9, trace.avatar.pose(i) @ trace.head.pose(i)) for i in places
    ]


def gpu_samples(ctx, scene, poses):
    gpu = GpuScene(ctx, scene)
    focus = make_focus_pass(ctx, gpu, SETTINGS)
    samples = []
    for index, (time_s, head) in enumerate(poses):
        gpu.update(time_s, head)
        samples += focus.render(
            HeadView(frame_index=index, display_time_ns=index, world_from_head=head)
        )
    return [*samples, *focus.drain()]


def cpu_rays_m(scene, time_s, head):
    """Distances along the head's forward axis."""
    directions = ray_directions(SETTINGS.ring_deg)
    world = directions @ head.matrix()[:3, :3].T
    along = cast(scene, time_s, np.tile(head.position, (9, 1)), world, head=head)
    return np.minimum(along / np.linalg.norm(directions, axis=1), SETTINGS.infinity_m)


def near_things_that_move_or_have_holes(scene):
    """Poses half a metre to two metres before each moving or alpha-masked thing."""
    poses = []
    for time_s in (0.3, 1.9):
        world = scene.world_from_node(time_s)
        for index, node in enumerate(scene.nodes):
            masked = any(
                scene.materials[scene.primitives[item].material].alpha_mode == "MASK"
                for item in node.mesh
            )
            if not node.mesh or not (node.moving or masked):
                continue
            low, high = np.stack([scene.primitives[item].bounds for item in node.mesh]).mean(0)
            centre = world[index][:3, :3] @ ((low + high) / 2) + world[index][:3, 3]
            away = np.linalg.norm(world[index][:3, :3] @ (high - low)) * 0.5 + 0.5
            poses.append((time_s, Pose(centre + np.array([0.0, 0.0, min(away, 4.0)]))))
    return poses[:: max(1, len(poses) // 20)]


def assert_rays_agree(samples, scene, poses):
    """Equal to 1e-5, but for one ray: float32 may put a grazed edge on its other side."""
    expected_m = np.array([cpu_rays_m(scene, time_s, head) for time_s, head in poses])
    rays_m = np.array([sample.rays_m for sample in samples])
    wrong = np.abs(rays_m / expected_m - 1) > 1e-5
    assert wrong.sum() <= 1, (rays_m[wrong], expected_m[wrong])


@pytest.mark.slow
def test_rays_agree_with_the_ray_cast_along_the_walk(ctx, scene):
    poses = walk(scene)
    samples = gpu_samples(ctx, scene, poses)
    assert_rays_agree(samples, scene, poses)
    for sample in samples:
        raw_m, used = estimate_focus(sample.rays_m, SETTINGS)
        assert sample.used.tolist() == used.tolist()
        assert sample.focus_m == pytest.approx(raw_m, rel=1e-5)


@pytest.mark.slow
def test_rays_agree_on_what_moves_and_what_has_holes(ctx, scene):
    poses = near_things_that_move_or_have_holes(scene)
    samples = gpu_samples(ctx, scene, poses)
    assert_rays_agree(samples, scene, poses)
    assert len(poses) >= 10
    assert np.mean([sample.rays_m < 5.0 for sample in samples]) > 0.2


def test_focus_follows_what_is_looked_at(ctx, scene):
    samples = gpu_samples(ctx, scene, walk(scene))
    focus_m = np.array([sample.focus_m for sample in samples])
    assert focus_m.min() < 2.5
    assert focus_m.max() > 2 * focus_m.min()
