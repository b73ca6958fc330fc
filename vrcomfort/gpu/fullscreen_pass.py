"""Post-processing passes from textures to textures: full-screen, mip chain, running maximum."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from math import ceil
from typing import Any, NamedTuple, Protocol

import moderngl
import numpy as np

from vrcomfort.gpu import gl, shaders, visible_area
from vrcomfort.gpu.passes import Pass, PassImage
from vrcomfort.gpu.visible_area import DRAWN, LimitedVertices


class Uniforms(Protocol):
    """A named tuple with the names of a program's uniforms as fields."""

    @property
    def _fields(self) -> tuple[str, ...]: ...

    def __iter__(self) -> Iterator[Any]: ...


_FILTERS = {
    False: (moderngl.LINEAR, moderngl.LINEAR),
    True: (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR),
}


class FullscreenPass:
    """Draws `fragment` into a texture of its own.

    Parameters
    ----------
    size_px
        (width, height) of the target.
    inputs
        Texture for each sampler uniform; several for an array of samplers.
    constants
        Uniforms that never change; a name that the shader does not use is an error.
    filtered
        Names of the inputs that are sampled bilinearly; the others as their textures say.
    mipmapped
        Names of those that are sampled trilinearly, between levels of their mip chains.
    components, dtype
        Of the target, as in :func:`gl.color_texture`.
    more_components
        Of further targets, which are drawn into at once, at locations 1, 2, …: `targets`.
    vertex, tiles
        Instead of the triangle: squares of ``POINT_PX`` px, which cover an image of `tiles` =
        (columns, rows) of them; `vertex` makes points of `gl_VertexID` alone.
    target
        A texture to draw into instead of one of its own, or several as with `more_components`; none
        where only `depth` is written.
    depth
        A texture; fragments replace its depth.
    reach_px
        How far beyond the pixels of a texel of the target it reads its inputs, in pixels of the
        eye's image, or how far by name; without it, and for names that are left out, anywhere.
    texel_px
        (width, height) of a texel of the target in pixels of the eye's image.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        fragment: str,
        *,
        size_px: tuple[int, int],
        inputs: Mapping[str, moderngl.Texture | Sequence[moderngl.Texture]],
        constants: Uniforms | None = None,
        defines: shaders.Defines | None = None,
        filtered: Collection[str] = (),
        mipmapped: Collection[str] = (),
        components: int = 4,
        dtype: str = "f2",
        more_components: Sequence[int] = (),
        vertex: str = "common/fullscreen.vert",
        tiles: tuple[int, int] | None = None,
        target: moderngl.Texture | Sequence[moderngl.Texture] | None = None,
        depth: moderngl.Texture | None = None,
        reach_px: float | Mapping[str, float] = math.inf,
        texel_px: tuple[int, int] = (1, 1),
    ) -> None:
        if target is None:
            wanted = (components, *more_components)
            made = (gl.color_texture(ctx, size_px, components=n, dtype=dtype) for n in wanted)
            self.targets = tuple(made)
        else:
            self.targets = tuple(_textures(target))
        area = visible_area.current()
        if area is not None and tiles is None:
            defines = {**(defines or {}), "CORNERS": 1}
        self._triangle = ctx.vertex_array(shaders.program(ctx, fragment, vertex, defines), [])
        named = [(name, texture) for name in inputs for texture in _textures(inputs[name])]
        for name in inputs:
            units = tuple(unit for unit, (other, _) in enumerate(named) if other == name)
            self._triangle.program[name] = units if len(units) > 1 else units[0]
        self._samplers = tuple(
            (unit, ctx.sampler(repeat_x=False, repeat_y=False, filter=_FILTERS[name in mipmapped]))
            for unit, (name, _) in enumerate(named)
            if name in filtered or name in mipmapped
        )
        self._values: dict[str, Any] = {}
        self._members: dict[str, Any] = {}
        self._last: Uniforms | None = None
        self._kind: type | None = None
        if constants is not None:
            self._set(constants)
        framebuffer = ctx.framebuffer(self.targets, depth)
        flags = moderngl.NOTHING if depth is None else moderngl.DEPTH_TEST
        self._ctx, self._writes_depth = ctx, depth is not None
        self._draw = _drawing(self._triangle, moderngl.TRIANGLES, 3)
        drawn_px = texel_px
        if tiles is not None:
            columns, rows = tiles
            self._draw = _drawing(self._triangle, moderngl.POINTS, columns * rows)
            flags = moderngl.PROGRAM_POINT_SIZE
            # Points whose middle is outside the viewport are not drawn: it is of whole tiles.
            point_px = int((defines or {})["POINT_PX"])
            framebuffer.viewport = (0, 0, columns * point_px, rows * point_px)
            drawn_px = (texel_px[0] * point_px, texel_px[1] * point_px)
        self._triangle.scope = ctx.scope(framebuffer, flags)
        self._bind = gl.binder(ctx, [texture for _, texture in named])
        reach = reach_px if isinstance(reach_px, Mapping) else dict.fromkeys(inputs, reach_px)
        self.declared = Pass(
            fragment,
            tuple(
                PassImage.of(texture, mipmaps=name in mipmapped, reach_px=reach.get(name, math.inf))
                for name, texture in named
            ),
            tuple(map(PassImage.of, (*self.targets, *([] if depth is None else [depth])))),
            texel_px=drawn_px,
        )
        self._framebuffer = framebuffer
        if area is not None:
            area.add(self)
            self._draw = LimitedVertices(
                area, self._triangle, self.declared.writes[0], texel_px=drawn_px, points=tiles
            ).render

    @property
    def target(self) -> moderngl.Texture:
        """Return the first of `targets`."""
        return self.targets[0]

    def render(self, uniforms: Uniforms | None = None) -> None:
        """Draw, after setting the uniforms of this frame."""
        if uniforms is not None and (uniforms != self._last or type(uniforms) is not self._kind):
            self._set(uniforms)
            self._last, self._kind = uniforms, type(uniforms)
        self._bind()
        for unit, sampler in self._samplers:
            sampler.use(unit)
        if self._writes_depth:
            self._ctx.depth_func = "1"  # moderngl's GL_ALWAYS: fragments replace any depth
        self.declared.run(self._draw)
        for unit, sampler in self._samplers:
            sampler.clear(unit)  # samplers override the textures of passes that follow

    def clear(self, value: float, depth: float) -> None:
        """Fill the targets with a value, integers with 0 or, where it is no number, all bits."""
        self._framebuffer.clear(value, value, value, value, depth=depth)
        for each in self.targets:
            if each.dtype.startswith("u"):
                texel = b"\xff" if math.isnan(value) else b"\0"
                each.write(
                    texel * (each.width * each.height * each.components * int(each.dtype[1]))
                )

    def _set(self, uniforms: Uniforms) -> None:
        known = self._values
        for name, value in zip(uniforms._fields, uniforms, strict=True):
            if name not in known or known[name] != value:  # a program keeps uniforms between draws
                known[name] = value
                self._write(name, value)

    def _write(self, name: str, value: Any) -> None:
        member: Any = self._members.get(name)
        if member is None:
            member = self._members[name] = self._triangle.program[name]
        if isinstance(value, bytes):
            member.write(value)
        else:
            member.value = value


def _drawing(array: moderngl.VertexArray, mode: int, vertices: int) -> Callable[[], None]:
    """Return what draws; the method is looked up at each draw, so that tests can count draws."""
    return lambda: array.render(mode, vertices=vertices)


def _textures(given: moderngl.Texture | Sequence[moderngl.Texture]) -> Sequence[moderngl.Texture]:
    return (given,) if isinstance(given, moderngl.Texture) else given


def copier(
    ctx: moderngl.Context, source: moderngl.Texture, target: moderngl.Texture
) -> Callable[[], None]:
    """Return a function that copies an image bit by bit, or what is drawn of it."""
    if visible_area.current() is None:
        copy = gl.copier(ctx)
        return lambda: copy(source, target)
    inputs, size_px = {"image": source}, target.size
    copied = FullscreenPass(
        ctx, "common/copy.frag", size_px=size_px, inputs=inputs, target=target, reach_px=0.0
    )
    return copied.render


class _Size(NamedTuple):
    size_px: tuple[int, int]


class MipChain:
    """Levels 1, 2, … of `image` (RGBA16F): ``common/mip_downsample.frag``.

    Level k has size / 2^k, rounded up, and its texel t begins at pixel 2^k t, also where an odd
    image ends within a texel.

    Attributes
    ----------
    levels
        The textures, level 1 first.
    """

    def __init__(
        self, ctx: moderngl.Context, image: moderngl.Texture, count: int, size_px: tuple[int, int]
    ) -> None:
        self._halves: list[FullscreenPass] = []
        width, height = size_px
        for level in range(1, count + 1):
            self._halves.append(
                FullscreenPass(
                    ctx,
                    "common/mip_downsample.frag",
                    size_px=(ceil(width / 2**level), ceil(height / 2**level)),
                    inputs={"source": self._halves[-1].target if self._halves else image},
                    constants=_Size(size_px),
                    defines={"TEXEL": 2 ** (level - 1)},
                    reach_px=0.0,
                    texel_px=(2**level, 2**level),
                )
            )
        self.levels = [half.target for half in self._halves]

    def render(self, count: int | None = None) -> None:
        """Draw the first `count` levels of the present image, or all."""
        for half in self._halves[:count]:
            half.render()


class MaxReductionPass:
    """Keeps the greatest values of an image's texels in one pixel, `target`, and of all images.

    Points on one pixel are blended by their maximum: one draw, and no frame waits for it; only
    :meth:`read` does.

    Parameters
    ----------
    vertex
        Makes a point of each texel, or with `by_row` of each row of them: ``greatest`` of
        ``common/max_reduction.frag``. The first component alone is kept over all images.
    value
        Components of a texel whose length counts, with the vertex shader that is given here.
    components
        Of `target`.
    least
        Where the maximum of each component of an image starts from.
    texel_px
        (width, height) of a texel in pixels of the eye's image: those that are not seen are left
        out. Without it all count.
    by_row
        A point looks at a row of texels, or where some are left out, with EACH_TEXEL, at one.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        texels: moderngl.Texture,
        *,
        vertex: str = "common/max_reduction.vert",
        value: str = "xy",
        components: int = 1,
        least: Sequence[float] = (0.0, 0.0, 0.0, 0.0),
        texel_px: tuple[int, int] | None = None,
        by_row: bool = False,
    ) -> None:
        self._ctx, self._texels = ctx, texels
        self.target = gl.color_texture(ctx, (1, 1), components=components, dtype="f4")
        self._of_all = gl.color_texture(ctx, (1, 1), components=1, dtype="f4")
        self._framebuffer = ctx.framebuffer([self.target, self._of_all])
        self._framebuffer.clear()
        self._fill = gl.clearer(ctx, self._framebuffer, least)
        limited = texel_px is not None and visible_area.current() is not None
        program = shaders.program(
            ctx,
            "common/max_reduction.frag",
            vertex,
            {"VALUE": value, **({"EACH_TEXEL": 1} if limited else {})},
        )
        self._points = ctx.vertex_array(program, [])
        self._points.program["texels"] = 0
        self._points.scope = ctx.scope(self._framebuffer, moderngl.BLEND)
        reads = (PassImage.of(texels, reach_px=DRAWN if limited else math.inf),)
        writes = PassImage.of(self.target), PassImage.of(self._of_all)
        self._cleared = Pass("clear", (), writes[:1])
        self._reset = Pass("clear", (), writes)
        self._declared = Pass("common/max_reduction.frag", reads, writes, blends=True)
        of_texels = LimitedVertices.of_texels(self._points, reads[0], texel_px)
        count = texels.height if by_row else texels.width * texels.height
        self._draw = _drawing(self._points, moderngl.POINTS, count)
        if of_texels is not None:
            self._draw = of_texels.render

    def render(self) -> None:
        """Take the present texels into account, and no others in `target`."""
        self._cleared.run(self._fill)
        self._texels.use(0)
        self._ctx.blend_equation = (moderngl.MAX, moderngl.MAX)
        self._declared.run(self._draw)
        self._ctx.blend_equation = (moderngl.FUNC_ADD, moderngl.FUNC_ADD)

    def read(self) -> float:
        """Return the greatest first component of all images; waits for the GPU."""
        return float(np.frombuffer(self._of_all.read(), dtype=np.float32)[0])

    def reset(self) -> None:
        """Start again from 0."""
        self._reset.run(self._framebuffer.clear)
