"""Which items headings name, and what else stands in them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import lru_cache
from typing import Literal

from vrcomfort.importing.suggest.spellings import spellings
from vrcomfort.questionnaire import Instrument, plain

How = Literal["name", "near", "abbreviation", "initials", "number", "position"]

_TOKEN = re.compile(r"\d+|[^\W\d_]+")
_LONGEST = 40
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


def tokens(heading: str) -> list[str]:
    """Return the words and numbers of a heading in small letters; ``preSSQ8`` is three."""
    return [word.casefold() for word in words_of(heading)]


def words_of(heading: str) -> list[str]:
    """Return the words and numbers of a heading."""
    parted = re.sub(r"(?<=[a-zß-ÿ])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", heading)
    return _TOKEN.findall(parted)


def named_items(column: int, heading: str, label: str, instrument: Instrument) -> Named | None:
    """Return the item of an instrument that a heading names, or else its label.

    A name that is there wins over one that is nearly there, and that over an abbreviation.
    """
    known = spellings(instrument)
    for find in (_exact, _near, _abbreviated):
        for text, other in ((heading, label), (label, heading)):
            words = tokens(text)
            found = find(words, known, instrument)
            if found is not None:
                start, end, item = found
                more = tokens(other) if text is label else []
                before = (*more, *words[:start])
                how: How = "name" if find is _exact else "near" if find is _near else "abbreviation"
                return Named(column, instrument.name, item, how, before, tuple(words[end:]))
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
        if not (words[start].isdecimal() or words[start + length - 1].isdecimal())
    )


def _exact(words: Sequence[str], known: dict[str, str], _: Instrument) -> _Span | None:
    for start, end, key in _windows(tuple(words)):
        if key in known:
            return start, end, known[key]
    return None


def _near(words: Sequence[str], known: dict[str, str], _: Instrument) -> _Span | None:
    best: tuple[float, _Span] | None = None
    for start, end, key in _windows(tuple(words)):
        if len(key) < 5:
            continue
        for spelling, item in known.items():
            if spelling[0] != key[0] or abs(len(spelling) - len(key)) > 3:
                continue
            ratio = _likeness(spelling, key)
            if ratio >= _NEAR and (best is None or ratio > best[0]):
                best = ratio, (start, end, item)
    return best[1] if best else None


@lru_cache(maxsize=4096)
def _likeness(spelling: str, key: str) -> float:
    """Return the ratio of what two words share, or 0 where it is surely less than is asked for."""
    matcher = SequenceMatcher(None, spelling, key)
    if matcher.real_quick_ratio() < _NEAR or matcher.quick_ratio() < _NEAR:
        return 0.0
    return matcher.ratio()


def _abbreviated(words: Sequence[str], _: dict[str, str], instrument: Instrument) -> _Span | None:
    """Find ``GenDisc`` or ``stom_aware``: beginnings of the words of exactly one item."""
    for length in range(min(4, len(words)), 0, -1):
        for start in range(len(words) - length + 1):
            part = words[start : start + length]
            if any(len(word) < 3 or word.isdecimal() for word in part):
                continue
            found = [item.name for item in instrument.items if _abbreviates(part, item.name)]
            enough = length > 1 or len(part[0]) >= 4
            if len(found) == 1 and enough:
                return start, start + length, found[0]
    return None


def _abbreviates(part: Sequence[str], name: str) -> bool:
    """Return whether words are beginnings of words of a name, in order and from the first."""
    full = [word for word in name.split("_") if word not in {"of"}]
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


def initials(instrument: Instrument) -> dict[str, str]:
    """Return ``gd``, ``deo``, ``n`` … → item, where no two items share them."""
    found: dict[str, set[str]] = {}
    for item in instrument.asked:
        words = item.name.split("_")
        short = {"".join(word[0] for word in words)}
        short.add("".join(word[0] for word in words if word != "of"))
        if len(words) == 1:
            short |= {item.name[:2], item.name[:3]}
        for word in tokens(item.text):
            if len(words) == 1 and tokens(item.text) == [word]:
                short.add(word[:4])
        for each in short:
            found.setdefault(each, set()).add(item.name)
    return {each: names.pop() for each, names in found.items() if len(names) == 1}


def mentions(text: str, known: Iterable[Instrument]) -> set[str]:
    """Return the instruments that a text names by their short names."""
    words = set(tokens(text))
    joined = plain(text)
    return {
        each.name
        for each in known
        for name in {plain(each.name), plain(each.short)}
        if name in words or (len(name) > 4 and name in joined)
    }
