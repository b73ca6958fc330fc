"""Reads rows of a session as it is: of an older version, or cut off in the middle of a row."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from vrcomfort.records import Row
from vrcomfort.records.recorded_rows import RecordedRow, read_rows


def rows_of(
    folder: Path, row_type: type[Row], manifest: Mapping[str, Any]
) -> Iterator[RecordedRow]:
    """Yield the rows of a file, none where the session has not got it.

    Raises
    ------
    InputError
        If the file is damaged.
    """
    if (folder / row_type.FILE).exists():
        version = manifest.get("schema_version", 1)
        yield from read_rows(folder, row_type, version=version, cut=True)
