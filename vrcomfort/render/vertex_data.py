"""Vertices and indices of a scene as the GPU reads them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vrcomfort.scene.data import Primitive

_VERTEX = np.dtype(
    [
        ("position", np.float32, 3),
        ("normal", np.float16, 4),
        ("uv", np.float32, 2),
        ("color", np.float16, 4),
    ]
)
VERTEX_FORMAT = "3f4 4f2 2f4 4f2"
SECOND_UV_FORMAT = "2f4"
SECOND_UV_NAMES = ("in_uv_1",)
VERTEX_NAMES = ("in_position", "in_normal", "in_uv", "in_color")


def vertex_bytes(primitives: tuple[Primitive, ...]) -> bytes:
    """Return the vertices of all primitives, one after the other."""
    return b"".join(_packed(primitive).tobytes() for primitive in primitives) or bytes(64)


def _packed(primitive: Primitive) -> NDArray[np.void]:
    vertices = np.zeros(len(primitive.positions), _VERTEX)
    vertices["position"] = primitive.positions
    vertices["normal"][:, :3] = primitive.normals
    vertices["uv"] = primitive.uvs
    vertices["color"] = 1 if primitive.colors is None else primitive.colors
    return vertices


def second_uv_bytes(primitives: tuple[Primitive, ...]) -> bytes | None:
    """Return the second texture coordinates of all vertices, or None where no primitive has any."""
    if all(primitive.uvs_1 is None for primitive in primitives):
        return None
    return b"".join(
        np.asarray(np.zeros_like(p.uvs) if p.uvs_1 is None else p.uvs_1, np.float32).tobytes()
        for p in primitives
    )


_BENDING = np.dtype([("joints", np.uint16, 4), ("weights", np.float32, 4)])
BENDING_FORMAT = "4u2 4f4"
BENDING_NAMES = ("in_joints", "in_weights")


def bending_bytes(primitives: tuple[Primitive, ...]) -> bytes | None:
    """Return joints and weights of all vertices, or None where no primitive has any."""
    if all(primitive.bending is None for primitive in primitives):
        return None
    return b"".join(_bending(primitive).tobytes() for primitive in primitives)


def _bending(primitive: Primitive) -> NDArray[np.void]:
    vertices = np.zeros(len(primitive.positions), _BENDING)
    if primitive.bending is not None:
        vertices["joints"] = primitive.bending.joints
        vertices["weights"] = primitive.bending.weights
    return vertices


def index_bytes(primitives: tuple[Primitive, ...]) -> bytes:
    """Return the indices of all primitives, each counting from its own first vertex."""
    return b"".join(np.asarray(p.indices, dtype=np.uint32).tobytes() for p in primitives) or bytes(
        12
    )
