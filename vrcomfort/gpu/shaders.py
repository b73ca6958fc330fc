"""Compiles the GLSL files of the `shaders` folder.

Files are named by what they do; shared functions are in ``shaders/include`` (one level deep).
Variants are made with defines, or by choosing an include file; never by pasting text.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from struct import Struct
from typing import Any, Literal

import moderngl
import numpy as np

from vrcomfort.gpu.gl import eyes_at_once, is_software
from vrcomfort.resources import data_folder

Defines = Mapping[str, int | float | str]
Chosen = Mapping[str, str]

_INCLUDE = re.compile(r'^[ \t]*#include[ \t]+"([^"]+)"', re.MULTILINE)
_MEMBER = re.compile(r"^\s*(mat4|vec[34]|float)\s+(\w+)\s*(?:\[(\d+)\])?\s*;", re.MULTILINE)
_VEC4_BYTES = 16
_ALWAYS: Defines = {"HALF_MAX": 65504.0}
"""Defines of every file: the greatest half float."""

_counting: ContextVar[Literal["all", "undrawn"] | None] = ContextVar("counting", default=None)


@contextmanager
def counting_reads(*, undrawn: bool = False) -> Iterator[None]:
    """Compile programs built inside so that they count their texture reads.

    Parameters
    ----------
    undrawn
        Count only those of texels that a pass was to draw and has not: `UNDRAWN` is in them.
    """
    token = _counting.set("undrawn" if undrawn else "all")
    try:
        yield
    finally:
        _counting.reset(token)


@cache
def source(name: str) -> str:
    """Return the text of a file in the `shaders` folder, such as ``include/view.glsl``."""
    return (data_folder("shaders") / name).read_text(encoding="utf-8")


def program(
    ctx: moderngl.Context,
    fragment: str | None,
    vertex: str = "common/fullscreen.vert",
    defines: Defines | None = None,
    chosen: Chosen | None = None,
) -> moderngl.Program:
    """Compile and link a pair of files; `fragment=None` draws depth only.

    Parameters
    ----------
    defines
        ``#define`` lines for both files; a boolean feature is a key with the value 1.
    chosen
        Which file an ``#include`` means that names none: a choice that is left to the caller.

    Returns
    -------
    Program
        Its `extra` is the name of the file of its last stage.

    Raises
    ------
    RuntimeError
        If the driver rejects the code; the message starts with the names of the files.
    """
    stages = [name for name in (vertex, fragment) if name is not None]
    files = (_with_chosen(source(name), chosen or {}) for name in stages)
    own = {"SOFTWARE_RASTERISER": 1} if is_software(ctx) else {}
    extension = eyes_at_once(ctx) if "EYES" in (defines or {}) else None
    texts = tuple(_with_defines(text, {**(defines or {}), **own}, extension) for text in files)
    if counting := _counting.get():
        texts = tuple(
            with_counted_reads(text, _included, undrawn=counting == "undrawn") for text in texts
        )
    for text in texts:
        _register_includes(ctx, text)
    try:
        made = ctx.program(texts[0], texts[1] if fragment else None)
    except moderngl.Error as error:
        variant = " ".join(f"{key}={value}" for key, value in (defines or {}).items())
        raise RuntimeError(f"{' + '.join(stages)} [{variant}]: {error}") from error
    made.extra = stages[-1]
    return made


def compute(
    ctx: moderngl.Context, name: str, defines: Defines | None = None
) -> moderngl.ComputeShader:
    """Compile a compute shader, with defines as in :func:`program`.

    Raises
    ------
    RuntimeError
        If the driver rejects the code; the message starts with the name of the file.
    """
    text = _with_defines(source(name), defines or {})
    if counting := _counting.get():
        text = with_counted_reads(text, _included, undrawn=counting == "undrawn")
    _register_includes(ctx, text)
    try:
        return ctx.compute_shader(text)
    except moderngl.Error as error:
        raise RuntimeError(f"{name}: {error}") from error


def _with_defines(text: str, defines: Defines, extension: str | None = None) -> str:
    """Put the defines after ``#version`` and keep the line numbers of the file."""
    version, rest = text.split("\n", 1)
    lines = [f"#extension {extension} : require"] if extension else []
    lines += [f"#define {name} {value}" for name, value in {**_ALWAYS, **defines}.items()]
    return "\n".join([version, *lines, "#line 2", rest])


def _included(name: str) -> str:
    return source(f"include/{name}")


def _with_chosen(text: str, chosen: Chosen) -> str:
    if not chosen:
        return text
    return _INCLUDE.sub(lambda line: f'#include "{chosen.get(line[1], line[1])}"', text)


@cache
def includes_of(text: str) -> tuple[str, ...]:
    """Return the names of the files that a text includes."""
    return tuple(_INCLUDE.findall(text))


def _register_includes(ctx: moderngl.Context, text: str) -> None:
    for name in includes_of(text):
        ctx.includes[name] = _included(name)


@cache
def constant(include: str, name: str) -> float:
    """Return a constant that an include file declares: the GLSL text is the only declaration."""
    text = source(f"include/{include}")
    found = re.search(rf"^const \w+ {name} = ([-.\w]+);", text, re.MULTILINE)
    if found is None:
        raise RuntimeError(f"{include} declares no constant {name}")
    return float(found[1])


@cache
def block_dtype(include: str, block: str) -> np.dtype[Any]:
    """Return the memory layout of a std140 uniform block that an include file declares.

    The GLSL text is the only declaration. Members must be `vec4`, `mat4` or arrays of them, which
    std140 packs without gaps, or `vec3` and `float` in an order that needs none. A `mat4` is (4, 4)
    with the matrix transposed: columns first.
    """
    return _members(include, f"uniform {block}")


@cache
def struct_dtype(include: str, struct: str) -> np.dtype[Any]:
    """Return the memory layout of a struct that blocks hold; see :func:`block_dtype`."""
    return _members(include, f"struct {struct}")


def _members(include: str, what: str) -> np.dtype[Any]:
    start = r"\s+".join(what.split())
    body = re.search(rf"{start}\s*\{{(.*?)\}}", source(f"include/{include}"), re.DOTALL)
    if body is None:
        raise RuntimeError(f"{include} declares no {what}")
    shapes = {"mat4": (4, 4), "vec4": (4,), "vec3": (3,), "float": ()}
    members = _MEMBER.findall(body[1])
    found = np.dtype(
        [
            (name, np.float32, (*([int(count)] if count else []), *shapes[kind]))
            for kind, name, count in members
        ]
    )
    for kind, name, count in members:
        packs = kind in ("vec4", "mat4") or not count
        if not packs or (kind != "float" and offset(found, name) % _VEC4_BYTES):
            raise RuntimeError(f"{include}: std140 leaves a gap at or in {name} of {what}")
    return found


class PackedStruct:
    """Packs a struct of std140 uniform blocks: a tenth of the time of a structured array.

    Raises
    ------
    RuntimeError
        If the include file declares other members, or in another order.
    """

    def __init__(self, include: str, struct: str, members: Sequence[str]) -> None:
        layout = struct_dtype(include, struct)
        if layout.names != tuple(members):
            raise RuntimeError(f"{include}: {struct} has {layout.names}; {members} are to fill it")
        # A struct is of whole vec4.
        self._struct = Struct(f"={layout.itemsize // 4}f{-layout.itemsize % _VEC4_BYTES}x")
        self.size_bytes = self._struct.size

    def packed(self, numbers: Iterable[float]) -> bytes:
        """Return the struct with the numbers of its members."""
        return self._struct.pack(*numbers)


def offset(block: np.dtype[Any], member: str) -> int:
    """Return where a member begins in a block, in bytes."""
    fields: Any = block.fields
    return int(fields[member][1])


def fullscreen(
    ctx: moderngl.Context,
    fragment: str,
    defines: Defines | None = None,
    chosen: Chosen | None = None,
) -> moderngl.VertexArray:
    """Return a full-screen triangle with its program: ``.render(vertices=3)`` draws it."""
    return ctx.vertex_array(program(ctx, fragment, defines=defines, chosen=chosen), [])


# Counting of texture reads: shaders are rewritten so that each invocation adds up its own.
#
# A read is one call of `texelFetch`, `texture`, `textureLod` and the like, or `imageLoad`, with any
# filter: a bilinear read of four texels is one, as is a gather. Reads of helper invocations do
# not count. Only reads that run count: a loop that is left early adds those so far.


READS_BINDING = 7
"""Of the shader storage buffer ``TexelReads``: reads (low and high 32 bits). The last of the eight
that OpenGL 4.5 promises: no shader of ours uses it."""

_READS_DECLARATION = f"""
layout(std430, binding = {READS_BINDING}) buffer TexelReads {{ uint texel_reads_of_all[2]; }};
uint texel_reads = 0u;
void add_texel_reads() {{
    if (texel_reads == 0u)
        return;
    uint before = atomicAdd(texel_reads_of_all[0], texel_reads);
    if (before + texel_reads < before)
        atomicAdd(texel_reads_of_all[1], 1u);
    texel_reads = 0u;
}}
"""

_READ = re.compile(
    r"\b(?:texelFetch(?:Offset)?|imageLoad|"
    r"texture(?:Lod|Grad|Proj|Gather)?(?:Lod|Grad)?(?:Offsets?)?)\s*\("
)
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_INCLUDE_LINE = re.compile(r'^[ \t]*#include[ \t]+"([^"]+)"[^\n]*', re.MULTILINE)
_MAIN = re.compile(r"\bvoid\s+main\s*\(\s*(?:void)?\s*\)")
_DISCARD = re.compile(r"\bdiscard\s*;")


UNDRAWN, UNDRAWN_DEPTH = math.nan, 0.98765432
"""What colours and depths hold that have not been drawn; integers have all bits set."""

_UNDRAWN_READS = f"""
// Filters carry what is no number on. The tiles that nobody sees have depth 1 before the resolve.
vec4 counted(vec4 v) {{
    texel_reads += uint(any(isnan(v)) || v.yzw == vec3(0.0, 0.0, 1.0)
                        && (v.x == {UNDRAWN_DEPTH} || v.x == 1.0));
    return v;
}}
vec4 counted_depths(vec4 v) {{
    texel_reads += uint(any(equal(v, vec4({UNDRAWN_DEPTH}))));
    return v;
}}
uvec4 counted(uvec4 v) {{
    texel_reads += uint(v == uvec4(0xffffffffu));
    return v;
}}
float counted(float v) {{ return v; }}
"""
_COUNT = "(texel_reads += 1u, "


def with_counted_reads(text: str, include: Callable[[str], str], *, undrawn: bool = False) -> str:
    """Return a shader that counts its reads into the buffer at :data:`READS_BINDING`.

    Parameters
    ----------
    text
        Of a vertex, fragment or compute shader, starting with ``#version``.
    include
        Gives the text of an included file.
    undrawn
        As in :func:`counting_reads`.
    """
    version, rest = text.split("\n", 1)
    rest = _INCLUDE_LINE.sub(lambda found: include(found[1]), rest)
    body = _with_reads(_COMMENT.sub(" ", rest), undrawn=undrawn)
    if body == _COMMENT.sub(" ", rest):
        return "\n".join([version, body])
    body = _DISCARD.sub("{ add_texel_reads(); discard; }", body)
    body = _MAIN.sub("void main_that_reads()", body)
    main = "void main() { main_that_reads(); add_texel_reads(); }\n"
    head = _extensions(body)
    declared = _READS_DECLARATION + (_UNDRAWN_READS if undrawn else "")
    return "\n".join([version, body[:head], declared, body[head:], main])


def _extensions(body: str) -> int:
    """Return where the lines end that must come before all code: those about extensions."""
    last = body.rfind("#extension")
    return 0 if last < 0 else body.index("\n", last) + 1


def _with_reads(text: str, *, undrawn: bool) -> str:
    """Return the text with `(texel_reads += 1u, read(…))` for every read, inner ones too.

    With `undrawn` it is `counted(read(…))`: what is read decides.
    """
    found = _READ.search(text)
    if found is None:
        return text
    end = _closing(text, found.end())
    inner = _with_reads(text[found.end() : end], undrawn=undrawn)
    gathered = found[0].startswith("textureGather")
    before = ("counted_depths(" if gathered else "counted(") if undrawn else _COUNT
    call = f"{before}{found[0]}{inner}))"
    return text[: found.start()] + call + _with_reads(text[end + 1 :], undrawn=undrawn)


def _closing(text: str, start: int) -> int:
    """Return where the bracket closes that was opened just before `start`."""
    depth = 1
    for index in range(start, len(text)):
        depth += {"(": 1, ")": -1}.get(text[index], 0)
        if depth == 0:
            return index
    raise ValueError("a call in a shader is not closed")
