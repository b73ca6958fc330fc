"""No glTF file ends in a traceback: it loads whole, or is refused in one sentence."""

from __future__ import annotations

import copy
import json
import warnings
from collections.abc import Iterator
from itertools import islice, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.scene_files import Gltf, png
from vrcomfort.errors import InputError
from vrcomfort.gpu import shaders
from vrcomfort.render import lighting
from vrcomfort.render.draw_list import DrawList
from vrcomfort.render.materials import ImageArrays, batch_key, material_blocks
from vrcomfort.render.scene_buffers import bending_bytes, second_uv_bytes, vertex_bytes
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene

TURN = [0.0, 0.6, 0.0, 0.8]
WORSE = (
    None, True, -1, 0, 1, 3, 10**6, 10**18, 0.5, 1e39, float("nan"), float("-inf"), "", "FOO",
    "data:,FOO", [], {}, [1.0], [0, 0, 0, 0], [float("nan")] * 3, {"index": 9},
)  # fmt: skip


def whole_file() -> dict[str, Any]:
    """Return the JSON of a small file that has one of everything that is read."""
    file = Gltf()
    normal = file.accessor([[0, 0, 1]] * 3)
    uv = file.accessor([[0, 0], [1, 0], [0, 1]])
    color = file.accessor([[255, 255, 0, 255]] * 3, "uint8", normalized=True)
    joints = file.accessor([[0, 1, 0, 0]] * 3, "uint8")
    weights = file.accessor([[0.5, 0.5, 0, 0]] * 3)
    first = file.triangle(
        NORMAL=normal,
        TEXCOORD_0=uv,
        TEXCOORD_1=uv,
        COLOR_0=color,
        JOINTS_0=joints,
        WEIGHTS_0=weights,
    )
    first |= {"material": 0, "indices": file.accessor([0, 1, 2], "uint16")}
    strip = file.triangle() | {"mode": 5, "indices": file.accessor([2, 1, 0], "uint8")}
    moved = {
        "count": 1,
        "indices": {"bufferView": file.view(bytes([1])), "componentType": 5121},
        "values": {"bufferView": file.view(np.array([2, 0, 0], "<f4").tobytes())},
    }
    sparse = {**file.root["accessors"][first["attributes"]["POSITION"]], "sparse": moved}
    file.root["accessors"].append(sparse)
    fan = {"mode": 6, "attributes": {"POSITION": len(file.root["accessors"]) - 1}}
    times = file.accessor([0.0, 1.0])
    cubic = file.accessor(np.tile([1.0, 2.0, 3.0], (6, 1)))
    image = {"bufferView": file.view(png(np.zeros((2, 2, 3)))), "mimeType": "image/png"}
    surface = {
        "baseColorFactor": [1, 0.5, 0.2, 1], "baseColorTexture": {"index": 0},
        "metallicFactor": 0.1, "metallicRoughnessTexture": {"index": 0, "texCoord": 1},
    }  # fmt: skip
    glow = {"KHR_materials_emissive_strength": {"emissiveStrength": 2.0}}
    lamp = {"type": "point", "intensity": 3.0, "color": [1, 1, 0.5]}
    cone = {"innerConeAngle": 0.2, "outerConeAngle": 0.5}
    spot = {"type": "spot", "intensity": 2.0, "range": 4.0, "spot": cone}
    moved_uv = {"offset": [0.5, 0], "rotation": 0.3, "scale": [2, 1], "texCoord": 1}
    bind = file.accessor(np.tile(np.eye(4).ravel(), (2, 1)))
    return file.root | {
        "scene": 0,
        "scenes": [{"nodes": [0, 2, 4, 5]}],
        "nodes": [
            {"name": "turned", "mesh": 0, "rotation": TURN, "scale": [1, 2, 1], "children": [1]},
            {"mesh": 1, "translation": [0, 1, 0]},
            {"name": "lamp", "matrix": np.eye(4).ravel().tolist(),
             "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"name": "far", "mesh": 1},
            {"name": "spot", "extensions": {"KHR_lights_punctual": {"light": 1}}},
            {"name": "bent", "mesh": 2, "skin": 0},
        ],
        "skins": [{"name": "rig", "joints": [0, 1], "inverseBindMatrices": bind}],
        "meshes": [
            {"name": "first", "primitives": [first]},
            {"primitives": [strip, fan]},
            {"name": "bent", "primitives": [first]},
        ],
        "materials": [{
            "name": "painted", "pbrMetallicRoughness": surface, "alphaMode": "MASK",
            "normalTexture": {"index": 0, "scale": 0.5,
                              "extensions": {"KHR_texture_transform": moved_uv}},
            "emissiveFactor": [0, 0, 1],
            "alphaCutoff": 0.3, "doubleSided": True, "extensions": glow,
        }],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648}],
        "images": [image],
        "animations": [{
            "name": "spin",
            "channels": [
                {"sampler": 0, "target": {"node": 0, "path": "rotation"}},
                {"sampler": 1, "target": {"node": 1, "path": "translation"}},
            ],
            "samplers": [
                {"input": times, "output": file.accessor([TURN, [0.0, 0.0, 0.0, 1.0]])},
                {"input": times, "output": cubic, "interpolation": "CUBICSPLINE"},
            ],
        }],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [lamp, spot, {"type": "directional"}]}},
    }  # fmt: skip


WHOLE = whole_file()


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield where every value of the JSON is."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in items:
        yield (*path, key)
        if isinstance(item, dict | list):
            yield from places(item, (*path, key))


PLACES = list(places(WHOLE))


def changed(root: dict[str, Any], place: tuple[Any, ...], new: Any = None, *, gone: bool) -> None:
    """Put something else into a place of the JSON, if it is still there."""
    holder: Any = root
    try:
        for key in place[:-1]:
            holder = holder[key]
        holder[place[-1]]
    except (KeyError, IndexError, TypeError):
        return
    if isinstance(holder, str):
        return
    if gone:
        del holder[place[-1]]
    else:
        holder[place[-1]] = new


def loads_whole_or_is_refused(path: Path, content: bytes) -> bool:
    """Return whether a file loads; then everything in it can be drawn."""
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            scene = load_scene(path)
        except InputError as error:
            assert_says_what_is_wrong(error, path)
            return False
        assert_can_be_drawn(scene)
    return True


def assert_says_what_is_wrong(error: InputError, path: Path) -> None:
    assert error.file == path
    assert "\n" not in str(error)
    assert "Error" not in str(error), "how Python fell is of no use to anybody"


def assert_can_be_drawn(scene: Scene) -> None:
    images = ImageArrays.of(scene)
    blocks = material_blocks(scene, images)
    assert all(np.isfinite(blocks[name]).all() for name in ("base_color", "uv_u", "uv_v"))
    DrawList.of(scene, images)
    for number, material in enumerate(scene.materials):
        batch_key(scene, images, number, vertex_colors=True, skinned=False, mirrored=False)
        for name in ("base_color", "normal", "metallic_roughness", "emissive"):
            index = getattr(material, f"{name}_image")
            assert index is None or 0 <= index < len(scene.images)
    for primitive in scene.primitives:
        assert 0 <= primitive.material < len(scene.materials)
        assert primitive.indices.max() < len(primitive.positions)
        assert np.isfinite(primitive.bounds).all()
    vertex_bytes(scene.primitives)
    second_uv_bytes(scene.primitives)
    bending_bytes(scene.primitives)
    for time_s in (0.0, 0.3, 1.0):
        assert np.isfinite(scene.world_from_node(time_s)).all()
        for index, node in enumerate(scene.nodes):
            for item in node.mesh:
                assert np.isfinite(scene.positions(index, item, time_s)).all()
    assert np.isfinite([(*lamp.intensity, lamp.range_m) for lamp in
                        scene.environment.point_lights]).all()  # fmt: skip
    layout = shaders.block_dtype("light.glsl", "Light")
    block = np.zeros(1, layout)
    lighting.Light(scene, block)
    assert all(np.isfinite(block[name]).all() for name in layout.names or ())


def test_the_whole_file_loads(tmp_path: Path) -> None:
    assert loads_whole_or_is_refused(tmp_path / "a.gltf", json.dumps(WHOLE).encode())


@pytest.mark.parametrize("every", [19, pytest.param(1, marks=pytest.mark.slow)])
def test_one_wrong_value_anywhere_is_no_traceback(tmp_path: Path, every: int) -> None:
    loaded, refused, wrong = 0, 0, []
    for place, new in islice(product(PLACES, (*WORSE, "gone")), 0, None, every):
        root = copy.deepcopy(WHOLE)
        changed(root, place, new, gone=new == "gone")
        try:
            fine = loads_whole_or_is_refused(tmp_path / "a.gltf", json.dumps(root).encode())
        except Exception as error:  # of any kind: it is what this looks for
            wrong.append(f"{place} = {new!r}: {type(error).__name__}: {error}")
        else:
            loaded, refused = loaded + fine, refused + (not fine)
    assert wrong == []
    assert min(loaded, refused) > 500 / every  # neither everything nor nothing


@given(st.data())
def test_two_wrong_values_are_no_traceback(tmp_path_factory: Any, data: st.DataObject) -> None:
    root = copy.deepcopy(WHOLE)
    for _ in range(2):
        place, new = data.draw(st.sampled_from(PLACES)), data.draw(st.sampled_from(WORSE))
        changed(root, place, copy.deepcopy(new), gone=data.draw(st.booleans()))
    path = tmp_path_factory.getbasetemp() / "two.gltf"
    loads_whole_or_is_refused(path, json.dumps(root).encode())


@given(st.integers(0, 10**6), st.binary(min_size=1, max_size=8))
def test_wrong_bytes_in_a_buffer_are_no_traceback(
    tmp_path_factory: Any, at: int, new: bytes
) -> None:
    import base64

    root = copy.deepcopy(WHOLE)
    buffer = root["buffers"][at % len(root["buffers"])]
    head, _, text = buffer["uri"].partition(",")
    content = bytearray(base64.b64decode(text))
    start = at // 64 % len(content)
    content[start : start + len(new)] = new
    buffer["uri"] = f"{head},{base64.b64encode(content[: buffer['byteLength']]).decode()}"
    path = tmp_path_factory.getbasetemp() / "bytes.gltf"
    loads_whole_or_is_refused(path, json.dumps(root).encode())
