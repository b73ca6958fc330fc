"""Finds the items that headings name, and the columns that are one questionnaire."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence, Set
from dataclasses import replace
from itertools import pairwise, takewhile

from vrcomfort.importing.answers import number
from vrcomfort.importing.files import is_number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.codings import code_of
from vrcomfort.importing.suggest.evidence import is_identifier
from vrcomfort.importing.suggest.found_answers import Context, Found, mentions, named_by_file
from vrcomfort.importing.suggest.item_names import WEIGHTS, Named, item_behind_stem
from vrcomfort.importing.suggest.stems import shared_stems
from vrcomfort.importing.suggest.vocabulary import Known, LabVocabulary, tokens
from vrcomfort.questionnaire import Instrument, plain

FEWEST, FEWEST_OF_NAMED = 4, 3
"""So many items of an instrument, or all it has, make a questionnaire; where its name stands in
headings or in the name of the file, fewer do."""


def find_blocks(table: SourceTable, columns: Sequence[int], known: Known) -> list[Found]:
    """Return the questionnaires that the headings of a table name, no column twice.

    By the names of the items, else by their numbers, else (where there are no headings, or the
    file is called after a questionnaire) by where the answers stand.
    """
    found: list[Found] = []
    other = {*range(len(table.headings))} - {*columns}
    said = named_by_file(table, known.instruments)
    named = [each for each in known.instruments if each.name in said]
    # Numbers in a file that is called after a scale of one item are those of its times.
    rated = bool(named) and all(len(each.asked) == 1 for each in named)
    for find in (_by_codes, _by_name, *(() if rated else (_by_number,)), _by_initials):
        taken = other.union(*(block.columns for block in found))
        blocks = [b for i in known.instruments for b in find(table, i, taken, known.vocabulary)]
        found += _best(table, blocks, known.instruments)
    severe = [each for each in known.instruments if _is_of_severity(each)]
    if not found and not table.reading.heading_rows:
        found = _runs(table, known) or _by_position(table, known, named or severe)
    elif not found:
        people = {c for c in columns if is_identifier(table, c, known.vocabulary)}
        found = _by_position(table, known, named, other | people)
    found = _with_letters(table, _with_weights(found), other, known.vocabulary)
    found = _without_gaps(table, found, other)
    found = [replace(block, siblings=_siblings(block, found)) for block in _without_stems(found)]
    return sorted(found, key=lambda block: block.columns)


def _by_codes(
    table: SourceTable, instrument: Instrument, taken: set[int], vocabulary: LabVocabulary
) -> list[Found]:
    """Find ``PD_MD``, ``PD_PD``: codes of conditions that look like those of items.

    The item is where each condition has all of them.
    """
    known = {**vocabulary.initials(instrument), **vocabulary.spellings(instrument)}
    asked = {item.name for item in instrument.asked}
    codes = {word: item for word, item in known.items() if item in asked and len(word) < 4}
    split = {c: tokens(h) for c, h in enumerate(table.headings) if c not in taken}
    pairs = {c: (w[0], w[-1]) for c, w in split.items() if len(w) == 2}
    if len(asked) < FEWEST or not any(a in codes and b in codes for a, b in pairs.values()):
        return []
    for item_place in (1, 0):
        groups: dict[Context, dict[str, Named]] = defaultdict(dict)
        for column, words in pairs.items():
            item, other = codes.get(words[item_place]), words[1 - item_place]
            if item is not None:
                named = Named(column, instrument.name, item, "initials", (), ())
                groups[(other,)].setdefault(item, named)
        if len(groups) > 1 and all({*items} == asked for items in groups.values()):
            return [Found(instrument, context, items) for context, items in groups.items()]
    return []


def _without_stray_weights(block: Found) -> Found:
    """Return a block without weights where most are lacking: `Weighted Rate` is a score."""
    asked = {item.name for item in block.instrument.asked}
    weights = {*block.items} - asked
    lacking = {item.name for item in block.instrument.items} - asked - weights
    kept = {i: n for i, n in block.items.items() if i in asked or len(weights) > len(lacking)}
    return replace(block, items=kept or block.items)


def _with_weights(found: Sequence[Found]) -> list[Found]:
    """Put weights, which are asked beside the items, into the block with most of their words."""
    found = [_without_stray_weights(block) for block in found]
    weights = [b for b in found if not {*b.items} & {item.name for item in b.instrument.asked}]
    blocks = [block for block in found if block not in weights]
    for each in weights:
        free = [
            block
            for block in blocks
            if block.instrument is each.instrument and not {*block.items} & {*each.items}
        ]
        if free:
            best = max(free, key=lambda block: len({*block.context} & {*each.context}))
            whole = replace(best, items={**best.items, **each.items})
            blocks[blocks.index(best)] = whole
    return blocks


def _with_letters(
    table: SourceTable, found: Sequence[Found], other: Set[int], vocabulary: LabVocabulary
) -> list[Found]:
    """Find items coded by a letter beside the others: ``P``, ``E`` and ``F`` behind ``MD``."""
    taken = {c for block in found for c in block.columns} | other
    filled = []
    for block in found:
        initials = vocabulary.initials(block.instrument)
        items = dict(block.items)
        for place in (-1, 1):
            column = (block.columns[0] if place < 0 else block.columns[-1]) + place
            while 0 <= column < len(table.headings) and column not in taken:
                words = [w for w in tokens(table.headings[column]) if w not in block.context]
                item = initials.get(words[0], "") if len(words) == 1 else ""
                if item in items or item not in block.absent:
                    break
                if not _fit(table, [column], block.instrument):
                    break
                items[item] = Named(column, block.instrument.name, item, "initials", (), ())
                taken.add(column)
                column += place
        filled.append(replace(block, items=items))
    return filled


def _without_gaps(table: SourceTable, found: Sequence[Found], other: Set[int]) -> list[Found]:
    """Fill in items without a column whose place in the published order holds answers."""
    taken = {c for block in found for c in block.columns} | other
    filled = []
    for block in found:
        order = [item.name for item in block.instrument.asked]
        places = {item: named.column for item, named in block.items.items() if item in order}
        ranked = sorted(places, key=order.index)
        rising = [places[item] for item in ranked] == sorted(places.values())
        items = dict(block.items)
        most = rising and len(ranked) * 2 > len(order)
        known = [(order.index(item), places[item]) for item in (ranked if most else ())]
        for (one, left), (next_, right) in pairwise(_with_ends(table, known, len(order))):
            lacking = order[one + 1 : next_]
            between = [c for c in range(left + 1, right) if c not in taken]
            if lacking and len(between) == len(lacking) and _fit(table, between, block.instrument):
                for item, column in zip(lacking, between, strict=True):
                    items[item] = Named(column, block.instrument.name, item, "order", (), ())
        filled.append(replace(block, items=items))
    return filled


def _with_ends(
    table: SourceTable, known: Sequence[tuple[int, int]], count: int
) -> list[tuple[int, int]]:
    """Return places of items, and their columns, with those just beyond the first and the last.

    Columns there are of the same questionnaire where a heading begins with the same word.
    """
    if not known:
        return []
    (first, left), (last, right) = known[0], known[-1]
    low, high = left - first, right + count - 1 - last
    starts = [(tokens(heading) or [""])[0] for heading in table.headings]
    before = low >= 0 and {*starts[low:left]} <= {starts[left]}
    after = high < len(starts) and {*starts[right + 1 : high + 1]} <= {starts[right]}
    return [*([(-1, low - 1)] if before else []), *known, *([(count, high + 1)] if after else [])]


def _without_stems(found: Sequence[Found]) -> list[Found]:
    """Return questionnaires with the letters alone by which codes before them differ: ``SYSA``."""
    stems: dict[str, set[str]] = defaultdict(set)
    for word in {word for block in found for word in block.context if len(word) > _LETTERS}:
        stems[word[:-1]].add(word)
    ends = {w: w[-1] for words in stems.values() if len(words) == len(found) > 1 for w in words}
    return [replace(b, context=tuple(ends.get(w, w) for w in b.context)) for b in found]


_LETTERS = 2
"""Of a code before the letter of a condition."""


def _siblings(block: Found, found: Sequence[Found]) -> tuple[int, ...]:
    alike = (e for e in found if e.instrument is block.instrument and e is not block)
    return tuple(column for each in alike for column in each.columns)


def _by_name(
    table: SourceTable, instrument: Instrument, taken: set[int], vocabulary: LabVocabulary
) -> list[Found]:
    if len(instrument.asked) == 1:
        return []
    headings, labels = shared_stems(table.headings), shared_stems(table.labels)
    named = [
        each
        for index, (heading, label) in enumerate(zip(headings, labels, strict=True))
        if index not in taken
        and (each := item_behind_stem(index, heading, label, instrument, vocabulary)) is not None
    ]
    named = [each for each in named if not _answers_otherwise(table, each, instrument, vocabulary)]
    named = _without_strays(table, named, instrument)
    if runs := _repeated_runs(named, instrument):
        return [
            Found(instrument, (str(n),) if n > 1 else (), {each.item: each for each in run})
            for n, run in enumerate(runs, start=1)
        ]
    moments = vocabulary.timepoints.keys()
    written = {word for each in named for word in tokens(table.headings[each.column])}
    contexts = _contexts(named, instrument)
    contexts = _without_wording(named, contexts, instrument, moments, written)
    groups: dict[Context, dict[str, Named]] = defaultdict(dict)
    for each, context in zip(named, contexts, strict=True):
        groups.setdefault(_free(groups, context, each), {})[each.item] = each
    return [Found(instrument, context, items) for context, items in groups.items()]


def _answers_otherwise(
    table: SourceTable, named: Named, instrument: Instrument, vocabulary: LabVocabulary
) -> bool:
    """Return whether a heading with an item's words has answers of another scale.

    They are degrees of agreement beside degrees of severity, or numbers far beyond.
    """
    cells = {*table.column(named.column)} - {""}
    ends = {plain(word) for word in instrument.labels}
    agree = vocabulary.agreement.keys()
    if cells and not ends & agree and all(plain(cell) in agree for cell in cells):
        return True
    values = [number(cell, table.decimal) for cell in cells]
    beyond = max((value for value in values if value is not None), default=0) > instrument.high + 1
    return named.how == "wording" and beyond


def _repeated_runs(named: Sequence[Named], instrument: Instrument) -> list[list[Named]]:
    """Return runs of columns with the same items in the same order, which nothing else tells apart.

    Headings that are the same are numbered, and a misspelt one of them begins anew.
    """
    asked = {item.name for item in instrument.asked}
    runs: list[list[Named]] = []
    for each in named:
        if each.item not in asked:
            continue
        if each.before or any(not word.isdecimal() for word in each.after):
            return []
        if not runs or each.item in {other.item for other in runs[-1]}:
            runs.append([])
        runs[-1].append(each)
    orders = [[each.item for each in run] for run in runs]
    same = len(runs) > 1 and all(order == orders[0] for order in orders)
    misspelt = any(each.how == "near" for run in runs for each in run)
    return runs if same and misspelt and len(orders[0]) >= FEWEST else []


def _without_strays(table: SourceTable, named: list[Named], instrument: Instrument) -> list[Named]:
    """Return headings without a few that lack the instrument's name, where most others have it.

    A rating of discomfort beside a questionnaire is none of its items.
    """
    own = [each for each in named if mentions(table.headings[each.column], [instrument])]
    few = len(named) - len(own) < FEWEST <= len(own) and len(own) * 3 >= len(named) * 2
    return own if few else named


def _free(groups: dict[Context, dict[str, Named]], context: Context, each: Named) -> Context:
    """Return the context, with a number if its item has a column that is as good already."""
    key, number = context, 1
    while key in groups and each.item in groups[key]:
        there = groups[key][each.item]
        if WEIGHTS[each.how] > WEIGHTS[there.how]:
            groups[key][each.item] = each  # the other is left to be asked about
            return key
        if WEIGHTS[each.how] < WEIGHTS[there.how]:
            beside = (
                k for k, g in groups.items() if each.column - 1 in {n.column for n in g.values()}
            )
            key = next(beside, key)  # a misspelt item of the block that it stands beside
            return (*context, "?") if each.item in groups[key] else key
        number += 1
        key = (*context, str(number))
    return key


def _contexts(named: Sequence[Named], instrument: Instrument) -> list[Context]:
    """Return for each heading the words that it shares with those of other items."""
    numbered = _item_numbers(named)
    rests = [
        [
            word
            for side, words in (("before", each.before), ("after", each.after))
            for place, word in _placed(side, words)
            if (side, place) not in numbered
        ]
        for each in named
    ]
    items_with: dict[str, set[str]] = defaultdict(set)
    for each, rest in zip(named, rests, strict=True):
        for word in rest:
            items_with[word].add(each.item)
    items = len({each.item for each in named})
    shared = {word for word, found in items_with.items() if len(found) * 2 >= items}
    own = set(tokens(instrument.name))
    return [tuple(word for word in rest if word in shared and word not in own) for rest in rests]


def _without_wording(
    named: Sequence[Named],
    contexts: Sequence[Context],
    instrument: Instrument,
    moments: Set[str],
    written: Set[str],
) -> list[Context]:
    """Return contexts without words of questions, such as the name of the system in most of them.

    Words count that all share, that tell the columns of several items apart, or that say a moment:
    a score called as an item is lacks it. Those that all share stand in headings (`written`), not
    in the texts of questions alone.
    """
    same: dict[str, list[set[str]]] = defaultdict(list)
    for each, context in zip(named, contexts, strict=True):
        same[each.item].append({*context})
    telling = Counter(
        w for sets in same.values() for w in set.union(*sets) if any(w not in s for s in sets)
    )
    fewest = min(FEWEST_OF_NAMED, len(instrument.asked))
    kept = {word for word, items in telling.items() if items >= fewest}
    kept.update(w for context in contexts for w in context if w in moments)
    shared = set.intersection(*({*context} for context in contexts)) if contexts else set()
    kept |= shared & written
    denied = Counter(b for c in contexts for a, b in pairwise(c) if a in _NEGATIONS & kept)
    kept |= {word for word, _ in denied.most_common(1)}  # NoBlur
    return [tuple(dict.fromkeys(w for w in context if w in kept)) for context in contexts]


_NEGATIONS = frozenset(["no", "non", "without", "ohne", "kein", "keine", "sin", "sans"])


def _placed(side: str, words: Sequence[str]) -> list[tuple[int, str]]:
    """Return words with how far they stand from the item's name."""
    if side == "after":
        return list(enumerate(words, start=1))
    return [(len(words) - place, word) for place, word in enumerate(words)]


def _item_numbers(named: Sequence[Named]) -> set[tuple[str, int]]:
    """Return the places in headings where the number of the item stands: another for each."""
    # Numbers of sessions or trials stand in headings, too, but most items share them.
    numbers: dict[tuple[str, int], dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for each in named:
        for side, words in (("before", each.before), ("after", each.after)):
            for place, word in _placed(side, words):
                if word.isdecimal():
                    numbers[side, place][each.item].add(word)
    items = len({each.item for each in named})
    return {
        place
        for place, found in numbers.items()
        if len(found) * 2 > items
        and len({min(each) for each in found.values()}) * 5 >= len(found) * 4 > 8
    }


def _best(
    table: SourceTable, found: Sequence[Found], instruments: Sequence[Instrument]
) -> list[Found]:
    """Return the questionnaires that explain most, none with a column of another."""

    def merit(block: Found) -> tuple[float, ...]:
        whole = len(block.items) / len(block.instrument.asked)
        headings = [table.headings[c] for c in block.columns]
        said = block.instrument.name in named_by_file(table, instruments, *headings)
        exact = sum(named.how in {"name", "wording", "number"} for named in block.items.values())
        part = any(
            {*block.columns} < {*other.columns}
            and len(other.items) >= len(block.items) + _MORE_ITEMS
            for other in found
        )
        unsaid = len(block.context)  # of two with the same items, one may be named
        again = block.instrument.asks == "symptoms"  # as others that are asked once are not
        return (said, whole == 1.0 and not part, exact + whole, again, -unsaid)

    kept: list[Found] = []
    taken: set[int] = set()
    for block in sorted(found, key=merit, reverse=True):
        items = {i: named for i, named in block.items.items() if named.column not in taken}
        said, *_ = merit(block)
        sure = all(named.how == "name" for named in items.values())
        sure = sure and len({(named.before, named.after) for named in items.values()}) == 1
        fewest = FEWEST_OF_NAMED if said and sure else FEWEST
        enough = min(fewest, len(block.instrument.asked))
        if len(items) >= enough and _is_worth(block, items):
            kept.append(replace(block, items=items))
            taken.update(named.column for named in items.values())
    return kept


_MORE_ITEMS = 3
"""Items by which a questionnaire of which some are lacking explains more than a whole one."""


def _is_worth(block: Found, items: dict[str, Named]) -> bool:
    """Return whether the items left are still a questionnaire, and not words of another."""
    hows = Counter(named.how for named in items.values())
    sure = sum(hows[how] for how in ("name", "wording", "number", "initials"))
    return len(items) == len(block.items) and sure * 3 >= len(items)


def _by_number(
    table: SourceTable, instrument: Instrument, taken: set[int], vocabulary: LabVocabulary
) -> list[Found]:
    """Find ``SSQ1`` … ``SSQ16``: headings that differ in a number alone, from 1 (or 0) on."""
    count = len(instrument.asked)
    if count < FEWEST or not table.reading.heading_rows:
        return []
    groups: dict[tuple[Context, Context], dict[int, int]] = defaultdict(dict)
    for column, heading in enumerate(table.headings):
        words = tokens(heading)
        for place, word in enumerate(words):
            if column not in taken and word.isdecimal() and len(word) < 4:
                key = tuple(words[:place]), tuple(words[place + 1 :])
                groups[key].setdefault(int(word), column)
    found = []
    for (before, after), columns in groups.items():
        first = min(columns)
        whole = sorted(columns) == list(range(first, first + count)) and first in {0, 1}
        places = list(columns.values())
        named = whole and _is_named(table, places, instrument, vocabulary)
        if named and _fit(table, places, instrument):
            items = {
                item.name: Named(columns[n], instrument.name, item.name, "number", before, after)
                for n, item in enumerate(instrument.asked, start=first)
            }
            own = set(tokens(instrument.name)) | vocabulary.item_fillers
            context = tuple(word for word in (*before, *after) if word not in own)
            found.append(Found(instrument, context, items))
    return found


_FEWEST_UNNAMED = 8
"""Items of an instrument that numbers alone can tell: four columns called 1 to 4 are anything."""


def _is_named(
    table: SourceTable, columns: Sequence[int], instrument: Instrument, vocabulary: LabVocabulary
) -> bool:
    """Return whether numbered columns name their instrument, or are many on a scale of its own."""
    if named_by_file(table, [instrument], *(table.headings[c] for c in columns)):
        return True
    cells = {text for column in columns for text in table.column(column)}
    agreed = {text for text in cells if plain(text) in vocabulary.agreement}
    said = any(is_number(t) or code_of(t, vocabulary) is not None for t in cells - agreed)
    return said and len(instrument.asked) >= _FEWEST_UNNAMED and _is_of_severity(instrument)


def _is_of_severity(instrument: Instrument) -> bool:
    """Return whether an instrument asks from none to severe, as few questions of a lab's own do."""
    return instrument.high - instrument.low == _STEPS


def _fit(table: SourceTable, columns: Sequence[int], instrument: Instrument) -> bool:
    """Return whether most numbers in columns are answers, counted from its lowest or from 1."""
    cells = [cell for column in columns for cell in table.column(column) if cell]
    values = [value for cell in cells if (value := number(cell, table.decimal)) is not None]
    low, high = float(instrument.low), float(instrument.high)
    half = (high - low) / 2
    if any(value < 0 for value in values) and all(-half <= value <= half for value in values):
        return _are_answers(table, columns)  # coded around 0
    inside = sum(low <= value <= high + 1 for value in values)
    many = high - low > MOST_ANSWERS and len(values) == len(cells) > 0
    return (many or _are_answers(table, columns)) and inside * 10 >= len(values) * 8


def _by_initials(
    table: SourceTable, instrument: Instrument, taken: set[int], vocabulary: LabVocabulary
) -> list[Found]:
    """Find ``SSQ_GD``, ``SSQ_DEO``: initials of at least nine in ten items of an instrument."""
    count = len(instrument.asked)
    known = vocabulary.initials(instrument)
    own = set(tokens(instrument.name))
    groups: dict[Context, dict[str, Named]] = defaultdict(dict)
    for column, heading in enumerate(table.headings):
        words = [word for word in tokens(heading) if word not in own]
        for place, word in enumerate(words):
            if column not in taken and word in known:
                before, after = tuple(words[:place]), tuple(words[place + 1 :])
                named = Named(column, instrument.name, known[word], "initials", before, after)
                there = groups[*before, *after]
                if known[word] not in there or word in vocabulary.listed_initials(instrument):
                    there[known[word]] = named  # SA may be salivation, where ST is the stomach
    return [
        Found(instrument, context, items)
        for context, items in groups.items()
        if count >= FEWEST and len(items) * 10 >= count * 9
        if _are_answers(table, [named.column for named in items.values()])
    ]


def _are_answers(table: SourceTable, columns: Sequence[int]) -> bool:
    """Return whether columns hold a few short texts, as those of a questionnaire do."""
    texts = {text for column in columns for text in table.column(column) if text}
    return 0 < len(texts) <= MOST_ANSWERS and max(map(len, texts)) <= 40


MOST_ANSWERS = 30
"""Different answers to a questionnaire, but to one that has more, in numbers."""


def _runs(table: SourceTable, known: Known) -> list[Found]:
    """Find blocks of as many columns of answers each, with other columns between them."""
    blocks: list[list[int]] = []
    before = False
    for column in range(len(table.headings)):
        now = _holds_answers(table, column, known.vocabulary)
        if now and before:
            blocks[-1].append(column)
        elif now:
            blocks.append([column])
        before = now
    length = Counter(map(len, blocks)).most_common(1)[0][0] if blocks else 0
    runs = [block for block in blocks if len(block) == length]
    said = named_by_file(table, known.instruments)
    fits = [i for i in known.instruments if len(i.asked) >= length and _is_of_severity(i)]
    fits.sort(key=lambda each: (len(each.asked) != length, each.name not in said))
    if len(runs) < 2 or length < FEWEST or not fits:
        return []
    return [_in_published_order(fits[0], run) for run in runs]


def _in_published_order(instrument: Instrument, columns: Sequence[int]) -> Found:
    """Return a questionnaire whose first items these columns are."""
    items = {
        item.name: Named(column, instrument.name, item.name, "position", (), ())
        for item, column in zip(instrument.asked, columns, strict=False)
    }
    return Found(instrument, (), items)


_STEPS = 3
"""From none to severe: instruments whose answers may be words of severity."""


def _holds_answers(table: SourceTable, column: int, vocabulary: LabVocabulary) -> bool:
    """Return whether all texts of a column are words of severity, or 0 to 4."""
    words = {text for text in table.column(column) if text}
    parts = [{plain(part) for part in word.split("/")} for word in words]
    asked = all(each & vocabulary.yes_no for each in parts)
    severe = all(
        word in _SMALL or each & vocabulary.severity.keys()
        for word, each in zip(words, parts, strict=True)
    )
    return bool(words) and severe and not asked


_SMALL = frozenset("01234")


def _by_position(
    table: SourceTable,
    known: Known,
    instruments: Sequence[Instrument],
    other: Set[int] = frozenset(),
) -> list[Found]:
    """Take as many columns of answers, side by side, as an instrument has items.

    Answers are small whole numbers, or words of agreement.

    In a longer run, that ends the table, they are the last ones. None is of the other columns.
    """
    said = named_by_file(table, known.instruments)
    for instrument in sorted(instruments, key=lambda each: each.name not in said):
        count = len(instrument.asked)
        answers = {*instrument.answers.plain, str(instrument.high + 1), ""}
        if not instrument.answers.plain:  # too many to list
            texts = {text for c in range(len(table.headings)) for text in table.column(c)}
            read = {text: number(text, table.decimal) for text in texts}
            answers |= {t for t, v in read.items() if v is not None and instrument.answers.has(v)}
        five = instrument.high - instrument.low == 4  # from strong disagreement to agreement
        agreed = {*known.vocabulary.agreement} if five else set()
        cells = [{*table.column(c)} - {""} for c in range(len(table.headings))]
        fits = [
            c not in other and bool(each) and (each <= answers or {*map(plain, each)} <= agreed)
            for c, each in enumerate(cells)
        ]
        ends = [c for c in range(len(fits)) if fits[c] and not any(fits[c + 1 : c + 2])]
        for end in reversed(ends):
            run = [*takewhile(fits.__getitem__, range(end, -1, -1))][::-1]
            whole = len(run) == count or (len(run) > count and end == len(fits) - 1)
            if FEWEST <= count < len(table.headings) and whole:
                return [_in_published_order(instrument, run[-count:])]
    return []
