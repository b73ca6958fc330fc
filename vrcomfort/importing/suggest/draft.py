"""A mapping under construction, and how it is written as TOML with comments."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from vrcomfort.settings import toml_key, toml_value

_WIDEST = 90
"""Characters of a list in one line."""


MOST_ASKED = 5
"""Doubts that a person is asked about at once."""
_ORDINARY = 50


class OpenDoubt(NamedTuple):
    """A question that the files do not answer, and the assumption meanwhile.

    Parameters
    ----------
    otherwise
        The consequence if the assumption is wrong.
    rank
        How much depends on the answer; the highest ranks are asked.
    """

    question: str
    assumed: str
    otherwise: str = ""
    rank: int = _ORDINARY

    @property
    def words(self) -> str:
        """Return the doubt in one line."""
        wrong = f" If not: {self.otherwise}." if self.otherwise else ""
        return f"{self.question} Assumed: {self.assumed}.{wrong}".replace("?.", "?")


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
            yield f"{toml_key(key)} = {_wrapped(value)}"
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
    """Return a value as TOML writes it; the elements of a long list have a line each."""
    line = toml_value(value)
    if len(line) <= _WIDEST or not isinstance(value, list | tuple):
        return line
    return "[\n" + "".join(f"  {toml_value(each)},\n" for each in value) + "]"


def write_doubts(draft: TomlDraft, doubts: Iterable[OpenDoubt]) -> list[OpenDoubt]:
    """Write the doubts of the highest rank as questions, the others as guesses; return the first.

    One question hardly matters beside five that do, and a person who is asked forty reads none.
    """
    ranked = sorted(dict.fromkeys(doubts), key=lambda doubt: -doubt.rank)
    asked, guessed = ranked[:MOST_ASKED], ranked[MOST_ASKED:]
    draft.lists["doubts"] = [TomlDraft({**_said(doubt), "answer": ""}) for doubt in asked]
    if guessed:
        draft.lists["guesses"] = [TomlDraft(_said(doubt)) for doubt in guessed]
        line = "Not asked, since less depends on it: mend what is wrong."
        draft.lists["guesses"][0].note(line)
    return asked


def _said(doubt: OpenDoubt) -> dict[str, object]:
    said = {"question": doubt.question, "assumed": doubt.assumed, "otherwise": doubt.otherwise}
    return {key: text for key, text in said.items() if text}
