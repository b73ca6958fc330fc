"""Things of different materials are drawn together, and each still has its own."""

import numpy as np
import pytest

from tests.support.render import at, eye, glowing, scene, still_life, wall
from vrcomfort.errors import InputError
from vrcomfort.gpu import shaders
from vrcomfort.render.draw_list import DrawList
from vrcomfort.render.materials import materials_per_block
from vrcomfort.render.output import read_depth, read_linear
from vrcomfort.render.scene_buffers import PlacedRows
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Image, Material
from vrcomfort.scene.load import load_scene
from vrcomfort.scene.node_poses import NodePoses

SIZE = (64, 64)
RED, GREEN, BLUE = np.eye(3)


def drawn(ctx, content, camera=None):
    """Return what a scene looks like, and how many draws it took."""
    scene_pass = ScenePass(ctx, content, SIZE, velocity=False)
    scene_pass.render(camera or eye(), 0.0)
    return read_linear(scene_pass.colour), scene_pass.gpu.draws


def picture(color, size=8):
    pixels = np.full((size, size, 4), 255, np.uint8)
    pixels[..., :3] = np.array(color) * 255
    return Image(pixels)


def shining(image):
    """Return a material that shows an image whatever the light."""
    return Material(base_color=(0, 0, 0, 1), emissive=(1, 1, 1), emissive_image=image)


def beside_each_other(materials, **settings):
    """Return a scene of walls side by side, two for each metre, one for each material."""
    count = len(materials)
    nodes = [at(0.5 * k - 0.25 * (count - 1), 0, -1, mesh=(k,)) for k in range(count)]
    walls = [wall(0.5, k) for k in range(count)]
    return scene(nodes, walls, materials, **settings)


def middles(colour, count):
    """Return the colours in the middle of the walls."""
    return [colour[32, round(32 + 16 * (k - (count - 1) / 2))] for k in range(count)]


def test_constants_of_their_own_take_no_draw_of_their_own(ctx):
    colour, draws = drawn(ctx, beside_each_other([glowing(c) for c in (RED, GREEN, BLUE)]))
    np.testing.assert_allclose(middles(colour, 3), (RED, GREEN, BLUE), atol=1e-3)
    assert draws == 1


def test_images_of_one_size_take_one_draw_and_of_two_sizes_two(ctx):
    materials = [shining(k) for k in range(3)]
    alike = [picture(RED), picture(GREEN), picture(BLUE)]
    colour, draws = drawn(ctx, beside_each_other(materials, images=tuple(alike)))
    np.testing.assert_allclose(middles(colour, 3), (RED, GREEN, BLUE), atol=1e-3)
    assert draws == 1
    other = (*alike[:2], picture(BLUE, size=16))
    colour, draws = drawn(ctx, beside_each_other(materials, images=other))
    np.testing.assert_allclose(middles(colour, 3), (RED, GREEN, BLUE), atol=1e-3)
    assert draws == 2


def test_the_last_of_more_materials_than_a_block_holds_has_its_own_colour(ctx):
    count = materials_per_block() + 1
    materials = [glowing(RED)] * (count - 1) + [glowing(GREEN)]
    nodes = [at(-0.5, 0, -1, mesh=(0,)), at(0.5, 0, -1, mesh=(1,))]
    content = scene(nodes, [wall(1, count - 2), wall(1, count - 1)], materials)
    colour, draws = drawn(ctx, content)
    np.testing.assert_allclose((colour[32, 16], colour[32, 48]), (RED, GREEN), atol=1e-3)
    assert draws == 2


def test_a_block_of_materials_is_no_larger_than_every_driver_has():
    size = shaders.struct_dtype("material.glsl", "Material").itemsize
    assert size % 16 == 0, "std140 would pad it"
    assert 15_000 < materials_per_block() * size <= 16_384


def test_images_of_too_many_kinds_are_told_in_a_sentence(ctx):
    images = tuple(picture(RED, size=1 + k) for k in range(64))
    with pytest.raises(InputError, match=r"'test' has images of 64 kinds .* at most 62 .*sizes$"):
        ScenePass(ctx, beside_each_other([shining(k) for k in range(64)], images=images), SIZE,
                  velocity=False)  # fmt: skip


def test_scenes_that_take_turns_keep_their_images(ctx):
    contents = [beside_each_other([shining(0)], images=(picture(c),)) for c in (RED, GREEN)]
    passes = [ScenePass(ctx, content, SIZE, velocity=False) for content in contents]
    for _ in range(2):
        for scene_pass, color in zip(passes, (RED, GREEN), strict=True):
            scene_pass.render(eye(), 0.0)
            found = read_linear(scene_pass.colour)[32, 32]
            np.testing.assert_allclose(found, color, atol=1e-3)


def test_eyes_that_are_looked_for_together_see_what_each_sees_alone(ctx):
    content = still_life()
    head = eye((0, 1, 0.5)).world_from_eye
    eyes = [eye((x, 1, 0.5), world_from_head=head) for x in (-0.4, 0.4)]
    together, alone = (ScenePass(ctx, content, SIZE, velocity=False) for _ in range(2))
    together.update(0.0, head, 0.0, eyes)
    images = []
    for camera in eyes:
        together.render(camera, 0.0)
        alone.render(camera, 0.0)
        images.append(read_linear(together.colour))
        assert np.array_equal(images[-1], read_linear(alone.colour))
        assert np.array_equal(read_depth(together.depth), read_depth(alone.depth))
    assert not np.array_equal(*images)


@pytest.mark.parametrize("name", ["temple", "mountain"])
def test_boxes_and_levels_of_what_moves_are_those_of_the_whole_scene(name):
    content = load_scene(name)
    table, poses = DrawList.of(content), NodePoses(content)
    moving = PlacedRows(table, poses.moving[table.node])
    every = PlacedRows(table, np.ones(len(table.node), dtype=bool))
    world = content.world_from_node(1.7)
    centers, halves = every.boxes(world)
    found = moving.boxes(world)
    np.testing.assert_allclose(found, (centers[moving.rows], halves[moving.rows]))
    for placed, boxes in ((moving, found), (every, (centers, halves))):
        expected = np.zeros((0, 3))
        for row in placed.with_levels:
            finest = (table.node == table.node[row]) & table.base_level
            corners = [(centers - halves)[finest].min(0), (centers + halves)[finest].max(0)]
            expected = np.concatenate([expected, [np.mean(corners, axis=0)]])
        np.testing.assert_allclose(placed.level_centers(*boxes), expected)
    assert len(moving.rows)
    assert len(every.with_levels) > len(moving.with_levels)
