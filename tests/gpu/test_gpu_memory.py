"""What `plan` calls GPU memory is what OpenGL says the objects hold, for every pipeline."""

import ctypes
import gc
import re
from pathlib import Path
from typing import get_args

import pytest

from tests.support.render import still_life
from vrcomfort.gpu import gl
from vrcomfort.gpu import memory as gpu_memory
from vrcomfort.protocol.conditions import (
    Condition,
    DepthOfField,
    Focus,
    GazeCentre,
    Kernel,
    MotionBlur,
    Peripheral,
    SpeedBlur,
    TurnRamp,
    Vignette,
)
from vrcomfort.render.pipeline import StereoRenderer

RENDER = Path(gl.__file__).parent
SIZE = (45, 33)
WIDTH, HEIGHT, LAYERS, SAMPLES, BUFFER_SIZE = 0x1000, 0x1001, 0x8071, 0x9106, 0x8764
IMMUTABLE = 0x912F
CHANNELS = (0x805C, 0x805D, 0x805E, 0x805F, 0x884A)
"""Bits of red, green, blue, alpha and depth."""

KERNELS = get_args(Kernel)
FOCUS = get_args(Focus.model_fields["method"].annotation)
CONDITIONS = [
    Condition(name="plain"),
    Condition(name="shutter", motion_blur=MotionBlur()),
    Condition(name="speed", speed_blur=SpeedBlur(turning=TurnRamp(from_deg_s=0, to_deg_s=60))),
    Condition(
        name="round_the_gaze",
        focus=Focus(method="autofocus_zone"),
        depth_of_field=DepthOfField(peripheral=Peripheral()),
        vignette=Vignette(),
        gaze_centre=GazeCentre(of=("autofocus_zone", "peripheral", "vignette")),
    ),
    *(
        Condition(
            name=method,
            focus=Focus(method=method, script=[(0.0, 2.0)] if method == "scripted" else []),
            depth_of_field=DepthOfField(),
        )
        for method in FOCUS
    ),
    *(
        Condition(name=kernel, depth_of_field=DepthOfField(kernel=kernel), motion_blur=MotionBlur())
        for kernel in KERNELS
    ),
]


class Survey:
    """Asks OpenGL, not us, what all objects of the context hold."""

    def __init__(self, ctx):
        self._ctx = ctx
        self._level = self._function("glGetTextureLevelParameteriv", 3)
        self._size = self._function("glGetNamedBufferParameteriv", 2)
        self._parameter = self._function("glGetTextureParameteriv", 2)

    def _function(self, name, numbers):
        call = gl.function(self._ctx, name, *[ctypes.c_uint] * numbers, ctypes.c_void_p)

        def ask(*arguments):
            value = ctypes.c_int()
            call(*arguments, ctypes.byref(value))
            return value.value

        return ask

    def _names(self, kind):
        exists = gl.function(self._ctx, f"glIs{kind}", ctypes.c_uint, result=ctypes.c_ubyte)
        newest = ctypes.c_uint()
        for verb in ("Gen", "Delete"):
            call = gl.function(self._ctx, f"gl{verb}{kind}s", ctypes.c_int, ctypes.c_void_p)
            call(1, ctypes.byref(newest))
        return {name for name in range(1, newest.value) if exists(name)}

    def _is_view(self, name):
        """Return whether it is a layer of another one: only those and arrays are immutable."""
        return self._parameter(name, IMMUTABLE) and self._level(name, 0, LAYERS) == 1

    def _texture_bytes(self, name):
        if self._is_view(name):
            return 0
        bits = sum(self._level(name, 0, channel) for channel in CHANNELS)
        samples = self._level(name, 0, SAMPLES)
        levels = 1 if samples else 14  # of the largest texture that drivers must allow
        texels = sum(
            self._level(name, level, WIDTH) * self._level(name, level, HEIGHT)
            for level in range(levels)
        )
        return texels * bits // 8 * max(samples, 1) * self._level(name, 0, LAYERS)

    def names(self):
        return {kind: self._names(kind) for kind in ("Texture", "Buffer", "Renderbuffer")}

    def bytes_since(self, before):
        made = {kind: names - before[kind] for kind, names in self.names().items()}
        textures = sum(map(self._texture_bytes, made["Texture"]))
        buffers = sum(self._size(name, BUFFER_SIZE) for name in made["Buffer"])
        return {
            "textures": textures,
            "buffers": buffers,
            "renderbuffers": len(made["Renderbuffer"]),
        }


def entered(renderer):
    entries = renderer.memory()
    return {
        "textures": sum(each.bytes for each in entries if each.kind != "buffer"),
        "buffers": sum(each.bytes for each in entries if each.kind == "buffer"),
        "renderbuffers": 0,
    }


@pytest.mark.parametrize(
    ("condition", "samples"),
    [(each, 2 + 2 * (index % 2)) for index, each in enumerate(CONDITIONS)],
    ids=lambda given: getattr(given, "name", given),
)
def test_memory_is_what_opengl_says_the_objects_hold(ctx, condition, samples):
    """And nothing as soon as the pipeline is gone, before Python looks for cycles."""
    survey, account = Survey(ctx), gpu_memory.account(ctx)
    before, first = survey.names(), account.mark()
    renderer = StereoRenderer(ctx, SIZE, samples=samples)
    gc.disable()
    try:
        renderer.build(still_life(), condition)
        assert entered(renderer) == survey.bytes_since(before)
        assert account.between(first, account.mark())
        renderer.release()
        assert account.between(first, account.mark()) == ()
    finally:
        gc.enable()


@pytest.mark.parametrize("condition", CONDITIONS, ids=lambda condition: condition.name)
def test_drawing_allocates_no_more_textures(ctx, condition):
    survey = Survey(ctx)
    before = survey.names()
    renderer = StereoRenderer(ctx, SIZE)
    renderer.begin(still_life(), condition)
    renderer.drain()
    assert entered(renderer)["textures"] == survey.bytes_since(before)["textures"]


@pytest.mark.slow
def test_memory_of_a_headsets_size_is_allocated(ctx):
    survey = Survey(ctx)
    before = survey.names()
    renderer = StereoRenderer(ctx, (1832, 1920))
    renderer.build(still_life(), CONDITIONS[-1])
    assert entered(renderer) == survey.bytes_since(before)
    pixels = 1832 * 1920
    # Colour, depth and velocity with four samples and with one, and two tone-mapped images.
    least = pixels * (5 * (8 + 4 + 4) + 2 * 4)
    assert entered(renderer)["textures"] > least


def test_mipmaps_go_down_to_one_texel():
    assert gpu_memory.texture_bytes((5, 2), 4, mipmaps=True) == 4 * (10 + 2 + 1)
    assert gpu_memory.texture_bytes((5, 2), 8, samples=4) == 320


def test_everything_that_renders_allocates_through_the_account():
    """Or it would be missing from what `vrcomfort passes` says."""
    raw = re.compile(r"\w*ctx\.(texture\w*|depth_texture\w*|buffer|\w*renderbuffer|simple_\w+)\(")
    found = {
        f"{file.relative_to(RENDER)}: {call[0]}"
        for file in RENDER.rglob("*.py")
        for call in raw.finditer(file.read_text(encoding="utf-8"))
    }
    kinds = ("texture", "texture_array", "depth_texture", "buffer")
    assert found == {f"gl.py: ctx.{kind}(" for kind in kinds}
