"""Messages of errors are written as the field writes: no coined constructions."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import vrcomfort

PACKAGE = Path(vrcomfort.__file__).parent
FORBIDDEN = re.compile(
    r"\b(somebody|nobody|everybody|so (many|much|long|often)"
    r"|whose|whom|is none\b|of which|(this|that|it) is no (?!longer)\w+)|\}`? is no (?!longer)\w+",
    re.IGNORECASE,
)
"""Clauses in the place of a noun; "is no X" in the place of "is not an X"."""


def messages(file: Path) -> Iterator[tuple[int, str]]:
    """Yield (line, text) of the errors and problems of a file, with `{…}` for values."""
    source = file.read_text("utf-8")
    if not re.search(r"\b(InputError\(|Problem\(|message = )", source):
        return
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in {"InputError", "Problem"}:
            for given in node.args:
                yield node.lineno, text_of(given)
        if isinstance(node, ast.Assign) and "message" in map(name_of, node.targets):
            yield node.lineno, text_of(node.value)


def name_of(node: ast.expr) -> str:
    return getattr(node, "id", "")


def text_of(node: ast.expr) -> str:
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(
            str(each.value) if isinstance(each, ast.Constant) else "{…}" for each in node.values
        )
    if isinstance(node, ast.BinOp):
        return text_of(node.left) + text_of(node.right)
    return ""


def test_messages_have_no_coined_constructions() -> None:
    found, read = [], 0
    for file in sorted(PACKAGE.rglob("*.py")):
        for line, text in messages(file):
            read += 1
            if FORBIDDEN.search(text):
                found.append(f"{file.relative_to(PACKAGE)}:{line}: {text}")
    assert read > 900
    assert found == []


@pytest.mark.parametrize(
    "text",
    ["nobody is in it", "`{…}` is no column", "a file whose name", "so many rows", "it is no TOML"],
)
def test_what_is_forbidden(text: str) -> None:
    assert FORBIDDEN.search(text)


def test_what_is_not() -> None:
    assert not FORBIDDEN.search("there is no such file; the answer is no longer there")
