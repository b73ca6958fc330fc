"""The schema of a study folder: its tables, its version, and its columns that copies share.

A column is declared beside the field of its row type (`vrcomfort.records.rows`), with the version
that introduced it; `SCHEMA_VERSION` follows. Older studies stay whole without it. A folder of an
older version that is continued gets it, blank.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.records.events import EVENTS
from vrcomfort.records.exposure_rows import (
    BallRow,
    DialRow,
    PracticeRow,
    RatingRow,
    TaskRow,
    TimingRow,
    TrialRow,
)
from vrcomfort.records.frame_rows import FrameRow, GazeRow, HandJointsRow, ImageRow, PartRow
from vrcomfort.records.rows import ALWAYS, Column, Needs, Row, declared
from vrcomfort.records.session_rows import (
    ClockRow,
    ConsentRow,
    EventRow,
    GazeValidationRow,
    ParticipantRow,
    QuestionnaireRow,
    ScreeningRow,
    TextRow,
)

STUDY_ROWS: tuple[type[Row], ...] = (ParticipantRow, ConsentRow)
SESSION_ROWS: tuple[type[Row], ...] = (
    TrialRow, TimingRow, QuestionnaireRow, RatingRow, FrameRow, EventRow,
)  # fmt: skip
OPTIONAL_ROWS: tuple[type[Row], ...] = (
    GazeRow, ImageRow, HandJointsRow, BallRow, PartRow, ClockRow, TaskRow, DialRow, TextRow,
    ScreeningRow,
    GazeValidationRow, PracticeRow,
)  # fmt: skip
"""Of sessions; their files appear with their first rows."""

TABLES: Mapping[str, type[Row]] = {
    each.FILE: each for each in (*STUDY_ROWS, *SESSION_ROWS, *OPTIONAL_ROWS)
}
"""File name → row type."""

SCHEMA_VERSION = max(column.since for table in TABLES.values() for column in declared(table))
"""Written into manifests and study descriptions. What has none is of version 1."""


def columns_of_version(version: int, file_name: str, columns: tuple[str, ...]) -> tuple[str, ...]:
    """Return those of a file's present `columns` that it had in an older version."""
    later = later_columns(version, [file_name]).get(file_name, [])
    return tuple(column for column in columns if column not in later)


def later_columns(version: int, files: Iterable[str]) -> dict[str, list[str]]:
    """Return file → the columns that it got after a version, of files that got any."""
    later = {
        name: [each.name for each in declared(TABLES[name]) if each.since > version]
        for name in files
        if name in TABLES
    }
    return {name: columns for name, columns in later.items() if columns}


@dataclass(frozen=True)
class SharedFile:
    """A file's place in a copy for others.

    Parameters
    ----------
    columns
        Column → the traits that have to be kept for it; it is blank otherwise. Ids and times in
        columns that stay are replaced, details of events are kept where `EVENTS` says so.
    needs
        The traits that have to be kept for the file.
    """

    columns: Mapping[str, Needs]
    needs: Needs = ALWAYS

    @classmethod
    def of(cls, table: type[Row]) -> SharedFile:
        """Return a table's place, as it is declared. Covariates of participants stay, too."""
        columns = (*declared(table), *table.FURTHER)
        return cls({each.name: each.needs for each in columns}, table.NEEDS)

    def lacking(self, kept: Needs) -> Needs:
        """Return the traits that the file is left out for; none where it stays."""
        return self.needs - kept

    def blank(self, kept: Needs) -> list[str]:
        """Return the columns that are blank in a copy with these traits."""
        return [name for name, needs in self.columns.items() if not needs <= kept]

    def stays(self, kept: Needs) -> dict[str, Needs]:
        """Return column → traits, of the columns that a copy with these traits keeps."""
        return {name: self.needs | needs for name, needs in self.columns.items() if needs <= kept}


def described(name: str, tables: Sequence[type[Row]]) -> str:
    """Return the meaning of a column that may be in several tables; empty where it is in none.

    What a blank cell means is said once for tables in which the column means the same.
    """
    named: dict[str, list[tuple[str, Column]]] = {}
    for file, column in _named(name, tables):
        named.setdefault(column.meaning, []).append((Path(file).stem, column))
    meanings = {
        full_meaning(max((column for _, column in found), key=lambda each: bool(each.blank))): [
            place for place, _ in found
        ]
        for found in named.values()
    }
    if len(meanings) == 1:
        return next(iter(meanings))
    return ". ".join(f"In {', '.join(places)}: {text}" for text, places in meanings.items())


def unit_of(name: str, tables: Sequence[type[Row]]) -> str:
    """Return the unit of a column that is in one of the tables; empty without one."""
    return next((column.unit for _, column in _named(name, tables)), "")


def _named(name: str, tables: Sequence[type[Row]]) -> Iterator[tuple[str, Column]]:
    for table in tables:
        for column in (*declared(table), *table.FURTHER):
            if column.name == name:
                yield table.FILE, column


def full_meaning(column: Column) -> str:
    """Return a column's meaning, and that of a blank cell."""
    return f"{column.meaning}; blank: {column.blank}" if column.blank else column.meaning


def check_schema_version(content: Mapping[str, Any], file: Path) -> None:
    """Refuse a file of a newer version of this program.

    Raises
    ------
    InputError
        If the version is newer.
    """
    version = content.get("schema_version", 1)
    if type(version) is int and version > SCHEMA_VERSION:
        message = f"this was written in schema version {version}, and this vrcomfort knows up to"
        raise InputError(f"{message} {SCHEMA_VERSION}; install a newer vrcomfort", file=file)


_HEAD = """\
# Data dictionary

Made from the declarations in `vrcomfort/records` (`python scripts/data_dictionary.py`), and so
complete: the tables of a study with their columns in order, and the events. How cells are written:
[CONVENTIONS.md](conventions.md#files).

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
    kept = f" The file is kept with {traits_text(table.NEEDS)}." if table.NEEDS else ""
    yield f"\n## {table.FILE}\n\n{said}. {place}{some}.{kept}\n\n"
    yield "| column | type | meaning | blank | since | kept with |\n|---|---|---|---|---|---|\n"
    yield from map(_line, (*declared(table), *table.FURTHER))


def _line(column: Column) -> str:
    kind = ", ".join(filter(None, (_TYPES[column.type], column.unit)))
    since = str(column.since) if column.since > 1 else ""
    cells = (
        f"`{column.name}`",
        kind,
        column.meaning,
        column.blank,
        since,
        traits_text(column.needs),
    )
    return f"| {' | '.join(cells)} |\n".replace("|  ", "| ")


def traits_text(needs: Needs) -> str:
    """Return the traits that a column or file tells of, joined with "and"; empty for none."""
    return " and ".join(sorted(needs, reverse=True))
