"""Finds the item of an instrument that a heading names."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from functools import lru_cache
from itertools import takewhile
from typing import Literal, NamedTuple

from vrcomfort.importing.suggest.codebooks import BESIDE, TITLE
from vrcomfort.importing.suggest.stems import Stem
from vrcomfort.importing.suggest.vocabulary import FEWEST_OF_SENTENCE, LabVocabulary, bare, tokens
from vrcomfort.questionnaire import Instrument, plain

How = Literal[
    "name", "wording", "near", "abbreviation", "initials", "number", "order", "position", "left",
    "measure",
]  # fmt: skip
"""The last two: nothing else knows the column, which is taken for a rating, or a measurement."""

_LONGEST = 40
# Of SequenceMatcher: one wrong letter in a word of seven passes, two in one of thirteen.
_NEAR = 0.84


@dataclass(frozen=True)
class Named:
    """An item that a heading names.

    Parameters
    ----------
    before, after
        The words of the heading around the item's name, in small letters.
    """

    column: int
    instrument: str
    item: str
    how: How
    before: tuple[str, ...]
    after: tuple[str, ...]


def named_item(
    column: int, heading: str, label: str, instrument: Instrument, vocabulary: LabVocabulary
) -> Named | None:
    """Return the item of an instrument that a heading names, or else its label.

    A name that is there wins over one that is nearly there, and that over an abbreviation.
    """
    found = _named(heading, label, instrument, vocabulary)
    return Named(column, instrument.name, *found) if found else None


@lru_cache(maxsize=16384)  # each search for questionnaires looks at the same headings
def _named(
    heading: str, label: str, instrument: Instrument, vocabulary: LabVocabulary
) -> tuple[str, How, tuple[str, ...], tuple[str, ...]] | None:
    if vocabulary.measures & {*tokens(heading)[-1:]}:
        return None  # nausea.rt
    for how, _, find in NAMES:
        for text, other in ((heading, label), (label, heading)):
            title, _, asked = text.rpartition(TITLE + BESIDE)
            words = tokens(asked)
            found = find(words, vocabulary, instrument)
            if found is not None:
                start, end, item = found
                more = tokens(f"{other} {title}") if text is label else []
                return item, how, (*more, *words[:start]), tuple(words[end:])
    return None


_Span = tuple[int, int, str]


@lru_cache(maxsize=1024)
def _windows(words: tuple[str, ...]) -> tuple[tuple[int, int, str], ...]:
    """Return start, end and letters of parts of a heading, long ones first.

    Each instrument is looked for in the same headings.
    """
    return tuple(
        (start, start + length, plain("".join(words[start : start + length])))
        for length in range(min(_LONGEST, len(words)), 0, -1)
        for start in range(len(words) - length + 1)
        if not words[start].isdecimal()
    )


def _exact(words: Sequence[str], vocabulary: LabVocabulary, instrument: Instrument) -> _Span | None:
    known = vocabulary.spellings(instrument)
    for start, end, key in _windows(tuple(words)):
        item = known.get(key)
        if item and (not words[end - 1].isdecimal() or _is_numbered_by_scale(item, instrument)):
            return start, end, item
    return None


def _is_numbered_by_scale(name: str, instrument: Instrument) -> bool:
    """Return whether the number at the end of an item's name is not its place: ``ipq_sp1``."""
    ends = [end[0] for item in instrument.asked if (end := _DIGITS.search(item.name))]
    return _DIGITS.search(name) is not None and len({*ends}) < len(ends)


_DIGITS = re.compile(r"\d+$")


def _worded(
    words: Sequence[str], vocabulary: LabVocabulary, instrument: Instrument
) -> _Span | None:
    """Find a sentence of which most words are there, the rare ones before all.

    Labs put the name of their system in place of "this system", and translate in their own way.
    """
    if len(words) < FEWEST_OF_SENTENCE:
        return None
    there = [*map(bare, words)]
    likeness: dict[str, tuple[float, Set[str]]] = {}
    for item, weights in vocabulary.sentences(instrument):
        shared = sum(weight for word, weight in weights.items() if word in there)
        share = shared / sum(weights.values())
        if share > likeness.get(item, (0.0, set()))[0]:
            likeness[item] = share, weights.keys()
    ranked = sorted(likeness, key=lambda item: -likeness[item][0])
    if not ranked or likeness[ranked[0]][0] < _WORDED:
        return None
    if len(ranked) > 1 and likeness[ranked[1]][0] > _AMBIGUOUS * likeness[ranked[0]][0]:
        return None
    places = [n for n, word in enumerate(there) if word in likeness[ranked[0]][1]]
    return min(places), max(places) + 1, ranked[0]


_WORDED, _AMBIGUOUS = 0.5, 0.6
"""Share of a sentence's words, weighed, that a heading has; that of the next item at most."""


@lru_cache(maxsize=256)
def _by_first_letter(
    vocabulary: LabVocabulary, instrument: Instrument
) -> dict[str, list[tuple[str, str]]]:
    """Return first letter → (spelling, item) of an instrument."""
    known: dict[str, list[tuple[str, str]]] = {}
    for spelling, item in vocabulary.spellings(instrument).items():
        known.setdefault(spelling[0], []).append((spelling, item))
    return known


def _near(words: Sequence[str], vocabulary: LabVocabulary, instrument: Instrument) -> _Span | None:
    known = _by_first_letter(vocabulary, instrument)
    best: tuple[float, _Span] | None = None
    for start, end, key in _windows(tuple(words)):
        # Short words resemble each other by chance; a number behind a name is not part of it.
        if len(key) < 5 or words[end - 1].isdecimal():
            continue
        # Misspellings keep the first letter and about the length; comparing all is slow.
        for spelling, item in known.get(key[0], ()):
            if abs(len(spelling) - len(key)) > 3:
                continue
            ratio = _likeness(spelling, key)
            if ratio >= _NEAR and (best is None or ratio > best[0]):
                best = ratio, (start, end, item)
    return best[1] if best else None


@lru_cache(maxsize=4096)
def _likeness(spelling: str, key: str) -> float:
    """Return the similarity of two words, or 0 where quick bounds put it below `_NEAR`."""
    matcher = SequenceMatcher(None, spelling, key)
    if matcher.real_quick_ratio() < _NEAR or matcher.quick_ratio() < _NEAR:
        return 0.0
    return matcher.ratio()


def _abbreviated(words: Sequence[str], _: LabVocabulary, instrument: Instrument) -> _Span | None:
    """Find ``GenDisc`` or ``stom_aware``: beginnings of the words of exactly one item."""
    for length in range(min(4, len(words)), 0, -1):
        for start in range(len(words) - length + 1):
            part = words[start : start + length]
            if any(len(word) < 3 or word.isdecimal() for word in part):
                continue
            found = [item.name for item in instrument.items if _abbreviates(part, item.name)]
            if not found and length == 1:
                found = [i.name for i in instrument.items if _is_glued(part[0], i.name)]
            enough = length > 1 or len(part[0]) >= 4
            if len(found) == 1 and enough:
                return start, start + length, found[0]
    return None


@lru_cache(maxsize=1024)
def _parts(name: str) -> tuple[str, ...]:
    """Return the words of an item's name that an abbreviation may have."""
    return tuple(word for word in name.split("_") if word != "of")


def _abbreviates(part: Sequence[str], name: str) -> bool:
    """Return whether words are beginnings of words of a name, in order and from the first."""
    full = _parts(name)
    if not full[0].startswith(part[0]):
        return False
    place = 0
    for word in part:
        while place < len(full) and not full[place].startswith(word):
            place += 1
        if place == len(full):
            return False
        place += 1
    return True


def _is_glued(word: str, name: str) -> bool:
    """Return whether a word is the beginnings of the first two words of a name: ``gendisc``."""
    first, *rest = _parts(name)
    return bool(rest) and any(
        first.startswith(word[:place]) and rest[0].startswith(word[place:])
        for place in range(3, len(word) - 2)
    )


class NameEvidence(NamedTuple):
    """A way in which a heading can name an item; the heaviest one counts."""

    how: How
    weight: int
    find: Callable[[Sequence[str], LabVocabulary, Instrument], _Span | None]


NAMES = (
    NameEvidence("name", 4, _exact),
    NameEvidence("near", 3, _near),
    NameEvidence("wording", 2, _worded),
    NameEvidence("abbreviation", 1, _abbreviated),
)
WEIGHTS = {each.how: each.weight for each in NAMES}


def item_behind_stem(
    column: int, heading: Stem, label: Stem, instrument: Instrument, vocabulary: LabVocabulary
) -> Named | None:
    """Return the item that is named behind a question which other headings share, or else in it.

    ``Rate the task (Performance: 0 = good). [Effort]`` is not performance.
    """
    whole = heading.stem + heading.rest, label.stem + label.rest
    for stem, rest in (heading, label):
        found = named_item(column, rest, "", instrument, vocabulary) if stem else None
        if found is not None and found.how == "name":
            # Qualtrics numbers loops before the codes of questions: 1_Q14_3.
            code = tokens(whole[0]) if stem != heading.stem else ()
            loop = [*takewhile(str.isdecimal, code)]
            named = [word for word in code if word.isalpha()]
            return replace(found, before=(*loop, *named, *tokens(stem), *found.before))
    return named_item(column, *whole, instrument, vocabulary)
