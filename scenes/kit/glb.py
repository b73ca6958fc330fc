"""Writes GLB files whose bytes depend on their content only."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .mesh import Mesh

_FLOAT, _I8, _U8, _U16, _U32 = 5126, 5120, 5121, 5123, 5125
_KIND = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


class GlbWriter:
    """Collects images, materials, meshes, nodes and animations, then writes one file."""

    def __init__(self, *, position_step_m: float = 1e-4) -> None:
        self.position_step_m = position_step_m
        self.root: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "vrcomfort scene scripts"},
            "scene": 0, "scenes": [{"nodes": []}], "samplers": [{"wrapS": 10497, "wrapT": 10497}],
        }  # fmt: skip
        self.binary = bytearray()

    def _add(self, key: str, item: dict[str, Any]) -> int:
        items: list[dict[str, Any]] = self.root.setdefault(key, [])
        items.append(item)
        return len(items) - 1

    def _view(self, data: bytes) -> int:
        self.binary += b"\0" * (-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        self.binary += data
        return self._add("bufferViews", view)

    def _accessor(self, values: NDArray[Any], component: int, **extra: Any) -> int:
        item = {"bufferView": self._view(values.tobytes()), "componentType": component,
                "count": len(values), "type": _KIND[values.shape[1]], **extra}  # fmt: skip
        return self._add("accessors", item)

    def texture(self, name: str, png: bytes) -> int:
        """Add an image and its repeating texture."""
        image = {"name": name, "mimeType": "image/png", "bufferView": self._view(png)}
        return self._add("textures", {"source": self._add("images", image), "sampler": 0})

    def material(
        self, name: str, *, color: ArrayLike = (1, 1, 1), texture: int | None = None,
        normal: int | None = None, normal_scale: float = 1.0, metallic: float = 0.0,
        roughness: float = 0.9, emissive: ArrayLike | None = None,
        mask: float | None = None, double_sided: bool = False,
    ) -> int:  # fmt: skip
        """Add a material; `mask` is the alpha cut-off of a MASK material."""
        surface: dict[str, Any] = {"metallicFactor": metallic, "roughnessFactor": roughness,
                                   "baseColorFactor": [*np.asarray(color).tolist(), 1]}  # fmt: skip
        item: dict[str, Any] = {"name": name, "pbrMetallicRoughness": surface}
        if texture is not None:
            surface["baseColorTexture"] = {"index": texture}
        if normal is not None:
            item["normalTexture"] = {"index": normal, "scale": normal_scale}
        if emissive is not None:
            self._emissive(item, np.asarray(emissive, dtype=np.float64))
        if mask is not None:
            item |= {"alphaMode": "MASK", "alphaCutoff": mask}
        if double_sided:
            item["doubleSided"] = True
        return self._add("materials", item)

    def _emissive(self, item: dict[str, Any], radiance: NDArray[np.float64]) -> None:
        strength = max(1.0, float(radiance.max()))
        item["emissiveFactor"] = (radiance / strength).round(4).tolist()
        if strength > 1:
            used: list[str] = self.root.setdefault("extensionsUsed", [])
            if "KHR_materials_emissive_strength" not in used:
                used.append("KHR_materials_emissive_strength")
            extension = {"emissiveStrength": strength}
            item["extensions"] = {"KHR_materials_emissive_strength": extension}

    def mesh(self, name: str, parts: list[tuple[Mesh, int]]) -> int:
        """Add a mesh of (triangles, material) parts."""
        primitives = [self._primitive(mesh, material) for mesh, material in parts]
        return self._add("meshes", {"name": name, "primitives": primitives})

    def _primitive(self, mesh: Mesh, material: int) -> dict[str, Any]:
        step = self.position_step_m
        positions = (np.round(mesh.positions / step) * step).astype(np.float32)
        attributes = {
            "POSITION": self._accessor(positions, _FLOAT, min=positions.min(axis=0).tolist(),
                                       max=positions.max(axis=0).tolist()),
            "NORMAL": self._normals(mesh.normals),
            "TEXCOORD_0": self._accessor(np.round(mesh.uvs, 4).astype(np.float32), _FLOAT),
        }  # fmt: skip
        if mesh.colors is not None:
            colors = np.round(np.clip(mesh.colors, 0, 1) * 255).astype(np.uint8)
            attributes["COLOR_0"] = self._accessor(colors, _U8, normalized=True)
        small = len(positions) < 65536
        flat = mesh.indices.reshape(-1, 1).astype(np.uint16 if small else np.uint32)
        indices = self._accessor(flat, _U16 if small else _U32)
        return {"attributes": attributes, "indices": indices, "material": material}

    def _normals(self, normals: NDArray[np.float64]) -> int:
        """Store normals as bytes, padded to four (KHR_mesh_quantization): 0.3° at most."""
        for key in ("extensionsUsed", "extensionsRequired"):
            used: list[str] = self.root.setdefault(key, [])
            if "KHR_mesh_quantization" not in used:
                used.append("KHR_mesh_quantization")
        padded = np.zeros((len(normals), 4), np.int8)
        padded[:, :3] = np.round(normals * 127)
        view = self._view(padded.tobytes())
        self.root["bufferViews"][view]["byteStride"] = 4
        item = {"bufferView": view, "componentType": _I8, "count": len(normals),
                "type": "VEC3", "normalized": True}  # fmt: skip
        return self._add("accessors", item)

    def node(
        self, name: str, mesh: int | None = None, *, at: ArrayLike | None = None,
        rotation: ArrayLike | None = None, children: list[int] | None = None, root: bool = True,
    ) -> int:  # fmt: skip
        """Add a node; without `root` it is only drawn as a child or as a level of detail."""
        item: dict[str, Any] = {"name": name}
        for key, value in (("translation", at), ("rotation", rotation)):
            if value is not None:
                item[key] = np.round(np.asarray(value, dtype=np.float64), 6).tolist()
        if mesh is not None:
            item["mesh"] = mesh
        if children:
            item["children"] = children
        index = self._add("nodes", item)
        if root:
            self.root["scenes"][0]["nodes"].append(index)
        return index

    def animate(
        self, name: str, node: int, path: str, times_s: ArrayLike, values: ArrayLike
    ) -> None:
        """Add a LINEAR animation of one property."""
        times = np.round(np.asarray(times_s, dtype=np.float64), 6).astype(np.float32).reshape(-1, 1)
        keys = np.round(np.asarray(values, dtype=np.float64), 7).astype(np.float32)
        span = {"min": [float(times.min())], "max": [float(times.max())]}
        sampler = {"input": self._accessor(times, _FLOAT, **span),
                   "output": self._accessor(keys, _FLOAT), "interpolation": "LINEAR"}  # fmt: skip
        channel = {"sampler": 0, "target": {"node": node, "path": path}}
        self._add("animations", {"name": name, "samplers": [sampler], "channels": [channel]})

    def save(self, path: Path) -> None:
        """Write the file."""
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.root["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.root, separators=(",", ":"), sort_keys=True).encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + len(self.binary)
        header = struct.pack("<4sII", b"glTF", 2, length)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(self.binary), b"BIN\0") + bytes(self.binary)
        path.write_bytes(header + chunks)
