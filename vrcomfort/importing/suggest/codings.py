"""Finds how the answers of a questionnaire stand in a file: words, numbers from 1, marks."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from difflib import get_close_matches
from types import MappingProxyType

from vrcomfort.importing.answers import number
from vrcomfort.importing.files import is_number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.draft import CODING, INSTRUMENT, REFUSED, ROWS, OpenDoubt, listed
from vrcomfort.importing.suggest.vocabulary import LabVocabulary
from vrcomfort.questionnaire import Instrument, never_zero, plain, shipped_instruments

_CODES = frozenset(
    {-1, -2, -7, -8, -9, -77, -88, -99, -999, -9999, 9, 77, 88, 99, 777, 888, 999, 9999}
)
"""Numbers by which statistics programs mark missing answers."""
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

    answers: dict[str, float] = field(default_factory=dict)
    coded_from: int | None = None
    times: float | None = None
    variant: Instrument | None = None
    missing: list[str] = field(default_factory=list)
    doubts: list[OpenDoubt] = field(default_factory=list)

    def answer_of(self, value: int, instrument: Instrument) -> float:
        """Return the answer that a number of the file means."""
        if self.coded_from is None:
            return value * (self.times or 1)
        return int(instrument.low) + (value - self.coded_from) * (self.times or 1)


def coding_of(
    table: SourceTable, columns: Sequence[int], instrument: Instrument, vocabulary: LabVocabulary
) -> Coding:
    """Return the coding of the answers in some columns, with its doubts."""
    cells = [table.rows[r][c] for r in range(len(table.rows)) for c in columns]
    legend = {
        code: text for c in columns if table.meanings for code, text in table.meanings[c].items()
    }
    return coding_of_texts(cells, instrument, table.decimal, vocabulary, legend)


def _variant(instrument: Instrument, values: Iterable[float]) -> Instrument | None:
    """Return the shipped variant of an instrument that asks the same, and has these answers."""
    asked = {item.name for item in instrument.asked}
    return next(
        (
            each
            for each in shipped_instruments().values()
            if each.variant_of == instrument.name
            and {item.name for item in each.asked} == asked
            and all(map(each.answers.has, values))
        ),
        None,
    )


def coding_of_texts(
    cells: Sequence[str],
    instrument: Instrument,
    decimal: str,
    vocabulary: LabVocabulary,
    legend: Mapping[str, str] = MappingProxyType({}),
) -> Coding:
    """Return the coding of some answers, with its doubts.

    Parameters
    ----------
    legend
        Number → what a codebook, or the heading, says that it means.
    """
    counts = Counter(cell for cell in cells if cell)
    found = Coding()
    values: dict[int, int] = {}
    words: dict[str, int] = {}
    broken: list[str] = []
    fractions: list[float] = []
    for text, count in counts.items():
        value = number(text, decimal)
        if value is not None and not value.is_integer() and _has_fraction(instrument, value):
            fractions.append(value)
            continue
        if value is not None and value.is_integer():
            values[int(value)] = values.get(int(value), 0) + count
        elif value is not None:
            broken.append(text)
        else:
            words[text] = count
    if broken:
        of = f"where those of {instrument.name} are whole numbers"
        question = f"Why are answers {listed(broken, 6)}, {of}?"
        found.doubts.append(OpenDoubt(question, "the import will refuse them", REFUSED))
    numbered, shifts = _words(words, values, instrument, found, vocabulary)
    shifts |= _shifts_of(legend, values, instrument, found, vocabulary)
    _numbers(values, instrument, found, shifts, fractions)
    _rounded(fractions, instrument, found)
    _doubled(found, instrument)
    for text, number_said in numbered.items():
        found.answers[text] = found.answer_of(number_said, instrument)
    found.answers = dict(sorted(found.answers.items(), key=lambda each: each[1]))
    return found


def _has_fraction(instrument: Instrument, value: float) -> bool:
    """Return whether a value is an answer of an instrument with fractions, perhaps a finer one."""
    answers = instrument.answers
    return answers.has(value) or (answers.step < 1 and answers.low <= value <= answers.high)


def _around_zero(values: Iterable[int], instrument: Instrument) -> bool:
    """Return whether answers are coded from minus to plus a number, as -3 to 3 for 0 to 6."""
    half, odd = divmod(int(instrument.high - instrument.low), 2)
    return not odd and half > 1 and all(-half <= value <= half for value in values)


def _rounded(fractions: Sequence[float], instrument: Instrument, found: Coding) -> None:
    """Ask whether answers of sliders may be rounded, where they are finer than ours."""
    finer = [v for v in fractions if not instrument.answers.has(v * (found.times or 1))]
    if finer:
        step = instrument.answers.step
        question = f"May answers such as {finer[0]:g} be rounded to {step}, as this scale has them?"
        found.doubts.append(OpenDoubt(question, "they are rounded", ROWS))


def _words(
    words: Mapping[str, int],
    values: dict[int, int],
    instrument: Instrument,
    found: Coding,
    vocabulary: LabVocabulary,
) -> tuple[dict[str, int], set[int]]:
    """Find the answers that words mean; return those that only their numbers say, and shifts.

    Parameters
    ----------
    words
        Text → how often it was met.
    values
        Number → how often; those of such texts are added.
    """
    said = _labels(instrument, vocabulary)
    unknown: list[str] = []
    numbered: dict[str, int] = {}
    shifts: set[int] = set()
    bare = bool(values)
    for text in sorted(words):
        value, word = _number_beside(text)
        answer = said.get(plain(text), said.get(plain(word)))
        if answer is None:
            answer = _in_two_languages(text, said)
        if plain(text) == "none" and bare and len(words) == 1:
            question = "Is `None` an answer (0) or a missing value? All others are numbers."
            found.doubts.append(OpenDoubt(question, "it is missing", CODING))
            found.missing.append(text)
        elif text.casefold() in vocabulary.missing:
            found.missing.append(text)
        elif answer is not None:
            found.answers[text] = answer
            shifts |= set() if value is None else {value - answer}
        elif value is not None:
            numbered[text] = value
            values[value] = values.get(value, 0) + words[text]
        else:
            unknown.append(text)
    if len(shifts) > 1:
        question = "The numbers and the words of answers say different things: which are right?"
        found.doubts.append(OpenDoubt(question, "the words", CODING))
    codes = [code for text in unknown if (code := _CODE.fullmatch(text))]
    if len(codes) == len(unknown) and len({code[1] for code in codes}) == 1:
        for text, code in zip(unknown, codes, strict=True):  # A1, A2 … of survey programs
            numbered[text] = int(code[2])
            values[numbered[text]] = values.get(numbered[text], 0) + words[text]
        unknown = []
    unknown = _misspelt(unknown, said, found)
    ordered = _in_order(words, found, unknown, instrument, vocabulary)
    odd = {text: words[text] for text in unknown}
    of = sum(words.values()) + sum(values.values())
    if unknown and not ordered and not _are_rare(odd, of, instrument, found):
        shown = listed([*map(repr, unknown)], 8)
        question = f"Which answers of {instrument.name} are the words {shown}?"
        assumed = "none yet: give them under answers, or under missing"
        found.doubts.append(OpenDoubt(question, assumed, REFUSED))
    return numbered, shifts if bare else set()


def _misspelt(unknown: Sequence[str], said: Mapping[str, int], found: Coding) -> list[str]:
    """Take words that are nearly an answer's for it, and ask; return the others."""
    rest, taken = [], []
    for text in unknown:
        key = plain(text)
        near = get_close_matches(key, said, cutoff=_NEAR) if len(key) >= _LONG else []
        if near and len({said[word] for word in near}) == 1:
            found.answers[text] = said[near[0]]
            taken.append(f"{text!r} is {said[near[0]]}")
        else:
            rest.append(text)
    if taken:
        question = f"Are these answers misspelt: {', '.join(taken[:6])}?"
        found.doubts.append(OpenDoubt(question, "they are, as `answers` has them", CODING))
    return rest


_NEAR, _LONG = 0.8, 5
"""How alike a misspelt word is to the right one, and its letters at least."""


def _are_rare(texts: Mapping[str, int], of: int, instrument: Instrument, found: Coding) -> bool:
    """Take one or a few odd cells among many answers for missing ones, and ask.

    Parameters
    ----------
    texts
        Text → how often it was met, among `of` answers.
    """
    often = 1 if len(texts) == 1 and not any(map(is_number, texts)) else _FEW_ODD
    most = _ONE_WORD_OF if often == 1 else _ODD_OF
    if len(texts) > often or sum(texts.values()) * most > of:
        return False
    found.missing += texts
    shown = ", ".join(map(repr, texts))
    question = f"What does {shown} mean, so rare among answers of {instrument.name}?"
    found.doubts.append(OpenDoubt(question, "nothing: the answer is missing", CODING))
    return True


_FEW_ODD, _ODD_OF, _ONE_WORD_OF, _LIKERT = 3, 50, 8, 7
"""Different texts, and answers among which there is at most one such cell; one word is a mark."""


def _shifts_of(
    legend: Mapping[str, str],
    values: dict[int, int],
    instrument: Instrument,
    found: Coding,
    vocabulary: LabVocabulary,
) -> set[int]:
    """Return by how much numbers exceed the answers that a legend says; take out missing ones."""
    said = _labels(instrument, vocabulary)
    shifts = set()
    for code, text in legend.items():
        if text.casefold() in vocabulary.missing and int(code) in values:
            found.missing.append(code)
            del values[int(code)]
            continue
        ends = _ENDS.match(text)
        answer = said.get(plain(text), int(ends[0]) if ends else None)
        shifts |= set() if answer is None else {int(code) - answer}
    return shifts if len(shifts) == 1 else set()


_CODE = re.compile(r"([A-Za-z]{1,2})0*(\d{1,2})")
_ENDS = re.compile(r"\d+(?= ?\(|$)")
"""The number in ``0 (none)``."""


def _in_order(
    words: Mapping[str, int],
    found: Coding,
    unknown: Sequence[str],
    instrument: Instrument,
    vocabulary: LabVocabulary,
) -> bool:
    """Put words in order by how much they say, where there are as many as answers; and ask.

    Words that no list has are so found, and two of one answer (very, extremely) told apart.
    """
    low, steps = int(instrument.low), int(instrument.high - instrument.low)
    asked = [text for text in words if text in found.answers or text in unknown]
    degrees = {text: vocabulary.degree(text) for text in asked}
    of_degree = {degree: text for text, degree in degrees.items() if degree is not None}
    if not asked or None in degrees.values() or len(of_degree) < len({*map(plain, asked)}):
        return False
    ranked = [of_degree[degree] for degree in sorted(of_degree)]
    top = min(max(of_degree), steps)
    if unknown and len(ranked) <= steps <= _AGREEMENT:  # an answer that nobody gave
        places = [min(degree, top) for degree in sorted(of_degree)]
    elif len(ranked) in {steps + 1, _AGREEMENT + 1}:
        places = [*range(len(ranked))]
    else:
        return False
    answers: dict[str, float] = {t: low + n for n, t in zip(places, ranked, strict=True)}
    if len({*places}) < len(places) or (not unknown and answers == found.answers):
        return False
    variant = _variant(instrument, answers.values()) if places[-1] > steps else None
    if places[-1] > steps and variant is None:
        return False
    found.variant = variant
    found.answers = answers
    question = f"Are the answers of {instrument.name} in this order: {' < '.join(ranked)}?"
    assumed = f"they are: {', '.join(f'{text} is {answers[text]}' for text in ranked)}"
    found.doubts.append(OpenDoubt(question, assumed, CODING))
    return True


def _labels(instrument: Instrument, vocabulary: LabVocabulary) -> dict[str, int]:
    """Return word → answer: the instrument's own, and those of its kind in any language."""
    low, steps = int(instrument.low), int(instrument.high - instrument.low)
    answers = instrument.answers
    own = {plain(word): int(answer) for word, answer in answers.words.items()}
    ends = {plain(word) for words in (answers.labels, *answers.more_labels) for word in words}
    agreed = steps == _AGREEMENT and ends & vocabulary.agreement.keys()
    said = vocabulary.severity if steps == _SEVERITY else vocabulary.agreement if agreed else {}
    return {word: low + value for word, value in said.items()} | own


_SEVERITY, _AGREEMENT = 3, 4
"""Steps from none to severe, and from strongly disagree to strongly agree."""


def _number_beside(text: str) -> tuple[int | None, str]:
    """Return number and word of ``0 - None`` or ``slight (1)``; no number of other texts."""
    match = _NUMBERED.fullmatch(text)
    if match is None:
        return None, ""
    digits, word = (match[1], match[2]) if match[1] else (match[4], match[3])
    return int(digits), word


def code_of(text: str, vocabulary: LabVocabulary, *, of_seven: bool = False) -> int | None:
    """Return the number that an answer stands for: beside its word, as a code, or as a degree.

    Parameters
    ----------
    of_seven
        Agreement has seven degrees: `somewhat agree` is below `agree`.
    """
    key = plain(text)
    if key in vocabulary.agreement:
        degree = vocabulary.agreement[key]
        return _OF_SEVEN[degree][is_softened(text)] if of_seven else 1 + degree
    if key in vocabulary.severity:
        return vocabulary.severity[key]
    code = _CODE.fullmatch(text)
    number_said = int(code[2]) if code else _number_beside(text)[0]
    return vocabulary.degree(text) if number_said is None else number_said


def is_softened(text: str) -> bool:
    """Return whether an answer such as `somewhat agree` is softened."""
    return text.casefold().startswith(("somewhat", "slightly", "rather", "eher", "stimme eher"))


_OF_SEVEN = ((1, 1), (2, 3), (4, 4), (6, 5), (7, 7))
"""For each degree of agreement, the number of the plain answer and of the softened one."""


def missing_codes(values: Iterable[float]) -> list[int]:
    """Return the numbers that programs write for missing answers.

    They are far from all others, or the only one below 0 where the scale is not around 0.
    """
    values = [*values]
    found = {int(value) for value in values if value in _CODES and abs(value) > _FAR}
    rest = [value for value in values if value not in found]
    if not rest or max(map(abs, rest)) > _FAR + 1:
        found = set()
    below = {value for value in values if value < 0} - found
    if len(below) == 1 and below <= _CODES and max(values) > _AROUND_ZERO * -min(below):
        found |= {*map(int, below)}
    return sorted(found)


_FAR, _AROUND_ZERO = 10, 3
"""Above the first, numbers are no usual answers; of scales around 0, ends are at most -3 and 3."""


def missing_texts(cells: Iterable[str], vocabulary: LabVocabulary) -> list[str]:
    """Return the texts of a column of facts that say nothing: words for it, and codes below 0."""
    words = dict.fromkeys(cells)
    below = [text for text in words if re.fullmatch(r"-\d+", text)]
    codes = below if len(below) == 1 and int(below[0]) in _CODES and int(below[0]) < -_FAR else []
    return [text for text in words if text.casefold() in vocabulary.missing or text in codes]


def _in_two_languages(text: str, said: dict[str, int]) -> int | None:
    """Return the answer of ``None / Inexistente``: what one of its parts says, if none differs."""
    found = {said[plain(part)] for part in re.split(r"[/|]", text) if plain(part) in said}
    return found.pop() if len(found) == 1 else None


def _doubled(found: Coding, instrument: Instrument) -> None:
    """Ask where two words mean one answer, or more words were met than there are answers."""
    by_value: dict[float, set[str]] = {}
    for text, value in found.answers.items():
        by_value.setdefault(value, set()).add(plain(text))
    doubled = [sorted(words) for words in by_value.values() if len(words) > 1]
    if doubled:
        shown = "; ".join(" and ".join(words) for words in doubled)
        question = f"Are these one answer of {instrument.name} each: {shown}?"
        found.doubts.append(OpenDoubt(question, "they are, as `answers` has them", CODING))


def _without_codes(outside: Sequence[int], instrument: Instrument, found: Coding) -> list[int]:
    """Take numbers beyond the scale that programs use for missing answers; return the others."""
    # One above the highest answer is an answer counted from 1, not a code.
    codes = [value for value in outside if value in _CODES and value != int(instrument.high) + 1]
    found.missing += map(str, codes)
    if codes:
        shown = ", ".join(map(str, codes))
        question = f"Do the numbers {shown} stand for missing answers? {instrument.name} has none."
        found.doubts.append(OpenDoubt(question, "they do", CODING))
    return [value for value in outside if value not in codes]


def _numbers(
    values: dict[int, int],
    instrument: Instrument,
    found: Coding,
    shifts: Set[int],
    fractions: Sequence[float],
) -> None:
    """Find the coding of the numbers among answers.

    Parameters
    ----------
    shifts
        By how much numbers exceed the answers that words beside them say: ``1 (none)`` is 0.
    fractions
        Answers that are no whole numbers.
    """
    low, high = int(instrument.low), int(instrument.high)
    outside = sorted(value for value in values if not low <= value <= high)
    inside = [value for value in values if low <= value <= high]
    around_zero = bool(values) and min(values) < 0 and _around_zero(values, instrument)
    rest = outside if around_zero else _without_codes(outside, instrument, found)
    variant = _variant(instrument, values)
    first: int | None = None
    if rest and low in values and variant is not None:
        found.variant = variant
        question = f"Answers go from {low} to {max(rest)}: is this the {variant.short}?"
        assumed = f"it is, and not comparable with {instrument.short}"
        found.doubts.append(OpenDoubt(question, assumed, INSTRUMENT))
    elif len(shifts) == 1 and min(shifts) != 0:
        first = low + min(shifts)
        question = f"Are answers counted from {first}, as the words beside some of them say?"
    elif around_zero:
        first = -(high - low) // 2
        question = f"Are the answers {first} to {-first}, around 0?"
    elif rest in ([low - 1], [high + 1]) and (high if rest[0] < low else low) not in values:
        first = low - 1 if rest[0] < low else low + 1
        question = f"Are the answers {first} to {first + high - low} in place of {low} to {high}?"
    elif rest and not _are_rare(
        {str(value): values[value] for value in rest}, sum(values.values()), instrument, found
    ):
        shown = ", ".join(map(str, rest[:6]))
        question = f"What do the answers {shown} mean? {instrument.name} has {low} to {high}."
        found.doubts.append(OpenDoubt(question, "the import will refuse them", REFUSED))
    # The task load index is printed with 21 marks, of which labs type the number.
    elif high >= 100 and 0 < max([*inside, *fractions], default=0) <= 21:
        least, most = min([*inside, *fractions]), max([*inside, *fractions])
        found.times = 100 if fractions and most <= 1 else 10 if most <= 10 else 5
        found.coded_from = 1 if most == 21 else None
        if not fractions and sorted(inside) == [*range(1, _LIKERT + 1)]:
            found.times, found.coded_from = round((high - low) / (_LIKERT - 1), 6), 1
        question = f"Answers of {instrument.short} are {low} to {high}, these {least:g} to"
        what = f"times {found.times:g}" + (", counted from 1" if found.coded_from == 1 else "")
        doubt = OpenDoubt(f"{question} {most:g}: are they marks?", what, CODING)
        found.doubts.append(doubt)
    elif (
        not found.answers
        and not shifts
        and not fractions
        and (count := never_zero(instrument, {value: values[value] for value in inside}))
    ):
        first = low + 1
        question = f"None of {count} answers is {low}: are they counted from {first} (with no"
        question = f"{question} {high + 1} among them), or was {low} never answered?"
    if first is not None:
        found.coded_from = first
        found.doubts.append(OpenDoubt(question, f"they are: {first} stands for {low}", CODING))
