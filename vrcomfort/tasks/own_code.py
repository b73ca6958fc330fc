"""Tasks of the lab's own: their Python files with everything they import from their folder.

Files are read and hashed first, and nothing of them is run; who starts a session decides on the
hash. What runs then are the bytes that were hashed.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.abc import InspectLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.metadata import EntryPoint
from pathlib import Path
from types import CodeType, ModuleType

from vrcomfort.errors import InputError
from vrcomfort.files import MOST_TEXT_BYTES, read_bytes
from vrcomfort.installed import installed, load, package_of, path_without, place_of
from vrcomfort.tasks.base import TaskSettings

ENTRY_POINTS = "vrcomfort.tasks"
"""Group of the entry points by which installed packages bring tasks."""


def own_task_file(folder: Path, kind: str) -> Path:
    """Return the file of a task; it is not run.

    Parameters
    ----------
    folder
        The protocol's.
    kind
        The path that the protocol gives, relative to `folder`.

    Raises
    ------
    InputError
        If there is no such file, or it lies outside of the folder, links followed.
    """
    file = folder / kind
    if not file.is_file():
        raise InputError("there is no such task file; put it beside the protocol", file=file)
    _require_inside(file, folder)
    return file


def _require_inside(file: Path, folder: Path) -> None:
    if not file.resolve().is_relative_to(folder.resolve()):
        message = f"this task file is outside of the protocol's folder {folder.resolve()}"
        raise InputError(f"{message}, and is never run; copy it into that folder", file=file)


def installed_task(kind: str) -> EntryPoint | None:
    """Return the entry point of an installed package that brings a task; nothing is imported."""
    if kind.endswith(".py"):
        return None
    return next((each for each in installed(ENTRY_POINTS) if each.name == kind), None)


@dataclass(frozen=True)
class TaskCode:
    """The Python files of a protocol's own tasks, as they were when they were read.

    Parameters
    ----------
    folder
        The protocol's.
    files
        Path in `folder` → content: the files that tasks name, and all that they import from
        their folders.
    modules
        Name under which a file is imported → its path in `folder`.
    """

    folder: Path
    files: Mapping[str, bytes] = field(default_factory=dict)
    modules: Mapping[str, str] = field(default_factory=dict)

    @property
    def hashes(self) -> dict[str, str]:
        """Return path → SHA-256 of each file."""
        return {name: hashlib.sha256(text).hexdigest() for name, text in self.files.items()}

    @property
    def sha256(self) -> str:
        """Return the SHA-256 of the output of `sha256sum` for the files, sorted by path."""
        lines = "".join(f"{sha256}  {name}\n" for name, sha256 in sorted(self.hashes.items()))
        return hashlib.sha256(lines.encode()).hexdigest()

    def run(self, kind: str) -> type[TaskSettings]:
        """Run the file of a task; return the settings class that it calls `TASK`.

        Raises
        ------
        InputError
            If it cannot be run, or has no such class.
        """
        file = self.folder / kind
        _Importer.serve(self)
        # A name of its own for each file, so that pydantic finds its classes' modules again.
        name = f"vrcomfort_task_{hashlib.sha256(str(file.resolve()).encode()).hexdigest()[:16]}"
        module = ModuleType(name)
        module.__file__ = str(file)
        sys.modules[name] = module
        try:
            code = compile(self.files[kind], str(file), "exec")
            exec(code, module.__dict__)  # noqa: S102 - see docs/tasks.md
        except Exception as error:  # whatever a lab's file raises, it is told where
            message = f"this task cannot be read: {type(error).__name__}: {error}"
            raise InputError(message, file=file) from error
        return _task_of(module, file)


def run_installed_task(found: EntryPoint) -> tuple[type[TaskSettings], str]:
    """Import a task of an installed package; return its settings class, and "package version".

    Raises
    ------
    InputError
        If it cannot be imported, or is no such class.
    """
    task = load(found)
    if not (isinstance(task, type) and issubclass(task, TaskSettings)):
        message = f"the entry point {place_of(found)} is not a settings class of a task"
        raise InputError(f"{message} (vrcomfort docs tasks)")
    return task, package_of(found)


def _task_of(module: ModuleType, file: Path) -> type[TaskSettings]:
    found = getattr(module, "TASK", None)
    if not (isinstance(found, type) and issubclass(found, TaskSettings)):
        message = "this file has no `TASK = …`: the settings class of a task"
        raise InputError(f"{message} (vrcomfort docs tasks)", file=file)
    return found


def read_task_code(folder: Path, kinds: Iterable[str]) -> TaskCode:
    """Read the files of tasks, and those that they import from their folders; none is run.

    Files that are called like an installed package or a module of Python's are not imported: that
    is.

    Raises
    ------
    InputError
        If one cannot be read, lies outside of `folder`, or two would be imported by one name.
    """
    files: dict[str, bytes] = {}
    modules: dict[str, str] = {}
    for kind in dict.fromkeys(kinds):
        start = own_task_file(folder, kind)
        beside = start.parent
        waiting: list[tuple[str, Path]] = [("", start)]
        while waiting:
            name, file = waiting.pop()
            place = file.relative_to(folder).as_posix() if name else kind
            if name and modules.setdefault(name, place) != place:
                message = f"`import {name}` would also mean {modules[name]}; rename one of the two"
                raise InputError(message, file=file)
            if place in files and name:
                continue
            _require_inside(file, folder)
            files[place] = _content(file)
            package = name if file.name == "__init__.py" else name.rpartition(".")[0]
            for wanted in _imported(files[place], package, file):
                waiting += _found(folder, beside, wanted)
    return TaskCode(folder, files, modules)


def _content(file: Path) -> bytes:
    try:
        return read_bytes(file, most=MOST_TEXT_BYTES)
    except OSError as error:
        raise InputError(f"cannot read this task file: {error.strerror}", file=file) from error


def _imported(text: bytes, package: str, file: Path) -> Iterator[str]:
    """Yield the names of the modules that a file may import, wherever in it."""
    try:
        tree = ast.parse(text, str(file))
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        message = f"this task cannot be read: {type(error).__name__}: {error}"
        raise InputError(message, file=file, line=getattr(error, "lineno", None)) from error
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            start = ".".join(above) if node.level else ""
            origin = ".".join(filter(None, (start, node.module)))
            if origin:
                yield origin
                yield from (f"{origin}.{each.name}" for each in node.names if each.name != "*")


def _found(folder: Path, beside: Path, wanted: str) -> Iterator[tuple[str, Path]]:
    """Yield the files, with their names as modules, that an import of `wanted` runs."""
    parts = wanted.split(".")
    if _is_installed(parts[0], path_without((folder, beside))):
        return
    for count in range(1, len(parts) + 1):
        name, path = ".".join(parts[:count]), beside.joinpath(*parts[:count])
        for file in (path / "__init__.py", path.with_name(f"{path.name}.py")):
            if file.is_file():
                yield name, file
                break


def _is_installed(name: str, path: Sequence[str]) -> bool:
    """Return whether an import of a name finds a module elsewhere than beside a task."""
    if name in sys.builtin_module_names or name in sys.stdlib_module_names:
        return True
    for each in sys.meta_path:
        if isinstance(each, _Importer) or not hasattr(each, "find_spec"):
            continue
        if each.find_spec(name, path) is not None:
            return True
    return False


class _Importer(MetaPathFinder, InspectLoader):
    """Imports modules of the task code that runs, from the bytes that were hashed."""

    def __init__(self, code: TaskCode) -> None:
        self._code = code

    @classmethod
    def serve(cls, code: TaskCode) -> None:
        """Import from this code from now on, and no longer from another."""
        beside = {(code.folder / name).parent for name in code.files}
        sys.path[:] = path_without((code.folder, *beside))
        for each in [each for each in sys.meta_path if isinstance(each, cls)]:
            if each._code is code:
                return
            sys.meta_path.remove(each)
            for name in each._code.modules:
                sys.modules.pop(name, None)
        sys.meta_path.append(cls(code))

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None = None,
        target: ModuleType | None = None,
    ) -> ModuleSpec | None:
        """Return how a module of the code is imported; None for others."""
        del path, target
        if fullname not in self._code.modules:
            return None
        spec = ModuleSpec(fullname, self, is_package=self.is_package(fullname))
        spec.origin = str(self._file(fullname))
        spec.has_location = True
        return spec

    def is_package(self, fullname: str) -> bool:
        """Return whether a module has others in it."""
        return self._file(fullname).name == "__init__.py"

    def get_source(self, fullname: str) -> str:
        """Return the text of a module."""
        return importlib.util.decode_source(self._code.files[self._code.modules[fullname]])

    def get_code(self, fullname: str) -> CodeType:
        """Return the program of a module."""
        place = self._code.modules[fullname]
        return compile(self._code.files[place], str(self._file(fullname)), "exec")

    def _file(self, fullname: str) -> Path:
        return self._code.folder / self._code.modules[fullname]
