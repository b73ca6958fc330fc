"""Reads CSV files as text, and says exactly where one is wrong."""

from __future__ import annotations

import csv
import io
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path
from typing import BinaryIO, NoReturn, Self, TypeVar

from vrcomfort.errors import InputError
from vrcomfort.files import open_file

BYTE_ORDER_MARK = b"\xef\xbb\xbf"
UTF_16 = (b"\xff\xfe", b"\xfe\xff")
NOTHING = frozenset({"na", "nan", "n/a"})
MOST_COLUMNS = 16_384
"""As many as a sheet of a spreadsheet program has."""
MOST_CELLS = 10_000_000
"""Of a table that is read as a whole; they take about 1 GB."""
A_ROW = 4
"""As many cells as take the memory of a row beside its cells."""
MOST_LINE_BYTES = 2**24
LARGEST_WHOLE = 2**62
"""Fits int64, with room for a sum."""
_BLOCK = 2**15
_LONGEST_SHOWN = 40

Number = TypeVar("Number", int, float)


@dataclass(frozen=True)
class CsvTable:
    """Text cells of a table, with the line of its file that each row ends on.

    Parameters
    ----------
    header
        Column names, without spaces around them; empty where there is no whole header row.
    rows
        The cells of each row, as many as the header has; blank is missing.
    lines
        The 1-based line of each row.
    warnings
        What was left out, one sentence each.
    """

    file: Path
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    warnings: tuple[str, ...] = ()

    @classmethod
    def read(cls, path: str | Path, *, appended: bool = False) -> Self:
        """Read a comma-separated UTF-8 table with a header row; its names may contain spaces.

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
        (table,) = cls.parts(path, appended=appended)
        return table

    @classmethod
    def parts(
        cls, path: str | Path, *, appended: bool = False, most_rows: int | None = None
    ) -> Iterator[Self]:
        """Read a table in parts of at most `most_rows` rows, at least one; in one without it.

        Raises
        ------
        InputError
            As `read`, when the part that is wrong is reached.
        """
        file = Path(path)
        text = _Text(file, appended=appended)
        records = text.records()
        first = list(islice(records, 2))
        if not first:
            yield cls(file, (), (), (), text.left_out("header"))
            return
        header = _header(file, first)
        rows = text.whole_rows(chain(first[1:], records), header)
        at_once = most_rows or MOST_CELLS // (len(header) + A_ROW)
        left = True
        while left:
            part = list(islice(rows, at_once))
            if most_rows is None and (beyond := next(rows, None)):
                message = f"a table of {len(header):,} columns may have {at_once:,} rows to here"
                raise InputError(f"{message}; split the file", file=file, line=beyond[0])
            lines, cells = tuple(line for line, _ in part), tuple(cells for _, cells in part)
            left = most_rows is not None and len(part) == most_rows
            yield cls(file, header, cells, lines, () if left else text.left_out("last row"))

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
                if cell and number_or_none(cell) is None:
                    message = "is not a number; write digits, with a decimal point"
                    message = f"{shortened(cell)} {message}"
                    raise self.fault(message, line, column)

    def numbers(self, column: str, *, blank: float | None = None) -> list[float]:
        """Return the numbers of a column.

        Parameters
        ----------
        blank
            Value of a blank cell; None refuses blank cells.

        Raises
        ------
        InputError
            At the first cell that is no number.
        """
        return [*self._read(column, number_or_none, blank, "a number; write digits")]

    def whole_numbers(self, column: str, *, blank: int | None = None) -> list[int]:
        """Return the whole numbers of a column, as `numbers`."""
        return [*self._read(column, whole_or_none, blank, "a whole number")]

    def _read(
        self, column: str, read: Callable[[str], Number | None], blank: Number | None, wanted: str
    ) -> Iterator[Number]:
        place = self.header.index(column)
        for line, row in zip(self.lines, self.rows, strict=True):
            value = read(row[place]) if row[place].strip() else blank
            if value is None:
                raise self.fault(f"{shortened(row[place])} is not {wanted}", line, column)
            yield value

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


def are_numbers(cells: Sequence[str]) -> bool:
    """Return whether each of many cells is empty or the text of a number, in plain digits."""
    together = "".join(cells)
    if "_" in together or not together.isascii():
        return False
    try:
        for cell in cells:
            if cell:
                float(cell)
    except ValueError:
        return False
    return True


def number_in(cell: str, *, words: bool = False) -> float | None:
    """Return the number that a cell holds; None of a blank one.

    Parameters
    ----------
    words
        The words of other programs for nothing (NA, NaN, n/a) are as good as a blank.

    Raises
    ------
    ValueError
        If it holds anything else: text, an infinite number, or what `plain_digits` refuses.
    """
    text = plain_digits(cell)
    if not text or (words and text.casefold() in NOTHING):
        return None
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text!r} is not a finite number")
    return number


def number_or_none(cell: str) -> float | None:
    """Return the number of a cell that may hold anything; None where it holds none."""
    try:
        return number_in(cell)
    except ValueError:
        return None


def whole_or_none(cell: str | None) -> int | None:
    """Return the whole number of a cell; None for other text and beyond `LARGEST_WHOLE`."""
    try:
        found = int(plain_digits(cell or ""))
    except ValueError:
        return None
    return found if abs(found) < LARGEST_WHOLE else None


def shortened(cell: str) -> str:
    """Return a cell in quotes, shortened for a message."""
    return repr(cell if len(cell) <= _LONGEST_SHOWN else f"{cell[:_LONGEST_SHOWN]}…")


class _Text:
    """The rows of a file, read line by line, and whether the last of them is a whole one."""

    def __init__(self, file: Path, *, appended: bool) -> None:
        self._file = file
        self._appended = appended
        self._cut_line = 0
        self._has_lines = _check_text(file, appended=appended)

    def records(self) -> Iterator[tuple[int, tuple[str, ...]]]:
        """Yield line and cells of the rows that hold anything."""
        with open_file(self._file) as stream:
            reader = csv.reader(self._lines(stream))
            try:
                for cells in reader:
                    if cells and (cells[0].strip() or any(map(str.strip, cells))):
                        yield reader.line_num, tuple(cells)  # no work for the garbage collector
            except csv.Error as error:
                message = f"not a CSV table: {error}"
                raise InputError(message, file=self._file, line=reader.line_num) from None

    def _lines(self, stream: BinaryIO) -> Iterator[str]:
        before = 0
        while lines := stream.readlines(_BLOCK):
            if self._appended and self._has_lines and not lines[-1].endswith(b"\n"):
                self._cut_line = before + len(lines)
                lines.pop()
            text = self._decoded(lines, before)
            if not self._has_lines:
                text = self._of_carriage_returns(text)
            alone = text.count("\r") > text.count("\r\n")
            yield from io.StringIO(text, newline="" if alone else "\n")
            before += len(lines)

    def _decoded(self, lines: list[bytes], before: int) -> str:
        """Return the text of some lines, after a number of lines already read."""
        whole = b"".join(lines)
        try:
            return str(whole.removeprefix(BYTE_ORDER_MARK) if before == 0 else whole, "utf-8")
        except UnicodeDecodeError:
            wrong = next(n for n, line in enumerate(lines, start=1) if not _is_utf8(line))
            message = "this line is not UTF-8; save the file as CSV in UTF-8"
            raise InputError(message, file=self._file, line=before + wrong) from None

    def _of_carriage_returns(self, text: str) -> str:
        """Return the text of a file that ends its lines with carriage returns alone."""
        text = text.replace("\r", "\n")
        if not self._appended or text.endswith("\n"):
            return text
        self._cut_line = text.count("\n") + 1
        return text[: text.rfind("\n") + 1]

    def whole_rows(
        self, records: Iterable[tuple[int, tuple[str, ...]]], header: Sequence[str]
    ) -> Iterator[tuple[int, tuple[str, ...]]]:
        """Yield the rows, all as long as the header; not the last of an appended file if short."""
        before: tuple[int, tuple[str, ...]] | None = None
        width = len(header)
        for record in records:
            if before is not None:
                yield before if len(before[1]) == width else self._other_width(before, header)
            before = record
        if before is None:
            return
        if self._appended and not self._cut_line and len(before[1]) < width:
            self._cut_line = before[0]
        else:
            yield before if len(before[1]) == width else self._other_width(before, header)

    def _other_width(self, record: tuple[int, tuple[str, ...]], header: Sequence[str]) -> NoReturn:
        line, cells = record
        raise InputError(_other_width(cells, header), file=self._file, line=line)

    def left_out(self, what: str) -> tuple[str, ...]:
        """Return the notices of excluded rows, once all are read."""
        return _half(self._file, self._cut_line, what) if self._cut_line else ()


def _check_text(file: Path, *, appended: bool) -> bool:
    """Return whether lines end with line feeds; raise InputError if the file cannot be text.

    A power cut can leave NUL bytes at the end of a file that is appended to: a half-written row.
    """
    has_lines = cut = False
    not_text = InputError("this is not a text file; a CSV table is needed", file=file)
    try:
        with open_file(file) as stream:
            if stream.read(2) in UTF_16:
                message = "this file is UTF-16; save it as CSV in UTF-8"
                raise InputError(message, file=file, line=1)
            stream.seek(0)
            in_line = 0
            while block := stream.read(_BLOCK):
                end = block.rfind(b"\n")
                in_line = len(block) - end - 1 if end >= 0 else in_line + len(block)
                if in_line > MOST_LINE_BYTES:
                    message = f"a line has more than {MOST_LINE_BYTES:,} bytes: this is not a table"
                    raise InputError(message, file=file)
                first = 0 if cut else block.find(b"\0")
                cut = first >= 0
                if cut and block[first:].strip(b"\0"):
                    raise not_text
                has_lines = has_lines or b"\n" in block
    except FileNotFoundError:
        raise InputError("there is no such file", file=file) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=file) from None
    if cut and not (appended and has_lines):
        raise not_text
    return has_lines


def _is_utf8(line: bytes) -> bool:
    try:
        line.decode()
    except UnicodeDecodeError:
        return False
    return True


def _header(file: Path, records: list[tuple[int, tuple[str, ...]]]) -> tuple[str, ...]:
    line, cells = records[0][0], list(records[0][1])
    if len(cells) == 1:
        for sign, name in ((";", "`;`"), ("\t", "tabs")):
            if sign in cells[0]:
                message = f"the columns are separated by {name}; save it with commas"
                raise InputError(message, file=file, line=line)
        words, rows = cells[0].split(), records[1:]
        cells = words if not rows or len(words) == len(rows[0][1]) else cells
    require_few_columns(len(cells), file, "this row")
    header = tuple(map(str.strip, cells))
    twice = {name for name, count in Counter(header).items() if name and count > 1}
    if twice:
        message = f"column {min(twice)!r} appears twice; keep one"
        raise InputError(message, file=file, line=line, column=min(twice))
    return header


def require_few_columns(width: int, file: Path, what: str) -> None:
    """Raise `InputError` if there are more columns than `MOST_COLUMNS`."""
    if width > MOST_COLUMNS:
        message = f"{what} has {width:,} columns, and a table has at most {MOST_COLUMNS:,}"
        raise InputError(f"{message}; is the separator right?", file=file)


def _other_width(cells: Sequence[str], header: Sequence[str]) -> str:
    widths = f"this row has {len(cells)} cells, the header has {len(header)}"
    if len(cells) < len(header):
        return f"{widths}; fill it up, or remove it"
    return f"{widths}; decimals need a point, and a text with a comma needs quotes"


def _half(file: Path, line: int, what: str) -> tuple[str, ...]:
    return (f"{file}, line {line}: the {what} is half-written and was left out",)
