"""Questionnaires in CSV files: one row per questionnaire (wide) or per answer (long).

Items are found by name, never by position. Cells are read as text, so an answer "None" is an
error and not a missing value. Answers that may be something else (sums in the column of an item,
answers counted from 1) are warned of.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from vrcomfort.csv_table import CsvTable, number_or_none
from vrcomfort.errors import InputError
from vrcomfort.questionnaire.answers import Answer, exact
from vrcomfort.questionnaire.instruments import Instrument, Item

FEWEST_ANSWERS = 32
"""So many answers without a single 0 are asked about: two whole SSQs."""

MOST_STEPS = 6
"""On longer scales, answers without a single 0 are plausible."""


def never_zero(instrument: Instrument, counts: Mapping[Answer, int]) -> int:
    """Return how many answers there are where none is 0 though that is the lowest, else 0.

    Then all of them may be too high by one: 1 to 4, with no 4 among them, for 0 to 3.

    Parameters
    ----------
    counts
        Answer → how often it was given.
    """
    answered = sum(counts.values())
    short = instrument.low == 0 and instrument.high <= MOST_STEPS
    suspect = short and answered >= FEWEST_ANSWERS and not counts.get(0)
    return answered if suspect else 0


def sum_in_place_of(
    instrument: Instrument,
    item: str,
    answers: Sequence[Mapping[str, Answer | None]],
    others: Mapping[str, Sequence[Answer | None]],
) -> tuple[str, str] | None:
    """Return (column, scale) where an item's column is exactly the raw sum of a scale.

    That is so where the sheet's item has another heading, and the scale's sum the item's. Rows
    with a missing answer prove nothing.

    Parameters
    ----------
    others
        Heading → answers of columns that are no item's, and may be this one's.
    """
    for heading, column in others.items():
        for scale in instrument.scales:
            terms = {term.item: term.slope for term in scale.terms}
            if item not in terms or len(terms) < 3:
                continue
            rows = [
                (sheet[item], sum(terms[name] * _of(sheet, name, item, other) for name in terms))
                for sheet, other in zip(answers, column, strict=True)
                if other is not None and all(sheet.get(name) is not None for name in terms)
            ]
            if len({found for found, _ in rows}) > 1 and all(a == b for a, b in rows):
                return heading, scale.title
    return None


def _of(sheet: Mapping[str, Answer | None], name: str, item: str, other: Answer) -> Answer:
    """Return the answer to an item, that of `other` standing for `item`."""
    found = other if name == item else sheet[name]
    return 0 if found is None else found


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
    answers: dict[str, Answer | None] = field(default_factory=dict)
    place: str = ""
    run: int = 0

    @property
    def participant(self) -> str:
        """The participant; this and the next ones are blank where the file says nothing."""
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
        """The condition before."""
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
    file: Path,
    instrument: Instrument,
    *,
    allow_blank: bool = False,
    coded_from: Answer | None = None,
) -> list[Sheet]:
    """Read a wide or a long CSV file, whichever it is.

    Long files have columns `item` and `response` (as ``questionnaires.csv``); in wide ones every
    item has a column under its name or a human-readable heading such as "Eye strain".

    Parameters
    ----------
    allow_blank
        A blank answer in a wide file is None, as it is in a long one.
    coded_from
        The number that stands for the lowest answer; the instrument's own without it.

    Raises
    ------
    InputError
        If a column is missing or there twice, or is named like an item and holds a sum; if an
        answer is no integer or out of range; in wide files also if an answer is missing. With line
        and column.
    """
    table = CsvTable.read(file)
    if not table.header:
        raise InputError("this file is empty; a header row is needed", file=file)
    names = {heading.lower() for heading in table.header}
    if {"item", "response"} <= names:
        keys = [name for name in LONG_KEYS if name in names]
        return read_long(table, instrument, keys, coded_from=coded_from)
    return _wide(table, instrument, allow_blank=allow_blank, coded_from=coded_from)


def _wide(
    table: CsvTable, instrument: Instrument, *, allow_blank: bool, coded_from: Answer | None
) -> list[Sheet]:
    columns = _item_columns(table, instrument)
    _require_no_sums(table, instrument, columns)
    sheets = []
    for line, cells in zip(table.lines, table.rows, strict=True):
        keys = {
            heading: cell.strip()
            for index, (heading, cell) in enumerate(zip(table.header, cells, strict=True))
            if index not in columns
        }
        sheet = Sheet(line, keys)
        for index, item in columns.items():
            answer = _answer(table, item, cells[index], line, table.header[index], coded_from)
            if answer is None and not allow_blank and not instrument.may_miss(item):
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
    _require_one_candidate(table, instrument, columns)
    missing = [item for item in instrument.asked if item not in columns.values()]
    if missing:
        others = [heading for heading in table.header if instrument.item(heading) is None]
        near = next((each for each in others if instrument.nearest(each) == missing[0].name), None)
        hint = f"; is it `{near}`?" if near else ""
        names = ", ".join(item.name for item in missing)
        raise table.fault(f"no column for {instrument.short} item {names}{hint}", 1)
    return columns


def _require_one_candidate(
    table: CsvTable, instrument: Instrument, columns: Mapping[int, Item]
) -> None:
    """Raise `InputError` where another heading may mean the same item: one may be a sum."""
    for index, item in columns.items():
        heading = table.header[index]
        rival = next((h for h in table.header if instrument.may_mean(h, item)), None)
        if rival is not None:
            message = (
                f"`{heading}` and `{rival}` may both be item {item.name}; rename the one that is "
                f"not (a sum to `{heading} sum`)"
            )
            raise table.fault(message, 1, heading)


def _require_no_sums(table: CsvTable, instrument: Instrument, columns: Mapping[int, Item]) -> None:
    """Raise `InputError` where the column of an item is exactly the sum of others."""
    texts = list(zip(*table.rows, strict=True))
    read = {i: [number_or_none(cell) for cell in texts[i]] for i in range(len(texts))}
    sheets = [
        {item.name: read[index][row] for index, item in columns.items()}
        for row in range(len(table.rows))
    ]
    others = {
        heading: read[index]
        for index, heading in enumerate(table.header)
        if index not in columns
        and index in read
        and all(each is not None and instrument.answers.has(each) for each in read[index])
    }
    for index, item in columns.items():
        found = sum_in_place_of(instrument, item.name, sheets, others)
        if found is not None:
            heading, (other, scale) = table.header[index], found
            message = f"`{heading}` is exactly the sum of {scale}, with `{other}` as {item.name}"
            hint = f"rename `{heading}` to `{heading} sum`, and `{other}` to `{item.name}`"
            raise table.fault(f"{message}; {hint}", 1, heading)


def _answer(
    table: CsvTable,
    item: Item,
    cell: str,
    line: int,
    column: str,
    coded_from: Answer | None = None,
) -> Answer | None:
    text = cell.strip()
    answers = item.answers
    if coded_from is None and text in answers.plain:
        return answers.plain[text]
    if not text:
        return None
    number = number_or_none(text)
    if number is not None and coded_from is not None:
        number += answers.low - coded_from
    if number is None or (exact(number) / answers.resolution).denominator != 1:
        what = "a whole number" if answers.resolution == 1 else f"one of {answers.in_words}"
        raise table.fault(f"`{text}` is not {what}", line, column)
    if not answers.low <= number <= answers.high:
        one_more = coded_from is None and number == answers.high + 1
        hint = f"; if they are counted from {answers.low + 1}, 1 is taken off" if one_more else ""
        hint = f"{hint} by `score --coded-from {answers.low + 1}` or an import" if hint else ""
        message = f"{number:g} is out of range, answers are {answers.in_words}{hint}"
        raise table.fault(message, line, column)
    if not answers.has(number):
        raise table.fault(f"`{text}` is not one of {answers.in_words}", line, column)
    return int(number) if number.is_integer() else number


def read_long(
    table: CsvTable,
    instrument: Instrument,
    keys: Sequence[str],
    *,
    nameless: bool = True,
    coded_from: Answer | None = None,
) -> list[Sheet]:
    """Read a table with a row for each answer, in the order in which they were given.

    Rows of other instruments are left alone. What a session asked again after it had been resumed
    is another sheet; what it finished then belongs to the sheet that had been begun.

    Parameters
    ----------
    keys
        Columns that say whose a sheet is; one that the table does not have is blank.
    nameless
        Whether rows that name no instrument are of this one.
    coded_from
        As in `read_sheets`.

    Raises
    ------
    InputError
        If an item is none or is answered twice, or an answer is no integer or out of range. With
        line and column.
    """
    if not table.rows:
        return []
    sheets = _LongSheets(table, instrument, keys, coded_from)
    own = {instrument.name, ""} if nameless else {instrument.name}
    name = sheets.column("instrument")
    mine: dict[str, bool] = {}
    for line, cells in zip(table.lines, table.rows, strict=True):
        named = "" if name is None else cells[name]
        if named not in mine:
            mine[named] = named.strip().lower() in own
        if mine[named]:
            sheets.add(cells, line)
    return list(sheets.found.values())


class _LongSheets:
    """The sheets of a long table."""

    def __init__(
        self,
        table: CsvTable,
        instrument: Instrument,
        keys: Sequence[str],
        coded_from: Answer | None,
    ) -> None:
        self._table = table
        self._coded_from = coded_from
        self._instrument = instrument
        self._keys = keys
        names = [name.lower() for name in table.header]
        self._columns = {name: place for place, name in enumerate(names)}
        self._places = [self._columns[name] for name in keys if name in self._columns]
        self._item, self._response = self._columns["item"], self._columns["response"]
        self._resumed = self._columns.get("resumed")
        self._runs: dict[tuple[str, str], int] = {}
        self._answered: dict[tuple[str, str], tuple[Item, Answer | None]] = {}
        self._before: tuple[list[str], Sheet] | None = None
        self.found: dict[tuple[str | int, ...], Sheet] = {}

    def column(self, name: str) -> int | None:
        """Return the place of a column, None where there is none of that name."""
        return self._columns.get(name)

    def add(self, cells: Sequence[str], line: int) -> None:
        """Put one answer where it belongs."""
        said = cells[self._item], cells[self._response]
        if said not in self._answered:
            self._answered[said] = self._read(*said, line)
        item, answer = self._answered[said]
        sheet = self._sheet(cells, line, item.name)
        sheet.require_unanswered(item, self._table, line)
        sheet.answers[item.name] = answer

    def _read(self, heading: str, response: str, line: int) -> tuple[Item, Answer | None]:
        item = self._instrument.item(heading.strip())
        if item is None:
            message = _unknown_item(self._instrument, heading.strip())
            raise self._table.fault(message, line, "item")
        answer = _answer(self._table, item, response, line, "response", self._coded_from)
        return item, answer

    def _sheet(self, cells: Sequence[str], line: int, item: str) -> Sheet:
        """Return the sheet of a row: mostly that of the row before."""
        whose = [cells[place] for place in self._places]
        again = self._resumed is not None and cells[self._resumed].strip() not in {"", "0"}
        if self._before is not None and not again and self._before[0] == whose:
            return self._before[1]
        there = [name for name in self._keys if name in self._columns]
        row = {name: cells[self._columns[name]].strip() for name in there}
        key = tuple(row.get(name, "") for name in self._keys)
        session = row.get("participant", ""), row.get("session", "")
        run = self._run(session, key, item) if again else self._runs.get(session, 0)
        sheet = self.found.get((*key, run))
        if sheet is None:
            sheet = Sheet(line, dict(zip(self._keys, key, strict=True)), run=run)
            self.found[*key, run] = sheet
        self._before = None if again else (whose, sheet)
        return sheet

    def _run(self, session: tuple[str, str], key: tuple[str, ...], item: str) -> int:
        """Return how often the session had been resumed: each run asks something once."""
        run = self._runs.get(session, 0)
        sheet = self.found.get((*key, run))
        if sheet is not None and item not in sheet.answers:
            return run  # what an interruption cut off has been finished
        run = max(run, 1) + (sheet is not None and run > 0)
        self._runs[session] = run
        return run


def _unknown_item(instrument: Instrument, heading: str) -> str:
    near = instrument.nearest(heading)
    hint = f"; did you mean `{near}`?" if near else ""
    return f"`{heading}` is not an item of the {instrument.short}{hint}"
