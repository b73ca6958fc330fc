"""Compiled programs that are kept for the tests that follow.

A software rasteriser translates a program again whenever it is linked, which takes as long as all
that most tests draw with it. A kept program is lent to one user at a time, with the uniforms and
bindings of a new one.
"""

from __future__ import annotations

import weakref
from collections import defaultdict
from collections.abc import Callable, Hashable
from typing import Any

import moderngl
from _moderngl import StorageBlock, Uniform, UniformBlock
from moderngl import InvalidObject

from vrcomfort.gpu.shaders import includes_of


class KeptPrograms:
    """Takes the place of what compiles programs in a context, for as long as there is that."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = weakref.ref(ctx)
        self._idle: defaultdict[Hashable, list[dict[str, Any]]] = defaultdict(list)
        for name in ("program", "compute_shader"):
            setattr(ctx, name, self._in_place_of(name))

    @property
    def idle(self) -> int:
        """Programs that are lent to nobody."""
        return sum(map(len, self._idle.values()))

    def take_back(self, key: Hashable, facts: dict[str, Any]) -> None:
        """Keep a program that its user has released, or let die."""
        self._idle[key].append({**facts, "extra": None, "ctx": None, "_pool": None})

    def _in_place_of(self, name: str) -> Callable[..., Any]:
        def compile_new(*texts: Any, **more: Any) -> Any:
            return getattr(moderngl.Context, name)(self._ctx(), *texts, **more)

        def lend(*texts: Any, **more: Any) -> Any:
            try:
                named = ((option, self._with_includes(more[option])) for option in sorted(more))
                key = (name, *map(self._with_includes, texts), *named)
            except KeyError:  # of an include that is missing; moderngl tells it
                return compile_new(*texts, **more)
            if not self._idle[key]:
                return _lent(self, key, compile_new(*texts, **more))
            facts = self._idle[key].pop()
            for member, value in facts["_first"].items():
                _write(facts["_members"][member], value)
            made = facts["_kind"].__new__(facts["_kind"])
            vars(made).update(facts, ctx=self._ctx(), _pool=self)
            return made

        return lend

    def _with_includes(self, given: Any) -> Hashable:
        if not isinstance(given, str):
            return repr(given)
        return given, *(self._ctx().includes[name] for name in includes_of(given))


class _Lent:
    """A program that goes back instead of being deleted."""

    _pool: KeptPrograms
    _key: Hashable
    mglo: Any

    def __del__(self) -> None:
        self.release()

    def release(self) -> None:
        if not isinstance(self.mglo, InvalidObject):
            self._pool.take_back(self._key, vars(self).copy())
            self.mglo = InvalidObject()


class _Program(_Lent, moderngl.Program):
    pass


class _ComputeShader(_Lent, moderngl.ComputeShader):
    pass


def _lent(pool: KeptPrograms, key: Hashable, made: Any) -> Any:
    kind = _Program if isinstance(made, moderngl.Program) else _ComputeShader
    made.__class__ = kind
    first = {name: _read(member) for name, member in made._members.items()}
    vars(made).update(_pool=pool, _key=key, _kind=kind, _first=first)
    return made


def _read(member: Any) -> Any:
    if isinstance(member, Uniform):
        return member.read()
    return member.binding if isinstance(member, UniformBlock | StorageBlock) else None


def _write(member: Any, value: Any) -> None:
    if isinstance(member, Uniform):
        member.write(value)
    elif value is not None:
        member.binding = value
