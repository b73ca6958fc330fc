from dataclasses import replace

import numpy as np
import pytest

from tests.support.render import DARK, at, box, eye, floor, glowing, mesh, scene, wall
from vrcomfort.geometry import Pose, axis_angle
from vrcomfort.render.lighting import LampReach
from vrcomfort.render.output import distance_m, read_depth, read_linear, read_texture
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Environment, Image, LodLevel, Material, PointLight

RED, GREEN, WHITE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 1.0)
SIZE = (64, 64)


def drawn(ctx, content, camera=None, *, time_s=0.0, samples=4):
    scene_pass = ScenePass(ctx, content, SIZE, velocity=False, samples=samples)
    scene_pass.render(camera or eye(), time_s)
    return read_linear(scene_pass.colour), read_depth(scene_pass.depth)


def test_a_triangle_covers_the_pixels_worked_out_by_hand(ctx):
    # At 1 m a pixel is 1/32 m: the legs of this triangle are 32 px from the image's centre.
    triangle = mesh([[0, 0, -1], [1, 0, -1], [0, 1, -1]], [0, 1, 2])
    colour, depth = drawn(ctx, scene([at(0, 0, 0)], [triangle], [glowing(RED)]), samples=1)
    x, y = np.meshgrid(np.arange(64) + 0.5 - 32, 32 - (np.arange(64) + 0.5))
    inside = (x > 0) & (y > 0) & (x + y < 32)
    edge = np.abs(x + y - 32) < 1e-9
    np.testing.assert_array_equal((colour[..., 0] > 0)[~edge], inside[~edge])
    np.testing.assert_allclose(distance_m(depth, 0.02)[inside & ~edge], 1.0, rtol=1e-6)
    assert np.all(depth[~inside & ~edge] == 0)


def test_depth_is_measured_along_the_eye_axis_far_from_the_origin(ctx):
    far = 30_000.0
    content = scene([at(far, 0, -5)], [wall(100)], [glowing(RED)])
    _, depth = drawn(ctx, content, eye((far, 0, 0)))
    np.testing.assert_allclose(distance_m(depth, 0.02), 5.0, rtol=1e-6)


def test_the_nearer_of_two_walls_wins_in_either_order(ctx):
    materials = [glowing(RED), glowing(GREEN)]
    for order in ((0, 1), (1, 0)):
        nodes = [at(0, 0, -2 - n, mesh=(n,)) for n in order]
        colour, _ = drawn(ctx, scene(nodes, [wall(20), wall(20, 1)], materials))
        np.testing.assert_allclose(colour[32, 32], RED, atol=1e-3)


def test_colour_is_the_mean_of_samples_and_depth_is_one_of_them(ctx):
    # A red wall at 1 m covers part of a pixel column in front of a green one at 2 m.
    near, far = wall(0.501 * 2), wall(20, 1)
    nodes = [at(0, 0, -1, mesh=(0,)), at(0, 0, -2, mesh=(1,))]
    colour, depth = drawn(ctx, scene(nodes, [near, far], [glowing(RED), glowing(GREEN)]))
    red = colour[..., 0]
    mixed = (red > 0.01) & (red < 0.99)
    np.testing.assert_allclose(colour.sum(axis=-1), 1.0, atol=2e-3)
    assert not mixed.any() or set(np.round(red[mixed] * 4).tolist()) <= {1, 2, 3}
    distances = distance_m(depth, 0.02)
    assert np.all(np.isclose(distances, 1, rtol=1e-5) | np.isclose(distances, 2, rtol=1e-5))


def test_back_faces_are_culled_unless_double_sided_and_mirrors_turn_them(ctx):
    turned = axis_angle([0.0, 1.0, 0.0], np.pi)
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    mirror[2, 3] = -2
    for node, double_sided, seen in [
        (at(0, 0, -2, rotation=turned), False, False),
        (at(0, 0, -2, rotation=turned), True, True),
        (at(0, 0, 0, matrix=mirror), False, True),
    ]:
        content = scene([node], [wall(20)], [glowing(RED, double_sided=double_sided)])
        assert (drawn(ctx, content)[0].max() > 0.5) == seen


def test_the_sun_lights_by_the_cosine_and_casts_shadows(ctx):
    sun = replace(
        DARK,
        sun_direction=np.array([0.0, 1.0, 0.0]),
        sun_irradiance=(np.pi, np.pi, np.pi),
        shadow_distance_m=8.0,
    )
    gray = Material(base_color=(0.5, 0.5, 0.5, 1), roughness=1.0)
    looking_down = eye((0, 3, 0), axis_angle([1.0, 0.0, 0.0], -np.pi / 2))
    open_floor = scene([at(0, 0, 0)], [floor()], [gray], environment=sun)
    lit, _ = drawn(ctx, open_floor, looking_down)
    # Diffuse 0.5 · irradiance / pi = 0.5, and a little from the rough highlight.
    np.testing.assert_allclose(lit[5, 32], 0.5, atol=0.04)

    nodes = [at(0, 0, 0), at(0, 6, 0, mesh=(1,))]
    shaded, _ = drawn(ctx, scene(nodes, [floor(), box(1)], [gray], environment=sun), looking_down)
    # The box hovers above the eye; 1 m of shadow at 3 m is 5 px to each side of the centre.
    assert np.all(shaded[28:36, 28:36] == 0)
    np.testing.assert_allclose(shaded[5], lit[5], rtol=1e-2)

    nodes[1] = replace(nodes[1], casts_shadow=False)
    spared, _ = drawn(ctx, scene(nodes, [floor(), box(1)], [gray], environment=sun), looking_down)
    np.testing.assert_array_equal(spared, lit)


def test_shadows_move_with_what_casts_them_and_stay_put_when_the_head_moves(ctx):
    sun = Environment(sun_direction=np.array([0.0, 1.0, 0.0]), shadow_distance_m=8.0)
    gray = Material(base_color=(0.5, 0.5, 0.5, 1), roughness=1.0)
    nodes = [at(0, 0, 0), at(0, 6, 0, mesh=(1,))]
    content = scene(nodes, [floor(), box(1)], [gray], environment=sun)
    scene_pass = ScenePass(ctx, content, SIZE, velocity=False)
    down = axis_angle([1.0, 0.0, 0.0], -np.pi / 2)
    camera = eye((0, 3, 0), down)
    images = []
    for head in (Pose(), Pose((0.11, 0, 0.07)), Pose((3.0, 0, 0))):
        scene_pass.render(replace(camera, world_from_head=head), 0.0)
        images.append(read_linear(scene_pass.colour))
    np.testing.assert_array_equal(images[0], images[1])
    np.testing.assert_allclose(images[0], images[2], atol=2e-3)


def test_a_lamp_lights_by_the_inverse_square_inside_its_range_only(ctx):
    lamp = PointLight((0.0, 1.0, 0.0), (np.pi, np.pi, np.pi), 4.0)
    gray = Material(base_color=(0.5, 0.5, 0.5, 1), roughness=1.0)
    content = scene(
        [at(0, 0, 0)], [floor()], [gray], environment=replace(DARK, point_lights=(lamp,))
    )
    looking_down = eye((0, 8, 0), axis_angle([1.0, 0.0, 0.0], -np.pi / 2))
    colour, _ = drawn(ctx, content, looking_down)
    falloff = (1 - 0.25**4) ** 2
    np.testing.assert_allclose(colour[32, 32], 0.5 * falloff, rtol=0.1)
    beyond = int(32 + 4.2 * 32 / 8)
    assert colour[32, beyond].max() == 0


def test_masks_cut_holes_and_blends_let_through(ctx):
    pixels = np.full((8, 8, 4), 255, np.uint8)
    pixels[:, :4, 3] = 0
    masked = glowing(RED, alpha_mode="MASK", base_color_image=0)
    masked = replace(masked, base_color=(0, 0, 0, 1))
    half = replace(glowing(GREEN, alpha_mode="BLEND"), base_color=(0, 0, 0, 0.5))
    content = scene(
        [at(0, 0, -1)],
        [wall(4)],
        [masked],
        images=(Image(pixels, ("clamp_to_edge", "clamp_to_edge")),),
    )
    colour, depth = drawn(ctx, content)
    assert colour[32, 4].max() == 0
    assert depth[32, 4] == 0
    np.testing.assert_allclose(colour[32, 60], RED, atol=1e-3)

    nodes = [at(0, 0, -1), at(0, 0, -3, mesh=(1,))]
    content = scene(nodes, [wall(4), wall(20, 1)], [half, glowing(RED)])
    colour, depth = drawn(ctx, content)
    np.testing.assert_allclose(colour[32, 32], (0.5, 0.5, 0), atol=2e-3)
    np.testing.assert_allclose(distance_m(depth, 0.02)[32, 32], 3, rtol=1e-5)


def test_level_of_detail_follows_the_distance_of_the_head(ctx):
    node = at(0, 0, -5, lod=(LodLevel(8.0, (1,)), LodLevel(20.0, ())))
    content = scene([node], [wall(40), wall(40, 1)], [glowing(RED), glowing(GREEN)])
    scene_pass = ScenePass(ctx, content, SIZE, velocity=False)
    for z, expected in ((0, RED), (4, GREEN), (16, (0, 0, 0))):
        scene_pass.render(eye((0, 0, z)), 0.0)
        np.testing.assert_allclose(read_linear(scene_pass.colour)[32, 32], expected, atol=1e-3)


def test_the_sky_fills_only_what_is_empty_and_has_depth_zero(ctx):
    sky = replace(DARK, sky_zenith=WHITE, sky_horizon=WHITE, ground=WHITE)
    content = scene([at(0, 0, -1)], [wall(1)], [glowing(RED)], environment=sky)
    colour, depth = drawn(ctx, content)
    np.testing.assert_allclose(colour[2, 2], WHITE, rtol=1e-3)
    assert depth[2, 2] == 0
    assert depth[32, 32] > 0


def test_fog_takes_what_the_air_between_takes(ctx):
    fog = replace(DARK, fog_color=(0.0, 0.0, 1.0), fog_density_per_m=0.1)
    content = scene([at(0, 0, -5)], [wall(100)], [glowing(RED)], environment=fog)
    colour, _ = drawn(ctx, content)
    left = np.exp(-0.1 * 5)
    np.testing.assert_allclose(colour[32, 32], (left, 0, 1 - left), rtol=5e-3, atol=1e-3)


def test_an_empty_scene_is_sky_in_any_size(ctx):
    for size in ((1, 1), (7, 5), (33, 64)):
        scene_pass = ScenePass(ctx, scene([], [], []), size, velocity=True)
        scene_pass.render(eye(), 0.0)
        assert np.isfinite(read_texture(scene_pass.colour)).all()
        assert np.all(read_depth(scene_pass.depth) == 0)


def test_the_whole_range_of_half_floats_stays_finite(ctx):
    blinding = glowing((1e9, 1e9, 1e9))
    colour, _ = drawn(ctx, scene([at(0, 0, -1)], [wall(4)], [blinding]))
    assert colour.max() == pytest.approx(65504)
    assert np.isfinite(colour).all()


def test_a_lamp_reaches_the_boxes_within_its_range():
    """The nearest sides of boxes are 0.9, 1.2, 2.9 and 3.1 m away."""
    lamps = tuple(PointLight((0.0, 0.0, 0.0), WHITE, range_m) for range_m in (1.0, 3.0))
    centers = np.array([[1.4, 0.0, 0.0], [0.0, -1.7, 0.0], [0.0, 0.0, 3.4], [-3.6, 0.0, 0.0]])
    reach = LampReach(replace(DARK, point_lights=lamps))
    assert reach.bits(centers, np.full((4, 3), 0.5)).tolist() == [3, 2, 2, 0]
