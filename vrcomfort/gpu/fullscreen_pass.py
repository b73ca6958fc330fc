"""Post-processing passes from textures to textures: full-screen, mip chain, reductions."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from math import ceil
from operator import methodcaller
from typing import Any

import moderngl
import numpy as np

from vrcomfort.gpu import gl, passes, shaders, visible_area
from vrcomfort.gpu.passes import WATCHERS, AnyTexture, Pass, PassImage
from vrcomfort.gpu.visible_area import DRAWN, limited_draw, texel_list

OVER = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
"""Factors by which what is drawn, premultiplied by its alpha, lies over what is there."""

ADDED = moderngl.ONE, moderngl.ONE


class FullscreenPass:
    """Draws `fragment` into a texture of its own.

    Where its textures have a layer for each eye, it draws both eyes at once: ``include/eyes.glsl``.

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
    blend
        Factors of what is drawn and of what is there, such as `OVER`; without them it is replaced.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        fragment: str,
        *,
        size_px: tuple[int, int],
        inputs: Mapping[str, AnyTexture | Sequence[AnyTexture]],
        constants: Mapping[str, Any] | None = None,
        defines: shaders.Defines | None = None,
        filtered: Collection[str] = (),
        components: int = 4,
        dtype: str = "f2",
        more_components: Sequence[int] = (),
        vertex: str = "common/fullscreen.vert",
        tiles: tuple[int, int] | None = None,
        target: AnyTexture | Sequence[AnyTexture] | None = None,
        depth: AnyTexture | None = None,
        reach_px: float | Mapping[str, float] = math.inf,
        texel_px: tuple[int, int] = (1, 1),
        blend: tuple[int, int] | None = None,
    ) -> None:
        # Those that are filtered come last, on the units that filter: units follow each other.
        order = sorted(inputs, key=lambda name: name in filtered)
        named = [(name, texture) for name in order for texture in _textures(inputs[name])]
        written = [] if target is None else [*_textures(target)]
        written += [] if depth is None else [depth]
        eyes = max(map(gl.layers_of, [*written, *(texture for _, texture in named)]))
        if target is None:
            self.targets = tuple(
                gl.eye_texture(ctx, size_px, eyes, components=count, dtype=dtype)
                for count in (components, *more_components)
            )
        else:
            self.targets = tuple(_textures(target))
        area = visible_area.current()
        if area is not None and tiles is None:
            defines = {**(defines or {}), "CORNERS": 1}
        defines = {**(defines or {}), **by_eyes(eyes)}
        self._triangle = ctx.vertex_array(shaders.program(ctx, fragment, vertex, defines), [])
        first_unit = gl.FILTERED_UNIT - sum(name not in filtered for name, _ in named)
        for name in inputs:
            units = tuple(
                unit for unit, (other, _) in enumerate(named, first_unit) if other == name
            )
            self._triangle.program[name] = units if len(units) > 1 else units[0]
        self._values: dict[str, Any] = {}
        self._members: dict[str, Any] = {}
        self._last: Mapping[str, Any] = {}
        self._set(constants or {})
        framebuffer = gl.framebuffer(ctx, self.targets, depth)
        flags = moderngl.NOTHING if depth is None else moderngl.DEPTH_TEST
        self._ctx, self._writes_depth, self._blend = ctx, depth is not None, blend
        flags |= moderngl.BLEND if blend else moderngl.NOTHING
        self._draw = _drawing(self._triangle, moderngl.TRIANGLES, 3 * eyes)
        drawn_px = texel_px
        if tiles is not None:
            columns, rows = tiles
            self._draw = _drawing(self._triangle, moderngl.POINTS, columns * rows * eyes)
            flags |= moderngl.PROGRAM_POINT_SIZE
            # Points whose middle is outside the viewport are not drawn: it is of whole tiles.
            point_px = int(defines["POINT_PX"])
            framebuffer.viewport = (0, 0, columns * point_px, rows * point_px)
            drawn_px = (texel_px[0] * point_px, texel_px[1] * point_px)
        self._triangle.scope = ctx.scope(framebuffer, flags)
        self._bind = gl.binder(ctx, [texture for _, texture in named], first_unit)
        reach = reach_px if isinstance(reach_px, Mapping) else dict.fromkeys(inputs, reach_px)
        self.declared = Pass(
            fragment,
            tuple(
                PassImage.of(texture, reach_px=reach.get(name, math.inf)) for name, texture in named
            ),
            tuple(map(PassImage.of, (*self.targets, *([] if depth is None else [depth])))),
            texel_px=drawn_px,
            blends=blend is not None,
        )
        self._framebuffer = framebuffer
        if area is not None:
            area.add(self)
            self._draw = limited_draw(
                area, self._triangle, self.declared.writes[0], texel_px=drawn_px, points=tiles
            )

    @property
    def target(self) -> AnyTexture:
        """Return the first of `targets`."""
        return self.targets[0]

    def render(self, **uniforms: Any) -> None:
        """Draw, after setting the uniforms of this frame."""
        if uniforms and uniforms != self._last:
            self._set(uniforms)
            self._last = uniforms
        self._bind()
        if self._writes_depth:
            self._ctx.depth_func = "1"  # moderngl's GL_ALWAYS: fragments replace any depth
        if self._blend is not None:
            self._ctx.blend_func = self._blend
        if WATCHERS:
            self.declared.run(self._draw)
        else:
            self._draw()

    def clear(self, value: float, depth: float) -> None:
        """Fill the targets with a value, integers with 0 or, where it is no number, all bits."""
        self._framebuffer.clear(value, value, value, value, depth=depth)
        for each in self.targets:
            if each.dtype.startswith("u"):
                texel = b"\xff" if math.isnan(value) else b"\0"
                texel *= gl.layers_of(each) * each.components * int(each.dtype[1])
                each.write(texel * (each.width * each.height))

    def _set(self, uniforms: Mapping[str, Any]) -> None:
        known = self._values
        for name, value in uniforms.items():
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
    """Return the draw call; the method is looked up at each draw, so that tests can count draws."""
    return partial(methodcaller("render", mode, vertices), array)


def _textures(given: AnyTexture | Sequence[AnyTexture]) -> Sequence[AnyTexture]:
    return (given,) if isinstance(given, AnyTexture) else given


def by_eyes(eyes: int) -> shaders.Defines:
    """Return the defines of ``include/eyes.glsl``."""
    return {"EYES": eyes} if eyes > 1 else {}


def of_each(values: Sequence[Any]) -> Any:
    """Return the value of a uniform of each eye: one alone, or all."""
    return values[0] if len(values) == 1 else tuple(values)


def copier(ctx: moderngl.Context, source: AnyTexture, target: AnyTexture) -> Callable[[], None]:
    """Return a function that copies an image bit by bit, or what is drawn of it."""
    if visible_area.current() is None:
        return gl.copier(ctx, source, target)
    inputs, size_px = {"image": source}, gl.size_px_of(target)
    copied = FullscreenPass(
        ctx, "common/copy.frag", size_px=size_px, inputs=inputs, target=target, reach_px=0.0
    )
    return copied.render


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
        self, ctx: moderngl.Context, image: AnyTexture, count: int, size_px: tuple[int, int]
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
                    constants={"size_px": size_px},
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


class ReductionPass:
    """Sums up all texels of an eye's image in one pixel, by one work group: `target`.

    The greatest value of all frames is kept as well; no frame waits for it: only :meth:`read` does.

    Parameters
    ----------
    shader
        Stores its result at image binding 0, and the greatest of all frames at 1.
    texels
        The name of its sampler, and the texture.
    texel_px
        (width, height) of a texel in pixels of the eye's image: those that are not seen are left
        out (``include/summed_texels.glsl``). Without it all count.
    components
        Of `target`, 32-bit float.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        shader: str,
        texels: tuple[str, AnyTexture],
        *,
        texel_px: tuple[int, int] | None = None,
        components: int = 1,
        defines: shaders.Defines | None = None,
        constants: Mapping[str, Any] | None = None,
    ) -> None:
        name, self._texels = texels
        self._eyes = eyes = gl.layers_of(self._texels)
        self.target = gl.eye_texture(ctx, (1, 1), eyes, components=components, dtype="f4")
        self._of_all = gl.eye_texture(ctx, (1, 1), eyes, components=1, dtype="f4")
        self._framebuffer = ctx.framebuffer([self._of_all])
        self._framebuffer.clear()
        area = None if texel_px is None else visible_area.current()
        listed = {} if area is None else {"LISTED": 1}
        defines = {**(defines or {}), **listed, **by_eyes(eyes)}
        self._program = shaders.compute(ctx, shader, defines)
        self._program[name] = 0
        for uniform, value in (constants or {}).items():
            self._program[uniform] = value
        of_all = PassImage.of(self._of_all)
        reads = (PassImage.of(self._texels, reach_px=math.inf if area is None else DRAWN),)
        writes = PassImage.of(self.target), of_all
        self.declared = Pass(shader, reads, writes, earlier=(of_all,), computes=True)
        self._bind = gl.binder(ctx, [self._texels])
        self._bind_images = gl.binder(ctx, [self.target, self._of_all], images=True)
        self._barrier = gl.function(ctx, "glMemoryBarrier", ctypes.c_uint)
        self._listed = texel_list(ctx, area, reads[0], texel_px or (1, 1)) if area else None
        self._clear = passes.clear([self._of_all])

    def render(self) -> None:
        """Take the present texels into account, and no others in `target`."""
        if self._listed is not None:
            self._listed().bind_to_storage_buffer(0)
        self._bind()
        self._bind_images()
        self.declared.run(self._program.run, group_z=self._eyes)
        self._barrier(_AFTER_IMAGE_STORES)

    def read(self) -> float:
        """Return the greatest value since the pass was made; waits for the GPU."""
        return float(np.frombuffer(self._of_all.read(), dtype=np.float32).max())

    def reset(self) -> None:
        """Start again from 0."""
        self._clear.run(self._framebuffer.clear)


def max_reduction(
    ctx: moderngl.Context,
    texels: AnyTexture,
    *,
    value: str = "xy",
    texel_px: tuple[int, int] | None = None,
) -> ReductionPass:
    """Return the pass that finds the greatest length of some components."""
    return ReductionPass(
        ctx,
        "common/max_reduction.comp",
        ("texels", texels),
        texel_px=texel_px,
        defines={"VALUE": value},
    )


_AFTER_IMAGE_STORES = 0x8 | 0x20 | 0x100 | 0x400
"""Texture fetches, image loads, copies to the CPU and clears see what a compute pass has stored."""
