"""A mapping under construction, and how it is written as TOML with comments."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple


class Doubt(NamedTuple):
    """A question that the files do not answer, and what is taken for granted meanwhile."""

    question: str
    assumed: str


@dataclass
class Draft:
    """A TOML table: its keys, comments above some of them, and tables inside.

    Parameters
    ----------
    comments
        Key (or "" for the table itself) → lines above it.
    """

    values: dict[str, object] = field(default_factory=dict)
    comments: dict[str, list[str]] = field(default_factory=dict)
    tables: dict[str, Draft] = field(default_factory=dict)
    lists: dict[str, list[Draft]] = field(default_factory=dict)

    def put(self, key: str, value: object, comment: str = "") -> None:
        """Set a key, with a comment above it."""
        self.values[key] = value
        if comment:
            self.comments.setdefault(key, []).append(comment)

    def note(self, comment: str, key: str = "") -> None:
        """Add a comment."""
        self.comments.setdefault(key, []).append(comment)

    def text(self) -> str:
        """Return the whole as TOML."""
        return "\n".join(self._lines("")) + "\n"

    def _lines(self, path: str) -> Iterator[str]:
        for key, value in self.values.items():
            yield from (f"# {line}" for line in self.comments.get(key, ()))
            yield f"{bare(key)} = {toml_value(value)}"
        for key, table in self.tables.items():
            name = f"{path}{bare(key)}"
            yield from self._opened(table, f"[{name}]", name)
        for key, tables in self.lists.items():
            name = f"{path}{bare(key)}"
            for table in tables:
                yield from self._opened(table, f"[[{name}]]", name)

    def _opened(self, table: Draft, header: str, name: str) -> Iterator[str]:
        yield ""
        yield from (f"# {line}" for line in table.comments.get("", ()))
        yield header
        yield from table._lines(f"{name}.")


def bare(key: str) -> str:
    """Return a key, in quotes where it needs them."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else quoted(key)


def quoted(text: str) -> str:
    """Return a TOML string."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def toml_value(value: object) -> str:
    """Return a value as TOML writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Mapping):
        inside = ", ".join(f"{bare(str(key))} = {toml_value(each)}" for key, each in value.items())
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, list | tuple):
        cells = [toml_value(each) for each in value]
        line = f"[{', '.join(cells)}]"
        if len(line) <= 90:
            return line
        return "[\n" + "".join(f"  {cell},\n" for cell in cells) + "]"
    raise TypeError(value)
