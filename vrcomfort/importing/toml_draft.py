"""TOML under construction: keys, comments above some of them, and tables inside."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from vrcomfort.settings import toml_key, toml_value

_EDITED = {"item_order"}
"""Lists that a person is likely to write anew: one line, however long."""


_WIDEST = 90
"""Characters of a list in one line."""


@dataclass
class TomlDraft:
    """A TOML table: its keys, comments above some of them, and tables inside.

    Parameters
    ----------
    comments
        Key (or "" for the table itself) → lines above it.
    """

    values: dict[str, object] = field(default_factory=dict)
    comments: dict[str, list[str]] = field(default_factory=dict)
    tables: dict[str, TomlDraft] = field(default_factory=dict)
    lists: dict[str, list[TomlDraft]] = field(default_factory=dict)

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
            yield f"{toml_key(key)} = {toml_value(value) if key in _EDITED else _wrapped(value)}"
        for key, table in self.tables.items():
            name = f"{path}{toml_key(key)}"
            yield from self._opened(table, f"[{name}]", name)
        for key, tables in self.lists.items():
            name = f"{path}{toml_key(key)}"
            for table in tables:
                yield from self._opened(table, f"[[{name}]]", name)

    def _opened(self, table: TomlDraft, header: str, name: str) -> Iterator[str]:
        yield ""
        yield from (f"# {line}" for line in table.comments.get("", ()))
        yield header
        yield from table._lines(f"{name}.")


def _wrapped(value: object) -> str:
    """Return a value as TOML writes it: a long list in lines, quotation marks as they are."""
    if isinstance(value, str) and '"' in value and value.isprintable() and "'" not in value:
        return f"'{value}'"  # to be copied as it stands
    line = toml_value(value)
    if len(line) <= _WIDEST or not isinstance(value, list | tuple):
        return line
    return "[\n" + "".join(f"  {toml_value(each)},\n" for each in value) + "]"
