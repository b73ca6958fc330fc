"""Settings of an own task as a TOML file beside it declares them: checked without running code."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, Self, TypeAlias

from pydantic import Field, create_model, model_validator

from vrcomfort.files import read_text
from vrcomfort.settings import Settings, Word, parse_settings
from vrcomfort.tasks.base import TaskSettings

Value: TypeAlias = bool | int | float | str | tuple[int | float | str, ...]
_TYPES: dict[str, Any] = {
    "whole": int,
    "number": float,
    "text": str,
    "yes_no": bool,
    "numbers": tuple[float, ...],
    "texts": tuple[str, ...],
}


class SettingDeclaration(Settings):
    """One setting of a task."""

    type: Literal["whole", "number", "text", "yes_no", "numbers", "texts"]
    """What is written: `3`, `0.5`, `"left"`, `true`, `[0.5, 1.0]` or `["left", "right"]`."""
    default: Value | None = None
    """Its value where the protocol does not say it; without one, the protocol has to."""
    low: float | None = None
    high: float | None = None
    """Bounds of a number, which may be reached."""
    one_of: tuple[str, ...] = ()
    """The texts that can be written."""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        numeric = self.type in {"whole", "number"}
        if not numeric and (self.low is not None or self.high is not None):
            raise ValueError('`low` and `high` are of type = "whole" and "number" alone')
        if self.one_of and self.type != "text":
            raise ValueError('`one_of` is of type = "text" alone')
        return self

    @property
    def field(self) -> tuple[Any, Any]:
        """Return the type and the default, as a model has them."""
        kind = Literal[self.one_of] if self.one_of else _TYPES[self.type]
        default = ... if self.default is None else self.default
        return kind, Field(default, ge=self.low, le=self.high, validate_default=True)


class TaskDeclaration(Settings):
    """A file beside a task's, of the same name with `.toml`."""

    settings: dict[Word, SettingDeclaration] = Field(default_factory=dict)
    """Name → each setting that an entry of [[tasks]] may have, but for `name` and `kind`."""

    def model(self) -> type[TaskSettings]:
        """Return the model of an entry of [[tasks]]."""
        fields: dict[str, Any] = {name: each.field for name, each in self.settings.items()}
        return create_model("DeclaredTask", __base__=TaskSettings, kind=(str, ...), **fields)


def declared_settings(task_file: Path) -> type[TaskSettings] | None:
    """Return the model that a task's declaration describes; None where there is no such file.

    Raises
    ------
    InputError
        If it is wrong, with line and column.
    """
    file = task_file.with_suffix(".toml")
    if not file.is_file():
        return None
    return parse_settings(TaskDeclaration, read_text(file, "declaration of a task"), file).model()
