"""Draws that happen only where others have drawn something: decided on the GPU, without a wait."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import moderngl

from vrcomfort.gpu import gl, passes
from vrcomfort.gpu.timer import queries

_ANY_SAMPLES_PASSED, _QUERY_WAIT, _QUERY_RESULT = 0x8C2F, 0x8E13, 0x8866


class ConditionalDraws:
    """Draws only if an earlier draw of the same frame has passed a sample (`ask`).

    While passes are watched, the CPU asks and leaves them out itself, so that none is counted that
    draws nothing.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        uint = ctypes.c_uint
        self._begin_query = gl.function(ctx, "glBeginQuery", uint, uint)
        self._end_query = gl.function(ctx, "glEndQuery", uint)
        self._result = gl.function(ctx, "glGetQueryObjectuiv", uint, uint, ctypes.c_void_p)
        self._begin = gl.function(ctx, "glBeginConditionalRender", uint, uint)
        self._end = gl.function(ctx, "glEndConditionalRender")
        (self._name,) = queries(ctx, self, 1)

    def ask(self, draw: Callable[[], object]) -> None:
        """Draw, without anybody watching, and note whether a sample has passed."""
        self._begin_query(_ANY_SAMPLES_PASSED, self._name)
        try:
            draw()
        finally:
            self._end_query(_ANY_SAMPLES_PASSED)

    def run(self, draw: Callable[[], object]) -> None:
        """Draw if one has."""
        if passes.is_watched():
            found = ctypes.c_uint()
            self._result(self._name, _QUERY_RESULT, ctypes.byref(found))
            if found.value:
                draw()
            return
        self._begin(self._name, _QUERY_WAIT)
        try:
            draw()
        finally:
            self._end()
