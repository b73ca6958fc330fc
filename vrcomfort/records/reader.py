"""Reads CSV files that a crash may have cut short."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vrcomfort.csv_table import CsvTable


@dataclass(frozen=True)
class Rows:
    """The whole rows of a file.

    Parameters
    ----------
    rows
        column → text; blank is missing.
    lines
        The line of the file at which each row ends, for messages.
    warnings
        What was left out, one sentence each.
    """

    columns: tuple[str, ...]
    rows: tuple[dict[str, str], ...]
    lines: tuple[int, ...]
    warnings: tuple[str, ...]


def read_rows(file: Path) -> Rows:
    """Read a CSV file; a half-written last row is reported and left out.

    Raises
    ------
    InputError
        If the file cannot be read, or a row before the last is broken, with its line.
    """
    table = CsvTable.read(file, appended=True)
    return Rows(table.header, tuple(table.dicts()), table.lines, table.warnings)
