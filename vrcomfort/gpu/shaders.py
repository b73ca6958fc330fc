"""Compiles the GLSL files of the `shaders` folder.

Files are named by what they do; shared functions are in ``shaders/include`` (one level deep).
Variants are made with defines, or by choosing an include file; never by pasting text.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from typing import Any

import moderngl
import numpy as np

from vrcomfort.gpu import texel_reads
from vrcomfort.resources import data_folder

Defines = Mapping[str, int | float | str]
Chosen = Mapping[str, str]

_INCLUDE = re.compile(r'^[ \t]*#include[ \t]+"([^"]+)"', re.MULTILINE)
_MEMBER = re.compile(r"^\s*(mat4|vec4)\s+(\w+)\s*(?:\[(\d+)\])?\s*;", re.MULTILINE)


_counting: ContextVar[bool] = ContextVar("counting", default=False)


@contextmanager
def counting_reads() -> Iterator[None]:
    """Compile what is built inside so that it counts its texture reads: `gpu.texel_reads`."""
    token = _counting.set(True)
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
        Which file an ``#include`` means that names none: a choice that is left to who compiles.

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
    texts = tuple(_with_defines(text, defines or {}) for text in files)
    if _counting.get():
        texts = tuple(texel_reads.counted(text, _included) for text in texts)
    for text in texts:
        _register_includes(ctx, text)
    try:
        made = ctx.program(texts[0], texts[1] if fragment else None)
    except moderngl.Error as error:
        variant = " ".join(f"{key}={value}" for key, value in (defines or {}).items())
        raise RuntimeError(f"{' + '.join(stages)} [{variant}]: {error}") from error
    made.extra = stages[-1]
    return made


def compute(ctx: moderngl.Context, name: str) -> moderngl.ComputeShader:
    """Compile a compute shader.

    Raises
    ------
    RuntimeError
        If the driver rejects the code; the message starts with the name of the file.
    """
    try:
        return ctx.compute_shader(source(name))
    except moderngl.Error as error:
        raise RuntimeError(f"{name}: {error}") from error


def _with_defines(text: str, defines: Defines) -> str:
    """Put the defines after ``#version`` and keep the line numbers of the file."""
    version, rest = text.split("\n", 1)
    lines = [f"#define {name} {value}" for name, value in defines.items()]
    return "\n".join([version, *lines, "#line 2", rest])


def _included(name: str) -> str:
    return source(f"include/{name}")


def _with_chosen(text: str, chosen: Chosen) -> str:
    return _INCLUDE.sub(lambda line: f'#include "{chosen.get(line[1], line[1])}"', text)


def _register_includes(ctx: moderngl.Context, text: str) -> None:
    for name in _INCLUDE.findall(text):
        ctx.includes[name] = _included(name)


@cache
def block_dtype(include: str, block: str) -> np.dtype[Any]:
    """Return the memory layout of a std140 uniform block that an include file declares.

    The GLSL text is the only declaration. Members must be `vec4`, `mat4` or arrays of them, which
    std140 packs without gaps. A `mat4` is (4, 4) with the matrix transposed: columns first.
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
    shapes = {"mat4": (4, 4), "vec4": (4,)}
    return np.dtype(
        [
            (name, np.float32, (*([int(count)] if count else []), *shapes[kind]))
            for kind, name, count in _MEMBER.findall(body[1])
        ]
    )


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
