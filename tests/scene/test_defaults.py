"""A scene that does not say where to stand is shown from where it can be seen."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import trimesh

from tests.support.scene_files import quad, scene_of
from vrcomfort.frame import EYE_HEIGHT_M
from vrcomfort.geometry import axis_angle
from vrcomfort.scene.data import Material, Node
from vrcomfort.scene.defaults import with_defaults, world_bounds
from vrcomfort.scene.load import load_scene

FLAT = axis_angle([1, 0, 0], -np.pi / 2)
"""Turns a quad that faces +Z so that it faces up."""


def box_scene(path, extents, centre=(0, 0, 0)):
    box = trimesh.creation.box(extents)
    box.apply_translation(centre)
    trimesh.Scene([box]).export(path)
    return load_scene(path)


@pytest.mark.parametrize(
    "extents",
    [(0.02, 0.02, 0.02), (0.3, 0.1, 0.2), (0.5, 1.0, 0.5), (1, 30, 1), (5, 0.1, 5), (40, 3, 1),
     (4, 2, 50), (18, 15, 8)],
)  # fmt: skip
@pytest.mark.parametrize("centre", [(0, 0, 0), (100, -20, 7)])
def test_of_a_thing_all_is_in_view_of_eyes_that_look_ahead(tmp_path, extents, centre):
    scene = box_scene(tmp_path / "thing.glb", extents, centre)
    lower, upper = world_bounds(scene)
    eyes = scene.spawn.position + np.array([0, EYE_HEIGHT_M, 0])
    np.testing.assert_allclose(scene.spawn.forward, [0, 0, -1])
    for corner in product(*zip(lower, upper, strict=True)):
        x, y, z = np.array(corner) - eyes
        assert z <= -0.5 + 1e-6
        assert np.hypot(x, 0) <= -z * np.tan(np.radians(30)) + 1e-6
        assert abs(y) <= -z * np.tan(np.radians(30)) + 1e-6


def test_a_small_thing_is_held_up_and_a_large_one_stands_on_the_floor(tmp_path):
    small = box_scene(tmp_path / "small.glb", (0.1, 0.1, 0.1)).spawn
    assert small.position[1] == pytest.approx(-EYE_HEIGHT_M)
    large = box_scene(tmp_path / "large.glb", (1, 2, 1)).spawn
    assert large.position[1] == pytest.approx(-1.0)


def floor(height_m: float, half: float = 5.0, **node) -> Node:
    return Node("floor", translation=np.array([0.0, height_m, 0.0]), rotation=FLAT,
                scale=np.full(3, half), mesh=(0,), **node)  # fmt: skip


def stands_at(*nodes: Node, material: Material | None = None) -> float:
    scene = with_defaults(scene_of(*nodes, primitives=(quad(),), material=material))
    x, height_m, z = scene.spawn.position
    assert (x, z) == (0.0, 0.0)
    assert [area.height_m for area in scene.walkable] == [height_m]
    return height_m


def test_a_place_is_entered_at_its_middle_on_its_floor():
    assert stands_at(floor(0.0)) == 0.0
    assert stands_at(floor(0.0), floor(2.5)) == 0.0


def test_nobody_stands_where_there_is_no_room_for_a_head():
    assert stands_at(floor(0.0), floor(1.0), floor(4.0)) == 1.0


def test_what_faces_down_is_no_floor():
    ceiling = replace(floor(-3.0), rotation=axis_angle([1, 0, 0], np.pi / 2))
    assert stands_at(ceiling, floor(0.0)) == 0.0
    assert stands_at(ceiling, floor(0.0), material=Material(double_sided=True)) == -3.0


def test_mirroring_a_node_turns_its_triangles_over():
    mirror = np.array([5.0, 5.0, -5.0])
    turned_down = replace(floor(0.0), scale=mirror)
    assert stands_at(turned_down, floor(3.0)) == 3.0
    turned_up = replace(turned_down, rotation=axis_angle([1, 0, 0], np.pi / 2))
    assert stands_at(turned_up, floor(3.0)) == 0.0


def test_on_a_hill_one_stands_above_its_foot():
    valley = replace(floor(-90.0, half=1.0), translation=np.array([30.0, -90.0, 0.0]))
    other = replace(valley, translation=np.array([-30.0, -90.0, 0.0]))
    assert stands_at(floor(7.0), valley, other) == 7.0


def test_where_there_is_no_floor_one_stands_where_the_scene_begins():
    left = replace(floor(1.0, half=1.0), translation=np.array([-9.0, 1.0, 9.0]))
    right = replace(floor(3.0, half=1.0), translation=np.array([9.0, 3.0, -9.0]))
    assert stands_at(left, right) == pytest.approx(1.0)


def test_what_lies_beside_the_middle_in_the_same_mesh_is_no_floor_there(tmp_path):
    boxes = [trimesh.creation.box((10.0, 0.1, 10.0)) for _ in range(3)]
    for box, x, y in zip(boxes, (0.0, 30.0, -30.0), (0.0, -4.0, 9.0), strict=True):
        box.apply_translation((x, y, 0.0))
    trimesh.Scene([trimesh.util.concatenate(boxes)]).export(tmp_path / "one.glb")
    assert load_scene(tmp_path / "one.glb").spawn.position[1] == pytest.approx(0.05)
