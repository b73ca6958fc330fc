"""Small scene files: one that has something of everything, and those made to hurt."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tests.support.scene_files import Gltf, png

HUGE = 10**9


def whole() -> dict[str, Any]:
    """Return the JSON of a file that has something of everything that is read."""
    file = Gltf()
    first = file.triangle(
        NORMAL=file.accessor([[0, 0, 1]] * 3), TEXCOORD_0=file.accessor([[0, 0], [1, 0], [0, 1]])
    )
    first |= {"material": 0, "indices": file.accessor([0, 1, 2], "uint16")}
    strip = file.triangle() | {"mode": 5, "indices": file.accessor([2, 1, 0], "uint8")}
    image = {"bufferView": file.view(png(np.zeros((2, 2, 3)))), "mimeType": "image/png"}
    times, turns = file.accessor([0.0, 1.0]), file.accessor([[0.0, 0.6, 0.0, 0.8]] * 2)
    surface = {"baseColorFactor": [1, 0.5, 0.2, 1], "baseColorTexture": {"index": 0}}
    lights = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 3.0}]}}
    return file.root | {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "a", "mesh": 0, "rotation": [0, 0.6, 0, 0.8], "children": [1, 2]},
            {"name": "b", "mesh": 1, "translation": [0, 1, 0]},
            {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "meshes": [{"primitives": [first]}, {"primitives": [strip]}],
        "materials": [{"name": "wall", "pbrMetallicRoughness": surface, "alphaMode": "MASK"}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33071}],
        "images": [image],
        "animations": [
            {
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}],
                "samplers": [{"input": times, "output": turns}],
            }
        ],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": lights,
    }


def glb(root: dict[str, Any]) -> bytes:
    """Return a file's binary form; its buffers stay where they are."""
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A)
    return head + text


def _scene(folder: Path, file: Gltf | None = None, **root: Any) -> Path:
    file = file or Gltf()
    mesh = {"meshes": [{"primitives": [file.triangle()]}]}
    return file.save(folder / "scene.gltf", **{**mesh, **root})


def _count(folder: Path, **more: Any) -> Path:
    """Have an accessor without data and with so many elements: zeros, by the format's rules."""
    file = Gltf()
    primitive = file.triangle()
    accessor = file.root["accessors"][0]
    accessor["count"] = HUGE
    if not more.get("bounded"):
        del accessor["bufferView"]
    return _scene(folder, file, meshes=[{"primitives": [primitive]}])


def _sparse(folder: Path) -> Path:
    file = Gltf()
    primitive = file.triangle()
    indices = {"bufferView": file.view(bytes([1])), "componentType": 5121}
    values = {"bufferView": file.view(bytes(12))}
    sparse = {"count": 1, "indices": indices, "values": values}
    accessor = {"componentType": 5126, "type": "VEC3", "count": HUGE, "sparse": sparse}
    file.root["accessors"][0] = accessor
    return _scene(folder, file, meshes=[{"primitives": [primitive]}])


def _keys(folder: Path) -> Path:
    file = Gltf()
    mesh = {"primitives": [file.triangle()]}
    empty = {"componentType": 5126, "count": HUGE}
    file.root["accessors"] += [empty | {"type": "SCALAR"}, empty | {"type": "VEC4"}]
    channel = {"sampler": 0, "target": {"node": 0, "path": "rotation"}}
    spin = {"channels": [channel], "samplers": [{"input": 1, "output": 2}]}
    return _scene(folder, file, meshes=[mesh], animations=[spin])


def _same_data(folder: Path) -> Path:
    """Draw the same megabyte ten thousand times."""
    file = Gltf()
    position = file.accessor(np.zeros((90_000, 3)))
    primitive = {"attributes": {"POSITION": position}}
    return _scene(folder, file, meshes=[{"primitives": [primitive] * 10_000}])


def _chain(folder: Path) -> Path:
    nodes: list[dict[str, Any]] = [{"children": [number + 1]} for number in range(99_999)]
    return _scene(folder, nodes=[*nodes, {"mesh": 0}])


def _many(folder: Path) -> Path:
    nodes = [{"mesh": number} for number in range(100_000)]
    file = Gltf()
    meshes = [{"primitives": [file.triangle()]}] * 100_000
    return _scene(folder, file, nodes=nodes, meshes=meshes, scenes=[{"nodes": [*range(100_000)]}])


def _circle(folder: Path) -> Path:
    return _scene(folder, nodes=[{"mesh": 0, "children": [1]}, {"children": [0]}])


def _nested(folder: Path) -> Path:
    path = folder / "scene.gltf"
    path.write_text('{"asset": ' + "[" * 1_000_000 + "]" * 1_000_000 + "}")
    return path


def _long_chunk(folder: Path) -> Path:
    path = folder / "scene.glb"
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 2**32 - 1, 2**32 - 16, 0x4E4F534A) + b"{}")
    return path


def picture(width: int, height: int, *, cut: bool = False) -> bytes:
    """Return a black PNG of one bit per pixel: small as a file."""
    row = bytes(1 + (width + 7) // 8)
    pack = zlib.compressobj(9)
    data = b"".join(pack.compress(row) for _ in range(4 if cut else height)) + pack.flush()
    head = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", data), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
        for name, body in chunks
    )


def _pictures(folder: Path, *images: bytes) -> Path:
    file = Gltf()
    triangle = file.triangle(TEXCOORD_0=file.accessor([[0, 0], [1, 0], [0, 1]]))
    views = {image: file.view(image) for image in images}
    parts = range(len(images))
    surfaces = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": n}}} for n in parts]
    return _scene(
        folder,
        file,
        meshes=[{"primitives": [triangle | {"material": number} for number in parts]}],
        materials=surfaces,
        textures=[{"source": number} for number in parts],
        images=[{"bufferView": views[image], "mimeType": "image/png"} for image in images],
    )


def _elsewhere(folder: Path, uri: str) -> Path:
    """Take the corners from a file that is not the scene's."""
    (folder.parent / "elsewhere.bin").write_bytes(np.eye(3, dtype="<f4").tobytes())
    file = Gltf()
    primitive = file.triangle()
    file.root["buffers"][0]["uri"] = uri.replace("ELSEWHERE", str(folder.parent / "elsewhere.bin"))
    return _scene(folder, file, meshes=[{"primitives": [primitive]}])


HOSTILE: Mapping[str, Callable[[Path], Path]] = {
    "10^9 elements without data": _count,
    "10^9 elements of 36 bytes": lambda folder: _count(folder, bounded=True),
    "10^9 sparse elements": _sparse,
    "10^9 keys of an animation": _keys,
    "the same data 10^4 times": _same_data,
    "a chain of 10^5 nodes": _chain,
    "10^5 nodes and meshes": _many,
    "JSON nested 10^6 deep": _nested,
    "a picture of 30,000 × 30,000 pixels": lambda at: _pictures(at, picture(30_000, 30_000)),
    "300 pictures of 4,096 × 4,096": lambda at: _pictures(at, *[picture(4096, 4096)] * 300),
    "a picture that says 65,000 × 65,000": lambda at: _pictures(
        at, picture(65_000, 65_000, cut=True)
    ),
}
"""May be loaded or refused, but within the limits."""

REFUSED: Mapping[str, Callable[[Path], Path]] = {
    "a circle of nodes": _circle,
    "a chunk of 4 GiB that is not there": _long_chunk,
    "data from the folder above": lambda at: _elsewhere(at, "../elsewhere.bin"),
    "data from the folder above, escaped": lambda at: _elsewhere(at, "%2e%2e/elsewhere.bin"),
    "data from an absolute path": lambda at: _elsewhere(at, "ELSEWHERE"),
    "data from a file: address": lambda at: _elsewhere(at, "file://ELSEWHERE"),
    "an extension that nobody knows": lambda at: _scene(
        at, extensionsUsed=["EXT_nobody_knows"], extensionsRequired=["EXT_nobody_knows"]
    ),
}
"""Must be refused."""
