"""Triangle meshes and the shapes that the scenes are made of. Metres, +Y up."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class Mesh:
    """(n, 3) positions and normals, (n, 2) uvs, (n, 4) colours, (m, 3) indices."""

    positions: Array
    normals: Array
    uvs: Array
    indices: NDArray[np.int64]
    colors: Array | None = None

    def at(self, x: float = 0, y: float = 0, z: float = 0) -> Mesh:
        """Return the mesh moved."""
        return replace(self, positions=self.positions + np.array([x, y, z]))

    def turned(self, axis: str, degrees: float) -> Mesh:
        """Return the mesh turned about an axis through the origin."""
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        matrix = {
            "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
            "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
        }[axis]
        m = np.array(matrix)
        return replace(self, positions=self.positions @ m.T, normals=self.normals @ m.T)

    def scaled(self, x: float, y: float | None = None, z: float | None = None) -> Mesh:
        """Return the mesh scaled (evenly if only `x` is given)."""
        s = np.array([x, x if y is None else y, x if z is None else z])
        normals = unit(self.normals / s)
        indices = self.indices if np.prod(s) > 0 else self.indices[:, ::-1]
        return replace(self, positions=self.positions * s, normals=normals, indices=indices)

    def tinted(self, color: ArrayLike) -> Mesh:
        """Return the mesh with vertex colours multiplied by a linear RGB or RGBA colour."""
        rgba = np.ones(4)
        given = np.asarray(color, dtype=np.float64)
        rgba[: len(given)] = given
        return replace(self, colors=self.rgba * rgba)

    def mapped(
        self, scale_u: float = 1.0, scale_v: float = 1.0, u: float = 0, v: float = 0
    ) -> Mesh:
        """Return the mesh with texture coordinates scaled, then shifted."""
        return replace(self, uvs=self.uvs * [scale_u, scale_v] + [u, v])

    def bent(self, displace: Callable[[Array], Array]) -> Mesh:
        """Return the mesh with displaced positions and new smooth normals."""
        return smooth(replace(self, positions=displace(self.positions)))

    @property
    def rgba(self) -> Array:
        """Return (n, 4) vertex colours, white where there are none."""
        return np.ones((len(self.positions), 4)) if self.colors is None else self.colors


def unit(vectors: Array) -> Array:
    """Return vectors of length one (zero vectors become +Y)."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-12), [0.0, 1.0, 0.0])


def join(meshes: Sequence[Mesh]) -> Mesh:
    """Return one mesh of several."""
    starts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes])
    return Mesh(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.uvs for mesh in meshes]),
        np.concatenate([mesh.indices + start for mesh, start in zip(meshes, starts, strict=False)]),
        np.concatenate([mesh.rgba for mesh in meshes]),
    )


def smooth(mesh: Mesh, crease_deg: float = 180.0) -> Mesh:
    """Return the mesh with area-weighted normals, shared between vertices at the same place.

    Faces that differ by more than `crease_deg` from a vertex's own first face do not contribute.
    """
    a, b, c = np.moveaxis(mesh.positions[mesh.indices], 1, 0)
    face = np.cross(b - a, c - a)
    keys = np.round(mesh.positions * 1e5).astype(np.int64)
    _, place = np.unique(keys, axis=0, return_inverse=True)
    place = place.reshape(-1)
    if crease_deg >= 180.0:
        total = np.zeros((place.max() + 1, 3))
        for corner in range(3):
            np.add.at(total, place[mesh.indices[:, corner]], face)
        return replace(mesh, normals=unit(total)[place])
    return _creased(mesh, unit(face), face, place, np.cos(np.radians(crease_deg)))


def _creased(
    mesh: Mesh, direction: Array, face: Array, place: NDArray[np.int64], cosine: float
) -> Mesh:
    """Split all corners; each takes the faces around its place that are nearly its own."""
    corners = mesh.indices.ravel()
    order = np.argsort(place[corners], kind="stable")
    owner = order // 3
    starts = np.flatnonzero(np.diff(place[corners][order], prepend=-1))
    size = np.diff(np.append(starts, len(order)))
    start, size = np.repeat(starts, size), np.repeat(size, size)
    within = np.arange(len(order)) - start
    total = np.zeros((len(order), 3))
    for shift in range(int(size.max())):
        other = owner[start + (within + shift) % size]
        near = (np.einsum("ij,ij->i", direction[owner], direction[other]) >= cosine) & (
            shift < size
        )
        total += np.where(near[:, None], face[other], 0)
    normals = np.empty_like(total)
    normals[order] = unit(total)
    split = Mesh(
        mesh.positions[corners],
        normals,
        mesh.uvs[corners],
        np.arange(len(corners)).reshape(-1, 3),
        mesh.rgba[corners],
    )
    return welded(split)


def welded(mesh: Mesh) -> Mesh:
    """Return the mesh with equal vertices merged."""
    columns = [mesh.positions, mesh.normals, mesh.uvs, mesh.rgba]
    keys = np.round(np.concatenate(columns, axis=1) * 2e3).astype(np.int64)
    _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return Mesh(
        mesh.positions[first],
        mesh.normals[first],
        mesh.uvs[first],
        index.reshape(-1)[mesh.indices],
        mesh.rgba[first],
    )


def grid(points: Array, uvs: Array, *, flip: bool = False) -> Mesh:
    """Return a mesh of a (rows, columns, 3) sheet of points; front is d/column × d/row."""
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    quads = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    positions = points.reshape(-1, 3)
    face = quads[:, ::-1] if flip else quads
    p = positions[face]
    solid = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1) > 1e-10
    return smooth(Mesh(positions, np.zeros_like(positions), uvs.reshape(-1, 2), face[solid]))


def numbers(text: str) -> list[tuple[float, ...]]:
    """Return rows of numbers: ``"0 1, 2 3"`` gives [(0.0, 1.0), (2.0, 3.0)]."""
    return [tuple(float(word) for word in row.split()) for row in text.split(",")]
