"""Matrices of joints on the GPU (``shaders/include/skin.glsl``)."""

from __future__ import annotations

import moderngl
import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.gpu import gl

JOINT_BINDING = 0


class JointBuffer:
    """Six rows for each joint: of its matrix now, and a frame ago."""

    def __init__(self, ctx: moderngl.Context, joints: int) -> None:
        self._rows = np.zeros((joints, 2, 3, 4), dtype=np.float32)
        self._buffer = gl.dynamic_buffer(ctx, self._rows.nbytes)

    def write(self, place_from_bind: Array, previous: Array) -> None:
        """Take (joints, 4, 4) matrices of `Skins.place_from_bind`."""
        self._rows[:, 0], self._rows[:, 1] = place_from_bind[:, :3], previous[:, :3]
        self._buffer.orphan(self._rows.nbytes)  # what is being drawn from it stays as it is
        self._buffer.write(self._rows)

    def bind(self) -> None:
        """Make the joints those that shaders see."""
        self._buffer.bind_to_storage_buffer(JOINT_BINDING)
