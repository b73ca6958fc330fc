"""The content of an import, before it is written."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import chain
from typing import NamedTuple

from vrcomfort.errors import InputError
from vrcomfort.questionnaire import Answer, Instrument, plain


def alike(names: Iterable[str]) -> list[list[str]]:
    """Return groups of names that differ in case, spaces, signs or leading zeros alone.

    Among numbers, so do a number and one with a word: ``9`` and ``no. 9``.
    """
    names = [*names]
    groups: dict[str, list[str]] = defaultdict(list)
    numbers = sum(map(str.isdecimal, names)) * 10 >= len(names) * 8
    for name in names:
        key = re.sub(r"(?<!\d)0+(?=\d)", "", plain(name))
        if numbers:  # a number with a word, once, is the number
            key = re.sub(r"[^\W\d]+", "", key) or key
        groups[key].append(name)
    return [group for group in groups.values() if len(group) > 1]


def suspects(names: Iterable[str]) -> list[str]:
    """Return a sentence for each group of names that may be one participant."""
    return [
        f"participants {', '.join(map(repr, group))} may be one person; they are kept apart "
        "(participant values in the mapping make them one)"
        for group in alike(names)
    ]


class Administration(NamedTuple):
    """One administration of a questionnaire; blank fields are not known."""

    participant: str
    session: str
    period: str
    block: str
    trial: str
    condition: str
    scene: str
    timepoint: str

    @property
    def words(self) -> str:
        """Return the administration in words."""
        parts = [self.participant, f"session {self.session}" if self.session else ""]
        parts += [f"exposure {self.trial}" if self.trial else "", self.condition]
        parts += [self.scene, self.timepoint]
        return ", ".join(part for part in parts if part)


class SourceRow(NamedTuple):
    """Where a row came from."""

    file: str
    sheet: str
    row: int

    def __str__(self) -> str:
        sheet = f", sheet {self.sheet}" if self.sheet else ""
        return f"{self.file}{sheet}, row {self.row}"


class AnsweredAgainError(InputError):
    """An answer that another row has given for the same administration."""


@dataclass
class ImportedResponse:
    """The answers to one questionnaire in one administration."""

    place: SourceRow
    answers: dict[str, Answer | None] = field(default_factory=dict)


class Rating(NamedTuple):
    """One rating during exposure; None where it was missed."""

    administration: Administration
    instrument: str
    onset_s: float
    response: Answer | None


class ExposureEnd(NamedTuple):
    """How long an exposure lasted, and whether its participant left it."""

    administration: Administration
    end_s: float | None
    left: bool


class RowsLost(NamedTuple):
    """How many rows of a table are in no questionnaire, and the texts that say what they are."""

    table: str
    rows: int
    of: int
    texts: tuple[str, ...]


@dataclass
class Imported:
    """Everything that the files gave.

    Parameters
    ----------
    responses
        (instrument, administration) → answers, in the order of the files.
    participants
        Participant → covariate → text, in the order in which they were met.
    instruments
        Those that the answers need and that are not shipped, by name.
    scores
        Names of those among them that stand for scores without answers.
    not_asked
        Instrument → items that the mapping says were left out by design.
    ends
        How exposures ended, where files say it.
    lost
        Tables with rows that are in no questionnaire.
    silent
        Participants without an answer.
    notes
        What the user should know, one sentence each.
    """

    responses: dict[tuple[str, Administration], ImportedResponse] = field(default_factory=dict)
    ratings: list[Rating] = field(default_factory=list)
    ends: list[ExposureEnd] = field(default_factory=list)
    participants: dict[str, dict[str, str]] = field(default_factory=dict)
    instruments: dict[str, Instrument] = field(default_factory=dict)
    scores: list[str] = field(default_factory=list)
    not_asked: dict[str, tuple[str, ...]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    lost: list[RowsLost] = field(default_factory=list)
    silent: list[str] = field(default_factory=list)

    @property
    def conditions(self) -> list[str]:
        """Return the conditions in the order in which they were met."""
        every = [administration for _, administration in self.responses]
        every += [rating.administration for rating in self.ratings]
        every += [end.administration for end in self.ends]
        return list(dict.fromkeys(each.condition for each in every if each.condition))

    @property
    def answered(self) -> bool:
        """Return whether anybody answered anything, or has a leaving time."""
        answers = (
            each for response in self.responses.values() for each in response.answers.values()
        )
        ratings = (rating.response for rating in self.ratings)
        return bool(self.ends) or any(each is not None for each in chain(answers, ratings))

    @property
    def covariates(self) -> list[str]:
        """Return the names of the covariates of participants."""
        return list(dict.fromkeys(name for each in self.participants.values() for name in each))


def administration_of(facts: Mapping[str, str]) -> Administration:
    """Return the administration with these facts; the others are blank."""
    return Administration(*(facts.get(name, "") for name in Administration._fields))
