"""Does something around each part of a frame that is told apart: scene, effects, tone map."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from vrcomfort.render.effects.depth_of_field.effect import DepthOfFieldPass

Around = Callable[[str, Callable[[], None]], None]
"""Called with the name of a part and what draws it."""


def leave_out_records(parts: Sequence[tuple[str, Any]]) -> None:
    """Let no effect draw what only the record of its limits needs: that is no part of a method."""
    for _, part in parts:
        if isinstance(part, DepthOfFieldPass):
            part.leave_out_records()


@contextmanager
def outermost(around: Around, parts: Sequence[tuple[str, Any]]) -> Iterator[None]:
    """Call `around` for each part whose `render` is called inside, unless another draws it.

    Parameters
    ----------
    parts
        Names and objects: those of :meth:`StereoRenderer.parts`.
    """
    depth = [0]

    def wrapped(method: Callable[..., Any], name: str) -> Callable[..., Any]:
        def render(*arguments: Any, **options: Any) -> Any:
            if depth[0]:
                return method(*arguments, **options)
            depth[0] += 1
            found = []
            try:
                around(name, lambda: found.append(method(*arguments, **options)))
            finally:
                depth[0] -= 1
            return found[0]

        return render

    for name, part in parts:
        part.render = wrapped(part.render, name)
    try:
        yield
    finally:
        for _, part in parts:
            del part.render
