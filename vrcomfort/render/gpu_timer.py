"""Times frames on the GPU, and reads the times when they have long arrived."""

from __future__ import annotations

import ctypes
import weakref
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import moderngl

from vrcomfort.render import gl

LATENCY = 4
"""Frames between timing and reading: no driver queues more, so reading never waits."""

SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software", "basic render")
"""Rasterisers without a GPU: their timer queries say when commands were taken, not drawn."""

_TIME_ELAPSED, _QUERY_RESULT = 0x88BF, 0x8866


class GpuTime(NamedTuple):
    """What a frame (`Frame.index`) cost the GPU."""

    frame_index: int
    gpu_ms: float


class GpuTimer:
    """A timer query for each frame that is on its way.

    Raw OpenGL, because moderngl's queries have 32 bits and are never deleted.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        names = (ctypes.c_uint * (LATENCY + 1))()
        count_and_names = ctypes.c_int, ctypes.POINTER(ctypes.c_uint)
        gl.function(ctx, "glGenQueries", *count_and_names)(len(names), names)
        delete = gl.function(ctx, "glDeleteQueries", *count_and_names)
        weakref.finalize(self, delete, len(names), names).atexit = False
        self._begin = gl.function(ctx, "glBeginQuery", ctypes.c_uint, ctypes.c_uint)
        self._end = gl.function(ctx, "glEndQuery", ctypes.c_uint)
        result = ctypes.c_uint, ctypes.c_uint, ctypes.POINTER(ctypes.c_uint64)
        self._result = gl.function(ctx, "glGetQueryObjectui64v", *result)
        self._free = list(names)
        self._pending: deque[tuple[int, int]] = deque()

    @contextmanager
    def frame(self, index: int) -> Iterator[None]:
        """Time what is drawn inside."""
        name = self._free.pop()
        self._pending.append((index, name))
        self._begin(_TIME_ELAPSED, name)
        try:
            yield
        finally:
            self._end(_TIME_ELAPSED)

    def arrived(self) -> tuple[GpuTime, ...]:
        """Return the time of the frame that was timed `LATENCY` frames ago, if there is one."""
        return (self._read(),) if len(self._pending) > LATENCY else ()

    def drain(self) -> tuple[GpuTime, ...]:
        """Return the times that are still on their way (this waits for the GPU)."""
        return tuple(self._read() for _ in range(len(self._pending)))

    def _read(self) -> GpuTime:
        index, name = self._pending.popleft()
        self._free.append(name)
        time_ns = ctypes.c_uint64()
        self._result(name, _QUERY_RESULT, ctypes.byref(time_ns))
        return GpuTime(index, time_ns.value / 1e6)


def make_gpu_timer(ctx: moderngl.Context) -> GpuTimer | None:
    """Return a timer, or None where its times would mean nothing."""
    renderer = str(ctx.info["GL_RENDERER"]).lower()
    return None if any(name in renderer for name in SOFTWARE) else GpuTimer(ctx)
