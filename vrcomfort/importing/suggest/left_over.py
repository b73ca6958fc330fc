"""Reads the columns that nothing else knows: none that holds numbers is dropped unasked.

A rule for each lab's questions would never end. So what is left over once people, conditions,
moments, items, scores and facts of people are found is taken for what most labs mean by it:
a rating on a usual scale, or a measurement as it stands. One doubt asks about all of a kind.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from math import ceil, floor

from vrcomfort.importing.answers import number
from vrcomfort.importing.made_instruments import MOST
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.answer_scales import (
    FEWEST_ANSWERS,
    is_missing,
    scale_of,
    step_of,
    yes_or_no,
)
from vrcomfort.importing.suggest.cells import (
    is_numeric,
    texts,
    texts_of_people,
    values_of,
    varies_within,
)
from vrcomfort.importing.suggest.codings import missing_codes
from vrcomfort.importing.suggest.draft import CODING, CURIOUS, LEFT, NO_LABEL, OpenDoubt, listed
from vrcomfort.importing.suggest.evidence import Context, is_identifier
from vrcomfort.importing.suggest.found_answers import Found
from vrcomfort.importing.suggest.item_names import How
from vrcomfort.importing.suggest.own_instruments import USUAL, AnswerRange, TakenFor
from vrcomfort.importing.suggest.vocabulary import FEWEST_OF_SENTENCE, LabVocabulary, tokens
from vrcomfort.questionnaire import plain

_MOST_OF_RATING, _FEWEST, _SHOWN = 100, 2, 8
_DEGREES = AnswerRange(0, 4)
"""From never to always, or from very unlikely to very likely."""
_STRAY = 20
"""One in so many cells of a column of numbers may be a remark in place of one."""
_MOST_ROWS = 200
"""Rows of a person at most: more are a log of the exposure."""


def left_over(
    context: Context, columns: Iterable[int]
) -> tuple[dict[int, TakenFor], dict[int, str]]:
    """Return what columns of numbers without a role are taken for, and why others are left out."""
    table = context.table
    taken: dict[int, TakenFor] = {}
    reasons: dict[int, str] = {}
    for column in sorted({*columns} - context.used):
        told = column in context.roles.outcomes
        if _numbers_rows(context, column) and not told:
            continue
        reason = "" if told else _reason(context, column)
        like = _sibling(table, column)
        reading = reading_of(table, like, context.vocabulary, told=told)
        if reading is None and (told or _answers_by_yes(context, column)):
            flag = yes_or_no(texts(table, column), context.vocabulary)
            reading = TakenFor(AnswerRange(0, 1), measured=True) if flag else None
        if reading is not None and not reason:
            taken[column] = reading
        elif told:
            reasons[column] = _NO_ANSWERS
        elif is_numeric(table, column):
            reasons[column] = reason or "a number that is too large, or too few of them"
    return taken, reasons


def _answers_by_yes(context: Context, column: int) -> bool:
    """Return whether yes and no in a column are answers: to what one felt, or to each exposure."""
    felt = in_first_person(context.table.headings[column], context.vocabulary)
    who, several = context.participant, len(texts(context.table, column)) > 1
    return several and (felt or (who is not None and varies_within(context.table, column, who)))


def in_first_person(heading: str, vocabulary: LabVocabulary) -> bool:
    """Return whether a heading is a sentence such as ``I felt safe there``."""
    words = tokens(heading)
    return len(words) >= FEWEST_OF_SENTENCE and bool(vocabulary.first_person & {*words})


def _reason(context: Context, column: int) -> str:
    """Return why a column of numbers is left out; nothing where it is not."""
    table, who = context.table, context.participant
    people = len(texts(table, who)) if who is not None else len(table.rows)
    if context.time is not None or len(table.rows) > _MOST_ROWS * people:
        return "rows are moments of an exposure"
    if len(texts(table, _sibling(table, column))) < _FEWEST:
        return "the same number in all rows"
    if tokens(table.headings[column])[-1:] == ["id"]:
        return "numbers that name something"
    return next((why for why, test in _REASONS.items() if test(context, column)), "")


def _sibling(table: SourceTable, column: int) -> int:
    """Return the column, or one of its numbered series that varies, where it says one number."""
    if len(texts(table, column)) != 1 or not is_numeric(table, column):
        return column

    def words(each: int) -> list[str]:
        return re.sub(r"\d+", " ", " ".join(tokens(table.headings[each]))).split()

    own = words(column)
    others = (c for c in range(len(table.headings)) if c != column and words(c) == own)
    varied = (c for c in others if is_numeric(table, c) and len(texts(table, c)) > 1)
    return next(varied, column)


def _numbers_rows(context: Context, column: int) -> bool:
    """Return whether a column has no heading, or tells people or rows apart."""
    table = context.table
    nameless = bool(table.reading.heading_rows) and table.headings[column].startswith("column ")
    each = len({*table.column(column)}) == len(table.rows)
    return nameless or (each and is_identifier(table, column, context.vocabulary))


def _is_of_design(context: Context, column: int) -> bool:
    """Return whether nearly all people have the same numbers, as levels and counts of trials."""
    who = context.participant
    people = [] if who is None else texts_of_people(context.table, column, who)
    sets = Counter(frozenset(each.items()) for each in people)
    usual, count = max(sets.items(), key=lambda each: each[1], default=(frozenset(), 0))
    return len(usual) > 1 and len(people) > 2 and count * 4 >= 3 * len(people)


def _is_level(context: Context, column: int) -> bool:
    """Return whether a column has one number for each of several scenes, or conditions."""
    rows = [row for row in context.table.rows if row[column]]
    for said in (context.columns.get(fact, ()) for fact in ("scene", "condition")):
        pairs = {(*(row[c] for c in said), row[column]) for row in rows if said}
        named = {pair[:-1] for pair in pairs}
        if 2 < len(named) == len(pairs) <= len(rows) // FEWEST_ANSWERS:
            return True
    return False


def _are_years(context: Context, column: int) -> bool:
    first, last = _YEARS
    years = values_of(context.table, column)
    return bool(years) and all(year.is_integer() and first <= year <= last for year in years)


_NO_ANSWERS = "they are no numbers, no words with an order, and no yes or no"
"""Why what the lab calls an outcome is left out."""
_YEARS = 1900, 2100
_REASONS: Mapping[str, Callable[[Context, int], bool]] = {
    "calendar years": _are_years,
    "each person has the same numbers, as levels and counts of trials are": _is_of_design,
    "each scene or condition has its number, as levels are": _is_level,
}
"""Why a column of numbers is left out → a test for it."""


def reading_of(
    table: SourceTable, column: int, vocabulary: LabVocabulary, *, told: bool = False
) -> TakenFor | None:
    """Return what a column of numbers, or of words with an order, is taken for.

    Parameters
    ----------
    told
        The lab says that it is an outcome.
    """
    given = texts(table, column)
    words = [text for text in given if not is_missing(text, vocabulary)]
    numbers = {text: number(text, table.decimal) for text in words}
    if len(words) < (1 if told else _FEWEST):
        return None
    values = [value for value in numbers.values() if value is not None]
    scale = scale_of(table, column, vocabulary)
    if not values:
        said = all(_has_order(text, vocabulary) for text in words)
        if not said or scale is None:
            return None
        return TakenFor(scale if scale.high > _DEGREES.high else scale | _DEGREES, measured=False)
    if len(values) < len(words):
        rows = tuple(r for r in table.rows if numbers.get(r[column]) is not None or not r[column])
        few = (len(table.rows) - len(rows)) * _STRAY <= len(table.rows)
        rest = replace(table, rows=rows)
        return reading_of(rest, column, vocabulary, told=told) if few else None
    heading = {*tokens(table.headings[column])}
    measure = heading & (vocabulary.asking_others | vocabulary.measures | vocabulary.units)
    halves = all(float(2 * value).is_integer() for value in values)
    flag = {*values} <= {0.0, 1.0}
    usual = scale is not None and scale.usual[:2] in USUAL and scale.usual.high <= _MOST_OF_RATING
    if scale is not None and usual and halves and not measure and not flag:
        return TakenFor(scale, measured=False)
    return _measured(table, column, values, told=told)


def _has_order(text: str, vocabulary: LabVocabulary) -> bool:
    return plain(text) in vocabulary.agreement or vocabulary.degree(text) is not None


def _measured(
    table: SourceTable, column: int, values: Sequence[float], *, told: bool
) -> TakenFor | None:
    """Return the range of measurements, in steps that tell all of them apart."""
    codes = missing_codes(values)
    values = [value for value in values if value not in codes]
    filled = sum(map(bool, table.column(column)))
    if filled < FEWEST_ANSWERS or not values or max(map(abs, values)) > MOST:
        return None
    if _name_something(values) and not told:
        return None
    low, high = floor(min(values)), ceil(max(values))
    return TakenFor(AnswerRange(low, max(high, low + 1), step_of(values)), measured=True)


def _name_something(values: Sequence[float]) -> bool:
    """Return whether numbers beyond a million are all about as large: dates, or codes."""
    least, most = min(map(abs, values)), max(map(abs, values))
    return most > _LARGE and least * _SPREAD > most


_LARGE, _SPREAD = 1e6, 10


def ask_to_leave_out(table: SourceTable, reasons: Mapping[int, str]) -> list[OpenDoubt]:
    """Return the questions whether columns of numbers without a place may be left out."""
    doubts = []
    for reason in dict.fromkeys(reasons.values()):
        own = [table.headings[column] for column, why in reasons.items() if why == reason]
        question = f"May {listed([*map(repr, own)], _SHOWN)} be left out ({reason})?"
        stake = NO_LABEL if reason == _NO_ANSWERS else CURIOUS
        doubts.append(OpenDoubt(question, "yes: they stand under ignore", stake))
    return doubts


def ask_of_left(
    found: Found, headings: Mapping[str, str], remarks: Sequence[str]
) -> list[OpenDoubt]:
    """Return the question whether columns that no rule knows are what they are taken for."""
    answers = {item.name: item.answers for item in found.instrument.items}
    doubts = []
    if remarks:
        question = f"Do {', '.join(map(repr, remarks))} among numbers stand for no answer?"
        doubts.append(OpenDoubt(question, "they do, as `missing` has them", CODING))
    for how, (what, taken) in _TAKEN_FOR.items():
        left = [item for item, named in found.items.items() if named.how == how]
        shown = [f"{headings[i]!r} ({answers[i].low} to {answers[i].high})" for i in left]
        if left:
            question = f"No rule knows {listed(shown, _SHOWN)}: are these {what} of the lab's own?"
            like = f"left {found.instrument.name} {how}"
            doubts.append(OpenDoubt(question, f"they are, {taken}, each an outcome", LEFT, like))
    return doubts


_TAKEN_FOR: Mapping[How, tuple[str, str]] = {
    "left": ("questions or ratings", "on the narrowest usual scale of all answers"),
    "measure": ("measurements", "as they stand"),
}
