"""Light that does not move, baked into vertices: how open a place is to the sky and around.

The scene is cut into cubes; from every vertex, rays march through them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .mesh import Array, Mesh, unit

RAYS = 28
LEAST_OPEN = 0.25
"""Openness of a place in a cranny that is narrower than a cube: it is dark, but never black."""


@dataclass(frozen=True)
class Voxels:
    """Which cubes hold a surface; a border of empty cubes surrounds them."""

    lower: Array
    cell_m: float
    solid: NDArray[np.bool_]


def voxelise(meshes: list[Mesh], cell_m: float) -> Voxels:
    """Return the cubes that the meshes' triangles pass through."""
    points = [_points_on(mesh, cell_m * 0.7) for mesh in meshes]
    lower = np.min([p.min(axis=0) for p in points], axis=0) - cell_m
    upper = np.max([p.max(axis=0) for p in points], axis=0)
    shape = np.floor((upper - lower) / cell_m).astype(int) + 3
    solid = np.zeros(int(np.prod(shape)), bool)
    for place in points:
        index = ((place - lower) / cell_m).astype(np.int32)
        solid[(index[:, 0] * shape[1] + index[:, 1]) * shape[2] + index[:, 2]] = True
    return Voxels(lower, cell_m, solid.reshape(shape))


def _points_on(mesh: Mesh, step_m: float) -> Array:
    """Return points that cover all triangles at about `step_m`."""
    a, b, c = np.moveaxis(mesh.positions[mesh.indices], 1, 0)
    longest = np.max([np.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)], axis=0)
    power = np.ceil(np.log2(np.maximum(longest / step_m, 1))).astype(int)
    parts = []
    for count in np.unique(power):
        mine = np.flatnonzero(power == count)
        i, j = np.meshgrid(np.arange(2**count + 1), np.arange(2**count + 1))
        s, t = (x[(i + j) <= 2**count] / 2**count for x in (i, j))
        edge1, edge2 = (b - a)[mine], (c - a)[mine]
        points = a[mine][:, None] + s[:, None] * edge1[:, None] + t[:, None] * edge2[:, None]
        parts.append(points.reshape(-1, 3))
    return np.concatenate(parts)


def _directions() -> Array:
    """Return RAYS cosine-weighted directions about +Z (a golden spiral)."""
    i = np.arange(RAYS) + 0.5
    r, angle = np.sqrt(i / RAYS), i * np.pi * (3 - np.sqrt(5))
    return np.stack([r * np.cos(angle), r * np.sin(angle), np.sqrt(1 - r * r)], axis=1)


def openness(
    voxels: Voxels, points: Array, normals: Array, *, reach_m: float, far_m: float
) -> tuple[Array, Array]:
    """Return for each place its share of free rays (within `reach_m`) and of rays to the sky."""
    n = unit(normals)
    side = unit(np.cross(n, np.where(np.abs(n[:, :1]) < 0.9, [1.0, 0, 0], [0, 0, 1.0])))
    frame = np.stack([side, np.cross(n, side), n], axis=2)
    directions = (frame @ _directions().T).transpose(0, 2, 1).reshape(-1, 3) / voxels.cell_m
    start = np.repeat(
        (points + n * voxels.cell_m * 1.3 - voxels.lower) / voxels.cell_m, RAYS, axis=0
    )
    free, sky = np.full(len(start), far_m), np.zeros(len(start), bool)
    shape = np.array(voxels.solid.shape, np.int32)
    flat = voxels.solid.reshape(-1)
    distance, alive = 0.0, np.arange(len(start))
    while distance < far_m and len(alive):
        distance += voxels.cell_m * (0.9 if distance < reach_m else 1.5)
        place = start[alive] + directions[alive] * distance
        x, y, z = ((place >= 0) & (place < shape)).T  # three columns are faster than `all`
        inside = x & y & z
        index = np.where(inside[:, None], place, 0).astype(np.int32)
        solid = flat[(index[:, 0] * shape[1] + index[:, 1]) * shape[2] + index[:, 2]] & inside
        free[alive[solid]] = distance
        sky[alive[~inside]] = directions[alive[~inside], 1] > -0.05 / voxels.cell_m
        alive = alive[inside & ~solid]
    near = np.minimum(free / reach_m, 1.0).reshape(-1, RAYS).mean(axis=1)
    return np.maximum(near, LEAST_OPEN), sky.reshape(-1, RAYS).mean(axis=1)


def darkened(voxels: Voxels, mesh: Mesh, *, reach_m: float = 0.7) -> Mesh:
    """Return an open ground, darkened in all its light where something stands near."""
    near, _ = openness(voxels, mesh.positions, mesh.normals, reach_m=reach_m, far_m=reach_m)
    rgba = mesh.rgba.copy()
    rgba[:, :3] *= (0.55 + 0.45 * near)[:, None]
    rgba[:, 3] *= near
    return replace(mesh, colors=rgba)


def baked(
    voxels: Voxels, mesh: Mesh, *, bounce: Array, reach_m: float = 0.7, far_m: float = 12.0
) -> Mesh:
    """Return the mesh with occlusion in its vertex colours and ambient light in their alpha.

    `bounce` is, for each vertex, the light (share of the sky's) that walls around give back.
    """
    places = np.concatenate([mesh.positions, mesh.normals], axis=1)
    _, first, back = np.unique(
        np.round(places * 200), axis=0, return_index=True, return_inverse=True
    )
    near, sky = openness(
        voxels, mesh.positions[first], mesh.normals[first], reach_m=reach_m, far_m=far_m
    )
    near, sky = near[back.reshape(-1)], sky[back.reshape(-1)]
    rgba = mesh.rgba.copy()
    rgba[:, :3] *= (0.55 + 0.45 * near)[:, None]
    rgba[:, 3] = np.clip(near * (sky + (1 - sky) * bounce), 0, 1)
    return replace(mesh, colors=rgba)
