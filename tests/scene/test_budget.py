"""A scene file costs what it may cost, and no small file can ask for all memory."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
from bisect import bisect_left
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as PillowImage

from tests.support.scene_files import Gltf, png
from tests.support.waiting import SESSION_S
from vrcomfort.errors import InputError
from vrcomfort.scene.gltf.budget import SceneBudget
from vrcomfort.scene.gltf.file import GltfFile
from vrcomfort.scene.load import load_scene

MIB = 2**20
SMALL_FILE_MAY_TAKE_MIB = 1200

PEAK = """
import sys
from pathlib import Path
from vrcomfort.errors import InputError
from vrcomfort.scene.load import load_scene
def peak_kib():  # of this program alone: ru_maxrss begins with that of the process it came from
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM:"))
before = peak_kib()
try:
    load_scene(sys.argv[1])
    print("loaded")
except InputError as error:
    print(error)
print((peak_kib() - before) // 1024)
"""


def peak_mib(path: Path) -> tuple[str, int]:
    """Return what loading says in a process of its own, and the memory that it took at most."""
    run = subprocess.run(
        [sys.executable, "-c", PEAK, str(path)],
        capture_output=True, text=True, check=True, timeout=SESSION_S,
    )  # fmt: skip
    said, peak = run.stdout.splitlines()[-2:]
    return said, int(peak)


def zeros(file: Gltf, count: int, kind: str = "SCALAR", component: int = 5126, **more) -> int:
    file.root["accessors"].append(
        {"count": count, "type": kind, "componentType": component, **more}
    )
    return len(file.root["accessors"]) - 1


def key_frames_of_nothing(path: Path) -> None:
    """Animations whose key frames have no data, each read many times."""
    file = Gltf()
    triangle = file.triangle()
    times, values = zeros(file, 2**24), zeros(file, 2**24, "VEC3")
    channel = {"sampler": 0, "target": {"node": 0, "path": "translation"}}
    animation = {"samplers": [{"input": times, "output": values}], "channels": [channel]}
    file.save(path, meshes=[{"primitives": [triangle]}], animations=[animation] * 8)


def vertices_of_nothing(path: Path) -> None:
    file = Gltf()
    triangle = file.triangle()
    uvs = zeros(file, 2**24, "VEC4", 5121, normalized=True)
    triangle["attributes"]["COLOR_0"] = uvs
    file.save(path, meshes=[{"primitives": [triangle] * 9}])


def sparse_nothing(path: Path) -> None:
    file = Gltf()
    triangle = file.triangle()
    one = file.view(b"\0\0\0\0" * 4)
    sparse = {
        "count": 1,
        "indices": {"bufferView": one, "componentType": 5125},
        "values": {"bufferView": one},
    }
    triangle["indices"] = zeros(file, 2**40, component=5125, sparse=sparse)
    file.save(path, meshes=[{"primitives": [triangle]}])


def indices_of_nothing(path: Path) -> None:
    """Corners without normals, which become vertices of their own."""
    file = Gltf()
    triangle = file.triangle()
    triangle["indices"] = zeros(file, 3 * (2**24 // 3), component=5121)
    file.save(path, meshes=[{"primitives": [triangle] * 30}])


def one_picture_often(path: Path) -> None:
    """A picture that is small in the file, large in memory, and decoded many times."""
    file = Gltf()
    out = io.BytesIO()
    PillowImage.new("1", (8192, 8192)).save(out, "PNG")
    view = file.view(out.getvalue())
    images = [{"bufferView": view}] * 40
    textures = [{"source": index} for index in range(40)]
    materials = [
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": index}}} for index in range(40)
    ]
    meshes = [{"primitives": [file.triangle() | {"material": 0}]}]
    file.save(path, meshes=meshes, images=images, textures=textures, materials=materials)


def huge_picture(path: Path) -> None:
    file = Gltf()
    out = io.BytesIO()
    PillowImage.new("1", (13_000, 13_000)).save(out, "PNG")
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    file.save(
        path,
        meshes=[{"primitives": [file.triangle() | {"material": 0}]}],
        images=[{"bufferView": file.view(out.getvalue()), "name": "sky"}],
        textures=[{"source": 0}],
        materials=[material],
    )


def strided(path: Path) -> None:
    """Vertices that overlap in the buffer, and are read for each of many primitives."""
    file = Gltf()
    view = file.view(bytes(400_012), byteStride=4)
    file.root["accessors"].append(
        {"bufferView": view, "count": 100_000, "type": "VEC3", "componentType": 5126}
    )
    triangle = {"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1}
    file.accessor([0, 1, 2], "uint8")
    file.save(path, meshes=[{"primitives": [triangle] * 20_000}])


def many_draws(path: Path) -> None:
    """A mesh of a thousand primitives at each of ten thousand nodes."""
    file = Gltf()
    mesh = {"primitives": [file.triangle()] * 1100}
    nodes = [{"mesh": 0}] * 1000
    file.save(path, meshes=[mesh], nodes=nodes, scenes=[{"nodes": list(range(1000))}])


def many_items(path: Path) -> None:
    file = Gltf()
    file.root["materials"] = [{}] * 1_100_000
    file.save(path, meshes=[{"primitives": [file.triangle()]}])


HEAVY = {
    key_frames_of_nothing: "animation .* numbers without data",
    vertices_of_nothing: "mesh .* numbers",
    sparse_nothing: "mesh .* numbers",
    indices_of_nothing: "mesh .* numbers",
    one_picture_often: "image .* pixels of images",
    huge_picture: "image 'sky' is 13000x13000",
    strided: "mesh .* numbers",
    many_draws: "1100000 primitives to draw",
    many_items: "parts",
}
LARGE = {one_picture_often, strided, many_items}
"""Those whose files take a second to be made or read, which is done once, for their memory."""


@pytest.mark.parametrize(
    "build", [b for b in HEAVY if b not in LARGE], ids=lambda build: build.__name__
)
def test_a_small_file_that_asks_for_much_memory_is_refused(tmp_path, build):
    path = tmp_path / "scene.gltf"
    build(path)
    with pytest.raises(InputError, match=HEAVY[build]) as caught:
        load_scene(path)
    assert caught.value.file == path


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
@pytest.mark.parametrize("build", HEAVY, ids=lambda build: build.__name__)
def test_a_refused_file_has_not_taken_much_memory(tmp_path, build):
    path = tmp_path / "scene.gltf"
    build(path)
    said, peak = peak_mib(path)
    assert re.search(f"scene.gltf: .*{HEAVY[build]}", said)
    assert peak < SMALL_FILE_MAY_TAKE_MIB, f"{peak} MiB for {path.stat().st_size} bytes"


def test_a_buffer_that_is_named_often_is_read_once(tmp_path):
    (tmp_path / "data.bin").write_bytes(bytes(4 * MIB))
    file = Gltf()
    triangle = file.triangle()
    file.root["buffers"] += [{"uri": "data.bin", "byteLength": 4 * MIB}] * 200
    path = file.save(tmp_path / "scene.gltf", meshes=[{"primitives": [triangle]}])
    load_scene(path, budget=SceneBudget(file_bytes=5 * MIB))
    with pytest.raises(InputError, match=r"buffer 1 brings the scene to .* bytes"):
        load_scene(path, budget=SceneBudget(file_bytes=4 * MIB))


@pytest.mark.parametrize(
    ("budget", "match"),
    [
        ({"nodes": 0}, "1 nodes, and 0 is the most"),
        ({"draws": 0}, "primitives to draw"),
        ({"numbers": 8}, "mesh 0 brings the scene to 9 numbers"),
        ({"items": 3}, "parts"),
        ({"json_bytes": 99}, "bytes of JSON"),
        ({"file_bytes": 99}, "bytes, and 99 is the most"),
        ({"image_pixels": 3}, "is 2x2, and 3 pixels are the most"),
        ({"pixels": 3}, "4 pixels of images"),
    ],
)
def test_every_limit_is_one_of_the_budget(tmp_path, budget, match):
    file = Gltf()
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    path = file.save(
        tmp_path / "scene.gltf",
        meshes=[{"primitives": [file.triangle() | {"material": 0}]}],
        materials=[material],
        textures=[{"source": 0}],
        images=[{"bufferView": file.view(png(np.zeros((2, 2, 3))))}],
    )
    load_scene(path)
    with pytest.raises(InputError, match=match):
        load_scene(path, budget=SceneBudget(**budget))


def test_strips_and_fans_cost_the_indices_of_the_triangles_that_they_become(tmp_path):
    def fewest_numbers(mode: int) -> int:
        file = Gltf()
        mesh = {"primitives": [file.triangle() | {"mode": mode}]}
        path = file.save(tmp_path / "a.gltf", meshes=[mesh])
        return bisect_left(range(1000), True, key=lambda numbers: fits(path, numbers))

    triangles, strip, fan = map(fewest_numbers, (4, 5, 6))
    assert (strip - triangles, fan - triangles) == (9, 9)


def fits(path: Path, numbers: int) -> bool:
    try:
        load_scene(path, budget=SceneBudget(numbers=numbers))
    except InputError:
        return False
    return True


def grid(path: Path, count: int) -> Path:
    """A file of so many nodes, each with a mesh of one primitive, half of them in a chain."""
    file = Gltf()
    mesh = {"primitives": [file.triangle()]}
    nodes = [{"mesh": index} for index in range(count)]
    for index in range(count // 2):
        nodes[index]["children"] = [index + 1]
    roots = [0, *range(count // 2 + 1, count)]
    return file.save(path, meshes=[mesh] * count, nodes=nodes, scenes=[{"nodes": roots}])


def test_the_work_of_loading_is_in_proportion_to_nodes(tmp_path, monkeypatch):
    """Counted are the list elements that looking up items could copy."""
    counts = []
    plain = GltfFile.items

    def items(file, key):
        found = plain(file, key)
        counts[-1] += 1 if found is file.root.get(key, found) else len(found)
        return found

    monkeypatch.setattr(GltfFile, "items", items)
    for count in (200, 800):
        counts.append(0)
        scene = load_scene(grid(tmp_path / f"{count}.gltf", count))
        assert len(scene.nodes) == count
    assert counts[1] < 4.5 * counts[0]


@pytest.mark.slow
def test_thirty_thousand_nodes_and_primitives_load(tmp_path):
    scene = load_scene(grid(tmp_path / "scene.gltf", 30_000))
    assert len(scene.nodes) == len(scene.primitives) == 30_000


AWAY = ["../data.bin", "a/../../data.bin", "%2e%2e/data.bin", "/etc/hostname", "//host/data.bin",
        "file:///etc/hostname", "http://localhost/data.bin", "C:\\data.bin", "C:data.bin",
        "\\\\host\\share\\data.bin", "link/data.bin", "link.bin", "a\0b"]  # fmt: skip


@pytest.mark.parametrize("uri", AWAY)
@pytest.mark.parametrize("kind", ["buffer", "image"])
def test_a_scene_reads_nothing_outside_of_its_folder(tmp_path, uri, kind):
    folder = tmp_path / "scene"
    folder.mkdir()
    (tmp_path / "data.bin").write_bytes(bytes(36))
    (folder / "link").symlink_to(tmp_path, target_is_directory=True)
    (folder / "link.bin").symlink_to(tmp_path / "data.bin")
    file = Gltf()
    triangle = file.triangle() | {"material": 0}
    root = {"materials": [{}]}
    if kind == "buffer":
        file.root["buffers"][0]["uri"] = uri
    else:
        root = {
            "materials": [{"emissiveTexture": {"index": 0}}],
            "textures": [{"source": 0}],
            "images": [{"uri": uri}],
        }
    path = file.save(folder / "scene.gltf", meshes=[{"primitives": [triangle]}], **root)
    with pytest.raises(InputError, match=f"^.*{kind} 0 is .* not in the scene's folder"):
        load_scene(path)


@pytest.mark.parametrize("uri", ["data.bin", "parts/data.bin", "parts/../data.bin", "a%20b.bin"])
def test_a_scene_reads_what_is_in_its_folder(tmp_path, uri, monkeypatch):
    file = Gltf()
    triangle = file.triangle()
    (tmp_path / "parts").mkdir()
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32).tobytes()
    for name in ("data.bin", "parts/data.bin", "a b.bin"):
        (tmp_path / name).write_bytes(positions)
    file.root["buffers"][0]["uri"] = uri
    file.save(tmp_path / "scene.gltf", meshes=[{"primitives": [triangle]}])
    monkeypatch.chdir(tmp_path)
    assert len(load_scene("scene.gltf").primitives) == 1


@pytest.mark.parametrize("name", ["KHR_texture_basisu", "EXT_of_tomorrow"])
def test_an_unknown_extension_that_the_file_requires_is_refused(tmp_path, name):
    file = Gltf()
    file.root["extensionsRequired"] = [name]
    path = file.save(tmp_path / "scene.gltf", meshes=[{"primitives": [file.triangle()]}])
    with pytest.raises(InputError, match=f"needs {name}, which cannot be read"):
        load_scene(path)


def test_an_unknown_extension_that_the_file_requires_is_told_with_its_place(tmp_path):
    file = Gltf()
    file.root["extensionsRequired"] = ["EXT_meshopt_compression"]
    packed = {**file.triangle(), "extensions": {"EXT_meshopt_compression": {}}}
    meshes = [{"primitives": [file.triangle()]}, {"name": "bush", "primitives": [packed]}]
    path = file.save(tmp_path / "scene.gltf", meshes=meshes)
    place = r"\(first in meshes\[1\] \('bush'\)\.primitives\[0\]\)"
    with pytest.raises(InputError, match=f"{place}, which cannot be read; .* mesh compression"):
        load_scene(path)


def test_a_fault_deep_in_a_long_list_is_told_with_its_place(tmp_path):
    path = grid(tmp_path / "scene.gltf", 9000)
    root = json.loads(path.read_text())
    root["nodes"][8765] = {"name": "here", "scale": [1, 1]}
    path.write_text(json.dumps(root))
    with pytest.raises(InputError, match=r"nodes\[8765\] \('here'\)\.scale has 2 numbers"):
        load_scene(path)
