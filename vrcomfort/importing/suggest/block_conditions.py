"""Finds the conditions of several questionnaires in a row that their headings do not say.

They stand in a column beside each block, or in one column that gives them in their order.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from itertools import pairwise
from typing import Literal, NamedTuple, TypeAlias

from vrcomfort.csv_table import plain_digits
from vrcomfort.importing.answers import number
from vrcomfort.importing.files import is_number
from vrcomfort.importing.row_facts import conditions_in
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.cells import (
    LONGEST_CONDITION,
    MOST_CONDITIONS,
    is_numeric,
    texts,
    values_of,
)
from vrcomfort.importing.suggest.found_answers import Found, FoundAnswers
from vrcomfort.importing.suggest.vocabulary import Known, LabVocabulary, tokens
from vrcomfort.questionnaire import plain

FARTHEST = 6
"""Columns between a block and the condition beside it."""
_FEWEST_ROWS = 8
Counted: TypeAlias = Literal["trial", "session", "period"]
_COUNTED: tuple[Counted, ...] = ("trial", "session", "period")


def numbered_conditions(table: SourceTable, vocabulary: LabVocabulary) -> dict[int, int]:
    """Return number → column of ``Condition_1``, ``Condition_2`` …; nothing where there is one.

    Columns with another name are these if each row has the same texts, in another order.
    """
    said = vocabulary.fact_words.get("condition", frozenset())
    found: dict[int, int] = {}
    for column, heading in enumerate(table.headings):
        words = tokens(heading)
        named = len(words) == 2 and words[1].isdecimal() and words[0] in said
        if named and 0 < len(texts(table, column)) <= MOST_CONDITIONS:
            found.setdefault(int(words[1]), column)
    return found if len(found) > 1 else _permuted(table, vocabulary)


def _permuted(table: SourceTable, vocabulary: LabVocabulary) -> dict[int, int]:
    """Return number → column of ``film1`` …, if rows have the same films in other orders.

    What people rank first is not what they saw first: ``Rank 1`` is no condition.
    """
    series: dict[tuple[str, ...], dict[int, int]] = defaultdict(dict)
    numbers: Counter[int] = Counter()
    for column, words in enumerate(map(tokens, table.headings)):
        numbers.update({*numbers_in_words(words)})
        if (place := number_in_words(words)) is not None:
            rest = tuple(word for word in words if not word.isdecimal())
            series[rest].setdefault(place, column)
    for found in (own for words, own in series.items() if not {*words} & vocabulary.asking_others):
        rows = [tuple(row[c] for c in found.values()) for row in table.rows]
        orders = Counter(row for row in rows if all(row))
        sets = Counter(frozenset(row) for row in orders.elements())
        same, often = sets.most_common(1)[0] if len(orders) > 1 else (frozenset(), 0)
        ranks = {*map(str, range(1, len(found) + 1))}
        beside = all(numbers[n] > 1 for n in found) and len(same) == len(found) > 2
        if beside and often >= _NEARLY_ALL * len(rows) and same != ranks:
            return found
    return {}


def without_levels(
    table: SourceTable, found: FoundAnswers, vocabulary: LabVocabulary
) -> tuple[str, ...]:
    """Return the words of headings without those of levels that all such records have: ``runs``.

    The name of a condition is one that others stand beside: ``gaze.ssq`` and ``walk.ssq``.
    """
    if not table.nested:
        return found.context
    paths = [heading.split(".") for heading in table.headings]
    places = Counter((*path[:n], None, *path[n + 1 :]) for path in paths for n in range(len(path)))
    levels: set[str] = set()
    for path in (paths[column] for column in found.columns):
        alone = (n for n in range(len(path) - 1) if places[*path[:n], None, *path[n + 1 :]] == 1)
        levels.update(word for n in alone for word in tokens(path[n]))
    said = vocabulary.timepoints
    return tuple(w for w in found.context if w not in levels or w in said or w.isdecimal())


def before_exposures(
    table: SourceTable, found: FoundAnswers, said: Mapping[str, str], facts: Mapping[str, object]
) -> dict[str, str]:
    """Return blanks for facts of exposures whose records a baseline stands outside of."""
    headings = [table.headings[column] for column in found.columns]
    blank = {}
    for fact in ("condition", *_COUNTED):
        where = facts.get(fact)
        name = where.get("column") if isinstance(where, Mapping) else None
        level = name.rpartition(".")[0] if isinstance(name, str) else ""
        if table.nested and level and not any(h.startswith(f"{level}.") for h in headings):
            blank[fact] = ""
    return blank if said.get("timepoint") == "baseline" else {}


def number_in_words(words: Sequence[str]) -> int | None:
    """Return the only number among words."""
    numbers = numbers_in_words(words)
    return numbers[0] if len(numbers) == 1 else None


def numbers_in_words(words: Sequence[str]) -> list[int]:
    """Return the numbers among words."""
    return [int(plain_digits(word)) for word in words if word.isascii() and word.isdecimal()]


def fitting(
    numbers: Sequence[int | None], conditions: Mapping[int, int]
) -> list[int | None] | None:
    """Return the column of the condition of each numbered administration, or None for all.

    All have one but perhaps the first, which is a baseline.
    """
    known = [number for number in numbers if number is not None]
    others = {*known} - {*conditions}
    first = len(others) <= 1 and all(each < min(conditions, default=0) for each in others)
    if not conditions or len(known) < len(numbers) or {*conditions} - {*known} or not first:
        return None
    return [conditions.get(number) for number in known]


class Ordered(NamedTuple):
    """A column that gives the conditions of the blocks of a row in their order.

    Parameters
    ----------
    by
        The fact that numbers the blocks.
    """

    column: int
    by: Counted


def conditions_beside(
    table: SourceTable, blocks: Sequence[Found], taken: Set[int], vocabulary: LabVocabulary
) -> list[int | None]:
    """Return for each block the column of its condition, or None; no column for any if none fits.

    The columns stand equally far before (or after) their blocks; the first block may have none, as
    it is often a baseline.
    """
    if len(blocks) < 2:
        return []
    free = {c for c in range(len(table.headings)) if c not in taken}

    def names(column: int, block: Found) -> bool:
        return _names(table, column, vocabulary) and _is_said(table, column, block)

    for distance in range(1, FARTHEST + 1):
        before = [block.columns[0] - distance for block in blocks]
        after = [block.columns[-1] + distance for block in blocks]
        for places in (before, after):
            beside = zip(places, blocks, strict=True)
            columns = [c if c in free and names(c, block) else None for c, block in beside]
            for first in (columns[0], None):
                found = [first, *columns[1:]]
                rest = found if first is not None else found[1:]
                if None not in rest and len(rest) > 1 and _are_alike(table, rest):
                    return found
    return []


def _names(table: SourceTable, column: int, vocabulary: LabVocabulary) -> bool:
    """Return whether a column has a few texts that may be names of conditions."""
    words = texts(table, column)
    few = 0 < len(words) <= MOST_CONDITIONS and max(map(len, words)) <= 2 * LONGEST_CONDITION
    said_no = all({*map(plain, tokens(word))} & vocabulary.yes_no for word in words)
    numbers = all(map(is_number, words))
    when = all(vocabulary.timepoint(word) for word in words)
    return few and not said_no and not numbers and not when


def _is_said(table: SourceTable, column: int, block: Found) -> bool:
    """Return whether nearly all rows with answers have a text: remarks are often blank."""
    answered = [row for row in table.rows if any(row[c] for c in block.columns)]
    return sum(bool(row[column]) for row in answered) >= _NEARLY_ALL * len(answered)


_NEARLY_ALL = 0.9


def _are_alike(table: SourceTable, columns: Sequence[int | None]) -> bool:
    """Return whether columns share their texts, and differ from each other within a row."""
    found = [column for column in columns if column is not None]
    sets = [{*texts(table, column)} for column in found]
    differ = any(len({row[c] for c in found if row[c]}) > 1 for row in table.rows)
    few = 2 <= len(set.union(*sets)) <= MOST_CONDITIONS
    return few and differ and all(one & other for one in sets for other in sets)


def order_column(
    table: SourceTable, columns: Sequence[int], facts: Sequence[Mapping[str, str]]
) -> Ordered | None:
    """Return the column that gives the conditions of numbered blocks in their order."""
    for by in ("condition", *_COUNTED):
        numbers = sorted({each[by] for each in facts if each.get(by, "").isdecimal()})
        if len(numbers) < 2 or [*map(int, numbers)] != list(range(1, len(numbers) + 1)):
            continue
        for column in columns:
            orders = texts(table, column)
            parts = [sorted(conditions_in(order)) for order in orders]
            permuted = len(orders) > 1 and all(part == parts[0] for part in parts)
            if permuted and len({*parts[0]}) == len(parts[0]) == len(numbers):
                return Ordered(column, next((each for each in _COUNTED if each == by), "trial"))
    return None


def _repeated(table: SourceTable, blocks: Sequence[Found]) -> list[Found]:
    """Return the blocks that say the same as others.

    Labs sort the answers of each row by condition, and keep them in their order beside.
    """
    numbered = [b for b in blocks if any(word.isdecimal() for word in b.context)]
    named = [b for b in blocks if b not in numbered]
    for extra in (0, 1):  # a baseline stands beside the named ones
        others = named[extra:] if extra else named
        if len(numbered) > 1 and len(numbered) == len(others) and _same(table, numbered, others):
            return numbered
    return []


def _said_in_words(table: SourceTable, blocks: Sequence[Found]) -> list[int]:
    """Return all columns of numbers behind words: ``Nausea Quantised`` behind ``… Response``."""
    ends: dict[tuple[str, str], list[int]] = defaultdict(list)
    for column, (one, two) in enumerate(pairwise(map(tokens, table.headings)), start=1):
        if len(two) > 1 and one[:-1] == two[:-1] and not two[-1].isdecimal():
            ends[one[-1], two[-1]].append(column)
    for columns in ends.values():
        worded = {column - 1 for column in columns if not is_numeric(table, column - 1)}
        known = any({*block.columns} <= worded for block in blocks)
        if known and all(_says_again(table, column, column - 1) for column in columns):
            return columns
    return []


def _says_again(table: SourceTable, column: int, other: int) -> bool:
    """Return whether numbers stand for the texts of another column, one to one."""
    pairs = {(row[other], row[column]) for row in table.rows if row[other] and row[column]}
    one_to_one = len(dict(pairs)) == len(pairs) == len({b for _, b in pairs})
    return one_to_one and all(map(is_number, texts(table, column)))


def _recoded(table: SourceTable, blocks: Sequence[Found]) -> list[Found]:
    """Return blocks that say the answers of others, or of some items, in other numbers.

    Labs put ``SP2_r``, the highest answer less SP2, beside it, or 0 to 4 beside 1 to 5.
    """
    return [b for b in blocks if any(_is_recoded(table, b, other) for other in blocks)]


def _is_recoded(table: SourceTable, block: Found, other: Found) -> bool:
    if block.instrument != other.instrument or not {*block.items} <= {*other.items}:
        return False
    columns = [(named.column, other.items[item].column) for item, named in block.items.items()]
    some = len(block.items) < len(other.items)
    made = some or _beside_scale(table, block) > _beside_scale(table, other)
    few = len(table.rows) < _FEWEST_ROWS  # two conditions may go together by chance
    by_chance = few or all(len(texts(table, column)) <= 2 for column, _ in columns)
    return made and not by_chance and all(_says_again(table, *pair) for pair in columns)


def _beside_scale(table: SourceTable, block: Found) -> int:
    low, high = block.instrument.low, block.instrument.high
    return sum(not low <= v <= high for c in block.columns for v in values_of(table, c))


def _products(table: SourceTable, blocks: Sequence[Found]) -> list[Found]:
    """Return the blocks of answers times weights.

    The weights of a task load index are 0 to 5, so its products exceed the highest rating.
    """
    return [
        block
        for block in blocks
        if any(scale.weights_sum for scale in block.instrument.scales)
        and _are_products([v for c in block.columns for v in values_of(table, c)], block)
    ]


def _weights(table: SourceTable, blocks: Sequence[Found]) -> list[Found]:
    """Return the blocks of answers to comparisons of the items: they have one sum in each row.

    The weights of the task load index stand in a sheet of their own, under its items' names.
    """
    return [block for block in blocks if _sums(table, block, _weights_of(block))]


A_WEIGHT, A_PRODUCT = "a weight, or the name of an item", "an answer times its weight"


def without_made(table: SourceTable, blocks: Sequence[Found]) -> tuple[list[Found], dict[int, str]]:
    """Return the blocks of answers; and column → what it is, of those made of others."""
    columns: dict[int, str] = {}
    for what, find in (
        (A_PRODUCT, _products),
        (A_WEIGHT, _weights),
        ("the same answers, by their order", _repeated),
        ("the same answers, recoded", _recoded),
    ):
        made = find(table, blocks)
        columns |= {column: what for block in made for column in block.columns}
        blocks = [block for block in blocks if block not in made]
        if find is _products:
            blocks = _with_weights(blocks, table)
    columns |= dict.fromkeys(_said_in_words(table, blocks), "the same answers, in numbers")
    blocks = [block for block in blocks if not {*block.columns} <= columns.keys()]
    there = {column for block in blocks for column in block.columns}
    kept = [replace(b, siblings=tuple(c for c in b.siblings if c in there)) for b in blocks]
    return kept, columns


def comparisons(table: SourceTable, known: Known) -> list[int]:
    """Return the columns of choices between items, such as the pairs of the task load index.

    Every cell is the name of an item, as no answer is. Records may list the items, too.
    """
    chosen = [{*map(plain, texts(table, c))} for c in range(len(table.headings))]
    found: list[int] = []
    for instrument in known.instruments:
        names = {*known.vocabulary.spellings(instrument)}
        if any(scale.weights_sum for scale in instrument.scales):
            names |= {*known.vocabulary.initials(instrument)}
        columns = [c for c, words in enumerate(chosen) if words and words <= names]
        found += columns if len(columns) >= _FEWEST_CHOICES else []
    return found


_FEWEST_CHOICES = 3
"""Columns of item names; one or two name the items of a long table."""


def _with_weights(blocks: Sequence[Found], table: SourceTable) -> list[Found]:
    """Take blocks whose rows sum to the number of comparisons for the weights of those before."""
    kept: list[Found] = []
    for block in blocks:
        weights = _weights_of(block)
        if not kept or kept[-1].instrument != block.instrument or not _sums(table, block, weights):
            kept.append(block)
            continue
        named = {weights[item]: named for item, named in block.items.items() if item in weights}
        own = {i: n for i, n in kept[-1].items.items() if i not in weights.values()}
        kept[-1] = replace(kept[-1], items={**own, **named})
    return kept


def _weights_of(block: Found) -> dict[str, str]:
    """Return item → the item that is its weight; nothing where the instrument has none."""
    return dict(pair for scale in block.instrument.scales for pair in scale.weights)


def _sums(table: SourceTable, block: Found, weights: Mapping[str, str]) -> bool:
    """Return whether most rows of a block sum to the number of comparisons."""
    columns = [named.column for item, named in block.items.items() if item in weights]
    total = max((scale.weights_sum for scale in block.instrument.scales), default=0)
    if not weights or len(columns) < len(weights):
        return False
    rows = [[number(row[c], table.decimal) for c in columns] for row in table.rows]
    full = [[v for v in row if v is not None] for row in rows if None not in row]
    fit = sum(sum(row) == total and max(row) <= _MOST_CHOSEN for row in full)
    return bool(full) and fit * 10 >= len(full) * 8


_MOST_CHOSEN = 5
"""Of 15 comparisons, each of six scales is in five."""


def _are_products(values: Sequence[float], block: Found) -> bool:
    """Return whether values can be ratings times weights: at most five times the highest one."""
    high = block.instrument.high
    above = sum(value > high for value in values)
    inside = min(values, default=-1) >= 0 and max(values) <= _MOST_CHOSEN * high
    return inside and 0 < len(values) <= above * _RARE


_RARE = 20
"""A few values beyond the highest rating are typing errors."""


def _same(table: SourceTable, one: Sequence[Found], other: Sequence[Found]) -> bool:
    def answers(row: tuple[str, ...], block: Found) -> tuple[str, ...]:
        return tuple(row[block.items[item].column] for item in sorted(block.items))

    return all(
        sorted(answers(row, block) for block in one)
        == sorted(answers(row, block) for block in other)
        for row in table.rows
    )
