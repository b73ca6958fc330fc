"""Reads the facts of the rows of one table, as a mapping says."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence

from vrcomfort.importing.columns import Columns
from vrcomfort.importing.mapping import FACTS, Fact, TableMapping, template_pattern
from vrcomfort.importing.source import SourceTable


def conditions_in(order: str) -> list[str]:
    """Return the conditions that an order such as ``A, B`` or ``AB`` gives, one after the other.

    >>> conditions_in("no blur > blur"), conditions_in("BAC"), conditions_in("B-A")
    (['no blur', 'blur'], ['B', 'A', 'C'], ['B', 'A'])
    """
    for signs in (r"[,;/>|→]+", r"[-–_\s]+"):
        parts = [part.strip() for part in re.split(signs, order) if part.strip()]
        if len(parts) > 1:
            return parts
    return [*order.strip()]


def _are_several(names: Sequence[str]) -> bool:
    """Return whether names of files or sheets, or patterns of them, can mean several."""
    return len(names) > 1 or any(sign in name for name in names for sign in "*?")


TIMEPOINT = "post"
"""What a questionnaire is taken for of which nothing says when it was asked."""


class Numbers:
    """Number sessions and trials consistently across a study's files, from 1."""

    def __init__(self) -> None:
        self._given: dict[tuple[str, ...], dict[str, int]] = defaultdict(dict)

    def of(self, group: tuple[str, ...], text: str) -> str:
        """Return the number of a text in its group."""
        given = self._given[group]
        return str(given.setdefault(text, len(given) + 1))


class RowFacts:
    """Reads the facts of the rows of one table."""

    def __init__(
        self, table: SourceTable, mapping: TableMapping, columns: Columns, numbers: Numbers
    ) -> None:
        self._table = table
        self._mapping = mapping
        self._columns = columns
        self._numbers = numbers
        self._repeats: dict[tuple[str, ...], int] = defaultdict(int)
        self._of_table = self._captured(mapping.sheet_name, table.sheet, "sheet")
        said = mapping.file_name or mapping.file_pattern
        folders = table.file.absolute().parts[:-1][-said.count("/") :] if "/" in said else ()
        name = "/".join((*folders, table.file.name.removesuffix(table.file.suffix)))
        self._of_table |= self._captured(mapping.file_name, name, "file's name")
        pattern = re.compile(mapping.file_pattern)
        self._of_table |= self._captured(mapping.file_pattern, name, "file's name", pattern)
        self._sources = [
            (name, mapping.fact(name), columns.facts.get(name))
            for name in FACTS
            if columns.facts.get(name) or mapping.fact(name).constant or name in self._of_table
        ]
        self._counted = [
            name for name in ("session", "period", "block", "trial") if mapping.fact(name).count
        ]

    @property
    def order_is_counted(self) -> bool:
        """Return whether the numbers by which an order gives conditions are counted here."""
        return self._columns.order is not None and self._mapping.condition.by in self._counted

    def key(self, cells: tuple[str, ...]) -> tuple[str, ...] | None:
        """Return the cells that say the facts of a row; None where rows are counted, too."""
        if self._counted or self._mapping.participant.count:
            return None
        return tuple([cells[i] for _, _, columns in self._sources for i in columns or ()])

    def _captured(
        self, template: str, text: str, what: str, pattern: re.Pattern[str] | None = None
    ) -> dict[str, str]:
        """Return the facts in a name; those that are not there are blank."""
        if not template:
            return {}
        match = (pattern or template_pattern(template)).fullmatch(text)
        if match is None:
            raise self._table.fault(f"the {what} {text!r} is not made as {template!r}")
        return match.groupdict(default="")

    def of_row(self, cells: tuple[str, ...], row: int) -> dict[str, str]:
        """Return the facts of a row, but for those that are counted.

        Raises
        ------
        InputError
            If a text is not among the mapping's values, with row and column.
        """
        return self._of_row(self._sources, cells, row)

    def participant(self, cells: tuple[str, ...], row: int) -> str:
        """Return the participant of a row alone."""
        sources = [each for each in self._sources if each[0] == "participant"]
        return self._of_row(sources, cells, row).get("participant", "")

    def _of_row(
        self,
        sources: Sequence[tuple[str, Fact, list[int] | None]],
        cells: tuple[str, ...],
        row: int,
    ) -> dict[str, str]:
        facts = {}
        for name, fact, columns in sources:
            text = self._said(name, fact, columns, cells)
            if text or "" in fact.values:
                facts[name] = self.renamed(name, text, row) if fact.values else text
        if self._mapping.participant.count and "participant" in facts:
            facts["participant"] = self._numbers.of(("participant",), facts["participant"])
        elif self._mapping.participant.count:
            facts["participant"] = f"R{row:03d}"
        if self._mapping.participant.apart and facts.get("participant"):
            facts["participant"] = f"{self._place}_{facts['participant']}"
        return facts

    @property
    def _place(self) -> str:
        """Return the file or the sheet, or both, by which people with one code are told apart."""
        sheet = self._table.sheet if _are_several(self._mapping.sheets) else ""
        file = self._table.file.name.removesuffix(self._table.file.suffix)
        return f"{file}_{sheet}".strip("_") if _are_several(self._mapping.files) else sheet or file

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

    def in_order(
        self, facts: Mapping[str, str], cells: tuple[str, ...], row: int
    ) -> Mapping[str, str]:
        """Return the facts with the condition that an order of conditions gives.

        Raises
        ------
        InputError
            If the order has no condition of this number, with row and column.
        """
        column, by = self._columns.order, self._mapping.condition.by
        number = facts.get(by, "")
        if column is None or not number or not cells[column]:
            return facts
        parts = conditions_in(cells[column])
        if not number.isdecimal() or not 0 < int(number) <= len(parts):
            message = f"the order {cells[column]!r} has no condition number {number} ({by})"
            raise self._table.fault(message, row, column)
        return {**facts, "condition": self.renamed("condition", parts[int(number) - 1], row)}

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
        """Return a key that tells this exposure from the others of its session."""
        when = facts.get("timepoint") or TIMEPOINT
        what = tuple(facts.get(n, "") for n in ("participant", "session", "condition", "scene"))
        self._repeats[*what, when, item] += 1
        return "/".join((*what, str(self._repeats[*what, when, item])))
