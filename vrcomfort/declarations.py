"""Finds what the modules of a package declare: effects, focus rules, analyses of a report."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

Declared = TypeVar("Declared")


def declared_in(package: ModuleType, kind: type[Declared]) -> Iterator[Declared]:
    """Yield the objects of a class that stand in the modules of a package, module by module."""
    for each in iter_modules(package.__path__):
        module = import_module(f"{package.__name__}.{each.name}")
        yield from (value for value in vars(module).values() if isinstance(value, kind))
