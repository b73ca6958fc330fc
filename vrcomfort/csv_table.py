"""Reads CSV files as text, and says exactly where one is wrong."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from vrcomfort.errors import InputError

BYTE_ORDER_MARK = b"\xef\xbb\xbf"
UTF_16 = (b"\xff\xfe", b"\xfe\xff")


@dataclass(frozen=True)
class CsvTable:
    """Text cells of a table, with the line of its file that each row ends on.

    Parameters
    ----------
    header
        Column names, without spaces around them; empty where there is no whole header row.
    rows
        One list of cells per row, all as long as the header; blank is missing.
    lines
        The 1-based line of each row.
    warnings
        What was left out, one sentence each.
    """

    file: Path
    header: tuple[str, ...]
    rows: tuple[list[str], ...]
    lines: tuple[int, ...]
    warnings: tuple[str, ...] = ()

    @classmethod
    def read(cls, path: str | Path, *, appended: bool = False) -> Self:
        """Read a table: UTF-8, commas, a header row (whose names may have spaces between them).

        Parameters
        ----------
        appended
            Rows were added one by one, each with its line end, by a program that may have been
            killed. So a last row without one was cut short, even where all of its columns seem to
            be there: it is left out and reported, never guessed. NUL bytes at the end, which a
            power cut leaves, are such a row.

        Raises
        ------
        InputError
            If the file cannot be read, is no such table, or a row is of another width.
        """
        file = Path(path)
        content = _content(file)
        whole, line_end, cut = content.rpartition(b"\n") if appended else (content, b"", b"")
        if b"\0" in whole:
            raise InputError("this is not a text file; a CSV table is needed", file=file)
        records = _records(file, whole + line_end)
        last = content.count(b"\n") + 1
        if not records:
            return cls(file, (), (), (), _half(file, last, "header") if cut else ())
        header = _header(file, records)
        del records[0]
        if appended and not cut and records and len(records[-1][1]) < len(header):
            cut, (last, _) = b"cells", records.pop()
        for line, cells in records:
            if len(cells) != len(header):
                raise InputError(_other_width(cells, header), file=file, line=line)
        rows, lines = tuple(cells for _, cells in records), tuple(line for line, _ in records)
        return cls(file, header, rows, lines, _half(file, last, "last row") if cut else ())

    def dicts(self) -> Iterator[dict[str, str]]:
        """Yield each row as column → text."""
        return (dict(zip(self.header, cells, strict=True)) for cells in self.rows)

    def require(self, columns: Sequence[str]) -> None:
        """Raise InputError if one of the columns is missing."""
        missing = [name for name in columns if name not in self.header]
        if missing:
            others = f" (and {', '.join(missing[1:])})" if missing[1:] else ""
            message = f"the column {missing[0]!r} is missing{others}; the header row needs it"
            raise self.fault(message, 1, missing[0])

    def require_numbers(self, columns: Sequence[str]) -> None:
        """Raise InputError at the first cell of these columns that is no number, nor blank."""
        for line, row in zip(self.lines, self.dicts(), strict=True):
            for column in columns:
                cell = row.get(column, "").strip()
                if cell and not _is_number(cell):
                    message = f"{cell!r} is not a number; write digits, with a decimal point"
                    raise self.fault(message, line, column)

    def fault(self, message: str, line: int, column: str | None = None) -> InputError:
        """Return the error of a row, or of one cell."""
        return InputError(message, file=self.file, line=line, column=column)


def plain_digits(cell: str) -> str:
    """Return the text of a number without spaces around it.

    Raises
    ------
    ValueError
        If it has what Python takes for digits and tables do not: ``1_000``, other scripts' digits.
    """
    text = cell.strip()
    if "_" in text or not text.isascii():
        raise ValueError(f"{text!r} is not written in plain digits")
    return text


def _is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(plain_digits(cell)))
    except ValueError:
        return False


def _content(file: Path) -> bytes:
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        raise InputError("there is no such file", file=file) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=file) from None
    if content.startswith(UTF_16):
        raise InputError("this file is UTF-16; save it as CSV in UTF-8", file=file, line=1)
    content = content.removeprefix(BYTE_ORDER_MARK)
    return content if b"\n" in content else content.replace(b"\r", b"\n")


def _records(file: Path, content: bytes) -> list[tuple[int, list[str]]]:
    """Return the rows that hold anything."""
    try:
        reader = csv.reader(io.StringIO(content.decode("utf-8"), newline=""))
        return [(reader.line_num, cells) for cells in reader if any(map(str.strip, cells))]
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        message = "this line is not UTF-8; save the file as CSV in UTF-8"
        raise InputError(message, file=file, line=line) from None
    except csv.Error as error:
        raise InputError(f"not a CSV table: {error}", file=file, line=reader.line_num) from None


def _header(file: Path, records: list[tuple[int, list[str]]]) -> tuple[str, ...]:
    line, cells = records[0]
    if len(cells) == 1:
        for sign, name in ((";", "`;`"), ("\t", "tabs")):
            if sign in cells[0]:
                message = f"the columns are separated by {name}; save it with commas"
                raise InputError(message, file=file, line=line)
        words, rows = cells[0].split(), records[1:]
        cells = words if not rows or len(words) == len(rows[0][1]) else cells
    header = tuple(map(str.strip, cells))
    twice = {name for name in header if name and header.count(name) > 1}
    if twice:
        message = f"column {min(twice)!r} appears twice; keep one"
        raise InputError(message, file=file, line=line, column=min(twice))
    return header


def _other_width(cells: list[str], header: Sequence[str]) -> str:
    widths = f"this row has {len(cells)} cells, the header has {len(header)}"
    if len(cells) < len(header):
        return f"{widths}; fill it up, or remove it"
    return f"{widths}; decimals need a point, and a text with a comma needs quotes"


def _half(file: Path, line: int, what: str) -> tuple[str, ...]:
    return (f"{file}, line {line}: the {what} is half-written and was left out",)
