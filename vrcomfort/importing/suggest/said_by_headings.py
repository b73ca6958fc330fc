"""Reads what the headings of a table's answers say: conditions, moments, participants."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from math import prod
from typing import Any

from vrcomfort.importing.files import JOIN
from vrcomfort.importing.row_facts import conditions_in
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.answer_columns import (
    BLOCKS,
    LONG,
    OWN,
    RATINGS,
    SCORES,
    AnswerColumns,
    Layout,
)
from vrcomfort.importing.suggest.block_conditions import (
    conditions_beside,
    fitting,
    number_in_words,
    numbered_conditions,
    order_column,
    without_levels,
)
from vrcomfort.importing.suggest.cells import texts
from vrcomfort.importing.suggest.draft import CONDITIONS, PEOPLE, SAME_CONDITION, WHOLE, OpenDoubt
from vrcomfort.importing.suggest.found_answers import Found, FoundAnswers, without_name
from vrcomfort.importing.suggest.heading_facts import heading_facts
from vrcomfort.importing.suggest.heading_roles import PERSON_CODE, roles_of
from vrcomfort.importing.suggest.kept_rows import KeptRows
from vrcomfort.importing.suggest.leaving import find_leaving
from vrcomfort.importing.suggest.own_instruments import TakenFor
from vrcomfort.importing.suggest.questionnaires import answers_of_block
from vrcomfort.importing.suggest.scores import FoundScores, rise_from_first
from vrcomfort.importing.suggest.vocabulary import Known, words_of

OF_WHAT_WAS_USED = frozenset(["ipq", "nasa_tlx", "sus"])
"""Instruments about a system, a task or a scene: none is asked before its use."""
_UPPER_ROWS = 2


def _baseline_as_condition(facts: Mapping[str, str]) -> dict[str, str]:
    return {("condition" if name == "timepoint" else name): text for name, text in facts.items()}


def _only_baselines(facts: Sequence[Mapping[str, str]]) -> bool:
    """Return whether headings say a baseline and conditions, and no other moment."""
    moments = {each["timepoint"] for each in facts if "timepoint" in each}
    alone = [each for each in facts if "timepoint" in each and "condition" not in each]
    return moments == {"baseline"} and len(alone) == 1 < len(facts)


class SaidByHeadings(KeptRows):
    """The answers of tables with the same headings, and what these say of them.

    Parameters
    ----------
    left
        Column that nothing else knows → what it is taken for.
    """

    def __init__(
        self,
        tables: Sequence[SourceTable],
        known: Known,
        left: Mapping[int, TakenFor] | None,
    ) -> None:
        super().__init__(tables, known.vocabulary)
        self._known = known
        self.labels: dict[str, str] = {}
        """Condition that headings say → how they write it."""
        self._answers = AnswerColumns(self.table, known, left)
        self._keep_answered(self._answers)
        if codes := self._answers.codes:
            question = f"Do {', '.join(codes)} in headings of the same questions say the condition?"
            self.doubts.append(OpenDoubt(question, "they do", CONDITIONS._replace(instead=WHOLE)))
        others = [c for c in range(len(self.table.headings)) if c not in self._answers.taken]
        self._leaving = find_leaving(self.table, others, known)
        times = self._leaving.columns if self._leaving else {}
        others = [column for column in others if column not in times]
        self._roles = roles_of(self.table, others, self._vocabulary)
        self._facts: dict[Layout[Any], list[dict[str, str]]] = {}
        """Layout → what the headings of its answers say."""
        self._beside: list[str | None] = []
        """For each block, the column of its condition, where conditions stand beside them."""

    @property
    def _answered(self) -> set[str]:
        """Return the names of the instruments of which the table has the answers."""
        return {each.instrument.name for each in (*self._answers[BLOCKS], *self._answers[LONG])}

    def _levels_in_headings(self, facts: Sequence[Mapping[str, str]]) -> dict[str, dict[str, str]]:
        """Return the levels of crossed factors that conditions in headings consist of; and ask.

        A factor is called after its levels.
        """
        names = dict.fromkeys(c for each in facts if (c := each.get("condition")))
        parts = {name: name.split("_") for name in names}
        if len({*map(len, parts.values())}) != 1:
            return {}
        levels = [[*dict.fromkeys(level)] for level in zip(*parts.values(), strict=True)]
        factors = {n: "/".join(each) for n, each in enumerate(levels) if len(each) > 1}
        if len(factors) < 2 or len(names) != prod(len(levels[n]) for n in factors):
            return {}
        shown = " and ".join(f"{factor}" for factor in factors.values())
        question = f"Are the conditions crossed, of the factors {shown}?"
        self.doubts.append(OpenDoubt(question, "they are", SAME_CONDITION))
        return {
            name: {factor: part[n] for n, factor in factors.items()} for name, part in parts.items()
        }

    def _facts_beside(self) -> list[dict[str, str]]:
        """Return the facts of blocks whose conditions stand in columns beside them."""
        blocks = self._answers[BLOCKS]
        closed = self._answers.taken | {*self._roles.metadata}  # answers in own words, dates …
        columns = conditions_beside(self.table, blocks, closed, self._vocabulary)
        if not columns:
            return []
        return self._take_beside(columns, "of the answers beside them")

    def _people_in_headings(self) -> list[dict[str, str]]:
        """Return the participants whom the columns of a long table are called after."""
        names = [self.table.headings[long.response_column] for long in self._answers[LONG]]
        codes = [PERSON_CODE.fullmatch(name) for name in names]
        if len({code[1] for code in codes if code}) != 1 or None in codes:
            return []
        question = f"Are {names[0]} … {names[-1]} participants?"
        self.doubts.append(OpenDoubt(question, "they are: each has a column", PEOPLE))
        return [{"participant": name} for name in names]

    def _facts_by_number(self, leading: Layout[Any] | None) -> list[dict[str, str]]:
        """Return the facts of answers whose numbers are those of conditions: ``Condition_1``."""
        if leading not in {BLOCKS, RATINGS, OWN} or leading is None:
            return []
        numbers = [number_in_words(each.context) for each in self._answers[leading]]
        columns = fitting(numbers, numbered_conditions(self.table, self._vocabulary))
        return self._take_beside(columns, "of the answers with their number") if columns else []

    def _take_beside(self, columns: Sequence[int | None], of: str) -> list[dict[str, str]]:
        """Let columns say the conditions of the leading answers, and ask; return their facts."""
        names = [None if c is None else self.table.headings[c] for c in columns]
        self._beside = names
        for column in columns:
            if column is not None:
                self._roles.forget(column)
        shown = ", ".join(repr(name) for name in dict.fromkeys(names) if name is not None)
        first = "they do"
        if None in names:
            first = f"{first}; the first answers, which have none, are before exposure"
        self.doubts.append(OpenDoubt(f"Do {shown} say the condition {of}?", first, CONDITIONS))
        return [{"timepoint": "baseline" if name is None else "post"} for name in names]

    def _in_order(self, facts: list[dict[str, str]]) -> set[str]:
        """Take conditions from a column that lists them in order; return the facts it says."""
        if self._beside:
            return {"condition"}
        roles = self._roles
        columns = [*roles.covariates.values(), *roles.unknown, *roles.facts["condition"]]
        found = order_column(self.table, columns, facts)
        if found is None:
            return set()
        for each in facts:
            if each.get("condition", "").isdecimal():
                each[found.by] = each.pop("condition")
        roles.forget(found.column)
        self.doubts = [d for d in self.doubts if not d.question.startswith("What do the numbers")]
        name = self.table.headings[found.column]
        self.draft.put("condition", {"order": name, "by": found.by})
        one = texts(self.table, found.column)[0]
        question = f"Does {name!r} give the conditions in the order of the {found.by}s?"
        assumed = f"it does: {one} is {', then '.join(conditions_in(one))}"
        self.doubts.append(OpenDoubt(question, assumed, CONDITIONS))
        self.draft.put("participants", {"sequence": name})
        return {"condition"}

    def _numbers(self, found: Sequence[FoundAnswers]) -> str:
        """Return the fact that numbers in headings are: a column may say the condition already.

        That of a person, of whom all numbers are, leaves them the timepoints.
        """
        said = [c for c in self._roles.facts.get("condition", []) if len(texts(self.table, c)) > 1]
        people = self._roles.facts.get("participant", [])
        scores = [each for each in found if isinstance(each, FoundScores)]
        scores = scores or self._answers[SCORES]  # numbers of all series of a table are one thing
        rises = rise_from_first(self.table, scores) or self._answers_rise(found)
        if not said:
            return "timepoint" if rises else "condition"
        each_once = any(len(texts(self.table, c)) == len(self.table.rows) for c in people)
        return (
            "timepoint"
            if (each_once and scores) or (rises and (each_once or not people))
            else "trial"
        )

    def _answers_rise(self, found: Sequence[FoundAnswers]) -> bool:
        """Return whether answers to symptoms of the first of several blocks are half of later ones.

        So they are before exposure.
        """
        blocks = [each for each in found if isinstance(each, Found)]
        often = Counter(each.instrument for each in blocks)
        blocks = [each for each in blocks if often[each.instrument] > 1]
        if not blocks or {each.instrument.name for each in blocks} & OF_WHAT_WAS_USED:
            return False
        means = []
        for block in blocks:
            said = answers_of_block(self.table, block, self._known)
            answers = [value for value in said if value is not None]
            means.append(sum(answers) / max(len(answers), 1) - float(block.instrument.low))
        return len(means) > 1 and 2 * means[0] <= max(means[1:])

    def _spelt(self, facts: dict[str, str]) -> dict[str, str]:
        """Return conditions with the capital letters that the headings have."""
        said = facts.get("condition", "")
        words = {
            word.casefold(): word
            for text in (*self.table.labels, *self.table.headings)
            for word in words_of(text)
        }
        if said in self._vocabulary.conditions:
            self.labels[said] = self._vocabulary.conditions[said]
            return facts
        parts = [words.get(word, word) for word in said.split("_")]
        if not said:
            return facts
        self.labels["_".join(parts)] = " ".join(parts)
        return {**facts, "condition": "_".join(parts)}

    def _facts_of(self, layout: Layout[Any]) -> list[dict[str, str]]:
        """Return the facts in the headings of a layout's answers.

        Ratings beside questionnaires, and scores of others, say their own; long tables nothing.
        """
        if layout not in self._facts and layout is OWN:
            self._facts[OWN] = self._facts_like_the_leading()
        if layout not in self._facts:
            found = self._answers[layout]
            alone = layout is SCORES and not self._answered & {e.instrument.name for e in found}
            says = layout is RATINGS or alone
            self._facts[layout] = self._heading_facts_of(found) if says else [{} for _ in found]
        return self._facts[layout]

    def _facts_like_the_leading(self) -> list[dict[str, str]]:
        """Return the facts of the lab's own questions: those of answers with the same words."""
        found = self._answers[OWN]
        leading = self._answers.leading or OWN
        pairs = zip(self._answers[leading], self._facts.get(leading, ()), strict=False)
        same = {frozenset(each.context): facts for each, facts in pairs}
        fillers = self._vocabulary.condition_fillers
        for words, facts in same.items() if len(same) > 1 else ():
            if words <= fillers and facts.get("timepoint") == "baseline":
                same[words] = {}  # what says no moment was not asked before by that
        said = [same.get(frozenset(each.context)) for each in found]
        if None not in said:
            return [dict(facts or {}) for facts in said]
        others = self._heading_facts_of(found)
        return [
            other if own is None else dict(own) for own, other in zip(said, others, strict=True)
        ]

    def _upper_facts(self, found: Sequence[FoundAnswers]) -> list[dict[str, str]]:
        """Return the facts in two rows of headings above the items: moments, and conditions."""
        uppers = [
            {tuple(self.table.headings[c].split(JOIN)[:-1]) for c in each.columns} for each in found
        ]
        rows = [min(each) for each in uppers if len(each) == 1]
        if len(rows) < 2 or len(rows) < len(uppers) or {*map(len, rows)} != {_UPPER_ROWS}:
            return []
        timepoint = self._vocabulary.timepoint
        whens = [
            place for place in range(_UPPER_ROWS) if all(timepoint(row[place]) for row in rows)
        ]
        if len(whens) != 1:
            return []
        moments = {row[whens[0]]: timepoint(row[whens[0]]) or "" for row in rows}
        if len({*moments.values()}) < len(moments):
            return []
        names = ["_".join(words_of(row[1 - whens[0]])) for row in rows]
        if not all(names):
            return []
        self.labels |= {n: row[1 - whens[0]] for n, row in zip(names, rows, strict=True)}
        return [
            {"condition": name, "timepoint": moments[row[whens[0]]]}
            for name, row in zip(names, rows, strict=True)
        ]

    def _heading_facts_of(self, found: Sequence[FoundAnswers]) -> list[dict[str, str]]:
        """Return the facts in the words of headings, each instrument by itself."""
        if upper := self._upper_facts(found):
            return upper
        named = [
            (e.instrument.name, without_name(without_levels(self.table, e, self._vocabulary), e))
            for e in found
        ]
        if any(isinstance(each, FoundScores) and each.where for each in found):
            return [{} for _ in named]  # a heading of all of them
        facts: list[dict[str, str]] = [{} for _ in named]
        for name in dict.fromkeys(name for name, _ in named):
            places = [i for i, (other, _) in enumerate(named) if other == name]
            places.sort(key=lambda i: min(found[i].columns))
            own, doubts = heading_facts(
                [named[i][1] for i in places], self._vocabulary, numbers=self._numbers(found)
            )
            self.doubts += doubts
            if name in OF_WHAT_WAS_USED:
                own = [*map(_baseline_as_condition, own)] if _only_baselines(own) else own
            for place, said in zip(places, own, strict=True):
                facts[place] = self._spelt(said)
        return facts
