"""Drafts of which files and sheets a table is, and how these are read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.draft import LAYOUT, ROWS, OpenDoubt, pattern_of
from vrcomfort.importing.toml_draft import TomlDraft

_WAYS = {
    "transpose": (
        "Do participants stand side by side, and items one below the other?",
        "they do; columns are read as rows",
    ),
    "stack": (
        "The headings repeat in the row: is each run of them a table of its own?",
        "it is; they are read one below the other",
    ),
    "marked": (
        "Is a mark in one of several columns the answer that the column is called?",
        "it is; the columns are read as one",
    ),
}
"""Key of `read` → what to ask, and what is assumed."""


def draft_reading(tables: Sequence[SourceTable]) -> tuple[TomlDraft, list[OpenDoubt]]:
    """Draft the files and sheets of tables, and how they are read, with what is to be asked."""
    first = tables[0]
    draft = TomlDraft()
    draft.put("files", [*map(pattern_of, dict.fromkeys(table.file.name for table in tables))])
    sheets = list(dict.fromkeys(table.sheet for table in tables if table.sheet))
    if sheets:
        draft.put("sheets", [*map(pattern_of, sheets)])
    read = first.reading
    values: dict[str, object] = {}
    asked: list[tuple[str, str]] = []
    doubts: list[OpenDoubt] = []
    ways = {(each.reading.encoding, each.reading.separator) for each in tables}
    if read.encoding is not None and len(ways) == 1 and read.separator is not None:
        values["encoding"] = read.encoding.replace("utf-8-sig", "utf-8")
        values["separator"] = read.separator
    if read.decimal == ",":
        values["decimal"] = ","
    if read.sections:
        values["sections"] = True
        question = "Do several tables stand one below the other, each below a title or a gap?"
        asked.append((question, f"they do: {', '.join(sheets)}"))
    elif not first.nested:
        values["heading_rows"] = list(read.heading_rows or ())
    if read.skip_rows and not read.sections:
        values["skip_rows"] = list(read.skip_rows)
        doubts += _of_skipped(first)
    for key, words in _WAYS.items():
        if getattr(read, key):
            values[key] = True
            asked.append(words)
    if read.spread:
        values["spread"] = list(read.spread)
        question = f"Has each cell of {', '.join(map(repr, read.spread))} the answers to all items?"
        asked.append((question, "it has, in the published order; each is read as a column"))
    if values:
        draft.put("read", values)
    if not read.heading_rows and "heading_rows" in values:
        question = f"{first.file.name} seems to have no headings: is its first row data?"
        asked.append((question, "it is; columns are called column 1, column 2 …"))
    return draft, doubts + [OpenDoubt(question, assumed, LAYOUT) for question, assumed in asked]


def _of_skipped(table: SourceTable) -> Iterator[OpenDoubt]:
    """Ask about rows below the headings that are not read."""
    heading, data = max(table.reading.heading_rows or (table.numbers[0],)), table.numbers[0]
    above = [n for n in table.reading.skip_rows if n < data]
    below = [n for n in table.reading.skip_rows if n > data]
    labels = [n for n in above if n > heading]
    if len(labels) == 1 and any(table.labels):
        question = f"Does row {labels[0]} say the headings in other words?"
        yield OpenDoubt(question, "it does, and is no answer", LAYOUT)
    if below:
        question = f"Are rows from {below[0]} on means, and no person's?"
        stake = ROWS._replace(instead=f"in `read`: skip_rows = {above}")
        yield OpenDoubt(question, "they are: the first is the mean of those above", stake)
