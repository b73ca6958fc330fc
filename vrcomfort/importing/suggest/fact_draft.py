"""Writes down where the facts of a table come from, and the doubts that are left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.cells import texts
from vrcomfort.importing.suggest.draft import (
    CONDITIONS,
    ORDER,
    PEOPLE,
    TIMEPOINTS,
    OpenDoubt,
    Stake,
)
from vrcomfort.importing.suggest.evidence import Candidate, Context
from vrcomfort.importing.toml_draft import TomlDraft

_LACKS = 10
"""A column that is blank in more than one of so many rows lacks some."""
_STAKES = {"participant": PEOPLE, "condition": CONDITIONS, "timepoint": TIMEPOINTS, "trial": ORDER}
_ASKED = {
    "participant": ("Does {heading!r} tell participants apart?", "it does"),
    "condition": ("Is {heading!r} the condition?", "it is"),
}
"""What is asked, and assumed, of a role unless its evidence says it otherwise."""


@dataclass
class DraftedFacts:
    """Where the facts come from.

    Parameters
    ----------
    unused
        Columns with a heading for a fact that were not taken.
    levels
        Condition → factor → level, where conditions are made of crossed factors.
    """

    context: Context
    draft: TomlDraft = field(default_factory=TomlDraft)
    doubts: list[OpenDoubt] = field(default_factory=list)
    unused: list[int] = field(default_factory=list)
    levels: dict[str, dict[str, str]] = field(default_factory=dict)


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

    def _lacks_rows(self, column: int) -> bool:
        return self._table.column(column).count("") * _LACKS > len(self._table.rows)

    def heading(self, column: int) -> str:
        """Return the heading of a column."""
        return self._table.headings[column]

    def use(self, fact: str, column: int, comment: str = "", **more: object) -> None:
        """Let a fact come from a column."""
        self._context.used.add(column)
        self._context.columns[fact] = (column,)
        if fact == "condition":
            more = {**self.names_of_codes(column), **more}
        values = more.get("values")
        if isinstance(values, dict) and self._answers.row_keys:
            # Rows of other questions have words of their own.
            whole = (text for table in self._answers.tables for text in texts(table, column))
            more["values"] = values | {text: text for text in whole if text not in values}
        self.found.draft.put(fact, {"column": self.heading(column), **more}, comment)

    def names_of_codes(self, column: int) -> dict[str, object]:
        """Return `values` of a column whose codes all have a name, if a codebook says them."""
        words = texts(self._table, column)
        told = {word: self._table.meaning(column, word) for word in words}
        return {"values": told} if len({*told.values()} - {*words}) == len(words) else {}

    def doubt(self, question: str, assumed: str, stake: Stake) -> None:
        """Add a question that the files leave open."""
        self.found.doubts.append(OpenDoubt(question, assumed, stake))

    def doubt_of(self, found: Candidate) -> None:
        """Add the question that a piece of evidence leaves open."""
        role = found.evidence.role
        question, assumed = _ASKED.get(role, ("", ""))
        question = (found.evidence.question or question).format(heading=self.heading(found.column))
        self.doubt(question, found.evidence.assumed or assumed, _STAKES[role])
