"""Joins tables that differ in columns that no analysis needs, such as remarks in a few files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.table_draft import TableDraft
from vrcomfort.importing.suggest.vocabulary import Known


def joined(drafts: Sequence[TableDraft], known: Known) -> list[TableDraft]:
    """Return drafts, of which each takes the tables of others that have all columns that it uses.

    Columns may stand in another order, and there may be more of them if they are ignored.
    """
    kept: dict[int, TableDraft] = {}
    order = sorted(range(len(drafts)), key=lambda n: -len(drafts[n].tables))
    for number in order:
        for first, draft in kept.items():
            whole = _together(draft, drafts[number], known)
            if whole is not None:
                kept[first] = whole
                break
        else:
            kept[number] = drafts[number]
    return [kept[number] for number in sorted(kept)]


def _together(draft: TableDraft, other: TableDraft, known: Known) -> TableDraft | None:
    """Return the draft of the tables of two drafts; None where they are not of one kind."""
    here, there = draft.table, other.table
    alike = here.reading._replace(encoding=None) == there.reading._replace(encoding=None)
    more = [heading for heading in there.headings if heading not in here.headings]
    used = {*here.headings} - draft.ignored
    if not draft.gives or not alike or not used <= {*there.headings}:
        return None
    if other.gives and {*more} - other.ignored:
        return None
    headings = (*here.headings, *more)
    tables = [_aligned(table, headings) for table in (*draft.tables, *other.tables)]
    whole = TableDraft(tables, known)
    people = [each.draft.values.get("participant") for each in (draft, other, whole)]
    if people[0] == people[1] != people[2]:
        return None  # codes that are one column's in each file, and in both files
    lacking = {*here.headings} ^ {*there.headings}
    if {each.table.headings[column] for each in (draft, other) for column in each.left} & lacking:
        return None
    return whole if whole.gives and lacking <= whole.ignored else None


def _aligned(table: SourceTable, headings: Sequence[str]) -> SourceTable:
    """Return a table with these columns in this order; those that it lacks are blank."""
    places = {heading: place for place, heading in enumerate(table.headings)}
    found = [places.get(heading) for heading in headings]

    def of(row: Sequence[str]) -> tuple[str, ...]:
        return tuple("" if place is None else row[place] for place in found)

    said = table.meanings
    return replace(
        table,
        headings=tuple(headings),
        labels=of(table.labels),
        meanings=tuple({} if place is None else said[place] for place in found) if said else (),
        rows=tuple(map(of, table.rows)),
    )
