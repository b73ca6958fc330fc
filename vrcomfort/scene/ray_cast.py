"""The first hit of a ray in a scene, on the CPU: for a line of sight, not for pictures."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose
from vrcomfort.scene.data import Primitive, Scene
from vrcomfort.scene.node_poses import NodePoses

_PARALLEL = 1e-12


class RayHit(NamedTuple):
    """The first hit of a ray.

    Parameters
    ----------
    distance_m
        Along the ray; infinite where it meets nothing.
    node
        Name of the node; empty where it meets nothing.
    """

    distance_m: float
    node: str


NOTHING = RayHit(np.inf, "")


class _Surface(NamedTuple):
    """Triangles of a node in the world.

    Parameters
    ----------
    corners
        (m, 3, 3).
    both_sides
        (m,) True where the back is seen, too.
    low, high
        (3,) of the box around them.
    """

    corners: Array
    both_sides: NDArray[np.bool_]
    low: Array
    high: Array


class RayCaster:
    """Casts rays into a scene. Nodes on the head or a hand are invisible to it.

    Nodes are taken at their finest level of detail. MASK surfaces count where they are
    transparent, too; BLEND surfaces, as glass, never do. Skins are not bent.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._poses = NodePoses(scene)
        self._nodes = [
            index
            for index, node in enumerate(scene.nodes)
            if not self._poses.locked[index] and any(_solid(scene, k) for k in node.mesh)
        ]
        self._movers = [
            place for place, index in enumerate(self._nodes) if scene.nodes[index].moving
        ]
        self._kept: tuple[float, list[_Surface], Array, Array] | None = None

    def cast(self, ray: Pose, time_s: float = 0.0) -> RayHit:
        """Return the first hit along −Z of world-from-ray at a time of the scene."""
        surfaces, low, high = self._at(time_s)
        if not surfaces:
            return NOTHING
        origin, along = ray.position, ray.forward
        enters = _entries(low, high, origin, along)
        found = NOTHING
        for place in np.argsort(enters, kind="stable").tolist():
            if enters[place] > found.distance_m or not np.isfinite(enters[place]):
                break
            away_m = _nearest(surfaces[place], origin, along)
            if away_m < found.distance_m:
                found = RayHit(away_m, self._scene.nodes[self._nodes[place]].name)
        return found

    def _at(self, time_s: float) -> tuple[list[_Surface], Array, Array]:
        kept = self._kept
        if kept is None or (self._movers and kept[0] != time_s):
            world = self._poses.world_from_node(time_s, Pose())
            if kept is None:
                surfaces = [_surface(self._scene, index, world[index]) for index in self._nodes]
                low = np.array([each.low for each in surfaces]).reshape(-1, 3)
                high = np.array([each.high for each in surfaces]).reshape(-1, 3)
            else:
                _, surfaces, low, high = kept
                for place in self._movers:
                    index = self._nodes[place]
                    surfaces[place] = found = _surface(self._scene, index, world[index])
                    low[place], high[place] = found.low, found.high
            self._kept = kept = time_s, surfaces, low, high
        return kept[1:]


def _solid(scene: Scene, primitive: int) -> bool:
    surface = scene.primitives[primitive]
    return len(surface.indices) > 0 and scene.materials[surface.material].alpha_mode != "BLEND"


def _surface(scene: Scene, index: int, world_from_node: Array) -> _Surface:
    parts = [scene.primitives[k] for k in scene.nodes[index].mesh if _solid(scene, k)]
    mirrored = np.linalg.det(world_from_node[:3, :3]) < 0
    corners = np.concatenate([_corners(part, world_from_node, mirrored) for part in parts])
    sides = [scene.materials[part.material].double_sided for part in parts]
    both = np.repeat(sides, [len(part.indices) for part in parts])
    return _Surface(corners, both, corners.min(axis=(0, 1)), corners.max(axis=(0, 1)))


def _corners(part: Primitive, world_from_node: Array, mirrored: bool) -> Array:
    placed = part.positions @ world_from_node[:3, :3].T + world_from_node[:3, 3]
    corners: Array = placed[part.indices]
    return corners[:, ::-1] if mirrored else corners


def _entries(low: Array, high: Array, origin: Array, along: Array) -> Array:
    """Return (n,) where a ray enters each box, 0 inside of it, infinite where it misses."""
    with np.errstate(divide="ignore", invalid="ignore"):
        to_low, to_high = (low - origin) / along, (high - origin) / along
    first = np.nan_to_num(np.minimum(to_low, to_high), nan=-np.inf).max(axis=1)
    last = np.nan_to_num(np.maximum(to_low, to_high), nan=np.inf).min(axis=1)
    return np.where(last >= np.maximum(first, 0.0), np.maximum(first, 0.0), np.inf)


def _nearest(surface: _Surface, origin: Array, along: Array) -> float:
    """Return how far the first triangle is (Möller & Trumbore 1997), infinite without one."""
    a, b, c = surface.corners[:, 0], surface.corners[:, 1], surface.corners[:, 2]
    edge_1, edge_2 = b - a, c - a
    across = np.cross(along, edge_2)
    faces = (edge_1 * across).sum(axis=1)  # positive: seen from the front
    seen = np.where(surface.both_sides, np.abs(faces), faces) > _PARALLEL
    if not seen.any():
        return np.inf
    edge_1, edge_2, across, faces = edge_1[seen], edge_2[seen], across[seen], faces[seen]
    from_a = origin - a[seen]
    u = (from_a * across).sum(axis=1) / faces
    turned = np.cross(from_a, edge_1)
    v = (turned @ along) / faces
    away = (edge_2 * turned).sum(axis=1) / faces
    met = (u >= 0) & (v >= 0) & (u + v <= 1) & (away > 0)
    return float(away[met].min()) if met.any() else np.inf
