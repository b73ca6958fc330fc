"""Where each key of a TOML text stands, which `tomllib` does not tell.

Only for text that `tomllib` has accepted: the scanner trusts the grammar and follows keys.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

Path: TypeAlias = tuple[str | int, ...]

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_STRINGS = tuple(
    re.compile(pattern, re.DOTALL)
    for pattern in (
        r'"""(?:\\.|[^\\])*?"{3,5}',
        r"'''.*?'{3,5}",
        r'"(?:\\.|[^"\\])*"',
        r"'[^']*'",
    )
)
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_BARE_VALUE = re.compile(r"[^,\]}#\n]*")


@dataclass(frozen=True)
class Places:
    """Offsets of keys in a text."""

    text: str
    offsets: dict[Path, int]

    def of(self, path: Sequence[str | int]) -> tuple[int, int]:
        """Return the 1-based (line, column) of `path`, or of its nearest parent in the text."""
        parts = tuple(path)
        alone = tuple(part for part in parts if part != 0)
        if parts not in self.offsets and alone in self.offsets:
            parts = alone  # a table that may stand for a list of one
        while parts and parts not in self.offsets:
            parts = parts[:-1]
        offset = self.offsets.get(parts, 0)
        line = bisect_right(self._starts, offset)
        return line, offset - self._starts[line - 1] + 1

    @cached_property
    def _starts(self) -> list[int]:
        """Where each line begins."""
        return [0, *(found.end() for found in re.finditer("\n", self.text))]


def locate(text: str) -> Places:
    """Return the places of all keys and array elements of a valid TOML text."""
    scanner = _Scanner(text)
    scanner.document()
    return Places(text, scanner.offsets)


@dataclass
class _Scanner:
    text: str
    at: int = 0
    offsets: dict[Path, int] = field(default_factory=dict)
    counts: dict[Path, int] = field(default_factory=dict)

    def document(self) -> None:
        table: Path = ()
        while self._skip(_BLANK) < len(self.text):
            table = self._header() if self.text[self.at] == "[" else self._pair(table)

    def _skip(self, pattern: re.Pattern[str]) -> int:
        found = pattern.match(self.text, self.at)
        self.at = found.end() if found else self.at
        return self.at

    def _take(self, literal: str) -> bool:
        taken = self.text.startswith(literal, self.at)
        self.at += len(literal) if taken else 0
        return taken

    def _note(self, path: Path, offset: int) -> None:
        self.offsets.setdefault(path, offset)

    def _key(self) -> list[tuple[str, int]]:
        """Read a dotted key: its names and where each stands."""
        names: list[tuple[str, int]] = []
        while True:
            start = self._skip(_SPACE)
            if self.text[start] in "\"'":
                self._string()
                names.append((self.text[start + 1 : self.at - 1], start))
            else:
                names.append((self.text[start : self._skip(_BARE_KEY)], start))
            self._skip(_SPACE)
            if not self._take("."):
                return names

    def _header(self) -> Path:
        start = self.at
        of_array = self._take("[[")
        if not of_array:
            self._take("[")
        names = self._key()
        self._take("]]" if of_array else "]")
        path: Path = ()
        for name, offset in names[:-1]:
            path = self._latest((*path, name))
            self._note(path, offset)
        path = (*path, names[-1][0])
        self._note(path, start)
        if of_array:
            self.counts[path] = self.counts.get(path, -1) + 1
            path = self._latest(path)
            self._note(path, start)
        return path

    def _latest(self, path: Path) -> Path:
        """Return the last element of an array of tables, any other path as it is."""
        return (*path, self.counts[path]) if path in self.counts else path

    def _pair(self, table: Path) -> Path:
        path = table
        for name, offset in self._key():
            path = (*path, name)
            self._note(path, offset)
        self._take("=")
        self._skip(_SPACE)
        self._value(path)
        return table

    def _value(self, path: Path) -> None:
        first = self.text[self.at]
        if first in "\"'":
            self._string()
        elif first == "[":
            self._array(path)
        elif first == "{":
            self._inline_table(path)
        else:
            self._skip(_BARE_VALUE)

    def _string(self) -> None:
        start = self.at
        for pattern in _STRINGS:
            if self._skip(pattern) > start:
                return

    def _array(self, path: Path) -> None:
        self._take("[")
        index = 0
        while self._skip(_BLANK) < len(self.text) and not self._take("]"):
            self._note((*path, index), self.at)
            self._value((*path, index))
            self._skip(_BLANK)
            self._take(",")
            index += 1

    def _inline_table(self, path: Path) -> None:
        self._take("{")
        while self._skip(_BLANK) < len(self.text) and not self._take("}"):
            self._pair(path)
            self._skip(_BLANK)
            self._take(",")
