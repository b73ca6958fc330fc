"""Clocks the CPU time of one thread, by the code that spends it."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, Literal, NamedTuple

import moderngl

Place = Literal["opengl", "runtime", "rig"]

_CLASSES = (
    "Buffer", "ComputeShader", "Context", "Framebuffer", "Program", "Query", "Sampler", "Scope",
    "Texture", "TextureArray", "Uniform", "VertexArray",
)  # fmt: skip
_ENTERED = ("__enter__", "__exit__")

_TRIES, _CALLS = 20, 1000


class Lap(NamedTuple):
    """CPU seconds between two laps: in Python, in OpenGL, in the OpenXR runtime, in the test rig.

    Waiting takes no CPU time, so it is in none of them.
    """

    python_s: float
    opengl_s: float
    runtime_s: float
    rig_s: float


class Clock:
    """The CPU time of the thread that makes it. Calls that nest count for the outermost.

    What the clock itself takes is measured once, on functions that do nothing, and taken away.

    Attributes
    ----------
    counts
        How often each function was called from outside of all others, by name.
    """

    def __init__(self) -> None:
        self._spent_s: dict[Place, float] = {"opengl": 0.0, "runtime": 0.0, "rig": 0.0}
        self._inside = False
        self._calls = 0
        self._own_s = 0.0
        self.counts: Counter[str] = Counter()
        self._since_s = time.thread_time()
        self._own_s = self._calibrated_s()
        self.counts.clear()

    def _calibrated_s(self) -> float:
        """Return the seconds that a clocked call takes beyond those of the function in it."""
        clocked, bare = (
            min(self._seconds_of(call) for _ in range(_TRIES))
            for call in (self.around("rig", _nothing, "nothing"), _nothing)
        )
        return (clocked - bare) / _CALLS

    def _seconds_of(self, call: Callable[[], None]) -> float:
        self.lap()
        for _ in range(_CALLS):
            call()
        return self.lap().python_s

    def around(
        self, place: Place, function: Callable[..., Any], name: str = ""
    ) -> Callable[..., Any]:
        """Return `function`, with the time in it counted for `place`."""

        def call(*arguments: Any, **options: Any) -> Any:
            if self._inside:
                return function(*arguments, **options)
            self._inside = True
            self._calls += 1
            self.counts[name] += 1
            start_s = time.thread_time()
            try:
                return function(*arguments, **options)
            finally:
                self._spent_s[place] += time.thread_time() - start_s
                self._inside = False

        return call

    def lap(self) -> Lap:
        """Return the time since the last lap, and begin the next."""
        now_s = time.thread_time()
        opengl_s, runtime_s, rig_s = (self._spent_s[place] for place in self._spent_s)
        python_s = now_s - self._since_s - opengl_s - runtime_s - rig_s
        python_s -= self._calls * self._own_s
        self._since_s, self._calls = now_s, 0
        self._spent_s = dict.fromkeys(self._spent_s, 0.0)
        return Lap(python_s, opengl_s, runtime_s, rig_s)


def yardstick_s() -> float:
    """Return the CPU time of a fixed piece of Python: how busy the machine is with other things."""
    start_s, value = time.thread_time(), 0.0
    for step in range(2000):
        value = value * 0.5 + step
    return time.thread_time() - start_s


def _nothing() -> None:
    """Do nothing."""


@contextmanager
def replaced(owner: Any, name: str, value: Any) -> Iterator[None]:
    """Give an attribute another value for a while."""
    before = getattr(owner, name)
    setattr(owner, name, value)
    try:
        yield
    finally:
        setattr(owner, name, before)


@contextmanager
def clocked_opengl(clock: Clock, gl: Any) -> Iterator[None]:
    """Count as OpenGL the calls of moderngl, and functions that `gl.function` finds in here."""
    find = gl.function

    def find_clocked(ctx: Any, name: str, *types: Any, **options: Any) -> Callable[..., Any]:
        return clock.around("opengl", find(ctx, name, *types, **options), name)

    with ExitStack() as kept:
        kept.enter_context(replaced(gl, "function", find_clocked))
        for owner in (getattr(moderngl, name) for name in _CLASSES if hasattr(moderngl, name)):
            for name, member in list(vars(owner).items()):
                clocked = _clocked_member(clock, member, f"{owner.__name__}.{name}")
                if clocked is not None and (name in _ENTERED or not name.startswith("__")):
                    kept.enter_context(replaced(owner, name, clocked))
        yield


def _clocked_member(clock: Clock, member: Any, name: str) -> Any:
    """Return a method or a property clocked as OpenGL's, None for anything else."""
    if isinstance(member, property):
        get, put = member.fget, member.fset
        return property(
            get and clock.around("opengl", get, name),
            put and clock.around("opengl", put, f"{name} ="),
        )
    return clock.around("opengl", member, name) if callable(member) else None
