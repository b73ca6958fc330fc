"""Drafts questionnaires: items, the coding of their answers, and the doubts that both leave."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.importing.answers import number
from vrcomfort.importing.files import is_number, numbers_in
from vrcomfort.importing.made_instruments import ROUNDED
from vrcomfort.importing.mapping import template_pattern
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.answer_scales import step_of
from vrcomfort.importing.suggest.cells import texts
from vrcomfort.importing.suggest.codings import Coding, coding_of, coding_of_texts
from vrcomfort.importing.suggest.draft import (
    CURIOUS,
    DIRECTION,
    INSTRUMENT,
    ITEM,
    ITEM_ORDER,
    LOST,
    ORDER,
    ROWS,
    SHORT_FORM,
    TIMES,
    OpenDoubt,
    listed,
)
from vrcomfort.importing.suggest.found_answers import Found, mentions, named_by_file
from vrcomfort.importing.suggest.heading_roles import Roles
from vrcomfort.importing.suggest.item_names import How, Named
from vrcomfort.importing.suggest.long_tables import Long
from vrcomfort.importing.suggest.ratings import FoundCourse, FoundRating
from vrcomfort.importing.suggest.scores import parts_of
from vrcomfort.importing.suggest.vocabulary import Known, LabVocabulary, tokens
from vrcomfort.importing.toml_draft import TomlDraft
from vrcomfort.questionnaire import Instrument, Scale, plain

if TYPE_CHECKING:
    from numpy.typing import NDArray

Drafted = tuple[TomlDraft, list[OpenDoubt]]


def _mend_items(
    table: SourceTable, block: Found, roles: Roles, vocabulary: LabVocabulary
) -> tuple[Found, list[OpenDoubt]]:
    """Take a sum for no item, though its heading names one; and ask."""
    doubts = []
    items = dict(block.items)
    values = {table.headings[c]: _values(table, c) for c in (*block.columns, *roles.unknown)}
    for item, named in block.items.items():
        heading = table.headings[named.column]
        parts = None
        if _exceeds(values[heading], block.instrument):
            others = {name: each for name, each in values.items() if name != heading}
            parts = parts_of(values[heading], others)
        if parts is None:
            continue
        del items[item]
        roles.unknown.append(named.column)
        shown = ", ".join(parts)
        free = [c for c in roles.unknown if may_answer(table, c, block.instrument, vocabulary)]
        if len(free) == 1:
            (other,) = free
            roles.unknown.remove(other)
            items[item] = Named(other, block.instrument.name, item, "position", (), ())
            assumed = f"`{heading}` is ignored, and {table.headings[other]!r} is {item}"
        else:
            assumed = f"`{heading}` is ignored, and {item} was not asked"
        question = f"{heading!r} is exactly the sum of {shown}: which column is the item {item}?"
        doubts.append(OpenDoubt(question, assumed, ITEM))
    return replace(block, items=items), doubts


def lacks_its_item(table: SourceTable, block: Found) -> bool:
    """Return whether a column is too large for the item that it is called after: it is a sum."""
    return any(_exceeds(_values(table, column), block.instrument) for column in block.columns)


def _exceeds(values: Sequence[float | None], instrument: Instrument) -> bool:
    return any(value is not None and value > instrument.high for value in values)


def _values(table: SourceTable, column: int) -> list[float | None]:
    return [number(cell, table.decimal) for cell in table.column(column)]


def _coded_values(
    table: SourceTable, column: int, instrument: Instrument, vocabulary: LabVocabulary
) -> list[float | None]:
    """Return the answers of a column, those in words as numbers."""
    words = coding_of(table, [column], instrument, vocabulary).answers
    return [words.get(cell, number(cell, table.decimal)) for cell in table.column(column)]


def answers_of_block(table: SourceTable, block: Found, known: Known) -> list[float | None]:
    """Return the answers of a questionnaire, those of all people, as the instrument counts them."""
    columns = [*dict.fromkeys((*block.columns, *block.siblings))]
    coding = coding_of(table, columns, block.instrument, known.vocabulary)
    from_ = 0 if coding.coded_from is None else coding.coded_from - int(block.instrument.low)
    return [
        coding.answers.get(cell, None if value is None else value - from_)
        for column in block.columns
        for cell, value in zip(table.column(column), _values(table, column), strict=True)
        if cell not in coding.missing
    ]


def may_answer(
    table: SourceTable, column: int, instrument: Instrument, vocabulary: LabVocabulary
) -> bool:
    """Return whether a column holds nothing but answers of an instrument."""
    words = texts(table, column)
    answers = {str(n) for n in range(int(instrument.low), int(instrument.high) + 1)}
    return bool(words) and all(
        word in answers or plain(word) in vocabulary.severity for word in words
    )


def draft_block(
    table: SourceTable, block: Found, facts: Mapping[str, str], known: Known, roles: Roles
) -> Drafted:
    """Draft a questionnaire that has a column for each item."""
    block, doubts = _mend_items(table, block, roles, known.vocabulary)
    draft = TomlDraft({"instrument": block.instrument.name, **facts})
    doubts += _instrument_doubts(table, block, known)
    columns = [*dict.fromkeys((*block.columns, *block.siblings))]
    coding = coding_of(table, columns, block.instrument, known.vocabulary)
    if coding.variant is not None:
        block = replace(block, instrument=coding.variant)
        draft.put("instrument", block.instrument.name)
    _coded(draft, coding)
    doubts += coding.doubts
    turned = _turned_round(table, block, known.vocabulary)
    doubts += [d for item, d in _direction_doubts(block, coding).items() if item not in turned]
    order = [item.name for item in block.instrument.items if item.name in block.items]
    headings = {item: table.headings[block.items[item].column] for item in order}
    doubts += _name_doubts(block, headings)
    doubts += _absent(draft, block, "column")
    if block.siblings and {each.how for each in block.items.values()} == {"position"}:
        columns = block.columns
        draft.values.pop("not_asked", None)
        draft.put("first_columns", [table.headings[columns[0]]])
        by_column = {named.column: item for item, named in block.items.items()}
        draft.put("item_order", [by_column[column] for column in columns])
        return draft, doubts
    items = TomlDraft(dict(headings))
    for item in order:
        how = block.items[item].how
        if how != "name":
            items.note(f"found by its {'spelling' if how == 'near' else how}", item)
    draft.tables["items"] = items
    for item, end in turned.items():
        own = draft.tables.setdefault("item_coding", TomlDraft())
        own.tables.setdefault(item, TomlDraft()).put("reverse_coded", True)
        question = f"{headings[item]!r} calls its highest number {end!r}: is that the best?"
        doubts.append(OpenDoubt(question, "it is, so the item is turned round", DIRECTION))
    return draft, doubts


def _absent(draft: TomlDraft, block: Found, what: str) -> list[OpenDoubt]:
    """Write down the items that have no column, or no row, and ask."""
    if not block.absent:
        return []
    draft.put("not_asked", block.absent)
    question = f"No {what} was found for {', '.join(block.absent)}: were they not asked?"
    assumed = "they were not (a short form); its scores lack them"
    return [OpenDoubt(question, assumed, SHORT_FORM)]


def _turned_round(table: SourceTable, block: Found, vocabulary: LabVocabulary) -> dict[str, str]:
    """Return item → the word for its highest number, where a heading says that it is the best."""
    found = {}
    for item in block.instrument.items:
        if item.name in block.items and item.answers.labels[:1] == ("perfect",):
            column = block.items[item.name].column
            ends = _ENDS.findall(f"{table.headings[column]} {table.labels[column]}")
            _, end = max(((int(n), word) for n, word in ends), default=(0, ""))
            if plain(end) in vocabulary.best and len(ends) > 1:
                found[item.name] = end
    return found


_ENDS = re.compile(r"(\d+)\s*[=:]\s*(?:very |sehr )?([^\W\d_]+)")


def _instrument_doubts(table: SourceTable, block: Found, known: Known) -> list[OpenDoubt]:
    """Ask which instrument it is, where another has all of these items, too."""
    text = " ".join(table.headings[c] + " " + table.labels[c] for c in block.columns)
    if block.instrument.name in named_by_file(table, known.instruments, text):
        return []
    found, asked = set(block.items), block.instrument
    numbered = {each.how for each in block.items.values()} == {"number"}
    numbered = numbered and not mentions(text, [asked])
    others = [
        other.name.upper()
        for other in known.instruments
        if other.name != asked.name
        if (
            (len(other.asked), other.low) == (len(asked.asked), asked.low)
            if numbered
            else found <= {item.name for item in other.items}
        )
    ]
    if not others:
        return []
    question = f"Items of {asked.name.upper()} are items of {', '.join(others)}, too:"
    if numbered:
        question = f"{asked.name.upper()} and {', '.join(others)} have as many items:"
    return [OpenDoubt(f"{question} which was asked?", block.instrument.name.upper(), INSTRUMENT)]


def _name_doubts(block: Found, headings: Mapping[str, str]) -> list[OpenDoubt]:
    """Ask about items that were not found by their own name."""
    doubts = []
    by_how: dict[str, list[str]] = {}
    for item in headings:
        by_how.setdefault(block.items[item].how, []).append(item)
    like = f"order of {block.instrument.name}"
    if numbered := by_how.get("number"):
        first, last = headings[numbered[0]], headings[numbered[-1]]
        title, citation = block.instrument.title, block.instrument.citation.split(",")[0]
        question = f"Are {first} … {last} in the published order of the {title} ({citation})?"
        doubts.append(OpenDoubt(question, f"they are: {first} is {numbered[0]}", ITEM_ORDER, like))
    if placed := by_how.get("position"):
        first, last = headings[placed[0]], headings[placed[-1]]
        if len(placed) > 1:
            question = f"Are {first} … {last} the {block.instrument.title} in published order?"
            assumed = f"they are: {first} is {placed[0]}"
            doubts.append(OpenDoubt(question, assumed, ITEM_ORDER, like))
    for hows, what in _UNSURE.items():
        if unsure := [item for how in hows for item in by_how.get(how, ())]:
            shown = listed([f"{headings[item]!r} is {item}" for item in unsure], _SHOWN, "; ")
            alike = " ".join((block.instrument.name, what, *unsure))
            doubts.append(OpenDoubt(f"Is it right that {shown}?", f"it is: {what}", ITEM, alike))
    return doubts


_UNSURE: Mapping[tuple[How, ...], str] = {
    ("near",): "these are misspellings",
    ("abbreviation", "initials"): "these are abbreviations",
    ("wording", "order"): "the question is worded otherwise",
}
"""How items were found → what that takes for granted."""
_SHOWN = 6
"""Items that one question lists."""


def _coded(draft: TomlDraft, coding: Coding) -> None:
    if coding.answers:
        draft.put("answers", dict(coding.answers))
    if coding.coded_from is not None:
        draft.put("coded_from", coding.coded_from)
    if coding.times is not None:
        draft.put("times", float(coding.times))
    if coding.missing:
        draft.put("missing", list(coding.missing))


def _direction_doubts(block: Found, coding: Coding) -> dict[str, OpenDoubt]:
    """Return item → a question where its ends are its own, as of performance in the TLX.

    Labs turn such an item round so that it runs like the others: its numbers look the same.
    """
    if coding.answers:
        return {}
    asked = (item for item in block.instrument.items if item.name in block.items)
    usual = block.instrument.labels[-1:]
    own = (item for item in asked if item.answers.labels[-1:] not in {(), usual})
    return {
        item.name: OpenDoubt(
            f"Does the highest number of {item.name} mean {item.answers.labels[-1]!r}?",
            f"it does; else add item_coding.{item.name}.reverse_coded = true",
            DIRECTION,
        )
        for item in own
    }


def places_of_rows(
    table: SourceTable, long: Long, facts: Mapping[str, str]
) -> tuple[TomlDraft, list[Sequence[str]]]:
    """Draft the place of a questionnaire with a row for each answer; return its rows, too."""
    draft = TomlDraft({"instrument": long.instrument.name, **facts})
    draft.put("item_column", table.headings[long.item_column])
    draft.put("response_column", table.headings[long.response_column])
    words = set(long.items.values())
    rows: list[Sequence[str]] = [row for row in table.rows if row[long.item_column] in words]
    if long.instrument_column is not None:
        column, text = long.instrument_column
        draft.put("where", {table.headings[column]: text})
        rows = [row for row in rows if row[column] == text]
    return draft, rows


def draft_long(
    table: SourceTable, long: Long, facts: Mapping[str, str], known: Known, _: Roles
) -> Drafted:
    """Draft a questionnaire of a table that has a row for each answer."""
    draft, rows = places_of_rows(table, long, facts)
    columns = long.siblings or (long.response_column,)
    cells = [row[c] for row in rows for c in columns]
    coding = coding_of_texts(cells, long.instrument, table.decimal, known.vocabulary)
    _coded(draft, coding)
    named = {
        item: Named(long.item_column, long.instrument.name, item, how, (), ())
        for item, how in long.hows.items()
    }
    block = Found(long.instrument, (), named)
    order = [item.name for item in long.instrument.items if item.name in long.items]
    doubts = [*coding.doubts, *_direction_doubts(block, coding).values()]
    doubts += _name_doubts(block, {item: long.items[item] for item in order})
    if long.instrument_column is None:
        doubts += _instrument_doubts(table, block, known)
    else:
        doubts += _other_instruments(table, long, long.instrument_column[0], known)
    doubts += _absent(draft, block, "row")
    if long.others and long.instrument_column is None:
        shown = listed([*map(repr, long.others)], 8)
        question = f"May the rows of {shown} be left out, which are no items of this instrument?"
        doubts.append(OpenDoubt(question, "they are left out", ROWS))
    draft.tables["items"] = TomlDraft({item: long.items[item] for item in order})
    return draft, doubts


def _other_instruments(
    table: SourceTable, long: Long, column: int, known: Known
) -> list[OpenDoubt]:
    """Ask whether the rows of questionnaires that we do not know may be left out."""
    names = {
        plain(name) for each in known.instruments for name in (each.name, each.short, each.title)
    }
    others = [text for text in texts(table, column) if text not in long.beside]
    others = [text for text in others if plain(text) not in names]
    others = [text for text in others if not mentions(text, known.instruments)]
    if not others:
        return []
    question = f"May the rows with {', '.join(others)} in {table.headings[column]!r} be left out?"
    return [OpenDoubt(question, "they are: no instrument of ours is called so", ROWS)]


def draft_rating(
    table: SourceTable, rating: FoundRating, facts: Mapping[str, str], known: Known, roles: Roles
) -> Drafted:
    """Draft a scale of one item: ratings during exposure, where there is a time."""
    (item,) = rating.instrument.items
    draft = TomlDraft({"instrument": rating.instrument.name, **facts})
    if rating.time is not None:
        said = {*tokens(table.headings[rating.time])} & known.vocabulary.minutes
        minutes = rating.counts or bool(said)
        if rating.event is not None:
            column, text = rating.event
            table = replace(table, rows=tuple(r for r in table.rows if r[column] == text))
        what = "minutes" if minutes else "seconds"
        draft.put("time", table.headings[rating.time], f"{what} since the exposure began")
        if minutes:
            draft.put("time_unit", "min")
        draft.put("summaries", ["peak", "mean", "last"], "what the report has of each exposure")
    coding = coding_of(table, rating.columns, rating.instrument, known.vocabulary)
    _coded(draft, coding)
    heading = table.headings[rating.column]
    if rating.event is not None:
        column, text = rating.event
        for each in (column, rating.time, rating.column):
            if each is not None:
                roles.forget(each)
        draft.put("item_column", table.headings[column])
        draft.put("response_column", heading)
        heading = text
    draft.tables["items"] = TomlDraft({item.name: heading})
    doubts = list(coding.doubts)
    heading = "" if rating.time is None else table.headings[rating.time]
    if heading and plain(heading) not in known.vocabulary.seconds:
        question = f"Is {heading!r} the time of each rating, in {what} since the exposure began?"
        doubts.append(OpenDoubt(question, "it is", TIMES))
    return draft, doubts


def draft_course(
    table: SourceTable, course: FoundCourse, facts: Mapping[str, str], known: Known, _: Roles
) -> Drafted:
    """Draft ratings during exposure that have a column for each time."""
    headings = [table.headings[column] for column in course.columns]
    parts = [re.split(r"(\d+)", heading) for heading in headings]
    place = next(i for i, part in enumerate(zip(*parts, strict=False)) if len(set(part)) > 1)
    minutes = [int(part[place]) for part in parts]
    unit = "time_min" if max(minutes) <= 60 else "time_s"
    template = [*parts[0][:place], f"{{{unit}}}", *parts[0][place + 1 :]]
    heading = "".join(template)
    draft = TomlDraft({"instrument": course.instrument.name, **facts, "heading": heading})
    if others := _others_of(heading, table, course.columns):
        del draft.values["heading"]
        number = rf"(?P<{unit}>(?!(?:{'|'.join(others)})$)\d+)"
        before, after = parts[0][:place], parts[0][place + 1 :]
        draft.put("pattern", re.escape("".join(before)) + number + re.escape("".join(after)))
    draft.put("summaries", ["peak", "mean", "last"], "what the report has of each exposure")
    coding = coding_of(table, course.columns, course.instrument, known.vocabulary)
    _coded(draft, coding)
    what = "minutes" if unit == "time_min" else "seconds"
    question = (
        f"Are {headings[0]} … {headings[-1]} ratings during exposure, {what} after its start?"
    )
    assumed, stake = f"they are, {what}", ORDER
    if not table.reading.heading_rows:
        assumed, stake = f"they are, {what}, though the file says no times", TIMES
    return draft, [*coding.doubts, OpenDoubt(question, assumed, stake, "rating courses")]


def _others_of(heading: str, table: SourceTable, columns: Sequence[int]) -> list[str]:
    """Return the numbers of headings that a template of ratings would take beside its own."""
    pattern = template_pattern(heading)
    others = (pattern.fullmatch(n) for c, n in enumerate(table.headings) if c not in columns)
    return [match[1] for match in others if match is not None]


def sum_of(
    table: SourceTable, column: int, blocks: Sequence[Found], known: Known
) -> list[str] | None:
    """Return the columns of a questionnaire of which another is the exact (weighted) sum."""
    words = texts(table, column)
    if not words or not all(map(is_number, words)):
        return None
    values = _values(table, column)
    every: dict[str, list[float | None]] = {}
    for block in blocks:
        answers = {
            table.headings[c]: _coded_values(table, c, block.instrument, known.vocabulary)
            for c in block.columns
        }
        if parts := parts_of(values, answers):
            return parts
        every |= answers
    return parts_of(values, every) if len(blocks) > 1 else None


MADE_OF_ANSWERS = "a score made of the answers"


def is_score_of(
    table: SourceTable, column: int, blocks: Sequence[Found], known: Known
) -> bool | None:
    """Return whether a column is, in all rows, a score of a questionnaire in some unit.

    The answer is None where items or rows are too few to tell.
    """
    if sum_of(table, column, blocks, known):
        return True
    given = np.array(_values(table, column), dtype=float)
    told = False
    for block in blocks:
        coding = coding_of(table, block.columns, block.instrument, known.vocabulary)
        as_numbers = {**coding.answers, **dict.fromkeys(coding.missing, None)}
        answers = {
            item: np.array([as_numbers.get(cell, number(cell, table.decimal)) for cell in cells])
            for item, named in block.items.items()
            if (cells := table.column(named.column))
        }
        answers = {item: each.astype(float) for item, each in answers.items()}
        whole = [np.sum([answers[i.name] for i in block.instrument.asked if i.name in answers], 0)]
        for raw in (*whole, *(_raw(e, block.instrument, answers) for e in block.instrument.scales)):
            both = None if raw is None else ~np.isnan(raw + given)
            if both is None or sum(both) < _FEWEST_SCORED:
                continue
            x, y = raw[both], given[both]
            if np.ptp(x) and np.ptp(y):
                rounded = min(max(ROUNDED, 0.51 * step_of(y)), np.ptp(y) / 20)
                if np.abs(np.polyval(np.polyfit(x, y, 1), x) - y).max() <= rounded:
                    return True
                told = told or raw is not whole[0]
    return False if told else None


_FEWEST_SCORED = 4
"""Rows with a score: any two are in a line."""


def _raw(
    scale: Scale, instrument: Instrument, answers: Mapping[str, NDArray[np.float64]]
) -> NDArray[np.float64] | None:
    """Return a score but for its unit and its zero; None where items are not there."""
    needed = {term.item for term in scale.terms} | {weight for _, weight in scale.weights}
    if not needed <= answers.keys():
        return None
    weights = dict(scale.weights)
    parts = [
        term.slope * answers[term.item] * (answers[weights[term.item]] if weights else 1)
        for term in scale.terms
    ]
    for name, times in scale.parts:
        part = instrument.scale(name)
        own = None if part is None else _raw(part, instrument, answers)
        if own is None:
            return None
        parts.append(times * own)
    whole: NDArray[np.float64] = np.sum(parts, axis=0)
    return whole


def leftovers(
    table: SourceTable, columns: Sequence[int], blocks: Sequence[Found], known: Known
) -> tuple[dict[int, str], list[OpenDoubt]]:
    """Return why columns are ignored, as far as that is known, and ask about answers in them."""
    reasons: dict[int, str] = {}
    doubts: list[OpenDoubt] = []
    maybe: list[str] = []
    several: list[str] = []
    for column in columns:
        words = texts(table, column)
        heading = table.headings[column]
        if not words:
            reasons[column] = "empty"
        elif sum(bool(numbers_in(word)) for word in words) * 2 > len(words):
            several.append(heading)
        elif parts := sum_of(table, column, blocks, known):
            reasons[column] = f"the exact (weighted) sum of {listed(parts, 3)}"
        elif blocks and may_answer(table, column, blocks[0].instrument, known.vocabulary):
            maybe.append(heading)
    if maybe:
        shown = listed([*map(repr, maybe)], _SHOWN)
        question = f"These hold what may be answers: {shown}. Is one of them an item?"
        doubts.append(OpenDoubt(question, "none is, and they are ignored", CURIOUS))
    if several:
        shown = ", ".join(map(repr, several))
        named = mentions(shown, known.instruments)
        to = ", ".join(each.short for each in known.instruments if each.name in named)
        question = f"Cells of {shown} hold several numbers each: are these no answers?"
        stake = LOST._replace(otherwise=f"answers to {to} would be missing") if to else CURIOUS
        instead = 'in the table: read = { spread = ["the heading"] }, which makes columns of them'
        stake = stake._replace(instead=instead)
        doubts.append(OpenDoubt(question, "they are none, and are ignored", stake))
    return reasons, doubts
