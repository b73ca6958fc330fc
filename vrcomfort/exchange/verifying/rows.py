"""Reads the rows of a session's file; what is no row is a finding, and the others are read."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying.findings import Verified
from vrcomfort.records.rows import Row
from vrcomfort.records.schema import OPTIONAL_ROWS, SCHEMA_VERSION, SESSION_ROWS, later_columns
from vrcomfort.records.tables import RecordedRow, read_rows


def note_version(folder: Path, version: int, found: Verified) -> None:
    """Say of a session of an older schema version which columns it is without."""
    files = (each.FILE for each in (*SESSION_ROWS, *OPTIONAL_ROWS))
    later = later_columns(version, [name for name in files if (folder / name).exists()])
    if later:
        named = "; ".join(f"{name}: {', '.join(columns)}" for name, columns in later.items())
        message = f"recorded in schema version {version} (now {SCHEMA_VERSION}), without {named}"
        found.note(folder / "manifest.json", message)


def read(folder: Path, row_type: type[Row], version: int, found: Verified) -> Iterator[RecordedRow]:
    """Yield the rows of a file that can be read.

    Parameters
    ----------
    version
        Of the schema, as the manifest says: an older one has fewer columns.
    """
    file = folder / row_type.FILE
    if file.is_symlink():
        found.fault(file, "is a symbolic link; put the file itself here")
        return
    if not file.exists():
        found.fault(file, "is missing; restore it from a copy")
        return

    def told(error: InputError) -> None:
        column = "" if error.column is None else f"column {error.column}: "
        found.fault(file, f"{column}{error.message}", error.line)

    for row in read_rows(folder, row_type, version=version, told=told):
        found.counts[f"rows of {row_type.FILE}"] += 1
        yield row
