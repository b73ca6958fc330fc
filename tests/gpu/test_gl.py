import ctypes

import numpy as np
import pytest

from vrcomfort.errors import InputError
from vrcomfort.geometry import Fov, clip_from_view
from vrcomfort.gpu import gl, shaders

ATTACHMENT_COMPONENT_TYPE, FRAMEBUFFER, DEPTH, FLOAT = 0x8211, 0x8D40, 0x8D00, 0x1406

POINT = """#version 450 core
uniform mat4 clip_from_view;
uniform float distance_m;
void main() { gl_Position = clip_from_view * vec4(0.0, 0.0, -distance_m, 1.0); gl_PointSize = 4.0; }
"""


@pytest.mark.parametrize("samples", [0, 4])
def test_depth_attachment_is_float(ctx, samples):
    depth = gl.depth_texture(ctx, (8, 8), samples=samples)
    target = ctx.framebuffer([], depth)
    target.use()
    kind = ctypes.c_int()
    query = gl.function(
        ctx, "glGetFramebufferAttachmentParameteriv", *[ctypes.c_uint] * 3, ctypes.c_void_p
    )
    query(FRAMEBUFFER, DEPTH, ATTACHMENT_COMPONENT_TYPE, ctypes.byref(kind))
    assert kind.value == FLOAT


def _drawn_depth(ctx, distance_m):
    depth = gl.depth_texture(ctx, (4, 4))
    target = ctx.framebuffer([], depth)
    points = ctx.vertex_array(ctx.program(POINT, "#version 450 core\nvoid main() {}"), [])
    matrix = clip_from_view(Fov.symmetric(vertical_rad=1.0, aspect=1.0), 0.02)
    points.program["clip_from_view"].write(matrix.T.astype("f4", order="C"))
    points.program["distance_m"] = distance_m
    target.use()
    target.clear(depth=0.0)
    ctx.depth_func = gl.DEPTH_FUNC
    with ctx.scope(target, enable_only=ctx.DEPTH_TEST | ctx.PROGRAM_POINT_SIZE):
        points.render(ctx.POINTS, vertices=1)
    return np.frombuffer(depth.read(), np.float32)[0]


def test_distances_of_thirty_kilometres_differ(ctx):
    far, less_far = _drawn_depth(ctx, 30_000.0), _drawn_depth(ctx, 29_995.0)
    assert less_far > far > 0
    np.testing.assert_allclose(0.02 / np.array([far, less_far]), [30_000, 29_995], rtol=1e-6)


def test_a_shader_error_names_the_files_and_the_variant(session_context, monkeypatch):
    # Not `ctx`: moderngl itself leaks the program object of code that does not compile.
    texts, source = {"a.frag": "#version 450\nbad"}, shaders.source
    monkeypatch.setattr(shaders, "source", lambda name: texts.get(name) or source(name))
    with pytest.raises(RuntimeError, match=r"a\.frag \[RINGS=3\]"):
        shaders.program(session_context, "a.frag", defines={"RINGS": 3})


def test_missing_driver_says_what_to_install(monkeypatch):
    def fail(**settings):
        raise ValueError("no display")

    monkeypatch.setattr(gl.moderngl, "create_context", fail)
    with pytest.raises(InputError, match="libegl1"):
        gl.create_context()


def test_a_compute_shader_has_its_includes_before_any_other_program() -> None:
    ctx = gl.create_context()
    try:
        with ctx:
            shaders.compute(ctx, "display/image_hash.comp")
    finally:
        ctx.release()


def test_a_context_says_what_it_is_also_while_none_is_current() -> None:
    ctx = gl.create_context()
    gl.release(gl.create_context())
    assert ctx.info["GL_RENDERER"] != ""
    ctx.release()
