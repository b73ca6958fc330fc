"""Reads text tables of any encoding and separator, and the JSON that programs log."""

from __future__ import annotations

import ast
import codecs
import csv
import io
import json
import re
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import A_ROW, MOST_CELLS, require_few_columns
from vrcomfort.errors import InputError
from vrcomfort.files import MOST_TEXT_BYTES, open_file, read_bytes
from vrcomfort.importing.source import Grid, Reading, cell_text, one_line, require_room
from vrcomfort.json_text import parse_json, require_few_values

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "vertical bars"}
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_DECIMAL_COMMA = re.compile(r"-?\d+,\d+")
_DECIMAL_POINT = re.compile(r"-?\d+\.\d+")


def read_text_table(file: Path, reading: Reading) -> Grid:
    """Read a CSV, TSV or semicolon file.

    Raises
    ------
    InputError
        If the file cannot be read, or its text is not of the encoding that is asked for.
    """
    content = content_of(file)
    encoding = reading.encoding or encoding_of(content)
    text = decode(content, encoding, file)
    separator, text = declared(_unquoted(text))
    separator = reading.separator or separator or separator_of(text)
    rows = _rows(text, separator, file)
    decimal = reading.decimal or decimal_of(rows, separator)
    notes = []
    if reading.encoding is None and encoding not in {"utf-8", "utf-8-sig"}:
        notes.append(f"{file.name}: read as {encoding}, which its bytes look like")
    if reading.decimal is None and decimal == ",":
        notes.append(f"{file.name}: decimals are written with commas")
    found = reading._replace(encoding=encoding, separator=separator, decimal=decimal)
    kept = [(number, row) for number, row in enumerate(rows, start=1) if any(row)]
    _unpack(kept, file)
    return Grid(
        file,
        "",
        tuple(tuple(row) for _, row in kept),
        tuple(number for number, _ in kept),
        found,
        tuple(notes),
    )


def _unpack(numbered: list[tuple[int, list[str]]], file: Path) -> None:
    """Put the answers of cells such as ``{"Q0": 2, "Q1": 0}`` into columns of their own, behind.

    Programs for web experiments write a page of questions so, under the heading ``response``.
    """
    headings, *rows = [row for _, row in numbered] or [[]]
    room = _Room(file)
    for column in range(len(headings)):
        cells = [_object_in(row[column], file) if column < len(row) else {} for row in rows]
        found = [_flat(each, headings[column], room)[0] if each else {} for each in cells]
        names = list(dict.fromkeys(name for said in found for name in said))
        if names and max(map(len, rows)) <= len(headings):
            for row, said in zip(rows, found, strict=True):
                blank = [""] * (len(headings) - len(row))
                row.extend([*blank, *(said.get(name, "") for name in names)])
            headings += names
    require_few_columns(len(headings), file, "the answers in its cells")


def _object_in(cell: str, file: Path) -> dict[str, Any]:
    """Return the object that a cell holds in JSON or Python; empty for none, and Qualtrics' ids."""
    if cell[:1] != "{" or cell[-1:] != "}":
        return {}
    try:
        found = parse_json(cell, file)
    except InputError:
        try:
            found = parse_json(json.dumps(ast.literal_eval(cell)), file)
        except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError, InputError):
            return {}
    return found if isinstance(found, dict) and "ImportId" not in found else {}


def content_of(file: Path, *, first: int | None = None) -> bytes:
    """Return the content of a file, or its first bytes.

    Raises
    ------
    InputError
        If it cannot be read, or is empty.
    """
    try:
        if first is None:
            content = read_bytes(file, most=MOST_TEXT_BYTES)
        else:
            with open_file(file) as stream:
                content = stream.read(first)
    except FileNotFoundError:
        raise InputError("there is no such file", file=file) from None
    except IsADirectoryError:
        raise InputError("this is a folder; give the files in it", file=file) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=file) from None
    if not content.strip(b"\0 \t\r\n"):
        raise InputError("this file is empty", file=file)
    return content


def decode(content: bytes, encoding: str, file: Path) -> str:
    """Return the text of a file.

    Raises
    ------
    InputError
        If the encoding is none, or the bytes are not of it, with the row.
    """
    try:
        text = content.decode(encoding)
    except LookupError:
        message = f"encoding {encoding!r} is unknown; write utf-8, utf-16 or windows-1252"
        raise InputError(message, file=file) from None
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        message = f"this line is not {encoding}; give another encoding in the mapping"
        raise InputError(message, file=file, line=line) from None
    if "\0" in text:
        raise InputError("this is not a text file; save it as CSV in UTF-8", file=file)
    return text.removeprefix("\ufeff")


def encoding_of(content: bytes) -> str:
    """Return the encoding that the bytes of a text look like."""
    for mark, name in _MARKS:
        if content.startswith(mark):
            return name
    if content[1:2] == b"\0" or content[:1] == b"\0":
        return "utf-16-le" if content[1:2] == b"\0" else "utf-16-be"
    for name in ("utf-8", "windows-1252"):
        with suppress(UnicodeDecodeError):
            content.decode(name)
            return name
    return "latin-1"


def _unquoted(text: str) -> str:
    """Return rows that were quoted once more as a whole as they were before."""
    lines = text.split("\n") if text.lstrip("\ufeff").startswith('"') else []
    whole = [line.strip("\ufeff\r") for line in lines if line.strip()]
    inner = [line[1:-1] for line in whole if len(line) > 1 and line[0] == line[-1] == '"']
    again = len(inner) == len(whole) and all(
        '""' in line and '"' not in line.replace('""', "") and any(s in line for s in SEPARATORS)
        for line in inner
    )
    return "\n".join(line.replace('""', '"') for line in inner) if again and inner else text


def declared(text: str) -> tuple[str | None, str]:
    """Return the separator of a first line ``sep=;``, as Excel writes it, and the rest."""
    found = re.match(r"sep=(.)(?:\r\n?|\n)", text)
    return (found[1], "\n" + text[found.end() :]) if found else (None, text)


def separator_of(text: str) -> str:
    """Return the separator that divides most rows into the same number of cells, at least two.

    Of two that do, it is the one that divides the first row, too: decimal commas stand below
    headings without commas.
    """
    sample = text[:200_000]  # enough rows to decide; the rest of a long file costs time alone

    def merit(sign: str) -> tuple[float, bool, int]:
        try:
            rows = [
                len(row)
                for row in csv.reader(io.StringIO(sample, newline=""), delimiter=sign)
                if row
            ]
        except csv.Error:
            return 0.0, False, 0
        wide = {width: count for width, count in Counter(rows).items() if width > 1}
        if not wide:
            return 0.0, False, 0
        width = max(wide, key=lambda each: (wide[each], each))
        return round(wide[width] / len(rows), 1), rows[0] == width, width

    best = max(SEPARATORS, key=merit)
    return best if merit(best)[-1] else ","


def _rows(text: str, separator: str, file: Path) -> list[list[str]]:
    if len(separator) != 1:
        raise InputError(f"separator {separator!r} is not one character", file=file)
    if "\n" not in text:  # old exports of Macintosh programs end lines with a carriage return
        text = text.replace("\r", "\n")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    rows: list[list[str]] = []
    cells = 0
    try:
        for row in reader:
            require_few_columns(len(row), file, f"row {len(rows) + 1}")
            cells += len(row) + A_ROW
            if cells > MOST_CELLS:
                message = f"this table has more than {MOST_CELLS:,} cells up to here"
                message = f"{message}, a row counting as {A_ROW} more; split it"
                raise InputError(message, file=file, line=reader.line_num)
            rows.append([cell if cell.isalnum() else one_line(cell) for cell in row])
    except csv.Error as error:
        message = f"not a table: {error}"
        raise InputError(message, file=file, line=reader.line_num) from None
    return rows


def decimal_of(rows: list[list[str]], separator: str) -> str:
    """Return the decimal sign that most numbers of a table have."""
    if separator == ",":
        return "."
    cells = [cell for row in rows for cell in row if cell]
    with_comma = sum(_DECIMAL_COMMA.fullmatch(cell) is not None for cell in cells)
    with_point = sum(_DECIMAL_POINT.fullmatch(cell) is not None for cell in cells)
    return "," if with_comma > with_point else "."  # the majority: both signs also group thousands


_ADVICE = "mend it there, or export it again"
KEY = "key"
"""The column of the names under which records stand, where an object holds them."""


def read_json_table(file: Path, reading: Reading) -> Grid:
    """Read a list of records, an object of columns, records by name, or one record a line.

    What is nested stands under ``outer.inner``; a list of records inside a record becomes a row
    each, with what stands outside repeated. Rows are numbered as they are made, from 1.

    Raises
    ------
    InputError
        If it is no JSON, or holds no records.
    """
    content = content_of(file)
    encoding = reading.encoding or encoding_of(content)
    records = list(_records(_parsed(decode(content, encoding, file), file), _Room(file)))
    headings = list(dict.fromkeys(name for record in records for name in record))
    if not headings:
        message = "no records were found in this JSON; a list of objects is needed"
        raise InputError(message, file=file)
    require_few_columns(len(headings), file, "the records")
    require_room(len(records), len(headings), file, f"{len(headings):,} names of columns")
    rows = [tuple(record.get(name, "") for name in headings) for record in records]
    return Grid(
        file,
        "",
        (tuple(headings), *rows),
        tuple(range(len(rows) + 1)),
        reading._replace(encoding=encoding, decimal=reading.decimal or "."),
        named=True,
    )


class _Room:
    """Counts the cells of flattened records; a value outside a list is in each of its rows."""

    def __init__(self, file: Path) -> None:
        self._file, self._left = file, MOST_CELLS

    def spend(self, cells: int, names: int = 0) -> None:
        """Count cells, and the characters of a column's name as some more.

        Raises
        ------
        InputError
            If they are more than a table of answers has.
        """
        self._left -= cells + names // 100
        if self._left < 0:
            message = f"the records of this JSON have more than {MOST_CELLS:,} cells"
            raise InputError(f"{message}; delete what is no data", file=self._file)


def _parsed(text: str, file: Path) -> Any:
    require_few_values(text, file)
    try:
        return parse_json(text, file, advice=_ADVICE)
    except InputError as error:
        lines = ((n, each) for n, each in enumerate(text.split("\n"), start=1) if each.strip())
        require_few_values(text, file, marks="[{,\n")
        try:
            found = [_record(next(lines), file)]
        except (StopIteration, InputError):
            raise error from None
        return found + [_record(each, file) for each in lines]


def _record(numbered: tuple[int, str], file: Path) -> Any:
    line, text = numbered
    return parse_json(text, file, advice=_ADVICE, line=line)


def _records(content: Any, room: _Room) -> Iterator[dict[str, str]]:
    columns = _columns(content)
    if columns is not None:
        content = columns
    elif isinstance(content, dict) and _holds_records(content):
        content = [
            {KEY: name, **each}
            for name, found in content.items()
            for each in (found if isinstance(found, list) else [found])
        ]
    for record in content if isinstance(content, list) else [content]:
        yield from _flat(record, "", room)


def _columns(content: Any) -> list[dict[str, Any]] | None:
    """Return the records of an object of columns: lists of the same length, or as pandas writes."""
    if not isinstance(content, dict) or not content:
        return None
    values = list(content.values())
    if all(isinstance(each, list) for each in values):
        alike = len({len(each) for each in values}) == 1 and len(values) > 1
        plain = all(not isinstance(cell, dict | list) for each in values for cell in each)
        return (
            [dict(zip(content, row, strict=True)) for row in zip(*values, strict=True)]
            if (alike and plain)
            else None
        )
    if all(isinstance(each, dict) and each and all(map(str.isdigit, each)) for each in values):
        rows = list(dict.fromkeys(row for each in values for row in each))
        return [{name: each.get(row) for name, each in content.items()} for row in rows]
    return None


def _holds_records(content: dict[str, Any]) -> bool:
    """Return whether an object has one record (or list of records) under each of its names."""
    values = [each if isinstance(each, list) else [each] for each in content.values()]
    if len(values) < 2 or not all(isinstance(e, dict) for each in values for e in each):
        return False
    keys = [set(e) for each in values for e in each]
    counts = Counter(name for each in keys for name in each)
    usual = {name for name, count in counts.items() if count * 2 > len(keys)}
    return bool(usual) and all(len(each & usual) * 2 >= len(each | usual) for each in keys)


def _flat(value: Any, path: str, room: _Room) -> list[dict[str, str]]:
    """Return the rows of a value: one, or one for each record of the lists in it."""
    room.spend(1, len(path))
    if not isinstance(value, dict | list):
        return [{path or "value": cell_text(value)}]
    if isinstance(value, list):
        if any(isinstance(each, dict) for each in value):
            return [row for each in value for row in _flat(each, path, room)]
        room.spend(len(value), len(value) * len(path))
        return [{f"{path}.{place}": cell_text(each) for place, each in enumerate(value, start=1)}]
    outside: dict[str, str] = {}
    inside: list[dict[str, str]] = []
    for name, each in value.items():
        rows = _flat(each, f"{path}.{name}" if path else name, room)
        is_list = isinstance(each, list) and any(isinstance(e, dict) for e in each)
        if is_list or len(rows) > 1:
            inside += rows
        else:
            outside |= rows[0] if rows else {}
    room.spend(len(outside) * len(inside))
    return [{**outside, **row} for row in inside] or [outside]
