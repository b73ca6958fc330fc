"""Small glTF files and scenes that the scene tests are made of."""

from __future__ import annotations

import base64
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image as PillowImage

from vrcomfort.scene.data import Image, Material, Node, Primitive, Scene

COMPONENT = {
    "int8": 5120,
    "uint8": 5121,
    "int16": 5122,
    "uint16": 5123,
    "uint32": 5125,
    "float32": 5126,
}
KIND = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class Gltf:
    """Writes a .gltf with one data URI per accessor."""

    def __init__(self) -> None:
        self.root: dict[str, Any] = {"asset": {"version": "2.0"}, "buffers": [], "bufferViews": [],
                                     "accessors": []}  # fmt: skip

    def view(self, data: bytes, **extra: Any) -> int:
        uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        self.root["buffers"].append({"uri": uri, "byteLength": len(data)})
        buffer = len(self.root["buffers"]) - 1
        self.root["bufferViews"].append({"buffer": buffer, "byteLength": len(data), **extra})
        return len(self.root["bufferViews"]) - 1

    def accessor(self, values: Any, dtype: str = "float32", **extra: Any) -> int:
        array = np.atleast_2d(np.array(values, dtype=dtype).T).T
        self.root["accessors"].append({
            "bufferView": self.view(array.tobytes()), "componentType": COMPONENT[dtype],
            "count": len(array), "type": KIND[array.shape[1]], **extra,
        })  # fmt: skip
        return len(self.root["accessors"]) - 1

    def triangle(self, **attributes: int) -> dict[str, Any]:
        """Return a primitive: a right triangle in the plane z = 0 that faces +Z."""
        position = self.accessor([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
        return {"attributes": {"POSITION": position, **attributes}}

    def save(self, path: Path, **root: Any) -> Path:
        """Write the file; nodes default to one with mesh 0."""
        content = {
            "nodes": [{"mesh": 0}],
            "scenes": [{"nodes": [0]}],
            "scene": 0,
            **self.root,
            **root,
        }
        path.write_text(json.dumps(content), encoding="utf-8")
        return path


def png(pixels: Any) -> bytes:
    """Return (h, w, 3 or 4) uint8 pixels as a PNG file."""
    out = io.BytesIO()
    PillowImage.fromarray(np.asarray(pixels, dtype=np.uint8)).save(out, "PNG")
    return out.getvalue()


def quad(z: float = 0.0, half: float = 1.0, material: int = 0) -> Primitive:
    """Return a square about the Z axis that faces +Z, uv (0, 0) at its upper left."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    positions = np.column_stack([corners, np.full(4, z)]).astype(np.float32)
    uvs = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)
    normals = np.tile(np.array([0, 0, 1], np.float32), (4, 1))
    return Primitive(
        positions, normals, uvs, None, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), material
    )


def scene_of(
    *nodes: Node,
    primitives: tuple[Primitive, ...],
    material: Material | None = None,
    image: Image | None = None,
) -> Scene:
    """Return a scene with one material."""
    images = () if image is None else (image,)
    return Scene("test", nodes, primitives, (material or Material(),), images)
