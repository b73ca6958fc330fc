"""Any glTF 2.0 file loads; what the loader does not support is named."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from tests.support.scene_files import Gltf, png
from vrcomfort.geometry import axis_angle, normalize
from vrcomfort.scene.animation import Channel, sample
from vrcomfort.scene.defaults import world_bounds
from vrcomfort.scene.load import load_scene


def world_positions(scene, time_s=0.0):
    """Return all drawn positions in the world."""
    world = scene.world_from_node(time_s)
    return np.concatenate(
        [
            scene.primitives[item].positions @ matrix[:3, :3].T + matrix[:3, 3]
            for node, matrix in zip(scene.nodes, world, strict=True)
            for item in node.mesh
        ]
    )


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
@pytest.mark.smoke
def test_agrees_with_another_writer(tmp_path, suffix):
    shape = trimesh.Scene()
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0.5, 0, 0])
    shape.add_geometry(trimesh.creation.icosphere(subdivisions=2), transform=turn)
    box = trimesh.creation.box([1, 2, 3])
    shape.add_geometry(box, transform=trimesh.transformations.translation_matrix([4, 5, 6]))
    if suffix == ".glb":
        shape.export(tmp_path / "shape.glb")
    else:
        for name, data in trimesh.exchange.gltf.export_gltf(shape).items():
            (tmp_path / ("shape.gltf" if name.endswith(".gltf") else name)).write_bytes(data)
    scene = load_scene(tmp_path / f"shape{suffix}")
    lower, upper = world_bounds(scene)
    np.testing.assert_allclose(
        [world_positions(scene).min(axis=0), world_positions(scene).max(axis=0)],
        shape.bounds,
        atol=1e-5,
    )
    assert (lower <= shape.bounds[0] + 1e-5).all()
    assert (upper >= shape.bounds[1] - 1e-5).all()
    assert sum(len(p.indices) for p in scene.primitives) == 320 + 12
    assert scene.warnings == ()


def test_missing_normals_are_flat(tmp_path):
    file = Gltf()
    scene = load_scene(file.save(tmp_path / "a.gltf", meshes=[{"primitives": [file.triangle()]}]))
    primitive = scene.primitives[0]
    np.testing.assert_array_equal(primitive.normals, [[0, 0, 1]] * 3)
    np.testing.assert_array_equal(primitive.uvs, np.zeros((3, 2)))
    assert primitive.colors is None


def test_normalised_and_sparse_accessors(tmp_path):
    file = Gltf()
    color = file.accessor([[255, 0, 51, 255]] * 3, "uint8", normalized=True)
    uv = file.accessor([[0, 0], [0, 0], [0, 0]])
    file.root["accessors"][uv]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": file.view(np.array([1], "<u2").tobytes()), "componentType": 5123},
        "values": {"bufferView": file.view(np.array([[0.5, 2.0]], "<f4").tobytes())},
    }
    triangle = file.triangle(COLOR_0=color, TEXCOORD_0=uv)
    primitive = load_scene(
        file.save(tmp_path / "a.gltf", meshes=[{"primitives": [triangle]}])
    ).primitives[0]
    np.testing.assert_allclose(primitive.colors, [[1, 0, 0.2, 1]] * 3, atol=1e-6)
    np.testing.assert_array_equal(primitive.uvs, [[0, 0], [0.5, 2], [0, 0]])


@pytest.mark.parametrize(
    ("mode", "expected"), [(5, [[0, 1, 2], [2, 1, 3]]), (6, [[0, 1, 2], [0, 2, 3]])]
)
def test_strips_and_fans_become_triangles(tmp_path, mode, expected):
    file = Gltf()
    attributes = {
        "POSITION": file.accessor(np.eye(4)[:, :3]),
        "NORMAL": file.accessor([[0, 0, 1]] * 4),
    }
    primitive = {"attributes": attributes, "mode": mode}
    scene = load_scene(file.save(tmp_path / "a.gltf", meshes=[{"primitives": [primitive]}]))
    np.testing.assert_array_equal(scene.primitives[0].indices, expected)


def test_nodes_may_come_in_any_order_and_have_matrices(tmp_path):
    file = Gltf()
    matrix = np.eye(4)
    matrix[:3, 3] = [1, 2, 3]
    nodes = [
        {"mesh": 0, "translation": [10, 0, 0]},
        {"children": [0], "matrix": matrix.T.ravel().tolist()},
        {"mesh": 0, "translation": [99, 0, 0]},
    ]
    path = file.save(
        tmp_path / "a.gltf",
        meshes=[{"primitives": [file.triangle()]}],
        nodes=nodes,
        scenes=[{"nodes": [1]}],
    )
    scene = load_scene(path)
    assert [node.parent for node in scene.nodes] == [-1, 0]
    np.testing.assert_allclose(scene.world_from_node(0.0)[1, :3, 3], [11, 2, 3])


def test_materials_and_textures(tmp_path):
    file = Gltf()
    view = file.view(png([[[255, 0, 0, 128]]]))
    material = {
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0},
            "metallicFactor": 0.25,
            "baseColorFactor": [1, 1, 1, 0.5],
        },
        "alphaMode": "MASK",
        "alphaCutoff": 0.3,
        "doubleSided": True,
        "emissiveFactor": [1, 0.5, 0],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}},
    }
    triangle = file.triangle() | {"material": 0}
    scene = load_scene(
        file.save(
            tmp_path / "a.gltf",
            meshes=[{"primitives": [triangle]}],
            materials=[material],
            textures=[{"source": 0, "sampler": 0}],
            samplers=[{"wrapS": 33071}],
            images=[{"bufferView": view, "mimeType": "image/png"}],
        )
    )
    read = scene.materials[scene.primitives[0].material]
    assert (read.alpha_mode, read.alpha_cutoff, read.double_sided, read.metallic) == (
        "MASK",
        0.3,
        True,
        0.25,
    )
    assert read.emissive == (4.0, 2.0, 0.0)
    image = scene.images[read.base_color_image]
    np.testing.assert_array_equal(image.pixels, [[[255, 0, 0, 128]]])
    assert image.wrap == ("clamp_to_edge", "repeat")
    assert scene.warnings == ()


def test_what_is_not_supported_is_named_in_one_warning(tmp_path):
    file = Gltf()
    triangle = file.triangle()
    triangle["targets"] = [{}]
    compressed = {
        "attributes": {"POSITION": len(file.root["accessors"])},
        "extensions": {"KHR_draco_mesh_compression": {}},
    }
    file.root["accessors"].append({"componentType": 5126, "count": 3, "type": "VEC3"})
    path = file.save(
        tmp_path / "a.gltf",
        meshes=[{"primitives": [triangle, compressed]}],
        cameras=[{}],
        materials=[
            {"extensions": {"KHR_materials_clearcoat": {}}, "occlusionTexture": {"index": 0}}
        ],
    )
    (warning,) = load_scene(path).warnings
    for name in (
        "morph targets",
        "KHR_draco_mesh_compression",
        "cameras",
        "KHR_materials_clearcoat",
        "occlusion",
    ):
        assert name in warning


def test_lamps_are_where_their_nodes_are(tmp_path):
    file = Gltf()
    lights = [{"type": "point", "intensity": 4.0, "color": [1, 0.5, 0]}, {"type": "area"}]
    nodes = [
        {"mesh": 0, "children": [1, 2], "translation": [0, 1, 0]},
        {"translation": [2, 0, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"extensions": {"KHR_lights_punctual": {"light": 1}}},
    ]
    path = file.save(
        tmp_path / "a.gltf",
        meshes=[{"primitives": [file.triangle()]}],
        nodes=nodes,
        extensions={"KHR_lights_punctual": {"lights": lights}},
    )
    scene = load_scene(path)
    (lamp,) = scene.environment.point_lights
    assert (lamp.position, lamp.intensity) == ((2.0, 1.0, 0.0), (4.0, 2.0, 0.0))
    assert "area lights" in scene.warnings[0]


def test_animations_move_children_and_loop(tmp_path):
    file = Gltf()
    times, moves = file.accessor([0, 2]), file.accessor([[0, 0, 0], [4, 0, 0]])
    path = file.save(
        tmp_path / "a.gltf",
        meshes=[{"primitives": [file.triangle()]}],
        nodes=[{"children": [1]}, {"mesh": 0, "translation": [0, 1, 0]}],
        animations=[
            {
                "samplers": [{"input": times, "output": moves}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            }
        ],
    )
    scene = load_scene(path)
    assert [node.moving for node in scene.nodes] == [True, True]
    np.testing.assert_allclose(scene.world_from_node(0.5)[1, :3, 3], [1, 1, 0])
    np.testing.assert_allclose(scene.world_from_node(5.5)[1, :3, 3], [3, 1, 0])


def test_cubic_spline_is_exact_for_a_cubic():
    # x = t³ with its own derivative as tangents.
    times = np.array([0.0, 1.0, 3.0])
    keys = np.stack([np.stack([3 * times**2, times**3, 3 * times**2], 1)] * 3, axis=2)
    channel = Channel(0, "translation", times, keys, "CUBICSPLINE")
    for t in (0.25, 1.0, 2.5):
        np.testing.assert_allclose(sample(channel, t), [t**3] * 3)


def test_steps_hold_until_the_next_key():
    channel = Channel(0, "scale", np.array([0.0, 1.0, 2.0]), np.eye(3), "STEP")
    np.testing.assert_array_equal(sample(channel, 0.999), [1, 0, 0])
    np.testing.assert_array_equal(sample(channel, 1.0), [0, 1, 0])
    np.testing.assert_array_equal(sample(channel, 7.0), [0, 0, 1])


@given(st.floats(0, 1), st.floats(-3.1, 3.1))
def test_rotations_turn_at_an_even_rate(t, angle):
    keys = np.stack([axis_angle([0, 1, 0], 0.0), axis_angle([0, 1, 0], angle)])
    value = sample(Channel(0, "rotation", np.array([0.0, 1.0]), keys, "LINEAR"), t)
    np.testing.assert_allclose(value, normalize(axis_angle([0, 1, 0], angle * t)), atol=1e-9)
