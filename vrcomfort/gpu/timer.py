"""Times frames on the GPU, and reads the times when they have long arrived."""

from __future__ import annotations

import ctypes
import time
import weakref
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import moderngl

from vrcomfort.frame import GpuTime
from vrcomfort.gpu import gl
from vrcomfort.gpu.gl import LATENCY

SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software", "basic render")
"""Rasterisers without a GPU, in lower case. Their timer queries say when commands were taken, not
drawn, and anisotropic filtering costs them more than all other shading (3 × measured)."""

_TIME_ELAPSED, _TIMESTAMP, _QUERY_RESULT = 0x88BF, 0x8E28, 0x8866


@dataclass
class Lap:
    """Tells the seconds between two time stamps, once they have arrived: may wait for them."""

    told: Callable[[], float] = float

    def __call__(self) -> float:
        """Return the seconds."""
        return self.told()


class GpuTimer:
    """A timer query for each frame that is on its way.

    Raw OpenGL, because moderngl's queries have 32 bits and are never deleted.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        names = queries(ctx, self, LATENCY + 1)  # those in flight, and one for this frame
        self._begin = gl.function(ctx, "glBeginQuery", ctypes.c_uint, ctypes.c_uint)
        self._end = gl.function(ctx, "glEndQuery", ctypes.c_uint)
        result = ctypes.c_uint, ctypes.c_uint, ctypes.POINTER(ctypes.c_uint64)
        self._result = gl.function(ctx, "glGetQueryObjectui64v", *result)
        self._free = list(names)
        self._pending: deque[tuple[int, int]] = deque()

    @contextmanager
    def frame(self, index: int) -> Iterator[None]:
        """Time the draws inside."""
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


class Stopwatch:
    """Times draws: for benchmarks, also inside a frame that is timed.

    Time stamps of the GPU, or where those mean nothing the processor's time that this process has
    used, all threads together, between two ``finish``: other load on the machine hardly changes
    it. Time stamps are queued with the draws between them, and nothing waits before
    a time is asked for. Still they tell how fast commands are sent where the GPU is done with them
    sooner.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self.on_gpu = not is_software(ctx)
        self._free: list[tuple[int, ...]] = []
        if self.on_gpu:
            self._stamp = gl.function(ctx, "glQueryCounter", ctypes.c_uint, ctypes.c_uint)
            result = ctypes.c_uint, ctypes.c_uint, ctypes.POINTER(ctypes.c_uint64)
            self._result = gl.function(ctx, "glGetQueryObjectui64v", *result)

    @contextmanager
    def lap(self) -> Iterator[Lap]:
        """Time the draws inside; the lap, called once afterwards, gives the seconds."""
        lap = Lap()
        if self.on_gpu:
            pair = self._free.pop() if self._free else queries(self._ctx, self, 2)
            self._stamp(pair[0], _TIMESTAMP)
            yield lap
            self._stamp(pair[1], _TIMESTAMP)
            lap.told = partial(self._between, pair)
            return
        self._ctx.finish()
        start_s = time.process_time()
        yield lap
        self._ctx.finish()
        seconds = time.process_time() - start_s
        lap.told = lambda: seconds

    def seconds(self, draw: Callable[[], object]) -> float:
        """Return how long drawing takes; waits for it."""
        with self.lap() as lap:
            draw()
        return lap()

    def _between(self, pair: tuple[int, ...]) -> float:
        seconds = (self._time_ns(pair[1]) - self._time_ns(pair[0])) / 1e9
        self._free.append(pair)
        return seconds

    def _time_ns(self, name: int) -> int:
        time_ns = ctypes.c_uint64()
        self._result(name, _QUERY_RESULT, ctypes.byref(time_ns))
        return time_ns.value


class _Queries(NamedTuple):
    """Names of queries, which :func:`gl.collect` releases."""

    delete: Callable[..., object]
    names: ctypes.Array[ctypes.c_uint]

    def release(self) -> None:
        self.delete(len(self.names), self.names)


def queries(ctx: moderngl.Context, owner: object, count: int) -> tuple[int, ...]:
    """Return the names of new queries, which die with their owner."""
    names = (ctypes.c_uint * count)()
    count_and_names = ctypes.c_int, ctypes.POINTER(ctypes.c_uint)
    gl.function(ctx, "glGenQueries", *count_and_names)(count, names)
    dead = _Queries(gl.function(ctx, "glDeleteQueries", *count_and_names), names)
    weakref.finalize(owner, ctx.objects.append, dead).atexit = False
    return tuple(names)


def is_software(ctx: moderngl.Context) -> bool:
    """Return whether a rasteriser without a GPU draws."""
    renderer = str(ctx.info["GL_RENDERER"]).lower()
    return any(name in renderer for name in SOFTWARE)


def make_gpu_timer(ctx: moderngl.Context) -> GpuTimer | None:
    """Return a timer, or None where its times would mean nothing."""
    return None if is_software(ctx) else GpuTimer(ctx)
