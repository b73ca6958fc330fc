"""What a row's columns, its file's name and the mapping say of a moment."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

from vrcomfort.importing.columns import Columns
from vrcomfort.importing.mapping import FACTS, Fact, Table, template_pattern
from vrcomfort.importing.source import SourceTable

TIMEPOINT = "post"
"""What a questionnaire is taken for of which nothing says when it was asked."""


class Numbers:
    """Numbers that are given to what is met, from 1, over all files of a study."""

    def __init__(self) -> None:
        self._given: dict[tuple[str, ...], dict[str, int]] = defaultdict(dict)

    def of(self, group: tuple[str, ...], text: str) -> str:
        """Return the number of a text in its group."""
        given = self._given[group]
        return str(given.setdefault(text, len(given) + 1))


class RowFacts:
    """Reads the facts of the rows of one table."""

    def __init__(
        self, table: SourceTable, mapping: Table, columns: Columns, numbers: Numbers
    ) -> None:
        self._table = table
        self._mapping = mapping
        self._columns = columns
        self._numbers = numbers
        self._repeats: dict[tuple[str, ...], int] = defaultdict(int)
        self._of_table = self._captured(mapping.sheet_name, table.sheet, "sheet")
        name = table.file.name.removesuffix(table.file.suffix)
        self._of_table |= self._captured(mapping.file_name, name, "file's name")
        self._sources = [
            (name, mapping.fact(name), columns.facts.get(name))
            for name in FACTS
            if columns.facts.get(name) or mapping.fact(name).constant or name in self._of_table
        ]
        self._counted = [
            name for name in ("session", "period", "block", "trial") if mapping.fact(name).count
        ]

    def key(self, cells: tuple[str, ...]) -> tuple[str, ...] | None:
        """Return the cells that say the facts of a row; None where rows are counted, too."""
        if self._counted or self._mapping.participant.count:
            return None
        return tuple([cells[i] for _, _, columns in self._sources for i in columns or ()])

    def _captured(self, template: str, text: str, what: str) -> dict[str, str]:
        if not template:
            return {}
        match = template_pattern(template).fullmatch(text)
        if match is None:
            raise self._table.fault(f"the {what} {text!r} is not made as {template!r}")
        return match.groupdict()

    def of_row(self, cells: tuple[str, ...], row: int) -> dict[str, str]:
        """Return the facts of a row, but for those that are counted.

        Raises
        ------
        InputError
            If a text is not among the mapping's values, with row and column.
        """
        facts = {}
        for name, fact, columns in self._sources:
            text = self._said(name, fact, columns, cells)
            if text:
                facts[name] = self.renamed(name, text, row) if fact.values else text
        if self._mapping.participant.count:
            facts["participant"] = f"R{row:03d}"
        return facts

    def _said(
        self, name: str, fact: Fact, columns: list[int] | None, cells: tuple[str, ...]
    ) -> str:
        if columns:
            texts = [cells[i] for i in columns]
            if self._mapping.missing:
                texts = ["" if text in self._mapping.missing else text for text in texts]
            return "_".join(texts) if all(texts) else ""
        return fact.constant or self._of_table.get(name, "")

    def renamed(self, name: str, text: str, row: int) -> str:
        """Return our word for the file's.

        Raises
        ------
        InputError
            If the mapping has words for this fact, and not this one.
        """
        values = self._mapping.fact(name).values
        if not values or (text in values.values() and text not in values):
            return text
        if text in values:
            return values[text]
        if name == "participant":
            return text
        columns = self._columns.facts.get(name)
        message = f"{text!r} is not among the values of {name} in the mapping; add it there"
        raise self._table.fault(message, row, columns[0] if columns else None)

    def counted(self, facts: Mapping[str, str], item: str = "") -> dict[str, str]:
        """Return the facts with numbers where the mapping has them counted.

        Parameters
        ----------
        item
            What a row of a long table answers: an exposure is asked of each item once.
        """
        out = dict(facts)
        for name in self._counted:
            session = "" if name == "session" else out.get("session", "")
            group = (name, out.get("participant", ""), session)
            out[name] = self._numbers.of(group, out.get(name) or self._exposure(out, item))
        return out

    def _exposure(self, facts: Mapping[str, str], item: str) -> str:
        """Return what tells this exposure from the others of its session."""
        when = facts.get("timepoint") or TIMEPOINT
        what = tuple(facts.get(n, "") for n in ("participant", "session", "condition", "scene"))
        self._repeats[*what, when, item] += 1
        return "/".join((*what, str(self._repeats[*what, when, item])))
