"""Reads a task of the lab's own from a Python file outside of the package."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.tasks.base import TaskSettings


def settings_of_file(file: Path) -> type[TaskSettings]:
    """Return the settings class that a Python file calls `TASK`.

    The file is run: it is code of the lab's, as the protocol beside it is.

    Raises
    ------
    InputError
        If there is no such file, it cannot be run, or has no such class.
    """
    if not file.is_file():
        raise InputError("there is no such task file; put it beside the protocol", file=file)
    # A name of its own for each file, so that pydantic finds its classes' modules again.
    name = f"vrcomfort_task_{hashlib.sha256(str(file.resolve()).encode()).hexdigest()[:16]}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise InputError("this cannot be a Python file; a task is one", file=file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # whatever a lab's file raises, it is told where
        message = f"this task cannot be read: {type(error).__name__}: {error}"
        raise InputError(message, file=file) from error
    found = getattr(module, "TASK", None)
    if not (isinstance(found, type) and issubclass(found, TaskSettings)):
        message = "this file has no `TASK = …`: the settings class of a task"
        raise InputError(f"{message} (docs/tasks.md)", file=file)
    return found
