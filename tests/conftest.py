"""Shared fixtures: one OpenGL context, checked after each test that uses it."""

from __future__ import annotations

import ctypes
import gc
from collections.abc import Callable, Iterator

import moderngl
import pytest

from vrcomfort.render import gl

KINDS = ("Texture", "Buffer", "Framebuffer", "Program", "VertexArray", "Query", "Sampler")
HIGHEST_NAME = 2048


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden", action="store_true", help="write the golden images instead of comparing"
    )


@pytest.fixture(scope="session")
def session_context() -> Iterator[moderngl.Context]:
    """Yield the context of the whole run; tests ask for `ctx`."""
    ctx = gl.create_context()
    yield ctx
    ctx.release()


@pytest.fixture(scope="session")
def count_objects(session_context: moderngl.Context) -> Callable[[], dict[str, int]]:
    """Return a function that counts the live OpenGL objects of each kind."""
    tests = {
        kind: gl.function(session_context, f"glIs{kind}", ctypes.c_uint, result=ctypes.c_ubyte)
        for kind in KINDS
    }
    use_program = gl.function(session_context, "glUseProgram", ctypes.c_uint)
    idle = session_context.simple_framebuffer((1, 1))

    def count() -> dict[str, int]:
        idle.use()  # what is in use outlives its last reference
        use_program(0)
        gc.collect()
        return {kind: sum(map(exists, range(1, HIGHEST_NAME))) for kind, exists in tests.items()}

    return count


@pytest.fixture
def ctx(
    session_context: moderngl.Context, count_objects: Callable[[], dict[str, int]]
) -> Iterator[moderngl.Context]:
    """Yield a real EGL context; afterwards no OpenGL error and no object may be left.

    Objects are released with their last reference, so a test need not release what it made;
    what stays is a leak (a reference cycle, a cache, a raw OpenGL name).
    """
    before = count_objects()
    yield session_context
    gl.check_errors(session_context)
    assert count_objects() == before, "the test left OpenGL objects behind"
