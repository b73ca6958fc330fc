"""Reads CSV files that a crash may have cut short."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

from vrcomfort.errors import InputError


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

    Every row ends with a line end, so a last line without one was cut short, even where all of
    its columns seem to be there: its last number may lack digits.

    Raises
    ------
    InputError
        If the file cannot be read, or a row before the last is broken, with its line.
    """
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror}", file=file) from error
    whole, line_end, cut = content.rpartition(b"\n")
    records = _records(file, (whole + line_end).removeprefix(b"\xef\xbb\xbf"))
    last_line = content.count(b"\n") + bool(cut)
    broken = bool(cut)
    if not records:
        return Rows((), (), (), _warn(file, last_line, "header") if broken else ())
    header = tuple(records[0][1])
    if len(header) == 1 and header[0].count(";") > 1:
        raise InputError("the columns are separated by `;`; save it with commas", file=file, line=1)
    if len(records) > 1 and len(records[-1][1]) != len(header) and not broken:
        broken, last_line = True, records.pop()[0]
    for line, cells in records[1:]:
        if len(cells) != len(header):
            message = f"this row has {len(cells)} cells, the header has {len(header)}"
            raise InputError(message, file=file, line=line)
    return Rows(
        header,
        tuple(dict(zip(header, cells, strict=True)) for _, cells in records[1:]),
        tuple(line for line, _ in records[1:]),
        _warn(file, last_line, "last row") if broken else (),
    )


def _records(file: Path, content: bytes) -> list[tuple[int, list[str]]]:
    try:
        reader = csv.reader(io.StringIO(content.decode("utf-8"), newline=""))
        return [(reader.line_num, cells) for cells in reader if cells]
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError("this line is not UTF-8", file=file, line=line) from error
    except csv.Error as error:
        raise InputError(f"this is not a CSV file: {error}", file=file) from error


def _warn(file: Path, line: int, what: str) -> tuple[str, ...]:
    return (f"{file}, line {line}: the {what} is half-written and was left out",)
