"""The autofocus zone: weights and means as mathematics, and the GPU against them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.oracles.autofocus_zone import halved, zone_focus_m
from tests.support.render import at, glowing, scene, wall
from vrcomfort.geometry import Fov, Pose, View, yaw_pitch_roll
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import autofocus_zone as zone
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.autofocus_zone import screen_tangents
from vrcomfort.render.focus.rules import RULES, make_focus_pass
from vrcomfort.render.focus.search import HeadView
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.scene.data import Material

NEAR_M = 0.02
SETTINGS = Focus(method="autofocus_zone", law="instant")
sizes = st.tuples(st.integers(1, 37), st.integers(1, 37))


@pytest.mark.parametrize("size_px", [(1, 1), (63, 17)])
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
        found = zone.reduced(np.full((3, 5), depth), np.full((3, 5), 0.5), NEAR_M, settings)
        focus_m = zone_focus_m(found, NEAR_M, settings)
        assert focus_m == pytest.approx(expected, rel=1e-9)


def test_the_mean_by_hand():
    """A target at 2 m on one pixel of four, a wall at 10 m on the rest; the same W_G for all."""
    depth = NEAR_M / np.array([[2.0, 10.0], [10.0, 10.0]])
    semantic = np.array([[1.0, 0.004], [0.004, 0.004]])
    found = zone_focus_m(zone.reduced(depth, semantic, NEAR_M, SETTINGS), NEAR_M, SETTINGS)
    assert found == pytest.approx((2.0 + 3 * 0.004 * 10) / 1.012)
    alike = Focus(semantic_max=0.004)
    found = zone_focus_m(zone.reduced(depth, semantic, NEAR_M, alike), NEAR_M, alike)
    assert found == pytest.approx(8.0)


@pytest.mark.parametrize(("statistic", "of_all_m"), [("minimum", 2.0), ("maximum", 10.0)])
def test_the_extremes_by_hand(statistic, of_all_m):
    """Of what weighs more than the least: 3 m and 5 m. Where all weigh the same, of everything."""
    depth = NEAR_M / np.array([[2.0, 10.0], [5.0, 3.0]])
    semantic = np.array([[0.004, 0.004], [1.0, 0.01]])
    settings = SETTINGS.model_copy(update={"zone_statistic": statistic})
    found = zone_focus_m(zone.reduced(depth, semantic, NEAR_M, settings), NEAR_M, settings)
    assert found == pytest.approx(3.0 if statistic == "minimum" else 5.0)
    alike = settings.model_copy(update={"semantic_max": 0.004})
    found = zone_focus_m(zone.reduced(depth, semantic, NEAR_M, alike), NEAR_M, alike)
    assert found == pytest.approx(of_all_m)


@given(
    sizes.flatmap(lambda size: arrays(float, (2, *size), elements=st.floats(0.004, 1.0))),
    st.booleans(),
)
def test_an_extreme_is_one_of_the_pixels_and_none_goes_beyond_it(image, weighs):
    distance_m, semantic = 10 * image[0], image[1] if weighs else np.full(image[1].shape, 0.004)
    found = {}
    for statistic in ("minimum", "mean", "maximum"):
        settings = Focus(zone_statistic=statistic)
        reduced = zone.reduced(NEAR_M / distance_m, semantic, NEAR_M, settings)
        found[statistic] = zone_focus_m(reduced, NEAR_M, settings)
    first = semantic > np.float32(0.004)
    among = distance_m[first] if first.any() else distance_m
    assert found["minimum"] == pytest.approx(among.min())
    assert found["maximum"] == pytest.approx(among.max())
    if not weighs:
        slack = 1 + 1e-9
        assert found["minimum"] / slack <= found["mean"] <= found["maximum"] * slack


@pytest.mark.parametrize(
    ("statistic", "size_px"),
    [("mean", (1, 1)), ("mean", (63, 17)), ("minimum", (64, 64)), ("maximum", (2, 5))],
)
def test_the_plan_counts_the_passes_that_are_drawn(ctx, statistic, size_px):
    content = target_before_a_wall()
    settings = SETTINGS.model_copy(update={"zone_statistic": statistic, "zone_size_px": size_px})
    focus = make_focus_pass(ctx, GpuScene(ctx, content), settings, near_m=NEAR_M)
    drawn = []
    render = FullscreenPass.render
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FullscreenPass, "render", lambda *a: (drawn.append(1), render(*a)))
        focus.render(HeadView(0, 0, Pose()))
    assert f"by the GPU in {len(drawn)} pass" in RULES["autofocus_zone"].plan(settings).reason


def sample(ctx, content, settings, *, head=None, tangents=(1.0, 0.8)):
    head = head or Pose()
    gpu = GpuScene(ctx, content)
    focus = make_focus_pass(ctx, gpu, settings, near_m=NEAR_M)
    gpu.update(0.0, head)
    focus.render(
        HeadView(frame_index=3, display_time_ns=0, world_from_head=head, screen_tangents=tangents)
    )
    (found,) = focus.drain()
    return found, gpu


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
    weights = np.where(hit, target_weight, 0.004)
    return zone_focus_m(zone.reduced(depth, weights, NEAR_M, settings), NEAR_M, settings)


@pytest.mark.parametrize(
    ("mean", "size_px"),
    [("metres", (64, 64)), ("dioptres", (63, 37)), ("metres", (5, 7)), ("dioptres", (40, 32))],
)
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


@pytest.mark.parametrize("size_px", [(63, 37), (5, 7)])
@pytest.mark.parametrize(
    ("statistic", "weight", "expected_m"),
    [
        ("minimum", 0.004, 2.0),
        ("maximum", 0.004, 10.0),
        ("minimum", 1.0, 2.0),
        ("maximum", 0.5, 2.0),
    ],
)
def test_the_gpu_and_the_cpu_find_the_extremes(ctx, size_px, statistic, weight, expected_m):
    content = target_before_a_wall(semantic_weight=weight)
    settings = SETTINGS.model_copy(update={"zone_statistic": statistic, "zone_size_px": size_px})
    for where in ("gpu", "cpu"):
        found, _ = sample(ctx, content, settings.model_copy(update={"zone_mean_on": where}))
        assert found.focus_m == pytest.approx(expected_m, rel=1e-6)
        assert found.focus_raw_m == found.focus_m


@pytest.mark.parametrize("statistic", ["minimum", "maximum"])
def test_the_gpu_searches_a_zone_of_many_distances_as_the_cpu_does(ctx, statistic):
    random = np.random.default_rng(3)
    nodes = [
        at(
            *random.uniform(-0.4, 0.4, 2),
            -random.uniform(1.0, 5.0),
            scale=np.full(3, 0.2),
            rotation=yaw_pitch_roll(*random.uniform(-1.0, 1.0, 3)),
            semantic_weight=random.choice([0.004, 0.01, 1.0]),
        )
        for _ in range(12)
    ]
    content = scene(nodes, [wall()], [glowing((1.0, 1.0, 1.0), double_sided=True)])
    settings = SETTINGS.model_copy(update={"zone_statistic": statistic, "zone_ratio": 0.5})
    focus_m = [
        sample(ctx, content, settings.model_copy(update={"zone_mean_on": where}))[0].focus_m
        for where in ("gpu", "cpu")
    ]
    assert focus_m[0] == pytest.approx(focus_m[1], rel=1e-6)
    assert 0.8 < focus_m[0] < 5.2


def test_the_sky_is_the_farthest_unless_something_matters(ctx):
    settings = SETTINGS.model_copy(update={"zone_statistic": "maximum", "infinity_m": 100.0})
    card = [at(0.0, 0.0, -2.0, scale=np.full(3, 0.1))]
    content = scene(card, [wall()], [glowing((1.0, 1.0, 1.0))])
    assert sample(ctx, content, settings)[0].focus_m == pytest.approx(100.0, rel=1e-6)
    nearest = settings.model_copy(update={"zone_statistic": "minimum"})
    assert sample(ctx, content, nearest)[0].focus_m == pytest.approx(2.0, rel=1e-6)
    assert sample(ctx, scene([], [], []), nearest)[0].focus_m == pytest.approx(100.0, rel=1e-6)


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
    found, gpu = sample(ctx, content, SETTINGS)
    assert found.focus_m == pytest.approx(5.0, rel=1e-5)
    assert gpu.triangles == 4  # glass is not even sent


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
