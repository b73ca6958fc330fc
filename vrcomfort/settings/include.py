"""Tables that a file includes from others, and TOML text."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, time
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel

from vrcomfort.errors import InputError
from vrcomfort.files import read_text
from vrcomfort.settings.locate import Path as KeyPath
from vrcomfort.settings.locate import Places, locate
from vrcomfort.settings.reading import (
    Problem,
    SourcePlace,
    parse_data,
    problems_at,
    read_toml,
)

_BARE = re.compile(r"[A-Za-z0-9_-]+")
Model = TypeVar("Model", bound=BaseModel)

INCLUDE = "include"


@dataclass(frozen=True)
class IncludedFile:
    """One file, or the text of one."""

    file: Path | None
    text: str
    data: Mapping[str, Any] = field(repr=False)
    places: Places = field(repr=False)

    @property
    def sha256(self) -> str:
        """Return the hash of the file's text."""
        return hashlib.sha256(self.text.encode()).hexdigest()


class Source:
    """A file and all that it includes, put together.

    Tables are joined key by key, lists of tables are put one after the other, and of everything
    else what comes last counts: the includes in their order, then the file itself.

    Parameters
    ----------
    what
        What the file should be, for sentences about it.

    Attributes
    ----------
    parts
        Included files before those that include them; the file itself is the last.
    data
        Everything, without `include`.
    text
        The file's own, or where it includes others the TOML of `data`.

    Raises
    ------
    InputError
        If a part cannot be read or is no TOML, or includes itself.
    """

    def __init__(self, text: str, file: Path | None, what: str) -> None:
        self.parts: list[IncludedFile] = []
        self._what = what
        self._read(text, file, ())
        self._origin: dict[KeyPath, tuple[IncludedFile, KeyPath]] = {}
        self.data: dict[str, Any] = {}
        for part in self.parts:
            own = {key: value for key, value in part.data.items() if key != INCLUDE}
            self._join(self.data, own, part, (), ())
        self.text = text if len(self.parts) == 1 else to_toml(self.data)

    def _read(self, text: str, file: Path | None, chain: tuple[Path, ...]) -> None:
        data = read_toml(text, file)
        places = locate(text)
        for index, name in enumerate(_names(data, file, places)):
            inner = (file.parent if file else Path()) / name
            line, column = places.of((INCLUDE, index))
            if file is None or not inner.is_file():
                message = f"there is no file {inner} to include; paths begin at this file"
                raise InputError(message, file=file, line=line, column=column)
            above = (*chain, file.resolve())
            if inner.resolve() in above:
                names = [each.name for each in (*above[above.index(inner.resolve()) :], inner)]
                message = f"files include each other: {' → '.join(names)}; take one include out"
                raise InputError(message, file=file, line=line, column=column)
            read = [part.file.resolve() for part in self.parts if part.file]
            if inner.resolve() not in read:
                self._read(read_text(inner, f"part of a {self._what}"), inner, above)
        self.parts.append(IncludedFile(file, text, data, places))

    def _join(
        self,
        whole: dict[str, Any],
        own: Mapping[str, Any],
        part: IncludedFile,
        path: KeyPath,
        local: KeyPath,
    ) -> None:
        for key, value in own.items():
            there, here, at = whole.get(key), (*path, key), (*local, key)
            if isinstance(there, dict) and isinstance(value, dict):
                self._join(there, value, part, here, at)
            elif isinstance(there, list) and _are_tables(there) and _are_tables(value):
                for index in range(len(value)):
                    self._origin[*here, len(there) + index] = part, (*at, index)
                whole[key] = [*there, *value]
            else:
                whole[key] = _copied(value)
                self._origin[here] = part, at

    def place(self, path: Sequence[str | int]) -> SourcePlace:
        """Return file, line and column of a key, or of its nearest parent that is written."""
        parts = tuple(path)
        alone = tuple(part for part in parts if part != 0)  # a table may stand for a list of one
        if parts not in self._origin and alone in self._origin:
            parts = alone
        while parts and parts not in self._origin:
            parts = parts[:-1]
        part, local = self._origin.get(parts, (self.parts[-1], ()))
        line, column = part.places.of((*local, *tuple(path)[len(parts) :]))
        return SourcePlace(self.parts.index(part), part.file, line, column)

    def first_problem(self, found: Iterable[Problem]) -> InputError:
        """Return the fault that stands first; the others are its `others`."""
        return problems_at(found, self.place)

    def parse(self, model: type[Model]) -> Model:
        """Return the settings that all parts say together.

        Raises
        ------
        InputError
            If a key or value is wrong, with file, line and column.
        """
        return parse_data(model, self.data, self.first_problem)


def _names(data: Mapping[str, Any], file: Path | None, places: Places) -> list[str]:
    names = data.get(INCLUDE, [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        line, column = places.of((INCLUDE,))
        message = '`include` should be a list of files: ["shared.toml"]'
        raise InputError(message, file=file, line=line, column=column)
    return names


def _are_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(each, dict) for each in value)


def _copied(value: Any) -> Any:
    """Return a value with tables that can be added to."""
    if isinstance(value, dict):
        return {key: _copied(each) for key, each in value.items()}
    return [_copied(each) for each in value] if isinstance(value, list) else value


def toml_key(key: str) -> str:
    """Return a key, in quotes where it needs them."""
    return key if _BARE.fullmatch(key) else toml_value(key)


def toml_value(value: object) -> str:
    """Return a value in one line of TOML.

    Raises
    ------
    TypeError
        If TOML has no such type.
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):  # those of NumPy are such, and would write their type
        return repr(int(value) if isinstance(value, int) else float(value))
    if isinstance(value, str):  # as JSON has it, and DEL escaped
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        pairs = [f"{toml_key(str(key))} = {toml_value(each)}" for key, each in value.items()]
        return f"{{ {', '.join(pairs)} }}" if pairs else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, date | time):
        return value.isoformat()
    raise TypeError(value)


def to_toml(data: Mapping[str, Any]) -> str:
    """Return TOML text that reads back as `data`: keys, then tables, then lists of tables."""
    simple = {k: v for k, v in data.items() if not isinstance(v, dict) and not _are_tables(v)}
    lines = [f"{toml_key(key)} = {toml_value(value)}" for key, value in simple.items()]
    for key, value in data.items():
        if isinstance(value, dict):
            lines += ["", f"[{toml_key(key)}]", *_pairs(value)]
    for key, value in data.items():
        for table in value if _are_tables(value) else ():
            lines += ["", f"[[{toml_key(key)}]]", *_pairs(table)]
    return "\n".join(lines) + "\n"


def _pairs(table: Mapping[str, Any]) -> list[str]:
    return [f"{toml_key(key)} = {toml_value(value)}" for key, value in table.items()]
