"""The kinds of tasks, those of the experimenter's own Python files among them."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias, get_args

from pydantic import ConfigDict, Discriminator, Field, Tag, field_validator
from pydantic_core import PydanticCustomError

from vrcomfort.settings import did_you_mean, union_tag
from vrcomfort.tasks.aiming import Aiming
from vrcomfort.tasks.base import TaskSettings
from vrcomfort.tasks.exploration import Exploration
from vrcomfort.tasks.fixation import Fixation
from vrcomfort.tasks.follow_path import FollowPath
from vrcomfort.tasks.opponents import Opponents
from vrcomfort.tasks.own_code import installed_task
from vrcomfort.tasks.search import VisualSearch

_OWN_KINDS = (
    r"\.py$|^(?!(aiming|opponents|search|follow_path|fixation|exploration)$)"
    "[A-Za-z][A-Za-z0-9_]*$"
)


class OwnTask(TaskSettings):
    """A task of the lab's own: a Python file beside the protocol; further keys are its settings.

    Or one that an installed package brings, by its entry point.
    """

    model_config = ConfigDict(frozen=True, extra="allow")

    kind: Annotated[str, Field(json_schema_extra={"pattern": _OWN_KINDS})]
    """The file, relative to the protocol's; it names its settings `TASK` (docs/tasks.md). Or the
    name of a task of an installed package."""

    @field_validator("kind")
    @classmethod
    def _is_a_file(cls, value: str) -> str:
        if not value.endswith(".py") and installed_task(value) is None:
            hint = did_you_mean(value, sorted(SHIPPED))
            message = "there is no such task, and a task of your own is a .py file; {hint}"
            raise PydanticCustomError("task_kind", message, {"hint": hint})
        return value


def _tag(table: Any) -> str:
    kind = table.get("kind") if isinstance(table, dict) else getattr(table, "kind", None)
    return union_tag(kind if isinstance(kind, str) and kind in SHIPPED else "own")


AnyTask: TypeAlias = Annotated[
    Annotated[Aiming, Tag(union_tag("aiming"))]
    | Annotated[Opponents, Tag(union_tag("opponents"))]
    | Annotated[VisualSearch, Tag(union_tag("search"))]
    | Annotated[FollowPath, Tag(union_tag("follow_path"))]
    | Annotated[Fixation, Tag(union_tag("fixation"))]
    | Annotated[Exploration, Tag(union_tag("exploration"))]
    | Annotated[OwnTask, Tag(union_tag("own"))],
    Discriminator(_tag),
]
"""An entry of [[tasks]], by its `kind`: a shipped task is a file and a line here."""

SHIPPED: dict[str, type[TaskSettings]] = {
    choice: settings
    for member in get_args(get_args(AnyTask)[0])
    for settings in get_args(member)[:1]
    for choice in get_args(settings.model_fields["kind"].annotation)
}
"""Word of `kind` → settings."""
