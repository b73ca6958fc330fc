"""Draw list as tables: one row per node, level of detail and primitive.

Choosing among thousands of instances per frame is then a few array operations, and the result is
in the format that the GPU reads: rows of ``DrawElementsIndirectCommand``.
"""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.render.culling import SkinBoxes
from vrcomfort.render.materials import BatchKey, ImageArrays, batch_key, materials_per_block
from vrcomfort.scene.data import Node, Scene

COMMAND = np.dtype(
    [
        ("index_count", np.uint32),
        ("instance_count", np.uint32),
        ("first_index", np.uint32),
        ("base_vertex", np.int32),
        ("base_instance", np.uint32),
    ]
)
"""DrawElementsIndirectCommand (OpenGL 4.5, §10.4)."""


Batch: TypeAlias = tuple[int, int, int]
"""A run of commands, to be drawn with one call: state, first command and number of commands."""


class _Item(NamedTuple):
    node: int
    primitive: int
    key: BatchKey
    from_m: float
    until_m: float
    base_level: bool


@dataclass(frozen=True, eq=False)
class DrawList:
    """The rows of a scene. All arrays are (items,) or (items, 3).

    Parameters
    ----------
    keys, depth_keys
        State that draws share, for colour and for depth alone.
    key, depth_key
        Of each row, by index into them.
    material
        Index into the block that the row's key names.
    blended
        Whether a row writes no depth.
    first_joint
        Where in the list of all joints those of a row's skin begin, 0 without one.
    skin_boxes
        Around skinned meshes.
    """

    keys: tuple[BatchKey, ...]
    depth_keys: tuple[BatchKey, ...]
    node: NDArray[np.intp]
    key: NDArray[np.intp]
    depth_key: NDArray[np.intp]
    material: NDArray[np.intp]
    blended: NDArray[np.bool_]
    commands: NDArray[np.void]
    centers: Array
    halves: Array
    from_m: Array
    until_m: Array
    base_level: NDArray[np.bool_]
    ambient: NDArray[np.float32]
    casts_shadow: NDArray[np.bool_]
    semantic_weight: NDArray[np.float32]
    first_joint: NDArray[np.intp]
    skin_boxes: SkinBoxes

    @classmethod
    def of(cls, scene: Scene, images: ImageArrays | None = None) -> DrawList:
        """Tabulate a scene; index and vertex offsets are those of `concatenated primitives`."""
        items = _items(scene, images or ImageArrays.of(scene))
        nodes = [scene.nodes[item.node] for item in items]
        surfaces = [scene.primitives[item.primitive] for item in items]
        keys, key = _numbered([item.key for item in items])
        depth_keys, depth_key = _numbered([item.key.of_depth for item in items])
        lower, upper = _bounds(scene, [item.primitive for item in items])
        return cls(
            keys=keys,
            depth_keys=depth_keys,
            node=np.array([item.node for item in items], dtype=np.intp),
            key=key,
            depth_key=depth_key,
            material=np.array([each.material for each in surfaces], np.intp)
            % materials_per_block(),
            blended=np.array([item.key.blended for item in items], dtype=bool),
            commands=_commands(scene, [item.primitive for item in items]),
            centers=(lower + upper) / 2,
            halves=(upper - lower) / 2,
            from_m=np.array([item.from_m for item in items]),
            until_m=np.array([item.until_m for item in items]),
            base_level=np.array([item.base_level for item in items], dtype=bool),
            ambient=np.array([node.ambient for node in nodes], dtype=np.float32),
            casts_shadow=np.array([node.casts_shadow for node in nodes], dtype=bool),
            semantic_weight=np.array([node.semantic_weight for node in nodes], dtype=np.float32),
            first_joint=np.array([_first_joint(scene, node) for node in nodes], dtype=np.intp),
            skin_boxes=SkinBoxes.of(scene, [(item.node, item.primitive) for item in items]),
        )

    @property
    def has_levels(self) -> NDArray[np.bool_]:
        """Return (items,) whether a row is not for every distance."""
        return (self.from_m > 0) | (self.until_m < np.inf)


def batches(keys: NDArray[np.intp], states: int) -> tuple[list[int], list[Batch]]:
    """Cut ordered rows into runs of equal keys.

    Parameters
    ----------
    keys
        (rows,) each a state's number, plus `states` times the number of what is drawn apart.

    Returns
    -------
    tuple
        That number for each run, and the runs with their states.
    """
    if not len(keys):
        return [], []
    changes = (keys[1:] != keys[:-1]).nonzero()[0] + 1  # hot: functions of NumPy's take longer
    starts = [0, *changes.tolist()]
    ends = [*starts[1:], len(keys)]
    found = keys[starts].tolist()
    lengths = map(operator.sub, ends, starts)
    runs = zip([key % states for key in found], starts, lengths, strict=True)
    return [key // states for key in found], list(runs)


def front_to_back(key: NDArray[np.intp], distance_m: Array) -> NDArray[np.intp]:
    """Return the order of rows: keys by their nearest row, and the rows of a key by distance.

    Near instances first: the depth test then spares most of the shading behind them.
    """
    nearest = np.full(int(key.max(initial=0)) + 1, np.inf)
    np.minimum.at(nearest, key, distance_m)
    return np.lexsort((distance_m, key, nearest[key]))


def _first_joint(scene: Scene, node: Node) -> int:
    return 0 if node.skin is None else int(scene.all_skins.first[node.skin])


def _items(scene: Scene, images: ImageArrays) -> list[_Item]:
    mirrored = _mirrored(scene)
    surfaces = scene.primitives
    return [
        _Item(index, primitive, key, from_m, until_m, base)
        for index, node in enumerate(scene.nodes)
        for mesh, from_m, until_m, base in _levels(node)
        for primitive in mesh
        for key in [
            batch_key(
                scene,
                images,
                surfaces[primitive].material,
                vertex_colors=surfaces[primitive].colors is not None,
                skinned=node.skin is not None,
                mirrored=bool(mirrored[index]),
            )
        ]
    ]


def _mirrored(scene: Scene) -> NDArray[np.bool_]:
    """Return (nodes,) whether a node's transform mirrors its meshes."""
    found = np.linalg.det(scene.world_from_node(0.0)[:, :3, :3]) < 0
    skins = scene.all_skins
    bends = np.linalg.det(skins.place_from_bind(scene.world_from_joint(0.0))[:, :3, :3])
    for index, node in enumerate(scene.nodes):
        if node.skin is not None:
            found[index] = bends[skins.first[node.skin]] < 0
    return np.asarray(found)


def _numbered(keys: list[BatchKey]) -> tuple[tuple[BatchKey, ...], NDArray[np.intp]]:
    """Return the different keys, and the number of each row's."""
    numbers: dict[BatchKey, int] = {}
    rows = [numbers.setdefault(key, len(numbers)) for key in keys]
    return tuple(numbers), np.array(rows, dtype=np.intp)


def _levels(node: Node) -> list[tuple[tuple[int, ...], float, float, bool]]:
    """Return (mesh, from, until, is the finest) of each level of detail."""
    starts = [0.0, *(level.from_distance_m for level in node.lod), np.inf]
    meshes = [node.mesh, *(level.mesh for level in node.lod)]
    return [
        (mesh, starts[level], starts[level + 1], level == 0) for level, mesh in enumerate(meshes)
    ]


def _bounds(scene: Scene, primitives: list[int]) -> tuple[Array, Array]:
    boxes = np.array([primitive.bounds for primitive in scene.primitives]).reshape(-1, 2, 3)
    return boxes[primitives, 0], boxes[primitives, 1]


def _commands(scene: Scene, primitives: list[int]) -> NDArray[np.void]:
    """Return one command per row; `base_instance` is filled in for each view."""
    indices = np.array([primitive.indices.size for primitive in scene.primitives], dtype=np.int64)
    vertices = np.array([len(primitive.positions) for primitive in scene.primitives])
    commands = np.zeros(len(primitives), COMMAND)
    commands["index_count"] = indices[primitives]
    commands["instance_count"] = 1
    commands["first_index"] = (np.cumsum(indices) - indices)[primitives]
    commands["base_vertex"] = (np.cumsum(vertices) - vertices)[primitives]
    return commands
