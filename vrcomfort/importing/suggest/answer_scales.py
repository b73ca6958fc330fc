"""Reads the answers of columns, as numbers or in words, and the scale that they are on."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from fractions import Fraction
from math import ceil, floor

from vrcomfort.importing.answers import number
from vrcomfort.importing.made_instruments import MOST_DECIMALS
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.codings import code_of, is_softened, missing_codes
from vrcomfort.importing.suggest.own_instruments import AGREEMENT, DEGREES, AnswerRange
from vrcomfort.importing.suggest.vocabulary import LabVocabulary
from vrcomfort.importing.toml_draft import TomlDraft
from vrcomfort.questionnaire import Instrument, plain

FEWEST_ANSWERS = 4
_REMARK = 4
"""Words among numbers that are no answer: I could not find it."""
_OF_FIVE, _OF_SEVEN = 5, 7
_NUMBERED = re.compile(r"\(?(-?\d{1,3})[\s–—=:.)(-]+[^\W\d_]\D*|[^\W\d_]\D*[\s=:(](-?\d{1,3})\)?")
"""An answer that says its number before or behind its words, as ends of scales do."""


def scale_of(
    table: SourceTable, column: int, vocabulary: LabVocabulary, *, of_seven: bool = False
) -> AnswerRange | None:
    """Return the lowest and the highest answer of a column; None where it holds no answers."""
    counts = Counter(cell for cell in table.column(column) if not is_missing(cell, vocabulary))
    read = _read(counts, table.decimal, vocabulary, of_seven=of_seven)
    values = [value for value in read.values() if value is not None]
    if sum(counts.values()) < FEWEST_ANSWERS or len(values) < len(read):
        return None
    values = [value for value in values if value not in missing_codes(values)]
    low, high = min(values), max(values)
    if any(plain(text) in vocabulary.agreement for text in counts) and not _are_degrees(
        counts, vocabulary
    ):
        low, high = 1.0, float(_OF_SEVEN if of_seven else _OF_FIVE)
    if not -100 <= low <= high <= 150:
        return None
    return AnswerRange(floor(low), ceil(high), step_of(values))


def step_of(values: Iterable[float]) -> float:
    """Return the step that tells numbers apart: 1, 0.1 … with at most `MOST_DECIMALS`."""
    exact = [Fraction(str(value)) for value in values]
    digits = next(
        (n for n in range(MOST_DECIMALS) if all((v * 10**n).denominator == 1 for v in exact)),
        MOST_DECIMALS,
    )
    return 1.0 if digits == 0 else float(Fraction(1, 10**digits))


def is_missing(cell: str, vocabulary: LabVocabulary) -> bool:
    """Return whether a cell says that there is no answer."""
    return not cell or (cell.casefold() in vocabulary.missing and plain(cell) != "none")


def are_of_seven(cells: Iterable[str], vocabulary: LabVocabulary) -> bool:
    """Return whether cells have plain and softened agreement."""
    agree = {text for text in {*cells} if vocabulary.agreement.get(plain(text)) in {1, 3}}
    return len({is_softened(text) for text in agree}) > 1


def _read(
    cells: Iterable[str], decimal: str, vocabulary: LabVocabulary, *, of_seven: bool
) -> dict[str, float | None]:
    """Return text → the answer that it is, as a number or in words; None where it is none."""
    found: dict[str, float | None] = {text: number(text, decimal) for text in cells}
    words = [text for text, value in found.items() if value is None]
    matches = {text: match for text in words if (match := _NUMBERED.fullmatch(text))}
    numbers = {text: float(match[1] or match[2]) for text, match in matches.items()}
    if len({*numbers.values()}) == len(words):  # 5, 6, "7 - very"
        return found | numbers
    if numbers:  # some words alone say a number, or two the same
        return dict.fromkeys(found)
    if len(words) < len(found):  # among numbers
        known = {*vocabulary.agreement, *vocabulary.severity}
        words = [t for t in words if len(t.split()) < _REMARK or plain(t) in known]
    alike = len({text[:1] for text in words if text[1:].isdecimal()}) < 2  # not a1, b1
    if alike and _are_degrees(words, vocabulary):
        found |= {text: vocabulary.degree(text) for text in words}
    elif alike:
        found |= {text: code_of(text, vocabulary, of_seven=of_seven) for text in words}
    said = [text for text in words if found[text] is not None]
    if len({found[text] for text in said}) < len({*map(plain, said)}):
        found |= dict.fromkeys(words)  # two words of one degree
    return {text: None if value is None else float(value) for text, value in found.items()}


def yes_or_no(texts: Sequence[str], vocabulary: LabVocabulary) -> dict[str, float | None]:
    """Return 1 for each yes or true, and 0 for each no; none where another text is among them."""
    if not all(plain(text) in vocabulary.yes_no for text in texts):
        return {}
    return {text: float(plain(text) not in vocabulary.no) for text in texts}


def _are_degrees(words: Iterable[str], vocabulary: LabVocabulary) -> bool:
    """Return whether words say how often, how likely or how much, and not all of them agree."""
    words = [*words]
    agreed = all(plain(text) in vocabulary.agreement for text in words)
    return not agreed and all(vocabulary.degree(text) is not None for text in words)


def kind_of_words(table: SourceTable, column: int, vocabulary: LabVocabulary) -> str:
    """Return whether the answers of a column are words of agreement or of degrees, or neither."""
    words = [text for text in table.texts[column] if not is_missing(text, vocabulary)]
    if words and all(plain(text) in vocabulary.agreement for text in words):
        return AGREEMENT
    return DEGREES if words and _are_degrees(words, vocabulary) else ""


def put_coding(
    draft: TomlDraft,
    instrument: Instrument,
    columns: Iterable[Collection[str]],
    decimal: str,
    vocabulary: LabVocabulary,
    flags: dict[str, float | None] | None = None,
) -> None:
    """Write what answers in words and `flags` mean, and which texts are missing answers.

    Two words of one degree are answers to two questions: ``low risk`` and ``low effort``.
    """
    columns = [*columns]
    blank = [t for cells in columns for t in cells if t and is_missing(t, vocabulary)]
    seven = max(item.answers.high for item in instrument.items) == _OF_SEVEN
    flags = flags or {}
    read: dict[str, float | None] = {}
    for cells in columns:
        given = [text for text in cells if text and text not in {*blank, *flags}]
        read |= _read(given, decimal, vocabulary, of_seven=seven)
    read |= flags
    codes = missing_codes([value for value in read.values() if value is not None])
    blank += [text for text, value in read.items() if value in codes]
    if any(value is not None for value in read.values()):  # remarks among numbers
        blank += [text for text, value in read.items() if value is None]
    words = {t: int(v) for t, v in read.items() if v is not None and number(t, decimal) is None}
    if words:
        draft.put("answers", dict(sorted(words.items(), key=lambda each: each[1])))
    if blank:
        draft.put("missing", list(dict.fromkeys(blank)))
