"""A mapping under construction, and how it is written as TOML with comments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.evidence import Context, Finding
from vrcomfort.settings import toml_key, toml_value

_WIDEST = 90
"""Characters of a list in one line."""


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
            yield f"{toml_key(key)} = {_wrapped(value)}"
        for key, table in self.tables.items():
            name = f"{path}{toml_key(key)}"
            yield from self._opened(table, f"[{name}]", name)
        for key, tables in self.lists.items():
            name = f"{path}{toml_key(key)}"
            for table in tables:
                yield from self._opened(table, f"[[{name}]]", name)

    def _opened(self, table: Draft, header: str, name: str) -> Iterator[str]:
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


@dataclass
class DraftedFacts:
    """Where the facts come from.

    Parameters
    ----------
    context
        The decisions on columns.
    unused
        Columns with a heading for a fact that were not taken.
    """

    context: Context
    draft: Draft = field(default_factory=Draft)
    doubts: list[Doubt] = field(default_factory=list)
    unused: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class AnswersFound:
    """The answers of a table, as far as its facts depend on them.

    Parameters
    ----------
    tables
        The single tables, of which the drafted one is made.
    said
        Facts that the headings of the answers say.
    taken
        Columns of answers.
    row_keys
        Columns that tell the rows of one questionnaire apart.
    answered
        Whether there are any.
    """

    tables: Sequence[SourceTable]
    said: set[str]
    taken: set[int]
    row_keys: Sequence[int]
    answered: bool


class FactDraft:
    """Writes down where facts come from; several of them write into one draft."""

    def __init__(
        self, answers: AnswersFound, found: DraftedFacts, named: dict[str, list[str]]
    ) -> None:
        self._answers = answers
        self._context = found.context
        self._table = found.context.table
        self._roles = found.context.roles
        self._vocabulary = found.context.vocabulary
        self._named = named
        self.found = found

    def heading(self, column: int) -> str:
        """Return the heading of a column."""
        return self._table.headings[column]

    def use(self, fact: str, column: int, comment: str = "", **more: object) -> None:
        """Let a fact come from a column."""
        self._context.used.add(column)
        self._context.columns[fact] = (column,)
        self.found.draft.put(fact, {"column": self.heading(column), **more}, comment)

    def doubt(self, question: str, assumed: str) -> None:
        """Add a question that the files leave open."""
        self.found.doubts.append(Doubt(question, assumed))

    def doubt_of(self, found: Finding) -> None:
        """Add the question that a piece of evidence leaves open."""
        question = found.evidence.question.format(heading=self.heading(found.column))
        self.doubt(question, found.evidence.assumed)
