"""Where to stand in a scene that does not say so."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.frame import EYE_HEIGHT_M
from vrcomfort.geometry import Array, Pose
from vrcomfort.scene.boxes import box_corners
from vrcomfort.scene.data import Scene, WalkableArea

Mask: TypeAlias = NDArray[np.bool_]
Corners: TypeAlias = Array
"""(draws, 3, 8) corners of the world-space box around everything that is drawn."""

#: A scene at least this wide both ways is a place to stand in; a smaller one is looked at.
ROOM_M = 6.0
HELD_M = 1.0
"""A smaller thing is looked at as if it were held up, not as if it lay on the floor."""
VIEW = math.tan(math.radians(30.0))
"""What is looked at lies within this tangent of straight ahead, which every headset shows."""
# From the eyes to the near side of a small scene.
NEAREST_M = 0.5
# A level with less above it is no floor to stand on.
HEADROOM_M = 2.0
FLAT = 0.5
"""Ground is less high than this share of its narrower side; anything else is a thing."""


def with_defaults(scene: Scene) -> Scene:
    """Return the scene with a spawn point and a walkable rectangle made from its bounds.

    A place is entered at its middle, on the lowest floor there that one can stand on; anything
    else is looked at from its +Z side, from so far away that all of it is in view. That is as it
    is at time zero.
    """
    corners = _corners_of_draws(scene)
    lower, upper = _bounds(corners)
    size, middle = upper - lower, (lower + upper) / 2
    is_place = min(size[0], size[2]) >= ROOM_M
    floor_m = _floor(scene, corners, middle) if is_place else None
    if floor_m is not None:
        stand, margin_m = np.array([middle[0], floor_m, middle[2]]), 0.0
    else:
        stand = _in_front(lower, upper)
        margin_m = (stand[2] - upper[2]) / 2
    near = np.minimum(lower, stand)[[0, 2]] - margin_m
    far = np.maximum(upper, stand)[[0, 2]] + margin_m
    rectangle = np.array([near, [far[0], near[1]], far, [near[0], far[1]]])
    walkable = (WalkableArea(rectangle, float(stand[1])),)
    return replace(scene, spawn=Pose(stand), walkable=walkable)


def world_bounds(scene: Scene) -> tuple[Array, Array]:
    """Return the (3,) corners of the box around everything drawn at time zero."""
    return _bounds(_corners_of_draws(scene))


def _bounds(corners: Corners) -> tuple[Array, Array]:
    return corners.min(axis=(0, 2)), corners.max(axis=(0, 2))


def _in_front(lower: Array, upper: Array) -> Array:
    """Return the (3,) floor point from which eyes that look ahead have a box in view."""
    centre, size = (lower + upper) / 2, upper - lower
    floor_m = lower[1] if size.max() >= HELD_M else centre[1] - EYE_HEIGHT_M
    eyes_m = floor_m + EYE_HEIGHT_M
    aside_m = max(size[0] / 2, upper[1] - eyes_m, eyes_m - lower[1])
    return np.array([centre[0], floor_m, upper[2] + max(aside_m / VIEW, NEAREST_M)])


def _floor(scene: Scene, corners: Corners, middle: Array) -> float | None:
    """Return the height of the lowest floor under or over a point that has room for a head.

    Where nothing is drawn over or under the point, that is where the scene begins. The top of a
    thing is no floor, as nothing of the thing is seen from there; None where there is only that.
    """
    heights: list[float] = []
    levels: list[float] = []
    tops_m = _tops_m(corners)
    over = (corners.min(axis=2) <= middle)[:, [0, 2]] & (corners.max(axis=2) >= middle)[:, [0, 2]]
    world = scene.world_from_node(0.0)
    for draw, (node, index) in enumerate(_draws(scene)):
        if over[draw].all():
            positions = scene.positions(node, index, 0.0)
            triangles = scene.primitives[index].indices
            found, faces_up = _heights(positions, triangles, world[node], middle)
            heights += found.tolist()
            both = scene.materials[scene.primitives[index].material].double_sided
            levels += found[(faces_up | both) & (found < tops_m[draw])].tolist()
    above = np.array([*heights, np.inf])
    for level in sorted(levels):
        overhead = above[above > level + 1e-3 * HEADROOM_M]
        if overhead.min() - level >= HEADROOM_M:
            return level
    return None if heights else float(corners[:, 1].min())


def _tops_m(corners: Corners) -> Array:
    """Return the height from which on a draw is a top, shape (draws,): ∞ where it is flat."""
    lower, upper = corners.min(axis=2), corners.max(axis=2)
    width, height, depth = (upper - lower).T
    flat = height < FLAT * np.minimum(width, depth)
    return np.where(flat, np.inf, (lower + upper)[:, 1] / 2)


def _heights(
    positions: Array, indices: NDArray[np.uint32], world_from_node: Array, middle: Array
) -> tuple[Array, Mask]:
    """Return the heights at which triangles meet the vertical line through a point.

    Returns
    -------
    heights, faces_up
        (k,) metres, and (k,) bool.
    """
    found = [
        _heights_of(positions[triangles], world_from_node, middle)
        for triangles in np.array_split(indices, len(indices) // 2**16 + 1)
    ]
    heights, faces_up = zip(*found, strict=True)
    return np.concatenate(heights), np.concatenate(faces_up)


def _heights_of(triangles: Array, world_from_node: Array, middle: Array) -> tuple[Array, Mask]:
    """Return the same of (m, 3, 3) corners in the node's frame."""
    world = triangles @ world_from_node[:3, :3].T + world_from_node[:3, 3]
    a, b, c = np.moveaxis(world - middle * [1.0, 0.0, 1.0], 1, 0)
    # Barycentric coordinates by the areas that the point spans with each edge, seen from above.
    areas = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)])
    total = areas.sum(axis=0)
    hit = (total != 0) & ((areas >= 0).all(axis=0) | (areas <= 0).all(axis=0))
    weights = areas[:, hit] / total[hit]
    heights = (weights * np.stack([a, b, c])[:, hit, 1]).sum(axis=0)
    # Counter-clockwise from above is clockwise in x and z, unless the node mirrors.
    mirrored = np.linalg.det(world_from_node[:3, :3]) < 0
    return heights, (total[hit] < 0) != mirrored


def _cross(a: Array, b: Array) -> Array:
    """Return x₁z₂ − z₁x₂ of (n, 3) points."""
    return np.asarray(a[:, 0] * b[:, 2] - a[:, 2] * b[:, 0])


def _draws(scene: Scene) -> list[tuple[int, int]]:
    """Return (node, primitive) of everything that is drawn."""
    return [(place, index) for place, node in enumerate(scene.nodes) for index in node.mesh]


def _corners_of_draws(scene: Scene) -> Corners:
    world = scene.world_from_node(0.0)
    boxes = [box_corners(*primitive.bounds) for primitive in scene.primitives]
    corners = [
        world[node, :3, :3]
        @ (boxes[index] if scene.nodes[node].skin is None else _bent_box(scene, node, index))
        + world[node, :3, 3:]
        for node, index in _draws(scene)
    ]
    return np.array(corners) if corners else np.zeros((1, 3, 8))


def _bent_box(scene: Scene, node: int, index: int) -> Array:
    positions = scene.positions(node, index, 0.0)
    return box_corners(positions.min(axis=0), positions.max(axis=0))
