"""Times frames on the GPU, and reads the times when they have long arrived."""

from __future__ import annotations

import ctypes
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import moderngl

from vrcomfort.frame import GpuTime, PartTime
from vrcomfort.gpu import gl
from vrcomfort.gpu.gl import LATENCY
from vrcomfort.gpu.passes import Watcher, watched

_TIME_ELAPSED, _TIMESTAMP, _QUERY_RESULT = 0x88BF, 0x8E28, 0x8866


@dataclass
class Lap:
    """Tells the seconds between two time stamps, once they have arrived: may wait for them."""

    told: Callable[[], float] = float

    def __call__(self) -> float:
        """Return the seconds."""
        return self.told()


class GpuTimer:
    """Timer queries of each frame that is on its way.

    Raw OpenGL, because moderngl's queries have 32 bits and are never deleted.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._begin = gl.function(ctx, "glBeginQuery", ctypes.c_uint, ctypes.c_uint)
        self._end = gl.function(ctx, "glEndQuery", ctypes.c_uint)
        self._flush = gl.function(ctx, "glFlush")
        result = ctypes.c_uint, ctypes.c_uint, ctypes.POINTER(ctypes.c_uint64)
        self._result = gl.function(ctx, "glGetQueryObjectui64v", *result)
        self._free: list[int] = []
        self._pending: deque[tuple[int, list[int]]] = deque()

    @contextmanager
    def frame(self, index: int) -> Iterator[None]:
        """Time the draws inside."""
        self._pending.append((index, []))
        self._start()
        try:
            yield
        finally:
            self._end(_TIME_ELAPSED)

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Leave out what is done inside, within :meth:`frame`: waits for others, too."""
        self._end(_TIME_ELAPSED)
        self._flush()  # else what is queued would begin before a wait and end after it
        try:
            yield
        finally:
            self._start()

    def _start(self) -> None:
        self._free = self._free or list(queries(self._ctx, self, 1))
        name = self._free.pop()
        self._pending[-1][1].append(name)
        self._begin(_TIME_ELAPSED, name)

    def arrived(self) -> tuple[GpuTime, ...]:
        """Return the time of the frame that was timed `LATENCY` frames ago, if there is one."""
        return (self._read(),) if len(self._pending) > LATENCY else ()

    def drain(self) -> tuple[GpuTime, ...]:
        """Return the times that are still on their way (this waits for the GPU)."""
        return tuple(self._read() for _ in range(len(self._pending)))

    def _read(self) -> GpuTime:
        index, names = self._pending.popleft()
        self._free += names
        total_ns, time_ns = 0, ctypes.c_uint64()
        for name in names:
            self._result(name, _QUERY_RESULT, ctypes.byref(time_ns))
            total_ns += time_ns.value
        return GpuTime(index, total_ns / 1e6)


TIME_PARTS_EVERY = 90
"""Drawn frames of a session from one whose parts are timed to the next."""


class PartTimer(Watcher):
    """Times the parts of a frame, on the processor and on the GPU; results come `LATENCY` later.

    Parts within parts count as the outer one's; both eyes' parts of a name are one.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self._watch = Stopwatch(ctx)
        self._inside = False
        self._frames = 0
        self._pending: deque[tuple[int, int, list[tuple[str, float, Lap | None]]]] = deque()

    @contextmanager
    def frame(self, index: int) -> Iterator[None]:
        """Time the parts that are drawn inside, as those of a frame."""
        self._pending.append((self._frames, index, []))
        with watched(self):
            yield

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Time a part."""
        if self._inside:
            yield
            return
        self._inside = True
        start_s, lap = time.perf_counter(), None
        if self._watch.on_gpu:
            with self._watch.lap() as lap:
                yield
        else:  # nothing waits for a software rasteriser in a session
            yield
        self._pending[-1][2].append((name, time.perf_counter() - start_s, lap))
        self._inside = False

    def arrived(self) -> tuple[PartTime, ...]:
        """Count a drawn frame; return the times that are there by now without a wait."""
        self._frames += 1
        if not self._pending or self._frames - self._pending[0][0] <= LATENCY:
            return ()
        return self._read()

    def drain(self) -> tuple[PartTime, ...]:
        """Return the times that are still on their way (this waits for the GPU)."""
        return tuple(time for _ in range(len(self._pending)) for time in self._read())

    def _read(self) -> tuple[PartTime, ...]:
        _, index, timed = self._pending.popleft()
        cpu_s: dict[str, float] = {}
        gpu_s: dict[str, float] = {}
        for name, seconds, lap in timed:
            cpu_s[name] = cpu_s.get(name, 0.0) + seconds
            if lap is not None:
                gpu_s[name] = gpu_s.get(name, 0.0) + lap()
        return tuple(
            PartTime(index, name, 1e3 * cpu_s[name], 1e3 * gpu_s[name] if name in gpu_s else None)
            for name in cpu_s
        )


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
        self.on_gpu = not gl.is_software(ctx)
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


def queries(ctx: moderngl.Context, owner: object, count: int) -> tuple[int, ...]:
    """Return the names of new queries, which die with their owner."""
    names = gl.names(ctx, "Queries", count)
    gl.owned(ctx, owner, "Queries", names)
    return tuple(names)


def make_gpu_timer(ctx: moderngl.Context) -> GpuTimer | None:
    """Return a timer, or None where its times would mean nothing."""
    return None if gl.is_software(ctx) else GpuTimer(ctx)
