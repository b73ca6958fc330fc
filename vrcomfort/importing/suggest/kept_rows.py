"""Keeps the rows of a table that are people's answers, and asks about those left out."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence, Set
from dataclasses import replace
from itertools import pairwise

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.answer_columns import LAYOUTS, LONG, AnswerColumns
from vrcomfort.importing.suggest.codings import missing_texts
from vrcomfort.importing.suggest.draft import CONDITIONS, PEOPLE, ROWS, OpenDoubt
from vrcomfort.importing.suggest.evidence import FIRST_COLUMNS
from vrcomfort.importing.suggest.heading_roles import roles_of
from vrcomfort.importing.suggest.long_tables import Long
from vrcomfort.importing.suggest.read_tables import draft_reading
from vrcomfort.importing.suggest.summary_rows import (
    notes_below,
    repeated_headings,
    rows_of_trial_runs,
    scores_of_others,
    total_rows,
)
from vrcomfort.importing.suggest.vocabulary import LabVocabulary


def _is_written_once(cells: Sequence[str]) -> bool:
    """Return whether most texts have blanks below them: the last one alone may have notes there."""
    if not cells[0] or cells.count("") * 4 < len(cells):
        return False
    places = [place for place, cell in enumerate(cells) if cell]
    below = [b - a - 1 for a, b in pairwise([*places, len(cells)])]
    return sum(map(bool, below)) * 2 > len(below)


class KeptRows:
    """The rows of tables with the same headings, without those that are no person's."""

    def __init__(self, tables: Sequence[SourceTable], vocabulary: LabVocabulary) -> None:
        self.tables = tables
        self._vocabulary = vocabulary
        rows = tuple(row for table in tables for row in table.rows)
        self.table = replace(tables[0], rows=rows)
        self.draft, self.doubts = draft_reading(tables)
        self._left_out = defaultdict(list, self._total_rows())
        """Column → texts of rows that are left out."""
        self._missing: dict[int, list[str]] = {}
        """Column beside the answers → texts that say nothing."""
        self._trial_runs = self._trial_run_columns()
        self._fill_down()
        self._said_once()
        self._rows_below()
        self.every_row = self.table
        """The table with rows that hold no answers."""

    @property
    def files(self) -> list[str]:
        """Return the names of the files."""
        return list(dict.fromkeys(table.file.name for table in self.tables))

    def _total_rows(self) -> dict[int, list[str]]:
        """Take rows of means and sums out of the table; return column → their texts."""
        for column in range(min(FIRST_COLUMNS, len(self.table.headings))):
            found = [
                text
                for table in self.tables
                for text in total_rows(table, column, self._vocabulary.totals)
            ]
            found += repeated_headings(self.table, column)
            found += scores_of_others(self.table, column, self._vocabulary)
            if found:
                rows = tuple(row for row in self.table.rows if row[column] not in found)
                self.table = replace(self.table, rows=rows)
                return {column: list(dict.fromkeys(found))}
        return {}

    def _trial_run_columns(self) -> list[int]:
        """Take rows of trial runs out of the table; return the columns that say so."""
        found = rows_of_trial_runs(self.table, self._vocabulary)
        for column, words in found.items():
            kept = tuple(row for row in self.table.rows if row[column] not in words)
            self.table = replace(self.table, rows=kept)
            self._left_out[column] += words
        return [*found]

    def _fill_down(self) -> None:
        """Let blank cells of a column of participants mean the one above, where they are many."""
        first = range(min(FIRST_COLUMNS, len(self.table.headings)))
        facts = roles_of(self.table, range(len(self.table.headings)), self._vocabulary).facts
        named = facts.get("participant", facts.get("condition", []))
        columns = [column for column in named if column in first]
        for column in columns or ([0] if self.table.reading.transpose else []):
            cells = self.table.column(column)
            if _is_written_once(cells):
                merged = [c for c in first if c != column]
                merged = [c for c in merged if _is_written_once(self.table.column(c))]
                for each in (column, *merged):
                    self._fill(each)
                names = [self.table.headings[each] for each in (column, *merged)]
                self.draft.put("fill_down", names)
                shown = " and ".join(map(repr, names))
                question = f"Do the blank cells of {shown} mean what stands above them?"
                self.doubts.append(OpenDoubt(question, "they do", PEOPLE))
                return

    def _fill(self, column: int) -> None:
        above, rows = "", []
        for row in self.table.rows:
            above = row[column] or above
            rows.append((*row[:column], above, *row[column + 1 :]))
        self.table = replace(self.table, rows=tuple(rows))

    def _rows_below(self) -> None:
        """Take rows below the last participant out of the table: statistics stand there."""
        every = range(len(self.table.headings))
        named = roles_of(self.table, every, self._vocabulary).facts.get("participant", [])
        named = [c for c in named if any(self.table.column(c))]
        named = named or ([0] if self.table.reading.transpose else [])
        cells = self.table.column(named[0]) if named else []
        last = max((place for place, cell in enumerate(cells) if cell), default=-1)
        if 0 <= last < len(cells) - 1:
            kept = self.table.rows[: last + 1]
            self.table = replace(self.table, rows=kept)
            self._left_out[named[0]].append("")
        if named and named[0] < FIRST_COLUMNS and (notes := notes_below(self.table, named[0])):
            self.table = replace(self.table, rows=self.table.rows[: -len(notes)])
            self._left_out[named[0]] += notes

    def _said_once(self) -> None:
        """Let a column of groups that each person's first row alone fills hold for the others."""
        facts = roles_of(self.table, range(len(self.table.headings)), self._vocabulary)
        columns = [c for n, c in facts.covariates.items() if n == "group"]
        columns += facts.facts.get("condition", [])
        named = facts.facts.get("participant", [])
        people = self.table.column(named[0]) if named else []
        first = [n for n, who in enumerate(people) if n == 0 or who != people[n - 1]]
        if not len({*people}) == len(first) < len(people):
            return
        for column in dict.fromkeys(columns):
            filled = [n for n, cell in enumerate(self.table.column(column)) if cell]
            if filled == first and self.table.headings[column] not in self._filled_down():
                self._fill(column)
                names = [*self._filled_down(), self.table.headings[column]]
                self.draft.put("fill_down", names)
                question = f"Does {names[-1]!r} of a person's first row hold for the others?"
                self.doubts.append(OpenDoubt(question, "it does", CONDITIONS))

    def _filled_down(self) -> list[str]:
        """Return the headings of columns whose blank cells have been filled so far."""
        there = self.draft.values.get("fill_down", [])
        return there if isinstance(there, list) else []

    def _keep_answered(self, answers: AnswerColumns) -> None:
        """Take rows without answers out of the table, such as other events of a log."""
        columns = [c for layout in LAYOUTS for each in answers[layout] for c in each.columns]
        if long := answers[LONG]:
            columns = [each.response_column for each in long]
        rows = tuple(row for row in self.table.rows if any(row[c] for c in columns))
        if rows:
            self.table = replace(self.table, rows=rows)

    def _without_missing(self, answers: Set[int]) -> SourceTable:
        """Return the table with blanks for words such as n/a in the columns beside the answers."""
        for column in {*range(len(self.table.headings))} - answers:
            if found := missing_texts(self.table.column(column), self._vocabulary):
                self._missing[column] = found
        if not self._missing:
            return self.table
        rows = (
            tuple("" if text in self._missing.get(c, ()) else text for c, text in enumerate(row))
            for row in self.table.rows
        )
        return replace(self.table, rows=tuple(rows))

    def _say_missing(self, columns: Iterable[int]) -> None:
        """Say which texts of columns stand for nothing."""
        words = [text for column in columns for text in self._missing.get(column, ())]
        if words:
            self.draft.put("missing", list(dict.fromkeys(words)))

    def _keep_items(self, long: Sequence[Long]) -> None:
        """Take rows of other questions out of a long table: their facts are no answers' facts."""
        words = {(e.item_column, text) for e in long for text in e.items.values()}
        columns = {column for column, _ in words}
        rows = tuple(r for r in self.table.rows if any((c, r[c]) in words for c in columns))
        if rows:
            self.table = replace(self.table, rows=rows)

    def _leave_out(self, participant: int | None) -> None:
        out = {column: list(dict.fromkeys(found)) for column, found in self._left_out.items()}
        if participant is not None and not all(self.table.column(participant)):
            out[participant] = list(dict.fromkeys([*out.get(participant, []), ""]))
        if not out:
            return
        names = self.table.headings
        self.draft.put("leave_out", {names[c]: found for c, found in out.items()})
        for column, found in out.items():
            shown = ", ".join(repr(text) if text else "nothing" for text in found)
            question = (
                f"May the rows with {shown} in {names[column]!r} be left out, as no person's?"
            )
            self.doubts.append(OpenDoubt(question, "they are left out", ROWS))
