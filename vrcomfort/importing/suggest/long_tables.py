"""Finds the columns of tables that have a row for each answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from vrcomfort.importing.headings import is_number
from vrcomfort.importing.source import Grid, SourceTable
from vrcomfort.importing.suggest.headings import How, mentions, named_items, tokens
from vrcomfort.importing.suggest.roles import texts
from vrcomfort.importing.suggest.spellings import spellings
from vrcomfort.importing.suggest.vocabulary import LONG_ITEM, LONG_RESPONSE, SEVERITY
from vrcomfort.questionnaire import Instrument, plain


@dataclass(frozen=True)
class Long:
    """A table with a row for each answer.

    Parameters
    ----------
    items
        Item → text in the item column.
    hows
        Item → how it was found.
    others
        Texts of the item column that are no item.
    instrument_column
        Where the questionnaire is named, and the text there.
    """

    instrument: Instrument
    item_column: int
    response_column: int
    items: dict[str, str]
    hows: dict[str, How]
    others: list[str]
    instrument_column: tuple[int, str] | None


def find_long(table: SourceTable, known: Sequence[Instrument]) -> list[Long]:
    """Return the questionnaires of a long table; none where it is not one."""
    found: list[Long] = []
    for column in range(len(table.headings)):
        words = texts(table, column)
        if not (4 <= len(words) <= 200) or len(table.rows) < len(words):
            continue
        response = _response_column(table, column)
        if response is None:
            continue
        for instrument in known:
            named = _named(table, column, words, instrument, known)
            if named is not None:
                items, hows = named
                others = [word for word in words if word not in items.values()]
                where = _instrument_column(table, instrument, column)
                long = Long(instrument, column, response, items, hows, others, where)
                found.append(long)
        if found:
            return _best(found)
    return []


def stands_on_its_side(grid: Grid, instruments: Sequence[Instrument]) -> bool:
    """Return whether items stand one below the other, and participants side by side."""
    width = max(map(len, grid.rows))
    if grid.named or width < 3 or any(plain(cell) in LONG_RESPONSE for cell in grid.rows[0]):
        return False
    first = [row[0] for row in grid.rows if row[0]]
    others = {cell for row in grid.rows[1:] for cell in row[1:] if cell}
    if len(set(first)) < len(first) or len(others) > 30:
        return False
    for instrument in instruments:
        known = spellings(instrument)
        named = {known[plain(text)] for text in first if plain(text) in known}
        if len(named) >= 4 and len(named) * 2 >= len(first):
            return True
    return False


def _best(found: list[Long]) -> list[Long]:
    """Keep questionnaires that are named in a column of their own, or else the one that fits."""
    named = [long for long in found if long.instrument_column is not None]
    if named:
        return named
    return [
        max(
            found,
            key=lambda long: (len(long.items) / len(long.instrument.asked), -len(long.others)),
        )
    ]


def _named(
    table: SourceTable,
    column: int,
    words: list[str],
    instrument: Instrument,
    known: Sequence[Instrument],
) -> tuple[dict[str, str], dict[str, How]] | None:
    items: dict[str, str] = {}
    hows: dict[str, How] = {}
    for word in words:
        found = named_items(column, word, "", instrument)
        if found is not None and (
            found.item not in items or found.how == "name" != hows[found.item]
        ):
            items[found.item] = word
            hows[found.item] = found.how
    sure = sum(how == "name" for how in hows.values())
    if sure >= min(4, len(instrument.asked)) and len(instrument.asked) > 1:
        return items, hows
    return _numbered(table, column, words, instrument, known)


def _numbered(
    table: SourceTable,
    column: int,
    words: list[str],
    instrument: Instrument,
    known: Sequence[Instrument],
) -> tuple[dict[str, str], dict[str, How]] | None:
    """Find items by numbers, ``1`` … ``16`` or ``SSQ1`` …, in a column that is called item."""
    heading = plain(table.headings[column])
    if heading not in LONG_ITEM and not mentions(" ".join(words[:3]), known):
        return None
    numbers: dict[int, str] = {}
    for word in words:
        digits = [token for token in tokens(word) if token.isdecimal()]
        named = mentions(word, known)
        if len(digits) == 1 and (not named or instrument.name in named):
            numbers.setdefault(int(digits[0]), word)
    count = len(instrument.asked)
    first = min(numbers, default=9)
    if first > 1 or sorted(numbers) != list(range(first, first + count)) or count < 4:
        return None
    items = {item.name: numbers[n] for n, item in enumerate(instrument.asked, start=first)}
    return items, dict.fromkeys(items, "number")


def _response_column(table: SourceTable, item_column: int) -> int | None:
    candidates = [
        column
        for column, heading in enumerate(table.headings)
        if column != item_column and _is_response(table, column, heading)
    ]
    named = [c for c in candidates if _last_word(table.headings[c]) in LONG_RESPONSE]
    return named[0] if named else None


def _last_word(heading: str) -> str:
    """Return a heading, or the inner one of ``outer.inner``."""
    return plain(heading.rsplit(".", 1)[-1])


def _is_response(table: SourceTable, column: int, heading: str) -> bool:
    words = texts(table, column)
    if not words or len(words) > 110:
        return False
    known = sum(is_number(word) or plain(word) in SEVERITY for word in words)
    return known * 2 >= len(words) or _last_word(heading) in LONG_RESPONSE


def _instrument_column(
    table: SourceTable, instrument: Instrument, item_column: int
) -> tuple[int, str] | None:
    for column in range(len(table.headings)):
        if column != item_column:
            words = texts(table, column)
            if len(words) <= 8:
                for word in words:
                    if plain(word) in {
                        plain(instrument.name),
                        plain(instrument.short),
                        plain(instrument.title),
                    }:
                        return column, word
    return None
