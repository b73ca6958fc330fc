"""The box around a node of a scene."""

from __future__ import annotations

import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.scene.data import Scene

_ENDS = np.indices((2, 2, 2)).reshape(3, 8)
_AXES = np.arange(3)[:, None]


def node_box(scene: Scene, index: int, time_s: float) -> tuple[Array, Array]:
    """Return the (3,) corners of a world-space box around a node and all that hangs on it.

    Where nothing is drawn, both are the node's own place.
    """
    world = scene.world_from_node(time_s)
    parts = [
        world[each, :3, :3] @ _corners(scene, k) + world[each, :3, 3:]
        for each in _below(scene, index)
        for k in scene.nodes[each].mesh
    ]
    points = np.concatenate(parts, axis=1) if parts else world[index, :3, 3:]
    return points.min(axis=1), points.max(axis=1)


def _below(scene: Scene, index: int) -> list[int]:
    """Return a node and its descendants; parents come first in a scene."""
    found = [index]
    for each in range(index + 1, len(scene.nodes)):
        if scene.nodes[each].parent in found:
            found.append(each)
    return found


def _corners(scene: Scene, primitive: int) -> Array:
    """Return the (3, 8) corners of the box around a primitive, in its node's frame."""
    low, high = scene.primitives[primitive].bounds
    return np.asarray(np.stack([low, high])[_ENDS, _AXES])
