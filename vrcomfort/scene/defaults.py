"""Where to stand in a scene that does not say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vrcomfort.geometry import Array, Pose
from vrcomfort.scene.data import Scene, WalkableArea

#: A scene at least this wide both ways is a place to stand in; a smaller one is looked at.
ROOM_M = 6.0


def with_defaults(scene: Scene) -> Scene:
    """Return the scene with a spawn point and a walkable rectangle made from its bounds.

    A wide scene is entered at its middle, a small object is looked at from its +Z side;
    the floor is the bottom of the box around everything at time zero.
    """
    lower, upper = world_bounds(scene)
    centre, size = (lower + upper) / 2, upper - lower
    away_m = 0.0 if min(size[0], size[2]) >= ROOM_M else size[2] / 2 + 0.5 + max(size[0], size[1])
    stand = np.array([centre[0], lower[1], centre[2] + away_m])
    near = np.minimum(lower, stand)[[0, 2]] - away_m / 2
    far = np.maximum(upper, stand)[[0, 2]] + away_m / 2
    corners = np.array([near, [far[0], near[1]], far, [near[0], far[1]]])
    return replace(scene, spawn=Pose(stand), walkable=(WalkableArea(corners, float(lower[1])),))


def world_bounds(scene: Scene) -> tuple[Array, Array]:
    """Return the (3,) corners of the box around everything drawn at time zero."""
    world = scene.world_from_node(0.0)
    boxes = [_corners(*primitive.bounds) for primitive in scene.primitives]
    corners = [
        transform[:3, :3] @ boxes[index] + transform[:3, 3:]
        for node, transform in zip(scene.nodes, world, strict=True)
        for index in node.mesh
    ]
    every = np.concatenate(corners, axis=1) if corners else np.zeros((3, 1))
    return every.min(axis=1), every.max(axis=1)


def _corners(lower: Array, upper: Array) -> Array:
    """Return the (3, 8) corners of a box."""
    return np.array(np.meshgrid(*np.stack([lower, upper], axis=1))).reshape(3, 8)
