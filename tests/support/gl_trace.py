"""A trace of OpenGL: bytes of every draw, clear and copy, from what OpenGL says is bound.

The product counts what passes declare (`vrcomfort.gpu.traffic`); this asks at each call of moderngl
which textures the program reads, where it draws and how many samples pass, by the same accounting.
"""

from __future__ import annotations

import ctypes
from contextlib import contextmanager, nullcontext

import moderngl
import pytest

from vrcomfort.gpu import gl
from vrcomfort.gpu.timer import queries

TEXTURE_2D, TEXTURE_2D_ARRAY, MULTISAMPLE = 0x0DE1, 0x8C1A, 0x9100
BINDINGS = {TEXTURE_2D: 0x8069, TEXTURE_2D_ARRAY: 0x8C1D, MULTISAMPLE: 0x9104}
SAMPLERS = {
    0x8B5E: TEXTURE_2D, 0x8B62: TEXTURE_2D, 0x8DCA: TEXTURE_2D, 0x8DD2: TEXTURE_2D,
    0x9108: MULTISAMPLE, 0x8DC1: TEXTURE_2D_ARRAY, 0x8DC4: TEXTURE_2D_ARRAY,
}  # fmt: skip
ACTIVE_TEXTURE, TEXTURE0, ACTIVE_UNIFORMS = 0x84E0, 0x84C0, 0x8B86
DRAW_FRAMEBUFFER, FRAMEBUFFER_BINDING = 0x8CA9, 0x8CA6
COLOR0, DEPTH_ATTACHMENT, OBJECT_TYPE, OBJECT_NAME, IS_TEXTURE = (
    0x8CE0,
    0x8D00,
    0x8CD0,
    0x8CD1,
    0x1702,
)
SAMPLES_PASSED, QUERY_RESULT, BLEND, WIDTH, HEIGHT, SAMPLES = (
    0x8914,
    0x8866,
    0x0BE2,
    0x1000,
    0x1001,
    0x9106,
)
IMMUTABLE, LAYERS = 0x912F, 0x8071
BITS = (0x805C, 0x805D, 0x805E, 0x805F, 0x884A, 0x88F1)


class Trace:
    """Adds up bytes; nothing of what passes declare is asked."""

    def __init__(self, ctx):
        uint, out = ctypes.c_uint, ctypes.c_void_p
        self._gl = {
            name: gl.function(ctx, name, *types)
            for name, types in {
                "glGetIntegerv": (uint, out),
                "glActiveTexture": (uint,),
                "glGetProgramiv": (uint, uint, out),
                "glGetActiveUniform": (uint, uint, ctypes.c_int, out, out, out, ctypes.c_char_p),
                "glGetUniformiv": (uint, ctypes.c_int, out),
                "glGetTextureParameteriv": (uint, uint, out),
                "glGetTextureLevelParameteriv": (uint, ctypes.c_int, uint, out),
                "glGetFramebufferAttachmentParameteriv": (uint, uint, uint, out),
                "glBeginQuery": (uint, uint),
                "glEndQuery": (uint,),
                "glGetQueryObjectui64v": (uint, uint, out),
            }.items()
        }
        where = ctypes.c_uint, ctypes.c_char_p
        self._location = gl.function(ctx, "glGetUniformLocation", *where, result=ctypes.c_int)
        self._enabled = gl.function(ctx, "glIsEnabled", uint, result=ctypes.c_ubyte)
        (self._query,) = queries(ctx, self, 1)
        self.begin()

    def draw(self, array, draw):
        scope, array.scope = array.scope, None  # entered here, so that its target can be asked for
        try:
            with scope or nullcontext():
                images, surfaces = self._inputs(array.program.glo)
                targets = self._targets()
                samples = self._samples_of(draw)
                blends = bool(self._enabled(BLEND))
        finally:
            array.scope = scope
        # Draws of one program after the other into the same targets are one pass.
        run = str(array.program.extra), tuple(targets.items()), blends
        if not self._runs or self._runs[-1] is None or self._runs[-1][0] != run:
            self._runs.append((run, {}, {}, [0]))
        _, read, painted, drawn = self._runs[-1]
        read.update(images)
        painted.update(surfaces)
        drawn[0] += samples

    def clear(self):
        self._runs.append(None)
        self._others += sum(map(_bytes, self._targets().values()))

    def copy(self, texture):
        self._runs.append(None)
        self._others += 2 * _bytes(self._size(texture))

    def begin(self):
        """Count from now on."""
        self._runs, self._others = [], 0.0

    @property
    def bytes(self):
        """Return the bytes since `begin`."""
        return self._others + sum(_bytes_of(*run) for run in self._runs if run)

    def _inputs(self, program):
        images, surfaces, active = {}, {}, self._get("glGetIntegerv", ACTIVE_TEXTURE)
        size, kind, text = ctypes.c_int(), ctypes.c_uint(), ctypes.create_string_buffer(256)
        for index in range(self._get("glGetProgramiv", program, ACTIVE_UNIFORMS)):
            self._gl["glGetActiveUniform"](
                program, index, 256, None, ctypes.byref(size), ctypes.byref(kind), text
            )
            if kind.value not in SAMPLERS:
                continue
            name, target = text.value.removesuffix(b"[0]"), SAMPLERS[kind.value]
            names = [name, *(b"%s[%d]" % (name, i) for i in range(1, size.value))]
            for each in names:
                unit = self._get("glGetUniformiv", program, self._location(program, each))
                self._gl["glActiveTexture"](TEXTURE0 + unit)
                if texture := self._get("glGetIntegerv", BINDINGS[target]):
                    # Arrays of eyes' images never change their storage; those of surfaces may.
                    of_eyes = self._get("glGetTextureParameteriv", texture, IMMUTABLE)
                    is_surface = target == TEXTURE_2D_ARRAY and not of_eyes
                    found = surfaces if is_surface else images
                    found[texture] = self._size(texture)
        self._gl["glActiveTexture"](active)
        return images, surfaces

    def _targets(self):
        ask, found = "glGetFramebufferAttachmentParameteriv", {}
        for attachment in (*range(COLOR0, COLOR0 + 8), DEPTH_ATTACHMENT):
            where = DRAW_FRAMEBUFFER, attachment
            if self._get(ask, *where, OBJECT_TYPE) == IS_TEXTURE:
                name = self._get(ask, *where, OBJECT_NAME)
                found[name] = self._size(name)
        return found

    def _size(self, texture):
        """Return width, height, samples with those of all layers, and bytes of a texel."""
        ask = "glGetTextureLevelParameteriv"
        width, height, samples, layers = (
            self._get(ask, texture, 0, each) for each in (WIDTH, HEIGHT, SAMPLES, LAYERS)
        )
        bits = sum(self._get(ask, texture, 0, each) for each in BITS)
        return width, height, max(1, samples) * layers, bits / 8

    def _samples_of(self, draw):
        self._gl["glBeginQuery"](SAMPLES_PASSED, self._query)
        draw()
        self._gl["glEndQuery"](SAMPLES_PASSED)
        found = ctypes.c_uint64()
        self._gl["glGetQueryObjectui64v"](self._query, QUERY_RESULT, ctypes.byref(found))
        return found.value

    def _get(self, function, *arguments):
        found = (ctypes.c_int * 16)()
        self._gl[function](*arguments, found)
        return int(found[0])


def _bytes_of(run, read, painted, drawn):
    targets, blends = dict(run[1]).values(), run[2]
    width, height, samples, _ = max(targets, key=lambda each: each[0] * each[1])
    pixels = drawn[0] / samples
    covered = pixels / (width * height)
    surfaces = min(sum(map(_bytes, painted.values())), 4 * pixels * len(painted))
    written = covered * sum(map(_bytes, targets))
    return min(1.0, covered) * sum(map(_bytes, read.values())) + surfaces + written * (1 + blends)


def _bytes(size):
    width, height, samples, texel = size
    return width * height * samples * texel


@contextmanager
def traced(ctx):
    """Yield the trace of all that is drawn, cleared and copied by what is made inside."""
    trace = Trace(ctx)
    render, indirect = moderngl.VertexArray.render, moderngl.VertexArray.render_indirect
    clear, copy, function = (
        moderngl.Framebuffer.clear,
        moderngl.Context.copy_framebuffer,
        gl.function,
    )

    def drawing(draw):
        return lambda array, *args, **kw: trace.draw(array, lambda: draw(array, *args, **kw))

    def clearing(target, *args, **kw):
        with ctx.scope(target):
            trace.clear()
        clear(target, *args, **kw)

    def copying(context, target, source):
        trace.copy(source.color_attachments[0].glo)
        copy(context, target, source)

    def function_of(context, name, *types, **options):
        found = function(context, name, *types, **options)
        if name != "glCopyImageSubData":
            return found

        def copy_image(source, *rest):
            trace.copy(source)
            found(source, *rest)

        return copy_image

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gl, "function", function_of)
        patch.setattr(moderngl.VertexArray, "render", drawing(render))
        patch.setattr(moderngl.VertexArray, "render_indirect", drawing(indirect))
        patch.setattr(moderngl.Framebuffer, "clear", clearing)
        patch.setattr(moderngl.Context, "copy_framebuffer", copying)
        yield trace
