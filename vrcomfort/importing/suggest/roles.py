"""What the columns beside the answers hold: who, when, under what, and what is known of people."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from vrcomfort.importing.headings import is_number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.headings import tokens
from vrcomfort.importing.suggest.vocabulary import (
    COVARIATES,
    FACT_HEADINGS,
    METADATA,
    PERSONAL,
    TIMEPOINTS,
    TOTALS,
)
from vrcomfort.questionnaire.instruments import plain

MOST_CONDITIONS = 12

_STRONG: dict[str, frozenset[str]] = {
    "participant": frozenset(
        ["participant", "participants", "subject", "subj", "proband", "teilnehmer", "vp", "vpn",
         "ppid", "pid", "versuchsperson", "participante", "sujeto", "sujet", "deelnemer",
         "proefpersoon", "soggetto", "prolific"]
    ),
    "condition": frozenset(
        ["condition", "bedingung", "cond", "conditie", "condición", "treatment"]
    ),
    "timepoint": frozenset(["timepoint", "messzeitpunkt"]),
    "session": frozenset(["session", "sitzung"]),
    "trial": frozenset(["durchgang"]),
}  # fmt: skip
_AGE = frozenset(["old", "age", "alter"])


@dataclass
class Roles:
    """Index of a column → what its heading says it holds.

    Parameters
    ----------
    facts
        Fact → columns, the likeliest first.
    covariates
        Name → column.
    metadata
        Columns of no use to the analysis.
    unknown
        All others.
    """

    facts: dict[str, list[int]] = field(default_factory=lambda: defaultdict(list))
    covariates: dict[str, int] = field(default_factory=dict)
    metadata: list[int] = field(default_factory=list)
    unknown: list[int] = field(default_factory=list)
    alike: dict[str, list[int]] = field(default_factory=dict)
    """Fact → columns that are as likely as the likeliest."""


def roles_of(table: SourceTable, columns: Iterable[int]) -> Roles:
    """Sort columns by their headings."""
    roles = Roles()
    ranked: dict[str, list[tuple[int, int]]] = defaultdict(list)
    for column in columns:
        role = _role(table.headings[column], table.labels[column])
        if role is None:
            roles.unknown.append(column)
        elif role[0] == "metadata":
            roles.metadata.append(column)
        elif role[0] in COVARIATES:
            if role[0] in roles.covariates:
                roles.unknown.append(column)
            else:
                roles.covariates[role[0]] = column
        else:
            ranked[role[0]].append((role[1], column))
    for fact, found in ranked.items():
        roles.facts[fact] = [column for _, column in sorted(found)]
        roles.alike[fact] = [c for rank, c in sorted(found) if rank == min(found)[0]]
    return roles


def _role(heading: str, label: str) -> tuple[str, int] | None:
    """Return fact, covariate or ``metadata``, and how likely: 0 is certain."""
    roles = (_role_of(text) for text in (heading, label) if plain(text))
    return next((role for role in roles if role is not None), None)


def _role_of(text: str) -> tuple[str, int] | None:
    key, words = plain(text), set(tokens(text))
    found = [
        (fact, 0 if len(words) <= 3 else 1)
        for fact, strong in _STRONG.items()
        if words & strong and len(words) <= 12
    ]
    found += [("metadata", 0)] if key in METADATA or key in PERSONAL else []
    found += [(fact, 2) for fact, known in FACT_HEADINGS.items() if key in known]
    found += [(name, 0) for name, known in COVARIATES.items() if key in known]
    found += [("age", 1)] if words & _AGE and len(words) <= 6 else []
    long_words = {word for word in words if len(word) > 2}
    if len(words) <= 3:
        found += [(name, 1) for name, known in COVARIATES.items() if long_words & known]
    return found[0] if found else None


def is_personal(heading: str) -> bool:
    """Return whether a column may hold what tells who a person is."""
    return plain(heading) in PERSONAL


def texts(table: SourceTable, column: int) -> list[str]:
    """Return the different texts of a column, in the order of the file, without blanks."""
    return [text for text in dict.fromkeys(table.column(column)) if text]


def varies_within(table: SourceTable, column: int, participant: int | None) -> bool:
    """Return whether somebody has more than one text in a column."""
    if participant is None:
        return len(texts(table, column)) > 1
    found: dict[str, set[str]] = defaultdict(set)
    for row in table.rows:
        if row[column]:
            found[row[participant]].add(row[column])
    return any(len(each) > 1 for each in found.values())


def few_texts(table: SourceTable, column: int, most: int = MOST_CONDITIONS) -> bool:
    """Return whether a column has few different texts, each of them more than once."""
    found = texts(table, column)
    return 2 <= len(found) <= most and len(table.rows) >= 2 * len(found)


def is_numeric(table: SourceTable, column: int) -> bool:
    """Return whether all texts of a column are numbers."""
    found = texts(table, column)
    return bool(found) and all(map(is_number, found))


def total_rows(table: SourceTable, column: int) -> list[str]:
    """Return the texts of a column that name means, sums and the like, of the last rows."""
    cells = table.column(column)
    last = cells[-8:]
    found = [text for text in dict.fromkeys(last) if _is_total(text) and cells.count(text) == 1]
    return found if len(cells) >= 2 * len(found) else []


def _is_total(text: str) -> bool:
    return text.casefold().strip(" :.") in TOTALS


def are_timepoints(words: Sequence[str]) -> bool:
    """Return whether every text is a word for before, after or later."""
    return bool(words) and all(timepoint(word) is not None for word in words)


def timepoint(text: str) -> str | None:
    """Return the timepoint that a text means, such as ``Pre-VR``; None where it says none."""
    key = plain(text)
    if key in TIMEPOINTS:
        return TIMEPOINTS[key]
    found = {TIMEPOINTS[word] for word in tokens(text) if word in TIMEPOINTS}
    return found.pop() if len(found) == 1 else None
