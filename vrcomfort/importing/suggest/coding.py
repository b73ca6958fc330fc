"""How answers stand in columns: as numbers, from 0 or 1 on, or in words."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from vrcomfort.importing.answers import number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.draft import Doubt
from vrcomfort.importing.suggest.vocabulary import MISSING, SEVERITY
from vrcomfort.questionnaire import Instrument, never_zero, plain, shipped_instruments

_CODES = frozenset(
    {-1, -2, -7, -8, -9, -77, -88, -99, -999, -9999, 9, 77, 88, 99, 777, 888, 999, 9999}
)
_NUMBERED = re.compile(r"\(?(\d+)\)?\s*[-–=:.)]?\s*(\D+)|(\D+?)\s*[-–=:(]\s*(\d+)\)?")


@dataclass
class Coding:
    """How the answers of some columns stand in the file.

    Parameters
    ----------
    answers
        Word → number of the instrument.
    coded_from
        The number of the lowest answer, where it is not the instrument's.
    times
        What the file's numbers are multiplied by.
    variant
        The instrument that has these answers, where the one that was looked for has not.
    """

    answers: dict[str, int] = field(default_factory=dict)
    coded_from: int | None = None
    times: int | None = None
    variant: Instrument | None = None
    missing: list[str] = field(default_factory=list)
    doubts: list[Doubt] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def coding_of(table: SourceTable, columns: Sequence[int], instrument: Instrument) -> Coding:
    """Return how the answers in some columns are to be read, with what is doubtful."""
    cells = [table.rows[r][c] for r in range(len(table.rows)) for c in columns]
    return coding_of_texts(cells, instrument, table.reading.decimal or ".")


def _variant(instrument: Instrument, values: Iterable[int]) -> Instrument | None:
    """Return the shipped variant of an instrument that has all of these answers."""
    return next(
        (
            each
            for each in shipped_instruments().values()
            if each.variant_of == instrument.name and all(map(each.answers.has, values))
        ),
        None,
    )


def coding_of_texts(cells: Sequence[str], instrument: Instrument, decimal: str) -> Coding:
    """Return how some answers are to be read, with what is doubtful."""
    counts = Counter(cell for cell in cells if cell)
    found = Coding()
    values: dict[int, int] = {}
    words: list[str] = []
    broken: list[str] = []
    for text, count in counts.items():
        value = number(text, decimal)
        if value is not None and not value.is_integer() and instrument.answers.has(value):
            continue
        if value is not None and value.is_integer():
            values[int(value)] = values.get(int(value), 0) + count
        elif value is not None:
            broken.append(text)
        else:
            words.append(text)
    if broken:
        shown = ", ".join(broken[:6]) + (" …" if len(broken) > 6 else "")
        question = f"Why are answers {shown}, where those of {instrument.name} are whole numbers?"
        found.doubts.append(Doubt(question, "the import will refuse them"))
    _words(words, values, instrument, found)
    _numbers(values, instrument, found)
    return found


def _words(words: list[str], values: dict[int, int], instrument: Instrument, found: Coding) -> None:
    said = _labels(instrument)
    unknown = []
    for text in sorted(words):
        answer = said.get(plain(text))
        if answer is None:
            answer = _numbered(text, said, instrument)
        if plain(text) == "none" and values and len(words) == 1:
            question = "Is `None` an answer (0) or a missing value? All others are numbers."
            found.doubts.append(Doubt(question, "it is missing"))
            found.missing.append(text)
        elif text.casefold() in MISSING:
            found.missing.append(text)
        elif answer is not None:
            found.answers[text] = answer
        else:
            unknown.append(text)
    if found.answers:
        found.answers = dict(sorted(found.answers.items(), key=lambda each: each[1]))
    if unknown:
        shown = ", ".join(repr(text) for text in unknown[:8]) + (" …" if len(unknown) > 8 else "")
        question = f"Which answers of {instrument.name} are the words {shown}?"
        found.doubts.append(Doubt(question, "none yet: give them under answers, or under missing"))
    _doubled(found, instrument)


def _labels(instrument: Instrument) -> dict[str, int]:
    """Return word → answer, of the instrument's own words and of none to severe."""
    low, high = int(instrument.low), int(instrument.high)
    said: dict[str, int] = {}
    if high - low == 3:
        said = {word: low + value for word, value in SEVERITY.items()}
    return said | {plain(word): int(answer) for word, answer in instrument.answers.words.items()}


def _numbered(text: str, said: dict[str, int], instrument: Instrument) -> int | None:
    """Return the answer of ``0 - None`` or ``slight (1)``: by its word, else by its number."""
    match = _NUMBERED.fullmatch(text)
    if match is None:
        return None
    digits, word = (match[1], match[2]) if match[1] else (match[4], match[3])
    if plain(word) in said:
        return said[plain(word)]
    value = int(digits)
    return value if instrument.low <= value <= instrument.high else None


def _doubled(found: Coding, instrument: Instrument) -> None:
    """Ask where two words mean one answer, or more words were met than there are answers."""
    by_value: dict[int, set[str]] = {}
    for text, value in found.answers.items():
        by_value.setdefault(value, set()).add(plain(text))
    doubled = [sorted(words) for words in by_value.values() if len(words) > 1]
    if doubled:
        shown = "; ".join(" and ".join(words) for words in doubled)
        question = f"Are these one answer of {instrument.name} each: {shown}?"
        found.doubts.append(Doubt(question, "they are, as `answers` has them"))


def _numbers(values: dict[int, int], instrument: Instrument, found: Coding) -> None:
    low, high = int(instrument.low), int(instrument.high)
    outside = sorted(value for value in values if not low <= value <= high)
    inside = [value for value in values if low <= value <= high]
    codes = [value for value in outside if value in _CODES and value != high + 1]
    for code in codes:
        found.missing.append(str(code))
    if codes:
        shown = ", ".join(map(str, codes))
        question = f"Do the numbers {shown} stand for missing answers? {instrument.name} has none."
        found.doubts.append(Doubt(question, "they do"))
    rest = [value for value in outside if value not in codes]
    variant = _variant(instrument, values)
    if rest and low in values and variant is not None:
        found.variant = variant
        question = f"Answers go from {low} to {max(rest)}: is this the {variant.short}?"
        found.doubts.append(Doubt(question, f"it is, and not comparable with {instrument.short}"))
    elif rest == [low - 1] and high not in values:
        found.coded_from = low - 1
        question = f"Are the answers {low - 1} to {high - 1} in place of {low} to {high}?"
        found.doubts.append(Doubt(question, f"they are: {low - 1} stands for {low}"))
    elif rest == [high + 1] and low not in values:
        found.coded_from = low + 1
        question = f"Are the answers {low + 1} to {high + 1} in place of {low} to {high}?"
        found.doubts.append(Doubt(question, f"they are: {low + 1} stands for {low}"))
    elif rest:
        shown = ", ".join(map(str, rest[:6]))
        question = f"What do the answers {shown} mean? {instrument.name} has {low} to {high}."
        found.doubts.append(Doubt(question, "the import will refuse them"))
    elif high >= 100 and inside and max(inside) <= 21:
        found.times = 10 if max(inside) <= 10 else 5
        found.coded_from = 1 if max(inside) == 21 else None
        question = f"Answers of {instrument.short} are {low} to {high}, these {min(inside)} to"
        doubt = Doubt(f"{question} {max(inside)}: are they marks?", f"times {found.times}")
        found.doubts.append(doubt)
    elif not found.answers and (
        count := never_zero(instrument, {value: values[value] for value in inside})
    ):
        found.coded_from = low + 1
        question = (
            f"None of {count} answers is {low}: are they counted from {low + 1} (with no "
            f"{high + 1} among them), or was {low} never answered?"
        )
        found.doubts.append(Doubt(question, f"they are: {low + 1} stands for {low}"))
