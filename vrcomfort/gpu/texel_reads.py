"""Counts the texture reads of shaders: rewrites their text so that each invocation adds its own up.

A read is one call of `texelFetch`, `texture`, `textureLod` and the like, or `imageLoad`, whatever
its filter: a bilinear read of four texels is one, as is a gather. Reads of helper invocations do
not count. What is counted is what runs: a loop that is left early adds what it has read.
"""

from __future__ import annotations

import re
from collections.abc import Callable

BINDING = 7
"""Of the shader storage buffer ``TexelReads``: reads (low and high 32 bits)."""

DECLARATION = f"""
layout(std430, binding = {BINDING}) buffer TexelReads {{ uint texel_reads_of_all[2]; }};
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
_INCLUDE = re.compile(r'^[ \t]*#include[ \t]+"([^"]+)"[^\n]*', re.MULTILINE)
_MAIN = re.compile(r"\bvoid\s+main\s*\(\s*(?:void)?\s*\)")
_DISCARD = re.compile(r"\bdiscard\s*;")


def counted(text: str, include: Callable[[str], str]) -> str:
    """Return a shader that counts its reads into the buffer at :data:`BINDING`.

    Parameters
    ----------
    text
        Of a vertex, fragment or compute shader, starting with ``#version``.
    include
        Gives the text of an included file.
    """
    version, rest = text.split("\n", 1)
    rest = _INCLUDE.sub(lambda found: include(found[1]), rest)
    body = _with_reads(_COMMENT.sub(" ", rest))
    if "texel_reads" not in body:
        return "\n".join([version, body])
    body = _DISCARD.sub("{ add_texel_reads(); discard; }", body)
    body = _MAIN.sub("void main_that_reads()", body)
    main = "void main() { main_that_reads(); add_texel_reads(); }\n"
    head = _extensions(body)
    return "\n".join([version, body[:head], DECLARATION, body[head:], main])


def _extensions(body: str) -> int:
    """Return where the lines end that must come before all code: those about extensions."""
    last = body.rfind("#extension")
    return 0 if last < 0 else body.index("\n", last) + 1


def _with_reads(text: str) -> str:
    """Return the text with `(texel_reads += 1u, read(…))` for every read, inner ones too."""
    found = _READ.search(text)
    if found is None:
        return text
    end = _closing(text, found.end())
    inner = _with_reads(text[found.end() : end])
    call = f"(texel_reads += 1u, {found[0]}{inner}))"
    return text[: found.start()] + call + _with_reads(text[end + 1 :])


def _closing(text: str, start: int) -> int:
    """Return where the bracket closes that was opened just before `start`."""
    depth = 1
    for index in range(start, len(text)):
        depth += {"(": 1, ")": -1}.get(text[index], 0)
        if depth == 0:
            return index
    raise ValueError("a call in a shader is not closed")
