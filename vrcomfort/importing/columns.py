"""Finds the columns that a mapping names in one table, and reads the facts of its rows."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches

from vrcomfort.importing.answers import number
from vrcomfort.importing.mapping import (
    FACTS,
    TIMES,
    Leaving,
    Questionnaire,
    Scores,
    TableMapping,
    template_pattern,
    texts_of,
)
from vrcomfort.importing.source import SourceTable, one_line
from vrcomfort.questionnaire import Instrument, plain, shipped_instruments
from vrcomfort.settings import did_you_mean


@dataclass(frozen=True)
class Block:
    """Columns of one administration of a questionnaire, or of its scores.

    Parameters
    ----------
    facts
        What the heading and the mapping say of the administration.
    columns
        Index of the column → item (or scale).
    where
        Index of a column → texts that a row has to have there.
    item_column, response_column, time_column
        Indices, in long tables.
    words
        In long tables, text in the item column → item.
    onset_s
        When the rating of these columns was given, where their headings say it.
    beside
        Fact → index of the column that says it of these columns alone.
    """

    source: Questionnaire | Scores
    instrument: Instrument
    facts: dict[str, str]
    columns: dict[int, str]
    where: dict[int, tuple[str, ...]]
    item_column: int | None = None
    response_column: int | None = None
    time_column: int | None = None
    words: dict[str, str] = field(default_factory=dict)
    onset_s: float | None = None
    beside: dict[str, int] = field(default_factory=dict)


class Columns:
    """The columns of a table, by their use in the mapping."""

    def __init__(
        self, table: SourceTable, mapping: TableMapping, known: Mapping[str, Instrument]
    ) -> None:
        self._table = table
        self._known = known
        self._index = {heading: index for index, heading in enumerate(table.headings)}
        self._mapping = mapping
        self._used: dict[int, str] = {}
        self.facts = {
            name: [self.index(c, f"{name}") for c in columns]
            for name in FACTS
            if (columns := _columns_of(mapping, name))
        }
        order = mapping.condition.order
        self.order = None if order is None else self.index(order, "condition.order")
        self.participants = {
            name: self.index(column, f"participants.{name}")
            for name, column in mapping.participants.items()
        }
        self.leave_out = {
            self.index(column, "leave_out"): texts_of(texts)
            for column, texts in mapping.leave_out.items()
        }
        self._placed = self._placed_columns()
        self._ignored = {i for heading in mapping.ignore for i in self._named(heading)}
        self.blocks = [b for each in mapping.questionnaires for b in self._blocks(each)]
        self.left_at = self._left_at(mapping.left_at)
        self.scores = [block for each in mapping.scores for block in self._blocks(each)]
        self._suspicious = {
            item: heading
            for block in self.blocks
            for item, heading in self._passed_over(block).items()
        }
        self._ignore()

    def _placed_columns(self) -> set[int]:
        """Return the indices of answers that are known by their place, from `first_columns` on."""
        found = set()
        for each in self._mapping.questionnaires:
            order = each.item_order or [item.name for item in self._instrument(each).asked]
            for first in filter(None, map(self._index.get, map(one_line, each.first_columns))):
                found |= {first + place for place, item in enumerate(order) if item}
        return found

    def _named(self, text: str) -> Iterable[int]:
        """Return the indices of the columns of a heading, ``first … last``, or a pattern."""
        first, _, last = text.partition(" … ")
        heading, start, end = (self._index.get(one_line(each)) for each in (text, first, last))
        if heading is not None:
            return [heading]
        if start is not None and end is not None:
            return range(start, end + 1)
        pattern = template_pattern(text.replace("*", "{*}"))
        wild = "*" in text and text != "*"  # another file of the table may have it
        return [i for i, h in enumerate(self._table.headings) if wild and pattern.fullmatch(h)]

    @property
    def of_answers(self) -> tuple[int, ...]:
        """Return the indices of the columns of answers and scores, and of the times of ratings."""
        blocks = (*self.blocks, *self.scores)
        single = [c for block in blocks for c in (block.response_column, block.time_column)]
        columns = (*single, *(c for block in blocks for c in block.columns))
        return tuple(c for c in dict.fromkeys(columns) if c is not None)

    @property
    def suspicions(self) -> list[str]:
        """Return a sentence for each item that was not asked, though a column looks like it."""
        return [
            f"{self._table.name}: {item} was not asked, as the mapping says, but the column "
            f"{heading!r} looks like it"
            for item, heading in self._suspicious.items()
        ]

    def _passed_over(self, block: Block) -> dict[str, str]:
        if not isinstance(block.source, Questionnaire) or block.item_column is not None:
            return {}
        return self.looks_like(block.instrument, block.source.not_asked)

    def index(self, heading: str, key: str) -> int:
        """Return the index of a column, and note its use."""
        name = one_line(heading)
        if name not in self._index:
            near = get_close_matches(name, self._index, n=1, cutoff=0.6)
            hint = f"; did you mean `{near[0]}`?" if near else ""
            message = f"the mapping's {key} names a column that is not there{hint}"
            raise self._table.fault(message, column=heading)
        self._used.setdefault(self._index[name], key)
        return self._index[name]

    def use_of(self, index: int) -> str:
        """Return the key of the mapping that a column is used by; nothing if it is ignored."""
        return self._used.get(index, "")

    def _instrument(self, source: Questionnaire | Scores) -> Instrument:
        name = source.instrument
        if name not in self._known:
            hint = did_you_mean(name, self._known)
            raise self._table.fault(f"there is no instrument {name!r} in vrcomfort; {hint}")
        return self._known[name]

    def _take(self, index: int, what: str, *, some_rows: bool = False) -> None:
        """Note that a column holds answers, which no other questionnaire may take in these rows."""
        if some_rows and self._used.setdefault(index, "scores of some rows") == (
            "scores of some rows"
        ):
            return
        if index in self._used:
            message = f"is taken twice, for {self._used[index]} and for {what}; keep one"
            raise self._table.fault(message, column=index)
        self._used[index] = what

    def _left_at(self, leaving: Leaving | None) -> dict[int, dict[str, str]]:
        """Return the index of each column of leaving times → what its heading says."""
        if leaving is None:
            return {}
        pattern = template_pattern(leaving.heading)
        matches = ((i, pattern.fullmatch(h)) for i, h in enumerate(self._table.headings))
        found = {index: match.groupdict() for index, match in matches if match is not None}
        if not found:
            message = f"no heading matches the mapping's left_at, {leaving.heading!r}"
            raise self._table.fault(message)
        for index in found:
            self._take(index, "left_at")
        return found

    def _blocks(self, source: Questionnaire | Scores) -> list[Block]:
        instrument = self._instrument(source)
        where = {
            self.index(column, "where"): texts_of(texts) for column, texts in source.where.items()
        }
        if isinstance(source, Questionnaire) and source.first_columns:
            return [
                self._placed_block(source, instrument, where, place, first)
                for place, first in enumerate(source.first_columns)
            ]
        beside = self._beside(source, 0)
        if isinstance(source, Questionnaire) and source.item_column is not None:
            return [replace(self._long_block(source, instrument, where), beside=beside)]
        pieces = self._pieces(source, instrument)
        pattern = re.compile(source.pattern) if source.pattern else template_pattern(source.heading)
        found: dict[tuple[tuple[str, str], ...], dict[int, str]] = {}
        lost: list[str] = []
        taken = self._placed | self._ignored
        for index, heading in enumerate(self._table.headings):
            match = pattern.fullmatch(heading)
            if match is None:
                continue
            captured = match.groupdict()
            item = self._item(captured.pop("item", None), pieces, instrument)
            if item is None:
                continue
            if index in taken:
                lost.append(item)
                continue
            facts = {name: text for name, text in captured.items() if text is not None}
            columns = found.setdefault(tuple(sorted(facts.items())), {})
            if item in columns.values():
                other = next(i for i, each in columns.items() if each == item)
                message = f"is a second column for {item}, beside {self._table.headings[other]!r}"
                raise self._table.fault(f"{message}; keep one", column=index)
            partly = isinstance(source, Scores) and bool(source.where)
            self._take(index, f"{instrument.name} {item}", some_rows=partly)
            columns[index] = item
        time = getattr(source, "time", None)
        time_column = self.index(time, "time") if time else None
        if lost and not found:
            return []
        if isinstance(source, Questionnaire) and source.instrument not in shipped_instruments():
            items = {item: text for item, text in source.items.items() if item not in lost}
            said = {"items": items, "not_asked": (*source.not_asked, *lost)}
            source = source.model_copy(update=said)
        self._require_items(source, instrument, found)
        return [
            Block(
                source,
                instrument,
                {**{n: t for n, t in facts if n not in TIMES}, **source.constants()},
                columns,
                where,
                time_column=time_column,
                onset_s=self._onset_s(dict(facts)),
                beside=beside,
            )
            for facts, columns in found.items()
        ]

    def _item(self, piece: str | None, pieces: _Pieces, instrument: Instrument) -> str | None:
        """Return the item of a heading; that of an instrument of one item need not be said."""
        if piece is not None:
            return pieces(piece)
        if len(instrument.asked) > 1:
            message = f"the headings of {instrument.name} have to say the item; write {{item}}"
            raise self._table.fault(message)
        return instrument.asked[0].name

    def _onset_s(self, facts: Mapping[str, str]) -> float | None:
        """Return the seconds that a heading says."""
        for name, seconds in (("time_s", 1.0), ("time_min", 60.0)):
            if name in facts:
                value = number(facts[name], self._table.decimal)
                if value is None:
                    message = f"{facts[name]!r} in a heading is no number, as {name} is"
                    raise self._table.fault(message)
                return value * seconds
        return None

    def _placed_block(
        self,
        source: Questionnaire,
        instrument: Instrument,
        where: dict[int, tuple[str, ...]],
        number: int,
        heading: str,
    ) -> Block:
        """Return the answers that stand side by side from a column on."""
        first = self.index(heading, "first_columns")
        if self._used[first] == "first_columns":
            del self._used[first]
        order = source.item_order or tuple(item.name for item in instrument.asked)
        if first + len(order) > len(self._table.headings):
            message = f"has only {len(self._table.headings) - first} columns from here on, for"
            raise self._table.fault(f"{message} {len(order)} items", column=first)
        for place, item in enumerate(order, start=first):
            self._take(place, f"{instrument.name} {item}" if item else "no item")
        columns = {place: item for place, item in enumerate(order, start=first) if item}
        if not source.item_order:
            self._require_items(source, instrument, {(): columns})
        beside = self._beside(source, number)
        facts = source.constants(number)
        return Block(source, instrument, facts, columns, where, beside=beside)

    def _beside(self, source: Questionnaire | Scores, number: int) -> dict[str, int]:
        """Return fact → index of the column that says it of one of a source's questionnaires."""
        named = {fact: texts_of(columns) for fact, columns in source.beside.items()}
        chosen = {fact: each[number if len(each) > 1 else 0] for fact, each in named.items()}
        return {f: self.index(name, f"beside.{f}") for f, name in chosen.items() if name}

    def _long_block(
        self, source: Questionnaire, instrument: Instrument, where: dict[int, tuple[str, ...]]
    ) -> Block:
        item_column = self.index(source.item_column or "", "item_column")
        response_column = self.index(source.response_column or "", "response_column")
        texts = dict.fromkeys(self._table.column(item_column))
        pieces = self._pieces(source, instrument)
        words = {text: item for text in texts if (item := pieces(text)) is not None}
        time_column = self.index(source.time, "time") if source.time else None
        return Block(
            source, instrument, source.constants(), {}, where,
            item_column, response_column, time_column, words,
        )  # fmt: skip

    def _pieces(self, source: Questionnaire | Scores, instrument: Instrument) -> _Pieces:
        if isinstance(source, Scores):
            return _Pieces({name: (piece,) for name, piece in source.scales.items()}, None)
        items = {item: texts_of(texts) for item, texts in source.items.items()}
        return _Pieces(items, None if items else instrument)

    def _require_items(
        self,
        source: Questionnaire | Scores,
        instrument: Instrument,
        found: Mapping[tuple[tuple[str, str], ...], dict[int, str]],
    ) -> None:
        """Raise `InputError` where a questionnaire lacks items that it does not say it lacks."""
        said = source.scales if isinstance(source, Scores) else source.items
        if not found:
            shown = source.pattern or source.heading
            message = f"no heading is made as the mapping's {shown!r} has it, for"
            raise self._table.fault(f"{message} {instrument.name}")
        for facts, columns in found.items():
            named = ", ".join(text for _, text in facts) or instrument.name
            if any(name in TIMES for name, _ in facts):
                continue
            absent = [name for name in said if name not in columns.values()]
            if absent:
                raise self._table.fault(f"there is no column for {absent[0]} of {named}")
            if isinstance(source, Questionnaire):
                silent = [
                    item.name
                    for item in instrument.asked
                    if item.name not in columns.values() and item.name not in source.not_asked
                ]
                if silent:
                    names = ", ".join(silent)
                    message = f"{named} has no column for {names}{self._hint(instrument, silent)}"
                    cure = "give them under items, or under not_asked if they were not asked"
                    raise self._table.fault(f"{message}; {cure}")

    def _hint(self, instrument: Instrument, items: Sequence[str]) -> str:
        """Return the headings that look like items, misspelt."""
        found = self.looks_like(instrument, items)
        shown = ", ".join(f"{heading!r} looks like {item}" for item, heading in found.items())
        return f", but {shown}" if shown else ""

    def looks_like(self, instrument: Instrument, items: Sequence[str]) -> dict[str, str]:
        """Return item → the heading of a column without use that is almost its name."""
        free = {
            plain(heading): heading
            for index, heading in enumerate(self._table.headings)
            if index not in self._used and plain(heading)
        }
        return nearly_named(instrument, items, free)

    def _ignore(self) -> None:
        """See that every column is said something of."""
        for index in self._ignored:
            self._used.setdefault(index, "ignore")
        if "*" in self._mapping.ignore:
            return
        unsaid = [h for i, h in enumerate(self._table.headings) if i not in self._used]
        if unsaid:
            others = f" (and {', '.join(unsaid[1:])})" if unsaid[1:] else ""
            message = f"is neither mapped nor listed under ignore{others}; say what it is"
            raise self._table.fault(message, column=unsaid[0])


class _Pieces:
    """Which item a piece of a heading (or a text of a long file) means."""

    def __init__(self, items: Mapping[str, tuple[str, ...]], instrument: Instrument | None) -> None:
        self._exact = {one_line(t): item for item, texts in items.items() for t in texts}
        self._plain = {plain(text): item for text, item in self._exact.items() if plain(text)}
        self._instrument = instrument

    def __call__(self, piece: str) -> str | None:
        """Return the item, or None."""
        text = one_line(piece)
        if self._instrument is not None:
            found = self._instrument.item(text)
            asked = self._instrument.asked
            if found is None and text.isdecimal() and 0 < int(text) <= len(asked):
                found = asked[int(text) - 1]  # numbers are of the published order
            return found.name if found else None
        return self._exact.get(text) or self._plain.get(plain(text))


ALMOST = 0.85
"""Similarity from which a text counts as another one misspelt."""


def nearly_named(
    instrument: Instrument, items: Sequence[str], texts: Mapping[str, str]
) -> dict[str, str]:
    """Return item → the text that is almost one of its names.

    Parameters
    ----------
    texts
        `plain` text → text.
    """
    found = {}
    for item in instrument.items:
        near = (get_close_matches(key, texts, n=1, cutoff=ALMOST) for key in item.keys)
        match = next((each[0] for each in near if each), None)
        if item.name in items and match is not None:
            found[item.name] = texts[match]
    return found


def _columns_of(mapping: TableMapping, fact: str) -> tuple[str, ...]:
    found = mapping.fact(fact)
    return (found.column,) if found.column is not None else found.columns
