"""Memory traffic of a frame: passes, draws, bytes and texture reads.

This travels between machines, as times do not. Passes declare what they read and write
(`vrcomfort.gpu.passes`); how much of its target a draw covers is asked of OpenGL.

The accounting: a pass reads each of its textures once, all levels that its sampler may use, and
writes every sample that it draws; where it blends, it reads that too. A draw that covers a part of
its target reads the same part of each texture; of images that surfaces are painted with, each
pixel reads a texel. Caches are perfect within a pass and empty between
two: a floor, which no reading of a texel twice changes. Vertices are not counted.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from typing import NamedTuple

import moderngl

from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.passes import Pass, Watcher
from vrcomfort.gpu.timer import queries


@dataclass(frozen=True)
class DrawnPass:
    """A pass that was drawn.

    Parameters
    ----------
    draws
        Draw calls and dispatches; clears and copies are none.
    samples
        How many were drawn.
    reads
        Texture reads; 0 where its program does not count them.
    """

    declared: Pass
    draws: int
    samples: int
    reads: int

    @property
    def bytes(self) -> float:
        """Return the bytes read and written."""
        reads, writes = self.declared.reads, self.declared.writes
        whole = sum(image.bytes for image in (*reads, *self.declared.earlier))
        if not self.draws or self.declared.computes:
            return whole + sum(image.bytes for image in writes)
        target = max(writes, key=lambda image: image.size_px[0] * image.size_px[1])
        width, height = target.size_px
        covered = self.samples / (width * height * target.samples * target.layers)
        pixels = self.samples / target.samples
        surfaces = sum(image.bytes for image in reads if image.of_surface)
        painted = sum(pixels * image.of_surface for image in reads)
        read = min(1.0, covered) * (whole - surfaces) + min(surfaces, painted)
        written = covered * sum(image.bytes for image in writes)
        return read + written * (2 if self.declared.blends else 1)


class Traffic(NamedTuple):
    """The passes of a part of a frame, added up."""

    passes: int
    """Runs of draws into the same target; a mip chain is one."""
    draws: int
    bytes: float
    reads: int | None
    """Texture reads; None where they were not counted."""


def added_up(drawn: Sequence[DrawnPass]) -> Traffic:
    """Return the sums over passes that follow each other."""
    draws = [each for each in drawn if each.draws]
    reads = sum(each.reads for each in draws)
    return Traffic(
        passes=_passes([each.declared for each in draws]),
        draws=sum(each.draws for each in draws),
        bytes=sum(each.bytes for each in drawn),
        reads=reads or None,
    )


def copied(size_px: tuple[int, int], texel: int) -> Traffic:
    """Return the traffic of copying an image with `texel` bytes a texel."""
    return Traffic(0, 0, 2 * size_px[0] * size_px[1] * texel, None)


def _passes(drawn: Sequence[Pass]) -> int:
    if not drawn:
        return 0
    return 1 + sum(a.writes != b.writes and not _next_level(a, b) for a, b in pairwise(drawn))


def _next_level(a: Pass, b: Pass) -> bool:
    """Return whether the second goes on with a mip chain: the same shader, half the size."""
    before, after = a.writes[0].size_px, b.writes[0].size_px
    # A texel halved is a texel: two images of 1×1 are no chain.
    return (
        a.name == b.name
        and before != after
        and all(
            half in {ceil(whole / 2), max(whole // 2, 1)}
            for whole, half in zip(before, after, strict=True)
        )
    )


class TrafficCounter(Watcher):
    """Notes every pass that is drawn while :func:`passes.watched` by it.

    Programs that were built inside :func:`shaders.counting_reads` count their reads too.

    Attributes
    ----------
    drawn
        All passes, in order.
    parts
        Those of each part of a frame, by the outermost one's name.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self._counter = gl.dynamic_buffer(ctx, 8)
        self._samples = _SamplesQuery(ctx)
        self.drawn: list[DrawnPass] = []
        self.parts: dict[str, list[DrawnPass]] = {}
        self._depth = 0

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Note the passes inside as those of a part."""
        first, outermost = len(self.drawn), not self._depth
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1
            if outermost:
                self.parts.setdefault(name, []).extend(self.drawn[first:])

    def run(self, declared: Pass, draw: Callable[[], int | None]) -> None:
        """Draw a pass, and note it."""
        draws: list[int | None] = []
        self._counter.clear()
        self._counter.bind_to_storage_buffer(shaders.READS_BINDING)
        samples = self._samples.of(lambda: draws.append(draw()))
        low, high = memoryview(self._counter.read()).cast("I")
        count = 0 if declared.name in NO_DRAWS else 1 if draws[0] is None else draws[0]
        if count or declared.name in NO_DRAWS:
            self.drawn.append(DrawnPass(declared, count, samples, low + (high << 32)))


NO_DRAWS = {"clear", "copy"}

_SAMPLES_PASSED, _QUERY_RESULT = 0x8914, 0x8866


class _SamplesQuery:
    """Asks OpenGL how many samples have passed all tests."""

    def __init__(self, ctx: moderngl.Context) -> None:
        uint = ctypes.c_uint
        self._begin = gl.function(ctx, "glBeginQuery", uint, uint)
        self._end = gl.function(ctx, "glEndQuery", uint)
        self._result = gl.function(ctx, "glGetQueryObjectui64v", uint, uint, ctypes.c_void_p)
        (self._name,) = queries(ctx, self, 1)

    def of(self, draw: Callable[[], object]) -> int:
        """Draw, and return the number; waits for the GPU."""
        self._begin(_SAMPLES_PASSED, self._name)
        try:
            draw()
        finally:
            self._end(_SAMPLES_PASSED)
        found = ctypes.c_uint64()
        self._result(self._name, _QUERY_RESULT, ctypes.byref(found))
        return found.value
