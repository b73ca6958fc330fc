"""Converts a lab's tables to answers, scores, ratings and participants, as a mapping says."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.importing.answers import AnswerReader, number, time_in_words_s
from vrcomfort.importing.columns import ALMOST, Block, Columns, nearly_named
from vrcomfort.importing.files import as_table, read_grids
from vrcomfort.importing.made_instruments import MOST, ScoreInstrument, name_of, on_scale, sum_up
from vrcomfort.importing.mapping import (
    LabMapping,
    Leaving,
    Questionnaire,
    ScoreKind,
    Scores,
    Summary,
    TableMapping,
    matches,
    scale_named,
)
from vrcomfort.importing.row_facts import TIMEPOINT, Numbers, RowFacts
from vrcomfort.importing.rows import (
    Administration,
    AnsweredAgainError,
    ExposureEnd,
    Imported,
    ImportedResponse,
    Rating,
    RowsLost,
    SourceRow,
    administration_of,
    suspects,
)
from vrcomfort.importing.sections import sections
from vrcomfort.importing.source import Grid, Reading, SourceTable
from vrcomfort.importing.unmatched import texts_in, unmatched
from vrcomfort.plurals import counted_doing
from vrcomfort.questionnaire import Answer, Instrument, Scale, plain, shipped_instruments

KnownInstruments = dict[str, Instrument]
STATUSES = ("enrolled", "completed", "withdrawn", "excluded")


@dataclass
class Made:
    """Instruments made of all tables together: scores without answers, rating time courses."""

    scores: dict[str, ScoreInstrument] = field(default_factory=dict)
    courses: dict[tuple[str, Administration], tuple[SourceRow, Sequence[Summary], list[Rating]]] = (
        field(default_factory=dict)
    )


_FEWEST_OF_LOG = 20
"""Rows of a log that has other rows than ratings; of fewer, blank ones are missed ratings."""


class TableImport:
    """The import of one table."""

    def __init__(
        self,
        table: SourceTable,
        mapping: TableMapping,
        known: KnownInstruments,
        imported: Imported,
        numbers: Numbers,
        made: Made,
    ) -> None:
        self._made = made
        self._table = table
        self._mapping = mapping
        self._imported = imported
        self._columns = Columns(table, mapping, known)
        self._facts = RowFacts(table, mapping, self._columns, numbers)
        self._all_blocks = (*self._columns.blocks, *self._columns.scores)
        self._answer_columns = self._columns.of_answers
        self._events = 0
        self._sparse: dict[int, bool] = {}
        self._beside = [tuple(block.beside.values()) for block in self._all_blocks]
        self._known_administrations: dict[tuple[object, ...], list[Administration]] = {}
        self._behind: dict[tuple[str, Administration], list[Rating]] = {}
        """Blank ratings since the last one of a course that has a column for each time."""
        self._left_out = 0
        self._again: list[str] = []
        """Rows whose answers another row has given already."""
        self._blank: Counter[str] = Counter()
        self._unknown_items: dict[str, list[tuple[int, int]]] = {}
        """Text that is no item → row and column of each such cell."""
        self._elsewhere: Counter[str] = Counter()
        self._readers: dict[tuple[int, str], AnswerReader] = {}

    def run(self) -> str:
        """Import every row, note the rows left out, and return the name of the sheet."""
        filled = [self._columns.index(name, "fill_down") for name in self._mapping.fill_down]
        above: dict[int, str] = {}
        for found, row in zip(self._table.rows, self._table.numbers, strict=True):
            above = {i: found[i] or above.get(i, "") for i in filled}
            cells = tuple(above.get(i, cell) for i, cell in enumerate(found)) if filled else found
            if any(cells[i] in texts for i, texts in self._columns.leave_out.items()):
                self._left_out += 1
            else:
                self._row(cells, row)
        self._note()
        return self._table.sheet

    def _row(self, cells: tuple[str, ...], row: int) -> None:
        elsewhere: list[str] = []
        taken: list[int] = []
        for place, block in enumerate(self._all_blocks):
            if block.where and any(cells[i] not in texts for i, texts in block.where.items()):
                elsewhere += [cells[i] for i in block.where]
            else:
                taken.append(place)
        if taken and not any(map(cells.__getitem__, self._answer_columns)):
            self._events += 1  # a row of a log without answers may say anything of its exposure
            taken = []
        administrations = self._administrations_of(taken, cells, row) if taken else []
        for place, administration in zip(taken, administrations, strict=True):
            self._take(place, administration, cells, row)
        if elsewhere and not taken:
            self._elsewhere[", ".join(dict.fromkeys(elsewhere))] += 1
        self._ends(cells, row)
        if self._columns.participants:
            self._covariates(self._facts.participant(cells, row), cells, row)

    def _ends(self, cells: tuple[str, ...], row: int) -> None:
        """Read how long the exposures of a row lasted."""
        leaving = self._mapping.left_at
        if leaving is None:
            return
        for column, said in self._columns.left_at.items():
            facts = {**self._facts.of_row(cells, row)}
            facts |= {name: self._facts.renamed(name, text, row) for name, text in said.items()}
            facts = {name: text for name, text in facts.items() if name != "timepoint"}
            administration = self._administration(facts, row)._replace(timepoint="")
            if all(each.administration != administration for each in self._imported.ends):
                end_s = self._left_s(leaving, cells[column], row, column)
                planned_s = leaving.planned_s
                left = end_s is not None and (planned_s is None or end_s < planned_s)
                end = ExposureEnd(administration, end_s if left else planned_s, left=left)
                self._imported.ends.append(end)

    def _left_s(self, leaving: Leaving, text: str, row: int, column: int) -> float | None:
        if text in {"", *leaving.missing, *self._mapping.missing}:
            return None
        value = number(text, self._table.decimal)
        in_words_s = time_in_words_s(text)
        if in_words_s is None and (value is None or value < 0):
            message = f"{text!r} is not a time; write texts for participants who stayed"
            raise self._table.fault(f"{message} into `missing` of left_at", row, column)
        end_s = (value or 0.0) * (60 if leaving.unit == "min" else 1)
        return end_s if in_words_s is None else in_words_s

    def _administrations_of(
        self, blocks: list[int], cells: tuple[str, ...], row: int
    ) -> list[Administration]:
        """Return the administration of each block of a row; equal rows are looked up."""
        said = self._facts.key(cells)
        order = self._columns.order
        beside = tuple(cells[i] for b in blocks for i in self._beside[b])
        key = (*blocks, said, beside, None if order is None else cells[order])
        if said is not None and key in self._known_administrations:
            return self._known_administrations[key]
        of_row = self._facts.of_row(cells, row)
        counted: dict[tuple[object, ...], dict[str, str]] = {}
        met: Counter[tuple[object, ...]] = Counter()
        found = []
        for block in map(self._all_blocks.__getitem__, blocks):
            facts = {**of_row, **self._renamed(block, row), **self._beside_of(block, cells, row)}
            if not self._facts.order_is_counted:
                facts = dict(self._facts.in_order(facts, cells, row))
            said_here = tuple(sorted(facts.items()))
            met[block.instrument.name, said_here] += 1
            # Questionnaires of one administration are of one exposure, two of a kind are not.
            same = said_here, met[block.instrument.name, said_here]
            if same not in counted:
                counted[same] = self._facts.counted(facts, _item_text(block, cells))
            numbered = dict(self._facts.in_order(counted[same], cells, row))
            found.append(self._administration(numbered, row))
        if said is not None:
            self._known_administrations[key] = found
        return found

    def _renamed(self, block: Block, row: int) -> dict[str, str]:
        said = block.source.constants()
        return {
            name: text if name in said else self._facts.renamed(name, text, row)
            for name, text in block.facts.items()
        }

    def _beside_of(self, block: Block, cells: tuple[str, ...], row: int) -> dict[str, str]:
        """Return the facts that stand in columns beside a questionnaire; blank ones say nothing."""
        missing = {"", *self._mapping.missing}
        return {
            fact: self._facts.renamed(fact, cells[column], row)
            for fact, column in block.beside.items()
            if cells[column] not in missing
        }

    def _administration(self, facts: dict[str, str], row: int) -> Administration:
        self._require_participant(facts.get("participant", ""), row)
        return administration_of({"timepoint": TIMEPOINT, **facts})

    def _require_participant(self, name: str, row: int) -> None:
        if not name:
            columns = self._columns.facts.get("participant")
            message = "there is no participant; name the row under leave_out unless it is one's"
            raise self._table.fault(message, row, columns[0] if columns else None)

    def _take(
        self, place: int, administration: Administration, cells: tuple[str, ...], row: int
    ) -> None:
        block = self._all_blocks[place]
        if isinstance(block.source, Scores):
            self._scores(block, administration, cells, row)
        elif block.time_column is not None or block.onset_s is not None:
            self._rating(place, administration, cells, row)
        else:
            self._answers(place, administration, cells, row)

    def _items(self, block: Block, cells: tuple[str, ...], row: int) -> list[tuple[int, str]]:
        """Return (column, item) of the answers of a row."""
        if block.item_column is None or block.response_column is None:
            return list(block.columns.items())
        item = block.words.get(cells[block.item_column])
        if item is None:
            text = cells[block.item_column]
            self._unknown_items.setdefault(text, []).append((row, block.item_column))
            return []
        return [(block.response_column, item)]

    def _read(self, place: int, item: str, text: str, row: int, column: int) -> Answer | None:
        reader = self._readers.get((place, item))
        if reader is None:
            block = self._all_blocks[place]
            if not isinstance(block.source, Questionnaire):
                raise TypeError(block.source)
            missing = self._mapping.missing
            reader = AnswerReader(self._table, block.source, block.instrument, item, missing)
            self._readers[place, item] = reader
        return reader.read(text, row, column)

    def _answers(
        self, place: int, administration: Administration, cells: tuple[str, ...], row: int
    ) -> None:
        block = self._all_blocks[place]
        found = self._items(block, cells, row)
        answers = {i: self._read(place, i, cells[c], row, c) for c, i in found}
        if not found:
            return
        if block.item_column is None and not any(a is not None for a in answers.values()):
            self._blank[administration.timepoint] += 1
            return
        here = SourceRow(self._table.file.name, self._table.sheet, row)
        name = block.instrument.name
        response = self._imported.responses.setdefault(
            (name, administration), ImportedResponse(here)
        )
        if all(i in response.answers and response.answers[i] == a for i, a in answers.items()):
            self._again.append(f"row {row} says what row {response.place.row} said")
            return
        for column, item in found:
            self._require_unanswered(response, item, administration, row, column)
            response.answers[item] = answers[item]
        if not_asked := _not_asked(block):
            before = self._imported.not_asked.get(name, ())
            self._imported.not_asked[name] = tuple(dict.fromkeys((*before, *not_asked)))

    def _rating(
        self, place: int, administration: Administration, cells: tuple[str, ...], row: int
    ) -> None:
        block = self._all_blocks[place]
        found = self._items(block, cells, row)
        if not found:
            return
        onset_s = block.onset_s
        if block.time_column is not None:
            onset_s = number(cells[block.time_column], self._table.decimal)
            in_minutes = isinstance(block.source, Questionnaire) and block.source.time_unit == "min"
            onset_s = None if onset_s is None else onset_s * (60 if in_minutes else 1)
        if onset_s is None:
            text = "" if block.time_column is None else cells[block.time_column]
            raise self._table.fault(f"{text!r} is no time", row, block.time_column)
        for column, item in found:
            response = self._read(place, item, cells[column], row, column)
            rating = Rating(administration, block.instrument.name, onset_s, response)
            here = SourceRow(self._table.file.name, self._table.sheet, row)
            summaries = block.source.summaries if isinstance(block.source, Questionnaire) else ()
            key = block.instrument.name, administration
            if response is None and self._is_sparse(block):
                self._events += 1  # a row of a log of more than ratings
                continue
            # Blank cells behind the last rating of a row are no missed ones: nobody asked.
            blank = self._behind.setdefault(key, [])
            if response is None and block.onset_s is not None:
                blank.append(rating)
                continue
            self._imported.ratings += [*blank, rating]
            course = self._made.courses.setdefault(key, (here, summaries, []))[2]
            course += [*blank, rating]
            blank.clear()

    def _is_sparse(self, block: Block) -> bool:
        """Return whether most rows of a table with times have no rating."""
        if block.time_column is None or not block.columns:
            return False
        column = next(iter(block.columns))
        if column not in self._sparse:
            cells = self._table.column(column)
            self._sparse[column] = cells.count("") * 2 >= len(cells) >= _FEWEST_OF_LOG
        return self._sparse[column]

    def _scores(
        self, block: Block, administration: Administration, cells: tuple[str, ...], row: int
    ) -> None:
        source = block.source
        if not isinstance(source, Scores):
            raise TypeError(source)
        name = name_of(block.instrument, source.kind)
        made = self._made.scores.setdefault(name, ScoreInstrument(block.instrument, source.kind))
        here = SourceRow(self._table.file.name, self._table.sheet, row)
        found: dict[int, tuple[str, Answer | None]] = {}
        for column, scale in block.columns.items():
            known = scale_named(block.instrument, scale)
            if known is None:
                names = ", ".join(each.name for each in block.instrument.scales)
                raise self._table.fault(f"{scale!r} is no scale; there are {names}", column=column)
            value = self._score(known, source.kind, cells[column], row, column)
            made.values.setdefault(known.column, []).extend([] if value is None else [value])
            found[column] = known.column, value
        if all(value is None for _, value in found.values()):
            self._blank[administration.timepoint] += 1
            return
        response = self._imported.responses.setdefault(
            (name, administration), ImportedResponse(here)
        )
        for column, (item, value) in found.items():
            self._require_unanswered(response, item, administration, row, column)
            response.answers[item] = value

    def _score(
        self, scale: Scale, kind: ScoreKind, text: str, row: int, column: int
    ) -> Answer | None:
        if not text or text in self._mapping.missing:
            return None
        value = number(text, self._table.decimal)
        if value is None:
            raise self._table.fault(f"{text!r} is no number, as scores are", row, column)
        found = on_scale(value, scale, kind)
        if found is None and kind == "other":
            raise self._table.fault(f"{text} is larger than any score, {MOST:,.0f}", row, column)
        if found is None:
            unit = 1 if kind == "raw_sum" else scale.weight
            highest = float(scale.high) if kind == "score" else float(scale.high / scale.unit)
            message = f"{text} is no {kind} of {scale.title}, which are multiples of {unit:g} up to"
            hint = f'{highest:g}; kind = "other" takes scores of another formula as they are'
            raise self._table.fault(f"{message} {hint}", row, column)
        return found

    def _require_unanswered(
        self,
        response: ImportedResponse,
        item: str,
        administration: Administration,
        row: int,
        column: int,
    ) -> None:
        if item in response.answers:
            message = f"{item} is answered a second time by {administration.words}; first in"
            hint = "a trial or session tells repetitions apart (or trial = { count = true })"
            fault = self._table.fault(f"{message} {response.place}; {hint}", row, column)
            raise AnsweredAgainError(fault.message)

    def _covariates(self, participant: str, cells: tuple[str, ...], row: int) -> None:
        self._require_participant(participant, row)
        known = self._imported.participants.setdefault(participant, {})
        for name, column in self._columns.participants.items():
            text = "" if cells[column] in self._mapping.missing else cells[column]
            if self._table.reading.decimal == "," and number(text, ",") is not None:
                text = text.replace(",", ".")
            if text and known.get(name) and known[name] != text:
                message = f"{name} of {participant} is {known[name]!r} elsewhere, {text!r} here"
                raise self._table.fault(f"{message}; a participant has one", row, column)
            if name == "status" and text not in {"", *STATUSES}:
                message = f"{text!r} is not a status; there are {', '.join(STATUSES)}"
                raise self._table.fault(message, row, column)
            known[name] = text or known.get(name, "")

    def _note(self) -> None:
        notes = [*self._table.notes, *self._columns.suspicions]
        name = self._table.name
        if self._left_out:
            notes.append(f"{name}: {self._left_out} rows were left out, as the mapping says")
        if self._events:
            rows_have = counted_doing(self._events, "rows", "have")
            notes.append(f"{name}: {rows_have} no answer at all; none was made")
        if short := sum(map(bool, self._behind.values())):
            courses_end = counted_doing(short, "courses of ratings", "end")
            notes.append(
                f"{name}: {courses_end} before the last column; blanks behind are no ratings"
            )
        if self._again:
            rows_were = counted_doing(len(self._again), "rows", "were")
            notes.append(f"{name}: {rows_were} counted once, not twice: {self._again[0]}")
        for timepoint, count in self._blank.items():
            have = counted_doing(count, "questionnaires", "have")
            notes.append(f"{name}: {have} no answer at all at {timepoint}; none was made")
        for text, count in self._elsewhere.items():
            notes.append(
                f"{name}: {count} rows with {text!r} are in no questionnaire of the mapping"
            )
        notes += self._rows_of_no_item()
        self._imported.notes += notes
        if self._elsewhere:
            found = self._elsewhere.total(), len(self._table.rows), tuple(self._elsewhere)
            self._imported.lost.append(RowsLost(name, *found))

    def _rows_of_no_item(self) -> Iterator[str]:
        """Yield notes on rows of unknown items.

        Raises
        ------
        InputError
            If the text is almost one: it is misspelt, and would be dropped.
        """
        known = {plain(text): text for block in self._all_blocks for text in block.words}
        for text, cells in self._unknown_items.items():
            if plain(text) in known:
                continue  # of another questionnaire
            if near := get_close_matches(plain(text), known, n=1, cutoff=ALMOST):
                message = f"{text!r} is not an item; is it {known[near[0]]!r}? Give it under"
                raise self._table.fault(f"{message} items or leave_out in the mapping", *cells[0])
            if item := self._not_asked_item(text):
                message = f"{text!r} looks like {item}, which was not asked, as the mapping says"
                yield f"{self._table.name}: {message}; {len(cells)} rows of it were left out"
                continue
            what = f"{len(cells)} rows of {text!r} were left out"
            self._elsewhere[text] += len(cells)
            yield f"{self._table.name}: {what}: no item of that name"

    def _not_asked_item(self, text: str) -> str:
        """Return the item that was not asked, of which a text is almost the name; or nothing."""
        for block in self._columns.blocks:
            if block.item_column is not None and plain(text):
                near = nearly_named(block.instrument, _not_asked(block), {plain(text): text})
                if near:
                    return next(iter(near))
        return ""


def _not_asked(block: Block) -> tuple[str, ...]:
    """Return the items that were left out by design."""
    if not isinstance(block.source, Questionnaire):
        return ()
    if not block.source.item_order:
        return block.source.not_asked
    return tuple(i.name for i in block.instrument.asked if i.name not in block.source.item_order)


def _item_text(block: Block, cells: tuple[str, ...]) -> str:
    return "" if block.item_column is None else cells[block.item_column]


def import_files(
    files: Sequence[Path], mapping: LabMapping, own: Sequence[Instrument] = ()
) -> Imported:
    """Read files as a mapping says.

    Parameters
    ----------
    own
        Instruments that are not shipped.

    Raises
    ------
    InputError
        If a file has no table in the mapping or a table no file, a column is not said anything
        of, a cell is not what it should be (with file, row and column), or nobody has an answer.
    """
    imported = Imported()
    numbers = Numbers()
    made = Made()
    own = (*mapping.declared, *own)
    known = {**shipped_instruments(), **{each.name: each for each in own}}
    _require_names(files)
    used: set[int] = set()
    seen: list[set[tuple[str, str]]] = [set() for _ in mapping.tables]
    for file in files:
        found = [i for i, each in enumerate(mapping.tables) if matches(file.name, each.files)]
        if not found and matches(file.name, mapping.ignore_files):
            continue
        if not found:
            message = "no table of the mapping names this file; add it, or list it under"
            raise InputError(f"{message} ignore_files", file=file)
        used.update(found)
        taken = []
        for index in found:
            table = mapping.tables[index]
            for each in tables_of(file, table, mapping.ignore_sheets):
                taken.append(TableImport(each, table, known, imported, numbers, made).run())
                seen[index] |= texts_in(each, table)
        reading = mapping.tables[found[0]].read.reading
        _require_sheets(file, mapping, reading, [sheet for sheet in taken if sheet])
    for index, table in enumerate(mapping.tables):
        if index not in used:
            names = ", ".join(table.files)
            raise InputError(f"the mapping has a table for {names}, which was not given; give it")
    mapping.require_none(unmatched(mapping, seen, known, imported.conditions))
    imported.instruments = {each.name: each for each in own}
    imported.instruments |= {name: each.made() for name, each in made.scores.items()}
    imported.scores = list(made.scores)
    sum_up(imported, made.courses, known)
    if not imported.answered:
        message = "no answer to a questionnaire, score, rating or leaving time comes in; say in"
        raise InputError(f"{message} the mapping which columns hold them (tables.questionnaires)")
    _finish(imported)
    return imported


def _require_names(files: Sequence[Path]) -> None:
    twice = [name for name, count in Counter(file.resolve() for file in files).items() if count > 1]
    if twice:
        raise InputError("this file is given twice", file=twice[0])


def _grids(file: Path, reading: Reading) -> list[Grid]:
    grids = read_grids(file, reading)
    return [part for grid in grids for part in (sections(grid) if reading.sections else [grid])]


def tables_of(file: Path, table: TableMapping, ignored: Sequence[str] = ()) -> list[SourceTable]:
    """Read the sheets of a file that are of a table of a mapping, and not ignored.

    Raises
    ------
    InputError
        If the file, or a table of it, cannot be read; with the row.
    """
    grids = _grids(file, table.read.reading)
    own = [g for g in grids if not g.sheet or matches(g.sheet, table.sheets)]
    return [as_table(g) for g in own if not (g.sheet and matches(g.sheet, ignored))]


def _require_sheets(
    file: Path, mapping: LabMapping, reading: Reading, taken: Sequence[str]
) -> None:
    """Raise `InputError` where a sheet with rows below its headings is left out without a word."""
    if file.suffix.lower() not in {".xlsx", ".xlsm"} and not reading.sections:
        return
    for grid in _grids(file, reading):
        said = grid.sheet in taken or matches(grid.sheet, mapping.ignore_sheets)
        if len(grid.rows) > 1 and not said:
            message = f"the sheet {grid.sheet!r} is in no table of the mapping"
            raise InputError(f"{message}; add it, or list it under ignore_sheets", file=file)


def _finish(imported: Imported) -> None:
    """Add participants without covariates, and note ids that may be one person.

    Where each question is an outcome by itself, what one file asks was asked.
    """
    asked = {(name, i) for (name, _), each in imported.responses.items() for i in each.answers}
    alone = {
        name
        for name, each in imported.instruments.items()
        if all(len(scale.terms) == 1 for scale in each.scales)
    }
    lacking = {
        name: tuple(each for each in items if name not in alone or (name, each) not in asked)
        for name, items in imported.not_asked.items()
    }
    imported.not_asked = {name: items for name, items in lacking.items() if items}
    people = [administration.participant for _, administration in imported.responses]
    people += [rating.administration.participant for rating in imported.ratings]
    people += [end.administration.participant for end in imported.ends]
    answered = dict.fromkeys(people)
    silent = [name for name in imported.participants if name not in answered]
    imported.silent = silent
    if silent:
        shown = ", ".join(silent[:5]) + (" …" if len(silent) > 5 else "")
        imported.notes.append(f"{len(silent)} participants have no answers: {shown}")
    for name in answered:
        imported.participants.setdefault(name, {})
    imported.notes += suspects(imported.participants)
