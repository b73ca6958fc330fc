"""Decides on the roles of columns by their headings.

Each line of `HEADINGS` is a piece of evidence: a test of a heading, the roles it speaks for, and
its weight. The heaviest one decides, for each column by itself.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence, Set
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

from vrcomfort.importing.files import JOIN
from vrcomfort.importing.mapping import FACTS
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.vocabulary import (
    FEWEST_OF_SENTENCE,
    IGNORED,
    OUTCOME,
    UNSPACED,
    LabVocabulary,
    tokens,
)
from vrcomfort.questionnaire import plain


@dataclass
class Roles:
    """The roles of columns by their headings.

    Parameters
    ----------
    facts
        Fact → columns, the likeliest first.
    covariates
        Name → column.
    metadata
        Columns that no analysis needs.
    unknown
        All others.
    outcomes
        Those among them that a lab says are answers or measurements.
    alike
        Fact → columns that are as likely as the likeliest.
    """

    facts: dict[str, list[int]] = field(default_factory=lambda: defaultdict(list))
    covariates: dict[str, int] = field(default_factory=dict)
    metadata: list[int] = field(default_factory=list)
    unknown: list[int] = field(default_factory=list)
    outcomes: set[int] = field(default_factory=set)
    alike: dict[str, list[int]] = field(default_factory=dict)

    def forget(self, column: int) -> None:
        """Take a column out of all roles, as it has been decided on."""
        for columns in (*self.facts.values(), self.metadata, self.unknown, *self.alike.values()):
            if column in columns:
                columns.remove(column)
        for name in [name for name, each in self.covariates.items() if each == column]:
            del self.covariates[name]


class HeadingEvidence(NamedTuple):
    """A test of a heading, and the roles it speaks for, the likeliest first."""

    name: str
    weight: int
    roles: Callable[[str, LabVocabulary], Iterable[str]]


def _order_of_conditions(text: str, vocabulary: LabVocabulary) -> list[str]:
    words = set(tokens(text))
    ordered = any(vocabulary.roles.get(word) == "sequence" for word in words)
    plain_label = plain(text) in vocabulary.roles
    return ["sequence"] if ordered and not plain_label and words & _conditions(vocabulary) else []


def _conditions(vocabulary: LabVocabulary) -> Set[str]:
    return vocabulary.fact_words.get("condition", frozenset())


def _fact_word(text: str, vocabulary: LabVocabulary, *, most: int) -> list[str]:
    said = tokens(text)
    words = set(said)
    sentence = len(said) >= FEWEST_OF_SENTENCE
    if len(words) > most or (
        sentence and (said[0] in vocabulary.starts or words & vocabulary.preferences)
    ):
        return []
    pairs = ((vocabulary.numbered.get(word), number) for word, number in pairwise(said))
    if len(said) > _PAIR and any(f == "condition" and n.isdecimal() for f, n in pairs):
        return []  # an answer in a condition: Q1_cond2
    return [fact for fact, known in vocabulary.fact_words.items() if words & known]


_PAIR = 2


def _label_inside(text: str, vocabulary: LabVocabulary) -> list[str]:
    """Return the role of a label in a heading of a language that is written without spaces."""
    key = plain(text)
    if len(key) > _LONGEST_UNSPACED or not UNSPACED.search(key):
        return []
    inside = [label for label in vocabulary.roles if label in key and UNSPACED.search(label)]
    return [vocabulary.roles[max(inside, key=len)]] if inside else []


_LONGEST_UNSPACED = 20


def _label(text: str, vocabulary: LabVocabulary, kind: Callable[[str], bool]) -> list[str]:
    role = vocabulary.roles.get(plain(text), "")
    return [role] if role and kind(role) else []


def _covariate_word(text: str, vocabulary: LabVocabulary) -> list[str]:
    said = tokens(text)
    words = set(said)
    if len(words) > 6 or (len(said) >= FEWEST_OF_SENTENCE and words & vocabulary.states):
        return []
    return [name for name, known in vocabulary.covariate_words.items() if words & known]


def _word_of_covariate_label(text: str, vocabulary: LabVocabulary) -> list[str]:
    words = set(tokens(text))
    if len(words) > 3:
        return []
    long = {word for word in words if len(word) > 2}
    return [name for name, known in vocabulary.covariate_labels.items() if long & known]


def _free_text(text: str, vocabulary: LabVocabulary) -> list[str]:
    return [IGNORED] if vocabulary.free_texts & {*tokens(text)} else []


def _measure_word(text: str, vocabulary: LabVocabulary) -> list[str]:
    words = set(tokens(text))
    return [IGNORED] if len(words) <= 5 and words & vocabulary.measures else []


def _row_number(text: str, _: LabVocabulary) -> list[str]:
    return [IGNORED] if _ROW_NUMBER.fullmatch(text) else []


_ROW_NUMBER = re.compile(
    r"(?i)unnamed: ?\d+|row ?(names?|no|number|id)?|zeile|x\.?1|index|(group|gruppen|page)time ?\d+"
    r"|time\d{3}|rts ?\d+|.*[_ ]((first|last) click|page submit|click count)|\S+_DO(_.+)?"
    r"|(gesamtzeit|total time)|((gruppen|fragen)zeit|(group|question) time):.*"
    r"|.+\.(started|stopped|this(Rep|Trial)?N|thisIndex)|\S+_complete"
)
"""What pandas and R call rows, and columns without a name; times and orders of survey programs."""
HEADINGS: tuple[HeadingEvidence, ...] = (
    HeadingEvidence("words for an order and for conditions", 105, _order_of_conditions),
    HeadingEvidence(
        "a word for a fact, among at most 3 words", 100, lambda t, v: _fact_word(t, v, most=3)
    ),
    # Longer texts are questions ("Which condition did you just complete?"); beyond a dozen words
    # they are instructions, which mention anything.
    HeadingEvidence(
        "a word for a fact, among at most 12 words", 90, lambda t, v: _fact_word(t, v, most=12)
    ),
    HeadingEvidence("a word for what no questionnaire asks", 85, _measure_word),
    HeadingEvidence("a word for answers in own words", 84, _free_text),
    HeadingEvidence("a number of the row, or a column without a name", 82, _row_number),
    HeadingEvidence(
        "a label that no analysis needs", 80, lambda t, v: _label(t, v, IGNORED.__eq__)
    ),
    HeadingEvidence("a label of a fact", 70, lambda t, v: _label(t, v, FACTS.__contains__)),
    HeadingEvidence(
        "a label of a covariate",
        60,
        lambda t, v: _label(t, v, lambda r: r not in {*FACTS, IGNORED, OUTCOME}),
    ),
    HeadingEvidence("a label in a heading without spaces", 55, _label_inside),
    HeadingEvidence("a word for a covariate, among at most 6 words", 50, _covariate_word),
    HeadingEvidence(
        "a word that is a covariate's label, among at most 3 words", 40, _word_of_covariate_label
    ),
)


_BY_WEIGHT = sorted(HEADINGS, key=lambda each: -each.weight)


def roles_of(table: SourceTable, columns: Iterable[int], vocabulary: LabVocabulary) -> Roles:
    """Decide on the roles of columns by their headings, or else by their labels."""
    roles = Roles()
    weighed: dict[str, list[tuple[int, int]]] = defaultdict(list)
    merged = Counter(around(heading)[0] for heading in table.headings)
    times = {f"{heading.partition('[')[0]}Time" for heading in table.headings}  # of answers
    for column in columns:
        outer, inner = around(table.headings[column])
        label = table.labels[column]
        said = inner_names(table.headings[column]) if table.nested else ()
        if code := _CODE_AND_TEXT.fullmatch(table.headings[column]):
            said = (code[2],) if code[1] == "id" else (code[2], code[1])  # that of the response
        without = _REMARK.sub("", table.headings[column])  # Session (of this participant)
        said = (*said, without, table.headings[column], label, *label.split(" | "))
        role, weight = _heaviest(said, vocabulary)
        role = IGNORED if table.headings[column] in times else role
        if table.nested and _heaviest(said[:1], vocabulary)[0]:
            weight += _OWN_NAME
        cell, _, key = table.headings[column].partition(".")
        unpacked = role == IGNORED and key and cell in table.headings  # feedback.q1
        asks = role not in {*FACTS, IGNORED} or len(tokens(outer)) >= FEWEST_OF_SENTENCE
        if unpacked or (outer and merged[outer] > 1 and asks):
            last = key if unpacked else inner  # Hand tracking / SUS: no handedness
            role, weight = _heaviest((last,), vocabulary)
        told = vocabulary.told(table.headings[column]) or vocabulary.told(label)
        role, weight = (told, _TOLD) if told else (role, weight)
        if role == OUTCOME:
            roles.outcomes.add(column)
        if role in {"", OUTCOME}:
            roles.unknown.append(column)
        elif role == IGNORED:
            roles.metadata.append(column)
        else:
            weighed[role].append((-weight, column))
    for role, found in weighed.items():
        ordered = [column for _, column in sorted(found)]
        if role == "participant":  # "stopped by the participant?"
            ordered = [c for c in ordered if not {*table.texts[c]} <= {"0", "1"}] or ordered
        if role in FACTS:
            roles.facts[role] = ordered
            roles.alike[role] = [c for weight, c in sorted(found) if weight == min(found)[0]]
            roles.unknown = sorted({*roles.unknown, *(c for _, c in found)} - {*ordered})
        else:
            taken = 0 if role == "sequence" and len(ordered) > _MOST_ORDERS else 1  # order_colour
            roles.covariates |= dict.fromkeys([role][:taken], ordered[0])
            roles.unknown = sorted([*roles.unknown, *ordered[taken:]])
    return roles


_MOST_ORDERS = 2
"""More columns of orders than this rank something."""
_TOLD = 1000
_OWN_NAME = 100
"""The name of a nested value counts more than that of a record around it."""
_REMARK = re.compile(r"\s*\([^()]*\)$")
_CODE_AND_TEXT = re.compile(r"([A-Za-z][A-Za-z0-9_]{0,19})\. (\S.*)")
"""Headings of a survey program that writes the code of a question before its text."""


def around(heading: str) -> tuple[str, str]:
    """Return the cell or question around a heading, and its own: ``How tight is it?.Screws``."""
    outer, _, inner = heading.rpartition(JOIN)
    question, _, row = heading.rpartition(".")
    asks = not outer and row and len(tokens(question)) >= FEWEST_OF_SENTENCE
    return (question, row) if asks else (outer, inner)


def inner_names(heading: str) -> tuple[str, ...]:
    """Return the name of a nested value: ``condition``, or ``person id`` if it is an id."""
    parts = heading.split(".")
    generic = plain(parts[-1]) in _GENERIC and len(parts) > 1
    return (" ".join(parts[-2:]),) if generic else (parts[-1],)


_GENERIC = frozenset(["id", "name", "number", "no", "nr", "code", "index", "type", "label"])


def _heaviest(said: Sequence[str], vocabulary: LabVocabulary) -> tuple[str, int]:
    """Return role and weight of the heaviest evidence in the first text that has any."""
    for text in said:
        if plain(text):
            for evidence in _BY_WEIGHT:
                for role in evidence.roles(text, vocabulary):
                    return role, evidence.weight
    return "", 0


def names_fact(heading: str, fact: str, vocabulary: LabVocabulary) -> bool:
    """Return whether a heading alone says that its column is of a fact."""
    return (vocabulary.told(heading) or _heaviest((heading,), vocabulary)[0]) == fact


PERSON_CODE = re.compile(r"(p|s|vp|id|pp|sub|subj|subject|participant|user|proband)[ _-]?\d+", re.I)
"""A heading that is the code of a person."""


def is_personal(heading: str, vocabulary: LabVocabulary) -> bool:
    """Return whether a column may identify a person."""
    return plain(heading) in vocabulary.personal
