"""What the line of sight meets, drawn into one texel: against rays cast on the CPU, and by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.render import at, glowing, scene, wall
from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, Gaze, Pose, View, yaw_pitch_roll
from vrcomfort.gpu import memory as gpu_memory
from vrcomfort.protocol import Condition, DepthOfField
from vrcomfort.render.focus.rays import GazeHits
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Image, Material
from vrcomfort.scene.load import load_scene
from vrcomfort.scene.ray_cast import RayCaster

SIZE = (32, 40)


def looking(yaw_deg, pitch_deg=0.0, *, valid=True):
    turn = yaw_pitch_roll(*np.radians([yaw_deg, pitch_deg, 0.0]))
    return Gaze(Pose(np.zeros(3), turn), valid=valid)


def hits_of(ctx, content, gazes, *, head=None, along_ray=False, time_s=0.0):
    gpu, head = GpuScene(ctx, content), head or Pose()
    gpu.update(time_s, head)
    hits = GazeHits(ctx, gpu, near_m=0.02, along_ray=along_ray)
    found = [hit for index, gaze in enumerate(gazes) for hit in hits.look(index, gaze, head)]
    return [*found, *hits.drain()]


@pytest.mark.parametrize("name", ["mountain", "depths"])
def test_hits_are_those_of_rays_on_the_cpu(ctx, name):
    content = load_scene(name)
    random = np.random.default_rng(5)
    head = content.spawn @ Pose((0.0, 1.6, 0.0), yaw_pitch_roll(0.4, -0.1, 0.05))
    gazes = [looking(*random.uniform(-35, 35, 2)) for _ in range(60)]
    found = hits_of(ctx, content, gazes, head=head, along_ray=True, time_s=1.5)
    assert [each.frame_index for each in found] == list(range(60))
    caster, same = RayCaster(content), 0
    for gaze, hit in zip(gazes, found, strict=True):
        met = caster.cast(head @ gaze.pose, 1.5)
        if not np.isfinite(met.distance_m):
            same += hit.hit_m is None and hit.node == ""
            continue
        assert hit.hit_m > met.distance_m * (1 - 2e-3)  # farther through the holes of masks alone
        same += hit.node == met.node and hit.hit_m == pytest.approx(met.distance_m, rel=2e-3)
    assert same >= 50


def test_a_board_by_hand_along_the_ray_and_along_the_heads_axis(ctx):
    """A board 2 m ahead, looked at 40° aside: 2 m along the axis, 2 / cos 40° along the ray."""
    board = at(0.0, 0.0, -2.0, scale=np.full(3, 20.0), name="board")
    content = scene([board], [wall()], [glowing((1.0, 1.0, 1.0))])
    (axis,) = hits_of(ctx, content, [looking(40.0)])
    assert axis == (0, pytest.approx(2.0, rel=1e-5), "board")
    (ray,) = hits_of(ctx, content, [looking(40.0)], along_ray=True)
    assert ray.hit_m == pytest.approx(2.0 / np.cos(np.radians(40.0)), rel=1e-5)


def test_the_gaze_goes_through_glass_and_through_the_holes_of_a_mask(ctx):
    holes = Image(np.zeros((4, 4, 4), np.uint8))
    materials = [
        glowing((1.0, 1.0, 1.0)),
        Material("glass", base_color=(1, 1, 1, 0.5), alpha_mode="BLEND"),
        Material("net", base_color_image=0, alpha_mode="MASK"),
    ]
    nodes = [
        at(0.0, 0.0, -1.0, name="pane", mesh=(1,)),
        at(0.0, 0.0, -2.0, name="net", mesh=(2,)),
        at(0.0, 0.0, -3.0, name="behind", scale=np.full(3, 5.0)),
    ]
    content = scene(nodes, [wall(), wall(material=1), wall(material=2)], materials, images=(holes,))
    (hit,) = hits_of(ctx, content, [looking(0.0)])
    assert hit == (0, pytest.approx(3.0, rel=1e-5), "behind")


@pytest.mark.parametrize("gaze", [looking(0.0, valid=False), looking(120.0)])
def test_a_blink_and_a_look_behind_meet_nothing_and_draw_nothing(ctx, gaze):
    content = scene([at(0.0, 0.0, -2.0)], [wall(50.0)], [glowing((1.0, 1.0, 1.0))])
    assert hits_of(ctx, content, [gaze]) == []


def shown(index, gaze):
    views = (View(Pose(), Fov(-0.7, 0.7, 0.7, -0.7)),) * 2
    return Frame(index, index * 10_000_000, 10_000_000, Pose(), views, Pose(), gaze=gaze)


def renderer_of(ctx, condition, **options):
    renderer = StereoRenderer(ctx, SIZE, samples=1, **options)
    board = at(0.0, 0.0, -2.0, name="board")
    renderer.begin(scene([board], [wall(50.0)], [glowing((1.0, 1.0, 1.0))]), condition)
    return renderer


@pytest.mark.parametrize(
    "condition",
    [Condition(name="sharp"), Condition(name="blur", depth_of_field=DepthOfField())],
    ids=lambda each: each.name,
)
def test_every_condition_tells_what_the_gaze_meets_some_frames_late(ctx, condition):
    renderer = renderer_of(ctx, condition, finds_hits=True)
    told = []
    for index in range(8):
        rendered = renderer.render(shown(index, looking(10.0, valid=index != 3)), 0.0)
        assert rendered.seeks_gaze == (index != 3)
        assert all(hit.frame_index < index for hit in rendered.gaze_hits)
        told += rendered.gaze_hits
    assert len(told) > 0
    told += renderer.drain_gaze_hits()
    assert [each.frame_index for each in told] == [0, 1, 2, 4, 5, 6, 7]
    assert {(round(each.hit_m, 4), each.node) for each in told} == {(2.0, "board")}
    renderer.begin(renderer._scene, condition)
    assert renderer.drain_gaze_hits() == ()
    renderer.release()


@pytest.mark.parametrize(("finds_hits", "gaze"), [(True, None), (False, looking(0.0))])
def test_without_gaze_and_where_nobody_asks_nothing_is_made(ctx, finds_hits, gaze):
    renderer = renderer_of(ctx, Condition(name="sharp"), finds_hits=finds_hits)
    account = gpu_memory.account(ctx)
    before = account.mark()
    rendered = [renderer.render(shown(index, gaze), 0.0) for index in range(6)]
    assert account.between(before, account.mark()) == ()
    assert {(each.seeks_gaze, each.gaze_hits) for each in rendered} == {(False, ())}
    assert renderer.drain_gaze_hits() == ()
    renderer.release()
