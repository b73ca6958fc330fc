"""Finds names and texts of a mapping that no row of the files has."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from difflib import get_close_matches
from typing import TypeAlias

from vrcomfort.importing.mapping import LabMapping, Questionnaire, TableMapping, texts_of
from vrcomfort.importing.source import SourceTable, one_line
from vrcomfort.questionnaire import Instrument, plain
from vrcomfort.settings import KeyPath, Problem, did_you_mean

Seen: TypeAlias = Set[tuple[str, str]]
"""(heading, text) of cells."""


def texts_in(table: SourceTable, mapping: TableMapping) -> Seen:
    """Return the cells of the columns in which the mapping names texts."""
    named = {one_line(column) for each in mapping.questionnaires for column in _columns(each)}
    named |= {one_line(column) for each in mapping.scores for column in each.where}
    return {
        (heading, text)
        for index, heading in enumerate(table.headings)
        if heading in named
        for text in table.column(index)
    }


def unmatched(
    mapping: LabMapping,
    seen: Sequence[Seen],
    known: Mapping[str, Instrument],
    conditions: Iterable[str],
) -> Iterator[Problem]:
    """Yield names and texts of a mapping that no row has.

    Parameters
    ----------
    seen
        The `texts_in` all files of each table.
    conditions
        Those of the answers.
    """
    there = set(conditions)
    for key in ("condition_labels", "condition_levels"):
        for name in getattr(mapping, key):
            if name not in there:
                message = f"no answer is of a condition `{name}`; {did_you_mean(name, there)}"
                yield Problem((key, name), message)
    for place, (table, cells) in enumerate(zip(mapping.tables, seen, strict=True)):
        if mapping.ignore_sheets and not cells:
            continue  # its sheets are ignored
        for kind, sources in (("questionnaires", table.questionnaires), ("scores", table.scores)):
            for index, each in enumerate(sources):
                path = ("tables", place, kind, index)
                for column, texts in each.where.items():
                    yield from _texts((*path, "where", column), column, texts_of(texts), cells)
                if isinstance(each, Questionnaire) and each.item_column is not None:
                    yield from _items(path, each, known[each.instrument], cells)


def _columns(each: Questionnaire) -> Iterator[str]:
    yield from each.where
    if each.item_column is not None:
        yield each.item_column


def _texts(path: KeyPath, column: str, texts: Iterable[str], cells: Seen) -> Iterator[Problem]:
    there = _of_column(column, cells)
    for text in texts:
        if one_line(text) not in there:
            yield Problem(path, f"no row has `{text}` under {column}; {_near(text, there)}")


def _items(
    path: KeyPath, each: Questionnaire, instrument: Instrument, cells: Seen
) -> Iterator[Problem]:
    """Yield the items of a long questionnaire that no row answers."""
    column = each.item_column or ""
    there = _of_column(column, cells) - {""}
    keys = {plain(text) for text in there} - {""}
    for item, texts in each.items.items():
        if not any(one_line(text) in there or plain(text) in keys for text in texts_of(texts)):
            text = texts_of(texts)[0] if texts_of(texts) else ""
            message = f"no row has `{text}` under {column}; {_near(text, there)}"
            yield Problem((*path, "items", item), message)
    said = {*each.items, *each.not_asked}
    if not each.items:
        found = (instrument.item(text) for text in there)
        said |= {item.name for item in found if item is not None}
    silent = [item.name for item in instrument.asked if item.name not in said]
    if silent:
        message = f"no row answers {', '.join(silent)}; give them under items, or under not_asked"
        yield Problem(path, f"{message} if they were not asked")


def _of_column(column: str, cells: Seen) -> Set[str]:
    return {text for heading, text in cells if heading == one_line(column)}


def _near(text: str, there: Iterable[str]) -> str:
    """Return a hint: the nearest text, else the first ones."""
    known = sorted(set(there) - {""})
    near = get_close_matches(text, known, n=1, cutoff=0.6)
    return f"did you mean `{near[0]}`?" if near else f"it has {', '.join(known[:8]) or 'no text'}"
