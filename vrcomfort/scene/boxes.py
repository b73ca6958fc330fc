"""Boxes around nodes of a scene, with their descendants."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.scene.data import Scene

_ENDS = np.indices((2, 2, 2)).reshape(3, 8)
_AXES = np.arange(3)[:, None]


def box_corners(lower: Array, upper: Array) -> Array:
    """Return the (3, 8) corners of a box."""
    return np.asarray(np.stack([lower, upper])[_ENDS, _AXES])


def with_all_below(scene: Scene, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (nodes,) the chosen nodes and their descendants."""
    found = np.array(chosen, dtype=bool)
    for index, node in enumerate(scene.nodes):  # parents come first in a scene
        found[index] |= node.parent >= 0 and found[node.parent]
    return found


def node_box(scene: Scene, index: int, time_s: float) -> tuple[Array, Array]:
    """Return the (3,) corners of a world-space box around a node and all that hangs on it.

    Where nothing is drawn, both are the node's own place.
    """
    world = scene.world_from_node(time_s)
    parts = [
        world[each, :3, :3] @ box_corners(*scene.primitives[k].bounds) + world[each, :3, 3:]
        for each in np.flatnonzero(with_all_below(scene, np.arange(len(scene.nodes)) == index))
        for k in scene.nodes[each].mesh
    ]
    points = np.concatenate(parts, axis=1) if parts else world[index, :3, 3:]
    return points.min(axis=1), points.max(axis=1)
