"""Finds the answers of a table by the ways in which they can stand there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.block_conditions import (
    A_PRODUCT,
    A_WEIGHT,
    comparisons,
    without_made,
)
from vrcomfort.importing.suggest.cells import texts
from vrcomfort.importing.suggest.found_answers import Found, FoundAnswers, mentions, named_by_file
from vrcomfort.importing.suggest.heading_roles import Roles
from vrcomfort.importing.suggest.items import find_blocks
from vrcomfort.importing.suggest.long_tables import Long, find_long
from vrcomfort.importing.suggest.own_instruments import TakenFor, own_instruments
from vrcomfort.importing.suggest.own_questions import OwnQuestions, draft_own
from vrcomfort.importing.suggest.own_rows import draft_own_rows, own_rows
from vrcomfort.importing.suggest.questionnaires import (
    Drafted,
    draft_block,
    draft_course,
    draft_long,
    draft_rating,
    lacks_its_item,
    may_answer,
)
from vrcomfort.importing.suggest.ratings import find_courses, find_ratings
from vrcomfort.importing.suggest.scores import find_scores, weighted
from vrcomfort.importing.suggest.vocabulary import IGNORED, OUTCOME, Known
from vrcomfort.questionnaire import Instrument, plain

FoundT = TypeVar("FoundT", bound=FoundAnswers)


@dataclass(frozen=True)
class Layout(Generic[FoundT]):
    """A way in which answers stand in a table.

    Parameters
    ----------
    weight
        Heavier layouts take their columns first; the others look among those that are left.
    find
        Returns the answers in some columns of a table; None for the lab's own, which take what the
        others leave.
    draft
        Drafts the questionnaire of what was found; None for scores, which are drafted together.
    whole
        The layout is that of a whole table: a table has at most one such layout.
    """

    name: str
    weight: int
    find: Callable[[SourceTable, Sequence[int], Known], list[FoundT]] | None
    draft: Callable[[SourceTable, FoundT, Mapping[str, str], Known, Roles], Drafted] | None = None
    whole: bool = False


def _draft_rows(
    table: SourceTable, long: Long, facts: Mapping[str, str], known: Known, roles: Roles
) -> Drafted:
    draft = draft_long if long.instrument in known.instruments else draft_own_rows
    return draft(table, long, facts, known, roles)


LONG = Layout("a row for each answer", 50, find_long, _draft_rows, whole=True)
BLOCKS = Layout("a column for each item", 40, find_blocks, draft_block, whole=True)
RATINGS = Layout("a column of ratings", 30, find_ratings, draft_rating)
COURSES = Layout("a column for each time of a rating", 20, find_courses, draft_course)
SCORES = Layout("columns of scores", 10, find_scores)
OWN: Layout[Found] = Layout("a column for each question of the lab's own", 5, None, draft_own)
LAYOUTS: tuple[Layout[Any], ...] = (LONG, BLOCKS, RATINGS, COURSES, SCORES, OWN)


class AnswerColumns:
    """The answers of a table, by their layouts.

    Parameters
    ----------
    left
        Column that nothing else knows → what it is taken for.
    """

    def __init__(
        self, table: SourceTable, known: Known, left: Mapping[int, TakenFor] | None = None
    ) -> None:
        self._found: dict[Layout[Any], list[Any]] = {}
        self._left = left or {}
        self._known = {each.name for each in known.instruments}
        self.taken: set[int] = set()
        """Columns of answers."""
        self.codes: list[str] = []
        """Words for conditions in the headings of the lab's own questions."""
        self.made = dict.fromkeys(comparisons(table, known), A_WEIGHT)
        """Column that is made of others, or of the comparisons of items → what it is."""
        self.taken.update(self.made)
        self.computed: set[int] = set()
        """Columns that are sums of others, or the reverse of one."""
        # "Marca temporal" is no temporal demand: a program writes it, and nobody answers it.
        roles = [known.vocabulary.roles.get(plain(heading)) for heading in table.headings]
        told = [*map(known.vocabulary.told, table.headings)]
        meta = {c for c, role in enumerate(roles) if role == IGNORED and told[c] != OUTCOME}
        meta |= {c for c, role in enumerate(told) if role not in {"", OUTCOME}}
        own = {c for c, role in enumerate(told) if role == OUTCOME}
        for layout in sorted(LAYOUTS, key=lambda each: -each.weight):
            closed_to = self.taken | meta | (own if layout is not OWN else set())
            free = [c for c in range(len(table.headings)) if c not in closed_to]
            closed = layout.whole and any(
                each.whole and found for each, found in self._found.items()
            )
            if layout.find is None:
                self._found[layout] = self._own(table, free, known)
            else:
                self._found[layout] = [] if closed else layout.find(table, free, known)
            if layout is BLOCKS:
                self._found[layout], made = without_made(table, self._found[layout])
                self.made |= made
                self.taken.update(made)
            if layout is SCORES and self.has_products:
                self._found[layout] = [weighted(each) for each in self._found[layout]]
            self.taken.update(c for each in self._found[layout] for c in each.columns)

    def _own(self, table: SourceTable, columns: Sequence[int], known: Known) -> list[Found]:
        """Find the lab's own questions, and let those in rows and in courses join their kind."""
        if self._found[LONG] or not any(self._found.values()):
            own = own_rows(table, known, self._found[LONG])
            self._found[LONG] = [*_without_rows(self._found[LONG], own), *own]
            self.taken.update(c for each in own for c in each.columns)
            columns = [c for c in columns if c not in self.taken]
        if self._found[LONG]:
            return []
        sums = [block for block in self._found[BLOCKS] if lacks_its_item(table, block)]
        columns = [
            column
            for column in columns
            if not any(may_answer(table, column, b.instrument, known.vocabulary) for b in sums)
        ]
        contexts = [each.context for found in self._found.values() for each in found]
        found = OwnQuestions(table, columns, known, contexts, self._left)
        self._found[COURSES] += found.courses
        self._found[RATINGS] += found.rated
        self.taken.update(c for each in (*found.courses, *found.rated) for c in each.columns)
        questions = [] if found.rated else own_instruments(found.questions)
        self.computed = found.computed
        self.codes = ["_".join(code).upper() for code in found.conditions]
        return questions

    def __getitem__(self, layout: Layout[FoundT]) -> list[FoundT]:
        return self._found[layout]

    def __bool__(self) -> bool:
        return any(self._found.values())

    @property
    def has_products(self) -> bool:
        """Return whether answers times their weights stand beside the answers."""
        return A_PRODUCT in self.made.values()

    @property
    def own(self) -> list[Instrument]:
        """Return the lab's own instruments."""
        found = (each.instrument for of_layout in self._found.values() for each in of_layout)
        return [*{each.name: each for each in found if each.name not in self._known}.values()]

    @property
    def instruments(self) -> set[str]:
        """Return the names of the instruments that were found."""
        return {each.instrument.name for found in self._found.values() for each in found}

    def named(self, table: SourceTable, known: Known) -> set[str]:
        """Return the names of instruments that a file, a sheet, or a column of them names."""
        columns = {e.instrument_column[0] for e in self[LONG] if e.instrument_column is not None}
        said = " ".join(text for column in columns for text in texts(table, column))
        return mentions(said, known.instruments) | named_by_file(table, known.instruments)

    def places_of(self, names: Set[str]) -> list[tuple[int, str | None]]:
        """Return where instruments have answers: columns, or columns that name them and how."""
        blocks = [each for each in self[BLOCKS] if each.instrument.name in names]
        rows = [each.instrument_column for each in self[LONG] if each.instrument.name in names]
        return [*((c, None) for each in blocks for c in each.columns), *filter(None, rows)]

    @property
    def leading(self) -> Layout[Any] | None:
        """Return the layout with the facts of a row in its headings, if there is one."""
        leading: tuple[Layout[Any], ...] = (BLOCKS, SCORES, RATINGS, OWN)
        if any(each.context for each in self[LONG]):
            leading = (LONG, *leading)
        answered = {each.instrument for each in (*self[BLOCKS], *self[LONG])}
        made = all(each.instrument in answered for each in self[SCORES])
        return next((e for e in leading if self[e] and not (e is SCORES and made)), None)


def _without_rows(found: Sequence[Long], own: Sequence[Long]) -> list[Long]:
    """Return long tables without the rows that are of the lab's own questions."""
    taken = {text for each in own for text in each.items.values()}
    names = tuple(each.instrument_column[1] for each in own if each.instrument_column)
    return [
        replace(each, others=[text for text in each.others if text not in taken], beside=names)
        for each in found
    ]
