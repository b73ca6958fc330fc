"""Drafts where the condition comes from, and what tells repetitions of one apart."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from difflib import SequenceMatcher
from itertools import combinations
from math import prod

from vrcomfort.errors import InputError
from vrcomfort.importing.suggest.cells import (
    MOST_CONDITIONS,
    few_texts,
    is_numeric,
    texts,
    varies_within,
)
from vrcomfort.importing.suggest.draft import (
    CONDITIONS,
    ORDER,
    PEOPLE,
    SAME_CONDITION,
    TIMEPOINTS,
    listed,
)
from vrcomfort.importing.suggest.evidence import (
    BALANCED_WORDS,
    COUNTS_EXPOSURES,
    GROUPS_PEOPLE,
    WORDS_WITHIN_PEOPLE,
    Candidate,
    candidates,
)
from vrcomfort.importing.suggest.fact_draft import FactDraft
from vrcomfort.importing.suggest.shared_codes import are_met_again
from vrcomfort.importing.suggest.vocabulary import tokens
from vrcomfort.questionnaire import plain
from vrcomfort.settings import toml_value

MOST_NAMED, _MOST_SPELLINGS = 5, 60
_MOST_LEVELS, _FULL_OF = 6, 4
"""Levels of a factor between participants; people of whom one may lack a combination."""
_MOST_CELLS = 60
"""Combinations of levels at most: more are stimuli."""
FEW_IN = 10
"""Of so many people, one with several rows may be two who share a code."""
_WORDS = (BALANCED_WORDS, WORDS_WITHIN_PEOPLE)
_FIRST = frozenset(["first", "initial", "erste"])
LONG_WORD, NEAR, RARER = 6, 0.85, 2
"""Letters in which a misspelling shows, how alike the two words are, and how much rarer one is."""


class Conditions(FactDraft):
    """Finds the condition, or asks."""

    def draft(self) -> None:
        """Draft where the condition comes from, and number repetitions."""
        self._condition()
        self._passed_over(self._not_used())
        self._alike()
        self._before_conditions()
        self._repetitions()

    def _condition(self) -> None:
        columns = self._roles.facts.get("condition", [])
        if "timepoint" in self._answers.said:  # events of other names are conditions
            events = [c for c in self._roles.facts["timepoint"] if few_texts(self._table, c)]
            when = self._vocabulary.timepoint
            columns += [c for c in events if not any(map(when, texts(self._table, c)))]
        if told := [c for c in columns if self._vocabulary.told(self.heading(c)) == "condition"]:
            self._require_silent_headings(told)
            self._told(told)
            return
        columns = [c for c in columns if texts(self._table, c) and not self._is_setting(c)]
        if "condition" in self._answers.said or "condition" in self._context.columns:
            self._passed_over([c for c in columns if c not in self._context.used])
            return
        if "condition" in self._named and not columns:
            return
        if len(columns) == 1 and (factors := self._with_another(columns[0])):
            self._cross(factors)
        elif len(columns) == 1:
            self.use("condition", columns[0])
            if len(texts(self._table, columns[0])) == 1:
                self.found.draft.note("one condition alone", "condition")
        elif columns:
            self._several_conditions(columns)
        else:
            self._guess_condition()

    def _require_silent_headings(self, columns: list[int]) -> None:
        """Raise `InputError` where headings of answers say conditions beside the lab's columns."""
        if "condition" in self._answers.said:
            names = ", ".join(repr(self.heading(column)) for column in columns)
            message = f"words.toml calls {names} the condition, but headings of answers say one"
            cure = "write it below [covariates.group], or take it out of condition.labels"
            raise InputError(f"{message}; {cure}", file=self._table.file)

    def _told(self, columns: list[int]) -> None:
        """Take the columns that the lab says are the condition, all of them together."""
        if len(columns) > 1:
            self._join_condition(columns)
            self.found.levels = self._levels(columns)
        else:
            self.use("condition", columns[0])

    def _is_setting(self, column: int) -> bool:
        """Return whether a column has many numbers, one a person: a field of view at random."""
        table, who = self._table, self._context.participant
        once = who is None or not varies_within(table, column, who)
        return len(texts(table, column)) > MOST_CONDITIONS and is_numeric(table, column) and once

    def _not_used(self) -> list[int]:
        """Return columns before the answers whose words differ in people, about equally often."""
        front = [c for c in self._roles.unknown if c < min(self._answers.taken, default=0)]
        found = candidates("condition", front, self._context)
        words = [each.column for each in found if each.evidence in _WORDS]
        counts = {c: Counter(filter(None, self._table.column(c))).values() for c in words}
        return [column for column, each in counts.items() if max(each) <= 2 * min(each)]

    def _passed_over(self, columns: Sequence[int]) -> None:
        """Ask about columns that may be the condition, where something else says it."""
        for column in columns:
            words = texts(self._table, column)
            if 1 < len(words) <= MOST_CONDITIONS:
                shown = ", ".join(map(repr, words[:MOST_NAMED]))
                question = f"{self.heading(column)!r} has {shown}: is it not the condition?"
                assumed = "it is not: headings, names of files or another column say it"
                if column in self._roles.facts["condition"] and self._groups(column):
                    assumed = "it is a group of participants: the condition is said elsewhere"
                self.doubt(question, assumed, CONDITIONS)

    def _groups(self, column: int) -> bool:
        """Take a column that says one thing of each person for a group; return whether it does."""
        table, who = self._table, self._context.participant
        if who is None or "group" in self._context.covariates or varies_within(table, column, who):
            return False
        self._context.covariates["group"] = column
        self._context.used.add(column)
        return True

    def _several_conditions(self, columns: list[int]) -> None:
        names = ", ".join(repr(self.heading(c)) for c in columns)
        who = self._context.participant
        columns = [c for c in columns if len(texts(self._table, c)) > 1] or columns
        columns = [c for c in columns if not self._is_count(c)] or columns
        columns = [c for c in columns if not self._lacks_rows(c)] or columns
        columns = [c for c in columns if not self._is_said_by(c, columns)]
        within = [c for c in columns if varies_within(self._table, c, who)]
        between = [c for c in columns if 1 < len(texts(self._table, c)) <= _MOST_LEVELS]
        chosen = self._all_of_design(within) if within else between
        if not (within or self._levels(between)):
            chosen = columns[:1]
        if len(chosen) > 1:
            self._cross(chosen)
            return
        self.use("condition", chosen[0])
        chosen_one = repr(self.heading(chosen[0]))
        groups = next((c for c in columns if c not in chosen and self._groups(c)), None)
        if groups is not None:
            chosen_one += f"; {self.heading(groups)!r} is a group of participants"
        self.doubt(f"Which of {names} is the condition?", chosen_one, CONDITIONS)

    def _is_said_by(self, column: int, columns: Sequence[int]) -> bool:
        """Return whether each text of another column goes with one of this, as a part of it."""
        pairs = ((c, len({(row[c], row[column]) for row in self._table.rows})) for c in columns)
        counts = [(c, len({*self._table.column(c)}), pair) for c, pair in pairs if c != column]
        own = len({*self._table.column(column)})
        return any(n == pair and (n > own or c < column) for c, n, pair in counts)

    def _cross(self, columns: Sequence[int]) -> None:
        """Make conditions of columns together, which are their factors if crossed; and ask."""
        self._join_condition(columns)
        self.found.levels = self._levels(columns)
        names = ", ".join(repr(self.heading(column)) for column in columns)
        for column in columns:
            self._roles.forget(column)
        what = "they are, and these are crossed factors" if self.found.levels else "they are"
        question = f"Are conditions made of {names} together?"
        self.doubt(question, f"{what}, joined by _", CONDITIONS)

    def _levels(self, columns: Sequence[int]) -> dict[str, dict[str, str]]:
        """Return condition → heading → level; nothing where columns are not crossed."""
        whole = [cell for cell in self._cells(columns) if all(cell)]
        sizes = [len({*level}) for level in zip(*whole, strict=True)]
        if len(sizes) < 2 or min(sizes) < 2 or len(whole) != prod(sizes):
            return {}
        names = [self.heading(column) for column in columns]
        return {"_".join(cell): dict(zip(names, cell, strict=True)) for cell in whole}

    def _join_condition(self, columns: Sequence[int]) -> None:
        self._context.used |= set(columns)
        self._context.columns["condition"] = tuple(columns)
        names = [self.heading(c) for c in columns]
        joined = ["_".join(row[c] for c in columns) for row in self._table.rows]
        values = {text: text for text in dict.fromkeys(joined) if all(text.split("_"))}
        self.found.draft.put("condition", {"columns": names, "values": values})

    def _guess_condition(self) -> None:
        """Take the column with the heaviest evidence for the condition, and ask."""
        context = self._context
        decided = context.sources
        columns = (*self._roles.unknown, *self._roles.facts["scene"], *decided)
        found = candidates("condition", columns, context)
        found = [each for each in found if not self._parts_questions(each.column)]
        if "scene" in context.columns:  # what was shown to each person is numbered, besides
            found = [each for each in found if each.evidence is not COUNTS_EXPOSURES]
        if not found:
            self.found.draft.put("condition", {"constant": "all"})
            question = "No column says the condition: was there but one?"
            self.doubt(question, "one, called `all`", CONDITIONS)
        elif found[0].evidence is COUNTS_EXPOSURES and found[-1].evidence is GROUPS_PEOPLE:
            self._crossover(found[-1].column, found[0].column)
        elif (column := found[0].column) in decided:  # it keeps the role that it has
            self._context.columns["condition"] = (column,)
            said = {"column": self.heading(column), **self.names_of_codes(column)}
            self.found.draft.put("condition", said)
            self.doubt_of(found[0])
        elif factors := self._with_another(column):
            self._cross(factors)
        else:
            self.use("condition", column)
            if column in self._roles.unknown:
                self._roles.unknown.remove(column)
            self._ask_of(found[0])

    def _ask_of(self, found: Candidate) -> None:
        """Ask whether a column is the condition, and whose codes begin anew in each."""
        who = self._context.participant
        if who is None or not are_met_again(self._table, who, found.column):
            return self.doubt_of(found)
        name, code = self.heading(found.column), texts(self._table, who)[0]
        one, other = texts(self._table, found.column)[:2]
        question = found.evidence.question.format(heading=name)
        question += f" And is {code!r} of {one!r} the {code!r} of {other!r}?"
        columns = f"columns = [{toml_value(name)}, the column of the codes]"
        stake = CONDITIONS._replace(
            instead=f"in the tables: participant = {{ {columns} }}; {CONDITIONS.instead}"
        )
        return self.doubt(question, "it is, and each code is one person", stake)

    def _parts_questions(self, column: int) -> bool:
        """Return whether each question has one text of a column, as the name of its part."""
        for item in self._answers.row_keys[:1]:
            pairs = {(row[item], row[column]) for row in self._table.rows}
            return len(pairs) == len(texts(self._table, item))
        return False

    def _with_another(self, column: int) -> list[int]:
        """Return a column and others with which it is crossed; nothing where there is none."""
        factors, who = [column], self._context.participant
        for other in self._levels_beside(factors):
            if who is not None and self._are_crossed([*factors, other], who):
                factors.append(other)
        factors = self._all_of_design(factors)
        return [column, *sorted(factors[1:])] if len(factors) > 1 else []

    def _levels_beside(self, factors: Sequence[int]) -> list[int]:
        """Return the open columns that may be factors beside others; nothing in long files."""
        if self._answers.row_keys or self._context.time is not None:
            return []
        closed = {*factors} | self._context.used | self._roles.outcomes
        open_ = sorted({*self._roles.unknown, *self._roles.facts["condition"]} - closed)
        return [c for c in open_ if few_texts(self._table, c) and not self._is_count(c)]

    def _all_of_design(self, factors: list[int]) -> list[int]:
        """Return factors, and others, if nearly everybody had the same cells of them once."""
        who = self._context.participant
        if who is None or len(self._table.rows) > _MOST_CELLS * len(texts(self._table, who)):
            return factors
        found, cells = [*factors], self._design(factors, who)
        for other in self._levels_beside(factors):
            if len(finer := self._design([*found, other], who)) > len(cells):
                found, cells = [*found, other], finer
        for other in found[:0:-1]:  # what the others say, too
            fewer = [c for c in found if c != other]
            found = fewer if len(self._design(fewer, who)) == len(cells) else found
        return found if {*cells.values()} == {1} else factors

    def _design(self, columns: Sequence[int], who: int) -> Counter[tuple[str, ...]]:
        """Return how often a person had each combination, where nearly everybody had the same."""
        each = [*self._met(columns, who).values()]
        usual = max(each, key=each.count, default=Counter[tuple[str, ...]]())
        return usual if each.count(usual) * _FULL_OF >= len(each) * (_FULL_OF - 1) else Counter()

    def _met(self, columns: Sequence[int], who: int) -> dict[str, Counter[tuple[str, ...]]]:
        """Return how often each person had each combination of texts of columns."""
        met: dict[str, Counter[tuple[str, ...]]] = defaultdict(Counter)
        for row in self._table.rows:
            met[row[who]][tuple(row[c] for c in columns)] += 1
        return met

    def _are_crossed(self, factors: Sequence[int], who: int) -> bool:
        """Return whether nearly everybody had each combination of levels equally often."""
        cells = [cell for cell in self._cells(factors) if all(cell)]
        if not self._levels(factors):
            return False
        met = self._met(factors, who).values()
        often = [{count[cell] for cell in cells} for count in met]
        whole = (len(each) == 1 and each != {0} for each in often)
        return sum(whole) * _FULL_OF >= len(met) * (_FULL_OF - 1)

    def _is_count(self, column: int) -> bool:
        """Return whether a column counts from 1, as numbers of trials do."""
        words = [self._table.meaning(column, word) for word in texts(self._table, column)]
        return {str(n) for n in range(1, 1 + len(words))} == {*words}

    def _cells(self, columns: Sequence[int]) -> list[tuple[str, ...]]:
        """Return the different combinations of texts of columns."""
        return [*dict.fromkeys(tuple(row[c] for c in columns) for row in self._table.rows)]

    def _crossover(self, group: int, number: int) -> None:
        """Take group and number of the exposure together for the condition."""
        self._join_condition([group, number])
        self._context.covariates.setdefault("sequence", group)
        if not self._letters(group, number):
            a, b = self.heading(group), self.heading(number)
            question = f"Which condition did each {a} have in each {b} (a crossover)?"
            assumed = "each combination is a condition of its own; under values, give those that"
            self.doubt(question, f"{assumed} are one condition one name", CONDITIONS)

    def _letters(self, sequence: int, number: int) -> bool:
        """Take letters of sequences such as AB for the conditions, in their order."""
        orders, numbers = texts(self._table, sequence), sorted(texts(self._table, number))
        alike = {tuple(sorted(order)) for order in orders}
        if len(alike) != 1 or len(numbers) < 2 or {*map(len, orders)} != {len(numbers)}:
            return False
        values = {f"{o}_{n}": letter for o in orders for n, letter in zip(numbers, o, strict=True)}
        names = [self.heading(sequence), self.heading(number)]
        self.found.draft.put("condition", {"columns": names, "values": values})
        a, b = names
        question = f"Does {a!r} name the conditions in the order of {b!r}?"
        shown = ", ".join(f"{key} is {value}" for key, value in values.items())
        self.doubt(question, shown, CONDITIONS)
        return True

    def _before_conditions(self) -> None:
        """Take answers without a condition, which come first for each person, for baselines."""
        column = self._context.columns.get("condition", ())
        said = self.found.draft.values
        who = self._context.participant
        if said.get("timepoint") != {"constant": "post"} or len(column) != 1 or who is None:
            return
        if not self._context.symptoms or self._context.time is not None:
            return
        cells: dict[str, list[str]] = {}
        for row in self._table.rows:
            if not (cells.get(row[who]) and cells[row[who]][-1] == row[column[0]]):
                cells.setdefault(row[who], []).append(row[column[0]])
        first = [row[:1] == [""] and any(row[1:]) and "" not in row[1:] for row in cells.values()]
        come_first = bool(first) and sum(first) * 10 >= len(first) * 9
        if not come_first and not self._is_flagged(column[0]):
            return
        words = texts(self._table, column[0])
        values = {"": "baseline", **dict.fromkeys(words, "post")}
        self.found.draft.put("timepoint", {"column": self.heading(column[0]), "values": values})
        question = f"Are the first answers of each person, without {self.heading(column[0])!r}, "
        self.doubt(f"{question}from before exposure?", "they are baselines", TIMEPOINTS)

    def _is_flagged(self, condition: int) -> bool:
        """Return whether a column tells rows without a condition from others, and says first."""
        for column, heading in enumerate(self._table.headings):
            said = {(not row[condition], row[column]) for row in self._table.rows}
            first = _FIRST & {*tokens(heading)} or self._vocabulary.timepoint(heading) == "baseline"
            if first and sorted(blank for blank, _ in said) == [False, True]:
                return len({text for _, text in said}) == len(said)
        return False

    def _repetitions(self) -> None:
        """Draft a count of exposures where a participant has a condition at a timepoint twice."""
        if self._context.participant is None or self._context.time is not None:
            return  # ratings of one exposure are many rows of one condition
        keys = [self._context.participant, *self._answers.row_keys]
        keys += [c for columns in self._context.columns.values() for c in columns]
        again, repeated = self._again(keys)
        people = {*self._table.column(self._context.participant)}  # without rows left out
        if again and (repeated or len(again) * 4 > len(people)):
            self._count_exposures(again)
        elif again:
            told = next(iter(again.values()))[0]
            question = f"Were rows of {', '.join([*again][:MOST_NAMED])} saved twice ({told})?"
            self.doubt(question, "they were; equal answers are counted once", ORDER)

    def _again(self, keys: Sequence[int]) -> tuple[dict[str, list[str]], bool]:
        """Return the people with several rows of one key, and whether their answers differ."""
        who = self._context.participant or 0
        people = {*self._table.column(who)} - {""}
        seen: dict[tuple[str, ...], tuple[int, tuple[str, ...]]] = {}
        again: dict[str, list[str]] = {}
        repeated = False
        answers = sorted(self._answers.taken)
        for table in self._answers.tables:
            for number, row in zip(table.numbers, table.rows, strict=True):
                if not any(row[column] for column in self._answers.taken):
                    continue
                key = (table.file.name, table.sheet, *(row[c] for c in dict.fromkeys(keys)))
                if key in seen and row[who] in people:
                    first, cells = seen[key]
                    same = [cells[c] for c in answers] == [row[c] for c in answers]
                    again.setdefault(row[who], [])
                    how = "is the same as" if cells == row else "has the answers of"
                    again[row[who]] += [f"row {number} {how} row {first}"] if same else []
                    repeated = repeated or not same
                seen.setdefault(key, (number, row))
        return again, repeated

    def _count_exposures(self, again: Mapping[str, Sequence[str]]) -> None:
        """Draft a count of exposures, and ask; `again`: participants with several → equal rows."""
        for column in self._context.columns.get("trial", ()):  # which does not tell them apart
            self._context.used.discard(column)
            self._roles.metadata.append(column)
        self.found.draft.put("trial", {"count": True}, "exposures in the order of the rows")
        people = listed([*again], MOST_NAMED)
        columns = " (and conditions in a row)" if "condition" in self._answers.said else ""
        question = f"One condition more than once: {people}. Do rows{columns} stand in the "
        assumed = "they do; exposures are numbered so"
        same = [each for found in again.values() for each in found if "is the same" in each]
        if same:
            assumed += f" (but {same[0]}: leave it out of the file if it was saved twice)"
        if len(again) * FEW_IN <= len(texts(self._table, self._context.participant or 0)):
            question = f"Has {people} several rows of one condition: is each code one person?"
            self.doubt(question, assumed.replace("they do", "it is"), PEOPLE)
            return
        self.doubt(f"{question}order of time?", assumed, ORDER)

    def _alike(self) -> None:
        """Ask whether words for conditions that are nearly the same are one."""
        column = self._context.columns.get("condition", ())
        cells = self._table.column(column[0]) if len(column) == 1 else ()
        counts = Counter(filter(None, cells))
        few = len(counts) <= MOST_CONDITIONS
        pairs = [
            sorted(pair, key=lambda word: -counts[word])
            for pair in (combinations(counts, 2) if len(counts) <= _MOST_SPELLINGS else ())
            if (few and _are_alike(counts, *pair)) or plain(pair[0]) == plain(pair[1])
        ]
        pairs.sort(key=lambda pair: counts[pair[0]])  # of three, the most usual one counts
        if pairs:
            shown = "; ".join(f"{usual!r} and {rare!r}" for usual, rare in pairs)
            one = {word: word for word in counts} | {rare: usual for usual, rare in pairs}
            said = "they are not; `values` of condition make them one: "
            if all(plain(usual) == plain(rare) for usual, rare in pairs):
                there = self.found.draft.values["condition"]
                if isinstance(there, dict) and "values" not in there:
                    self.found.draft.put("condition", {**there, "values": one})
                    said = "they are: "
            question = f"Is each of these one condition, typed differently: {shown}?"
            self.doubt(question, f"{said}values = {toml_value(one)}", SAME_CONDITION)


def _are_alike(counts: Mapping[str, int], a: str, b: str) -> bool:
    """Return whether two words are the same but for signs and case, or one is misspelt."""
    rare, usual = sorted((counts[a], counts[b]))
    return plain(a) == plain(b) or (RARER * rare <= usual and _near(a, b))


def _near(a: str, b: str) -> bool:
    """Return whether two words differ in a letter or two of many, and not in numbers or un-."""
    short, long = sorted((plain(a), plain(b)), key=len)
    if len(short) < LONG_WORD or long.endswith(short) or _digits(short) != _digits(long):
        return False
    return SequenceMatcher(None, short, long, autojunk=False).ratio() >= NEAR


def _digits(text: str) -> list[str]:
    return [letter for letter in text if letter.isdecimal()]
