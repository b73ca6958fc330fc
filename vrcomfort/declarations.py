"""Finds the declarations in a package's modules: effects, focus rules, analyses of a report."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pkgutil import walk_packages
from types import ModuleType
from typing import TypeVar

Declared = TypeVar("Declared")


def declared_in(package: ModuleType, kind: type[Declared]) -> Iterator[Declared]:
    """Yield the objects of a class that stand in the modules of a package, each once."""
    found: dict[int, Declared] = {}
    for each in walk_packages(package.__path__, f"{package.__name__}."):
        values = vars(import_module(each.name)).values()
        found.update((id(value), value) for value in values if isinstance(value, kind))
    yield from found.values()
