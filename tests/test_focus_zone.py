"""The autofocus zone: weights and means as mathematics, and the GPU against them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.oracles.autofocus_zone import halved, zone_focus_m
from tests.support.render import at, glowing, scene, wall
from vrcomfort.geometry import Fov, Pose, View, yaw_pitch_roll
from vrcomfort.optics import autofocus_zone as zone
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.autofocus_zone import screen_tangents
from vrcomfort.render.focus.rule import Sight
from vrcomfort.render.focus.rules import make_focus_pass
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.scene.data import Material

NEAR_M = 0.02
SETTINGS = Focus(method="autofocus_zone", law="instant")
sizes = st.tuples(st.integers(1, 37), st.integers(1, 37))


@pytest.mark.parametrize("size_px", [(1, 1), (64, 64), (63, 17)])
def test_weights_fall_from_the_middle_to_the_border_as_a_gaussian(size_px):
    width, height = size_px
    weights = zone.gauss_weights(size_px, SETTINGS)
    assert weights.shape == (height, width)
    assert weights.max() <= 1.0
    assert weights.min() >= 0.7
    if width > 1:
        x = (2 * np.arange(width) + 1) / width - 1
        middle = weights[height // 2]
        np.testing.assert_allclose(middle[1:-1], 0.7 ** (x[1:-1] ** 2), rtol=0.002)
        np.testing.assert_allclose(weights[0, 0], 0.7)


@given(sizes.flatmap(lambda size: arrays(float, (*size, 2), elements=st.floats(0.01, 1.0))))
def test_halving_to_one_texel_is_the_weighted_mean_at_any_size(image):
    level = image
    while level.shape[:2] != (1, 1):
        level = halved(level)
    direct = image[..., 0].sum() / image[..., 1].sum()
    assert level[0, 0, 0] / level[0, 0, 1] == pytest.approx(direct, rel=1e-12)


@given(st.floats(0.1, 50.0), st.floats(1.0, 1e9), st.sampled_from(["metres", "dioptres"]))
def test_one_distance_everywhere_is_the_focus_and_the_sky_is_a_number(distance_m, infinity_m, mean):
    settings = Focus(mean=mean, infinity_m=infinity_m)
    for depth, expected in ((NEAR_M / distance_m, min(distance_m, infinity_m)), (0.0, infinity_m)):
        weighted = zone.weighted(np.full((3, 5), depth), np.full((3, 5), 0.5), NEAR_M, settings)
        focus_m = zone_focus_m(weighted.sum(axis=(0, 1)), settings)
        assert focus_m == pytest.approx(expected, rel=1e-9)


def test_the_mean_by_hand():
    """A target at 2 m on one pixel of four, a wall at 10 m on the rest; the same W_G for all."""
    depth = NEAR_M / np.array([[2.0, 10.0], [10.0, 10.0]])
    semantic = np.array([[1.0, 0.004], [0.004, 0.004]])
    weighted = zone.weighted(depth, semantic, NEAR_M, SETTINGS)
    found = zone_focus_m(weighted.mean(axis=(0, 1)), SETTINGS)
    assert found == pytest.approx((2.0 + 3 * 0.004 * 10) / 1.012)
    alike = Focus(semantic_max=0.004)
    weighted = zone.weighted(depth, semantic, NEAR_M, alike)
    assert zone_focus_m(weighted.mean(axis=(0, 1)), alike) == pytest.approx(8.0)


def sample(ctx, content, settings, *, head=None, tangents=(1.0, 0.8)):
    head = head or Pose()
    gpu = GpuScene(ctx, content)
    focus = make_focus_pass(ctx, gpu, settings, near_m=NEAR_M)
    gpu.update(0.0, head)
    focus.render(
        Sight(frame_index=3, display_time_ns=0, world_from_head=head, screen_tangents=tangents)
    )
    (found,) = focus.drain()
    return found, focus


def target_before_a_wall(**target):
    nodes = [
        at(0.0, 0.0, -10.0, scale=np.full(3, 60.0)),
        at(0.1, 0.05, -2.0, scale=np.full(3, 0.3), **target),
    ]
    return scene(nodes, [wall()], [glowing((1.0, 1.0, 1.0))])


def cpu_zone_m(settings, tangents, target_weight):
    """The same picture painted by hand: which texels of the zone the target covers."""
    width, height = settings.zone_size_px
    x = ((2 * np.arange(width) + 1) / width - 1) * settings.zone_ratio * tangents[0] * 2.0
    y = ((2 * np.arange(height) + 1) / height - 1) * settings.zone_ratio * tangents[1] * 2.0
    hit = (np.abs(x - 0.1) < 0.15)[None, :] & (np.abs(y - 0.05) < 0.15)[:, None]
    assert 0.05 < hit.mean() < 0.9
    depth = NEAR_M / np.where(hit, 2.0, 10.0)
    weighted = zone.weighted(depth, np.where(hit, target_weight, 0.004), NEAR_M, settings)
    return zone_focus_m(weighted.sum(axis=(0, 1)), settings)


@pytest.mark.parametrize("mean", ["metres", "dioptres"])
@pytest.mark.parametrize("size_px", [(64, 64), (63, 37), (5, 7), (40, 32)])
@pytest.mark.parametrize("weight", [0.004, 1.0])
def test_the_gpu_and_the_cpu_find_what_is_worked_out_by_hand(ctx, mean, size_px, weight):
    content = target_before_a_wall(semantic_weight=weight)
    settings = SETTINGS.model_copy(update={"mean": mean, "zone_size_px": size_px})
    expected = cpu_zone_m(settings, (1.0, 0.8), weight)
    found, _ = sample(ctx, content, settings)
    assert found.focus_m == pytest.approx(expected, rel=1e-5)
    slow, _ = sample(ctx, content, settings.model_copy(update={"zone_mean_on": "cpu"}))
    assert slow.focus_m == pytest.approx(expected, rel=1e-5)
    assert np.isnan(found.rays_m).all()
    assert not found.used.any()


def test_an_important_thing_takes_the_focus_from_a_wall_that_covers_more(ctx):
    """Figure 1 of the paper: without semantic weights focus is on the background."""
    important, _ = sample(ctx, target_before_a_wall(semantic_weight=1.0), SETTINGS)
    plain, _ = sample(ctx, target_before_a_wall(), SETTINGS)
    assert important.focus_m < 2.3
    assert plain.focus_m > 5.0


def test_the_zone_is_part_of_the_image_and_turns_with_the_head(ctx):
    head = Pose(np.array([5.0, 1.6, 2.0]), yaw_pitch_roll(0.6, -0.3, 0.4))
    nodes = [
        at(*(head.position + 4.0 * head.forward), rotation=head.orientation,
           scale=np.array([2.02, 1.62, 1.0])),
    ]  # fmt: skip
    content = scene(nodes, [wall()], [glowing((1.0, 1.0, 1.0))])
    # The wall is 2 m by 1.6 m at 4 m: tangents of 0.25 and 0.2, a quarter of the image's.
    inside, _ = sample(ctx, content, SETTINGS, head=head)
    assert inside.focus_m == pytest.approx(4.0, rel=1e-5)
    wider, _ = sample(ctx, content, SETTINGS.model_copy(update={"zone_ratio": 0.3}), head=head)
    assert wider.focus_m > 1000  # the sky at 30 km, in a mean of metres
    taller, _ = sample(ctx, content, SETTINGS, head=head, tangents=(1.0, 1.0))
    assert taller.focus_m > 1000


def test_holes_and_glass_let_the_focus_through(ctx):
    near = at(0.0, 0.0, -1.0, mesh=(1,), semantic_weight=1.0)
    nearer = at(0.0, 0.0, -0.5, mesh=(2,), semantic_weight=1.0)
    far = at(0.0, 0.0, -5.0, scale=np.full(3, 60.0))
    white = (1.0, 1.0, 1.0)
    hole = Material(base_color=(*white, 0.2), alpha_mode="MASK", alpha_cutoff=0.5)
    materials = [glowing(white), glowing(white, alpha_mode="BLEND"), hole]
    meshes = [wall(), wall(4.0, material=1), wall(4.0, material=2)]
    content = scene([far, near, nearer], meshes, materials)
    found, focus = sample(ctx, content, SETTINGS)
    assert found.focus_m == pytest.approx(5.0, rel=1e-5)
    assert focus.triangles == 4  # glass is not even sent


def test_a_scene_of_sky_alone_is_at_infinity(ctx):
    for infinity_m in (100.0, 30_000.0, 1e20):
        settings = SETTINGS.model_copy(update={"infinity_m": infinity_m})
        found, _ = sample(ctx, scene([], [], []), settings)
        assert found.focus_m == pytest.approx(infinity_m, rel=1e-5)


def test_the_image_is_as_wide_as_both_eyes_see_on_average():
    left = Fov(*np.arctan([-1.2, 0.8, 1.0, -1.1]).tolist())
    right = Fov(*np.arctan([-0.8, 1.2, 1.0, -1.1]).tolist())
    views = (View(Pose(), left), View(Pose(), right))
    assert screen_tangents(views) == pytest.approx((1.0, 1.05))
