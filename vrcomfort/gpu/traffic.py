"""Memory traffic of a frame: draws, passes, bytes and texture reads.

This travels between machines, as times do not. It is found by asking OpenGL at each draw which
textures the program reads, where it draws, and how many fragments it has drawn.

The accounting: a pass reads each of its textures once, all levels that its sampler may use, and
writes what it draws; where it blends, it reads that too. A draw that covers a part of its target
reads the same part of each texture. Caches are perfect within a pass and empty between two: a
floor, which no reading of a texel twice changes.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from typing import Any, NamedTuple

import moderngl

from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.timer import queries


class TextureLevel(NamedTuple):
    """A level of a texture: its OpenGL name, size, and bytes for each texel (all samples)."""

    name: int
    size_px: tuple[int, int]
    texel_bytes: float

    @property
    def bytes(self) -> float:
        """Return the bytes of the whole level."""
        return self.size_px[0] * self.size_px[1] * self.texel_bytes


@dataclass(frozen=True)
class Draw:
    """One draw, or one copy of a texture.

    Parameters
    ----------
    shader
        File of its last stage; ``copy`` where a texture is copied.
    targets
        Colour textures that it drew into.
    fragments
        How many it has drawn.
    bytes
        Read and written.
    reads
        Texture reads; None where its program does not count them.
    """

    shader: str
    targets: tuple[TextureLevel, ...]
    fragments: int
    bytes: float
    reads: int | None


class Traffic(NamedTuple):
    """The draws of a part of a frame, added up."""

    passes: int
    """Runs of draws into the same target; a mip chain is one."""
    draws: int
    bytes: float
    reads: int | None
    """Texture reads; None where they were not counted."""


def added_up(draws: Sequence[Draw]) -> Traffic:
    """Return the sums over consecutive draws."""
    reads = [draw.reads for draw in draws if draw.reads is not None]
    return Traffic(
        passes=_passes(draws),
        draws=len(draws),
        bytes=sum(draw.bytes for draw in draws),
        reads=sum(reads) if reads else None,
    )


def _passes(draws: Sequence[Draw]) -> int:
    if not draws:
        return 0
    return 1 + sum(not (_same_target(a, b) or _next_level(a, b)) for a, b in pairwise(draws))


def _same_target(a: Draw, b: Draw) -> bool:
    return [each.name for each in a.targets] == [each.name for each in b.targets] and (
        not a.targets or a.targets[0].size_px == b.targets[0].size_px
    )


def _next_level(a: Draw, b: Draw) -> bool:
    """Return whether the second draw goes on with a mip chain: the same shader, half the size."""
    if a.shader != b.shader or not a.targets or not b.targets:
        return False
    before, after = a.targets[0].size_px, b.targets[0].size_px
    sides = zip(before, after, strict=True)
    # A texel halved is a texel: two images of 1×1 are no chain.
    return before != after and all(
        half in {ceil(whole / 2), max(whole // 2, 1)} for whole, half in sides
    )


class DrawRecorder:
    """Notes every draw that is made through moderngl between :meth:`recording`'s begin and end.

    Programs that were built inside :func:`shaders.counting_reads` count their reads too.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self._state = _State(ctx)
        self._counter = gl.dynamic_buffer(ctx, 8)
        self.draws: list[Draw] = []

    @contextmanager
    def recording(self) -> Iterator[None]:
        """Record the draws inside, in `draws`."""
        arrays: Any = moderngl.VertexArray
        draw, indirect = arrays.render, arrays.render_indirect

        def render(array: moderngl.VertexArray, *arguments: Any, **options: Any) -> None:
            self._note(array, lambda: draw(array, *arguments, **options))

        def render_indirect(array: moderngl.VertexArray, *arguments: Any, **options: Any) -> None:
            self._note(array, lambda: indirect(array, *arguments, **options))

        arrays.render = render
        arrays.render_indirect = render_indirect
        gl.copy_observers.append(self._note_copy)
        try:
            yield
        finally:
            arrays.render = draw
            arrays.render_indirect = indirect
            gl.copy_observers.remove(self._note_copy)

    def _note(self, array: moderngl.VertexArray, draw: Callable[[], None]) -> None:
        scope, array.scope = array.scope, None  # entered here, so that its target can be asked for
        try:
            with scope or nullcontext():
                self._note_in_scope(array.program, draw)
        finally:
            array.scope = scope

    def _note_in_scope(self, program: moderngl.Program, draw: Callable[[], None]) -> None:
        self._counter.clear()
        self._counter.bind_to_storage_buffer(shaders.READS_BINDING)
        inputs, targets = self._state.inputs(program.glo), self._state.targets()
        fragments = self._state.fragments_of(draw)
        low, high = memoryview(self._counter.read()).cast("I")
        covered = _covered(fragments, targets)
        written = sum(each.bytes for each in targets) * covered
        reads = low + (high << 32)
        self.draws.append(
            Draw(
                str(program.extra),
                tuple(targets),
                fragments,
                sum(each.bytes for each in inputs) * covered
                + written * (2 if self._state.blends() else 1),
                reads,
            )
        )

    def _note_copy(self, source: moderngl.Texture) -> None:
        level = self._state.level(source.glo, 0)
        self.draws.append(Draw("copy", (), 0, 2 * level.bytes, 0))


def _covered(fragments: int, targets: Sequence[TextureLevel]) -> float:
    """Return which part of its target a draw covers; all of a target that has no pixels."""
    pixels = max((each.size_px[0] * each.size_px[1] for each in targets), default=0)
    return min(1.0, fragments / pixels) if pixels else 1.0


_SAMPLERS = {0x8B5E, 0x8B62, 0x8DCA, 0x8DD2, 0x9108, 0x8DC1, 0x8DC4}
"""GL_SAMPLER_2D and other samplers of two dimensions: shadow, integer, multisample, array."""
_BINDINGS = {0x9108: 0x9104, 0x8DC1: 0x8C1D, 0x8DC4: 0x8C1D}
"""Binding query by type of sampler, where it is not GL_TEXTURE_BINDING_2D."""
_TEXTURE_BINDING_2D, _ACTIVE_TEXTURE, _TEXTURE0, _SAMPLER_BINDING = 0x8069, 0x84E0, 0x84C0, 0x8919
_ACTIVE_UNIFORMS, _DRAW_FRAMEBUFFER, _FRAMEBUFFER_BINDING = 0x8B86, 0x8CA9, 0x8CA6
_COLOR_ATTACHMENT0, _OBJECT_TYPE, _OBJECT_NAME, _LEVEL = 0x8CE0, 0x8CD0, 0x8CD1, 0x8CD2
_TEXTURE, _SAMPLES_PASSED, _QUERY_RESULT, _BLEND = 0x1702, 0x8914, 0x8866, 0x0BE2
_WIDTH, _HEIGHT, _SAMPLES = 0x1000, 0x1001, 0x9106
_BITS = (0x805C, 0x805D, 0x805E, 0x805F, 0x884A, 0x88F1)
"""GL_TEXTURE_RED_SIZE … ALPHA_SIZE, DEPTH_SIZE, STENCIL_SIZE."""
_MIN_FILTER, _BASE_LEVEL, _MAX_LEVEL = 0x2801, 0x813C, 0x813D
_NEAREST, _LINEAR = 0x2600, 0x2601
_MOST_COLOURS = 8
"""Least GL_MAX_COLOR_ATTACHMENTS of OpenGL 4.5; no pass of ours has more targets."""


class _State:
    """Queries of OpenGL state: bound textures, targets, fragments."""

    def __init__(self, ctx: moderngl.Context) -> None:
        uint, out = ctypes.c_uint, ctypes.c_void_p
        names = {
            "glGetIntegerv": (uint, out),
            "glActiveTexture": (uint,),
            "glGetProgramiv": (uint, uint, out),
            "glGetActiveUniform": (uint, uint, ctypes.c_int, out, out, out, ctypes.c_char_p),
            "glGetUniformiv": (uint, ctypes.c_int, out),
            "glGetTextureLevelParameteriv": (uint, ctypes.c_int, uint, out),
            "glGetTextureParameteriv": (uint, uint, out),
            "glGetSamplerParameteriv": (uint, uint, out),
            "glGetFramebufferAttachmentParameteriv": (uint, uint, uint, out),
            "glBeginQuery": (uint, uint),
            "glEndQuery": (uint,),
            "glGetQueryObjectui64v": (uint, uint, out),
        }
        self._gl = {name: gl.function(ctx, name, *types) for name, types in names.items()}
        self._location = gl.function(
            ctx, "glGetUniformLocation", uint, ctypes.c_char_p, result=ctypes.c_int
        )
        self._enabled = gl.function(ctx, "glIsEnabled", uint, result=ctypes.c_ubyte)
        (self._query,) = queries(ctx, self, 1)
        self._samplers: dict[int, list[tuple[int, int]]] = {}

    def inputs(self, program: int) -> list[TextureLevel]:
        """Return the levels of all textures that a program may read, each once."""
        if program not in self._samplers:
            self._samplers[program] = self._sampler_locations(program)
        active = self._integer(_ACTIVE_TEXTURE)
        found = {}
        for location, kind in self._samplers[program]:
            unit = self._get("glGetUniformiv", program, location)
            self._gl["glActiveTexture"](_TEXTURE0 + unit)
            texture = self._integer(_BINDINGS.get(kind, _TEXTURE_BINDING_2D))
            if texture:
                for level in self._levels(texture, self._integer(_SAMPLER_BINDING)):
                    found[level.name, level.size_px] = level
        self._gl["glActiveTexture"](active)
        return list(found.values())

    def targets(self) -> list[TextureLevel]:
        """Return the colour targets."""
        if not self._integer(_FRAMEBUFFER_BINDING):
            return []
        found = []
        for index in range(_MOST_COLOURS):
            where = _DRAW_FRAMEBUFFER, _COLOR_ATTACHMENT0 + index
            ask = "glGetFramebufferAttachmentParameteriv"
            if self._get(ask, *where, _OBJECT_TYPE) == _TEXTURE:
                name = self._get(ask, *where, _OBJECT_NAME)
                found.append(self.level(name, self._get(ask, *where, _LEVEL)))
        return found

    def blends(self) -> bool:
        """Return whether draws are blended."""
        return bool(self._enabled(_BLEND))

    def fragments_of(self, draw: Callable[[], None]) -> int:
        """Draw, and return how many samples have passed all tests."""
        self._gl["glBeginQuery"](_SAMPLES_PASSED, self._query)
        try:
            draw()
        finally:
            self._gl["glEndQuery"](_SAMPLES_PASSED)
        found = ctypes.c_uint64()
        self._gl["glGetQueryObjectui64v"](self._query, _QUERY_RESULT, ctypes.byref(found))
        return found.value

    def level(self, texture: int, level: int) -> TextureLevel:
        """Return the size and format of a level of a texture."""
        ask = "glGetTextureLevelParameteriv"
        width, height = (self._get(ask, texture, level, side) for side in (_WIDTH, _HEIGHT))
        bits = sum(self._get(ask, texture, level, each) for each in _BITS)
        samples = max(1, self._get(ask, texture, level, _SAMPLES))
        return TextureLevel(texture, (width, height), bits / 8 * samples)

    def _levels(self, texture: int, sampler: int) -> Iterator[TextureLevel]:
        """Yield the levels that may be read: all between the bounds, or one without mipmaps."""
        first = self._get("glGetTextureParameteriv", texture, _BASE_LEVEL)
        last = self._get("glGetTextureParameteriv", texture, _MAX_LEVEL)
        if sampler:
            how = self._get("glGetSamplerParameteriv", sampler, _MIN_FILTER)
        else:
            how = self._get("glGetTextureParameteriv", texture, _MIN_FILTER)
        for number in range(first, first + 1 if how in (_NEAREST, _LINEAR) else last + 1):
            level = self.level(texture, number)
            if not level.size_px[0]:
                return
            yield level

    def _sampler_locations(self, program: int) -> list[tuple[int, int]]:
        """Return (location, type) of a program's samplers, those of arrays one by one."""
        found = []
        size, kind, text = ctypes.c_int(), ctypes.c_uint(), ctypes.create_string_buffer(256)
        for index in range(self._get("glGetProgramiv", program, _ACTIVE_UNIFORMS)):
            self._gl["glGetActiveUniform"](
                program, index, 256, None, ctypes.byref(size), ctypes.byref(kind), text
            )
            if kind.value not in _SAMPLERS:
                continue
            name = text.value.removesuffix(b"[0]")
            names = (
                [name] if size.value == 1 else [b"%s[%d]" % (name, i) for i in range(size.value)]
            )
            found += [(self._location(program, each), kind.value) for each in names]
        return found

    def _integer(self, name: int) -> int:
        return self._get("glGetIntegerv", name)

    def _get(self, function: str, *arguments: int) -> int:
        found = (ctypes.c_int * 16)()
        self._gl[function](*arguments, found)
        return int(found[0])
