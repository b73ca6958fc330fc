"""Questionnaires in CSV files: one row per questionnaire (wide) or per answer (long).

Items are found by name, never by position. Cells are read as text, so an answer "None" is an
error and not a missing value.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from vrcomfort.csv_table import CsvTable, plain_digits
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
    place
        File and line where it starts, for people.
    run
        How often the session had been resumed when this was asked.
    """

    line: int
    keys: dict[str, str]
    answers: dict[str, int | None] = field(default_factory=dict)
    place: str = ""
    run: int = 0

    @property
    def participant(self) -> str:
        """Whose it is; this and what follows are blank where the file says nothing."""
        return self.keys.get("participant", "")

    @property
    def session(self) -> str:
        """The session in which it was asked."""
        return self.keys.get("session", "")

    @property
    def period(self) -> str:
        """The period of the study."""
        return self.keys.get("period", "")

    @property
    def trial(self) -> str:
        """The exposure of the session."""
        return self.keys.get("trial", "")

    @property
    def condition(self) -> str:
        """What was shown before."""
        return self.keys.get("condition", "")

    @property
    def scene(self) -> str:
        """Where it was shown."""
        return self.keys.get("scene", "")

    @property
    def sequence(self) -> str:
        """The participant's order."""
        return self.keys.get("sequence", "")

    @property
    def timepoint(self) -> str:
        """When it was asked, such as before or after."""
        return self.keys.get("timepoint", "")

    @property
    def name(self) -> str:
        """The moment in words."""
        parts = [f"session {self.session}" if self.session else ""]
        number = self.trial or self.period
        parts += [f"exposure {number}" if number else "", self.condition, self.timepoint]
        return ", ".join(part for part in parts if part)

    def require_unanswered(self, item: Item, table: CsvTable, line: int) -> None:
        """Raise `InputError` where a second row answers the same item."""
        if item.name in self.answers:
            raise table.fault(f"`{item.name}` is answered twice in one questionnaire", line, "item")


def read_sheets(
    file: Path, instrument: Instrument = SSQ, *, allow_blank: bool = False
) -> list[Sheet]:
    """Read a wide or a long CSV file, whichever it is.

    Long files have columns `item` and `response` (as ``questionnaires.csv``); in wide ones every
    item has a column under its name or a human-readable heading such as "Eye strain".

    Parameters
    ----------
    allow_blank
        A blank answer in a wide file is None, as it is in a long one.

    Raises
    ------
    InputError
        If a column is missing or there twice, or an answer is no integer or out of range; in wide
        files also if an answer is missing. With line and column.
    """
    table = CsvTable.read(file)
    if not table.header:
        raise InputError("this file is empty; a header row is needed", file=file)
    names = {heading.lower() for heading in table.header}
    if {"item", "response"} <= names:
        return _long(table, instrument)
    return _wide(table, instrument, allow_blank=allow_blank)


def _wide(table: CsvTable, instrument: Instrument, *, allow_blank: bool) -> list[Sheet]:
    columns = _item_columns(table, instrument)
    sheets = []
    for line, cells in zip(table.lines, table.rows, strict=True):
        keys = {
            heading: cell.strip()
            for index, (heading, cell) in enumerate(zip(table.header, cells, strict=True))
            if index not in columns
        }
        sheet = Sheet(line, keys)
        for index, item in columns.items():
            answer = _answer(table, instrument, cells[index], line, table.header[index])
            if answer is None and not allow_blank:
                message = "this answer is missing; `score --skip-incomplete` leaves such rows out"
                raise table.fault(message, line, table.header[index])
            sheet.answers[item.name] = answer
        sheets.append(sheet)
    return sheets


def _item_columns(table: CsvTable, instrument: Instrument) -> dict[int, Item]:
    columns: dict[int, Item] = {}
    for index, heading in enumerate(table.header):
        item = instrument.item(heading)
        if item is None:
            continue
        if item in columns.values():
            raise table.fault(f"a second column for `{item.name}`; keep one", 1, heading)
        columns[index] = item
    missing = [item for item in instrument.items if item not in columns.values()]
    if missing:
        others = [heading for heading in table.header if instrument.item(heading) is None]
        near = next((each for each in others if instrument.nearest(each) == missing[0].name), None)
        hint = f"; is it `{near}`?" if near else ""
        names = ", ".join(item.name for item in missing)
        raise table.fault(f"no column for {instrument.name.upper()} item {names}{hint}", 1)
    return columns


def _answer(
    table: CsvTable, instrument: Instrument, cell: str, line: int, column: str
) -> int | None:
    text = cell.strip()
    if not text:
        return None
    number = answer_number(text)
    if not number.is_integer():
        raise table.fault(f"`{text}` is not a whole number", line, column)
    answer = int(number)
    if not instrument.low <= answer <= instrument.high:
        hint = "; answers coded from 1 need 1 taken off" if answer == instrument.high + 1 else ""
        limits = f"{instrument.low} to {instrument.high}"
        raise table.fault(f"{answer} is out of range, answers are {limits}{hint}", line, column)
    return answer


def answer_number(text: str) -> float:
    """Return the number that an answer says, NaN where it says none."""
    try:
        return float(plain_digits(text))
    except ValueError:
        return float("nan")


def _long(table: CsvTable, instrument: Instrument) -> list[Sheet]:
    names = [heading.lower() for heading in table.header]
    sheets: dict[tuple[str, ...], Sheet] = {}
    for line, cells in zip(table.lines, table.rows, strict=True):
        row = dict(zip(names, (cell.strip() for cell in cells), strict=True))
        if row.get("instrument", instrument.name) != instrument.name:
            continue
        item = instrument.item(row["item"])
        if item is None:
            raise table.fault(_unknown_item(instrument, row["item"]), line, "item")
        keys = {name: row[name] for name in LONG_KEYS if name in row}
        sheet = sheets.setdefault(tuple(keys.values()), Sheet(line, keys))
        sheet.require_unanswered(item, table, line)
        sheet.answers[item.name] = _answer(table, instrument, row["response"], line, "response")
    return list(sheets.values())


def _unknown_item(instrument: Instrument, heading: str) -> str:
    near = instrument.nearest(heading)
    hint = f"; did you mean `{near}`?" if near else ""
    return f"`{heading}` is not an item of the {instrument.name.upper()}{hint}"
