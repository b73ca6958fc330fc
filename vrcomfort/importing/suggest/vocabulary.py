"""Reads the words of other labs' files: TOML, the shipped files and perhaps a lab's own.

A word that is in no file is no fault: it becomes a doubt in the mapping, or an ignored column.
"""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from functools import cache, cached_property, lru_cache
from itertools import chain, count, pairwise
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import Field

from vrcomfort.files import read_text
from vrcomfort.importing.source import SourceTable
from vrcomfort.questionnaire import Instrument, plain
from vrcomfort.resources import data_folder
from vrcomfort.settings import KeyPath, Problem, Settings, Word, first_problem, parse_settings

FOLDER = "vocabulary"
"""The folder of the shipped files, inside that of the instruments."""
IGNORED = "ignored"
"""The role of columns that no analysis needs."""
OUTCOME = "outcome"
"""The role of columns that a lab says are questions, ratings or measurements."""
_Words = tuple[str, ...]
UNSPACED = re.compile("[\u3040-\u30ff\u3400-\u9fff\uac00-\ud7af]")
"""A letter of a language that is written without spaces, or with endings of one letter."""
_TOKEN = re.compile(r"\d+|[^\W\d_]+")
_CAPITALS = re.compile(r"(?<=[a-zß-ÿ])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
"""Where a word begins inside ``preSSQ`` and ``SSQNausea``."""


FEWEST_OF_SENTENCE = 4
"""Words of a heading, or of an item, that is taken for a sentence."""


class WeighedSentence(NamedTuple):
    """A sentence that asks for an item, as words and their weights."""

    item: str
    weights: Mapping[str, float]


def tokens(heading: str) -> list[str]:
    """Return the words and numbers of a heading in small letters; ``preSSQ8`` is three."""
    return [*_tokens(heading)]


@lru_cache(maxsize=4096)  # each questionnaire is looked for in the same headings
def _tokens(heading: str) -> tuple[str, ...]:
    return tuple(word.casefold() for word in words_of(heading))


def words_of(heading: str) -> list[str]:
    """Return words and numbers of a heading, but for ``(0-100)``, and ``${lm://Field/1}``."""
    return _TOKEN.findall(_CAPITALS.sub(" ", _SCALE.sub(" ", heading)))


_SCALE = re.compile(
    r"[(\[]\s*[-+]?\d+\s*([-–…]|\.{2,3}|to|bis|=[^()\[\]]*[,;/–-]\s*)\s*[-+]?\d+\s*"
    r"(=[^()\[\]]*)?[)\]]|[(\[]\s*[-+]?\d+\s*=[^()\[\]]*[)\]]|\$\{[^{}]*\}"
)


class Headings(Settings):
    """Whole headings of one role."""

    labels: _Words = ()


class Labels(Headings):
    """Headings of one role, and words that speak for it in any heading or cell."""

    words: _Words = ()


class HeadingWords(Settings):
    """Words of headings of one role."""

    words: _Words = ()


class MeasureWords(HeadingWords):
    """Words of headings of what was measured, and not answered."""

    performance: _Words = ()
    """Those that keep a column from being a score, and not from being an answer."""


class FactLabels(Settings):
    """Headings of facts; where two share a word, the fact that stands first here has it."""

    participant: Labels = Labels()
    condition: Labels = Labels()
    timepoint: Labels = Labels()
    session: Labels = Labels()
    trial: Labels = Labels()
    period: Labels = Labels()
    block: Labels = Labels()
    scene: Labels = Labels()


class IgnoredLabels(Labels):
    """Headings of columns that no analysis needs; `words` are of answers in own words."""

    responses: _Words = ()
    """Those among `labels` of which each response has its own."""
    personal: _Words = ()
    """Headings of columns that may identify a person."""


class QuestionLabels(Settings):
    """Headings of a lab's own questions."""

    words: _Words = ()
    sentences: _Words = ()
    """Words of longer headings, which are sentences."""
    others: _Words = ()
    """Words and phrases that ask no opinion."""
    first_person: _Words = ()
    second_person: _Words = ()
    starts: _Words = ()
    """First words of sentences that ask no fact: how comfortable was this condition?"""
    states: _Words = ()
    """Words of statements about what was shown: it was a creative experience."""
    preferences: _Words = ()
    """Words of sentences that ask what people liked: which mode do you like best?"""


class LongLabels(Settings):
    """Headings of files with a row for each answer."""

    item: _Words = ()
    response: _Words = ()


class RatingLabels(Settings):
    """Headings of ratings during exposure."""

    seconds: _Words = ()
    words: _Words = ()
    """Words of headings of times, where numbers rise from row to row."""
    minutes: _Words = ()
    units: _Words = ()
    """Of time, but for minutes."""


class NumberedWords(Settings):
    """Words before a number in headings of answers."""

    session: _Words = ()
    trial: _Words = ()
    period: _Words = ()
    block: _Words = ()
    timepoint: _Words = ()
    condition: _Words = ()


class Fillers(Settings):
    """Words in headings of answers that name no condition, item or scale."""

    condition: _Words = ()
    item: _Words = ()
    scale: _Words = ()


class TimepointWords(Settings):
    """Words for the timepoints that every study has."""

    baseline: _Words = ()
    post: _Words = ()
    recovery: _Words = ()


class SeverityWords(Settings):
    """Answers in words, in one language."""

    none: _Words = ()
    slight: _Words = ()
    moderate: _Words = ()
    severe: _Words = ()


class DegreeWords(Settings):
    """Words and phrases by which other answers are put in order."""

    lowest: _Words = ()
    low: _Words = ()
    middle: _Words = ()
    high: _Words = ()
    highest: _Words = ()


class AgreementWords(Settings):
    """Answers to statements in words, in one language."""

    strongly_disagree: _Words = ()
    disagree: _Words = ()
    neutral: _Words = ()
    agree: _Words = ()
    strongly_agree: _Words = ()


class VocabularyFile(Settings):
    """A vocabulary file; each shipped one has some of these tables."""

    facts: FactLabels = FactLabels()
    covariates: dict[Word, Labels] = Field(default_factory=dict)
    """Name in participants.csv → its headings."""
    ignored: IgnoredLabels = IgnoredLabels()
    outcomes: Headings = Headings()
    """Columns that are questions, ratings or measurements, whatever they look like."""
    people: Headings = Headings()
    """Facts of people, called after their headings in participants.csv."""
    conditions: HeadingWords = HeadingWords()
    """Words of headings of answers that say the condition."""
    trial_runs: dict[Word, Labels] = Field(default_factory=dict)
    """Kind of column → its headings, and its texts in rows of trial runs."""
    measures: MeasureWords = MeasureWords()
    """Columns of what no questionnaire asks: physiology, performance, the room."""
    questions: QuestionLabels = QuestionLabels()
    leaving: Labels = Labels()
    """Times at which participants left exposures; in words (``Yes - 11m 56s``) below `words`."""
    long: LongLabels = LongLabels()
    ratings: RatingLabels = RatingLabels()
    numbered: NumberedWords = NumberedWords()
    fillers: Fillers = Fillers()
    scales: dict[str, dict[str, _Words]] = Field(default_factory=dict)
    """Instrument → scale → words for it."""
    missing: _Words = ()
    totals: _Words = ()
    yes: _Words = ()
    no: _Words = ()
    best: _Words = ()
    """Words for the good end of a scale of performance."""
    timepoints: TimepointWords = TimepointWords()
    severity: dict[str, SeverityWords] = Field(default_factory=dict)
    """Language → answers in words."""
    degrees: DegreeWords = DegreeWords()
    agreement: dict[str, AgreementWords] = Field(default_factory=dict)
    """Language → answers to statements in words."""
    items: dict[str, _Words] = Field(default_factory=dict)
    """Item of any instrument → spellings of its name."""
    initials: dict[str, dict[str, _Words]] = Field(default_factory=dict)
    """Instrument → item → initials that stand for it."""


def read_vocabulary(file: Path) -> VocabularyFile:
    """Read a vocabulary file.

    Raises
    ------
    InputError
        If it cannot be read, a key is unknown, or a label is blank or of two roles; with line and
        column.
    """
    text = read_text(file, "vocabulary")
    found = parse_settings(VocabularyFile, text, file)
    if problems := list(_problems(found)):
        raise first_problem(problems, text, file)
    return found


@cache
def shipped_vocabulary() -> LabVocabulary:
    """Return the vocabulary of the shipped files."""
    return LabVocabulary(())


class LabVocabulary:
    """Words of other labs' files, compiled for look-up as `plain` writes them.

    Parameters
    ----------
    own
        A lab's own files, which win over the shipped ones.
    """

    def __init__(self, own: Sequence[VocabularyFile]) -> None:
        shipped = sorted((data_folder("instruments") / FOLDER).glob("*.toml"))
        files = (*own, *map(read_vocabulary, shipped))
        merged = _merged([file.model_dump() for file in files])
        self._own_roles = {text: role for file in own[::-1] for role, _, text in _labels(file)}
        """Label of a lab's own file, or its pattern → role."""
        self._told = {plain(text): role for text, role in self._own_roles.items()}
        self.conditions = {"_".join(tokens(w)): w for w in merged["conditions"]["words"]}
        """Words that say the condition, as headings are read → as they were written."""
        self.roles = {
            key: role
            for file in files[::-1]
            for role, _, text in _labels(file)
            if "*" not in text
            for key in sorted(_keys(text))
        }
        """Label → fact, covariate, `IGNORED` or `OUTCOME`."""
        self.fact_words = _word_sets(merged["facts"], "words")
        self.covariate_words = _word_sets(merged["covariates"], "words")
        self.covariate_labels = _word_sets(merged["covariates"], "labels")
        ignored = (merged["ignored"][key] for key in ("words", "responses", "personal"))
        self.free_texts, self.responses, self.personal = map(_plain_set, ignored)
        self.trial_runs = {
            label: _plain_set(each["words"])
            for each in merged["trial_runs"].values()
            for label in _plain_set(each["labels"])
        }
        """Heading → texts of trial runs below it."""
        self.measures, self.performance = _sets(merged["measures"])
        self.asking_words, self.asking_sentences, self.asking_others, *asked = _sets(
            merged["questions"]
        )
        self.first_person, self.second_person, self.starts, self.states, self.preferences = asked
        self.leaving = tuple(tuple(tokens(label)) for label in merged["leaving"]["labels"])
        """Labels of leaving times, as words."""
        self.leaving_words = _plain_set(merged["leaving"]["words"])
        self.item_labels, self.response_labels = _sets(merged["long"])
        self.seconds, self.time_words, self.minutes, units = _sets(merged["ratings"])
        self.units = units | self.minutes
        self.numbered = _looked_up(merged["numbered"])
        """Word before a number → fact."""
        self.condition_fillers, self.item_fillers, self.scale_fillers = _sets(merged["fillers"])
        self.scales = {name: _looked_up(words) for name, words in merged["scales"].items()}
        """Instrument → word → scale."""
        self.missing = frozenset(text.casefold() for text in merged["missing"])
        self.totals = frozenset(text.casefold() for text in merged["totals"])
        self.yes, self.no = (_plain_set(merged[key]) for key in ("yes", "no"))
        self.best = _plain_set(merged["best"])
        self.timepoints = _looked_up(merged["timepoints"])
        """Word → timepoint."""
        self.severity = _by_degree(merged["severity"])
        """Word → 0 (none) to 3 (severe); the first language that has the word decides."""
        self.degrees = _by_degree({"": merged["degrees"], **merged["severity"]})
        self._longest_degree = max(map(len, self.degrees), default=0)
        """Word or phrase → 0 (lowest) to 4 (highest), by which answers are put in order."""
        self.agreement = _by_degree(merged["agreement"])
        """Word → 0 (strongly disagree) to 4 (strongly agree), likewise."""
        self._initials = {name: _looked_up(items) for name, items in merged["initials"].items()}
        self._items: Mapping[str, _Words] = merged["items"]
        self._spellings: dict[Instrument, dict[str, str]] = {}
        self._sentences: dict[Instrument, tuple[WeighedSentence, ...]] = {}
        self._all_initials: dict[Instrument, dict[str, str]] = {}

    @cached_property
    def yes_no(self) -> frozenset[str]:
        """Return the words for either."""
        return self.yes | self.no

    def told(self, heading: str) -> str:
        """Return the role that the lab's own files give a heading; blank where they are silent."""
        if not self._own_roles:
            return ""
        key = plain(heading)
        if key not in self._told:
            found = (r for text, r in self._own_roles.items() if _is_called(heading, text))
            self._told[key] = next(found, "")
        return self._told[key]

    def without_use(self, tables: Sequence[SourceTable]) -> list[str]:
        """Return the labels of the lab's own files alone that nothing in some tables is called."""
        if not self._own_roles:
            return []
        there = {text for table in tables for text in (*table.headings, *table.labels)}
        there |= {text for table in tables for words in table.texts for text in words}
        known = {*map(plain, there), *shipped_vocabulary().roles}
        own = [text for text in self._own_roles if plain(text) not in known]
        return [text for text in own if not any(_is_called(each, text) for each in there)]

    def spellings(self, instrument: Instrument) -> Mapping[str, str]:
        """Return spelling → item; the instrument's own spellings win."""
        if instrument not in self._spellings:
            found: dict[str, str] = {}
            for item in instrument.items:
                for key in item.keys:
                    found.setdefault(key, item.name)
            for item in instrument.items:
                for key in sorted(_plain_set(self._items.get(item.name, ()))):
                    found.setdefault(key, item.name)
            self._spellings[instrument] = found
        return self._spellings[instrument]

    def sentences(self, instrument: Instrument) -> tuple[WeighedSentence, ...]:
        """Return the sentences of an instrument's items, each word weighed by how rare it is."""
        if instrument not in self._sentences:
            sentences = [
                (item.name, frozenset(words))
                for item in instrument.asked
                for said in (*item.spellings(), *self._items.get(item.name, ()))
                for text in dict.fromkeys((said, said.casefold().translate(_UMLAUTS)))
                if len(words := tokens(bare(text))) >= FEWEST_OF_SENTENCE
            ]
            often = Counter(word for word, _ in {(w, i) for i, each in sentences for w in each})
            self._sentences[instrument] = tuple(
                WeighedSentence(item, {word: 1 / often[word] ** 2 for word in words})
                for item, words in sentences
            )
        return self._sentences[instrument]

    def initials(self, instrument: Instrument) -> Mapping[str, str]:
        """Return ``gd``, ``deo``, ``n`` … → item, where no two items share them."""
        if instrument not in self._all_initials:
            found: dict[str, set[str]] = {}
            for item in instrument.asked:
                words = item.name.split("_")
                short = {"".join(word[0] for word in words)}
                short.add("".join(word[0] for word in words if word != "of"))
                if len(words) == 1:
                    short |= {item.name[:length] for length in (2, 3, 4)}
                for each in short:
                    found.setdefault(each, set()).add(item.name)
            known = {each: names.pop() for each, names in found.items() if len(names) == 1}
            self._all_initials[instrument] = {**known, **self.listed_initials(instrument)}
        return self._all_initials[instrument]

    def listed_initials(self, instrument: Instrument) -> Mapping[str, str]:
        """Return initials → item, those of the vocabulary files alone: no others count so much."""
        return self._initials.get(instrument.name, {})

    def asks_of_habits(self, words: Sequence[str]) -> bool:
        """Return whether two words of a heading ask how often, how long, or the like."""
        return bool({a + b for a, b in pairwise(words)} & self.asking_others)

    def degree(self, text: str) -> int | None:
        """Return how much an answer such as ``rather not applicable`` says; None if two degrees."""
        words, place = tokens(text), 0
        said: set[int] = set()
        while place < len(words) and len(said) < 2:
            end, joined = None, ""
            for at in range(place, len(words)):
                joined += words[at]
                if len(joined) > self._longest_degree:
                    break
                end = at + 1 if joined in self.degrees else end
            if end is not None:
                said.add(self.degrees["".join(words[place:end])])
            place = end or place + 1
        return said.pop() if len(said) == 1 else None

    def timepoint(self, text: str) -> str | None:
        """Return the timepoint that a text means, such as ``Pre-VR``, or None."""
        key = plain(text)
        if key in self.timepoints:
            return self.timepoints[key]
        words = tokens(text)
        found = {self.timepoints[word] for word in words if word in self.timepoints}
        if not found and UNSPACED.search(key):
            inside = (word for word in self.timepoints if UNSPACED.search(word) and word in key)
            found = {self.timepoints[word] for word in inside}
        if found == {"post"} and any(map(str.isdecimal, words)) and self.units & {*words}:
            return "recovery"  # 15 minutes after
        return found.pop() if len(found) == 1 else None

    def moments(self, words: Sequence[str]) -> dict[str, str | None]:
        """Return word → timepoint of several words, those minutes after exposure in their order.

        The first is the timepoint after exposure if no word is; later ones have a number.
        """
        found = {word: self.timepoint(word) for word in words}
        timed = {w: int(n[0]) for w in words if found[w] == "recovery" if (n := _DIGITS.search(w))}
        if len(timed) < 2:
            return found
        names = [*([] if "post" in found.values() else ["post"]), "recovery"]
        for place, word in enumerate(sorted(timed, key=lambda each: timed[each])):
            found[word] = names[place] if place < len(names) else f"later_{timed[word]}"
        return found


_DIGITS = re.compile(r"\d+")


class Known(NamedTuple):
    """Instruments that a file may hold answers to, and the words of other labs' files."""

    instruments: Sequence[Instrument]
    vocabulary: LabVocabulary


def _is_called(heading: str, pattern: str) -> bool:
    """Return whether a pattern of headings, such as ``time_*``, has this one."""
    return "*" in pattern and fnmatchcase(heading.casefold(), pattern.casefold())


def _labels(file: VocabularyFile) -> Iterator[tuple[str, KeyPath, str]]:
    """Yield role, key path and text of each whole heading; the last one of a text wins."""
    for name, labels in reversed(file.covariates.items()):
        for place, text in enumerate(labels.labels):
            yield name, ("covariates", name, "labels", place), text
    for name in reversed(FactLabels.model_fields):
        for place, text in enumerate(getattr(file.facts, name).labels):
            yield name, ("facts", name, "labels", place), text
    for key in ("labels", "personal"):
        for place, text in enumerate(getattr(file.ignored, key)):
            yield IGNORED, ("ignored", key, place), text
    for place, text in enumerate(file.people.labels):
        yield covariate_name(text), ("people", "labels", place), text
    for place, text in enumerate(file.outcomes.labels):
        yield OUTCOME, ("outcomes", "labels", place), text


def _problems(file: VocabularyFile) -> Iterator[Problem]:
    for name in file.covariates:
        if name in FactLabels.model_fields or name == IGNORED:
            yield Problem(("covariates", name), f"`{name}` is not a covariate; write another name")
    seen: dict[str, str] = {}
    for role, path, text in reversed([*_labels(file)]):
        if not (key := plain(text)):
            yield Problem(path, "this label has no letter and no digit; write the heading")
        elif seen.setdefault(key, role) != role:
            message = f"this label is of {role} and of {seen[key]}; keep one"
            yield Problem(path, message)


def _merged(tables: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Merge tables key by key; the lists of the first ones come first."""
    merged: dict[str, Any] = {}
    for table in tables:
        for key, value in table.items():
            there = merged.get(key)
            if isinstance(value, Mapping):
                merged[key] = _merged([there or {}, value])
            else:
                merged[key] = (*(there or ()), *value)
    return merged


def covariate_name(heading: str) -> str:
    """Return a name for a column of participants.csv."""
    return "_".join("".join(c if c.isalnum() else " " for c in heading.casefold()).split()) or "x"


def free_name(name: str, taken: Container[str]) -> str:
    """Return a name, with a number where others have it."""
    numbered = (f"{name}_{number}" for number in count(2))
    return next(each for each in chain((name,), numbered) if each not in taken)


@cache
def bare(text: str) -> str:
    """Return a text without accents."""
    parts = unicodedata.normalize("NFKD", text)
    return "".join(letter for letter in parts if not unicodedata.combining(letter))


def _keys(word: str) -> set[str]:
    """Return a word as `plain` writes it, and as who has no accents on the keyboard does."""
    return {plain(word), plain(bare(word)), plain(word.casefold().translate(_UMLAUTS))} - {""}


_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "ø": "oe", "å": "aa"})


def _plain_set(words: Iterable[str]) -> frozenset[str]:
    return frozenset(key for word in words for key in _keys(word))


def _sets(table: Mapping[str, Iterable[str]]) -> Iterator[frozenset[str]]:
    return map(_plain_set, table.values())


def _word_sets(tables: Mapping[str, Any], key: str) -> dict[str, frozenset[str]]:
    return {name: _plain_set(table[key]) for name, table in tables.items() if table[key]}


def _by_degree(languages: Mapping[str, Mapping[str, Iterable[str]]]) -> dict[str, int]:
    """Return word → degree; the first language that has the word decides."""
    found: dict[str, int] = {}
    for language in languages.values():
        for degree, words in enumerate(language.values()):
            for key in _plain_set(words):
                found.setdefault(key, degree)
    return found


def _looked_up(words: Mapping[str, Iterable[str]]) -> dict[str, str]:
    """Return word → name; the first name that has the word."""
    found: dict[str, str] = {}
    for name, texts in words.items():
        for key in sorted(_plain_set(texts)):
            found.setdefault(key, name)
    return found
