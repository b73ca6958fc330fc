"""Meshes, materials and textures of a glTF file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrcomfort.scene.animation import Bending
from vrcomfort.scene.data import Image, Material, Primitive, UvMap, Wrap
from vrcomfort.scene.gltf.file import GltfFile
from vrcomfort.scene.gltf.parts import FARTHEST

Meshes = list[tuple[int, ...]]
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_UNSIGNED = (5121, 5123, 5125)
_MOST_HALF = 65_504.0
"""Greatest number of half precision, in which the GPU has normals and colours."""
_OF_CORNER = 3 + 3 + 2 + 2 + 4 + 4 + 4
"""Numbers of a corner that no other triangle shares: position, normal, uv twice, colour, joints and
weights."""
_NEXT, _LAST = [1, 2, 0], [2, 0, 1]
_WRAPS: dict[int, Wrap] = {10497: "repeat", 33071: "clamp_to_edge", 33648: "mirrored_repeat"}
#: Material extensions that are honoured here; any other is named as unsupported.
_MATERIAL_EXTENSIONS = {"KHR_materials_emissive_strength", "KHR_materials_unlit"}
_TRANSFORM = "KHR_texture_transform"


def read_materials(
    file: GltfFile, unsupported: set[str]
) -> tuple[tuple[Material, ...], tuple[Image, ...]]:
    """Return materials (the last is glTF's default material) and the images they use."""
    textures = _Textures(file, unsupported)
    materials = [_material(item, textures) for item in file.items("materials")]
    return (*materials, Material("default", metallic=1.0, roughness=1.0)), tuple(textures.images)


class _Textures:
    """Turns glTF textures (image + sampler) into `Image` indices, each loaded once."""

    def __init__(self, file: GltfFile, unsupported: set[str]) -> None:
        self.file = file
        self.unsupported = unsupported
        self.images: list[Image] = []
        self._known: dict[tuple[int, tuple[Wrap, Wrap]], int] = {}

    def fields(self, name: str, info: dict[str, Any] | None) -> dict[str, Any]:
        """Return the fields of a `Material` that a textureInfo object fills."""
        if info is None:
            return {}
        return {f"{name}_image": self._index(info), f"{name}_uv": self._uv_map(info)}

    def _uv_map(self, info: dict[str, Any]) -> UvMap:
        extensions = info.get("extensions", {})
        self.unsupported.update(extensions.keys() - {_TRANSFORM})
        moved = extensions.get(_TRANSFORM, {})
        uv_set = moved.get("texCoord", info.get("texCoord", 0))
        return UvMap(
            uv_set,
            tuple(moved.get("offset", (0.0, 0.0))),
            moved.get("rotation", 0.0),
            tuple(moved.get("scale", (1.0, 1.0))),
        )

    def _index(self, info: dict[str, Any]) -> int | None:
        texture = self.file.item("textures", info["index"])
        if "source" not in texture:
            self.unsupported.update(texture.get("extensions", {"textures without an image": {}}))
            return None
        wrap = self._wrap(texture)
        key = (texture["source"], wrap)
        if key not in self._known:
            self._known[key] = len(self.images)
            self.images.append(Image(self.file.image(texture["source"]), wrap))
        return self._known[key]

    def _wrap(self, texture: dict[str, Any]) -> tuple[Wrap, Wrap]:
        if "sampler" not in texture:
            return "repeat", "repeat"
        sampler = self.file.item("samplers", texture["sampler"])
        return _WRAPS[sampler.get("wrapS", 10497)], _WRAPS[sampler.get("wrapT", 10497)]


def _material(item: dict[str, Any], textures: _Textures) -> Material:
    surface = item.get("pbrMetallicRoughness", {})
    normal = item.get("normalTexture")
    if "occlusionTexture" in item:
        textures.unsupported.add("occlusion textures")
    extensions = item.get("extensions", {})
    textures.unsupported.update(set(extensions) - _MATERIAL_EXTENSIONS)
    strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    red, green, blue = item.get("emissiveFactor", (0.0, 0.0, 0.0))
    return Material(
        name=item.get("name", ""),
        base_color=tuple(surface.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))),
        normal_scale=(normal or {}).get("scale", 1.0),
        metallic=surface.get("metallicFactor", 1.0),
        roughness=surface.get("roughnessFactor", 1.0),
        emissive=(red * strength, green * strength, blue * strength),
        alpha_mode=item.get("alphaMode", "OPAQUE"),
        alpha_cutoff=item.get("alphaCutoff", 0.5),
        double_sided=item.get("doubleSided", False),
        unlit="KHR_materials_unlit" in extensions,
        **textures.fields("base_color", surface.get("baseColorTexture")),
        **textures.fields("normal", normal),
        **textures.fields("metallic_roughness", surface.get("metallicRoughnessTexture")),
        **textures.fields("emissive", item.get("emissiveTexture")),
    )


def read_meshes(file: GltfFile, unsupported: set[str]) -> tuple[tuple[Primitive, ...], Meshes]:
    """Return all primitives, and for each glTF mesh the indices of its primitives."""
    primitives: list[Primitive] = []
    meshes: Meshes = []
    default_material = len(file.items("materials"))
    bent = {node.get("mesh") for node in file.items("nodes") if "skin" in node}
    for number, mesh in enumerate(file.items("meshes")):
        first = len(primitives)
        for item in mesh["primitives"]:
            what = f"mesh {mesh.get('name', len(meshes))!r}"
            used = item if number in bent else _never_bent(item)
            primitive = _primitive(file, used, what, default_material, unsupported)
            if primitive is not None:
                primitives.append(primitive)
        meshes.append(tuple(range(first, len(primitives))))
    return tuple(primitives), meshes


def _never_bent(item: dict[str, Any]) -> dict[str, Any]:
    """Return a primitive without joints and weights: exports may keep them without a skin."""
    kept = {
        name: accessor
        for name, accessor in item["attributes"].items()
        if not name.startswith(("JOINTS_", "WEIGHTS_"))
    }
    return {**item, "attributes": kept}


def _primitive(
    file: GltfFile,
    item: dict[str, Any],
    what: str,
    default_material: int,
    unsupported: set[str],
) -> Primitive | None:
    _name_unsupported(item, unsupported)
    mode = item.get("mode", _TRIANGLES)
    if mode not in (_TRIANGLES, _STRIP, _FAN):
        unsupported.add("points and lines")
        return None
    position = item["attributes"].get("POSITION")
    if position is None or "bufferView" not in file.item("accessors", position):
        return None
    positions = file.accessor(position, what, ["VEC3"]).astype(np.float32)
    if np.abs(positions).max() > FARTHEST:
        raise file.fault(what, f"has a position of more than {FARTHEST:g}")
    flat = _corners(file, item, what, len(positions), mode)
    if mode != _TRIANGLES:
        file.account.spend("numbers", 3 * len(flat), what)
    indices = _triangles(flat, mode)
    return _assembled(file, item, what, positions, indices, item.get("material", default_material))


def _name_unsupported(item: dict[str, Any], unsupported: set[str]) -> None:
    if "targets" in item:
        unsupported.add("morph targets")
    unsupported.update(item.get("extensions", {}))


def _corners(
    file: GltfFile, item: dict[str, Any], what: str, count: int, mode: int
) -> NDArray[np.uint32]:
    """Return the (n,) vertices of which triangles are made, in the file's order."""
    if "indices" not in item:
        file.account.spend("numbers", count, what)
        flat = np.arange(count, dtype=np.uint32)
    elif file.item("accessors", item["indices"])["componentType"] not in _UNSIGNED:
        raise file.fault(what, "has indices that are not unsigned whole numbers")
    else:
        flat = file.accessor(item["indices"], what, ["SCALAR"])[:, 0].astype(np.uint32)
    if flat.max() >= count:
        raise file.fault(what, f"has indices out of range: {flat.max()} of {count} vertices")
    if len(flat) < 3 or (mode == _TRIANGLES and len(flat) % 3):
        raise file.fault(what, f"has {len(flat)} corners, which are no whole triangles")
    return flat


def _triangles(flat: NDArray[np.uint32], mode: int) -> NDArray[np.uint32]:
    """Return (m, 3) indices of a list, a strip or a fan of triangles."""
    if mode == _TRIANGLES:
        return flat.reshape(-1, 3)
    if mode == _FAN:
        return np.stack([np.full(len(flat) - 2, flat[0]), flat[1:-1], flat[2:]], axis=1)
    strip = np.stack([flat[:-2], flat[1:-1], flat[2:]], axis=1)
    strip[1::2] = strip[1::2, [1, 0, 2]]
    return strip


def _assembled(
    file: GltfFile,
    item: dict[str, Any],
    what: str,
    positions: NDArray[np.float32],
    indices: NDArray[np.uint32],
    material: int,
) -> Primitive:
    attributes = item["attributes"]

    def read(name: str, *kinds: str, most: float) -> NDArray[np.float32] | None:
        if name not in attributes:
            return None
        values = file.accessor(attributes[name], what, kinds)
        if len(values) != len(positions):
            raise file.fault(what, f"has {len(values)} {name} for {len(positions)} POSITION")
        if np.abs(values).max() > most:
            raise file.fault(what, f"has a number of more than {most:g} in {name}")
        return values.astype(np.float32)

    normals = read("NORMAL", "VEC3", most=_MOST_HALF)
    uvs = read("TEXCOORD_0", "VEC2", most=FARTHEST)
    uvs_1 = read("TEXCOORD_1", "VEC2", most=FARTHEST)
    colors = read("COLOR_0", "VEC3", "VEC4", most=_MOST_HALF)
    bending = _bending(file, attributes, what, read("WEIGHTS_0", "VEC4", most=_MOST_HALF))
    if uvs is None:
        uvs = np.zeros((len(positions), 2), np.float32)
    if colors is not None and colors.shape[1] == 3:
        colors = np.concatenate([colors, np.ones((len(colors), 1), np.float32)], axis=1)
    if normals is None:
        # Flat normals, as the specification asks (§3.7.2.1): no corner is shared any more.
        corners = indices.ravel()
        file.account.spend("numbers", _OF_CORNER * len(corners), what)
        positions, uvs = positions[corners], uvs[corners]
        uvs_1 = None if uvs_1 is None else uvs_1[corners]
        colors = None if colors is None else colors[corners]
        if bending is not None:
            bending = Bending(bending.joints[corners], bending.weights[corners])
        indices = np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)
        normals = _flat_normals(positions)
    return Primitive(positions, normals, uvs, colors, indices, material, uvs_1, bending)


def _bending(
    file: GltfFile,
    attributes: dict[str, int],
    what: str,
    weights: NDArray[np.float32] | None,
) -> Bending | None:
    if "JOINTS_1" in attributes:
        raise file.fault(what, "has JOINTS_1: 4 joints may bend a vertex, not more")
    if "JOINTS_0" not in attributes or weights is None:
        return None
    accessor = file.item("accessors", attributes["JOINTS_0"])
    if accessor["componentType"] not in _UNSIGNED[:2] or accessor.get("normalized"):
        raise file.fault(what, "has joints that are not unsigned whole numbers of 8 or 16 bits")
    joints = file.accessor(attributes["JOINTS_0"], what, ["VEC4"]).astype(np.uint16)
    if len(joints) != len(weights):
        raise file.fault(what, f"has {len(joints)} JOINTS_0 for {len(weights)} WEIGHTS_0")
    total = weights.sum(axis=1, keepdims=True)
    if (weights < 0).any() or not (total > 0).all():
        raise file.fault(what, "has a vertex whose weights are negative, or all 0")
    return Bending(np.where(weights > 0, joints, 0).astype(np.uint16), weights / total)


def _flat_normals(corners: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return (3 m, 3) unit normals of m triangles given by their (3 m, 3) corners."""
    triangles = corners.astype(np.float64).reshape(-1, 3, 3)
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    # np.cross, whose overhead is most of the time that files of many small meshes take.
    normal = u[:, _NEXT] * v[:, _LAST] - u[:, _LAST] * v[:, _NEXT]
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.where(length > 0, normal / np.where(length > 0, length, 1.0), [0.0, 1.0, 0.0])
    return np.repeat(normal, 3, axis=0).astype(np.float32)
