"""Focus on the GPU: rays that hit what they should, the twin's estimate, samples that come late."""

from typing import get_args

import numpy as np
import pytest

from tests.oracles.focus import estimate_focus, ray_directions
from tests.oracles.raycast import cast
from tests.oracles.refocus import FocusState, advance
from vrcomfort.geometry import Pose, axis_angle, yaw_pitch_roll
from vrcomfort.gpu.gl import LATENCY
from vrcomfort.optics.refocus import LAWS
from vrcomfort.protocol.conditions import Focus, FocusRuleName
from vrcomfort.render.focus.at_rest import FixedFocus
from vrcomfort.render.focus.rules import RULES, make_focus_pass
from vrcomfort.render.focus.search import HeadView
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.scene.animation import Animation, Channel
from vrcomfort.scene.data import Image, Material, Node, Primitive, Scene

FRAME_NS = 11_111_111
HEAD = Pose(np.array([3.0, 1.6, -2.0]), yaw_pitch_roll(0.7, -0.2, 0.1))


def square(material=0):
    """A unit square around the origin that faces +Z."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    return Primitive(
        positions=corners,
        normals=np.tile(np.float32([0, 0, 1]), (4, 1)),
        uvs=(corners[:, :2] / 2 + 0.5).astype(np.float32),
        colors=None,
        indices=np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
        material=material,
    )


def scene_of(nodes, *, material=None, images=(), animations=()):
    return Scene(
        "test", tuple(nodes), (square(),), (material or Material(),), images, tuple(animations)
    )


def wall(distance_m, head=HEAD, size_m=50.0, **more):
    """A square before the head, square to its forward axis."""
    return Node(
        "wall",
        translation=head.position + distance_m * head.forward,
        rotation=head.orientation,
        scale=np.full(3, size_m),
        mesh=(0,),
        **more,
    )


def samples_of(
    ctx, scene, *, settings=None, heads=(HEAD,), times_s=None, cuts=(), step_ns=FRAME_NS
):
    gpu = GpuScene(ctx, scene)
    focus = make_focus_pass(ctx, gpu, settings or Focus())
    samples = []
    times_s = [0.0] * len(heads) if times_s is None else times_s
    heads = list(heads) * (len(times_s) // len(heads))
    for index, (time_s, head) in enumerate(zip(times_s, heads, strict=True)):
        gpu.update(time_s, head)
        samples += focus.render(
            HeadView(
                frame_index=index,
                display_time_ns=index * step_ns,
                world_from_head=head,
                discontinuity=index in cuts,
            )
        )
    return [*samples, *focus.drain()]


@pytest.mark.parametrize("distance_m", [0.05, 7.3, 29_000.0])
def test_a_wall_before_the_head_is_at_its_distance_on_all_rays(ctx, distance_m):
    scene = scene_of([wall(distance_m, size_m=distance_m)])
    (sample,) = samples_of(ctx, scene)
    np.testing.assert_allclose(sample.rays_m, distance_m, rtol=2e-6)
    assert sample.used.all()
    assert sample.focus_m == pytest.approx(distance_m, rel=2e-6)


@pytest.mark.smoke
def test_the_sky_is_at_infinity(ctx):
    (sample,) = samples_of(ctx, scene_of([]))
    assert sample.rays_m.tolist() == [30_000.0] * 9
    assert sample.used.all()
    assert (sample.focus_m, sample.focus_raw_m) == (30_000.0, 30_000.0)


@pytest.mark.parametrize("ring_deg", [0.5, 2.0, 10.0])
def test_a_slanted_wall_is_hit_where_the_rays_are(ctx, ring_deg):
    # Depth along each ray by hand: a plane n · p = c in the head's frame.
    turned = Pose(HEAD.position, HEAD.orientation) @ Pose(
        np.zeros(3), axis_angle([1.0, 2.0, 0.0], 1.1)
    )
    node = Node(
        "wall",
        translation=HEAD.position + 2.0 * HEAD.forward,
        rotation=turned.orientation,
        scale=np.full(3, 20.0),
        mesh=(0,),
    )
    normal = Pose(np.zeros(3), axis_angle([1.0, 2.0, 0.0], 1.1)).matrix()[:3, 2]
    directions = ray_directions(ring_deg)
    depths = normal @ [0.0, 0.0, -2.0] / (directions @ normal)
    (sample,) = samples_of(ctx, scene_of([node]), settings=Focus(ring_deg=ring_deg))
    np.testing.assert_allclose(sample.rays_m, depths, rtol=1e-5)


def test_one_ray_that_misses_a_small_thing_is_dropped(ctx):
    reach = np.tan(np.radians(2.0))
    head = Pose()
    node = Node(
        "square",
        translation=np.array([-0.05, 0.0, -1.0]),
        scale=np.array([reach + 0.049, 1.0, 1.0]),
        mesh=(0,),
    )
    (sample,) = samples_of(ctx, scene_of([node]), heads=(head,))
    assert sample.used.tolist() == [True, False, *[True] * 7]
    assert sample.rays_m[1] == 30_000.0
    assert sample.focus_m == pytest.approx(1.0, rel=1e-6)


def test_holes_of_an_alpha_mask_let_rays_through(ctx):
    pixels = np.full((16, 16, 4), 255, np.uint8)
    pixels[:, 8:, 3] = 0
    material = Material(base_color_image=0, alpha_mode="MASK", alpha_cutoff=0.5)
    scene = scene_of(
        [wall(1.0, Pose(), 1.0)],
        material=material,
        images=(Image(pixels, wrap=("clamp_to_edge", "clamp_to_edge")),),
    )
    (sample,) = samples_of(ctx, scene, heads=(Pose(),))
    left = ray_directions(2.0)[:, 0] < -1e-6
    np.testing.assert_allclose(sample.rays_m[left], 1.0, rtol=1e-6)
    right = ray_directions(2.0)[:, 0] > 1e-6
    assert (sample.rays_m[right] == 30_000.0).all()


def test_blended_things_are_transparent_to_rays(ctx):
    material = Material(base_color=(1, 1, 1, 0.9), alpha_mode="BLEND")
    (sample,) = samples_of(ctx, scene_of([wall(1.0)], material=material))
    assert (sample.rays_m == 30_000.0).all()


def test_the_back_of_a_single_sided_wall_is_not_there(ctx):
    behind = HEAD @ Pose(np.array([0.0, 0.0, -4.0]), axis_angle([0.0, 1.0, 0.0], np.pi))
    assert (samples_of(ctx, scene_of([wall(2.0)]), heads=(behind,))[0].rays_m == 30_000.0).all()


def test_a_thing_locked_to_the_head_is_hit_wherever_the_head_is(ctx):
    node = Node("sight", translation=np.array([0, 0, -0.8]), mesh=(0,), head_locked=True)
    for sample in samples_of(ctx, scene_of([node]), heads=(Pose(), HEAD)):
        np.testing.assert_allclose(sample.rays_m, 0.8, rtol=1e-6)


def jumping_squares(depths_m):
    """Nine small squares, one on each ray, that jump to other depths every second."""
    times_s = np.arange(len(depths_m) + 1.0)
    depths_m = np.concatenate([depths_m, depths_m[-1:]])
    nodes, channels = [], []
    for ray, direction in enumerate(ray_directions(2.0)):
        places = depths_m[:, ray, None] * direction
        sizes = np.repeat(depths_m[:, ray, None] * 0.005, 3, axis=1)
        nodes.append(Node(f"ray {ray}", mesh=(0,), moving=True))
        channels.append(Channel(ray, "translation", times_s, places, "STEP"))
        channels.append(Channel(ray, "scale", times_s, sizes, "STEP"))
    return scene_of(nodes, animations=[Animation("jump", tuple(channels), times_s[-1])])


@pytest.mark.parametrize("mean", ["metres", "dioptres"])
@pytest.mark.parametrize("law", LAWS)
def test_the_shader_computes_what_its_twin_does(ctx, mean, law):
    random = np.random.default_rng(5)
    depths_m = random.uniform(0.3, 12.0, (30, 1)) * random.uniform(0.8, 1.25, (30, 9))
    depths_m[random.random((30, 9)) < 0.1] *= 40.0
    # 300 µs: the metric law is then as slow as rooms are deep, so that its steps are seen.
    settings = Focus(mean=mean, law=law)
    step_ns = 300_000 if law == "linear" else FRAME_NS
    samples = samples_of(
        ctx,
        jumping_squares(depths_m),
        settings=settings,
        heads=(Pose(),),
        times_s=np.arange(30) + 0.5,
        cuts=(10,),
        step_ns=step_ns,
    )
    state = FocusState(1.0)
    for index, (sample, depths) in enumerate(zip(samples, depths_m, strict=True)):
        np.testing.assert_allclose(sample.rays_m, depths, rtol=3e-6)
        raw_m, used = estimate_focus(sample.rays_m, settings)
        assert sample.used.tolist() == used.tolist()
        assert sample.focus_raw_m == pytest.approx(raw_m, rel=1e-6)
        cut = index in (0, 10)
        state = advance(state, raw_m, 1e9 if cut else step_ns * 1e-9, settings)
        assert sample.focus_m == pytest.approx(raw_m if cut else state.focus_m, rel=1e-5)


def test_samples_come_a_fixed_number_of_frames_late_and_all_of_them(ctx):
    gpu = GpuScene(ctx, scene_of([]))
    focus = make_focus_pass(ctx, gpu, Focus())
    arrived = [
        [
            sample.frame_index
            for sample in focus.render(
                HeadView(frame_index=index, display_time_ns=index, world_from_head=Pose())
            )
        ]
        for index in range(7)
    ]
    assert arrived == [[]] * LATENCY + [[index] for index in range(7 - LATENCY)]
    assert [sample.frame_index for sample in focus.drain()] == list(range(7 - LATENCY, 7))
    assert focus.drain() == ()


def test_at_a_discontinuity_focus_is_at_once_where_the_rays_say(ctx):
    near, far = Pose(np.array([0.0, 0.0, 9.0])), Pose()
    scene = scene_of([Node("wall", translation=np.array([0, 0, 8.0]), mesh=(0,))])
    settings = Focus(law="linear_dioptre")
    heads = (near, far, far, near)
    smooth = samples_of(ctx, scene, settings=settings, heads=heads)
    cut = samples_of(ctx, scene, settings=settings, heads=heads, cuts=(1, 3))
    assert smooth[0].focus_m == pytest.approx(1.0, rel=1e-6)
    assert smooth[1].focus_m == pytest.approx(1 / (1 - 2 * 0.011111111), rel=1e-5)
    assert [s.focus_m for s in cut] == pytest.approx([1.0, 30_000.0, 30_000.0, 1.0], rel=1e-6)


def test_the_texture_holds_the_last_frames_focus(ctx):
    gpu = GpuScene(ctx, scene_of([wall(2.5)]))
    focus = make_focus_pass(ctx, gpu, Focus())
    gpu.update(0.0, HEAD)
    focus.render(HeadView(frame_index=0, display_time_ns=0, world_from_head=HEAD))
    x, y, bits, w = np.frombuffer(focus.texture.read(), np.float32)
    assert (x, y) == pytest.approx((2.5, 2.5), rel=1e-6)
    assert (bits, w) == (511, 1)


def test_a_ray_draws_only_what_it_meets(ctx):
    around = [wall(2.0, HEAD @ Pose(np.zeros(3), yaw_pitch_roll(a, 0, 0)), 0.2) for a in range(6)]
    gpu = GpuScene(ctx, scene_of(around))
    focus = make_focus_pass(ctx, gpu, Focus())
    gpu.update(0.0, HEAD)
    focus.render(HeadView(frame_index=0, display_time_ns=0, world_from_head=HEAD))
    assert gpu.triangles == 9 * 2


def test_every_rule_of_a_protocol_is_there():
    assert RULES.keys() == set(get_args(FocusRuleName))


def test_fixed_focus_draws_nothing(ctx):
    gpu = GpuScene(ctx, scene_of([wall(2.5)]))
    focus = make_focus_pass(ctx, gpu, Focus(method="fixed", fixed_m=1.5))
    assert isinstance(focus, FixedFocus)
    (sample,) = focus.render(HeadView(frame_index=4, display_time_ns=0, world_from_head=HEAD))
    assert (sample.frame_index, sample.focus_m, sample.focus_raw_m) == (4, 1.5, 1.5)
    assert np.isnan(sample.rays_m).all()
    assert not sample.used.any()
    assert gpu.draws == 0
    assert np.frombuffer(focus.texture.read(), np.float32)[0] == 1.5
    assert focus.drain() == ()


def cpu_rays_m(scene, time_s, head, settings):
    """Distances along the head's forward axis, from the independent ray cast."""
    directions = ray_directions(settings.ring_deg)
    world = directions @ head.matrix()[:3, :3].T
    along = cast(scene, time_s, np.tile(head.position, (9, 1)), world, head=head)
    return np.minimum(along / np.linalg.norm(directions, axis=1), settings.infinity_m)


def test_the_ray_cast_agrees_on_a_wall():
    scene = scene_of([wall(3.0)])
    np.testing.assert_allclose(cpu_rays_m(scene, 0.0, HEAD, Focus()), 3.0, rtol=1e-6)
