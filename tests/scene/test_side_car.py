"""The side-car says what glTF cannot; its errors name the line."""

from __future__ import annotations

import numpy as np
import pytest

from tests.oracles.raycast import mesh_at
from tests.support.scene_files import Gltf
from vrcomfort.errors import InputError
from vrcomfort.scene.load import load_scene


def scene_with(tmp_path, side_car):
    file = Gltf()
    nodes = [
        {"mesh": 0, "name": "stone 1"},
        {"mesh": 0, "name": "stone 2", "children": [2]},
        {"mesh": 0, "name": "moss"},
        {"mesh": 1, "name": "stone 1 far"},
        {"mesh": 1, "name": "stone 2 far"},
    ]
    meshes = [{"primitives": [file.triangle()]}, {"primitives": [file.triangle()]}]
    path = file.save(tmp_path / "a.gltf", meshes=meshes, nodes=nodes, scenes=[{"nodes": [0, 1]}])
    path.with_suffix(".toml").write_text(side_car, encoding="utf-8")
    return load_scene(path)


def test_sun_stands_where_the_compass_says(tmp_path):
    scene = scene_with(tmp_path, "[sun]\nazimuth_deg = 90\nelevation_deg = 30\n")
    np.testing.assert_allclose(scene.environment.sun_direction, [np.sqrt(0.75), 0.5, 0], atol=1e-12)
    north = scene_with(tmp_path, "[sun]\nazimuth_deg = 0\nelevation_deg = 0\n")
    np.testing.assert_allclose(north.environment.sun_direction, [0, 0, -1], atol=1e-12)


def test_spawn_walkable_lamps_and_air(tmp_path):
    scene = scene_with(
        tmp_path,
        """
exposure = 2.0
[fog]
density_per_m = 1e-4
[spawn]
position = [1.0, 0.5, 2.0]
yaw_deg = 90.0
[[walkable]]
height_m = 0.5
polygon_xz = [[0, 0], [4, 0], [4, 4]]
[[lamps]]
position = [0, 2, 0]
intensity = [3, 2, 1]
range_m = 5
""",
    )
    np.testing.assert_allclose(scene.spawn.forward, [-1, 0, 0], atol=1e-12)
    (area,) = scene.walkable
    assert (area.height_m, area.polygon_xz.shape) == (0.5, (3, 2))
    (lamp,) = scene.environment.point_lights
    assert (lamp.intensity, lamp.range_m) == ((3.0, 2.0, 1.0), 5.0)
    assert (scene.environment.exposure, scene.environment.fog_density_per_m) == (2.0, 1e-4)


def test_patterns_reach_nodes_and_head_locking_reaches_children(tmp_path):
    scene = scene_with(
        tmp_path,
        '[nodes."stone *"]\nsemantic_weight = 0.5\n'
        '[nodes."stone 2"]\nhead_locked = true\nambient = 0.25\ncasts_shadow = false\n',
    )
    assert [node.name for node in scene.nodes] == ["stone 1", "stone 2", "moss"]
    assert [node.semantic_weight for node in scene.nodes] == [0.5, 0.5, 0.004]
    assert [node.head_locked for node in scene.nodes] == [False, True, True]
    assert [node.ambient for node in scene.nodes] == [1.0, 0.25, 1.0]
    assert [node.casts_shadow for node in scene.nodes] == [True, False, True]


def test_what_is_below_a_node_in_a_hand_goes_with_that_hand(tmp_path):
    scene = scene_with(
        tmp_path, '[nodes."stone 1"]\nhand = "right"\n[nodes."stone 2"]\nhand = "left"\n'
    )
    assert [node.hand for node in scene.nodes] == ["right", "left", "left"]
    assert scene.has_hands
    assert not scene_with(tmp_path, "").has_hands


def test_levels_of_detail_come_from_nodes_outside_the_scene(tmp_path):
    scene = scene_with(
        tmp_path,
        '[nodes."stone *"]\nlod = [{ from_distance_m = 9.0, node = "" }, '
        '{ from_distance_m = 5.0, node = "* far" }]\n',
    )
    stone = scene.nodes[0]
    assert [level.from_distance_m for level in stone.lod] == [5.0, 9.0]
    assert mesh_at(stone, 4.9) == (0,)
    assert mesh_at(stone, 5.0) == (1,)
    assert mesh_at(stone, 100.0) == ()


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("exposure = 1.0\n[sun]\nazimut_deg = 3\n", 3, "azimut_deg"),
        ("[sky]\nzenith = [1, 2]\n", 2, "zenith"),
        ("\n[spawn]\nposition = [0, 0, 'x']\n", 3, "position"),
        ("[fog]\ndensity_per_m = -1\n", 2, "density_per_m"),
        ("[[walkable]]\npolygon_xz = [[0, 0], [1, 1]]\n", 2, "polygon_xz"),
        ('[nodes."tree"]\nsemantic_weight = 1\n', 1, "no node of the scene is called 'tree'"),
        (
            'exposure = 1.0\n[nodes.moss]\nlod = [{ from_distance_m = 3, node = "gone" }]\n',
            3,
            "'gone'",
        ),
        ('[nodes.moss]\nhand = "both"\n', 2, "'left' or 'right'"),
        ('[nodes.moss]\nhead_locked = true\nhand = "left"\n', 1, "exclude each other; keep one"),
        ("exposure = \n", 1, "not valid TOML"),
        ("\nexposure = 1e39\n", 2, "`exposure`: should be less than or equal to"),
        ("[spawn]\nposition = [0, 1e39, 0]\n", 2, "should be less than or equal to 1000000"),
        ("sun = 3\n", 1, "`sun`: should be a table"),
        ("exposure = " + "9" * 5000, 1, "not valid TOML"),
        ("exposure = " + "[" * 9999, None, "nested too deep"),
    ],
)
def test_errors_name_the_line(tmp_path, text, line, reason):
    with pytest.raises(InputError) as caught:
        scene_with(tmp_path, text)
    assert caught.value.line == line
    assert reason in str(caught.value)
    assert caught.value.file == tmp_path / "a.toml"
