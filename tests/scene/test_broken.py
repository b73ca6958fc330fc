"""Broken scene files are refused in one sentence that says why."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
import trimesh

from tests.support.scene_files import Gltf
from vrcomfort.errors import InputError
from vrcomfort.scene.load import load_scene


def truncated(path):
    trimesh.Scene([trimesh.creation.box()]).export(path)
    path.write_bytes(path.read_bytes()[:-40])


def no_json_chunk(path):
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20, 0, 0x004E4942))


def old_version(path):
    path.write_text(json.dumps({"asset": {"version": "1.0"}}))


def old_container(path):
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 1, 24, 2, 0) + b"{}  ")


def not_gltf(path):
    path.write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0")


def two_parents(path):
    file = Gltf()
    file.save(
        path, meshes=[{"primitives": [file.triangle()]}], nodes=[{"mesh": 0, "children": [0]}]
    )


def short_buffer(path):
    file = Gltf()
    triangle = file.triangle()
    file.root["accessors"][0]["count"] = 4
    file.save(path, meshes=[{"primitives": [triangle]}])


def missing_buffer_file(path):
    file = Gltf()
    triangle = file.triangle()
    file.root["buffers"][0]["uri"] = "gone.bin"
    file.save(path, meshes=[{"primitives": [triangle]}])


def index_out_of_range(path):
    file = Gltf()
    triangle = file.triangle() | {"indices": file.accessor([0, 1, 9], "uint16")}
    file.save(path, meshes=[{"primitives": [triangle]}])


def not_a_number(path):
    file = Gltf()
    triangle = {"attributes": {"POSITION": file.accessor([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]])}}
    file.save(path, meshes=[{"primitives": [triangle]}])


def bad_image(path):
    file = Gltf()
    view = file.view(b"not a picture")
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    file.save(
        path,
        meshes=[{"primitives": [file.triangle()]}],
        materials=[material],
        textures=[{"source": 0}],
        images=[{"bufferView": view}],
    )


def nothing_to_draw(path):
    file = Gltf()
    file.save(path, meshes=[{"primitives": [file.triangle() | {"mode": 1}]}])


def missing_mesh(path):
    file = Gltf()
    file.save(path, meshes=[{"primitives": [file.triangle()]}], nodes=[{"mesh": 3}])


def missing_child(path):
    file = Gltf()
    file.save(
        path, meshes=[{"primitives": [file.triangle()]}], nodes=[{"mesh": 0, "children": [7]}]
    )


def compressed_geometry(path):
    file = Gltf()
    file.root["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    file.save(path, meshes=[{"primitives": [file.triangle()]}])


def surfaces(path, **material):
    file = Gltf()
    triangle = file.triangle() | {"material": 0}
    file.save(path, meshes=[{"primitives": [triangle]}], materials=[{"name": "wall"} | material])


def missing_material(path):
    file = Gltf()
    file.save(path, meshes=[{"primitives": [file.triangle() | {"material": 3}]}])


def unknown_alpha_mode(path):
    surfaces(path, alphaMode="FOO")


def two_colours(path):
    surfaces(path, pbrMetallicRoughness={"baseColorFactor": [1, 2]})


def colour_in_words(path):
    surfaces(path, pbrMetallicRoughness={"baseColorFactor": "red"})


def part_of_a_triangle(path):
    file = Gltf()
    triangle = file.triangle() | {"indices": file.accessor([0, 1], "uint16")}
    file.save(path, meshes=[{"name": "roof", "primitives": [triangle]}])


def nested_deep(path):
    path.write_text("[" * 100_000 + "]" * 100_000)


def moved(path, **node):
    file = Gltf()
    node = {"name": "lid", "mesh": 0} | node
    file.save(path, meshes=[{"primitives": [file.triangle()]}], nodes=[node])


def moved_nowhere(path):
    moved(path, translation=[0, float("nan"), 0])


def turned_by_nothing(path):
    moved(path, rotation=[0, 0, 0, 0])


def scaled_out_of_all_bounds(path):
    file = Gltf()
    nodes = [{"scale": [1e9, 1, 1], "children": [1]}, {"name": "in", "scale": [9, 1, 1], "mesh": 0}]
    file.save(path, meshes=[{"primitives": [file.triangle()]}], nodes=nodes)


def animated(path, turns):
    file = Gltf()
    meshes = [{"primitives": [file.triangle()]}]
    sampler = {"input": file.accessor([0.0, 1.0]), "output": file.accessor(turns)}
    channel = {"sampler": 0, "target": {"node": 0, "path": "rotation"}}
    spin = {"name": "spin", "channels": [channel], "samplers": [sampler]}
    file.save(path, meshes=meshes, animations=[spin])


def keys_that_are_no_numbers(path):
    animated(path, [[0, 0, 0, 1], [0, 0, np.nan, 1]])


def keys_without_a_turn(path):
    animated(path, [[0, 0, 0, 1], [0, 0, 0, 0]])


def texture_of_a_device(path):
    surfaces(path, normalTexture={"index": 0})
    root = json.loads(path.read_text())
    path.write_text(
        json.dumps(root | {"textures": [{"source": 0}], "images": [{"uri": "/dev/zero"}]})
    )


BROKEN = {
    missing_material: r"meshes\[0\].primitives\[0\].material refers to number 3 of its materials",
    unknown_alpha_mode: r"materials\[0\] \('wall'\).alphaMode should be 'OPAQUE', 'MASK'",
    two_colours: r"baseColorFactor has 2 numbers, but needs 4; export",
    colour_in_words: "baseColorFactor should be a list",
    part_of_a_triangle: "mesh 'roof' has 2 corners, which are no whole triangles",
    nested_deep: "nested too deep",
    moved_nowhere: r"nodes\[0\] \('lid'\).translation\[1\] should be a finite number",
    turned_by_nothing: r"nodes\[0\] \('lid'\).rotation has length 0",
    scaled_out_of_all_bounds: "node 'in' is scaled or moved by more than 1e",
    keys_that_are_no_numbers: "animation 'spin' has a number in accessor 2 that is not finite",
    keys_without_a_turn: "animation 'spin' has a rotation of length 0",
    texture_of_a_device: "image 0 is '/dev/zero', which is not in the scene's folder",
    missing_mesh: "number 3 of its meshes, but has 1",
    missing_child: "number 7 of its nodes, but has 1",
    compressed_geometry: "needs KHR_draco_mesh_compression",
    truncated: "cut off",
    no_json_chunk: "JSON chunk",
    old_version: "not glTF 2.0",
    old_container: "not glTF 2.0",
    not_gltf: "not glTF",
    two_parents: "two parents",
    short_buffer: "beyond its buffer",
    missing_buffer_file: "gone.bin",
    index_out_of_range: "out of range",
    not_a_number: "not finite",
    bad_image: "cannot be decoded",
    nothing_to_draw: "no triangles",
}


@pytest.mark.parametrize("break_it", BROKEN, ids=lambda make: make.__name__)
def test_broken_files_are_refused_with_the_reason(tmp_path, break_it):
    path = tmp_path / (
        "a.glb" if break_it in (truncated, no_json_chunk, old_container, not_gltf) else "a.gltf"
    )
    break_it(path)
    with pytest.raises(InputError, match=BROKEN[break_it]) as caught:
        load_scene(path)
    assert caught.value.file == path
    assert "\n" not in str(caught.value)


def test_unknown_names_list_what_there_is(tmp_path):
    with pytest.raises(InputError, match="mountain, temple"):
        load_scene("valley")
    with pytest.raises(InputError, match="no such scene file"):
        load_scene(tmp_path / "gone.glb")
