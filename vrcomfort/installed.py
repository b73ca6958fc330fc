"""Finds additions of installed packages by entry points: tasks, effects, questionnaires.

To install a package is the consent to its code. What lies in the present folder, where `python -m`
looks too, is not installed.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from importlib.machinery import PathFinder
from importlib.metadata import EntryPoint, distributions
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError

_PACKAGE = Path(__file__).resolve().parents[1]
"""Where this package is imported from."""


def installed(group: str) -> Iterator[EntryPoint]:
    """Yield the entry points of a group; nothing is imported."""
    there = distributions(path=path_without((Path.cwd(),)))
    found = (each for package in there for each in package.entry_points)
    yield from (each for each in found if each.group == group)


def load(found: EntryPoint) -> Any:
    """Import the object of an entry point.

    Raises
    ------
    InputError
        If it cannot be imported.
    """
    sys.path[:] = path_without((Path.cwd(),))
    try:
        return found.load()
    except Exception as error:  # whatever a package raises, it is told where
        raise InputError(
            f"the package {package_of(found)} cannot be read: {type(error).__name__}: {error} "
            f"(entry point {place_of(found)})"
        ) from error


def file_of(found: EntryPoint) -> Path:
    """Return the file that an entry point names as ``package.folder:file.toml``.

    Raises
    ------
    InputError
        If the package does not have it.
    """
    top, *folders = found.module.split(".")
    spec = PathFinder.find_spec(top, path_without((Path.cwd(),)))
    for folder in (spec and spec.submodule_search_locations) or ():
        file = Path(folder).joinpath(*folders, found.attr)
        if found.attr and file.is_file():
            return file
    raise InputError(f"the entry point {place_of(found)} names no file of its package")


def place_of(found: EntryPoint) -> str:
    """Return an entry point as its package declares it."""
    return f"{found.group}: {found.name} = {found.value}"


def package_of(found: EntryPoint) -> str:
    """Return name and version of the package of an entry point."""
    return f"{found.dist.name} {found.dist.version}" if found.dist else place_of(found)


def path_without(folders: Iterable[Path]) -> list[str]:
    """Return where modules are looked for, but for folders of tasks, the protocol's first.

    `python -m` looks into the folder in which it was started: what nobody has hashed would run.
    """
    own = [folder.resolve() for folder in folders]
    here = Path.cwd()
    own += [here] if here.is_relative_to(own[0]) else []
    places = ((each, Path(each or ".").resolve()) for each in sys.path)
    return [each for each, place in places if place == _PACKAGE or place not in own]
