"""The scenes that ship: as they are described, clean, small, rebuilt by their scripts."""

from __future__ import annotations

import io
import json
import struct
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image as PillowImage

from tests.oracles.raycast import cast
from vrcomfort.geometry import Fov, clip_from_view, rotate, rotation_matrix, yaw_pitch_roll
from vrcomfort.render import culling
from vrcomfort.render.draw_list import DrawList
from vrcomfort.render.scene_buffers import DetailLevels, PlacedRows
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene

NAMES = ("temple", "mountain", "depths")
EYE = np.array([0.0, 1.6, 0.0])


@pytest.fixture(scope="module", params=NAMES)
def scene(request):
    return load_scene(request.param)


def inside(polygon, point):
    """Return whether a point is in a simple polygon (crossings to the right)."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    crosses = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = a[:, 0] + (point[1] - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return bool((crosses & (x > point[0])).sum() % 2)


def floor_points(scene, step_m=1.1):
    """Return (n, 3) points on the walkable floor."""
    points = []
    for area in scene.walkable:
        low, high = area.polygon_xz.min(axis=0), area.polygon_xz.max(axis=0)
        places = np.stack(
            np.meshgrid(*(np.arange(a + 0.2, b, step_m) for a, b in zip(low, high, strict=True))),
            -1,
        )
        points += [
            (x, area.height_m, z)
            for x, z in places.reshape(-1, 2)
            if inside(area.polygon_xz, (x, z))
        ]
    return np.array(points)


def view_rays(position, yaw_deg, count=24, half_angle_deg=40.0):
    """Return origins and directions of a fan of rays over a view."""
    tangent = np.tan(np.radians(np.linspace(-half_angle_deg, half_angle_deg, count)))
    x, y = np.meshgrid(tangent, tangent)
    local = np.stack([x, y, -np.ones_like(x)], axis=-1).reshape(-1, 3)
    directions = rotate(yaw_pitch_roll(np.radians(yaw_deg), 0.0, 0.0), local)
    return np.broadcast_to(position, directions.shape), directions


def test_small_enough_and_without_a_warning(scene):
    assert (data_folder("scenes") / f"{scene.name}.glb").stat().st_size <= 8_000_000
    assert scene.warnings == ()


@pytest.mark.smoke
def test_something_moves(scene):
    moving = [node for node in scene.nodes if node.moving and node.mesh]
    assert moving
    assert not np.array_equal(scene.world_from_node(0.0), scene.world_from_node(0.7))


def test_animations_loop_without_a_jump(scene):
    for animation in scene.animations:
        before, after = (
            scene.world_from_node(animation.duration_s * k) for k in (1 - 1e-6, 1 + 1e-6)
        )
        assert np.abs(before - after).max() < 1e-2


def test_meshes_are_sound(scene):
    for primitive in scene.primitives:
        assert primitive.indices.max() < len(primitive.positions)
        np.testing.assert_allclose(np.linalg.norm(primitive.normals, axis=1), 1.0, atol=0.02)
        assert np.isfinite(primitive.uvs).all()
        a, b, c = np.moveaxis(primitive.positions.astype(float)[primitive.indices], 1, 0)
        assert (np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0).mean() > 0.97


def test_normals_face_outwards(scene):
    for primitive in scene.primitives:
        material = scene.materials[primitive.material]
        if material.alpha_mode == "MASK" or material.double_sided:
            continue  # leaves borrow their normals from the crown
        a, b, c = np.moveaxis(primitive.positions.astype(float)[primitive.indices], 1, 0)
        face = np.cross(b - a, c - a)
        mean = primitive.normals[primitive.indices].sum(axis=1)
        agree = np.einsum("ij,ij->i", face, mean) >= -1e-9
        assert agree.mean() > 0.9, scene.materials[primitive.material].name


def test_spawn_is_on_the_walkable_floor(scene):
    x, y, z = scene.spawn.position
    assert any(inside(area.polygon_xz, (x, z)) and area.height_m == y for area in scene.walkable)


def test_walkable_floor_is_a_floor(scene):
    points = floor_points(scene)
    assert len(points) > 40
    nodes = tuple(replace(n, mesh=()) if n.name.startswith("grass") else n for n in scene.nodes)
    scene = replace(scene, nodes=nodes)
    down = cast(scene, 0.0, points + np.array([0, 0.6, 0]), np.tile([0.0, -1, 0], (len(points), 1)))
    np.testing.assert_allclose(down, 0.6, atol=0.03)


@pytest.mark.slow
def test_nothing_stands_in_the_way_of_a_head(scene):
    points = floor_points(scene)
    for turn in range(0, 360, 45):
        ahead = np.tile([np.sin(np.radians(turn)), 0, np.cos(np.radians(turn))], (len(points), 1))
        assert (cast(scene, 0.0, points + EYE, ahead) > 0.12).all()


@pytest.mark.slow
def test_temple_is_near_and_mountain_is_far():
    nearest = {}
    for name in ("temple", "mountain"):
        scene = load_scene(name)
        turns = [
            cast(scene, 0.0, *view_rays(scene.spawn.position + EYE, yaw))
            for yaw in (0, 90, 180, 270)
        ]
        nearest[name] = np.concatenate(turns)
    temple, mountain = nearest["temple"], nearest["mountain"]
    indoors = temple[np.isfinite(temple)]
    assert np.median(indoors) < 8
    assert (indoors < 20).mean() > 0.97
    land = mountain[np.isfinite(mountain)]
    assert (land > 1_000).mean() > 0.08
    assert land.max() > 20_000
    assert (land < 6).mean() > 0.1


def test_temple_has_a_bright_a_natural_and_a_dark_room():
    scene = load_scene("temple")
    assert len(scene.environment.point_lights) >= 4
    assert scene.environment.ambient_in_vertex_alpha
    ambient = {"court_floor": [], "hall_floor": [], "crypt_floor": []}
    for node in scene.nodes:
        for room, values in ambient.items():
            if node.name.startswith(room):
                values += [scene.primitives[item].colors[:, 3].mean() for item in node.mesh]
    bright, natural, dark = (np.mean(values) for values in ambient.values())
    assert bright > natural > 4 * dark


@pytest.mark.parametrize("name", NAMES)
def test_at_most_thirty_thousand_triangles_are_in_view(name):
    scene = load_scene(name)
    table = DrawList.of(scene)
    world = scene.world_from_node(0.0)
    rows = PlacedRows(table, np.ones(len(table.node), dtype=bool))
    centers, halves = rows.boxes(world)
    places = np.zeros((3, len(table.node)))
    places[:, rows.with_levels] = rows.level_centers(centers, halves).T
    levels = DetailLevels.of(table, rows.rows)
    triangles = table.commands["index_count"] // 3
    worst = 0
    for point in floor_points(scene, 2.5) + EYE:
        level = levels.in_use(places, point)
        for yaw in range(0, 360, 45):
            planes = culling.planes(_clip_from_relative(yaw))
            seen = culling.visible(planes, culling.boxes(centers - point, halves))
            worst = max(worst, int(triangles[seen & level].sum()))
    assert worst <= 32_000


def _clip_from_relative(yaw_deg):
    """Return the projection of a 90° × 90° view, from world axes about the eye."""
    view = np.eye(4)
    view[:3, :3] = rotation_matrix(yaw_pitch_roll(np.radians(yaw_deg), 0.0, 0.0)).T
    return clip_from_view(Fov.symmetric(vertical_rad=np.pi / 2, aspect=1.0), 0.02) @ view


BUILD = """
import runpy, sys
from pathlib import Path
from PIL import Image
save = Image.Image.save
Image.Image.save = lambda *given, **more: save(*given, **{**more, "compress_level": 1})
script = sys.argv.pop(1)
sys.path.insert(0, str(Path(script).parent))
runpy.run_path(script, run_name="__main__")
"""
"""Packing pictures as small as they ship takes a third of the time of a scene."""


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_scripts_rebuild_the_shipped_files(tmp_path, name):
    folder = data_folder("scenes")
    rebuilt = tmp_path / f"{name}.glb"
    subprocess.run([sys.executable, "-c", BUILD, folder / f"build_{name}.py", rebuilt], check=True)
    assert_same_content(rebuilt.read_bytes(), (folder / f"{name}.glb").read_bytes())


def assert_same_content(a, b):
    """Compare two GLB files decoded: structure, numbers and pictures."""
    (root_a, data_a), (root_b, data_b) = unpack(a), unpack(b)
    for key in ("nodes", "materials", "meshes", "scenes"):
        assert root_a[key] == root_b[key]
    for one, other in zip(root_a["accessors"], root_b["accessors"], strict=True):
        kind = {5126: "<f4", 5120: "i1", 5121: "u1", 5123: "<u2", 5125: "<u4"}[one["componentType"]]
        values = [
            np.frombuffer(view(root, data, item), kind).astype(float)
            for root, data, item in ((root_a, data_a, one), (root_b, data_b, other))
        ]
        np.testing.assert_allclose(*values, rtol=1e-6, atol=2e-3 if kind == "<f4" else 1)
    for one, other in zip(root_a["images"], root_b["images"], strict=True):
        pictures = [
            np.asarray(PillowImage.open(io.BytesIO(view(root, data, item))).convert("RGBA"), float)
            for root, data, item in ((root_a, data_a, one), (root_b, data_b, other))
        ]
        assert (np.abs(pictures[0] - pictures[1]).max(axis=2) <= 12).mean() > 0.999


def unpack(data):
    """Return the JSON and the binary chunk of a GLB."""
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def view(root, data, item):
    """Return the bytes of an accessor's or image's buffer view."""
    where = root["bufferViews"][item["bufferView"]]
    return data[where["byteOffset"] : where["byteOffset"] + where["byteLength"]]


def test_columns_are_closed_where_shaft_base_and_capital_meet():
    """Rays at the joints, flutes included, end there; and no joint is a black line."""
    scene = load_scene("temple")
    foot = np.array([-2.95, 0.0, -1.6])
    turn = np.radians(np.arange(0, 360, 2.5))
    around = np.stack([np.sin(turn), 0 * turn, np.cos(turn)], axis=1)
    for radius_m, height_m, eye_m in ((0.29, 0.565, 1.6), (0.25, 3.89, 1.6), (0.247, 3.885, 0.8)):
        origins = foot + around * 0.65 + np.array([0, eye_m, 0])
        aimed = foot + around * radius_m + np.array([0, height_m, 0]) - origins
        hit = cast(scene, 0.0, origins, aimed)
        beyond_m = hit - np.linalg.norm(aimed, axis=1)
        assert beyond_m.max() < 0.1, f"a gap at {height_m} m, seen from {eye_m} m"
    (node,) = (node for node in scene.nodes if node.name == "column_w2")
    assert min(scene.primitives[item].colors[:, 3].min() for item in node.mesh) > 0.05


@pytest.mark.parametrize(
    ("name", "floor", "at", "radius_m"),
    [
        ("mountain", "ground_", (2.1, -3.3), 0.45),
        ("temple", "court_floor", (-2.95, -1.6), 0.45),
        ("temple", "hall_floor", (6.35, -3.1), 0.33),
    ],
)
def test_floors_are_darker_around_what_stands_on_them(name, floor, at, radius_m):
    scene = load_scene(name)
    items = [item for node in scene.nodes if node.name.startswith(floor) for item in node.mesh]
    places = np.concatenate([scene.primitives[item].positions for item in items])
    ambient = np.concatenate([scene.primitives[item].colors[:, 3] for item in items])
    away_m = np.hypot(places[:, 0] - at[0], places[:, 2] - at[1])
    close = (away_m > radius_m - 0.1) & (away_m < radius_m + 0.25)
    beyond = (away_m > radius_m + 0.9) & (away_m < radius_m + 2)
    assert close.sum() >= 4, "the floor is fine enough to be dark there alone"
    assert ambient[close].mean() < 0.85 * np.quantile(ambient[beyond], 0.8)


def test_grass_is_rooted_and_lit_as_the_ground_is():
    scene = load_scene("mountain")
    tufts = [p for p in scene.primitives if scene.materials[p.material].name == "grass"]
    assert tufts
    for tuft in tufts:
        np.testing.assert_array_equal(tuft.normals, np.tile([0, 1, 0], (len(tuft.normals), 1)))
        blades = tuft.positions[tuft.indices]
        root, tip = blades[..., 1].argmin(axis=1), blades[..., 1].argmax(axis=1)
        row = np.arange(len(blades))
        assert (blades[row, root, 1] < 0).all()
        colors = tuft.colors[tuft.indices][..., :3]
        assert (colors[row, root] <= colors[row, tip]).all()
        assert colors[row, root].mean() < 0.6 * colors[row, tip].mean()
