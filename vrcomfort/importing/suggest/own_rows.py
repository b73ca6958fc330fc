"""Finds a lab's own questions in tables that have a row for each answer."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.answer_scales import (
    FEWEST_ANSWERS,
    are_of_seven,
    put_coding,
    scale_of,
)
from vrcomfort.importing.suggest.cells import is_balanced, texts
from vrcomfort.importing.suggest.heading_roles import Roles
from vrcomfort.importing.suggest.item_names import How
from vrcomfort.importing.suggest.long_tables import Long, response_column, response_columns
from vrcomfort.importing.suggest.own_instruments import (
    USUAL,
    AnswerRange,
    ask_about,
    declared,
    name_of,
    together,
)
from vrcomfort.importing.suggest.questionnaires import Drafted, places_of_rows
from vrcomfort.importing.suggest.vocabulary import (
    FEWEST_OF_SENTENCE,
    IGNORED,
    Known,
    LabVocabulary,
    tokens,
)
from vrcomfort.importing.toml_draft import TomlDraft
from vrcomfort.questionnaire import plain, shipped_instruments
from vrcomfort.questionnaire.instrument_file import TAKEN

_MOST_ITEMS = 60


def own_rows(table: SourceTable, known: Known, found: Sequence[Long]) -> list[Long]:
    """Return the lab's own questions of a table that has a row for each answer.

    They stand beside those of known instruments, under another name or as other items; or alone
    in a column that is called item. Each person, or condition, may have a column of answers.
    """
    item, responses, named = _columns_of_rows(table, known, found)
    if item is None or not responses:
        return []
    groups: dict[str, list[str]] = defaultdict(list)
    taken = {text for each in found for text in each.items.values()}
    names = {each.instrument_column[1] for each in found if each.instrument_column}
    for row in table.rows:
        group = "" if named is None else row[named]
        again = any(row[item].startswith(text) for text in taken)  # nausea-quantised
        if row[item] and not again and row[item] not in groups[group]:
            groups[group].append(row[item])
    made: set[str] = {*shipped_instruments(), *TAKEN}
    seven = are_of_seven((row[c] for row in table.rows for c in responses), known.vocabulary)
    others = (c for c in range(len(table.headings)) if c not in {item, *responses})
    crossed = len(responses) > 1 and any(is_balanced(table, item, c) for c in others)
    own = []
    for group, words in groups.items():
        rows = [row for row in table.rows if named is None or row[named] == group]
        said = _statements(table, item, words)
        scales: dict[str, AnswerRange] = {}
        for text in words if len(words) <= _MOST_ITEMS else ():
            cells = tuple((row[c],) for row in rows if row[item] == text for c in responses)
            scale = scale_of(replace(table, rows=cells), 0, known.vocabulary, of_seven=seven)
            asks = crossed or not _asks_no_opinion(said.get(text, text), known.vocabulary)
            if scale is not None and asks and known.vocabulary.told(text) != IGNORED:
                scales[text] = scale
        name = "" if group in names else group
        usual = {text for text, scale in scales.items() if scale.usual[:2] in USUAL}
        sure = [t for t in scales if _is_asked(said.get(t, t), name, known.vocabulary)]
        sure = sure or ([*scales] if crossed and usual == {*words} else [])
        if not sure:
            continue
        beside = usual if group not in names else ()
        scales = {t: s for t, s in scales.items() if t in sure or t in beside}
        taken_names: set[str] = {*TAKEN}
        items = {name_of(text, taken_names): text for text in scales}
        scales = together(scales)
        questions = [(name, said.get(text, text), scales[text]) for name, text in items.items()]
        instrument = declared(name_of(name or "own_questions", made), questions)
        where = None if named is None else (named, group)
        hows: dict[str, How] = dict.fromkeys(items, "name")
        several = tuple(responses) if len(responses) > 1 else ()
        for column in responses:
            context = tuple(tokens(table.headings[column])) if several else ()
            own.append(Long(instrument, context, item, column, items, hows, [], where, several))
    return own


def _asks_no_opinion(text: str, vocabulary: LabVocabulary) -> bool:
    """Return whether a text in the column of items names a fact, or no answer."""
    short = len(tokens(text)) < FEWEST_OF_SENTENCE
    other = {*tokens(text)} & vocabulary.asking_others or plain(text) in vocabulary.roles
    return short and bool(other)


def _is_asked(text: str, group: str, vocabulary: LabVocabulary) -> bool:
    """Return whether a text in the column of items asks, by its words or under a name.

    Others beside it are questions, too, where their answers are on a usual scale.
    """
    words = {*tokens(text)}
    if len(tokens(text)) >= FEWEST_OF_SENTENCE:
        return bool(words & vocabulary.asking_sentences)
    return bool(group or words & vocabulary.asking_words)


def _statements(table: SourceTable, column: int, items: Sequence[str]) -> dict[str, str]:
    """Return item → its statement, where a column beside has one for each."""
    for other in range(len(table.headings)):
        pairs = {(row[column], row[other]) for row in table.rows if row[column] in items}
        found = dict(pairs)
        long = all(len(tokens(text)) >= FEWEST_OF_SENTENCE for text in found.values())
        if other != column and long and len(found) == len(pairs) == len({*found.values()}):
            return found
    return {}


def _columns_of_rows(
    table: SourceTable, known: Known, found: Sequence[Long]
) -> tuple[int | None, Sequence[int], int | None]:
    """Return the column of items, those of answers, and that of the names of questionnaires."""
    if found:
        first = found[0]
        named = first.instrument_column and first.instrument_column[0]
        return first.item_column, [*dict.fromkeys(each.response_column for each in found)], named
    labels = known.vocabulary.item_labels
    told = known.vocabulary.told
    items = [c for c, h in enumerate(table.headings) if plain(h) in labels and not told(h)]
    items = [c for c in items if 1 < len(texts(table, c)) <= len(table.rows) // FEWEST_ANSWERS]
    if not items:
        return None, [], None
    # Of several, the one with most different texts in rows with an answer: question, not event.
    answered = {c: response_column(table, c, known.vocabulary) for c in items}
    items.sort(key=lambda c: -len({r[c] for r in table.rows if r[answered[c] or 0]}))
    response = answered[items[0]]
    several = response_columns(table, items[0], known) if response is None else [response]
    return items[0], several, None


def draft_own_rows(
    table: SourceTable, long: Long, facts: Mapping[str, str], known: Known, _: Roles
) -> Drafted:
    """Draft the lab's own questions of a table that has a row for each answer."""
    draft, rows = places_of_rows(table, long, facts)
    cells = [row[c] for row in rows for c in long.siblings or (long.response_column,)]
    put_coding(draft, long.instrument, [dict.fromkeys(cells)], table.decimal, known.vocabulary)
    draft.tables["items"] = TomlDraft(dict(long.items))
    return draft, [ask_about(long.instrument, [*long.items.values()])]
