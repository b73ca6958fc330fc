"""The kinds of tasks, those of the experimenter's own Python files among them."""

from __future__ import annotations

import hashlib
import sys
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, TypeAlias, get_args

from pydantic import ConfigDict, Discriminator, Field, Tag, field_validator
from pydantic_core import PydanticCustomError

from vrcomfort.errors import InputError
from vrcomfort.files import read_bytes
from vrcomfort.settings import did_you_mean, union_tag
from vrcomfort.tasks.aiming import Aiming
from vrcomfort.tasks.base import TaskSettings
from vrcomfort.tasks.exploration import Exploration
from vrcomfort.tasks.fixation import Fixation
from vrcomfort.tasks.follow_path import FollowPath
from vrcomfort.tasks.search import VisualSearch


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
        code = read_bytes(file)
        exec(compile(code, str(file), "exec"), module.__dict__)  # noqa: S102 - see docs/tasks.md
    except Exception as error:  # whatever a lab's file raises, it is told where
        message = f"this task cannot be read: {type(error).__name__}: {error}"
        raise InputError(message, file=file) from error
    found = getattr(module, "TASK", None)
    if not (isinstance(found, type) and issubclass(found, TaskSettings)):
        message = "this file has no `TASK = …`: the settings class of a task"
        raise InputError(f"{message} (docs/tasks.md)", file=file)
    return found, hashlib.sha256(code).hexdigest()


class OwnTask(TaskSettings):
    """A task of the lab's own: a Python file beside the protocol; further keys are its settings."""

    model_config = ConfigDict(frozen=True, extra="allow")

    kind: Annotated[str, Field(json_schema_extra={"pattern": r"\.py$"})]
    """The file, relative to the protocol's; it names its settings `TASK` (docs/tasks.md)."""

    @field_validator("kind")
    @classmethod
    def _is_a_file(cls, value: str) -> str:
        if not value.endswith(".py"):
            hint = did_you_mean(value, sorted(SHIPPED))
            message = "there is no such task, and a task of your own is a .py file; {hint}"
            raise PydanticCustomError("task_kind", message, {"hint": hint})
        return value


def _tag(table: Any) -> str:
    kind = table.get("kind") if isinstance(table, dict) else getattr(table, "kind", None)
    return union_tag(kind if isinstance(kind, str) and kind in SHIPPED else "own")


AnyTask: TypeAlias = Annotated[
    Annotated[Aiming, Tag(union_tag("aiming"))]
    | Annotated[VisualSearch, Tag(union_tag("search"))]
    | Annotated[FollowPath, Tag(union_tag("follow_path"))]
    | Annotated[Fixation, Tag(union_tag("fixation"))]
    | Annotated[Exploration, Tag(union_tag("exploration"))]
    | Annotated[OwnTask, Tag(union_tag("own"))],
    Discriminator(_tag),
]
"""An entry of [[tasks]], by its `kind`: a shipped task is a file and a line here."""

SHIPPED = {
    choice
    for member in get_args(get_args(AnyTask)[0])
    for choice in get_args(get_args(member)[0].model_fields["kind"].annotation)
}
"""Words of `kind`."""
