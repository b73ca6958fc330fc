"""Reads a task of the lab's own from a Python file outside of the package."""

from __future__ import annotations

import hashlib
import sys
from pathlib import Path
from types import ModuleType

from vrcomfort.errors import InputError
from vrcomfort.tasks.base import TaskSettings


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
    if not file.resolve().is_relative_to(folder.resolve()):
        message = f"this task file is outside of the protocol's folder {folder.resolve()}"
        raise InputError(f"{message}, and is never run; copy it into that folder", file=file)
    return file


def run_task_file(file: Path) -> tuple[type[TaskSettings], str]:
    """Run a Python file; return the settings class that it calls `TASK`, and the file's SHA-256.

    Raises
    ------
    InputError
        If it cannot be run, or has no such class.
    """
    # A name of its own for each file, so that pydantic finds its classes' modules again.
    name = f"vrcomfort_task_{hashlib.sha256(str(file.resolve()).encode()).hexdigest()[:16]}"
    module = ModuleType(name)
    module.__file__ = str(file)
    sys.modules[name] = module
    try:
        # The bytes that are hashed are those that run: no cached .pyc comes between.
        code = file.read_bytes()
        exec(compile(code, str(file), "exec"), module.__dict__)  # noqa: S102 - see docs/tasks.md
    except Exception as error:  # whatever a lab's file raises, it is told where
        message = f"this task cannot be read: {type(error).__name__}: {error}"
        raise InputError(message, file=file) from error
    found = getattr(module, "TASK", None)
    if not (isinstance(found, type) and issubclass(found, TaskSettings)):
        message = "this file has no `TASK = …`: the settings class of a task"
        raise InputError(f"{message} (docs/tasks.md)", file=file)
    return found, hashlib.sha256(code).hexdigest()
