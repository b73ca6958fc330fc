"""Finds the facts inside codes such as ``P01_pre`` or ``3 VR``: who, and when or what."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from typing import NamedTuple

from vrcomfort.importing.suggest.vocabulary import LabVocabulary

_CODE = re.compile(r"(?P<who>[^\W\d_]{0,12}[ _-]?\d+)[ _.:/-]*(?P<what>[^\W\d].*)")
_REVERSED = re.compile(r"(?P<what>.*?[^\W\d])[ _.:/-]+(?P<who>[^\W\d_]{0,12}[ _-]?\d+)")
_FEWEST_PEOPLE, _MOST_WORDS = 3, 6
"""People that codes tell apart, and words behind them."""


class Codes(NamedTuple):
    """What codes say: code → participant, and code → the word beside it.

    Parameters
    ----------
    timepoints
        Whether all words are of timepoints.
    """

    people: dict[str, str]
    words: dict[str, str]
    timepoints: bool


def codes_in(cells: Sequence[str], vocabulary: LabVocabulary) -> Codes | None:
    """Return what codes say of which each is there once, each person with the same words."""
    found = [cell for cell in cells if cell]
    if len({*found}) < len(found):
        return None
    for pattern in (_CODE, _REVERSED):
        matches = {code: pattern.fullmatch(code) for code in found}
        people = {code: match["who"].strip() for code, match in matches.items() if match}
        words = {code: match["what"].strip() for code, match in matches.items() if match}
        if len(people) == len(found) and _crossed(people, words):
            when = [vocabulary.timepoint(word) for word in {*words.values()}]
            return Codes(people, words, all(when) and len({*when}) == len(when))
    return None


def _crossed(people: dict[str, str], words: dict[str, str]) -> bool:
    """Return whether several people have the same few words, nearly all of them each."""
    of: dict[str, set[str]] = defaultdict(set)
    for code, who in people.items():
        of[who].add(words[code])
    count = Counter(len(each) for each in of.values())
    different = len({*words.values()})
    return (
        len(of) >= _FEWEST_PEOPLE
        and 1 < different <= _MOST_WORDS
        and count[different] * 5 >= len(of) * 4
    )
