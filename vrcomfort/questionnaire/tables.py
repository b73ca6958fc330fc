"""Questionnaires in CSV files: one row per questionnaire (wide) or per answer (long).

Items are found by name, never by position. Cells are read as text, so an answer "None" is an
error and not a missing value.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

from vrcomfort.errors import InputError
from vrcomfort.questionnaire.instruments import SSQ, Instrument, Item

LONG_KEYS = ("participant", "session", "trial", "condition", "timepoint")


@dataclass
class Sheet:
    """One questionnaire of one person at one moment.

    Parameters
    ----------
    line
        The line of the file where it starts.
    keys
        The cells that say whose it is, by column.
    answers
        item name → answer; None where the cell is blank.
    """

    line: int
    keys: dict[str, str]
    answers: dict[str, int | None] = field(default_factory=dict)


@dataclass(frozen=True)
class _Table:
    file: Path
    header: tuple[str, ...]
    rows: tuple[tuple[int, list[str]], ...]
    """(line number, cells)."""

    def fail(self, message: str, line: int, column: str | None = None) -> NoReturn:
        raise InputError(message, file=self.file, line=line, column=column)


def read_sheets(file: Path, instrument: Instrument = SSQ) -> list[Sheet]:
    """Read a wide or a long CSV file, whichever it is.

    Long files have columns `item` and `response` (as ``questionnaires.csv``); in wide ones every
    item has a column under its name or a human-readable heading such as "Eye strain".

    Raises
    ------
    InputError
        If a column is missing or there twice, or an answer is no integer or out of range; in wide
        files also if an answer is missing. With line and column.
    """
    table = _read(file)
    names = {heading.strip().lower() for heading in table.header}
    if {"item", "response"} <= names:
        return _long(table, instrument)
    return _wide(table, instrument)


def _read(file: Path) -> _Table:
    try:
        with file.open(encoding="utf-8-sig", newline="") as stream:
            reader = csv.reader(stream)
            lines = [(reader.line_num, cells) for cells in reader if any(map(str.strip, cells))]
    except OSError as error:
        raise InputError(f"cannot read this table: {error.strerror}", file=file) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"this is not a UTF-8 CSV file: {error}", file=file) from error
    if not lines:
        raise InputError("this file is empty; a header row is needed", file=file)
    header = tuple(heading.strip() for heading in lines[0][1])
    table = _Table(file, header, tuple(lines[1:]))
    if len(header) == 1 and header[0].count(";") > 1:
        table.fail("the columns are separated by `;`; save it with commas", lines[0][0])
    for line, cells in table.rows:
        if len(cells) != len(header):
            table.fail(f"this row has {len(cells)} cells, the header has {len(header)}", line)
    return table


def _wide(table: _Table, instrument: Instrument) -> list[Sheet]:
    columns = _item_columns(table, instrument)
    sheets = []
    for line, cells in table.rows:
        keys = {
            heading: cell.strip()
            for index, (heading, cell) in enumerate(zip(table.header, cells, strict=True))
            if index not in columns
        }
        sheet = Sheet(line, keys)
        for index, item in columns.items():
            answer = _answer(table, instrument, cells[index], line, table.header[index])
            if answer is None:
                table.fail("this answer is missing", line, table.header[index])
            sheet.answers[item.name] = answer
        sheets.append(sheet)
    return sheets


def _item_columns(table: _Table, instrument: Instrument) -> dict[int, Item]:
    columns: dict[int, Item] = {}
    for index, heading in enumerate(table.header):
        item = instrument.item(heading)
        if item is None:
            continue
        if item in columns.values():
            table.fail(f"a second column for `{item.name}`; keep one", 1, heading)
        columns[index] = item
    missing = [item for item in instrument.items if item not in columns.values()]
    if missing:
        others = [heading for heading in table.header if instrument.item(heading) is None]
        near = next((each for each in others if instrument.nearest(each) == missing[0].name), None)
        hint = f"; is it `{near}`?" if near else ""
        names = ", ".join(item.name for item in missing)
        table.fail(f"no column for {instrument.name.upper()} item {names}{hint}", 1)
    return columns


def _answer(table: _Table, instrument: Instrument, cell: str, line: int, column: str) -> int | None:
    text = cell.strip()
    if not text:
        return None
    try:
        number = float(text)
    except ValueError:
        number = float("nan")
    if not number.is_integer():
        table.fail(f"`{text}` is not a whole number", line, column)
    answer = int(number)
    if not instrument.low <= answer <= instrument.high:
        hint = "; answers coded from 1 need 1 taken off" if answer == instrument.high + 1 else ""
        limits = f"{instrument.low} to {instrument.high}"
        table.fail(f"{answer} is out of range, answers are {limits}{hint}", line, column)
    return answer


def _long(table: _Table, instrument: Instrument) -> list[Sheet]:
    names = [heading.strip().lower() for heading in table.header]
    sheets: dict[tuple[str, ...], Sheet] = {}
    for line, cells in table.rows:
        row = dict(zip(names, (cell.strip() for cell in cells), strict=True))
        if row.get("instrument", instrument.name) != instrument.name:
            continue
        item = instrument.item(row["item"])
        if item is None:
            table.fail(_unknown_item(instrument, row["item"]), line, "item")
        keys = {name: row[name] for name in LONG_KEYS if name in row}
        sheet = sheets.setdefault(tuple(keys.values()), Sheet(line, keys))
        if item.name in sheet.answers:
            table.fail(f"`{item.name}` is answered twice in one questionnaire", line, "item")
        sheet.answers[item.name] = _answer(table, instrument, row["response"], line, "response")
    return list(sheets.values())


def _unknown_item(instrument: Instrument, heading: str) -> str:
    near = instrument.nearest(heading)
    hint = f"; did you mean `{near}`?" if near else ""
    return f"`{heading}` is not an item of the {instrument.name.upper()}{hint}"
