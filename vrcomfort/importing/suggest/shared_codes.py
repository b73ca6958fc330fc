"""Tells people apart who share a code, in two labs, groups or files; and reads ``P01_pre``."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.cells import few_texts, is_numeric, measures, texts_of_people
from vrcomfort.importing.suggest.heading_roles import Roles
from vrcomfort.importing.suggest.vocabulary import LabVocabulary

_PLACES = ("site", "group")
"""Covariates of which a person has one alone, as the place where the code was given."""
OF_EXPOSURES = frozenset([*_PLACES, "sequence"])
"""Covariates that may differ between the files of one person."""
JUDGED = ("vision", "vr_experience")
"""Covariates whose headings stand above judgements of what was shown, too."""
_COUNTS = ("trial", "period", "timepoint")
_RARE = 20
"""Of so many people one may have two ages, by a typing error."""

Keyed = Sequence[tuple[tuple[str, ...], tuple[str, ...]]]
"""Rows, each behind what is to tell its person from others."""


def constants_of(table: SourceTable, people: int, roles: Roles) -> list[int]:
    """Return the columns of what a person has but one of: age, sex, and the like."""
    columns = [c for name, c in roles.covariates.items() if name not in (*OF_EXPOSURES, *JUDGED)]
    return [c for c in columns if is_numeric(table, c) or not is_shown_in_turn(table, c, people)]


def is_shown_in_turn(table: SourceTable, column: int, participant: int) -> bool:
    """Return whether nearly all people have several numbers, or of a few words.

    They are those of conditions, or judgements of what was shown.
    """
    people = texts_of_people(table, column, participant)
    several = sum(len(words) > 1 for words in people)
    short = few_texts(table, column) or is_numeric(table, column)
    return short and several * 5 >= len(people) * 4 > 0


def are_others(tables: Sequence[SourceTable], people: int, constants: Sequence[int]) -> bool:
    """Return whether most codes have another age, sex or the like in another file or sheet."""
    rows = [((row[people], str(n)), row) for n, table in enumerate(tables) for row in table.rows]
    return _are_torn_apart(rows, constants)


def place_of(table: SourceTable, people: int, roles: Roles, taken: Iterable[int]) -> int | None:
    """Return the column with which a code is a person; None where the code is one alone.

    With it, nobody has two ages or sexes; without it, most do whose code is in several places. A
    column for the site or the group is one, too, where people are counted anew in each.
    """
    constants = constants_of(table, people, roles)
    named = [roles.covariates[name] for name in _PLACES if name in roles.covariates]
    places = [*named, *roles.facts["condition"], *roles.facts["session"], *roles.unknown]
    no_place = {people, *taken, *constants, *(c for fact in _COUNTS for c in roles.facts[fact])}
    for place in dict.fromkeys(places):
        if place in no_place or not few_texts(table, place) or measures(table, place):
            continue
        rows = [
            ((row[people], row[place]), row) for row in table.rows if row[people] and row[place]
        ]
        own = [c for c in constants if _holds_within(rows, place, c)]
        if _are_torn_apart(rows, own) or (place in named and _begins_anew(table, people, place)):
            return place
    return None


def _holds_within(rows: Keyed, place: int, constant: int) -> bool:
    """Return whether nearly nobody of a place has two texts, which are not those of the place."""
    places = {row[place] for _, row in rows}
    several = len({(row[place], row[constant]) for _, row in rows}) > len(places)
    return several and len(_torn(rows, [constant])) * _RARE <= len({key for key, _ in rows})


def _are_torn_apart(rows: Keyed, constants: Sequence[int]) -> bool:
    """Return whether most codes that are in several places have two texts of a constant."""
    places: dict[str, set[str]] = defaultdict(set)
    for (code, place), _ in rows:
        places[code].add(place)
    shared = {(code,) for code, found in places.items() if code and len(found) > 1}
    torn = _torn([((code,), row) for (code, _), row in rows], constants) & shared
    return bool(shared) and len(torn) * 2 > len(shared)


def _torn(rows: Keyed, columns: Sequence[int]) -> set[tuple[str, ...]]:
    """Return the keys that have two texts in one of the columns."""
    said: dict[tuple[tuple[str, ...], int], set[str]] = defaultdict(set)
    for key, row in rows:
        for column in columns:
            if row[column]:
                said[key, column].add(row[column])
    return {key for (key, _), found in said.items() if len(found) > 1}


def _begins_anew(table: SourceTable, people: int, place: int) -> bool:
    """Return whether a table goes through one group after the other, and counts from 1 in each."""
    groups = [*_runs(table, place)]
    codes = [{row[people] for row in rows} for rows in groups]
    counted = all(each == {str(n + 1) for n in range(len(each))} for each in codes)
    return counted and len(groups) == len(table.texts[place])


_NO_NUMBER = re.compile(r"\D+0*|^0+")


def are_met_again(table: SourceTable, people: int, place: int) -> bool:
    """Return whether a table goes through one place after the other, with the same codes in each.

    They are once in each: one person in all, or another who was numbered anew.
    """
    groups = [*_runs(table, place)]
    codes = [sorted(_NO_NUMBER.sub("", r[people]) or r[people] for r in rows) for rows in groups]
    once = len({rows[0][place] for rows in groups}) == len(groups)
    once &= len({*codes[0]}) == len(codes[0])
    return once and all(each == codes[0] for each in codes)


def _runs(table: SourceTable, column: int) -> Iterator[list[tuple[str, ...]]]:
    """Yield the rows between which the text of a column does not change."""
    rows: list[tuple[str, ...]] = []
    for row in table.rows:
        if rows and row[column] != rows[-1][column]:
            yield rows
            rows = []
        rows.append(row)
    yield rows


def with_places(table: SourceTable, people: int, place: int) -> SourceTable:
    """Return a table whose codes of people stand behind their place, as a mapping joins them."""
    rows = []
    for row in table.rows:
        both = (row[place], row[people])
        rows.append((*row[:people], "_".join(both) if all(both) else "", *row[people + 1 :]))
    return replace(table, rows=tuple(rows))


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
