"""Weighs the evidence for the role of each column beside the answers, by its cells.

Each line of `CELLS` is one piece of evidence: a named test of a column in the light of decisions
before, such as those by headings; the role it speaks for; and its weight. A role chooses among
columns: the heaviest evidence decides, and of equal evidence the first column. A new kind of layout
begins with a line here, or in `heading_roles`.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.cells import (
    DATE_OR_TIME,
    LONGEST_CODE,
    MOST_CONDITIONS,
    counts_of_people,
    few_texts,
    is_balanced,
    is_numeric,
    measures,
    texts,
    values_of,
    varies_within,
)
from vrcomfort.importing.suggest.heading_roles import Roles, around, is_personal, names_fact
from vrcomfort.importing.suggest.vocabulary import FEWEST_OF_SENTENCE, LabVocabulary, tokens
from vrcomfort.importing.text_files import KEY
from vrcomfort.questionnaire import plain

FIRST_COLUMNS = 4
"""Columns in which codes of participants, and names of rows below them, are looked for."""


@dataclass
class Context:
    """A table in the light of decisions before.

    Parameters
    ----------
    participant
        The column of the participants, if there is one.
    one_row_each
        A row is a person or a questionnaire, and not an answer.
    time
        The column of the seconds of ratings.
    used
        Columns that have a role.
    columns
        Fact → its columns, as decided so far.
    covariates
        Name → its column, as decided so far.
    derived
        Columns that are sums or means of others.
    symptoms
        The answers are to symptoms, which are asked before exposure, too.
    judged
        Where answers are to what was used: a column, and its text in the rows of such answers.
    """

    table: SourceTable
    vocabulary: LabVocabulary
    roles: Roles
    one_row_each: bool = True
    time: int | None = None
    participant: int | None = None
    used: set[int] = field(default_factory=set)
    columns: dict[str, tuple[int, ...]] = field(default_factory=dict)
    covariates: dict[str, int] = field(default_factory=dict)
    derived: frozenset[int] = frozenset()
    symptoms: bool = True
    judged: Sequence[tuple[int, str | None]] = ()

    @property
    def sources(self) -> list[int]:
        """Return the columns of facts and of covariates, as decided so far."""
        facts = (column for columns in self.columns.values() for column in columns)
        return sorted({*facts, *self.covariates.values()})

    def code_of_rows(self, column: int) -> int | None:
        """Return the column of codes that rows share, crossed with words, where one counts rows."""
        table, open_ = self.table, [*self.roles.unknown, *self.roles.metadata]
        said = tokens(f"{table.headings[column]} {table.labels[column]}")
        named = {*said} & self.vocabulary.fact_words["participant"]
        shown = [*self.roles.facts["condition"], *self.roles.facts["timepoint"]]
        words = [c for c in (*open_, *shown) if few_texts(table, c) and not is_numeric(table, c)]
        for other in open_ if not named and len(texts(table, column)) == len(table.rows) else ():
            codes = len(texts(table, other))
            if codes < _FEWEST_PEOPLE or "" in table.column(other) or measures(table, other):
                continue
            often = {
                c for c in (other, *words) if len(counts_of_people(table, c, other)) > codes // 2
            }
            fewer = (c for c in often if len(texts(table, c)) < codes)
            if other in often and any(is_balanced(table, c, other) for c in fewer):
                return other
        return None


class CellEvidence(NamedTuple):
    """A test of a column's cells, the role it speaks for, and the doubt it leaves."""

    role: str
    name: str
    weight: int
    test: Callable[[Context, int], bool]
    assumed: str = ""
    question: str = ""


class Candidate(NamedTuple):
    """A column that may have a role, and its heaviest evidence."""

    column: int
    evidence: CellEvidence


def is_identifier(table: SourceTable, column: int, vocabulary: LabVocabulary) -> bool:
    """Return whether a column tells people or rows apart: by heading, or as its numbers rise."""
    if table.reading.heading_rows and names_fact(table.headings[column], "participant", vocabulary):
        return True
    cells = table.column(column)
    if not all(map(str.isdecimal, cells)):
        return False
    numbers = [*map(int, cells)]
    return len({*numbers}) >= _FEWEST_PEOPLE and numbers == sorted(numbers)


def _counts_rows(context: Context, column: int) -> bool:
    """Return whether a column without a heading holds 0, 1, 2 … or 1, 2, 3 …: R's row names."""
    table, cells = context.table, context.table.column(column)
    nameless = table.headings[column].startswith("column ")
    count = [str(n) for n in range(len(cells) + 1)]
    return nameless and len(cells) > 1 and cells in (count[:-1], count[1:])


def _tells_people_apart(context: Context, column: int) -> bool:
    table = context.table
    named = table.headings[column] == KEY  # the names of the records of a JSON file
    if not named and column not in context.roles.unknown[:FIRST_COLUMNS]:
        return False
    words, rows = texts(table, column), len(table.rows)
    if (
        not words
        or all(map(context.vocabulary.timepoint, words))
        or all(map(DATE_OR_TIME.match, words))
    ):
        return False
    asked = {*tokens(table.headings[column])} & (context.vocabulary.item_labels | {"question"})
    if _counts_rows(context, column) or (asked and not named and not table.reading.transpose):
        return False  # QuestionId
    if column == context.time or {*tokens(table.headings[column])} & context.vocabulary.time_words:
        return False
    whole = all(value.is_integer() for value in values_of(table, column))
    if is_numeric(table, column) and (_are_ages(words) or not whole):
        return False
    each_row = len(words) == rows
    # Long tables have many rows for each person; without headings or on its side, codes repeat.
    few_rows = not context.one_row_each and 1 < len(words) <= rows / 4
    in_front = (not table.reading.heading_rows and len(words) * 4 >= rows) or (
        table.reading.transpose and column == 0 and len(words) > 1
    )
    return (each_row or few_rows or in_front) and max(map(len, words)) <= LONGEST_CODE


def says_no_person(table: SourceTable, column: int, vocabulary: LabVocabulary) -> bool:
    """Return whether a column has truth values, or mostly sentences: it tells no people apart."""
    words = texts(table, column)
    flags = bool(words) and all(plain(word) in vocabulary.yes_no for word in words)
    return flags or sum(len(word.split()) > 4 for word in words) * 2 > len(words)


def _are_ages(words: Sequence[str]) -> bool:
    """Return whether numbers are in no order, and can be years of age."""
    whole = all(map(str.isdecimal, words))
    numbers = [*map(int, words)] if whole else []
    return whole and numbers != sorted(numbers) and 15 <= min(numbers) <= max(numbers) <= 99


def _numbers_responses(context: Context, column: int) -> bool:
    """Return whether a column has the key of each response, where no row is of another person."""
    words = texts(context.table, column)
    labelled = plain(context.table.headings[column]) in context.vocabulary.responses
    return labelled and len(words) == len(context.table.rows) and context.one_row_each


def _codes_in_equally_many_rows(context: Context, column: int) -> bool:
    """Return whether a column of the first ones has codes such as P01, in several rows each.

    They are equally often there, or count on from 1 behind one letter or word.
    """
    counts = Counter(cell for cell in context.table.column(column) if cell)
    codes = [re.fullmatch(r"([^\W\d_]{1,12}[ _-]?)(\d+)", text) for text in counts]
    if column not in context.roles.unknown[:FIRST_COLUMNS] or len(counts) < _FEWEST_PEOPLE:
        return False
    parts = [(code[1], int(code[2])) for code in codes if code is not None]
    count_on = {number for _, number in parts} == {*range(1, len(counts) + 1)}
    one_way = count_on and len({word for word, _ in parts}) == 1
    several = max(counts.values()) > 1 and (one_way or len({*counts.values()}) == 1)
    return len(parts) == len(counts) and several


_FEWEST_PEOPLE = 5


def _meets_all_words(context: Context, column: int) -> bool:
    """Return whether a column of the first ones is crossed with fewer words of another.

    So people are with conditions. They have codes, or stand in a table without headings.
    """
    table, open_ = context.table, context.roles.unknown
    codes = texts(table, column)
    if column not in open_[:FIRST_COLUMNS] or len(codes) < _FEWEST_PEOPLE:
        return False
    if any(map(DATE_OR_TIME.match, codes)) or max(map(len, codes)) > LONGEST_CODE:
        return False
    if table.reading.heading_rows and not all(re.search(r"\d", code) for code in codes):
        return False
    words = (c for c in (*open_, *context.roles.facts["condition"]) if few_texts(table, c))
    words = (c for c in words if c != column and not is_numeric(table, c))
    return any(len(texts(table, c)) < len(codes) and is_balanced(table, c, column) for c in words)


def asks_name(table: SourceTable, column: int, vocabulary: LabVocabulary) -> bool:
    """Return whether a heading, or the text of its question, asks who the person is."""
    return any(
        is_personal(said, vocabulary) for said in (table.headings[column], table.labels[column])
    )


def _codes_of_people(context: Context, column: int) -> bool:
    words = texts(context.table, column)
    codes = all(re.fullmatch(r"[\w -]*\d[\w -]*", w) and len(w) <= LONGEST_CODE for w in words)
    personal = asks_name(context.table, column, context.vocabulary)
    return column in context.roles.metadata and personal and len(words) >= _FEWEST_NAMES and codes


def _recurring_names(context: Context, column: int) -> bool:
    """Return whether a column under a heading for names has each of several people a few times."""
    counts = Counter(cell for cell in context.table.column(column) if cell)
    personal = asks_name(context.table, column, context.vocabulary)
    again = sum(count > 1 for count in counts.values())
    several = len(counts) >= _FEWEST_NAMES and again * 5 >= len(counts) * 4
    filled = sum(counts.values()) * 5 >= len(context.table.rows) * 4
    return column in context.roles.metadata and personal and several and filled


_FEWEST_NAMES = 4
"""Fewer names may be those of conditions."""


def _timepoints_under_heading(context: Context, column: int) -> bool:
    return column in context.roles.facts["timepoint"] and bool(_timepoints(context, column))


def _several_timepoints(context: Context, column: int) -> bool:
    open_ = {*context.roles.unknown, *context.roles.metadata}  # the name of a program's form
    return column in open_ and len(set(_timepoints(context, column))) > 1


def _timepoints(context: Context, column: int) -> list[str]:
    """Return the timepoints that a column's texts mean; none where one means none."""
    words = [context.table.meaning(column, word) for word in texts(context.table, column)]
    found = [context.vocabulary.timepoint(word) for word in words]
    said = [when for when in found if when is not None]
    return said if len(said) == len(found) <= 8 else []


def _baseline_among_conditions(context: Context, column: int) -> bool:
    """Return whether some texts of a column mean before exposure, and others conditions."""
    roles = context.roles.facts
    open_ = {*roles["timepoint"], *roles["condition"]}
    if context.table.reading.transpose and column == 0:
        open_.add(column)
    # Ratings are given during exposure, and a system is judged after its use.
    if column not in open_ or context.time is not None or not context.symptoms:
        return False
    when = context.vocabulary.timepoint
    before = [row for row in context.table.rows if when(row[column]) == "baseline"]
    if any(row[c] == said or (not said and row[c]) for row in before for c, said in context.judged):
        return False
    said = [when(word) for word in texts(context.table, column)]
    mixed = "baseline" in said and None in said and "post" not in said
    return mixed and len(said) <= MOST_CONDITIONS


def _other_texts_under_timepoint(context: Context, column: int) -> bool:
    named = column in context.roles.facts["timepoint"] and column not in context.used
    words = texts(context.table, column)
    counted = column in context.roles.unknown and all(map(_MOMENT.fullmatch, words))
    return (named or counted) and 1 < len(words) <= 5


_MOMENT = re.compile(r"[tT] ?\d{1,2}")
"""A moment such as ``T1``, under any heading."""


def _order_within_people(context: Context, column: int) -> bool:
    within = context.participant is not None and varies_within(
        context.table, column, context.participant
    )
    named = context.roles.covariates.get("sequence") == column
    return named and within and is_numeric(context.table, column)


def _differs_within_people(context: Context, column: int) -> bool:
    """Return whether a column has few texts, of which most participants have several."""
    table, open_ = context.table, {*context.roles.unknown, *context.roles.facts["scene"]}
    if context.participant is None or column not in open_ - context.used:
        return False
    if column in context.derived or not few_texts(table, column) or measures(table, column):
        return False
    if {*tokens(table.headings[column])} & context.vocabulary.scale_fillers:
        return False  # a sum or a score
    people = counts_of_people(table, column, context.participant)
    return 2 * sum(len(counts) > 1 for counts in people) > len(people)


def _words_within_people(context: Context, column: int) -> bool:
    """Return whether a column has words that differ within participants; Yes and No come last."""
    if not _differs_within_people(context, column) or is_numeric(context.table, column):
        return False
    return not _says_yes_or_no(context, column) or not any(
        _words_within_people(context, other)
        for other in context.roles.unknown
        if other != column and not _says_yes_or_no(context, other)
    )


def _balanced_words(context: Context, column: int) -> bool:
    who = context.participant
    return _words_within_people(context, column) and is_balanced(context.table, column, who)


def _balanced_numbers(context: Context, column: int) -> bool:
    """Return whether numbers are those of conditions: others are counted or measured."""
    numbers = _differs_within_people(context, column) and is_numeric(context.table, column)
    return numbers and is_balanced(context.table, column, context.participant)


def _says_yes_or_no(context: Context, column: int) -> bool:
    words = texts(context.table, column)
    return all(plain(word) in context.vocabulary.yes_no for word in words)


def _few_scenes(context: Context, column: int) -> bool:
    """Return whether a column under a heading for scenes has two or a few words, no more."""
    named = column in context.roles.facts["scene"] and column not in context.used
    return named and few_texts(context.table, column, most=_FEW_SCENES)


_FEW_SCENES = 4


def _counts_exposures(context: Context, column: int) -> bool:
    facts = (fact for fact in ("trial", "session", "period") if fact in context.columns)
    finest = next((context.columns[fact][0] for fact in facts), None)
    if context.participant is None or column != finest:
        return False
    if not all(context.table.column(column)):
        return False  # a count of what some questionnaires alone repeat
    return varies_within(context.table, column, context.participant)


def _words_without_people(context: Context, column: int) -> bool:
    """Return whether one of the first columns has few words, where nothing tells people apart."""
    open_ = {*context.roles.unknown[:FIRST_COLUMNS]} - context.used
    behind = column * 2 > len(context.table.headings)  # grades and verdicts follow the answers
    if context.participant is not None or column not in open_ or behind:
        return False
    words = texts(context.table, column)
    if all(map(context.vocabulary.timepoint, words)) or _asks_person(context, column):
        return False
    if _says_yes_or_no(context, column):
        return False  # an answer to a question of the lab's own
    numbers = is_numeric(context.table, column) or measures(context.table, column)
    return not numbers and few_texts(context.table, column)


def _asks_person(context: Context, column: int, role: str = "condition") -> bool:
    """Return whether a heading asks people of themselves, and not for a role.

    What they ``did`` just use may be a condition, and so may the group of which they are.
    """
    said = tokens(f"{context.table.headings[column]} {context.table.labels[column]}")
    told = {context.vocabulary.roles.get(word) for word in said}
    shown = context.vocabulary.fact_words["condition"] | {"did", "assigned"}
    named = role in told if role == "participant" else "group" in told or {*said} & shown
    asked = bool({*said} & context.vocabulary.second_person)
    return len(said) >= FEWEST_OF_SENTENCE and asked and not named


def _groups_people(context: Context, column: int) -> bool:
    return column == context.covariates.get("group", context.covariates.get("sequence"))


def _constant_within_people(context: Context, column: int) -> bool:
    table, who = context.table, context.participant
    # With one row for each participant, every column is constant within participants.
    if who is None or len(texts(table, who)) * 2 > len(table.rows):
        return False
    said = texts(table, column)
    if len(said) < 2 or varies_within(table, column, who) or any(len(t) > _LONGEST for t in said):
        return False
    return is_numeric(table, column) or few_texts(table, column)


_LONGEST = 60
"""Letters of an answer that is no sentence in own words."""


def _balanced_groups(context: Context, column: int) -> bool:
    """Return whether each participant has one of two to four words, and each word about as many.

    Where rows are people, and words Yes and No, it has to be the only column beside the answers.
    """
    table, who = context.table, context.participant
    if column not in context.roles.unknown or column in context.used:
        return False
    if (who is None or _says_yes_or_no(context, column)) and not _stands_alone(context, column):
        return False
    people = {n if who is None else row[who]: row[column] for n, row in enumerate(table.rows)}
    groups = Counter(people.values())
    if groups.pop("", 0) * 10 > len(people):  # who broke off early was in no group
        return False
    several = who is not None and varies_within(table, column, who)
    if not 2 <= len(groups) <= _FEW_SCENES or several:
        return False
    if is_numeric(table, column) or measures(table, column) or _is_a_question(context, column):
        return False
    return min(groups.values()) >= _FEWEST_OF_GROUP and max(groups.values()) - min(
        groups.values()
    ) <= max(1, len(people) // 12)


def _is_a_question(context: Context, column: int) -> bool:
    """Return whether a heading is one of a row (``Q4``, ``Q5``, ``Q6``) or grid, or asks people."""
    table = context.table
    asked = [around(each)[0] for each in table.headings]
    if _asks_person(context, column) or (asked[column] and asked.count(asked[column]) > 2):
        return True
    stems = [re.fullmatch(r"([^\W\d]{1,3}) ?_?\d{1,3}", each) for each in table.headings]
    own = stems[column]
    return own is not None and [each[1] for each in stems if each].count(own[1]) >= _ROW_OF_CODES


_ROW_OF_CODES = 3


def _stands_alone(context: Context, column: int) -> bool:
    """Return whether nothing else stands beside the answers, and the heading asks no question."""
    words = tokens(context.table.headings[column])
    alone = {*context.roles.unknown} == {column} and context.one_row_each
    return alone and len(words) < FEWEST_OF_SENTENCE


_FEWEST_OF_GROUP = 3

BASELINE_AMONG_CONDITIONS = CellEvidence(
    "timepoint", "a baseline among conditions", 20, _baseline_among_conditions
)
OTHER_TIMEPOINTS = CellEvidence(
    "timepoint", "a few other texts under its heading", 10, _other_texts_under_timepoint
)
BALANCED_WORDS = CellEvidence(
    "condition", "few words, of which nearly every participant has each", 45, _balanced_words
)
WORDS_WITHIN_PEOPLE = CellEvidence(
    "condition", "few words that differ within participants", 40, _words_within_people
)
CODES_IN_ROWS = CellEvidence(
    "participant", "codes, each in several rows", 25, _codes_in_equally_many_rows
)
CODES_UNDER_NAME = CellEvidence(
    "participant", "codes under a heading for names", 20, _codes_of_people,
    "it does; it holds codes, no names of people",
)  # fmt: skip
RECURRING_NAMES = CellEvidence(
    "participant", "names, each in several rows", 15, _recurring_names,
    "it does; they are numbered, without their names",
)  # fmt: skip
CROSSED_CODES = CellEvidence(
    "participant", "codes that are crossed with words", 32, _meets_all_words
)
CODES = (CROSSED_CODES, CODES_IN_ROWS, CODES_UNDER_NAME, RECURRING_NAMES)
"""Evidence of codes and names that are people's, whatever files are called."""
COUNTS_EXPOSURES = CellEvidence(
    "condition", "a number of exposures", 20, _counts_exposures, "it is, for want of another",
)  # fmt: skip
GROUPS_PEOPLE = CellEvidence(
    "condition", "a group of participants", 10, _groups_people,
    "it is", "Is {heading!r} the condition, between participants?",
)  # fmt: skip
"""Together these two are a crossover: the condition is a group's, in each of its exposures."""

CELLS: tuple[CellEvidence, ...] = (
    CROSSED_CODES,
    CellEvidence(
        "participant", "short texts, others for each row or person", 30, _tells_people_apart,
    ),
    CODES_IN_ROWS,
    CellEvidence(
        "participant", "numbers of rows without a heading", 5, _counts_rows,
        "it does, for want of another",
    ),
    CODES_UNDER_NAME,
    RECURRING_NAMES,
    CellEvidence(
        "participant", "the key of each response", 10, _numbers_responses,
        "it is", "Is each row, with a {heading!r} of its own, another person?",
    ),
    CellEvidence("timepoint", "timepoints under their heading", 40, _timepoints_under_heading),
    CellEvidence("timepoint", "two timepoints or more, any heading", 30, _several_timepoints),
    BASELINE_AMONG_CONDITIONS,
    OTHER_TIMEPOINTS,
    CellEvidence(
        "trial", "numbers of an order that differs within participants", 20, _order_within_people,
        "it is, from 1", "Is {heading!r} the place of an exposure in its order?",
    ),
    BALANCED_WORDS,
    WORDS_WITHIN_PEOPLE,
    CellEvidence(
        "condition", "two to four words under a heading for scenes", 35, _few_scenes,
        "it is: no other column says one",
    ),
    CellEvidence(
        "condition", "few numbers, of which nearly every participant has each", 30,
        _balanced_numbers,
    ),
    COUNTS_EXPOSURES,
    GROUPS_PEOPLE,
    CellEvidence(
        "condition", "a few words, each of as many participants", 8, _balanced_groups,
        "it is", "Is {heading!r} the condition, between participants?",
    ),
    CellEvidence(
        "condition", "few words in front, where nothing tells people apart", 5,
        _words_without_people,
    ),
    CellEvidence("covariate", "one text for each participant", 10, _constant_within_people),
)  # fmt: skip


def candidates(role: str, columns: Iterable[int], context: Context) -> list[Candidate]:
    """Return the columns with evidence for a role, the heaviest first, then those without blanks.

    The others stand as they are given.
    """
    rows = sorted((each for each in CELLS if each.role == role), key=lambda each: -each.weight)
    opinions = context.vocabulary.starts | context.vocabulary.preferences
    found = []
    for column in dict.fromkeys(columns):
        if column in context.roles.outcomes:
            continue
        words = tokens(context.table.headings[column])
        asks = len(words) >= FEWEST_OF_SENTENCE and opinions & {*words}
        if role == "condition" and asks:
            continue  # a question of the lab's own
        open_ = role == "participant" and column in context.roles.unknown
        if open_ and _asks_person(context, column, role):
            continue
        heaviest = next((each for each in rows if each.test(context, column)), None)
        if heaviest is not None:
            found.append(Candidate(column, heaviest))
    cells = context.table.column
    return sorted(found, key=lambda each: (-each.evidence.weight, "" in cells(each.column)))
