"""Reads the sheets of Excel workbooks as text.

A workbook is a ZIP archive of XML, in which a few bytes can stand for gigabytes. So its XML is
checked before it is parsed, and cells are counted before they are made.
"""

from __future__ import annotations

import io
import time
import warnings
import zipfile
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import IO, Any
from xml.etree.ElementTree import Element, iterparse
from xml.parsers import expat

from vrcomfort.csv_table import MOST_CELLS, require_few_columns
from vrcomfort.errors import InputError
from vrcomfort.importing.source import LONGEST_TEXT, Grid, Reading, cell_text
from vrcomfort.importing.text_files import content_of

MOST_BYTES = 2**28
"""Of XML, unpacked."""
MOST_CELLS_READ = 2_000_000
"""Rows, cells and shared texts of all sheets, blank ones as well: each takes some 10 µs."""
MOST_ELEMENTS = 8_000_000
"""Of XML: a cell is two or three."""
MOST_OTHERS = 200_000
"""Elements of XML that are no part of cells: styles, merged ranges, links and the like."""
MOST_S = 60.0
"""Of processor time, for one workbook: three times that of all cells at 10 µs each."""
_ELEMENTS_AT_ONCE = 4096
"""Between two looks at the clock."""
_READ = {"row": 1, "c": 1, "si": 1, "is": 1, "r": 4}
"""As many cells as take the time of an element; of `r`, a part of a text with its own style."""
_INSIDE = frozenset({"v", "t", "f"})
_A_SHEET = 200
"""As many of them as take the time of a sheet."""

_LOOKED_AT = 64
"""Bytes of a file in which XML has its first sign."""
_SAVE_AGAIN = "open it in a spreadsheet program, and save it again"
_NO_WORKBOOK = "this is not a workbook that can be read; save it as .xlsx or CSV"


class _Clock:
    """Stops the reading of a workbook that takes too long."""

    def __init__(self, file: Path, most_s: float) -> None:
        self._file, self._most_s, self._begun_s = file, most_s, time.process_time()

    def check(self) -> None:
        """Look at the clock.

        Raises
        ------
        InputError
            If the time is over.
        """
        if time.process_time() - self._begun_s > self._most_s:
            message = f"reading this workbook takes more than {self._most_s:g} s"
            hint = "delete what is no data, or save its sheets as CSV"
            raise InputError(f"{message}; {hint}", file=self._file)


def check_archive(content: bytes, file: Path, clock: _Clock) -> None:
    """Check that the XML of a workbook is well-formed and within the limits.

    Document types are refused: no spreadsheet program writes one, and their entities expand.

    Raises
    ------
    InputError
        With the part of the archive, and the line and column in it.
    """
    with one_sentence(file, "this workbook"):
        archive = _opened(content, file)
        parts = [each for each in archive.infolist() if _is_xml(archive, each)]
        _require_room(sum(each.file_size for each in parts), MOST_BYTES, "bytes", file)
    count = _Elements(file, clock).count

    for part in parts:
        name = f"{part.filename} of this workbook"
        with one_sentence(file, name), archive.open(part) as stream:
            parser = expat.ParserCreate()
            parser.StartDoctypeDeclHandler = partial(_refuse_document_type, file, name)
            parser.StartElementHandler = count
            parser.ParseFile(stream)


class _Elements:
    """Counts the elements of all parts, weighted by the memory that they take."""

    def __init__(self, file: Path, clock: _Clock) -> None:
        self._file, self._all, self._read, self._others, self._in_row = file, 0, 0, 0, 0
        self._clock = clock

    def count(self, name: str, _attributes: object) -> None:
        """Count an element that begins.

        Raises
        ------
        InputError
            If there is no room for it.
        """
        name = name.rpartition(":")[2]
        self._all += 1
        if self._all % _ELEMENTS_AT_ONCE == 1:
            self._clock.check()
        if name in _READ:
            self._read += _READ[name]
            self._in_row = self._in_row + (name == "c") if name != "row" else 0
        elif name not in _INSIDE:
            self._others += _A_SHEET if name == "sheet" else 1
        _require_room(self._all, MOST_ELEMENTS, "elements", self._file)
        _require_room(self._read, MOST_CELLS_READ, "cells", self._file)
        _require_room(self._others, MOST_OTHERS, "styles and the like", self._file)
        require_few_columns(self._in_row, self._file, "a row of this workbook")


@contextmanager
def one_sentence(file: Path, what: str) -> Iterator[None]:
    """Turn any exception while a part is read into one sentence.

    zipfile and openpyxl do not validate what they read: exceptions of all types come from them.

    Raises
    ------
    InputError
        In place of any other exception.
    """
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        said = f"{type(error).__name__}: {' '.join(str(error).split())[:80]}"
        raise InputError(f"{what} is damaged ({said}); {_SAVE_AGAIN}", file=file) from error


def _refuse_document_type(file: Path, name: str, *_: object) -> None:
    message = f"{name} has a document type, as no spreadsheet program writes it"
    raise InputError(f"{message}; {_SAVE_AGAIN}", file=file)


def _opened(content: bytes, file: Path) -> zipfile.ZipFile:
    if zipfile.is_zipfile(io.BytesIO(content)):
        archive = zipfile.ZipFile(io.BytesIO(content))
        if "[Content_Types].xml" in archive.namelist():
            return archive
    raise InputError(_NO_WORKBOOK, file=file)


def _is_xml(archive: zipfile.ZipFile, part: zipfile.ZipInfo) -> bool:
    """Return whether a part begins as XML does; some programs add parts of their own."""
    with archive.open(part) as stream:
        return stream.read(_LOOKED_AT).lstrip(_BEFORE_XML).startswith(b"<")


_BEFORE_XML = b"\xef\xbb\xbf\xfe\xff\x00 \t\r\n"
"""Marks of byte order, halves of UTF-16, and spaces."""


def _require_room(found: int, most: int, what: str, file: Path) -> None:
    if found > most:
        message = f"this workbook unpacks to more than {most:,} {what}; delete what is no data"
        raise InputError(f"{message}, or save its sheets as CSV", file=file)


_ENCRYPTED = b"\xd0\xcf\x11\xe0"
"""How files of Excel's former format begin, and workbooks with a password."""
_XML = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
_ROW, _MERGED = f"{_XML}row", f"{_XML}mergeCell"
_FORMULA, _VALUE = f"{_XML}f", f"{_XML}v"


def read_workbook(file: Path, reading: Reading, *, most_s: float = MOST_S) -> list[Grid]:
    """Read every sheet that holds anything; a merged cell's text stands in all of its cells.

    Formulas are their values when the workbook was last saved.

    Parameters
    ----------
    most_s
        Processor time that it may take.

    Raises
    ------
    InputError
        If it is no workbook, is damaged, unpacks to more than `MOST_BYTES` or
        `MOST_CELLS`, takes too long, or a formula has no saved value; with sheet and row.
    """
    from openpyxl import load_workbook  # noqa: PLC0415 - slow, and for workbooks alone

    content = content_of(file)
    if content.startswith(_ENCRYPTED):
        message = "this workbook has a password, or is of Excel's former format"
        raise InputError(f"{message}; save it as .xlsx without a password", file=file)
    clock = _Clock(file, most_s)
    check_archive(content, file, clock)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # styles and such that it does not keep
        with one_sentence(file, "this workbook"):
            book = load_workbook(
                io.BytesIO(content), read_only=True, data_only=True, keep_links=False
            )
        with closing(book):
            size = _Size(file, clock)
            grids = [_grid(file, sheet, reading, size) for sheet in book.worksheets]
    found = [grid for grid in grids if grid.rows]
    if not found:
        raise InputError("this workbook is empty", file=file)
    return found


class _Size:
    """Counts the cells of all sheets, before they are made."""

    def __init__(self, file: Path, clock: _Clock) -> None:
        self._file, self._cells, self._clock = file, 0, clock

    def add(self, cells: int, sheet: str, place: str) -> None:
        """Count cells.

        Raises
        ------
        InputError
            If they are more than a table of answers has.
        """
        self._cells += cells
        self._clock.check()
        if self._cells > MOST_CELLS:
            message = f"sheet {sheet}, {place}: the workbook has more than {MOST_CELLS:,} cells"
            raise InputError(f"{message} up to here; delete what is no data", file=self._file)


def _grid(file: Path, sheet: Any, reading: Reading, size: _Size) -> Grid:
    cells: dict[int, dict[int, str]] = {}
    merged: list[tuple[int | None, int | None, int | None, int | None]] = []
    with one_sentence(file, f"sheet {sheet.title}"), sheet._get_source() as source:
        _read_sheet(file, sheet, source, cells, merged, size)
    _fill_merged(cells, merged, sheet.title, size)
    kept = dict(sorted(cells.items()))
    rows = []
    for number, row in kept.items():
        width = max(row)
        size.add(width - len(row), sheet.title, f"row {number}")
        rows.append(tuple(row.get(column, "") for column in range(1, width + 1)))
    hidden = sheet.sheet_state != "visible"
    notes = (f"{file.name}: the sheet {sheet.title} is hidden, and was read",) if hidden else ()
    found = reading._replace(decimal=reading.decimal or ".")
    return Grid(file, sheet.title, tuple(rows), tuple(kept), found, notes)


def _read_sheet(
    file: Path,
    sheet: Any,
    source: IO[bytes],
    cells: dict[int, dict[int, str]],
    merged: list[tuple[int | None, int | None, int | None, int | None]],
    size: _Size,
) -> None:
    """Read a sheet's cells and merged ranges in one pass; its stated dimension is not used."""
    from openpyxl.utils import get_column_letter, range_boundaries  # noqa: PLC0415
    from openpyxl.worksheet._reader import WorkSheetParser  # noqa: PLC0415

    book = sheet.parent
    parser = WorkSheetParser(
        source,
        sheet._shared_strings,
        data_only=True,
        epoch=book.epoch,
        date_formats=book._date_formats,
        timedelta_formats=book._timedelta_formats,
    )
    texts: dict[str, str] = {}
    in_row = False
    for event, element in iterparse(source, ("start", "end")):  # noqa: S314 - see `check_archive`
        if element.tag == _ROW:
            in_row = event == "start"
        if event == "start" or in_row:
            continue
        if element.tag == _ROW:
            place = element.get("r") or parser.row_counter + 1
            with one_sentence(file, f"sheet {sheet.title}, row {str(place)[:10]}"):
                number, row = parser.parse_row(element)
            size.add(1 + len(row), sheet.title, f"row {number}")
            for cell, said in zip(row, element, strict=True):
                place = f"sheet {sheet.title}, cell {get_column_letter(cell['column'])}{number}"
                text = _text(cell["value"], said, texts, file, place)
                if text:
                    cells.setdefault(number, {})[cell["column"]] = text
        elif element.tag == _MERGED:
            merged.append(range_boundaries(element.get("ref", "")))
        element.clear()


def _text(value: object, said: Element, known: dict[str, str], file: Path, place: str) -> str:
    """Return the text of a cell; equal texts are one object."""
    if value is None and said.find(_FORMULA) is not None and said.find(_VALUE) is None:
        message = "this formula has no saved value; open the workbook, and save it again"
        raise InputError(f"{file}, {place}: {message}")
    if not isinstance(value, str):
        return cell_text(value)
    if len(value) > LONGEST_TEXT:
        message = f"this text has {len(value):,} characters; a cell of a table has at most"
        raise InputError(f"{file}, {place}: {message} {LONGEST_TEXT:,}")
    if value not in known:
        known[value] = cell_text(value)
    return known[value]


def _fill_merged(
    cells: dict[int, dict[int, str]],
    merged: Iterable[tuple[int | None, int | None, int | None, int | None]],
    sheet: str,
    size: _Size,
) -> None:
    """Put the text of merged cells into all of them, as far as the sheet is used."""
    last_row = max(cells, default=0)
    last_column = max((column for row in cells.values() for column in row), default=0)
    for left, top, right, bottom in merged:
        if not (left and top and right and bottom) or not (text := cells.get(top, {}).get(left)):
            continue
        columns = range(left, min(right, last_column) + 1)
        rows = range(top, min(bottom, last_row) + 1)
        size.add(len(rows) * len(columns), sheet, f"the merged cells from row {top} to {bottom}")
        for row in rows:
            cells.setdefault(row, {}).update(dict.fromkeys(columns, text))
