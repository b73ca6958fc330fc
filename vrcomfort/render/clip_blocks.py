"""The uniform block of ``depth.vert``: where each of several views puts things."""

from __future__ import annotations

import moderngl
import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.gpu import gl

CLIP_BINDING = 3


class ClipBlocks:
    """A block for each view, all written with one call."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._stride = gl.uniform_stride(64)
        self._buffer = gl.dynamic_buffer(ctx, self._stride)

    def write(self, clips_from_relative: Array) -> None:
        """Take (views, 4, 4) matrices."""
        blocks = np.zeros((len(clips_from_relative), self._stride // 64, 4, 4), dtype=np.float32)
        blocks[:, 0] = clips_from_relative.swapaxes(-1, -2)  # GLSL stores columns
        self._buffer.orphan(blocks.nbytes)
        self._buffer.write(blocks)

    def bind(self, view: int) -> None:
        """Make a view's matrix the one that shaders see."""
        offset = view * self._stride
        self._buffer.bind_to_uniform_block(CLIP_BINDING, offset=offset, size=64)
