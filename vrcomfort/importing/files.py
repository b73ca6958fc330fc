"""Reads a file of any kind into tables."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.importing.headings import as_table
from vrcomfort.importing.json_files import read_json_table
from vrcomfort.importing.source import Grid, Reading, SourceTable
from vrcomfort.importing.text_files import read_text_table
from vrcomfort.importing.workbooks import read_workbook

_UNREAD = {
    ".xls": "Excel's former format; save it as .xlsx",
    ".xlsb": "a binary workbook; save it as .xlsx",
    ".ods": "an OpenDocument table; save it as .xlsx or CSV",
    ".sav": "an SPSS file; export it as CSV with value labels or codes",
    ".dta": "a Stata file; export it as CSV",
    ".rds": "an R object; write it with write.csv",
    ".rdata": "R objects; write them with write.csv",
    ".parquet": "a Parquet file; write it as CSV",
    ".zip": "an archive; unpack it first",
    ".pdf": "a PDF; export the answers as CSV",
    ".html": "a web page; export the answers as CSV",
}


def read_grids(file: Path, reading: Reading) -> list[Grid]:
    """Read a file without telling headings from data: one grid, or one for each sheet.

    Raises
    ------
    InputError
        If the file cannot be read, or is of a kind that is not.
    """
    ending = file.suffix.lower()
    if ending in _UNREAD:
        raise InputError(f"this is {_UNREAD[ending]}", file=file)
    if ending in {".xlsx", ".xlsm"}:
        return read_workbook(file, reading)
    if ending in {".json", ".jsonl", ".ndjson"}:
        return [read_json_table(file, reading)]
    return [read_text_table(file, reading)]


def read_tables(file: Path, reading: Reading | None = None) -> list[SourceTable]:
    """Read the tables of a file.

    Raises
    ------
    InputError
        If the file, or a table of it, cannot be read; with the row.
    """
    return [as_table(grid) for grid in read_grids(file, reading or Reading())]
