"""Draws that happen only where others have drawn something: decided on the GPU, without a wait."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import partial
from typing import ParamSpec

import moderngl

from vrcomfort.gpu import gl
from vrcomfort.gpu.passes import WATCHERS
from vrcomfort.gpu.timer import queries

P = ParamSpec("P")

_ANY_SAMPLES_PASSED, _QUERY_WAIT = 0x8C2F, 0x8E13


class ConditionalDraws:
    """Draws only if an earlier draw of the same frame has passed a sample (`ask`).

    Queries do not nest, and whoever watches passes may have one. Then the CPU decides, and leaves
    draws out itself, so that none is counted that draws nothing.

    Parameters
    ----------
    known
        Whether `ask` draws anything; waits for the GPU.
    """

    def __init__(self, ctx: moderngl.Context, known: Callable[[], bool]) -> None:
        uint = ctypes.c_uint
        (name,) = queries(ctx, self, 1)
        begin_query = gl.function(ctx, "glBeginQuery", uint, uint)
        self._begin_query = partial(begin_query, _ANY_SAMPLES_PASSED, name)
        end_query = gl.function(ctx, "glEndQuery", uint)
        self._end_query = partial(end_query, _ANY_SAMPLES_PASSED)
        begin = gl.function(ctx, "glBeginConditionalRender", uint, uint)
        self._begin = partial(begin, name, _QUERY_WAIT)
        self._end = gl.function(ctx, "glEndConditionalRender")
        self._known = known

    def ask(self, draw: Callable[[], object]) -> None:
        """Draw, and note whether a sample has passed."""
        if WATCHERS:
            draw()
            return
        self._begin_query()
        try:
            draw()
        finally:
            self._end_query()

    def run(self, draw: Callable[P, object], *arguments: P.args, **options: P.kwargs) -> None:
        """Draw if one has."""
        if WATCHERS:
            if self._known():
                draw(*arguments, **options)
            return
        self._begin()
        try:
            draw(*arguments, **options)
        finally:
            self._end()
