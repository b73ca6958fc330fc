"""Puts columns of items together that are one questionnaire of one moment."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.headings import Named, initials, mentions, named_items, tokens
from vrcomfort.questionnaire import Instrument

FEWEST = 4
"""So many items of an instrument, or all it has, make a questionnaire."""

Context = tuple[str, ...]


@dataclass
class Found:
    """Columns that are one questionnaire.

    Parameters
    ----------
    context
        The words that its headings share, but for those that name the instrument.
    items
        Item → index of its column.
    """

    instrument: Instrument
    context: Context
    items: dict[str, Named]

    @property
    def columns(self) -> list[int]:
        """Return the indices of its columns, in the order of the file."""
        return sorted(named.column for named in self.items.values())

    @property
    def absent(self) -> list[str]:
        """Return the items that have no column."""
        return [item.name for item in self.instrument.asked if item.name not in self.items]


def find_blocks(table: SourceTable, known: Sequence[Instrument]) -> list[Found]:
    """Return the questionnaires that the headings of a table name, no column twice.

    By the names of the items, else by their numbers, else (where there are no headings) by where
    the answers stand.
    """
    by_name = [b for i in known for b in _by_name(table, i)]
    found = _best(table, by_name, known)
    taken = {column for block in found for column in block.columns}
    by_number = [b for i in known for b in _by_number(table, i, taken)]
    found += _best(table, by_number, known)
    taken = {column for block in found for column in block.columns}
    by_initials = [b for i in known for b in _by_initials(table, i, taken)]
    found += _best(table, by_initials, known)
    if not found and not table.reading.heading_rows:
        found = _by_position(table, known)
    return sorted(found, key=lambda block: block.columns)


def _by_name(table: SourceTable, instrument: Instrument) -> list[Found]:
    if len(instrument.asked) == 1:
        return []
    named = [
        each
        for index, (heading, label) in enumerate(zip(table.headings, table.labels, strict=True))
        if (each := named_items(index, heading, label, instrument)) is not None
    ]
    contexts = _contexts(named, instrument)
    groups: dict[Context, dict[str, Named]] = defaultdict(dict)
    for each, context in zip(named, contexts, strict=True):
        groups.setdefault(_free(groups, context, each), {})[each.item] = each
    return [Found(instrument, context, items) for context, items in groups.items()]


def _free(groups: dict[Context, dict[str, Named]], context: Context, each: Named) -> Context:
    """Return the context, with a number if its item has a column that is as good already."""
    rank = ("name", "near", "abbreviation")
    key, number = context, 1
    while key in groups and each.item in groups[key]:
        there = groups[key][each.item]
        if rank.index(each.how) < rank.index(there.how):
            groups[key][each.item] = each  # the other is left to be asked about
            return key
        if rank.index(each.how) > rank.index(there.how):
            return (*context, "?")
        number += 1
        key = (*context, str(number))
    return key


def _contexts(named: Sequence[Named], instrument: Instrument) -> list[Context]:
    """Return for each heading the words that it shares with those of other items."""
    numbered = _item_numbers(named)
    rests = [
        [
            word
            for side, words in (("before", each.before), ("after", each.after))
            for place, word in _placed(side, words)
            if (side, place) not in numbered
        ]
        for each in named
    ]
    items_with: dict[str, set[str]] = defaultdict(set)
    for each, rest in zip(named, rests, strict=True):
        for word in rest:
            items_with[word].add(each.item)
    items = len({each.item for each in named})
    shared = {word for word, found in items_with.items() if len(found) * 2 >= items}
    own = set(tokens(instrument.name))
    return [tuple(word for word in rest if word in shared and word not in own) for rest in rests]


def _placed(side: str, words: Sequence[str]) -> list[tuple[int, str]]:
    """Return words with how far they stand from the item's name."""
    if side == "after":
        return list(enumerate(words, start=1))
    return [(len(words) - place, word) for place, word in enumerate(words)]


def _item_numbers(named: Sequence[Named]) -> set[tuple[str, int]]:
    """Return the places in headings where the number of the item stands: another for each."""
    numbers: dict[tuple[str, int], dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for each in named:
        for side, words in (("before", each.before), ("after", each.after)):
            for place, word in _placed(side, words):
                if word.isdecimal():
                    numbers[side, place][each.item].add(word)
    items = len({each.item for each in named})
    return {
        place
        for place, found in numbers.items()
        if len(found) * 2 > items
        and len({min(each) for each in found.values()}) * 5 >= len(found) * 4 > 8
    }


def _best(table: SourceTable, found: Sequence[Found], known: Sequence[Instrument]) -> list[Found]:
    """Return the questionnaires that explain most, none with a column of another."""

    def merit(block: Found) -> tuple[float, ...]:
        whole = len(block.items) / len(block.instrument.asked)
        text = " ".join(table.headings[c] for c in block.columns)
        said = block.instrument.name in mentions(f"{table.file.stem} {table.sheet} {text}", known)
        exact = sum(named.how in {"name", "number"} for named in block.items.values())
        return (said, whole == 1.0, exact + whole)

    kept: list[Found] = []
    taken: set[int] = set()
    for block in sorted(found, key=merit, reverse=True):
        items = {i: named for i, named in block.items.items() if named.column not in taken}
        enough = min(FEWEST, len(block.instrument.asked))
        if len(items) >= enough and _is_worth(block, items):
            kept.append(replace(block, items=items))
            taken.update(named.column for named in items.values())
    return kept


def _is_worth(block: Found, items: dict[str, Named]) -> bool:
    """Return whether what is left is still a questionnaire, and not a few words of another."""
    hows = Counter(named.how for named in items.values())
    sure = hows["name"] + hows["number"] + hows["initials"]
    return len(items) == len(block.items) and sure * 3 >= len(items)


def _by_number(table: SourceTable, instrument: Instrument, taken: set[int]) -> list[Found]:
    """Find ``SSQ1`` … ``SSQ16``: headings that differ in a number alone, from 1 (or 0) on."""
    count = len(instrument.asked)
    if count < FEWEST or not table.reading.heading_rows:
        return []
    groups: dict[tuple[Context, Context], dict[int, int]] = defaultdict(dict)
    for column, heading in enumerate(table.headings):
        words = tokens(heading)
        for place, word in enumerate(words):
            if column not in taken and word.isdecimal() and len(word) < 4:
                key = tuple(words[:place]), tuple(words[place + 1 :])
                groups[key].setdefault(int(word), column)
    found = []
    for (before, after), columns in groups.items():
        first = min(columns)
        whole = sorted(columns) == list(range(first, first + count)) and first in {0, 1}
        if whole and _are_answers(table, list(columns.values())):
            items = {
                item.name: Named(columns[n], instrument.name, item.name, "number", before, after)
                for n, item in enumerate(instrument.asked, start=first)
            }
            own = set(tokens(instrument.name)) | _NUMBERED
            context = tuple(word for word in (*before, *after) if word not in own)
            found.append(Found(instrument, context, items))
    return found


def _by_initials(table: SourceTable, instrument: Instrument, taken: set[int]) -> list[Found]:
    """Find ``SSQ_GD``, ``SSQ_DEO``: initials of at least nine in ten items of an instrument."""
    count = len(instrument.asked)
    known = {**initials(instrument), **_ODD_INITIALS.get(instrument.name, {})}
    own = set(tokens(instrument.name))
    groups: dict[Context, dict[str, Named]] = defaultdict(dict)
    for column, heading in enumerate(table.headings):
        words = [word for word in tokens(heading) if word not in own]
        for place, word in enumerate(words):
            if column not in taken and word in known:
                before, after = tuple(words[:place]), tuple(words[place + 1 :])
                named = Named(column, instrument.name, known[word], "initials", before, after)
                groups[*before, *after].setdefault(known[word], named)
    return [
        Found(instrument, context, items)
        for context, items in groups.items()
        if count >= FEWEST and len(items) * 10 >= count * 9
        if _are_answers(table, [named.column for named in items.values()])
    ]


_ODD_INITIALS = {"ssq": {"es": "eyestrain", "is": "increased_salivation"}}
"""Of what is one word to us."""
_NUMBERED = frozenset(["q", "sq", "item", "question", "i", "frage", "symptom", "no", "nr"])


def _are_answers(table: SourceTable, columns: Sequence[int]) -> bool:
    """Return whether columns hold a few short texts, as those of a questionnaire do."""
    texts = {text for column in columns for text in table.column(column) if text}
    return 0 < len(texts) <= 30 and max(map(len, texts)) <= 40


def _by_position(table: SourceTable, known: Sequence[Instrument]) -> list[Found]:
    """Take the last columns of a table without headings, if they hold small whole numbers."""
    width = len(table.headings)
    for instrument in known:
        count = len(instrument.asked)
        columns = list(range(width - count, width))
        answers = {*instrument.answers.plain, str(instrument.high + 1), ""}
        if FEWEST <= count < width and all(set(table.column(c)) <= answers for c in columns):
            items = {
                item.name: Named(column, instrument.name, item.name, "position", (), ())
                for item, column in zip(instrument.asked, columns, strict=True)
            }
            return [Found(instrument, (), items)]
    return []
