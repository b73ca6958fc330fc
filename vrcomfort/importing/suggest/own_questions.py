"""Finds a lab's own questions: columns of answers that belong to no known instrument.

A column is one if its cells are answers on one scale, and its heading asks for an opinion: by a
word (`questions` in the vocabulary), as a sentence, by the ends of its scale, or as one of a row of
numbered codes. What asks nothing is taken for what `left_over` says.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from dataclasses import replace
from functools import cached_property, reduce
from itertools import pairwise

from vrcomfort.importing.answers import number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.answer_scales import (
    FEWEST_ANSWERS,
    are_of_seven,
    is_missing,
    kind_of_words,
    put_coding,
    scale_of,
    yes_or_no,
)
from vrcomfort.importing.suggest.block_conditions import numbered_conditions
from vrcomfort.importing.suggest.cells import is_numeric, texts, varies_within
from vrcomfort.importing.suggest.codebooks import BESIDE, TITLE
from vrcomfort.importing.suggest.computed_columns import computed_columns
from vrcomfort.importing.suggest.crossed_words import crossed, differing
from vrcomfort.importing.suggest.draft import DIRECTION, OpenDoubt
from vrcomfort.importing.suggest.evidence import asks_name
from vrcomfort.importing.suggest.found_answers import Context, Found
from vrcomfort.importing.suggest.heading_roles import Roles, roles_of
from vrcomfort.importing.suggest.item_names import How
from vrcomfort.importing.suggest.left_over import ask_of_left
from vrcomfort.importing.suggest.own_instruments import (
    FEWEST_OF_SERIES,
    AnswerRange,
    OwnQuestion,
    TakenFor,
    ask_about,
    declared,
    name_of,
)
from vrcomfort.importing.suggest.questionnaires import Drafted
from vrcomfort.importing.suggest.ratings import FoundCourse, FoundRating, rises, time_column
from vrcomfort.importing.suggest.stems import Stem, shared_stems
from vrcomfort.importing.suggest.vocabulary import (
    FEWEST_OF_SENTENCE,
    Known,
    LabVocabulary,
    tokens,
    words_of,
)
from vrcomfort.importing.toml_draft import TomlDraft
from vrcomfort.questionnaire import plain, shipped_instruments
from vrcomfort.questionnaire.instrument_file import TAKEN

_FEWEST_STEPS = 2
_FEWEST_WORDS = 3
"""Answers in words that show which scale a question is on."""
_FEWEST_OF_BLOCK = 5
"""Questions on the scale of a number with decimals, which is then their mean."""
_BRACKET = re.compile(r"\[([^\[\]]*[^\W\d_]{2}[^\[\]]*)\]\s*$")
"""The statement of a grid of questions: ``Do you agree? [I felt present]``."""
_ENDS = (
    re.compile(r"[(\[ ](-?\d{1,2})\s*(?:-|–|—|\.\.+|to|bis|a|à|/)\s*(\d{1,3})(?!\d)"),
    re.compile(r"(-?\d{1,2})\s*[=:(]\s*[^\d=:]{2,80}?(\d{1,3})\s*[=:(]"),
)
"""The ends of a scale in a heading: ``(1-7)``, ``1 = not at all, 7 = very``."""
_REPEATED = re.compile(r" \(\d+\)$")
_NUMBERING = re.compile(r"^\d{1,2}[.)] +(?=\D)")
_NUMBER_OF_ITEM = re.compile(r"(?<=[^\d])\d+$")
_FEWEST_FAR = 10
"""Codes for no answer that no number on a usual scale is, as -1 may be."""
_CLOCK = frozenset(["t", "time", "zeit"])


class OwnQuestions:
    """The lab's own questions among some columns of a table.

    Parameters
    ----------
    contexts
        The words that tell the administrations of known instruments apart.
    left
        Column that nothing else knows → what it is taken for.
    """

    def __init__(
        self,
        table: SourceTable,
        columns: Sequence[int],
        known: Known,
        contexts: Iterable[Context],
        left: Mapping[int, TakenFor],
    ) -> None:
        self._table = table
        numbered = numbered_conditions(table, known.vocabulary)
        columns = [column for column in columns if column not in numbered.values()]
        self._left = {c: each for c, each in left.items() if c not in numbered.values()}
        self._columns, self._known = columns, known
        self._vocabulary = known.vocabulary
        self._roles = roles_of(table, columns, known.vocabulary)
        contexts = [*contexts]
        self._apart = {word for context in contexts for word in context}
        self._glued = _glued(table.headings, contexts)
        self._apart |= {w for name in known.vocabulary.conditions for w in name.split("_")}
        self._apart |= {*map(str, numbered)}
        self._headings = shared_stems(table.headings)
        self._labels = shared_stems(table.labels)
        items = any(
            plain(heading) in known.vocabulary.item_labels and not is_numeric(table, column)
            for column, heading in enumerate(table.headings)
        )
        no_item = known.vocabulary.response_labels if items else frozenset()
        self._has_headings = bool(table.reading.heading_rows or table.nested)
        cells = (cell for row in table.rows for cell in row)
        seven = are_of_seven(cells, known.vocabulary)
        self._scales = {
            column: scale
            for column in columns
            if plain(table.headings[column]) not in no_item
            if not asks_name(table, column, known.vocabulary)
            if not (self._has_headings and table.headings[column].startswith("column "))
            if (scale := scale_of(table, column, known.vocabulary, of_seven=seven)) is not None
        }

        self._scales |= {c: each.scale for c, each in self._left.items() if not each.measured}
        self._ranked = ranks_in_words(table, columns, known.vocabulary)
        self._scales |= {c: AnswerRange(1, len(words)) for c, words in self._ranked.items()}
        self.conditions = self._codes_of_conditions()
        """Words that tell the same questions apart, as conditions: ``PnP_1``, ``HMD_1``."""
        self._apart |= {word for code in self.conditions for word in code}

    def _codes_of_conditions(self) -> list[tuple[str, ...]]:
        """Return the codes before runs of the same numbers, where a column has their order."""
        if "sequence" not in self._roles.covariates or self._roles.facts.get("condition"):
            return []
        series: dict[tuple[str, ...], list[str]] = defaultdict(list)
        for column in self._scales:
            *code, last = tokens(self._table.headings[column])
            if code and last.isdecimal():
                series[tuple(code)].append(last)
        alike: dict[tuple[str, ...], list[tuple[str, ...]]] = defaultdict(list)
        for words, numbers in series.items():
            no_name = {*words} & (self._vocabulary.timepoints.keys() | {*self._vocabulary.numbered})
            if len(numbers) >= FEWEST_OF_SERIES and not no_name:
                alike[tuple(numbers)].append(words)
        codes = max(alike.values(), key=len, default=[])
        said = [(c, tokens(self._table.headings[c])[:-1]) for c in self._scales]
        groups = [[c for c, w in said if w == [*code]] for code in codes]
        return codes if len(codes) > 1 and self._are_met_together(groups) else []

    def _are_met_together(self, groups: Collection[Collection[int]]) -> bool:
        """Return whether people answered columns of several groups: others are forms of one."""
        rows = ([any(row[c] for c in own) for own in groups] for row in self._table.rows)
        return len(groups) < 2 or any(sum(answered) > 1 for answered in rows)

    @cached_property
    def courses(self) -> list[FoundCourse]:
        """Return ratings during exposure that have a column for each time: ``comfort_2min``."""
        groups: dict[tuple[str, ...], dict[int, int]] = defaultdict(dict)
        for column in self._scales:
            words = tokens(self._table.headings[column])
            places = [
                n for n, word in enumerate(words) if word.isdecimal() and self._is_time(words, n)
            ]
            if len(places) == 1:
                rest = tuple("#" if n == places[0] else w for n, w in enumerate(words))
                groups[rest].setdefault(int(words[places[0]]), column)
        groups = {
            said: columns
            for said, columns in groups.items()
            if len(columns) >= FEWEST_OF_SERIES and [*columns] == sorted(columns)
        }
        asking = self._vocabulary.asking_words
        fillers = {"#", *self._apart, *self._vocabulary.units, *_CLOCK}
        names = [[word for word in said if word not in fillers] for said in groups]
        alike: dict[str, list[tuple[Context, list[int]]]] = defaultdict(list)
        for said, own, named in zip(groups, differing(names, asking), names, strict=True):
            context = (*(word for word in said if word in self._apart), *own)
            if asking & {*named, *tokens(self._table.file.stem)}:
                text = " ".join(word for word in named if word not in own) or "rating"
                alike[text].append((context, [*groups[said].values()]))
        taken: set[str] = {*shipped_instruments(), *TAKEN}
        found = []
        for text, courses in alike.items():
            scales = [self._scales[c] for _, columns in courses for c in columns]
            widest = reduce(lambda one, other: one | other, scales)
            name = name_of(text, taken)
            scale = declared(name, [(name, text, widest.usual)])
            for context, rated in courses if widest.high >= _FEWEST_STEPS else ():
                ratings = (FoundRating(scale, context, column, None) for column in rated)
                found.append(FoundCourse(scale, context, tuple(ratings)))
        return found

    def _is_time(self, words: Sequence[str], place: int) -> bool:
        beside = {*words[place + 1 : place + 2]} & self._vocabulary.units
        return bool(beside or {*words[place - 1 : place]} & (_CLOCK | self._vocabulary.units))

    @cached_property
    def questions(self) -> list[OwnQuestion]:
        """Return the questions, with the words of each that tell administrations apart."""
        rated = {c for course in self.courses for c in course.columns}
        columns = [c for c in self._scales if c not in rated and self._asks(c)]
        columns += self._asked_again(columns, rated)
        columns = [c for c in columns if not self._is_made_of(c, columns)]
        if len(columns) != 1 or self._times is None:  # else it is a rating during exposure
            columns += self._left_over(columns, rated)
            columns = [c for c in columns if c in self._left or not self._is_made_of(c, columns)]
        return self._in_runs(self._crossed([*map(self._question, sorted(columns))]))

    def _left_over(self, asking: Sequence[int], rated: set[int]) -> list[int]:
        """Return the columns that nothing knows, but for means of questions beside them."""
        open_ = [c for c in self._left if c not in rated and c not in asking]
        return [c for c in open_ if not self._is_made_of(c, [*asking, *open_])]

    @cached_property
    def _times(self) -> int | None:
        """Return the column of the times of ratings, if they rise."""
        time = time_column(self._table, self._columns, self._known)
        return time if time is not None and rises(self._table, time) else None

    @cached_property
    def rated(self) -> list[FoundRating]:
        """Return the only question as a rating during exposure, if a column has its times."""
        if len(self.questions) != 1 or self._times is None:
            return []
        (asked,) = self.questions
        name = name_of(asked.text, {*shipped_instruments(), *TAKEN})
        scale = declared(name, [(name, asked.text, asked.said or asked.seen.usual)])
        return [FoundRating(scale, asked.context, asked.column, self._times)]

    def _in_runs(self, questions: list[OwnQuestion]) -> list[OwnQuestion]:
        """Tell runs of questions apart that repeat in the same order, by their numbers."""
        said = {each.column: self._bare(self._table.headings[each.column]) for each in questions}
        again = {text for text, count in Counter(said.values()).items() if count > 1}
        once = [each for each in questions if said[each.column] not in again]
        questions = [each for each in questions if said[each.column] in again]
        bare = [said[each.column] for each in questions]
        if not again:
            return once
        for size in range(1, len(bare) // 2 + 1):
            runs = [bare[start : start + size] for start in range(0, len(bare), size)]
            alike = all(run == runs[0] for run in runs)
            if alike and (len({*runs[0]}) > 1 or questions[0].how != "measure"):
                break
        else:
            return sorted([*once, *questions], key=lambda each: each.column)
        often = Counter(runs[0])
        found = once
        for place, (each, text) in enumerate(zip(questions, bare, strict=True)):
            run, within = divmod(place, size)
            number_within = runs[0][: within + 1].count(text)
            asked = f"{text} {number_within}" if often[text] > 1 else text
            found.append(replace(each, text=asked, context=(str(run + 1),)))
        return found

    def _bare(self, heading: str) -> str:
        """Return a heading without the number of its repetition: ``Sharp? (2)``, ``Sharp?2``."""
        bare = _REPEATED.sub("", heading)
        once = _NUMBER_OF_ITEM.sub("", bare)
        before = int(bare[len(once) :] or 0) - 1
        there = once in self._table.headings and {once, f"{once}{before}"} <= {
            *self._table.headings,
            f"{once}1",
        }
        return once if there else bare

    def _asked_again(self, asking: Sequence[int], rated: set[int]) -> list[int]:
        """Return other columns with the same question at another time, or the same words."""
        asked = {self._asked(c) for c in asking}
        worded = (c for c in asking if not is_numeric(self._table, c))
        words = {text for c in worded for text in texts(self._table, c)}
        open_ = {*self._roles.unknown} & {*self._scales} - rated - {*asking}
        return [c for c in sorted(open_) if self._asked(c) in asked or self._is_in(c, words)]

    def _is_in(self, column: int, words: Set[str]) -> bool:
        """Return whether the answers of a column are at least three of some words."""
        said = {*texts(self._table, column)}
        return len(said) >= _FEWEST_WORDS and said <= words and not self._is_no_answer(column)

    def _asked(self, column: int) -> str:
        return plain(_REPEATED.sub("", self._question(column).text))

    @cached_property
    def _families(self) -> dict[str, list[int]]:
        """Return the code before short headings → at least three columns: ``PRES_real``."""
        found: dict[str, list[int]] = defaultdict(list)
        for column in self._scales:
            words = tokens(self._table.headings[column])
            if 1 < len(words) < FEWEST_OF_SENTENCE:
                found[words[0]].append(column)
        return {code: each for code, each in found.items() if len(each) >= FEWEST_OF_SERIES}

    def _is_code(self, word: str) -> bool:
        """Return whether a moment's word is a code as others are: ``PRE_`` of presence."""
        moments = self._vocabulary.timepoints.keys()
        others = [code for code in self._families if code not in moments]
        headings = (tokens(self._table.headings[c]) for c in self._scales)
        said = {each for words in headings for each in words} & moments
        return word in self._families and len(others) > 1 and said == {word}

    def _words(self, column: int) -> list[str]:
        return tokens(f"{self._table.headings[column]} {self._table.labels[column]}")

    def _asks(self, column: int) -> bool:
        """Return whether a column's heading asks for an opinion, and its cells are answers."""
        vocabulary, words = self._vocabulary, self._words(column)
        own = {*words} - self._apart
        sentence = len(words) >= FEWEST_OF_SENTENCE and bool({*words} & vocabulary.asking_sentences)
        opinion = sentence or bool(own & vocabulary.asking_words)
        said = self._ends(column) is not None
        others = own & (vocabulary.asking_others | vocabulary.measures)
        shown = self._is_agreement(column) or column in self._in_grids
        if others and not (sentence or said or shown or {*words} & {"vas", "likert"}):
            return False
        whole = self._scales[column].step == 1
        asks = opinion or said or shown or (whole and column in self._series)
        free = self._is_agreement(column) or column in self._roles.unknown
        free = free or (len(words) > FEWEST_OF_SENTENCE and opinion and self._is_free(column))
        return asks and free and not self._is_no_answer(column)

    @cached_property
    def _in_grids(self) -> set[int]:
        """Return statements in brackets behind the same text: a grid of questions."""
        grids = _grids(self._table, self._scales)
        return {c for stem, grid in grids.items() if stem and len(grid) > 1 for c in grid}

    def _is_agreement(self, column: int) -> bool:
        """Return whether cells are words of agreement, whatever the heading says."""
        said = {self._vocabulary.agreement.get(plain(t)) for t in texts(self._table, column)}
        return len(said - {None}) > 1

    def _is_no_answer(self, column: int) -> bool:
        """Return whether a column is a flag, a level, known of a person, or asks how often."""
        phrase = self._vocabulary.asks_of_habits(self._words(column))
        flag = self._scales[column].high < _FEWEST_STEPS
        balanced = self._is_balanced(column) and not self._is_agreement(column)
        return flag or phrase or balanced or self._is_of_person(column)

    def _is_of_person(self, column: int) -> bool:
        """Return whether a column says the same in all of a person's rows."""
        table, people = self._table, self._roles.facts.get("participant", [])
        several = bool(people) and len(texts(table, people[0])) * 2 <= len(table.rows)
        return several and not varies_within(table, column, people[0])

    def _is_free(self, column: int) -> bool:
        """Return whether a sentence has a role by one of its words alone."""
        return column not in self._roles.metadata and column not in {
            columns[0] for columns in self._roles.facts.values() if columns
        }

    def _is_balanced(self, column: int) -> bool:
        """Return whether each number is there equally often, as levels of a factor are."""
        counts = Counter(filter(None, self._table.column(column)))
        few = len(counts) <= FEWEST_ANSWERS and min(counts.values()) > FEWEST_ANSWERS
        return few and len({*counts.values()}) == 1

    def _is_made_of(self, column: int, columns: Sequence[int]) -> bool:
        """Return whether a mean or a total stands beside the questions that it is made of."""
        if column in self._roles.outcomes:
            return False
        if column in self.computed:
            return True
        others = [c for c in sorted(columns) if c != column]
        left = self._left.get(column)
        scale = left.scale if left is not None else self._scales[column]
        whole = [c for c in others if c in self._scales and self._scales[c].step == 1]
        items = [c for c in whole if self._scales[c].usual[:2] == scale.usual[:2]]
        if scale.step < 1 and left is None and len(items) >= _FEWEST_OF_BLOCK:
            return True
        fillers = self._vocabulary.scale_fillers | self._vocabulary.totals
        given = tokens(self._table.headings[column])
        words = {*given} if len(given) < FEWEST_OF_SENTENCE else set()
        own = {word for word in words - fillers - self._apart if not word.isdecimal()}
        asked = [c for c in others if left is None or c not in self._left]
        said = ({*tokens(self._table.headings[c])} for c in asked)
        return bool(words & fillers) and any(own & each and not each & fillers for each in said)

    @cached_property
    def computed(self) -> set[int]:
        """Return the columns that are sums, weighted or not, or the reverse, of those before."""
        return computed_columns(self._table, {*self._scales, *self._left})

    @cached_property
    def _series(self) -> set[int]:
        """Return columns of numbered codes with answers of few steps: ``Q1`` … ``Q7``."""
        groups: dict[tuple[str, ...], list[tuple[int, int]]] = defaultdict(list)
        vocabulary = self._vocabulary
        for column in self._roles.unknown if self._has_headings else ():
            words = self._without_condition(tokens(self._table.headings[column]))
            if words and words[-1].isdecimal():
                groups[tuple(words[:-1])].append((int(words[-1]), column))
        found: set[int] = set()
        for code, group in groups.items():
            columns = [column for _, column in group if column in self._scales]
            steps = [self._scales[c].high - self._scales[c].low for c in columns]
            no_codes = vocabulary.asking_others | vocabulary.measures | vocabulary.units
            no_codes |= {*vocabulary.numbered, *vocabulary.timepoints, *vocabulary.scale_fillers}
            alike = len(columns) * 5 >= len(group) * 4 and max(steps, default=99) <= 10
            if not alike or len(columns) < FEWEST_OF_SERIES or not {*code} - self._apart:
                continue
            if {*code} & no_codes or self._are_ranks(columns):
                continue
            found.update(columns)
        return found

    def _without_condition(self, words: Sequence[str]) -> list[str]:
        """Return the words of a heading but for those of a numbered condition: ``cond 2``."""
        for place, (word, following) in enumerate(pairwise(words)):
            if self._vocabulary.numbered.get(word) == "condition" and following.isdecimal():
                return [*words[:place], *words[place + 2 :]]
        return [*words]

    def _are_ranks(self, columns: Sequence[int]) -> bool:
        """Return whether no two columns of a row are equal, as places in an order are."""
        rows = [[row[c] for c in columns if row[c]] for row in self._table.rows]
        return all(len({*row}) == len(row) for row in rows)

    def _ends(self, column: int) -> AnswerRange | None:
        """Return the scale between the ends in a heading, if all answers are on it."""
        text = f" {self._table.headings[column]} {self._table.labels[column]}"
        found = [match for pattern in _ENDS for match in pattern.finditer(text)]
        for match in found:
            low, high = int(match[1]), int(match[2])
            if _holds(low, high, self._scales[column]):
                return AnswerRange(low, high, self._scales[column].step)
        return None

    def _question(self, column: int) -> OwnQuestion:
        """Return what a column asks, without the words that tell administrations apart."""
        parts = self._parts(column)
        if parts is None:
            return self._short_question(column)
        text, heading, around = parts
        words = tokens(_NUMBER_OF_ITEM.sub("", heading) + around[len(heading) :])
        context = tuple(w for n, w in enumerate(words) if self._tells(words, n))
        code = next((w for n, w in enumerate(words) if not self._tells(words, n)), "")
        return self._made(column, text.strip(" -–:?.[]"), context, code if heading else "")

    def _parts(self, column: int) -> tuple[str, str, str] | None:
        """Return what a column asks, its heading, and the words around; None if that is all."""
        heading, label = self._table.headings[column], self._table.labels[column]
        bracket = _BRACKET.search(label) or _BRACKET.search(heading)
        if bracket:
            heading = heading.replace(bracket[0], "")
            return bracket[1], heading, f"{heading} {self._labels[column].stem}"
        if len(tokens(label)) > 1:
            stem = self._labels[column] if _is_whole(self._labels[column]) else Stem("", label)
            title, _, text = stem.rest.rpartition(TITLE + BESIDE)
            return text, heading, f"{heading} {stem.stem} {title}"
        if _is_whole(self._headings[column]):
            return self._headings[column].rest, "", self._headings[column].stem
        return None

    def _short_question(self, column: int) -> OwnQuestion:
        """Return a question whose heading is all there is: words at its ends may be facts."""
        given = self._glued.get(column) or words_of(self._table.headings[column])
        words = [word.casefold() for word in given]
        start, end = 0, len(words)
        while start < end - 1 and self._tells_outside(words, start):
            start += 1
        while end > start + 1 and self._tells_outside(words, end - 1):
            end -= 1
        inside = [n for n in range(start, end) if len(self._moments[_blank(words, n)]) > 1]
        context = (*words[:start], *(words[n] for n in inside), *words[end:])
        text = " ".join(given[n] for n in range(start, end) if n not in inside)
        if not context and len(given) >= FEWEST_OF_SENTENCE:
            text = self._table.headings[column]
        short = sum(not word.isdecimal() for word in words) < FEWEST_OF_SENTENCE + len(context)
        said = {*words} & self._vocabulary.asking_sentences  # I felt content
        code = words[start] if end - start > 1 and short and not said else ""
        return self._made(column, text, context, code)

    @cached_property
    def _moments(self) -> dict[tuple[str, ...], set[str]]:
        """Return headings with a moment left out → the moments there: ``mood_pre_valence``."""
        found: dict[tuple[str, ...], set[str]] = defaultdict(set)
        for column in (*self._scales, *self._left):
            words = [word.casefold() for word in words_of(self._table.headings[column])]
            for place, word in enumerate(words):
                if word in self._vocabulary.timepoints:
                    found[_blank(words, place)].add(self._vocabulary.timepoints[word])
        return found

    def _made(self, column: int, text: str, context: Context, code: str) -> OwnQuestion:
        left = self._left.get(column)
        seen = self._scales[column] if left is None else left.scale
        alone = left is not None and (left.measured or not is_numeric(self._table, column))
        said = seen if alone else self._ends(column)
        text = _NUMBERING.sub("", text)
        how: How = "name" if left is None else "measure" if left.measured else "left"
        words = kind_of_words(self._table, column, self._vocabulary)
        return OwnQuestion(
            column, text, tuple(dict.fromkeys(context)), code, seen, said, how, words
        )

    def _tells(self, words: Sequence[str], place: int) -> bool:
        """Return whether a word tells administrations apart: a moment, or a word of others."""
        word = words[place]
        if word in self._apart:
            return True
        after = words[place + 1] if place + 1 < len(words) else ""
        if word in self._vocabulary.timepoints:  # a start time is no moment
            return not self._is_code(word) and word + after not in self._vocabulary.roles
        before = words[place - 1] if place else ""
        return self._numbers(word, after) or self._numbers(before, word)

    def _numbers(self, word: str, number: str) -> bool:
        """Return whether a word and its number are a fact; a letter and 01 are a question's."""
        padded = len(word) == 1 and re.fullmatch(r"0\d+", number)
        return word in self._vocabulary.numbered and number.isdecimal() and not padded

    def _tells_outside(self, words: Sequence[str], place: int) -> bool:
        """Return whether a word at the end of a heading is none of its question.

        A moment in a sentence is one if the sentence is asked of another moment, too.
        """
        moment = words[place] in self._vocabulary.timepoints and words[place] not in self._apart
        again = len(self._moments[_blank(words, place)]) > 1
        return self._tells(words, place) and (
            again or not moment or len(words) <= FEWEST_OF_SENTENCE
        )

    def _crossed(self, questions: list[OwnQuestion]) -> list[OwnQuestion]:
        """Take words for conditions out of questions, unless a column says the condition."""
        there = [c for c in self._roles.facts.get("condition", ()) if texts(self._table, c)]
        said = there and not numbered_conditions(self._table, self._vocabulary)
        said = said or any(self._vocabulary.told(h) == "condition" for h in self._table.headings)
        told = [] if said else [q for q in questions if q.column in self._roles.outcomes]
        # the lab says what others ask
        free = [self._of_ranked(each) for each in questions if each not in told]
        found = questions if said else [*crossed(free, self._vocabulary), *told]
        groups: dict[Context, list[int]] = defaultdict(list)
        for each in found:
            groups[each.context].append(each.column)
        if not self._are_met_together(groups.values()):
            return questions
        known = {each.context for each in questions}
        self.conditions += [context for context in groups if context not in known]
        return found

    def _of_ranked(self, question: OwnQuestion) -> OwnQuestion:
        """Return what things were ranked by; the thing in brackets is a condition."""
        parts = self._parts(question.column)
        if question.column not in self._ranked or parts is None:
            return question
        context, scale = tuple(tokens(parts[0])), self._scales[question.column]
        return replace(question, text=parts[1].strip(), context=context, code="", said=scale)


def _glued(headings: Sequence[str], contexts: Sequence[Context]) -> dict[int, list[str]]:
    """Return column → its administration, and the words of a heading to whose code it is glued.

    ``COMFA, COMFB``, or ``COMFA. How comfortable?``: each of the others has such a heading.
    """
    found = {}
    there, words = {h.casefold() for h in headings}, {w for each in contexts for w in each}
    glued = re.compile(rf"([^\W\d]+?)({'|'.join(map(re.escape, words))})(\W.*|)", re.I | re.S)
    for column, heading in enumerate(headings if len(words) > 1 else ()):
        if match := glued.fullmatch(heading):
            stem, end, rest = match.groups()
            met = {w for w in words if f"{stem}{w}{rest}".casefold() in there}
            if end not in tokens(heading) and all(met & {*each} for each in contexts):
                found[column] = [end.casefold(), *(words_of(rest) or words_of(stem))]
    return found


def _grids(table: SourceTable, columns: Iterable[int]) -> dict[str, list[int]]:
    """Return text → the columns with a statement in brackets behind it."""
    found: dict[str, list[int]] = defaultdict(list)
    for column in columns:
        if match := _BRACKET.search(table.headings[column]):
            found[table.headings[column][: match.start()].strip()].append(column)
    return found


def ranks_in_words(
    table: SourceTable, columns: Iterable[int], vocabulary: LabVocabulary
) -> dict[int, tuple[str, ...]]:
    """Return columns of a grid of as many words, no two alike in a row → these, in their order.

    A word without a degree (``the nicest``) stands behind the others.
    """
    found: dict[int, tuple[str, ...]] = {}
    for grid in _grids(table, columns).values():
        words = [*dict.fromkeys(text for c in grid for text in texts(table, c))]
        rows = [{row[c] for c in grid} for row in table.rows if all(row[c] for c in grid)]
        each = len(rows) >= FEWEST_ANSWERS and all(len(row) == len(grid) for row in rows)
        if each and len(words) == len(grid) > 2 and not any(number(w, ".") for w in words):
            degrees = [9 if (d := vocabulary.degree(text)) is None else d for text in words]
            order = [text for _, text in sorted(zip(degrees, words, strict=True))]
            found |= dict.fromkeys(grid, tuple(order))
    return found


def _blank(words: Sequence[str], place: int) -> tuple[str, ...]:
    return (*words[:place], "", *words[place + 1 :])


def _is_whole(stem: Stem) -> bool:
    """Return whether what headings share is a question before statements, or a name."""
    return len(tokens(stem.rest)) > 1 and not stem.stem.rstrip()[-1:].isalnum() and bool(stem.stem)


def draft_own(
    table: SourceTable, found: Found, facts: Mapping[str, str], known: Known, _: Roles
) -> Drafted:
    """Draft the lab's own questions of one administration."""
    draft = TomlDraft({"instrument": found.instrument.name, **facts})
    cells = [texts(table, c) for c in found.columns]
    flags: dict[str, float | None] = {}
    for column in found.columns:
        flags |= yes_or_no(texts(table, column), known.vocabulary)
    ranks = ranks_in_words(table, range(len(table.headings)), known.vocabulary)
    orders = [*dict.fromkeys(ranks[c] for c in found.columns if c in ranks)]
    flags |= {text: float(n) for order in orders for n, text in enumerate(order, 1)}
    put_coding(draft, found.instrument, cells, table.decimal, known.vocabulary, flags)
    headings = {item: table.headings[named.column] for item, named in found.items.items()}
    draft.tables["items"] = TomlDraft(dict(headings))
    ruled = {item: headings[item] for item, each in found.items.items() if each.how == "name"}
    asked = [ask_about(found.instrument, [*ruled.values()], ruled)] if ruled else []
    missing = draft.values.get("missing")
    said = missing if isinstance(missing, list) else []
    remarks = [t for t in said if (v := number(t, ".")) is None or abs(v) < _FEWEST_FAR]
    remarks = [text for text in remarks if not is_missing(text, known.vocabulary)]
    if orders:
        shown = "; ".join(" < ".join(map(repr, order)) for order in orders)
        asked.append(OpenDoubt("In what order do these ranks stand?", shown, DIRECTION))
    return draft, [*asked, *ask_of_left(found, headings, remarks)]


def _holds(low: int, high: int, seen: AnswerRange) -> bool:
    return -100 <= low <= 1 < high <= 100 and low <= seen.low and seen.high <= high
