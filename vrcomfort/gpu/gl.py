"""The context, and the few features that moderngl lacks: float depth and [0, 1] clip depth.

Everything that is drawn into the scene is in reverse-Z: depth 1 on the near plane, 0 at infinity,
``GL_GREATER`` wins. Only a 32-bit float depth buffer and a [0, 1] clip range make that precise
(2 mm at 30 km); see https://developer.nvidia.com/blog/visualizing-depth-precision/.
"""

from __future__ import annotations

import ctypes
import sys
import weakref
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import moderngl

from vrcomfort.errors import InputError
from vrcomfort.gpu import adapters, passes
from vrcomfort.gpu import memory as gpu_memory
from vrcomfort.gpu.passes import AnyTexture

MINIMUM_VERSION = 450
"""OpenGL 4.5: the first with clip control. The README names it, too."""

VERSION_NAME = f"{MINIMUM_VERSION // 100}.{MINIMUM_VERSION // 10 % 10}"

DEPTH_FUNC = ">"
"""Nearer is greater, everywhere in `render` (shadow maps too)."""

LATENCY = 4
"""Frames between drawing and reading something back: more than drivers queue, so that the CPU does
not wait. Nothing that is read back is shown."""

_LOWER_LEFT, _ZERO_TO_ONE = 0x8CA1, 0x935F
_TEXTURE_2D, _TEXTURE_2D_MULTISAMPLE = 0x0DE1, 0x9100
_DEPTH_COMPONENT, _DEPTH_COMPONENT32F, _FLOAT = 0x1902, 0x8CAC, 0x1406
_SRGB8_ALPHA8, _TEXTURE_SAMPLES, _SAMPLE_POSITION = 0x8C43, 0x9106, 0x8E50
_TEXTURE_2D_ARRAY, _RGBA8, _RGBA, _UNSIGNED_BYTE = 0x8C1A, 0x8058, 0x1908, 0x1401
_INTERNAL_FORMAT, _FRAMEBUFFER_DEPTH = 0x1003, 0x8D00

_DYNAMIC_DRAW = 0x88E8

_UNIFORM_ALIGNMENT = 256
"""The most that GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT may be."""


FILTERED_UNIT, _FILTERED_UNITS = 16, 16
"""The first of the texture units on which every texture is filtered and clamps to its edge, and how
many they are: as many as a shader may read."""

_SAMPLER = {0x2800: 0x2601, 0x2801: 0x2601, 0x2802: 0x812F, 0x2803: 0x812F}
"""GL_TEXTURE_MAG_FILTER and _MIN_FILTER: linear; _WRAP_S and _WRAP_T: to the edge."""


def create_context() -> moderngl.Context:
    """Return a context without a window, in reverse-Z clip space.

    Raises
    ------
    InputError
        If the machine has no OpenGL of `MINIMUM_VERSION`; says what to install.
    """
    backend: dict[str, Any] = {"backend": "egl"} if sys.platform.startswith("linux") else {}
    try:
        ctx = moderngl.create_context(standalone=True, require=MINIMUM_VERSION, **backend)
    except Exception as error:
        raise InputError(
            f"no OpenGL {VERSION_NAME} context could be made ({error}); install a driver: "
            "on Debian or Ubuntu 'apt-get install libegl1 libgl1 libgl1-mesa-dri', on Fedora "
            "'dnf install mesa-libEGL mesa-libGL mesa-dri-drivers', elsewhere your graphics driver"
        ) from error
    return prepare(ctx)


def prepare(ctx: moderngl.Context) -> moderngl.Context:
    """Set the clip space that `geometry.clip_from_view` assumes, on any context.

    Objects that die wait for :func:`collect`: their names may be those of others in the context
    that is current then.
    """
    ctx.gc_mode = "context_gc"
    _ = ctx.info  # moderngl keeps what it reads first, which is blank where no context is current
    weakref.finalize(ctx, ctx.mglo.release).atexit = False
    function(ctx, "glClipControl", ctypes.c_uint, ctypes.c_uint)(_LOWER_LEFT, _ZERO_TO_ONE)
    sampler, uint = ctypes.c_uint(), ctypes.c_uint  # for as long as there is the context
    function(ctx, "glGenSamplers", ctypes.c_int, ctypes.c_void_p)(1, ctypes.byref(sampler))
    for name, value in _SAMPLER.items():
        function(ctx, "glSamplerParameteri", uint, uint, ctypes.c_int)(sampler, name, value)
    for unit in range(FILTERED_UNIT, FILTERED_UNIT + _FILTERED_UNITS):
        function(ctx, "glBindSampler", uint, uint)(unit, sampler)
    return ctx


def release(ctx: moderngl.Context) -> None:
    """Release a context without a window; then none is current.

    While one of EGL is, GLX makes no context of a window current.
    """
    ctx.release()
    if sys.platform.startswith("linux"):
        ctypes.CDLL("libEGL.so.1").eglReleaseThread()


def collect(ctx: moderngl.Context) -> None:
    """Release all objects that have died; the context is the current one."""
    while ctx.objects:
        dead = ctx.objects.popleft()
        if not isinstance(dead, moderngl.InvalidObject):  # released by hand
            dead.release()


def function(
    ctx: moderngl.Context, name: str, *types: Any, result: Any = None
) -> Callable[..., Any]:
    """Return an OpenGL function that moderngl has no name for, for the context that is current."""
    loader = ctx.mglo._context
    # A context of our own and one that a window made look functions up by different names.
    address = (getattr(loader, "load", None) or loader.load_opengl_function)(name)
    if not address:
        raise InputError(f"this OpenGL driver has no {name}; update the graphics driver")
    prototype = getattr(ctypes, "WINFUNCTYPE", ctypes.CFUNCTYPE)(result, *types)
    call: Callable[..., Any] = prototype(address)
    return call


def depth_texture(
    ctx: moderngl.Context, size_px: tuple[int, int], *, samples: int = 0
) -> moderngl.Texture:
    """Return a D32F texture: attach it as depth, sample it as `sampler2D` (or `sampler2DMS`).

    moderngl allocates 24-bit integers; the same texture gets new storage here, so that moderngl
    still owns, attaches and releases it.
    """
    texture = ctx.depth_texture(size_px, samples=samples)
    bind = function(ctx, "glBindTexture", ctypes.c_uint, ctypes.c_uint)
    if samples:
        bind(_TEXTURE_2D_MULTISAMPLE, texture.glo)
        allocate = function(ctx, "glTexImage2DMultisample", *[ctypes.c_int] * 5, ctypes.c_ubyte)
        allocate(_TEXTURE_2D_MULTISAMPLE, samples, _DEPTH_COMPONENT32F, *size_px, 1)
        return _entered(ctx, texture, 1, "f4")
    bind(_TEXTURE_2D, texture.glo)
    allocate = function(ctx, "glTexImage2D", *[ctypes.c_int] * 8, ctypes.c_void_p)
    allocate(_TEXTURE_2D, 0, _DEPTH_COMPONENT32F, *size_px, 0, _DEPTH_COMPONENT, _FLOAT, None)
    return _entered(ctx, point_sampled(texture, comparison=False), 1, "f4")


def copier(ctx: moderngl.Context, source: AnyTexture, target: AnyTexture) -> Callable[[], None]:
    """Return a function that copies a single-sample texture (depth too) over another like it.

    `Context.copy_framebuffer` copies colour only.
    """
    copy = function(ctx, "glCopyImageSubData", *[ctypes.c_int] * 15)
    level_and_corner, layers = (0, 0, 0, 0), layers_of(source)
    place = (_TEXTURE_2D_ARRAY if layers > 1 else _TEXTURE_2D, *level_and_corner)
    size = (*size_px_of(source), layers)
    draw = partial(copy, source.glo, *place, target.glo, *place, *size)
    return partial(passes.run_copy, source, target, draw)


def binder(
    ctx: moderngl.Context,
    textures: Sequence[AnyTexture | None],
    first_unit: int = 0,
    *,
    images: bool = False,
) -> Callable[[], None]:
    """Return a function that puts textures on units that follow each other, with one call.

    Parameters
    ----------
    images
        On image units, which compute shaders store into.
    """
    kept = tuple(textures)
    names = (ctypes.c_uint * len(kept))(*(0 if each is None else each.glo for each in kept))
    name = "glBindImageTextures" if images else "glBindTextures"
    bind = function(ctx, name, ctypes.c_uint, ctypes.c_int, ctypes.c_void_p)
    bind_all = partial(bind, first_unit, len(kept), names)
    vars(bind_all)["textures"] = kept  # which live as long as it does
    return bind_all


def color_texture(
    ctx: moderngl.Context,
    size_px: tuple[int, int],
    *,
    components: int = 4,
    dtype: str = "f2",
    samples: int = 0,
) -> moderngl.Texture:
    """Return a texture to draw into; single-sample ones clamp to their edge and are not filtered.

    `dtype` is moderngl's: ``f2`` half float, ``f4`` float, ``f1`` 8-bit normalised.
    """
    texture = ctx.texture(size_px, components, dtype=dtype, samples=samples)
    return _entered(ctx, texture if samples else point_sampled(texture), components, dtype)


EYES_AT_ONCE = {"GL_ARB_shader_viewport_layer_array", "GL_AMD_vertex_shader_layer"}
"""Extensions with either of which a vertex shader says in which layer it draws."""


def eyes_at_once(ctx: moderngl.Context) -> str | None:
    """Return the extension by which passes draw both eyes at once; None where there is none."""
    return min(EYES_AT_ONCE & ctx.extensions, default=None)


def eye_texture(
    ctx: moderngl.Context,
    size_px: tuple[int, int],
    eyes: int,
    *,
    components: int = 4,
    dtype: str = "f2",
) -> AnyTexture:
    """Return a texture as :func:`color_texture` does, or one with a layer for each eye."""
    if eyes == 1:
        return color_texture(ctx, size_px, components=components, dtype=dtype)
    return _array(ctx, size_px, eyes, components, dtype)


def eye_depth(ctx: moderngl.Context, size_px: tuple[int, int], eyes: int) -> AnyTexture:
    """Return a texture as :func:`depth_texture` does, or one with a layer for each eye."""
    if eyes == 1:
        return depth_texture(ctx, size_px)
    return _array(ctx, size_px, eyes, 1, "f4", _DEPTH_COMPONENT32F)


def _array(
    ctx: moderngl.Context,
    size_px: tuple[int, int],
    eyes: int,
    components: int,
    dtype: str,
    internal_format: int = 0,
) -> moderngl.TextureArray:
    """Return an array, to draw into; its storage never changes, so that it can have views."""
    texture = ctx.texture_array((*size_px, eyes), components, dtype=dtype)
    store = function(ctx, "glTextureStorage3D", ctypes.c_uint, *[ctypes.c_int] * 5)
    given = internal_format or _internal_format(texture)
    store(texture.glo, 1, given, *size_px, eyes)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    texture.repeat_x = texture.repeat_y = False
    entry = gpu_memory.texture("target", size_px, components, dtype, layers=eyes)
    gpu_memory.account(ctx).add(texture, entry)
    return texture


def layers_of(texture: AnyTexture) -> int:
    """Return the number of images in a texture, one for each eye."""
    return texture.layers if isinstance(texture, moderngl.TextureArray) else 1


def size_px_of(texture: AnyTexture) -> tuple[int, int]:
    """Return (width, height)."""
    return texture.width, texture.height


def of_eye(texture: AnyTexture, eye: int) -> moderngl.Texture:
    """Return an eye's image alone: a layer as a texture of its own, which is kept while it is."""
    if isinstance(texture, moderngl.Texture):
        return texture
    ctx, uint = texture.ctx, ctypes.c_uint
    (name,) = made = names(ctx, "Textures", 1)
    view = function(ctx, "glTextureView", *[uint] * 8)
    view(name, _TEXTURE_2D, texture.glo, _internal_format(texture), 0, 1, eye, 1)
    found = ctx.external_texture(name, size_px_of(texture), texture.components, 0, texture.dtype)
    found.extra = texture
    owned(ctx, found, "Textures", made)
    return point_sampled(found)


def _internal_format(texture: AnyTexture) -> int:
    return _level_parameter(texture, _INTERNAL_FORMAT)


def _level_parameter(texture: AnyTexture, parameter: int) -> int:
    given = ctypes.c_int()
    name = "glGetTextureLevelParameteriv"
    ask = function(texture.ctx, name, *[ctypes.c_uint] * 3, ctypes.c_void_p)
    ask(texture.glo, 0, parameter, ctypes.byref(given))
    return given.value


def read(texture: AnyTexture) -> bytes:
    """Return all texels, in the texture's own type (this waits for the GPU)."""
    if _internal_format(texture) != _DEPTH_COMPONENT32F:
        return texture.read()
    ctx, count = texture.ctx, texture.width * texture.height * layers_of(texture)
    texels, types = (ctypes.c_float * count)(), [ctypes.c_uint] * 4
    get = function(ctx, "glGetTextureImage", *types, ctypes.c_int, ctypes.c_void_p)
    get(texture.glo, 0, _DEPTH_COMPONENT, _FLOAT, ctypes.sizeof(texels), texels)
    return bytes(texels)


def framebuffer(
    ctx: moderngl.Context, colours: Sequence[AnyTexture], depth: AnyTexture | None = None
) -> moderngl.Framebuffer:
    """Return a framebuffer of all layers; moderngl takes no array as depth, nor a layer of one."""
    if depth is None or (isinstance(depth, moderngl.Texture) and depth.depth):
        return ctx.framebuffer(colours, depth)
    made = ctx.framebuffer(colours) if colours else ctx.empty_framebuffer(size_px_of(depth))
    uint = ctypes.c_uint
    attach = function(ctx, "glNamedFramebufferTexture", uint, uint, uint, ctypes.c_int)
    attach(made.glo, _FRAMEBUFFER_DEPTH, depth.glo, 0)
    made.depth_mask = True
    made.extra = depth  # which lives as long as it does
    return made


class _Names(NamedTuple):
    """OpenGL's names, which :func:`collect` releases."""

    delete: Callable[..., object]
    names: ctypes.Array[ctypes.c_uint]

    def release(self) -> None:
        self.delete(len(self.names), self.names)


def names(ctx: moderngl.Context, kind: str, count: int) -> ctypes.Array[ctypes.c_uint]:
    """Return new names of a kind of OpenGL's objects: ``Queries`` or ``Textures``."""
    made = (ctypes.c_uint * count)()
    function(ctx, f"glGen{kind}", ctypes.c_int, ctypes.c_void_p)(count, made)
    return made


def owned(
    ctx: moderngl.Context, owner: object, kind: str, made: ctypes.Array[ctypes.c_uint]
) -> None:
    """Let objects of OpenGL die with their owner."""
    dead = _Names(function(ctx, f"glDelete{kind}", ctypes.c_int, ctypes.c_void_p), made)
    weakref.finalize(owner, ctx.objects.append, dead).atexit = False


_WRAPS = {"repeat": 0x2901, "clamp_to_edge": 0x812F, "mirrored_repeat": 0x8370}
_WRAP_S, _WRAP_T = 0x2802, 0x2803


def wrap(ctx: moderngl.Context, texture: moderngl.TextureArray, ways: tuple[str, str]) -> None:
    """Say how a texture goes on outside of [0, 1], in u and in v (moderngl mirrors nothing)."""
    function(ctx, "glBindTexture", ctypes.c_uint, ctypes.c_uint)(_TEXTURE_2D_ARRAY, texture.glo)
    parameter = function(ctx, "glTexParameteri", ctypes.c_uint, ctypes.c_uint, ctypes.c_int)
    for axis, way in zip((_WRAP_S, _WRAP_T), ways, strict=True):
        parameter(_TEXTURE_2D_ARRAY, axis, _WRAPS[way])


def image_array(
    ctx: moderngl.Context, size_px: tuple[int, int], layers: Sequence[bytes], *, srgb: bool
) -> moderngl.TextureArray:
    """Return 8-bit RGBA pictures with mipmaps; `srgb` is decoded to linear when sampled.

    moderngl has no sRGB arrays; the same texture gets new storage here, as in `depth_texture`.
    """
    width, height = size_px
    texture = ctx.texture_array((*size_px, len(layers)), 4)
    function(ctx, "glBindTexture", ctypes.c_uint, ctypes.c_uint)(_TEXTURE_2D_ARRAY, texture.glo)
    allocate = function(ctx, "glTexImage3D", *[ctypes.c_int] * 9, ctypes.c_void_p)
    kind = _SRGB8_ALPHA8 if srgb else _RGBA8
    shape = (width, height, len(layers))
    allocate(_TEXTURE_2D_ARRAY, 0, kind, *shape, 0, _RGBA, _UNSIGNED_BYTE, None)
    for layer, pixels in enumerate(layers):
        texture.write(pixels, viewport=(0, 0, layer, width, height, 1))
    texture.build_mipmaps()
    entry = gpu_memory.texture("image", size_px, 4, "f1", mipmaps=True, layers=len(layers))
    gpu_memory.account(ctx).add(texture, entry)
    return texture


def buffer(ctx: moderngl.Context, data: bytes) -> moderngl.Buffer:
    """Return a buffer that holds `data` for good."""
    return _entered_buffer(ctx, ctx.buffer(data))


def dynamic_buffer(ctx: moderngl.Context, size_bytes: int) -> moderngl.Buffer:
    """Return a buffer that is rewritten every frame."""
    return _entered_buffer(ctx, ctx.buffer(reserve=size_bytes, dynamic=True))


def rewriter(ctx: moderngl.Context, buffer: moderngl.Buffer) -> Callable[[bytes], None]:
    """Return a function that replaces all of a buffer; draws that are under way keep the old."""
    uint = ctypes.c_uint
    replace = function(ctx, "glNamedBufferData", uint, ctypes.c_ssize_t, ctypes.c_void_p, uint)
    name = buffer.glo

    def rewrite(content: bytes) -> None:
        replace(name, len(content), content, _DYNAMIC_DRAW)

    return rewrite


def uniform_stride(size_bytes: int) -> int:
    """Return how far apart in a buffer uniform blocks of a size may begin, on every driver."""
    return -(-size_bytes // _UNIFORM_ALIGNMENT) * _UNIFORM_ALIGNMENT


def _entered_buffer(ctx: moderngl.Context, made: moderngl.Buffer) -> moderngl.Buffer:
    entry = gpu_memory.GpuAllocation("buffer", f"{made.size} bytes", made.size)
    gpu_memory.account(ctx).add(made, entry)
    return made


def _entered(
    ctx: moderngl.Context, target: moderngl.Texture, components: int, dtype: str
) -> moderngl.Texture:
    # At least as many as were asked for.
    samples = _level_parameter(target, _TEXTURE_SAMPLES) if target.samples else 0
    entry = gpu_memory.texture("target", target.size, components, dtype, samples=samples)
    gpu_memory.account(ctx).add(target, entry)
    return target


def sample_places(ctx: moderngl.Context, samples: int) -> list[tuple[float, float]]:
    """Return where in a pixel each sample of the framebuffer in use is: (x, y) in [0, 1]."""
    ask = function(ctx, "glGetMultisamplefv", ctypes.c_uint, ctypes.c_uint, ctypes.c_void_p)
    places = []
    for sample in range(samples):
        place = (ctypes.c_float * 2)()
        ask(_SAMPLE_POSITION, sample, place)
        places.append((float(place[0]), float(place[1])))
    return places


def point_sampled(texture: moderngl.Texture, *, comparison: bool | None = None) -> moderngl.Texture:
    """Switch filtering and repetition off; `comparison=False` reads a depth texture as values."""
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    texture.repeat_x = texture.repeat_y = False
    if comparison is False:
        texture.compare_func = ""
    return texture


def is_software(ctx: moderngl.Context) -> bool:
    """Return whether a rasteriser without a GPU draws."""
    return adapters.draws_in_software(str(ctx.info["GL_RENDERER"]))


def check_errors(ctx: moderngl.Context) -> None:
    """Raise if OpenGL has recorded an error since the last call (this waits for the driver)."""
    error = ctx.error
    if error != "GL_NO_ERROR":
        raise RuntimeError(f"OpenGL reports {error}")


def describe(ctx: moderngl.Context) -> dict[str, str]:
    """Return the driver's own words: vendor, renderer, version, and the GLSL version."""
    names = {"GL_VENDOR": "vendor", "GL_RENDERER": "renderer", "GL_VERSION": "version"}
    return {name: str(ctx.info[key]) for key, name in names.items()}
