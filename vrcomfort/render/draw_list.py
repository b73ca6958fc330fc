"""What could be drawn, as tables: one row per node, level of detail and primitive.

Choosing among thousands of things per frame is then a few array operations, and the answer is
what the GPU reads: rows of ``DrawElementsIndirectCommand``.
"""

from __future__ import annotations

import operator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.render import culling
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


class BatchKey(NamedTuple):
    """What one multi-draw shares: everything that needs a change of OpenGL state."""

    material: int
    mirrored: bool
    vertex_colors: bool


class Batch(NamedTuple):
    """A run of commands, to be drawn with one call."""

    key: int
    first: int
    length: int


class _Item(NamedTuple):
    node: int
    primitive: int
    key: int
    from_m: float
    until_m: float
    base_level: bool


@dataclass(frozen=True, eq=False)
class DrawList:
    """The rows of a scene. All arrays are (items,) or (items, 3)."""

    keys: tuple[BatchKey, ...]
    node: NDArray[np.intp]
    key: NDArray[np.intp]
    commands: NDArray[np.void]
    centers: Array
    halves: Array
    from_m: Array
    until_m: Array
    base_level: NDArray[np.bool_]
    ambient: NDArray[np.float32]
    casts_shadow: NDArray[np.bool_]
    semantic_weight: NDArray[np.float32]

    @classmethod
    def of(cls, scene: Scene) -> DrawList:
        """Tabulate a scene; index and vertex offsets are those of `concatenated primitives`."""
        world = scene.world_from_node(0.0)
        keys: dict[BatchKey, int] = {}
        items = [
            _Item(index, primitive, keys.setdefault(key, len(keys)), from_m, until_m, base)
            for index, node in enumerate(scene.nodes)
            for mesh, from_m, until_m, base in _levels(node)
            for primitive in mesh
            for key in [_key(scene, primitive, world[index])]
        ]
        lower, upper = _bounds(scene, [item.primitive for item in items])
        return cls(
            keys=tuple(keys),
            node=np.array([item.node for item in items], dtype=np.intp),
            key=np.array([item.key for item in items], dtype=np.intp),
            commands=_commands(scene, [item.primitive for item in items]),
            centers=(lower + upper) / 2,
            halves=(upper - lower) / 2,
            from_m=np.array([item.from_m for item in items]),
            until_m=np.array([item.until_m for item in items]),
            base_level=np.array([item.base_level for item in items], dtype=bool),
            ambient=np.array([scene.nodes[item.node].ambient for item in items], dtype=np.float32),
            casts_shadow=np.array([scene.nodes[item.node].casts_shadow for item in items], bool),
            semantic_weight=np.array(
                [scene.nodes[item.node].semantic_weight for item in items], dtype=np.float32
            ),
        )

    def world_boxes(self, world_from_node: Array, rows: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return centres and half extents of the world-space boxes of some rows."""
        return culling.transformed_boxes(
            world_from_node[self.node[rows]], self.centers[rows], self.halves[rows]
        )

    def level_in_use(self, node_distance_m: Array) -> NDArray[np.bool_]:
        """Return (items,) True where a row's level of detail is the one for its node's distance."""
        distance = node_distance_m[self.node]
        return (distance >= self.from_m) & (distance < self.until_m)

    def node_centers(self, centers: Array, halves: Array, nodes: int) -> Array:
        """Return (nodes, 3) centres of the world boxes around the finest level of each node."""
        found = np.zeros((nodes, 3))
        rows, first = self._finest
        if len(rows):
            center, half = centers[rows], halves[rows]
            lower = np.minimum.reduceat(center - half, first)
            upper = np.maximum.reduceat(center + half, first)
            found[self.node[rows[first]]] = (lower + upper) / 2
        return found

    @cached_property
    def _finest(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the rows of the finest levels, and where among them each node begins."""
        rows = np.flatnonzero(self.base_level)  # rows of a node stand together
        return rows, np.flatnonzero(np.diff(self.node[rows], prepend=-1))


def batches(keys: NDArray[np.intp], order: NDArray[np.intp]) -> list[Batch]:
    """Cut ordered rows into runs of equal key."""
    ordered = keys[order]
    if not len(ordered):
        return []
    starts = [0, *(np.flatnonzero(ordered[1:] != ordered[:-1]) + 1).tolist()]
    ends = [*starts[1:], len(ordered)]
    return list(map(Batch, ordered[starts].tolist(), starts, map(operator.sub, ends, starts)))


def front_to_back(
    rows: NDArray[np.intp], keys: NDArray[np.intp], distance_m: Array
) -> NDArray[np.intp]:
    """Order rows by key, keys by their nearest row, and the rows of a key by distance.

    Near things first: the depth test then spares most of the shading behind them.
    """
    nearest = np.full(int(keys.max(initial=0)) + 1, np.inf)
    np.minimum.at(nearest, keys[rows], distance_m[rows])
    return rows[np.lexsort((distance_m[rows], keys[rows], nearest[keys[rows]]))]


def _levels(node: Node) -> list[tuple[tuple[int, ...], float, float, bool]]:
    """Return (mesh, from, until, is the finest) of each level of detail."""
    starts = [0.0, *(level.from_distance_m for level in node.lod), np.inf]
    meshes = [node.mesh, *(level.mesh for level in node.lod)]
    return [
        (mesh, starts[level], starts[level + 1], level == 0) for level, mesh in enumerate(meshes)
    ]


def _key(scene: Scene, primitive: int, world_from_node: Array) -> BatchKey:
    surface = scene.primitives[primitive]
    mirrored = bool(np.linalg.det(world_from_node[:3, :3]) < 0)
    return BatchKey(surface.material, mirrored, surface.colors is not None)


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
