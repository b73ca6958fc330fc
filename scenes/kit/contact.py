"""Floors that are finer where something stands, so that baked light can darken them there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay

from .mesh import Array, Mesh

TOUCHING_M = 0.06
"""What is lower than this touches the floor."""
TOGETHER_M = 0.12
"""Footprints closer than this count as one."""
RINGS_M = (-0.02, 0.14, 0.4)
"""Distances from a footprint's outline at which a floor has vertices."""


def outlines(meshes: Iterable[Mesh]) -> list[Array]:
    """Return the convex outlines, (n, 2) x and z each, of where meshes meet the floor y = 0."""
    waiting = [hull for mesh in meshes for hull in _footprints(mesh)]
    found: list[Array] = []
    while waiting:
        hull = waiting.pop()
        near = [_gap_m(hull, other) < TOGETHER_M for other in found]
        if any(near):
            together = [other for other, joins in zip(found, near, strict=True) if joins]
            waiting.append(convex_hull(np.concatenate([hull, *together])))
            found = [other for other, joins in zip(found, near, strict=True) if not joins]
        else:
            found.append(hull)
    return [simplified(hull) for hull in found]


def _footprints(mesh: Mesh) -> list[Array]:
    """Return the hull of the low vertices of each connected part."""
    _, place = np.unique(np.round(mesh.positions, 4), axis=0, return_inverse=True)
    corners = place.reshape(-1)[mesh.indices]
    count = int(place.max()) + 1
    links = coo_array(
        (np.ones(2 * len(corners)), (corners[:, :2].ravel(), corners[:, 1:].ravel())),
        shape=(count, count),
    )
    part = connected_components(links, directed=False)[1][place.reshape(-1)]
    low = mesh.positions[:, 1] < TOUCHING_M
    hulls = [
        convex_hull(mesh.positions[low & (part == one)][:, [0, 2]]) for one in np.unique(part[low])
    ]
    return [hull for hull in hulls if len(hull) > 2]


def convex_hull(points: Array) -> Array:
    """Return the corners of the convex hull of (n, 2) points (Andrew's monotone chain)."""
    ordered = np.unique(np.round(points, 4), axis=0)

    def chain(places: Array) -> list[Array]:
        corners: list[Array] = []
        for place in places:
            while len(corners) > 1 and _turn(corners[-2], corners[-1], place) <= 1e-9:
                corners.pop()
            corners.append(place)
        return corners[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1])).reshape(-1, 2)


def _turn(a: Array, b: Array, c: Array) -> float:
    """Return twice the signed area of a triangle."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _gap_m(a: Array, b: Array) -> float:
    """Return about how far apart two outlines are."""
    if (a.min(axis=0) > b.max(axis=0) + 1).any() or (b.min(axis=0) > a.max(axis=0) + 1).any():
        return np.inf
    one, other = (spaced(outline, 0.05) for outline in (a, b))
    return float(np.linalg.norm(one[:, None] - other[None], axis=2).min())


def simplified(outline: Array, *, most: int = 8, least_m2: float = 0.004) -> Array:
    """Return the outline without the corners that matter least."""
    corners = outline
    while len(corners) > 3:
        before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
        cut_m2 = [abs(_turn(*three)) / 2 for three in zip(before, corners, after, strict=True)]
        least = int(np.argmin(cut_m2))
        if len(corners) <= most and cut_m2[least] > least_m2:
            break
        corners = np.delete(corners, least, axis=0)
    return corners


def spaced(outline: Array, step_m: float) -> Array:
    """Return the outline's corners, and points between them at most `step_m` apart."""
    parts = []
    for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        count = max(1, int(np.ceil(np.linalg.norm(b - a) / step_m)))
        parts.append(a + (b - a) * (np.arange(count) / count)[:, None])
    return np.concatenate(parts)


def rings(outline: Array) -> Array:
    """Return floor points around an outline, at each distance of `RINGS_M`."""
    places = spaced(outline, 0.7)
    along = np.roll(places, -1, axis=0) - np.roll(places, 1, axis=0)
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return np.concatenate([places + outward * distance for distance in RINGS_M])


def refined(coarse: Array, border: NDArray[np.bool_], around: Sequence[Array]) -> Array:
    """Return (n, 2) places: coarse ones, which make room for rings around the outlines.

    Those of the `border` stay, so that neighbouring floors still meet; rings end at it.
    """
    inside = Delaunay(coarse)
    near = [ring for ring in map(rings, around) if (inside.find_simplex(ring) >= 0).any()]
    if not near:
        return coarse
    fine = np.concatenate(near)
    fine = fine[(inside.find_simplex(fine) >= 0) & (_nearest_m(fine, coarse[border]) > 0.08)]
    kept = border | (_nearest_m(coarse, fine) > 0.28)
    return np.concatenate([coarse[kept], fine])


def _nearest_m(places: Array, others: Array) -> Array:
    return np.asarray(np.linalg.norm(places[:, None] - others[None], axis=2).min(axis=1))


def triangulated(places: Array) -> NDArray[np.int64]:
    """Return (m, 3) indices of the Delaunay triangles of (n, 2) x and z, facing up."""
    indices = Delaunay(places).simplices.astype(np.int64)
    a, b, c = np.moveaxis(places[indices], 1, 0)
    up = (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]) - (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1])
    facing = np.where((up > 0)[:, None], indices, indices[:, ::-1])
    return np.asarray(facing[np.abs(up) > 1e-6])


def floor(x: Array, z: Array, around: Sequence[Array], *, uv_m: float) -> Mesh:
    """Return a level floor at y = 0 over a grid, finer around the outlines."""
    grid_x, grid_z = (axis.ravel() for axis in np.meshgrid(x, z))
    border = np.isin(grid_x, x[[0, -1]]) | np.isin(grid_z, z[[0, -1]])
    places = refined(np.stack([grid_x, grid_z], axis=1), border, around)
    positions = np.stack([places[:, 0], 0 * places[:, 0], places[:, 1]], axis=1)
    up = np.broadcast_to([0.0, 1.0, 0.0], positions.shape)
    return Mesh(positions, up, places / uv_m, triangulated(places))
