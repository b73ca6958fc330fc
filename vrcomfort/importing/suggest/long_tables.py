"""Finds questionnaires in tables with a row for each answer, or on their side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace

from vrcomfort.csv_table import plain_digits
from vrcomfort.importing.files import JOIN, is_number, under_titles
from vrcomfort.importing.source import Grid, SourceTable
from vrcomfort.importing.suggest.cells import texts
from vrcomfort.importing.suggest.evidence import is_identifier
from vrcomfort.importing.suggest.found_answers import FoundAnswers, mentions, named_by_file
from vrcomfort.importing.suggest.heading_roles import PERSON_CODE, names_fact
from vrcomfort.importing.suggest.item_names import How, named_item
from vrcomfort.importing.suggest.items import FEWEST_OF_NAMED, MOST_ANSWERS
from vrcomfort.importing.suggest.vocabulary import FEWEST_OF_SENTENCE, Known, LabVocabulary, tokens
from vrcomfort.questionnaire import Instrument, plain


@dataclass(frozen=True)
class Long(FoundAnswers):
    """A table with a row for each answer.

    Parameters
    ----------
    items
        Item → text in the item column.
    hows
        Item → how it was found.
    others
        Texts of the item column that are no item.
    instrument_column
        Where the questionnaire is named, and the text there.
    siblings
        Columns of the answers of all administrations, which are coded alike.
    beside
        Names of the lab's own questionnaires in the rows between.
    """

    item_column: int
    response_column: int
    items: dict[str, str]
    hows: dict[str, How]
    others: list[str]
    instrument_column: tuple[int, str] | None
    siblings: tuple[int, ...] = ()
    beside: tuple[str, ...] = ()

    @property
    def row_keys(self) -> list[int]:
        """Return the columns that tell the answers of one questionnaire apart."""
        named = [self.instrument_column[0]] if self.instrument_column else []
        return [self.item_column, *named]

    @property
    def columns(self) -> list[int]:
        """Return the indices of the columns."""
        return [*self.row_keys, self.response_column]


def find_long(table: SourceTable, columns: Sequence[int], known: Known) -> list[Long]:
    """Return the questionnaires of a long table; none where it is not one."""
    kept: list[Long] = []
    naming = {each: _naming_columns(table, each) for each in known.instruments}
    for column in columns:
        found: list[Long] = []
        words = texts(table, column)
        # Fewer items make no questionnaire; more texts are ids, longer ones interviews.
        fitting = 4 <= len(words) <= 200 and max(map(len, words)) <= _LONGEST_QUESTION
        if not fitting or len(table.rows) < len(words):
            continue
        response = response_column(table, column, known.vocabulary)
        responses = [response] if response is not None else response_columns(table, column, known)
        for instrument in known.instruments:
            where = next((each for each in naming[instrument] if each[0] != column), None)
            named = _named_in_rows(table, column, words, instrument, known, where)
            if named is not None:
                items, hows = named
                own = responses[:1] or _answered_beside(table, column, items, instrument, known)
                others = [word for word in words if word not in items.values()]
                places = _instrument_texts(table, instrument, column, where)
                for place, context in places if own else ():
                    long = Long(instrument, context, column, own[0], items, hows, others, place)
                    found.append(long)
        if found and response is None and responses:
            return _for_each_column(table, _best_long(found)[0], responses)
        # Each questionnaire may have columns of its own: pre.item, pre.response, post.item …
        if found and found[0].response_column not in {each.response_column for each in kept}:
            kept += _best_long(found)
    if len({each.item_column for each in kept}) < 2:
        return kept
    return [replace(e, context=tuple(tokens(table.headings[e.item_column]))) for e in kept]


def _answered_beside(
    table: SourceTable,
    item_column: int,
    items: Mapping[str, str],
    instrument: Instrument,
    known: Known,
) -> list[int]:
    """Return the only column that holds answers in all rows of items, as logs of events have it."""
    rows = [row for row in table.rows if row[item_column] in items.values()]
    severity = known.vocabulary.severity

    def answers(cells: Set[str]) -> bool:
        numbers = [float(cell.replace(",", ".")) for cell in cells if is_number(cell)]
        inside = all(instrument.low <= value <= instrument.high for value in numbers)
        words = all(is_number(cell) or plain(cell) in severity for cell in cells)
        return 1 < len(cells) <= MOST_ANSWERS and words and inside

    filled = {c: {row[c] for row in rows} for c in range(len(table.headings)) if c != item_column}
    found = [c for c, cells in filled.items() if answers(cells)]
    found = [c for c in found if not is_identifier(table, c, known.vocabulary)]
    return found if len(found) == 1 and len(rows) < len(table.rows) else []


def response_columns(table: SourceTable, item_column: int, known: Known) -> list[int]:
    """Return the columns of numbers beside that of the items, one for each condition."""
    if len(table.rows) <= len(texts(table, item_column)):
        return []  # one person, or means
    filled = [c for c in range(len(table.headings)) if texts(table, c)]
    beside = [c for c in filled if c > item_column]
    beside = beside or [c for c in filled if not is_identifier(table, c, known.vocabulary)]
    worded = [c for c in beside if not all(map(is_number, texts(table, c)))]
    naming = {c for c in worded if any(mentions(t, known.instruments) for t in texts(table, c))}
    beside = [c for c in beside if c != item_column and c not in naming]
    labels = {key for key, role in known.vocabulary.roles.items() if role not in _OF_COLUMNS}
    numeric = not {*worded} & {*beside}
    plain_ones = not any(plain(table.headings[c]) in labels for c in beside)
    named = bool(table.reading.heading_rows)
    return beside if numeric and plain_ones and named and 1 < len(beside) <= _MOST_COLUMNS else []


_MOST_COLUMNS, _LONGEST_QUESTION = 100, 500
_OF_COLUMNS = frozenset(["condition", "scene"])
"""Roles of labels that may be names of conditions: ``Blur``."""


def _for_each_column(table: SourceTable, long: Long, responses: Sequence[int]) -> list[Long]:
    """Return a questionnaire for each column of answers; none where numbers are no answers."""
    low, high = long.instrument.low, long.instrument.high
    rows = [row for row in table.rows if row[long.item_column] in long.items.values()]
    cells = [row[c].replace(",", ".") for row in rows for c in responses if row[c]]
    if not cells or not all(low <= float(cell) <= high + 1 for cell in cells):
        return []
    return [
        replace(
            long,
            response_column=c,
            context=tuple(tokens(table.headings[c])),
            siblings=tuple(responses),
        )
        for c in responses
    ]


def stands_on_its_side(grid: Grid, known: Known) -> bool:
    """Return whether items stand one below the other, and participants side by side."""
    width = max(_filled_width(row) for row in grid.rows)
    responses = known.vocabulary.response_labels
    if grid.named or any(_last_word(cell) in responses for cell in grid.rows[0]):
        return False
    rows = under_titles(grid.rows)
    first = [row[0] for row in rows if row[0]]
    repeated = len(first) - len({*first})  # rows that a program adds may say nothing, and twice
    if repeated * 10 > len(first) or (width < 3 and not _says_whose(grid, known)):
        return False
    people = [*filter(None, rows[0][1:])]
    timed = bool({*tokens(rows[0][0])} & known.vocabulary.units)
    coded = timed and len(people) > 1 and all(map(PERSON_CODE.fullmatch, people))
    if coded or _are_counted(rows[0], first, known):
        return True  # ratings of a time in each row, or participants 1, 2, 3 … at the top
    top = {plain(word) for cell in rows[0] for word in (cell, *tokens(cell)) if len(word) > 1}
    if top & {*map(plain, known.vocabulary.totals)}:
        return False  # means and deviations of groups
    others = {cell for row in rows[1:] for cell in row[1:] if cell}
    for instrument in known.instruments if len(others) <= MOST_ANSWERS else ():
        spellings = known.vocabulary.spellings(instrument)
        inner = [plain(text.rpartition(JOIN)[2]) for text in first]
        named = [spellings[text] for text in inner if text in spellings]
        if len({*named}) >= 4 and len(named) * 2 >= len(first):
            return True
    return _numbered_on_its_side(grid, first, known)


def _are_counted(top: Sequence[str], first: Sequence[str], known: Known) -> bool:
    """Return whether participants 1, 2, 3 … stand at the top, and words below their heading."""
    people = [*filter(None, top[1:])]
    counted = people == [str(n) for n in range(1, 1 + len(people))]
    named = counted and names_fact(top[0], "participant", known.vocabulary)
    return named and len(people) >= _FEWEST_COUNTED and not any(map(is_number, first))


_FEWEST_COUNTED = 5


def _filled_width(row: Sequence[str]) -> int:
    return max((place for place, cell in enumerate(row, start=1) if cell), default=0)


def _says_whose(grid: Grid, known: Known) -> bool:
    """Return whether one of the names in the first column is that of a participant's code."""
    names = [row[0] for row in grid.rows if len(row) > 1 and row[0] and row[1]]
    return any(names_fact(name, "participant", known.vocabulary) for name in names)


def _numbered_on_its_side(grid: Grid, first: Sequence[str], known: Known) -> bool:
    """Return whether the numbers of an instrument's items stand in front, people at the top."""
    top = [cell for cell in grid.rows[0][1:] if cell]
    roles = (plain(cell) in known.vocabulary.roles for cell in top)
    people = len({*top}) == len(top) > 1 and not any(map(is_number, top)) and not any(roles)
    decimals = (text for text in first if text.isascii() and text.isdecimal())
    numbers = [int(plain_digits(text)) for text in decimals]
    said = named_by_file(grid, known.instruments)
    counts = {len(i.asked) for i in known.instruments if i.name in said and len(i.asked) > 1}
    return people and len(numbers) in counts and numbers == [*range(1, len(numbers) + 1)]


def _best_long(found: list[Long]) -> list[Long]:
    """Keep questionnaires that are named in a column of their own, or else those that fit.

    Several can fit, one after the other: each of the others has all its items among the texts that
    are no item of those before.
    """
    named = [long for long in found if long.instrument_column is not None]
    if named:
        return named
    ranked = sorted(found, key=lambda each: (-_share(each), len(each.others)))
    kept = ranked[:1]
    for long in ranked[1:]:
        taken = {text for each in kept for text in each.items.values()}
        if _share(long) == 1 and not taken & {*long.items.values()}:
            kept.append(long)
    taken = {text for each in kept for text in each.items.values()}
    return [
        replace(each, others=[text for text in each.others if text not in taken]) for each in kept
    ]


def _share(long: Long) -> float:
    return len(long.items) / len(long.instrument.asked)


def _named_in_rows(
    table: SourceTable,
    column: int,
    words: list[str],
    instrument: Instrument,
    known: Known,
    where: tuple[int, str] | None,
) -> tuple[dict[str, str], dict[str, How]] | None:
    items: dict[str, str] = {}
    hows: dict[str, How] = {}
    for word in words:
        found = named_item(column, word, "", instrument, known.vocabulary)
        if found is not None and (
            found.item not in items or found.how == "name" != hows[found.item]
        ):
            items[found.item] = word
            hows[found.item] = found.how
    sure = sum(how == "name" for how in hows.values())
    if sure >= min(4, len(instrument.asked)) and len(instrument.asked) > 1:
        return items, hows
    if where is not None:
        # Beside its name, most of the few texts are items: a short form.
        own = {row[column] for row in table.rows if row[where[0]] == where[1]}
        words = [word for word in words if word in own]
        there = {item: text for item, text in items.items() if text in own}
        if len(there) >= FEWEST_OF_NAMED and len(there) == len(own):
            return there, {item: hows[item] for item in there}
    initials = known.vocabulary.initials(instrument)
    short = {initials[plain(w)]: w for w in words if plain(w) in initials}
    if len(short) == len(words) == len(instrument.asked):
        return short, dict.fromkeys(short, "initials")
    return _numbered_in_rows(table, column, words, instrument, known)


def _numbered_in_rows(
    table: SourceTable,
    column: int,
    words: list[str],
    instrument: Instrument,
    known: Known,
) -> tuple[dict[str, str], dict[str, How]] | None:
    """Find items by numbers, ``1`` … ``16`` or ``SSQ1`` …, in a column that is called item."""
    heading = plain(table.headings[column])
    named = mentions(" ".join(words[:3]), known.instruments)
    if heading not in known.vocabulary.item_labels and not named:
        return None
    numbers: dict[int, str] = {}
    for word in words:
        digits = [token for token in tokens(word) if token.isdecimal()]
        named = mentions(word, known.instruments)
        if len(digits) == 1 and (not named or instrument.name in named):
            numbers.setdefault(int(digits[0]), word)
    count = len(instrument.asked)
    first = min(numbers, default=9)
    if _asks_otherwise(table, column, [*numbers.values()], instrument, known):
        return None
    if first > 1 or sorted(numbers) != list(range(first, first + count)) or count < 4:
        return None
    items = {item.name: numbers[n] for n, item in enumerate(instrument.asked, start=first)}
    return items, dict.fromkeys(items, "number")


def _asks_otherwise(
    table: SourceTable, column: int, words: Sequence[str], instrument: Instrument, known: Known
) -> bool:
    """Return whether a column beside the numbers has the questions, and they are other ones."""
    if instrument.name in named_by_file(table, [instrument]):
        return False
    for other in range(len(table.headings)):
        asked = {row[column]: row[other] for row in table.rows if row[column] in words}
        always = all(asked.get(row[column], row[other]) == row[other] for row in table.rows)
        sentences = [text for text in asked.values() if len(tokens(text)) >= FEWEST_OF_SENTENCE]
        if not always or len({*sentences}) < len(words):
            continue
        found = (named_item(other, t, "", instrument, known.vocabulary) for t in sentences)
        return sum(each is not None for each in found) * 2 < len(sentences)
    return False


def response_column(table: SourceTable, item_column: int, vocabulary: LabVocabulary) -> int | None:
    """Return the column of the answers of a table that has a row for each; None without one."""
    candidates = [
        column
        for column, heading in enumerate(table.headings)
        if column != item_column and _is_response(table, column, heading, vocabulary)
    ]
    named = [c for c in candidates if _last_word(table.headings[c]) in vocabulary.response_labels]
    if not named and not table.reading.heading_rows:
        # Without headings, answers are small numbers or words of severity: times and dates are not.
        named = [c for c in candidates if _are_few_and_short(texts(table, c))]
        named = named if len(named) == 1 else []
    outer = table.headings[item_column].rpartition(".")[0]
    beside = [c for c in named if table.headings[c].startswith(outer)]
    return next(iter(beside or named), None)


def _are_few_and_short(words: Sequence[str]) -> bool:
    digits = (word for word in words if is_number(word))
    return len(words) <= _FEW_ANSWERS and all(len(each) <= _DIGITS for each in digits)


_FEW_ANSWERS, _DIGITS = 11, 3


def _last_word(heading: str) -> str:
    """Return a heading, or the inner one of ``outer.inner``."""
    return plain(heading.rsplit(".", 1)[-1])


def _is_response(table: SourceTable, column: int, heading: str, vocabulary: LabVocabulary) -> bool:
    words = texts(table, column)
    labelled = _last_word(heading) in vocabulary.response_labels
    if not words or (len(words) > 110 and not labelled):
        return False
    known = sum(is_number(word) or plain(word) in vocabulary.severity for word in words)
    return known * 2 >= len(words) or labelled


_MOST_WORDS = 2
"""Of the name of a questionnaire."""


def _instrument_texts(
    table: SourceTable, instrument: Instrument, item_column: int, named: tuple[int, str] | None
) -> list[tuple[tuple[int, str] | None, tuple[str, ...]]]:
    """Return where the questionnaire is named, and the words there: each moment may have its own.

    Logs of events call rows ``Answer_SSQ_PRE`` and ``Answer_SSQ_POST``.
    """
    for column in range(len(table.headings)):
        said = texts(table, column) if column != item_column else []
        asked = [
            text
            for text in said
            if mentions(text, [instrument])
            and len({r[item_column] for r in table.rows if r[column] == text}) >= FEWEST_OF_NAMED
        ]
        if 1 < len(asked) <= _MOST_MOMENTS and len(said) <= _MOST_EVENTS:
            return [((column, text), tuple(tokens(text))) for text in asked]
    return [(named, ())]


_MOST_MOMENTS, _MOST_EVENTS = 12, 100


def _naming_columns(table: SourceTable, instrument: Instrument) -> list[tuple[int, str]]:
    """Return the columns in which one text names the questionnaire: two would be of two moments."""
    few = ((column, words) for column, words in enumerate(table.texts) if len(words) <= 8)
    naming = ((column, [w for w in words if _names(w, instrument)]) for column, words in few)
    return [(column, words[0]) for column, words in naming if len(words) == 1]


def _names(text: str, instrument: Instrument) -> bool:
    short = bool(mentions(text, [instrument])) and len(tokens(text)) <= _MOST_WORDS
    return short or plain(text) == plain(instrument.title)
