"""The first hit of a ray in a scene, on the CPU: for a line of sight, not for pictures."""

from __future__ import annotations

import math
from operator import mul
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose
from vrcomfort.scene.data import Primitive, Scene
from vrcomfort.scene.node_poses import NodePoses

# Smaller determinants are of rays along the plane of a triangle.
_PARALLEL = 1e-12
_FLAT = 1e-12
"""Smaller volumes are those of a node that is scaled to nothing."""
_ROUNDED = 1 + 1e-6
"""Factor that keeps rounding inside of a sphere."""
_CELL = 32
"""Triangles that lie near each other and share a box."""
_BLOCK = 32
"""Cells that lie near each other and share a box."""
# Of each axis: 1024 steps across the triangles, 30 bits in all.
_MORTON_BITS = 10


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


class _Triangles(NamedTuple):
    """Triangles in cells of `_CELL`, which a ray meets by their boxes.

    Parameters
    ----------
    corner, edge_1, edge_2
        (cells, _CELL, 3); a cell that is not full repeats its last triangle.
    both_sides
        (cells, _CELL) True where the back is seen, too.
    node
        (cells, _CELL) index of the node.
    low, high
        (3, cells) of the boxes.
    block_low, block_high
        (3, blocks) of the boxes around `_BLOCK` cells each.
    """

    corner: Array
    edge_1: Array
    edge_2: Array
    both_sides: NDArray[np.bool_]
    node: NDArray[np.intp]
    low: Array
    high: Array
    block_low: Array
    block_high: Array

    @classmethod
    def of(
        cls, corners: Array, both_sides: NDArray[np.bool_], node: NDArray[np.intp]
    ) -> _Triangles:
        """Put (m, 3, 3) triangles into cells."""
        order = np.argsort(_morton(corners.mean(axis=1)), kind="stable")
        cells = -(-len(order) // _CELL)
        order = np.pad(order, (0, cells * _CELL - len(order)), mode="edge").reshape(cells, _CELL)
        placed = corners[order]
        corner = placed[:, :, 0]
        low = np.ascontiguousarray(placed.min(axis=(1, 2)).T)
        high = np.ascontiguousarray(placed.max(axis=(1, 2)).T)
        blocks = np.arange(0, cells, _BLOCK)
        return cls(
            corner,
            placed[:, :, 1] - corner,
            placed[:, :, 2] - corner,
            both_sides[order],
            node[order],
            low,
            high,
            np.minimum.reduceat(low, blocks, axis=1),
            np.maximum.reduceat(high, blocks, axis=1),
        )

    def _cells_met(self, origin: Array, along: Array) -> NDArray[np.intp]:
        """Return the indices of cells with boxes that a ray hits, ascending."""
        blocks = np.flatnonzero(_meets(self.block_low, self.block_high, origin, along))
        near = (blocks[:, None] * _BLOCK + np.arange(_BLOCK)).ravel()
        near = near[near < self.low.shape[1]]
        met: NDArray[np.intp] = near[_meets(self.low[:, near], self.high[:, near], origin, along)]
        return met

    def nearest(self, origin: Array, along: Array, *, mirrored: bool = False) -> tuple[float, int]:
        """Return the distance to the first triangle and its node; infinite without one."""
        met = self._cells_met(origin, along)
        if not met.size:
            return np.inf, -1
        corner, edge_1, edge_2 = (
            each[met].reshape(-1, 3) for each in (self.corner, self.edge_1, self.edge_2)
        )
        both_sides = self.both_sides[met].ravel()
        away = _distances(corner, edge_1, edge_2, both_sides, origin, along, mirrored=mirrored)
        first = int(np.argmin(away))
        away_m = float(away[first])
        return away_m, int(self.node[met].ravel()[first]) if away_m < np.inf else -1


class _Ball(NamedTuple):
    """A sphere in the world."""

    middle_m: tuple[float, ...]
    radius_m: float

    def meets(self, ray: Pose) -> bool:
        """Return whether the sphere is around, or ahead on, a ray."""
        away = [m - o for m, o in zip(self.middle_m, ray.numbers, strict=False)]
        along = ray.forward.tolist()
        ahead = max(sum(map(mul, away, along)), 0.0)
        return math.dist(away, [ahead * each for each in along]) <= self.radius_m


def _ball_of_turns(scene: Scene, index: int, world: Array) -> _Ball | None:
    """Return a sphere that holds a node at all times; None of one that does more than turn."""
    node = scene.nodes[index]
    paths = {
        channel.path
        for animation in scene.animations
        for channel in animation.channels
        if channel.node == index
    }
    carried = node.parent >= 0 and scene.nodes[node.parent].moving
    if carried or node.matrix is not None or paths != {"rotation"}:
        return None
    place = world[node.parent] if node.parent >= 0 else np.eye(4)
    middle = place[:3, :3] @ node.translation + place[:3, 3]
    parts = [scene.primitives[k].positions * node.scale for k in node.mesh]
    reach = max(float(np.linalg.norm(each, axis=1).max()) for each in parts)
    widest = float(np.linalg.norm(place[:3, :3], 2))
    return _Ball(tuple(middle.tolist()), reach * widest * _ROUNDED)


class RayCaster:
    """Casts rays into a scene. Nodes on the head or a hand are invisible to it.

    Nodes are taken at their finest level of detail. MASK surfaces count where they are
    transparent, too; BLEND surfaces, as glass, never do. Skins are not bent.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._poses = NodePoses(scene)
        world = self._poses.world_from_node(0.0, Pose())
        solid = [
            index
            for index, node in enumerate(scene.nodes)
            if not self._poses.locked[index] and any(_solid(scene, k) for k in node.mesh)
        ]
        still = [_surface(scene, k, world[k]) for k in solid if not scene.nodes[k].moving]
        self._still = (
            _Triangles.of(*map(np.concatenate, zip(*still, strict=True))) if still else None
        )
        moving = [index for index in solid if scene.nodes[index].moving]
        self._moving = {k: _Triangles.of(*_surface(scene, k, np.eye(4))) for k in moving}
        self._boxes = {k: _box(each) for k, each in self._moving.items()}
        self._turning = {k: _ball_of_turns(scene, k, world) for k in moving}

    def cast(self, ray: Pose, time_s: float = 0.0) -> RayHit:
        """Return the first hit along −Z of world-from-ray at a time of the scene."""
        origin, along = ray.position, ray.forward
        found = np.inf, -1
        if self._still is not None:
            found = self._still.nearest(origin, along)
        near = [k for k, ball in self._turning.items() if ball is None or ball.meets(ray)]
        if near:
            world = self._poses.world_from_node(time_s, Pose())
            for index in near:
                triangles = self._moving[index]
                if not _passes_near(*self._boxes[index], world[index], origin, along):
                    continue
                # Distances along a ray are the same in a node's own frame, where nothing moves.
                volume = np.linalg.det(world[index, :3, :3])
                if abs(volume) < _FLAT:
                    continue
                own = np.linalg.inv(world[index])
                start, way = own[:3, :3] @ origin + own[:3, 3], own[:3, :3] @ along
                found = min(found, triangles.nearest(start, way, mirrored=bool(volume < 0)))
        return RayHit(found[0], self._scene.nodes[found[1]].name) if found[1] >= 0 else NOTHING


def _solid(scene: Scene, primitive: int) -> bool:
    surface = scene.primitives[primitive]
    return len(surface.indices) > 0 and scene.materials[surface.material].alpha_mode != "BLEND"


def _surface(
    scene: Scene, index: int, place: Array
) -> tuple[Array, NDArray[np.bool_], NDArray[np.intp]]:
    """Return a node's (m, 3, 3) triangles, which are seen from both sides, and (m,) its index."""
    parts = [scene.primitives[k] for k in scene.nodes[index].mesh if _solid(scene, k)]
    mirrored = np.linalg.det(place[:3, :3]) < 0
    corners = np.concatenate([_corners(part, place, mirrored) for part in parts])
    sides = [scene.materials[part.material].double_sided for part in parts]
    both = np.repeat(sides, [len(part.indices) for part in parts])
    return corners, both, np.full(len(corners), index)


def _corners(part: Primitive, place: Array, mirrored: bool) -> Array:
    placed = part.positions @ place[:3, :3].T + place[:3, 3]
    corners: Array = placed[part.indices]
    return corners[:, ::-1] if mirrored else corners


def _morton(points: Array) -> NDArray[np.uint64]:
    """Return (m,) places on a space-filling curve (Morton 1966), on which neighbours are near."""
    low, size = points.min(axis=0), np.maximum(np.ptp(points, axis=0).max(), 1e-9)
    steps = ((points - low) / size * (2**_MORTON_BITS - 1)).astype(np.uint64)
    code = np.zeros(len(points), dtype=np.uint64)
    for bit in range(_MORTON_BITS):
        for axis in range(3):
            picked = (steps[:, axis] >> np.uint64(bit)) & np.uint64(1)
            code |= picked << np.uint64(3 * bit + axis)
    return code


def _meets(low: Array, high: Array, origin: Array, along: Array) -> NDArray[np.bool_]:
    """Return (n,) True for each of (3, n) boxes that a ray meets."""
    start, way = origin[:, None], along[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        to_low, to_high = (low - start) / way, (high - start) / way
    # NaN: the ray runs within the plane of a side, which then excludes nothing.
    first = np.fmax(np.fmax.reduce(np.fmin(to_low, to_high), axis=0), 0.0)
    last = np.fmin(np.fmin.reduce(np.fmax(to_low, to_high), axis=0), np.inf)
    met: NDArray[np.bool_] = np.asarray(last >= first)
    return met


def _box(triangles: _Triangles) -> tuple[Array, Array]:
    """Return the middle of a box around triangles, and its half edges as a (3, 3) diagonal."""
    low, high = triangles.low.min(axis=1), triangles.high.max(axis=1)
    return (low + high) / 2, np.diag((high - low) / 2)


def _passes_near(middle: Array, edges: Array, world: Array, origin: Array, along: Array) -> bool:
    """Return whether a ray meets the sphere around a box that `world` places."""
    to_middle = world[:3, :3] @ middle + world[:3, 3] - origin
    half = world[:3, :3] @ edges
    reach = float(np.abs(half).sum(axis=1) @ np.abs(half).sum(axis=1))
    ahead = max(float(to_middle @ along), 0.0)
    off = to_middle - ahead * along
    return float(off @ off) <= reach


def _cross(a: Array, b: Array) -> Array:
    """Return the cross product along the last axis; np.cross, which moves axes, is slower."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx), axis=-1)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b))


def _distances(
    corner: Array,
    edge_1: Array,
    edge_2: Array,
    both_sides: NDArray[np.bool_],
    origin: Array,
    along: Array,
    *,
    mirrored: bool,
) -> Array:
    """Return (m,) how far each triangle is (Möller & Trumbore 1997), infinite where it is missed.

    `mirrored`: the ray is in a frame that mirrors the world, where fronts are backs.
    """
    across = _cross(along, edge_2)
    faces = _dot(edge_1, across)  # positive: seen from the front, but for a mirror
    seen = np.where(both_sides, np.abs(faces), -faces if mirrored else faces) > _PARALLEL
    from_corner = origin - corner
    turned = _cross(from_corner, edge_1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = _dot(from_corner, across) / faces
        v = (turned @ along) / faces
        away = _dot(edge_2, turned) / faces
        met = seen & (u >= 0) & (v >= 0) & (u + v <= 1) & (away > 0)
    return np.where(met, away, np.inf)
