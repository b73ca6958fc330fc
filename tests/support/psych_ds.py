"""The rules of Psych-DS' published schema 1.5.1 that are errors, under its own codes.

Written from the schema's words: a dataset is looked at without any part of the exporter.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

NAME = re.compile(r"([a-z]+-[a-zA-Z0-9]+)(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv")
KEYWORDS = {
    "study", "site", "subject", "session", "task", "condition", "trial", "stimulus", "description",
}  # fmt: skip
CODES = {
    "MISSING_DATASET_DESCRIPTION", "MISSING_DATA_DIRECTORY", "MISSING_DATAFILE",
    "JSON_INVALID", "JSON_ENCODING_ERROR", "JSON_KEY_REQUIRED", "INVALID_JSONLD_FORMATTING",
    "MISSING_DATASET_TYPE", "INCORRECT_DATASET_TYPE",
    "FILENAME_KEYWORD_FORMATTING_ERROR", "FILENAME_UNOFFICIAL_KEYWORD_ERROR", "EXTENSION_MISMATCH",
    "CSV_HEADER_MISSING", "CSV_FORMATTING_ERROR", "CSV_HEADER_LENGTH_MISMATCH",
    "ROWID_VALUES_NOT_UNIQUE", "CSV_COLUMN_MISSING_FROM_METADATA",
}  # fmt: skip
"""What `errors` finds: the schema's errors but for FILE_NOT_READ, which is the machine's, and two
that say others in general (MISSING_REQUIRED_ELEMENT, INVALID_JSON_FORMATTING)."""


def errors(dataset: Path) -> set[str]:
    """Return the codes of all errors of a dataset without metadata beside its tables."""
    return set(_errors(dataset))


def _errors(dataset: Path) -> Iterator[str]:
    file, data = dataset / "dataset_description.json", dataset / "data"
    if not file.exists():
        yield "MISSING_DATASET_DESCRIPTION"
        return
    described = _json(file)
    if isinstance(described, str):
        yield described
        return
    yield from _of_metadata(described)
    if not data.is_dir():
        yield "MISSING_DATA_DIRECTORY"
        return
    tables = [each for each in data.rglob("*_data.*") if each.is_file()]
    if not any(each.suffix == ".csv" for each in tables):
        yield "MISSING_DATAFILE"
    known = [each.get("name") for each in described.get("variableMeasured") or ()]
    for table in tables:
        if table.suffix not in {".csv", ".json"}:
            yield "EXTENSION_MISMATCH"
        elif table.suffix == ".csv":
            yield from _of_name(table.name)
            yield from _of_table(table, known)


def _json(file: Path) -> dict[str, Any] | str:
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except UnicodeDecodeError:
        return "JSON_ENCODING_ERROR"
    except ValueError:
        return "JSON_INVALID"
    return content if isinstance(content, dict) else "JSON_INVALID"


def _of_metadata(described: dict[str, Any]) -> Iterator[str]:
    if described.get("@context") not in {"https://schema.org/", "http://schema.org/"}:
        yield "INVALID_JSONLD_FORMATTING"
    if "@type" not in described:
        yield "MISSING_DATASET_TYPE"
    elif described["@type"] != "Dataset":
        yield "INCORRECT_DATASET_TYPE"
    if not all(described.get(key) for key in ("name", "description", "variableMeasured")):
        yield "JSON_KEY_REQUIRED"


def _of_name(name: str) -> Iterator[str]:
    if not NAME.fullmatch(name):
        yield "FILENAME_KEYWORD_FORMATTING_ERROR"
    elif not {part.partition("-")[0] for part in name.split("_")[:-1]} <= KEYWORDS:
        yield "FILENAME_UNOFFICIAL_KEYWORD_ERROR"


def _of_table(file: Path, known: list[Any]) -> Iterator[str]:
    try:
        with file.open(encoding="utf-8", newline="") as stream:
            rows = list(csv.reader(stream, strict=True))
    except (csv.Error, UnicodeDecodeError):
        yield "CSV_FORMATTING_ERROR"
        return
    if not rows or not any(rows[0]):
        yield "CSV_HEADER_MISSING"
        return
    header, *rest = rows
    if any(len(row) != len(header) for row in rest):
        yield "CSV_HEADER_LENGTH_MISMATCH"
        return
    if "row_id" in header:
        ids = [row[header.index("row_id")] for row in rest]
        if len(ids) != len(set(ids)):
            yield "ROWID_VALUES_NOT_UNIQUE"
    if not set(header) <= set(known):
        yield "CSV_COLUMN_MISSING_FROM_METADATA"
