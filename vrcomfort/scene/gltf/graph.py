"""Nodes, animations and lights of a glTF file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.geometry import Array, normalize
from vrcomfort.scene.animation import Animation, Channel, Skin
from vrcomfort.scene.data import (
    DirectionalLight,
    Node,
    PointLight,
    Rgb,
    SpotLight,
    parent_from_node,
)
from vrcomfort.scene.gltf.file import GltfFile, places_of
from vrcomfort.scene.gltf.mesh import Meshes
from vrcomfort.scene.gltf.parts import FARTHEST, SHORTEST_QUATERNION

Lights = tuple[tuple[PointLight, ...], tuple[DirectionalLight, ...]]
Graph = tuple[
    tuple[Node, ...], tuple[Animation, ...], tuple[Skin, ...], Lights, dict[str, tuple[int, ...]]
]
_HANDLED = {
    "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_unlit",
    "KHR_mesh_quantization", "KHR_texture_transform",
}  # fmt: skip
_LIGHTS = "KHR_lights_punctual"
_COMPRESSED = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}
#: A lamp without a range ends where it gives this irradiance (W/m², our units).
_FAINTEST = 0.01


def read_graph(file: GltfFile, meshes: Meshes, unsupported: set[str]) -> Graph:
    """Return nodes (parents first), animations, skins, lights, and the meshes of other nodes.

    Nodes outside the default scene are not drawn; a side-car may name them as coarser
    levels of detail.
    """
    unsupported.update(name for name in ("cameras",) if file.items(name))
    file.account.spend("nodes", len(file.items("nodes")), "the file")
    order = list(_walk(file))
    place = {gltf_index: index for index, (gltf_index, _) in enumerate(order)}
    items = file.items("nodes")
    nodes = [
        _node(file.item("nodes", index), -1 if parent < 0 else place[parent], meshes, index)
        for index, parent in order
    ]
    file.account.spend("draws", sum(len(node.mesh) for node in nodes), "the scene graph")
    animations = _animations(file, place, unsupported)
    moving = {channel.node for animation in animations for channel in animation.channels}
    skins = _skins(file, place)
    marked = _mark_moving(nodes, moving, skins)
    lights = _lights(file, place, marked, unsupported)
    stand_ins = {
        item.get("name", f"node {index}"): _mesh(meshes, item)
        for index, item in enumerate(items)
        if index not in place and "mesh" in item
    }
    return marked, animations, skins, lights, stand_ins


def refuse_unknown(file: GltfFile) -> None:
    """Raise InputError where the file needs an extension that is not here: it says so itself."""
    needed = sorted(set(file.root.get("extensionsRequired", [])) - _HANDLED)
    if needed:
        without = "mesh compression" if needed[0] in _COMPRESSED else "it"
        where = next(places_of(file.root, needed[0]), None)
        there = f" (first in {where})" if where else ""
        raise InputError(
            f"needs {needed[0]}{there}, which cannot be read; export it without {without}",
            file=file.path,
        )


def _walk(file: GltfFile) -> Iterator[tuple[int, int]]:
    """Yield (node, parent) of the default scene, parents first; parent -1 for roots."""
    items, scenes = file.items("nodes"), file.items("scenes")
    children = {child for item in items for child in item.get("children", [])}
    if scenes:
        roots = file.item("scenes", file.root.get("scene", 0)).get("nodes", [])
    else:
        roots = [index for index in range(len(items)) if index not in children]
    waiting = [(root, -1) for root in reversed(roots)]
    seen: set[int] = set()
    while waiting:
        index, parent = waiting.pop()
        if index in seen:
            name = items[index].get("name", f"node {index}")
            raise file.fault(f"node {name!r}", "has two parents, or is its own")
        seen.add(index)
        yield index, parent
        waiting += [
            (child, index) for child in reversed(file.item("nodes", index).get("children", []))
        ]


def _mesh(meshes: Meshes, item: dict[str, Any]) -> tuple[int, ...]:
    return meshes[item["mesh"]] if "mesh" in item else ()


def _node(item: dict[str, Any], parent: int, meshes: Meshes, index: int) -> Node:
    matrix = item.get("matrix")
    return Node(
        name=item.get("name", f"node {index}"),
        parent=parent,
        translation=np.array(item.get("translation", (0, 0, 0)), np.float64).reshape(3),
        rotation=normalize(np.array(item.get("rotation", (0, 0, 0, 1)), np.float64).reshape(4)),
        scale=np.array(item.get("scale", (1, 1, 1)), np.float64).reshape(3),
        # Column-major in the file.
        matrix=None if matrix is None else np.array(matrix, np.float64).reshape(4, 4).T,
        mesh=_mesh(meshes, item),
        skin=item.get("skin") if "mesh" in item else None,
    )


def _skins(file: GltfFile, place: dict[int, int]) -> tuple[Skin, ...]:
    """Return all skins; those that nothing in the scene wears have no joints."""
    worn = {file.item("nodes", index).get("skin") for index in place} - {None}
    if not worn:
        return ()
    return tuple(
        _skin(file, item, f"skin {item.get('name', index)!r}", place)
        if index in worn
        else Skin(f"skin {index}", (), np.zeros((0, 4, 4)))
        for index, item in enumerate(file.items("skins"))
    )


def _skin(file: GltfFile, item: dict[str, Any], what: str, place: dict[int, int]) -> Skin:
    count = len(item["joints"])
    file.account.spend("joints", count, what)
    if any(joint not in place for joint in item["joints"]):
        raise file.fault(what, "has a joint that is no node of the scene")
    matrices = np.tile(np.eye(4), (count, 1, 1))
    if "inverseBindMatrices" in item:
        rows = file.accessor(item["inverseBindMatrices"], what, ["MAT4"]).astype(np.float64)
        if len(rows) < count:
            raise file.fault(what, f"has {len(rows)} inverse bind matrices for {count} joints")
        if np.abs(rows).max() > FARTHEST:
            raise file.fault(what, f"has a number of more than {FARTHEST:g} in a matrix")
        matrices = rows[:count].reshape(-1, 4, 4).swapaxes(1, 2)  # column-major in the file
        matrices[:, 3] = [0.0, 0.0, 0.0, 1.0]
    return Skin(what, tuple(place[joint] for joint in item["joints"]), matrices)


def _mark_moving(nodes: list[Node], moving: set[int], skins: tuple[Skin, ...]) -> tuple[Node, ...]:
    """Mark moving nodes: below an animated node, or bent by a joint that moves."""
    marked: list[Node] = []
    for index, node in enumerate(nodes):
        inherited = node.parent >= 0 and marked[node.parent].moving
        marked.append(replace(node, moving=inherited or index in moving))
    bends = [any(marked[joint].moving for joint in skin.joints) for skin in skins]
    return tuple(
        replace(node, moving=True) if node.skin is not None and bends[node.skin] else node
        for node in marked
    )


def _animations(
    file: GltfFile, place: dict[int, int], unsupported: set[str]
) -> tuple[Animation, ...]:
    animations = []
    for index, item in enumerate(file.items("animations")):
        name = item.get("name", f"animation {index}")
        channels = [
            _channel(file, name, item["samplers"][channel["sampler"]], channel["target"], place)
            for channel in item["channels"]
            if _animates(channel["target"], place, unsupported)
        ]
        if channels:
            duration_s = max(float(channel.times_s[-1]) for channel in channels)
            animations.append(Animation(name, tuple(channels), duration_s))
    return tuple(animations)


def _animates(target: dict[str, Any], place: dict[int, int], unsupported: set[str]) -> bool:
    if target["path"] not in ("translation", "rotation", "scale"):
        unsupported.add(f"animation of {target['path']}")
        return False
    return target.get("node") in place


def _channel(
    file: GltfFile,
    name: str,
    sampler: dict[str, Any],
    target: dict[str, Any],
    place: dict[int, int],
) -> Channel:
    what, path = f"animation {name!r}", target["path"]
    times_s = file.accessor(sampler["input"], what, ["SCALAR"])[:, 0].astype(np.float64)
    kind = "VEC4" if path == "rotation" else "VEC3"
    values = file.accessor(sampler["output"], what, [kind]).astype(np.float64)
    interpolation = sampler.get("interpolation", "LINEAR")
    parts = 3 if interpolation == "CUBICSPLINE" else 1
    if len(values) != parts * len(times_s):
        raise file.fault(what, f"has {len(values)} values for {len(times_s)} key frames")
    if (np.diff(times_s) < 0).any():
        raise file.fault(what, "has times that do not rise")
    if np.abs(values).max() > FARTHEST:
        raise file.fault(what, f"has a value of more than {FARTHEST:g}")
    keys = values.reshape(-1, parts, values.shape[1])
    if path == "rotation" and (_lengths(keys[:, parts // 2]) < SHORTEST_QUATERNION).any():
        raise file.fault(what, "has a rotation of length 0, which is none")
    return Channel(
        place[target["node"]], path, times_s, keys if parts > 1 else values, interpolation
    )


def _lengths(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=-1))


def _lights(
    file: GltfFile, place: dict[int, int], nodes: tuple[Node, ...], unsupported: set[str]
) -> Lights:
    """Return the lamps of KHR_lights_punctual where their nodes are at time zero."""
    extension = file.root.get("extensions", {}).get(_LIGHTS, {})
    world = _world(nodes)
    lamps: list[PointLight] = []
    far: list[DirectionalLight] = []
    for gltf_index, index in place.items():
        reference = file.root["nodes"][gltf_index].get("extensions", {})
        if _LIGHTS not in reference:
            continue
        light = extension["lights"][reference[_LIGHTS]["light"]]
        if nodes[index].moving:
            unsupported.add("lamps that move (they stay where they are at first)")
        if light["type"] == "directional":
            shines = _shines(file, nodes[index], world[index])
            far.append(DirectionalLight(shines, _strength(light)))
        elif light["type"] == "spot":
            lamps.append(_spot(light, world[index], _shines(file, nodes[index], world[index])))
        elif light["type"] == "point":
            lamps.append(_lamp(light, world[index]))
        else:
            unsupported.add(f"{light['type']} lights")
    return tuple(lamps), tuple(far)


def _shines(file: GltfFile, node: Node, world_from_node: Array) -> Rgb:
    """Return the unit vector along which a node's light shines: its -Z axis."""
    axis = -world_from_node[:3, 2]
    if not np.linalg.norm(axis) > 0:
        raise file.fault(
            f"node {node.name!r}", "has a light, but a scale of 0: it has no direction"
        )
    return _rgb(normalize(axis))


def _strength(light: dict[str, Any]) -> Rgb:
    return _rgb(light.get("intensity", 1.0) * np.array(light.get("color", (1.0, 1.0, 1.0))))


def _rgb(vector: Array) -> Rgb:
    x, y, z = (float(value) for value in vector)
    return x, y, z


def _lamp(light: dict[str, Any], world_from_node: Array) -> PointLight:
    strength = _strength(light)
    reach_m = light.get("range", float(np.sqrt(max(strength) / _FAINTEST)))
    return PointLight(_rgb(world_from_node[:3, 3]), strength, reach_m)


def _spot(light: dict[str, Any], world_from_node: Array, shines: Rgb) -> SpotLight:
    cone = light.get("spot", {})
    inner, outer = cone.get("innerConeAngle", 0.0), cone.get("outerConeAngle", np.pi / 4)
    lamp = _lamp(light, world_from_node)
    return SpotLight(lamp.position, lamp.intensity, lamp.range_m, shines, inner, outer)


def _world(nodes: tuple[Node, ...]) -> Any:
    world = parent_from_node(nodes, (), 0.0)
    for index, node in enumerate(nodes):
        if node.parent >= 0:
            world[index] = world[node.parent] @ world[index]
    return world
