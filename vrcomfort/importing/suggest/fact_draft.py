"""What is drafted of where facts come from, and what is known when they are looked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.draft import Doubt, Draft
from vrcomfort.importing.suggest.roles import (
    Roles,
)


@dataclass(frozen=True)
class Exposures:
    """What is known of a table when its facts are looked for.

    Parameters
    ----------
    said
        Facts that the headings of the answers say.
    taken
        Columns of answers.
    one_row_each
        A row is a person or a questionnaire, and not an answer.
    row_keys
        Columns that tell the rows of one questionnaire apart.
    time
        The column of the seconds of ratings.
    """

    table: SourceTable
    tables: Sequence[SourceTable]
    roles: Roles
    said: set[str]
    taken: set[int]
    one_row_each: bool
    row_keys: Sequence[int]
    answered: bool
    time: int | None


@dataclass
class DraftedFacts:
    """Where the facts come from.

    Parameters
    ----------
    participant
        The column of the participants, if there is one.
    used
        Columns that are taken.
    unused
        Columns that were looked at, and are not.
    """

    draft: Draft = field(default_factory=Draft)
    doubts: list[Doubt] = field(default_factory=list)
    participant: int | None = None
    used: set[int] = field(default_factory=set)
    unused: list[int] = field(default_factory=list)
    covariates: dict[str, int] = field(default_factory=dict)
    columns: dict[str, tuple[int, ...]] = field(default_factory=dict)


class FactDraft:
    """Writes down where facts come from; several of them write into one draft."""

    def __init__(self, known: Exposures, found: DraftedFacts, named: dict[str, list[str]]) -> None:
        self._known = known
        self._table = known.table
        self._roles = known.roles
        self._named = named
        self.found = found

    def heading(self, column: int) -> str:
        """Return the heading of a column."""
        return self._table.headings[column]

    def use(self, fact: str, column: int, comment: str = "", **more: object) -> None:
        """Let a fact come from a column."""
        self.found.used.add(column)
        self.found.columns[fact] = (column,)
        self.found.draft.put(fact, {"column": self.heading(column), **more}, comment)

    def doubt(self, question: str, assumed: str) -> None:
        """Ask."""
        self.found.doubts.append(Doubt(question, assumed))
