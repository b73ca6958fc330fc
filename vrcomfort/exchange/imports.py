"""The tables of an import, for exports and anonymous copies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import CsvTable
from vrcomfort.records.exposure_rows import RatingRow
from vrcomfort.records.json_file import DescribedShape, ImportShape, read_json
from vrcomfort.records.rows import Row
from vrcomfort.records.session_rows import ParticipantRow, QuestionnaireRow
from vrcomfort.records.study import DESCRIPTION
from vrcomfort.records.tables import read_table

IMPORT = "import.json"
TABLES: tuple[type[Row], ...] = (ParticipantRow, QuestionnaireRow, RatingRow)
_OF_A_ROW = ("session", "period", "block", "trial", "condition", "scene")


def is_import(study: Path) -> bool:
    """Return whether a folder holds an import, and no sessions that vrcomfort recorded."""
    return (study / IMPORT).is_file()


@dataclass(frozen=True)
class Import:
    """An import: answers and ratings of participants of other software's studies."""

    folder: Path

    @property
    def description(self) -> dict[str, Any]:
        """Return the content of its ``dataset_description.json``."""
        return read_json(self.folder / DESCRIPTION, DescribedShape, "study description")

    @property
    def provenance(self) -> dict[str, Any]:
        """Return the content of its ``import.json``."""
        return read_json(self.folder / IMPORT, ImportShape, "note of where an import came from")

    @property
    def name(self) -> str:
        """Return the study's name."""
        return str(self.description.get("name") or self.folder.resolve().name)

    def table(self, row_type: type[Row]) -> CsvTable:
        """Return one of its tables as text, empty where it has none.

        Raises
        ------
        InputError
            If it is damaged.
        """
        file = self.folder / row_type.FILE
        if not file.exists():
            return CsvTable(file, (), (), ())
        table = read_table(file, appended=False)
        table.require(("participant",))
        return table

    @property
    def people(self) -> list[dict[str, str]]:
        """Return the rows of its participants."""
        return list(self.table(ParticipantRow).dicts())

    @property
    def names(self) -> list[str]:
        """Return the names of all participants, also of those with answers alone."""
        rows = (row for kind in TABLES for row in self.table(kind).dicts())
        return list(dict.fromkeys(row["participant"] for row in rows))

    def covariates(self) -> list[str]:
        """Return the columns of participants that the lab's files brought."""
        own = ParticipantRow.columns()
        return [each for each in self.table(ParticipantRow).header if each not in own]


def labels_of(names: list[str]) -> dict[str, str]:
    """Return name → label of letters and digits alone, which BIDS wants; each another."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        plain = "".join(each for each in name if each.isascii() and each.isalnum()) or "x"
        label = next(
            each
            for number in range(len(names) + 1)
            if (each := f"{plain}{number or ''}").lower() not in taken
        )
        found[name] = label
        taken.add(label.lower())
    return found


def place_of(row: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield the columns that identify a row of a participant, with their values."""
    for column in _OF_A_ROW:
        if row.get(column):
            yield column, row[column]
