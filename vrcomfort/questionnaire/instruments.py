"""Instruments: items, wording, answers, and the scales made of them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property, lru_cache
from typing import Literal

from vrcomfort.questionnaire.answers import Answer, Answers
from vrcomfort.questionnaire.scales import Scale


@dataclass(frozen=True)
class Wording:
    """An item in one language: its text, and other headings under which labs export it."""

    language: str
    text: str
    aliases: tuple[str, ...] = ()


@dataclass(frozen=True)
class Translation:
    """An instrument's instruction and labels in another language, with their source."""

    instruction: str | None = None
    labels: tuple[str, ...] = ()
    source: str = ""


@dataclass(frozen=True)
class Item:
    """One question.

    Parameters
    ----------
    name
        As it stands in ``questionnaires.csv``.
    text
        As it is asked; the name where the wording is the lab's to give.
    answers
        What can be answered.
    aliases
        Other headings under which labs export it, compared without case, spaces and punctuation.
    reversed
        A high answer counts as a low one.
    asked
        False for what is not asked item by item, such as weights from comparisons.
    wordings
        The item in other languages.
    worded
        False where the file gives no text, and `text` is the name.
    """

    name: str
    text: str
    answers: Answers
    aliases: tuple[str, ...] = ()
    reversed: bool = False
    asked: bool = True
    wordings: tuple[Wording, ...] = ()
    worded: bool = True

    @cached_property
    def keys(self) -> frozenset[str]:
        """Return every spelling of this item, as `plain` writes them."""
        return frozenset(plain(word) for word in self.spellings())

    def spellings(self, language: str | None = None) -> tuple[str, ...]:
        """Return name, text and aliases: in one language, or in all."""
        own = (self.name, self.text, *self.aliases)
        found = [each for each in self.wordings if language in (None, each.language)]
        others = tuple(word for each in found for word in (each.text, *each.aliases))
        return own if not others else (self.name, *others) if language else (*own, *others)


@dataclass(frozen=True)
class Instrument:
    """A questionnaire or a rating scale.

    Parameters
    ----------
    name
        As it stands in files; no two instruments share one.
    short, title
        As headings name it: SSQ, Simulator Sickness Questionnaire.
    instruction
        What is asked of all items.
    items
        The questions, in the order in which they are asked.
    answers
        What can be answered to items that say nothing else.
    scales
        In the order of the file; items that none counts are scales of their own, at the end.
    primary
        Name of the scale that is reported first.
    citation, sources
        The paper, and every other place that the file is made from.
    rule
        A sentence on how it is scored, for the methods.
    language
        Of the wording.
    variant_of
        The instrument whose items these are with other answers: never taken for it, and it never
        for this.
    """

    name: str
    short: str
    title: str
    instruction: str
    items: tuple[Item, ...]
    answers: Answers
    scales: tuple[Scale, ...]
    primary: str
    citation: str = ""
    sources: tuple[str, ...] = ()
    rule: str = ""
    language: str = "en"
    variant_of: str = ""
    asks: Literal["symptoms", "questions"] = "questions"
    """What reports call its items."""
    prefixed: bool = True
    """Whether plans and tables put the instrument's name before those of its scores and items."""
    licence: str = ""
    """What allows the wording to be here."""
    translations: Mapping[str, Translation] = field(default_factory=dict, repr=False, hash=False)
    """Language → what is asked of all items in it."""
    text: str = field(default="", repr=False)
    """The TOML that it was read from."""
    not_asked: tuple[str, ...] = ()
    """Items that a study left out by design; see `instrument_file.short_form`."""
    shortened: tuple[str, ...] = ()
    """Scales made of the other items of those that they are made of otherwise."""
    unscored: Mapping[str, str] = field(default_factory=dict, repr=False, hash=False)
    """Scale → why it has no score without those items."""

    def __hash__(self) -> int:
        return hash(self.name)  # that of every item and fraction takes longer than what it serves

    @property
    def low(self) -> Answer:
        """Return the lowest answer."""
        return self.answers.low

    @property
    def high(self) -> Answer:
        """Return the highest answer."""
        return self.answers.high

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the names of the answers, or of the two ends."""
        return self.answers.labels

    @property
    def asked(self) -> tuple[Item, ...]:
        """Return the items that are asked one after the other."""
        return tuple(item for item in self.items if item.asked)

    @property
    def unworded(self) -> tuple[str, ...]:
        """Return the names of the asked items that have no text to be asked with."""
        return tuple(item.name for item in self.asked if not item.worded)

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Return the names of the scales in the order of reports: the primary one first."""
        return tuple(sorted((s.name for s in self.scales), key=lambda name: name != self.primary))

    @cached_property
    def needed(self) -> tuple[str, ...]:
        """Return the names of the scales that a complete response has."""
        found: list[str] = []
        asked = {item.name for item in self.asked}
        for scale in self.scales:
            items = {term.item for term in scale.terms} | {name for _, name in scale.weights}
            if items <= asked and all(name in found for name, _ in scale.parts):
                found.append(scale.name)
        return tuple(found)

    def may_miss(self, item: Item) -> bool:
        """Return whether an answer may be missing in a questionnaire that has all its scores."""
        scales = [s for s in self.scales if any(term.item == item.name for term in s.terms)]
        return not item.asked or all(scale.min_valid < len(scale.terms) for scale in scales)

    def scale(self, name: str) -> Scale | None:
        """Return the scale of a name, or None."""
        return next((scale for scale in self.scales if scale.name == name), None)

    @cached_property
    def _found(self) -> dict[tuple[str, str | None], Item | None]:
        """Items by headings that were looked up: a long file has each thousands of times."""
        return {}

    def item(self, heading: str, language: str | None = None) -> Item | None:
        """Return the item that a human-readable heading means, or None.

        Parameters
        ----------
        language
            Such as "de": look among its words and the items' names alone. All otherwise.
        """
        asked = heading, language
        if asked not in self._found:
            key = plain(heading)
            found = (
                item
                for item in self.items
                if key in (item.keys if language is None else map(plain, item.spellings(language)))
            )
            self._found[asked] = next(found, None)
        return self._found[asked]

    def may_mean(self, heading: str, item: Item) -> bool:
        """Return whether a heading that names no item has the words of this one in it.

        As "8. Nausea", "ssq_nausea" and "Nausae" have; headings of sums and scores say so.
        """
        words = _words(heading)
        if self.item(heading) is not None or words & DERIVED:
            return False
        names = [_words(name) for name in item.spellings()]
        if any(name and name <= words for name in names):
            return True
        misspelt = any(key[:1] == plain(heading)[:1] for key in item.keys)  # "comfort" is another
        return misspelt and self.nearest(heading) == item.name

    def nearest(self, heading: str) -> str | None:
        """Return the item name that looks most like a heading that is none."""
        spellings = {key: item.name for item in self.items for key in item.keys}
        near = get_close_matches(plain(heading), spellings, n=1, cutoff=0.75)
        return spellings[near[0]] if near else None

    def in_language(self, language: str) -> Instrument | None:
        """Return the instrument as it is asked in a language, or None where it has no words."""
        if language == self.language:
            return self
        if self.lacks(language):
            return None
        given = self.translations[language]
        answers = replace(self.answers, labels=given.labels)

        def worded(item: Item) -> Item:
            text = next((w.text for w in item.wordings if w.language == language), item.text)
            own = item.answers != self.answers
            answered = item.answers if own else answers
            return replace(item, text=text, answers=answered, worded=True)

        return replace(
            self,
            items=tuple(worded(item) for item in self.items),
            answers=answers,
            instruction=given.instruction or "",
            language=language,
        )

    def lacks(self, language: str) -> list[str]:
        """Return the texts that a language lacks, in words."""
        if language == self.language:
            return []
        given = self.translations.get(language, Translation())
        missing = [] if given.instruction else ["the instruction"]
        if self.labels and not given.labels:
            missing.append("the labels of its answers")
        return missing + [
            f"item {item.name}"
            for item in self.asked
            if all(wording.language != language for wording in item.wordings)
        ]

    def with_translation(
        self, language: str, given: Translation, items: Mapping[str, str]
    ) -> Instrument:
        """Return the instrument with texts of a language; they replace its own.

        Parameters
        ----------
        items
            Item → its text.
        """
        before = self.translations.get(language, Translation())
        whole = Translation(
            given.instruction or before.instruction,
            given.labels or before.labels,
            given.source or before.source,
        )
        if language == self.language:
            return self._reworded(given, items, {**self.translations, language: whole})

        def worded(item: Item) -> Item:
            if item.name not in items:
                return item
            others = tuple(each for each in item.wordings if each.language != language)
            new = Wording(language, items[item.name])
            return replace(item, wordings=(*others, new))

        asked = tuple(worded(item) for item in self.items)
        return replace(self, items=asked, translations={**self.translations, language: whole})

    def _reworded(
        self,
        given: Translation,
        items: Mapping[str, str],
        translations: Mapping[str, Translation],
    ) -> Instrument:
        """Return the instrument with other words of its own language."""
        answers = replace(self.answers, labels=given.labels or self.labels)

        def reworded(item: Item) -> Item:
            answered = answers if item.answers == self.answers else item.answers
            if item.name not in items:
                return replace(item, answers=answered)
            return replace(item, text=items[item.name], worded=True, answers=answered)

        return replace(
            self,
            items=tuple(reworded(item) for item in self.items),
            answers=answers,
            instruction=given.instruction or self.instruction,
            translations=translations,
        )

    def wording_source(self, language: str) -> str:
        """Return the source of the wording in a language."""
        source = self.translations.get(language, Translation()).source
        return source or (self.licence if language == self.language else "")


DERIVED = frozenset(
    ["sum", "total", "score", "scores", "raw", "mean", "average", "scale", "subscale", "weighted",
     "rt", "time", "ms", "onset", "fms", "misc"]
)  # fmt: skip
"""Words of headings that stand over what was made of answers, beside them, or asked otherwise."""


def _words(heading: str) -> frozenset[str]:
    """Return the words of a heading in lower case, ``SsqNausea8`` being three."""
    parts = re.findall(r"[^\W\d_]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", heading))
    return frozenset(part.casefold() for part in parts)


@lru_cache(maxsize=4096)  # words of a table are compared with those of each instrument
def plain(heading: str) -> str:
    """Return the letters and digits of a heading in lower case."""
    return re.sub(r"[\W_]+", "", heading.casefold())
