"""Shows files, coloured by the roles of their columns, beside the mapping: a page to read it by.

The page has no script: the mapping stands in a text field, to be mended and copied.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from vrcomfort import __version__
from vrcomfort.errors import InputError
from vrcomfort.files import open_file
from vrcomfort.importing.columns import Block, Columns
from vrcomfort.importing.convert import tables_of
from vrcomfort.importing.mapping import FACTS, LabMapping, Scores, TableMapping, matches
from vrcomfort.importing.preview import preview
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.source import SourceTable
from vrcomfort.questionnaire import Instrument, shipped_instruments
from vrcomfort.web_page import page_templates

TEMPLATE = "import_preview.html.j2"
_MARK = b'<meta name="generator" content="vrcomfort'
MOST_ROWS, MOST_TABLES = 30, 8
"""Of each table, and tables of a study of many files: the first ones."""
KINDS = {
    "participant": "participant",
    "condition": "condition",
    "timepoint": "timepoint",
    "exposure": "session, exposure, scene",
    "answer": "answer",
    "score": "score",
    "time": "time of a rating, or of leaving",
    "covariate": "known of participants",
    "ignored": "not taken",
}
"""Kind of a column → its name in the key."""


def is_preview(file: Path) -> bool:
    """Return whether a file is a page of an import, which may be replaced."""
    with open_file(file) as stream:
        return _MARK in stream.read(2000)


@dataclass(frozen=True)
class ColumnView:
    """A column, its kind and its role in words."""

    heading: str
    kind: str
    role: str


@dataclass(frozen=True)
class RowView:
    """A row as numbered in the file, and whether it is left out."""

    number: int
    cells: tuple[str, ...]
    left_out: bool


@dataclass(frozen=True)
class TableView:
    """The first rows of a table.

    Parameters
    ----------
    refusal
        The reason for which its columns are not understood, or nothing.
    more
        How many rows follow.
    """

    name: str
    columns: list[ColumnView]
    rows: list[RowView]
    more: int
    refusal: str


def render_preview(
    files: Sequence[Path],
    mapping: LabMapping,
    text: str,
    imported: Imported | None,
    own: Sequence[Instrument] = (),
) -> str:
    """Return a page with the files, coloured by role, and the mapping beside them.

    Parameters
    ----------
    text
        The mapping's TOML.
    imported
        What it makes of the files; None where it is refused.

    Raises
    ------
    InputError
        If a file cannot be read.
    """
    every = {each.name: each for each in (*mapping.declared, *own)}
    known = {**shipped_instruments(), **every}
    tables = list(_views(files, mapping, known))
    used = {column.kind for table in tables for column in table.columns}
    page = page_templates().get_template(TEMPLATE)
    return page.render(
        title=mapping.name or files[0].stem,
        version=__version__,
        kinds={kind: name for kind, name in KINDS.items() if kind in used},
        tables=tables[:MOST_TABLES],
        further=[table.name for table in tables[MOST_TABLES:]],
        mapping=mapping,
        lines=text.splitlines(),
        found=preview(imported) if imported is not None else [],
        notes=imported.notes if imported is not None else [],
    )


def _views(
    files: Sequence[Path], mapping: LabMapping, known: Mapping[str, Instrument]
) -> list[TableView]:
    return [
        _view(table, each, known)
        for file in files
        for each in mapping.tables
        if matches(file.name, each.files)
        for table in tables_of(file, each, mapping.ignore_sheets)
    ]


def _view(table: SourceTable, mapping: TableMapping, known: Mapping[str, Instrument]) -> TableView:
    try:
        columns = Columns(table, mapping, known)
        refusal = ""
        views = [_column(columns, index, heading) for index, heading in enumerate(table.headings)]
        out = columns.leave_out
    except InputError as error:
        refusal, out = error.message, {}
        views = [ColumnView(heading, "ignored", "not understood") for heading in table.headings]
    rows = [
        RowView(number, cells, any(cells[i] in texts for i, texts in out.items()))
        for number, cells in zip(table.numbers, table.rows, strict=True)
    ]
    # Rows that are left out often stand last: they are shown, too.
    last = [row for row in rows[MOST_ROWS:] if row.left_out][:5]
    shown = [*rows[:MOST_ROWS], *last]
    return TableView(table.name, views, shown, len(rows) - len(shown), refusal)


def _column(columns: Columns, index: int, heading: str) -> ColumnView:
    for block in (*columns.blocks, *columns.scores):
        if index in block.columns or index in {block.item_column, block.response_column}:
            kind = "score" if isinstance(block.source, Scores) else "answer"
            return ColumnView(heading, kind, _of_block(block, index))
    said = columns.use_of(index)
    if said.startswith("participants."):
        return ColumnView(heading, "covariate", said.removeprefix("participants."))
    fact = said.removeprefix("beside.").removesuffix(".order")
    if fact in {"participant", "condition", "timepoint"}:
        return ColumnView(heading, fact, said)
    if fact in FACTS:
        return ColumnView(heading, "exposure", said)
    kind = "time" if said in {"time", "left_at"} else "ignored"
    return ColumnView(heading, kind, "not taken" if said in {"", "ignore"} else said)


def _of_block(block: Block, index: int) -> str:
    what = block.columns.get(index, "item" if index == block.item_column else "answer")
    facts = " · ".join(text for text in block.facts.values() if text)
    return f"{block.instrument.short}: {what}" + (f" ({facts})" if facts else "")
