"""The files of another lab that a plan analyses, and the mapping that describes them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from vrcomfort.errors import InputError
from vrcomfort.files import read_text
from vrcomfort.settings import Settings, parse_settings, read_toml
from vrcomfort.settings.locate import locate


class DataFiles(Settings):
    """Answers that are no study folder, read through a mapping (see ``vrcomfort import``)."""

    files: Annotated[tuple[str, ...], Field(min_length=1)]
    """Paths from the plan's folder, with `*` and `?` for any letters."""
    mapping: str
    """Path of the mapping, from the plan's folder."""


class _Plan(Settings, extra="ignore"):
    """Of a plan, this alone: the rest is checked when its instruments are known."""

    data: DataFiles | None = None


def data_files(plan: Path) -> tuple[list[Path], Path] | None:
    """Return the files that a plan names and their mapping; None where it names none.

    Raises
    ------
    InputError
        If the plan cannot be read or a path leads to no file, with line and column.
    """
    text = read_text(plan, "analysis plan")
    try:
        said = read_toml(text, plan)
    except InputError:
        said = {"data": None}  # told below
    if "data" not in said:
        return None
    data = parse_settings(_Plan, text, plan).data
    if data is None:
        return None
    found: list[Path] = []
    for place, pattern in enumerate(data.files):
        own = sorted(plan.parent.glob(pattern)) if not Path(pattern).is_absolute() else []
        own = own or [plan.parent / pattern]
        if not own[0].is_file():
            raise _no_file(plan, text, pattern, "files", place)
        found += [file for file in own if file not in found]
    mapping = plan.parent / data.mapping
    if not mapping.is_file():
        raise _no_file(plan, text, data.mapping, "mapping")
    return found, mapping


def _no_file(plan: Path, text: str, name: str, *path: str | int) -> InputError:
    line, column = locate(text).of(("data", *path))
    message = f"there is no file `{name}` in {plan.parent}/, the plan's folder; mend the path"
    return InputError(message, file=plan, line=line, column=column)
