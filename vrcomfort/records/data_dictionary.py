"""The page of a study's tables, columns and events: ``docs/data_dictionary.md``."""

from __future__ import annotations

import inspect
from collections.abc import Iterator

from vrcomfort.records.events import EVENTS
from vrcomfort.records.rows import Column, Needs, Row, declared
from vrcomfort.records.schema import OPTIONAL_ROWS, SCHEMA_VERSION, STUDY_ROWS, TABLES

_HEAD = """\
# Data dictionary

Made from the declarations in `vrcomfort/records` (`python scripts/data_dictionary.py`), and so
complete: the tables of a study with their columns in order, and the events. How cells are written:
[CONVENTIONS.md](../CONVENTIONS.md#files).

- **Blank** says what a blank cell means; a column without it is never blank, but in copies for
  others.
- **Since** is the schema version that introduced a column, where that is not 1 (now {version}).
  Older studies are whole without it; `vrcomfort verify` lists the columns that a session lacks.
- **Kept with** names what `vrcomfort anonymise` has to keep for a column, or a file, to stay:
  `motion` and `gaze` on request, `text` and `date` never. A column without it always stays.
- **Type** is text, whole (number) or number, with the unit that ends the column's name.
"""
_TYPES = {str: "text", int: "whole", float: "number"}
_EVENTS = """
## Events

`events.csv` has a row for each event. `vrcomfort anonymise` and `vrcomfort export --format bids`
leave out details that may tell who a participant is. They report a name that is not in this table,
and leave its detail out.

| name | meaning | detail in copies for others |
|---|---|---|
"""


def data_dictionary() -> str:
    """Return the page."""
    tables = "".join(line for table in TABLES.values() for line in _section(table))
    events = "".join(
        f"| `{name}` | {kind.meaning} | {kind.private or 'kept'} |\n"
        for name, kind in sorted(EVENTS.items())
    )
    return _HEAD.format(version=SCHEMA_VERSION) + tables + _EVENTS + events


def _section(table: type[Row]) -> Iterator[str]:
    said = (inspect.getdoc(table) or "").splitlines()[0].rstrip(".")
    place = "In the study's folder" if table in STUDY_ROWS else "In a session's folder"
    some = ", where it has rows" if table in OPTIONAL_ROWS else ""
    kept = f" The file is kept with {_traits(table.NEEDS)}." if table.NEEDS else ""
    yield f"\n## {table.FILE}\n\n{said}. {place}{some}.{kept}\n\n"
    yield "| column | type | meaning | blank | since | kept with |\n|---|---|---|---|---|---|\n"
    yield from map(_line, (*declared(table), *table.FURTHER))


def _line(column: Column) -> str:
    kind = ", ".join(filter(None, (_TYPES[column.type], column.unit)))
    since = str(column.since) if column.since > 1 else ""
    cells = (f"`{column.name}`", kind, column.meaning, column.blank, since, _traits(column.needs))
    return f"| {' | '.join(cells)} |\n".replace("|  ", "| ")


def _traits(needs: Needs) -> str:
    return " and ".join(sorted(needs, reverse=True))
