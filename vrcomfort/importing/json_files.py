"""Reads JSON that programs log: records, columns, and records inside records."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.importing.source import Grid, Reading, cell_text, require_room
from vrcomfort.importing.text_files import decode, encoding_of, read_bytes
from vrcomfort.json_text import parse_json

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
    content = read_bytes(file)
    encoding = reading.encoding or encoding_of(content)
    records = list(_records(_parsed(decode(content, encoding, file), file)))
    headings = list(dict.fromkeys(name for record in records for name in record))
    if not headings:
        message = "no records were found in this JSON; a list of objects is needed"
        raise InputError(message, file=file)
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


def _parsed(text: str, file: Path) -> Any:
    try:
        return parse_json(text, file, advice=_ADVICE)
    except InputError as error:
        lines = ((n, each) for n, each in enumerate(text.split("\n"), start=1) if each.strip())
        try:
            found = [_record(next(lines), file)]
        except (StopIteration, InputError):
            raise error from None
        return found + [_record(each, file) for each in lines]


def _record(numbered: tuple[int, str], file: Path) -> Any:
    line, text = numbered
    return parse_json(text, file, advice=_ADVICE, line=line)


def _records(content: Any) -> Iterator[dict[str, str]]:
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
        yield from _flat(record, "")


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
    return bool(keys) and all(len(each & keys[0]) * 2 > len(each | keys[0]) for each in keys)


def _flat(value: Any, path: str) -> list[dict[str, str]]:
    """Return the rows of a value: one, or one for each record of the lists in it."""
    if not isinstance(value, dict | list):
        return [{path or "value": cell_text(value)}]
    if isinstance(value, list):
        if any(isinstance(each, dict) for each in value):
            return [row for each in value for row in _flat(each, path)]
        return [{f"{path}.{place}": cell_text(each) for place, each in enumerate(value, start=1)}]
    outside: dict[str, str] = {}
    inside: list[dict[str, str]] = []
    for name, each in value.items():
        rows = _flat(each, f"{path}.{name}" if path else name)
        is_list = isinstance(each, list) and any(isinstance(e, dict) for e in each)
        if is_list or len(rows) > 1:
            inside += rows
        else:
            outside |= rows[0] if rows else {}
    return [{**outside, **row} for row in inside] or [outside]
