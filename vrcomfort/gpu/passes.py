"""Passes as they are declared: the textures that each reads and writes, and who watches.

Every draw, clear and copy of a frame goes through :meth:`Pass.run`. Counts of memory traffic, times
of passes and figures of the graph watch there; without a watcher nothing is asked of OpenGL.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from typing import ParamSpec, TypeAlias, TypeVar

import moderngl

from vrcomfort.gpu.memory import texel_bytes, texture_bytes

P = ParamSpec("P")
Result = TypeVar("Result")

AnyTexture: TypeAlias = moderngl.Texture | moderngl.TextureArray


@dataclass(frozen=True)
class PassImage:
    """A texture of a pass, without the texture.

    Parameters
    ----------
    name
        OpenGL's.
    size_px
        (width, height).
    bytes
        Of all that may be read: all samples and layers, and all mipmap levels where they are used.
    samples
        Of each pixel.
    of_surface
        Bytes of a texel where surfaces are painted with it, of which a pixel reads but one; 0 for
        what passes read as a whole.
    reach_px
        How far beyond the pixels of a texel of its target a pass reads it, in pixels of the eye's
        image (`gpu.visible_area`).
    layers
        Of an array.
    """

    name: int
    size_px: tuple[int, int]
    bytes: float
    samples: int = 1
    of_surface: int = 0
    reach_px: float = math.inf
    layers: int = 1

    @classmethod
    def of(
        cls,
        texture: AnyTexture,
        *,
        mipmaps: bool = False,
        of_surface: bool = False,
        reach_px: float = math.inf,
    ) -> PassImage:
        """Return the image of a texture."""
        # A layer as a texture of its own is one by the array's name.
        whole = texture.extra if isinstance(texture.extra, moderngl.TextureArray) else texture
        width, height = texture.size[:2]
        layers = 1 if isinstance(texture, moderngl.Texture) else texture.layers
        samples = texture.samples if isinstance(texture, moderngl.Texture) else 0
        texel = texel_bytes(texture.components, texture.dtype)
        size = texture_bytes((width, height), texel, samples=samples, mipmaps=mipmaps)
        surface = texel if of_surface else 0
        shape = (width, height), layers * size, max(samples, 1), surface, reach_px, layers
        return cls(whole.glo, *shape)


_collected: ContextVar[list[Pass] | None] = ContextVar("collected", default=None)


@contextmanager
def collected() -> Iterator[list[Pass]]:
    """Yield the list of all passes that are declared inside."""
    found: list[Pass] = []
    token = _collected.set(found)
    try:
        yield found
    finally:
        _collected.reset(token)


@dataclass(frozen=True, eq=False)
class Pass:
    """A draw, compute dispatch, clear or copy.

    Parameters
    ----------
    name
        File of its fragment or compute shader; ``clear``, ``copy`` and ``geometry`` have none of
        their own.
    reads, writes
        Its textures, depth among them. Nothing is both: a pass cannot read what it writes.
    blends
        Whether what it writes is read, too.
    earlier
        Read as the frame before left them.
    texel_px
        (width, height) of a texel, or a tile that is drawn whole, in pixels of the eye's image.
    computes
        Whether it is a dispatch: no samples are drawn, and its textures are read and written whole.

    Raises
    ------
    ValueError
        If it reads what it writes.
    """

    name: str
    reads: tuple[PassImage, ...]
    writes: tuple[PassImage, ...]
    blends: bool = False
    earlier: tuple[PassImage, ...] = ()
    texel_px: tuple[int, int] = (1, 1)
    computes: bool = False

    def __post_init__(self) -> None:
        written = {image.name for image in self.writes}
        for image in self.reads:
            if image.name in written:
                size = "×".join(map(str, image.size_px))
                raise ValueError(f"the pass {self.name} reads the {size} texture that it writes")

        if (collected := _collected.get()) is not None:
            collected.append(self)

    def run(self, draw: Callable[P, int | None], *arguments: P.args, **options: P.kwargs) -> None:
        """Draw; `draw` returns how many draws that were, None for one."""
        if WATCHERS:
            WATCHERS[-1].run(self, partial(draw, *arguments, **options))
        else:
            draw(*arguments, **options)


class Watcher:
    """Watches passes, and the parts of a frame that they belong to: each method may be another."""

    def run(self, declared: Pass, draw: Callable[[], int | None]) -> None:
        """Draw a pass; `draw` is as in :meth:`Pass.run`."""
        del declared
        draw()

    def part(self, name: str) -> AbstractContextManager[None]:
        """Return the context in which a part of a frame is drawn; parts stand within parts."""
        del name
        return _NOTHING


_NOTHING = nullcontext()
WATCHERS: list[Watcher] = []
"""Those of now, the innermost last; hot code looks whether there are any."""


@contextmanager
def watched(watcher: Watcher) -> Iterator[None]:
    """Let a watcher draw all passes inside; of nested ones, the innermost."""
    WATCHERS.append(watcher)
    try:
        yield
    finally:
        WATCHERS.remove(watcher)


def part(name: str) -> AbstractContextManager[None]:
    """Return the context in which a part of a frame is drawn, such as an effect."""
    return WATCHERS[-1].part(name) if WATCHERS else _NOTHING


def draw_part(
    name: str, draw: Callable[P, Result], *arguments: P.args, **options: P.kwargs
) -> Result:
    """Draw a part of a frame, as inside :func:`part`: hot, it enters no context unwatched."""
    if not WATCHERS:
        return draw(*arguments, **options)
    with part(name):
        return draw(*arguments, **options)


def clear(textures: Iterable[AnyTexture]) -> Pass:
    """Return the pass that clears textures."""
    return Pass("clear", (), tuple(map(PassImage.of, textures)))


def run_copy(source: AnyTexture, target: AnyTexture, draw: Callable[[], None]) -> None:
    """Copy a texture over another by `draw`, as a pass; none is made where nobody watches."""
    if WATCHERS:
        Pass("copy", (PassImage.of(source),), (PassImage.of(target),)).run(draw)
    else:
        draw()


class PassOrder(Watcher):
    """Checks that passes are drawn in an order in which each reads what is there."""

    def __init__(self) -> None:
        self._drawn: list[Pass] = []

    def run(self, declared: Pass, draw: Callable[[], int | None]) -> None:
        """Draw a pass, and note it."""
        self._drawn.append(declared)
        draw()

    def check(self) -> None:
        """Make sure that no pass has read what only later ones write.

        Raises
        ------
        ValueError
            With the names of both: they stand in a cycle, or in the wrong order.
        """
        check_order(self._drawn)


def check_order(passes: Iterable[Pass]) -> None:
    """Make sure that no pass reads what only later ones write.

    Raises
    ------
    ValueError
        With the names of both: they stand in a cycle, or in the wrong order.
    """
    listed = list(passes)
    written: set[int] = set()
    writers: dict[int, str] = {}
    for each in reversed(listed):
        writers.update(dict.fromkeys((image.name for image in each.writes), each.name))
    for each in listed:
        for image in each.reads:
            if image.name in writers and image.name not in written:
                size = "×".join(map(str, image.size_px))
                raise ValueError(
                    f"the pass {each.name} reads a {size} texture that the pass "
                    f"{writers[image.name]} writes after it"
                )
        written |= {image.name for image in each.writes}
