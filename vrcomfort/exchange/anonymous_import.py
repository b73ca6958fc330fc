"""Writes an import without the identity of its participants; see `vrcomfort.exchange.anonymising`.

The mapping and the names and checksums of the imported files are left out: they have the names that
the lab gave, and tell which files to look for.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vrcomfort import __version__
from vrcomfort.csv_table import CsvTable
from vrcomfort.exchange.imports import IMPORT, TABLES, Import
from vrcomfort.json_text import json_of
from vrcomfort.records.checksums import replace_listed
from vrcomfort.records.disk import Access
from vrcomfort.records.rows import Needs, csv_line
from vrcomfort.records.schema import SCHEMA_VERSION, SharedFile, traits_text
from vrcomfort.records.study import DESCRIPTION

_BLANK = ("enrolled_at", "note")


def write_anonymous(
    source: Import, out: Path, names: Mapping[str, str], kept: Needs, access: Access
) -> dict[str, Any]:
    """Write the tables of an import with new names; return the copy's record.

    Parameters
    ----------
    names
        Old name → new name.
    kept
        Traits that the copy keeps.

    Raises
    ------
    InputError
        If a table is damaged, or the disk refuses.
    """
    description = source.description
    replace_listed(out / DESCRIPTION, json_of(description) + "\n", access)
    known = source.covariates()
    columns: dict[str, dict[str, str]] = {}
    blanked: dict[str, list[str]] = {}
    for row_type in TABLES:
        table = source.table(row_type)
        if not table.header:
            continue
        shared = SharedFile.of(row_type)
        blanks = {*shared.blank(kept), *_BLANK}
        replace_listed(out / row_type.FILE, _changed(table, names, blanks), access)
        told = {name: traits_text(needs) or "none" for name, needs in shared.stays(kept).items()}
        classes = {**dict.fromkeys(known, "covariate"), **told}
        columns[row_type.FILE] = {
            name: classes.get(name, "none") for name in table.header if name not in blanks
        }
        blanked[row_type.FILE] = [name for name in table.header if name in blanks]
    provenance = {
        "schema_version": SCHEMA_VERSION, "vrcomfort": __version__,
        "notes": ["anonymous copy of an import"],
    }  # fmt: skip
    replace_listed(out / IMPORT, json_of(provenance) + "\n", access)
    people = source.people if known else []
    groups = Counter(tuple(row.get(name, "") for name in known) for row in people)
    return {
        "columns_blank": {file: names for file, names in blanked.items() if names},
        "events_not_known": [],
        "left_out": "the mapping; names and checksums of the imported files; notes and dates",
        "still_there": {
            "people_are_recognised_by": [],
            "covariates": known,
            "smallest_group_with_the_same_covariates": min(groups.values(), default=None),
            "columns": columns,
        },
    }


def _changed(table: CsvTable, names: Mapping[str, str], blanks: set[str]) -> str:
    """Return a table with new names, in their order: that of the file would tell."""
    rows = sorted(table.dicts(), key=lambda row: names[row["participant"]])
    lines = [csv_line(table.header)]
    for row in rows:
        new = dict.fromkeys(blanks, "") | {"participant": names[row["participant"]]}
        lines.append(csv_line(new.get(name, row[name]) for name in table.header))
    return "".join(lines)
