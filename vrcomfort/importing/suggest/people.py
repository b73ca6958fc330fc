"""Drafts where the participant comes from."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from vrcomfort.importing.suggest.cells import texts, varies_within
from vrcomfort.importing.suggest.draft import PEOPLE
from vrcomfort.importing.suggest.evidence import RECURRING_NAMES, candidates
from vrcomfort.importing.suggest.fact_draft import FactDraft
from vrcomfort.importing.suggest.shared_codes import are_others, constants_of, place_of, with_places


def _are_even(cells: Sequence[str]) -> bool:
    """Return whether each text is in equally many cells."""
    return len({*Counter(cells).values()}) == 1


class People(FactDraft):
    """Finds who the participants are, or asks."""

    _apart = False
    """Whether people of each file, or sheet, are others."""

    def _varies(self, column: int) -> bool:
        """Return whether a participant has more than one text in a column."""
        tables = self._answers.tables if self._apart else [self._table]
        return any(varies_within(table, column, self._context.participant) for table in tables)

    def _participant_column(self) -> None:
        """Take the column whose heading says that it has the participants."""
        if self._context.participant is None:
            self._named_column()
        self._people_of_places()

    def _named_column(self) -> None:
        columns = self._roles.facts.get("participant", [])
        told = [c for c in columns if self._vocabulary.told(self.heading(c)) == "participant"]
        if told:
            self._context.participant = told[-1]
            if told[1:]:
                self._join_people(told[-1], told[0])
            return
        columns = [c for c in columns if len(texts(self._table, c)) > 1] or columns
        columns = [c for c in columns if not self._has_codes(c)] or columns
        if columns:
            self._context.participant = columns[0]
            if (corrected := self._corrected(columns[0])) is not None:
                self._roles.forget(corrected)
                self._roles.facts["participant"].insert(0, corrected)
                self._context.participant = corrected
                self._ask_which([corrected, columns[0]])
                return
            columns = [c for c in columns if c in self._roles.alike["participant"]]
            same = {tuple(self._table.column(column)) for column in columns}
            if len(same) > 1:
                self._ask_which(columns)

    def _ask_which(self, columns: Sequence[int]) -> None:
        names = ", ".join(repr(self.heading(c)) for c in columns)
        question = f"Which of the columns {names} tells participants apart?"
        self.doubt(question, f"`{self.heading(columns[0])}`", PEOPLE)

    def _corrected(self, column: int) -> int | None:
        """Return the column that has the codes of another once more, with its errors mended.

        Most rows have the same text in both. There each person has equally many rows, here not.
        """
        cells = self._table.column(column)
        if _are_even(cells):
            return self._context.code_of_rows(column)
        for other in range(len(self._table.headings)):
            texts_there = self._table.column(other) if other != column else ()
            alike = sum(a == b != "" for a, b in zip(cells, texts_there, strict=False))
            if 2 * alike > len(cells) > alike and all(texts_there) and _are_even(texts_there):
                return other
        return None

    def _has_codes(self, column: int) -> bool:
        """Return whether a column has codes of missing values, such as -66, in place of people."""
        return any(
            re.fullmatch(r"-\d+", text) or text.casefold() in self._vocabulary.missing
            for text in texts(self._table, column)
        )

    def _people_of_places(self) -> None:
        """Let a code and its place be the person, where several people have one code; and ask."""
        people = self._context.participant
        if people is None or "participant" in self._context.columns:
            return
        place = place_of(self._table, people, self._roles, self._answers.taken)
        if place is None:
            return
        self._join_people(people, place)
        a, b = self.heading(place), self.heading(people)
        question = f"Is a code in {b!r} another person in each {a!r}?"
        self.doubt(question, "it is: codes are counted anew, or age or the like differs", PEOPLE)

    def _join_people(self, people: int, place: int) -> None:
        """Let two columns together tell people apart."""
        tables = [with_places(table, people, place) for table in self._answers.tables]
        self._answers = replace(self._answers, tables=tables)
        self._table = self._context.table = with_places(self._table, people, place)
        self._context.columns["participant"] = (people,)
        self._context.used.add(people)
        names = [self.heading(place), self.heading(people)]
        self.found.draft.put("participant", {"columns": names})

    def _numbered_anew(self, column: int) -> None:
        """Ask whether people who have the same codes in several sheets or files are the same."""
        tables = self._answers.tables
        if len(tables) < 2 or "participant" in self._context.columns:
            return
        people = [{*table.column(column)} - {""} for table in tables]
        counted = all(each == {str(n + 1) for n in range(len(each))} for each in people)
        counted = counted and all(len(each) > 1 for each in people)
        groups = "condition" in self._named and "participant" not in self._named
        others = are_others(tables, column, constants_of(self._table, column, self._roles))
        if not others and not (counted and groups):
            return
        what = "sheets" if len({table.file for table in tables}) < len(tables) else "files"
        question = f"People have the same codes in several {what}: are they the same people?"
        other = "they are; else write `apart = true` into `participant`"
        if others or len({len(each) for each in people}) > 1:
            self.use("participant", column, apart=True)
            self._apart = True
            other = "they are not, as their number, or age or the like, differs"
        self.doubt(question, other, PEOPLE)

    def _participant(self) -> None:
        column = self._context.participant
        if "participant" in self._answers.said:
            return
        if "participant" in self._named or "participant" in self._context.columns:
            return
        if column is None:
            columns = (*self._roles.unknown, *self._roles.metadata)
            for found in candidates("participant", columns, self._context)[:1]:
                column = found.column
                self.doubt_of(found)
                if found.evidence is RECURRING_NAMES:
                    self._context.participant = column
                    self.use("participant", column, "numbered, without the names", count=True)
                    return
                if column in self._roles.unknown:
                    self._roles.unknown.remove(column)
        if column is not None:
            self._context.participant = column
            self._people_of_places()
            self._numbered_anew(column)
            if "participant" not in self._context.columns:
                self.use("participant", column)
        elif self._context.one_row_each:
            self._each_row()
        else:
            person = self._table.file.name.removesuffix(self._table.file.suffix)
            self.found.draft.put("participant", {"constant": person})
            question = "No column tells participants apart: are all answers of one person?"
            self.doubt(question, f"they are, of {person!r}", PEOPLE)

    def _each_row(self) -> None:
        """Take each row for another person, of several files and sheets, too; and ask."""
        tables = self._answers.tables
        again = "timepoint" in self._named and len({len(table.rows) for table in tables}) == 1
        apart = len(tables) > 1 and not again
        self.found.draft.put(
            "participant", {"count": True, **({"apart": True} if apart else {})}, "the row's number"
        )
        assumed = "it is" if not again else "it is; rows of one number in several files are one's"
        self.doubt(
            "No column tells participants apart: is each row another person?", assumed, PEOPLE
        )
