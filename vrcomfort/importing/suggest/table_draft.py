"""Drafts the mapping of one table, or of several that are made alike."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise
from math import prod
from typing import Any

from vrcomfort.importing.answers import number, time_in_words_s
from vrcomfort.importing.columns import conditions_in
from vrcomfort.importing.files import JOIN
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.answer_columns import (
    BLOCKS,
    COURSES,
    LAYOUTS,
    LONG,
    OWN,
    RATINGS,
    SCORES,
    AnswerColumns,
    Layout,
)
from vrcomfort.importing.suggest.block_conditions import (
    before_exposures,
    conditions_beside,
    fitting,
    number_in_words,
    numbered_conditions,
    order_column,
    without_levels,
)
from vrcomfort.importing.suggest.draft import (
    CONDITIONS,
    LAYOUT,
    LEFT,
    ORDER,
    PEOPLE,
    SAME_CONDITION,
    SAME_PERSON,
    SCORE_KIND,
    STAYED,
    TIMEPOINTS,
    OpenDoubt,
    TomlDraft,
    pattern_of,
    placed_in_short,
)
from vrcomfort.importing.suggest.evidence import Context, texts
from vrcomfort.importing.suggest.fact_draft import AnswersFound, DraftedFacts
from vrcomfort.importing.suggest.facts import draft_facts
from vrcomfort.importing.suggest.heading_facts import heading_facts, template_of
from vrcomfort.importing.suggest.heading_roles import PERSON_CODE, is_personal, roles_of
from vrcomfort.importing.suggest.items import Found, FoundAnswers
from vrcomfort.importing.suggest.kept_rows import KeptRows
from vrcomfort.importing.suggest.leaving import find_leaving
from vrcomfort.importing.suggest.left_over import ask_to_leave_out, left_over
from vrcomfort.importing.suggest.own_instruments import TakenFor
from vrcomfort.importing.suggest.own_questions import ask_about
from vrcomfort.importing.suggest.questionnaires import (
    answers_of_block,
    leftovers,
    sum_of,
)
from vrcomfort.importing.suggest.scores import (
    FoundScores,
    by_kind,
    rise_from_first,
)
from vrcomfort.importing.suggest.vocabulary import Known, covariate_name, tokens, words_of
from vrcomfort.questionnaire import Instrument

_OF_WHAT_WAS_USED = frozenset(["ipq", "nasa_tlx", "sus"])
"""Instruments about a system, a task or a scene: none is asked before its use."""


def _only_baselines(facts: Sequence[Mapping[str, str]]) -> bool:
    """Return whether headings say a baseline and conditions, and no other moment."""
    moments = {each["timepoint"] for each in facts if "timepoint" in each}
    alone = [each for each in facts if "timepoint" in each and "condition" not in each]
    return moments == {"baseline"} and len(alone) == 1 < len(facts)


def _stands_among(column: int, some: Collection[int], others: Collection[int]) -> bool:
    """Return whether a column stands between some, or behind some and all of the others."""
    before = max((c for c in (*some, *others) if c < column), default=None)
    behind = min((c for c in (*some, *others) if c > column), default=None)
    return before in some and (behind in some or (behind is None and bool(others)))


def _baseline_as_condition(facts: Mapping[str, str]) -> dict[str, str]:
    return {("condition" if name == "timepoint" else name): text for name, text in facts.items()}


_UPPER_ROWS = 2
_AGAIN = re.compile(r" ?\(\d\)$")
"""The mark of a person's second questionnaire."""


class TableDraft(KeptRows):
    """The mapping of tables with the same headings.

    Parameters
    ----------
    tables
        The tables; the first one's reading is written down.
    known
        Instruments that may be meant, and the words of other labs' files.
    left
        Column that nothing else knows → what it is taken for.
    of_person
        Columns that nothing else knows, and of which each person has one value.
    answered
        Whether there are answers, though none are known yet.
    """

    def __init__(
        self,
        tables: Sequence[SourceTable],
        known: Known,
        left: Mapping[int, TakenFor] | None = None,
        *,
        of_person: Collection[int] = (),
        answered: bool = False,
    ) -> None:
        super().__init__(tables, known.vocabulary)
        self._known = known
        self._answered_otherwise = answered
        self.left: dict[int, TakenFor] = {}
        """Column that nothing in this draft knows → what it may be taken for."""
        self.people: int | None = None
        """The column of the participants, if its heading says so."""
        self.labels: dict[str, str] = {}
        """Condition that headings say → how they write it."""
        self.levels: dict[str, dict[str, str]] = {}
        """Condition → factor → level, where conditions are made of crossed factors."""
        self.gives = False
        """Whether there is anything to import."""
        self._files()
        self._answers = AnswerColumns(self.table, known, left)
        self._keep_answered(self._answers)
        if codes := self._answers.codes:
            question = f"Do {', '.join(codes)} before the same numbers each say the condition?"
            self.doubts.append(OpenDoubt(question, "they do", *CONDITIONS))
        others = [c for c in range(len(self.table.headings)) if c not in self._answers.taken]
        self._leaving = find_leaving(self.table, others, known)
        times = self._leaving.columns if self._leaving else {}
        others = [column for column in others if column not in times]
        self._roles = roles_of(self.table, others, self._vocabulary)
        self._say_of_people(of_person)
        for column in self._trial_runs:
            if column not in self._roles.facts.get("participant", ()):
                self._roles.forget(column)
        self._keep_peoples(self._roles.facts.get("participant", []) if self._answers else [])
        self._whole = self.table
        """The table with rows of other questions, where each has a row."""
        self._keep_items(self._answers[LONG])
        self.unanswered = self._answers.named(self._whole, known) - self._answers.instruments
        """Instruments that the file names, and to which it has no answers."""
        self.answered = self._answers.instruments
        self._facts: dict[Layout[Any], list[dict[str, str]]] = {}
        """Layout → what the headings of its answers say."""
        self._beside: list[str | None] = []
        """For each block, the column of its condition, where conditions stand beside them."""
        self._made: dict[int, str] = {
            **dict.fromkeys(self._answers.repeated, "the same answers, by their order"),
            **dict.fromkeys(self._answers.products, "an answer times its weight"),
            **dict.fromkeys(self._answers.turned, "an answer the other way round"),
            **dict.fromkeys(self._answers.weights, "a weight, or the name of an item"),
        }
        """Column of a score whose answers are there → why it is ignored."""
        self._write()

    @property
    def own(self) -> list[Instrument]:
        """Return the instruments of the lab's own questions."""
        return self._answers.own

    def rename(self, instrument: str, name: str) -> None:
        """Call an instrument otherwise, as another table has one of that name."""
        for each in self.draft.lists.get("questionnaires", ()):
            if each.values["instrument"] == instrument:
                each.put("instrument", name)

    def lack(self, instrument: str, items: Sequence[str]) -> None:
        """Say which of an instrument's items were not asked here, but elsewhere."""
        for each in self.draft.lists.get("questionnaires", ()):
            there = each.tables["items"].values if "items" in each.tables else {}
            lacking = [item for item in items if item not in there]
            if each.values["instrument"] == instrument and there and lacking:
                each.put("not_asked", lacking)

    @property
    def ignored(self) -> set[str]:
        """Return the headings of the columns that are not imported."""
        said = self.draft.values.get("ignore")
        return {*said} if isinstance(said, list) else set()

    @property
    def files(self) -> list[str]:
        """Return the names of the files."""
        return list(dict.fromkeys(table.file.name for table in self.tables))

    def _files(self) -> None:
        names = self.files
        self.draft.put("files", [*map(pattern_of, names)])
        sheets = list(dict.fromkeys(table.sheet for table in self.tables if table.sheet))
        if sheets:
            self.draft.put("sheets", [*map(pattern_of, sheets)])
        read = self.table.reading
        values: dict[str, object] = {}
        alike_read = all(
            (t.reading.encoding, t.reading.separator) == (read.encoding, read.separator)
            for t in self.tables
        )
        if read.encoding is not None and alike_read and read.separator is not None:
            values["encoding"] = read.encoding.replace("utf-8-sig", "utf-8")
            values["separator"] = read.separator
        if read.decimal == ",":
            values["decimal"] = ","
        if read.sections:
            values["sections"] = True
            question = "Do several tables stand one below the other, each below a title or a gap?"
            self.doubts.append(OpenDoubt(question, f"they do: {', '.join(sheets)}", *LAYOUT))
        elif not self.table.nested:
            values["heading_rows"] = list(read.heading_rows or ())
        if read.skip_rows and not read.sections:
            values["skip_rows"] = list(read.skip_rows)
            labels = [n for n in read.skip_rows if n > max(read.heading_rows or (n,))]
            if len(labels) == 1 and any(self.table.labels):
                question = f"Does row {labels[0]} say the headings in other words?"
                self.doubts.append(OpenDoubt(question, "it does, and is no answer", *LAYOUT))
        if read.transpose:
            values["transpose"] = True
            question = "Do participants stand side by side, and items one below the other?"
            self.doubts.append(OpenDoubt(question, "they do; columns are read as rows", *LAYOUT))
        if read.stack:
            values["stack"] = True
            question = "The headings repeat in the row: is each run of them a table of its own?"
            self.doubts.append(
                OpenDoubt(question, "it is; they are read one below the other", *LAYOUT)
            )
        if read.marked:
            values["marked"] = True
            question = "Is a mark in one of several columns the answer that the column is called?"
            self.doubts.append(OpenDoubt(question, "it is; the columns are read as one", *LAYOUT))
        if values:
            self.draft.put("read", values)
        if not read.heading_rows and "heading_rows" in values:
            question = f"{self.table.file.name} seems to have no headings: is its first row data?"
            self.doubts.append(
                OpenDoubt(question, "it is; columns are called column 1, column 2 …", *LAYOUT)
            )

    def _write(self) -> None:
        leading = self._answers.leading
        facts = self._facts_beside() or self._facts_by_number(leading)
        if leading is LONG:
            facts = self._people_in_headings()
        if leading and not facts:
            facts = self._heading_facts_of(self._answers[leading])
        when = self._roles.facts.get("timepoint", [])
        if len(facts) == 1 and any(len(texts(self.table, column)) > 1 for column in when):
            facts[0].pop("timepoint", None)  # a column says it better
        rated = self._answers[COURSES]
        courses = self._heading_facts_of(rated)
        self._facts = {COURSES: courses} | ({leading: facts} if leading else {})
        said = {name for each in (*facts, *courses) for name in each}
        said |= self._in_order(facts)
        context, answers = self._context(), self._found_answers(said)
        exposures = draft_facts(context, answers)
        self.draft.values |= exposures.draft.values
        self.draft.comments |= exposures.draft.comments
        self.doubts += exposures.doubts
        self.levels = exposures.levels or self._levels_in_headings(facts)
        self._leave_out(context.participant)
        self._draft_leaving()
        self._compare_moments()
        self._questionnaires()
        self._score_tables()
        self._covariates(exposures)
        self._say_missing(exposures.context.sources)
        who = exposures.context.participant
        self.people = who if who in self._roles.facts["participant"] else None
        if not self._answers[LONG]:
            self.left, why = left_over(exposures.context, self._unread())
            self.doubts += ask_to_leave_out(self.table, why)
        self._ignore(exposures)
        self.gives = bool(
            self.draft.lists or self._leaving or self.draft.values.get("participants")
        )

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
        self.doubts.append(OpenDoubt(question, "they are", *SAME_CONDITION))
        return {
            name: {factor: part[n] for n, factor in factors.items()} for name, part in parts.items()
        }

    def _facts_beside(self) -> list[dict[str, str]]:
        """Return the facts of blocks whose conditions stand in columns beside them."""
        blocks = self._answers[BLOCKS]
        columns = conditions_beside(self.table, blocks, self._answers.taken, self._vocabulary)
        if not columns:
            return []
        facts = self._take_beside(columns, "of the answers beside them")
        for row in self.table.rows:
            said = [row[column] for column in columns if column is not None and row[column]]
            if len({*said}) < len(said):
                self.draft.put("trial", {"count": True}, "exposures in the order of the columns")
                question = f"One condition twice in a row ({', '.join(said)}): was it shown twice?"
                self.doubts.append(OpenDoubt(question, "it was", *ORDER))
                break
        return facts

    def _people_in_headings(self) -> list[dict[str, str]]:
        """Return the participants whom the columns of a long table are called after."""
        names = [self.table.headings[long.response_column] for long in self._answers[LONG]]
        codes = [PERSON_CODE.fullmatch(name) for name in names]
        if len({code[1] for code in codes if code}) != 1 or None in codes:
            return []
        question = f"Are {names[0]} … {names[-1]} participants?"
        self.doubts.append(OpenDoubt(question, "they are: each has a column", *PEOPLE))
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
        self.doubts.append(OpenDoubt(f"Do {shown} say the condition {of}?", first, *CONDITIONS))
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
        self.doubts.append(OpenDoubt(question, assumed, *CONDITIONS))
        self.draft.put("participants", {"sequence": name})
        return {"condition"}

    def _numbers(self, found: Sequence[FoundAnswers]) -> str:
        """Return the fact that numbers in headings are: a column may say the condition already.

        That of a person, of whom all numbers are, leaves them the timepoints.
        """
        said = [c for c in self._roles.facts.get("condition", []) if len(texts(self.table, c)) > 1]
        people = self._roles.facts.get("participant", [])
        scores = [each for each in found if isinstance(each, FoundScores)]
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
        if not blocks or {each.instrument.name for each in blocks} & _OF_WHAT_WAS_USED:
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

    def _context(self) -> Context:
        time = next((r.time for r in self._answers[RATINGS] if r.time is not None), None)
        own = {each.name for each in self._answers.own}
        single = not self._answers[LONG] and not any(each.where for each in self._answers[SCORES])
        people = self._roles.facts["participant"]
        return Context(
            self._without_missing({*self._answers.taken, *people}),
            self._vocabulary,
            self._roles,
            one_row_each=single,
            time=time,
            derived=self._derived(),
            symptoms=not self._answers.instruments - own <= _OF_WHAT_WAS_USED or bool(own),
            judged=self._answers.places_of(_OF_WHAT_WAS_USED),
        )

    def _derived(self) -> frozenset[int]:
        """Return the columns that are exactly the sum of a questionnaire's answers."""
        blocks = self._answers[BLOCKS]
        return frozenset(
            column
            for column in self._roles.unknown
            if sum_of(self.table, column, blocks, self._known)
        )

    def _found_answers(self, said: set[str]) -> AnswersFound:
        keys = [column for long in self._answers[LONG][:1] for column in long.row_keys]
        keys += [each.where[0] for each in self._answers[SCORES][:1] if each.where is not None]
        answered = bool(self._answers) or self._leaving is not None or self._answered_otherwise
        return AnswersFound(self.tables, said, self._answers.taken, keys, answered)

    def _draft_leaving(self) -> None:
        """Draft when participants left exposures, and ask how long exposures were to be."""
        if self._leaving is None:
            return
        decimal = self.table.reading.decimal or "."
        columns, heading, unit, stayed = self._leaving
        cells = [row[column] for row in self.table.rows for column in columns]
        longest_s = max((number(cell, decimal) or 0.0 for cell in cells), default=0.0)
        longest_s *= 60 if unit == "min" else 1
        planned_s = max([longest_s, *(time_in_words_s(cell) or 0.0 for cell in cells)])
        if stayed:  # who has a time has left, so the exposure was longer: to the next minute
            planned_s = 60.0 * (planned_s // 60 + 1)
        said: dict[str, object] = {"heading": heading, "unit": unit, "planned_s": planned_s}
        self.draft.put("left_at", {**said, "missing": list(stayed)} if stayed else said)
        question = f"Was an exposure that nobody left {planned_s:g} s long?"
        assumed = "it was: who has this time, or none, stayed to the end"
        self.doubts.append(OpenDoubt(question, assumed, *STAYED))

    def _questionnaires(self) -> None:
        drafts: list[TomlDraft] = []
        for layout in LAYOUTS:
            if layout.draft is None:
                continue
            for found, own in zip(self._answers[layout], self._facts_of(layout), strict=True):
                table = self._whole if layout is LONG else self.table
                said = {**own, **before_exposures(table, found, own, self.draft.values)}
                draft, doubts = layout.draft(table, found, said, self._known, self._roles)
                beside = self._beside[len(drafts)] if len(drafts) < len(self._beside) else None
                beside = beside if layout is self._answers.leading else None
                if layout is OWN and layout is not self._answers.leading:
                    beside = self._beside_of(found)
                if beside is not None:
                    draft.put("beside", {"condition": beside})
                drafts.append(draft)
                self.doubts += doubts
                if layout in {RATINGS, COURSES} and found.instrument in self._answers.own:
                    names = [table.headings[column] for column in found.columns]
                    self.doubts.append(ask_about(found.instrument, names))
        self.doubts[:] = list(dict.fromkeys(self.doubts))
        if drafts:
            self.draft.lists["questionnaires"] = self._in_short(drafts)

    def _beside_of(self, found: FoundAnswers) -> str | None:
        """Return the column of the condition that stands beside answers, or others like them."""
        leading = self._answers[self._answers.leading or OWN]
        pairs = zip(leading, self._beside, strict=False)
        return next((column for each, column in pairs if each.context == found.context), None)

    def _compare_moments(self) -> None:
        """Ask where headings of answers say another moment than the draft."""
        usual = "post" if self.draft.values.get("timepoint") == {"constant": "post"} else None
        for found, own in zip(self._answers[BLOCKS], self._facts_of(BLOCKS), strict=True):
            names = [self.table.headings[column] for column in found.columns]
            said = {self._vocabulary.timepoint(name) for name in names}
            when = own.get("timepoint", usual)
            if len(said) == 1 and {when, *said} == {"baseline", "post"}:
                question = f"{names[0]!r} seems to say another moment than {when}: is it?"
                self.doubts.append(OpenDoubt(question, f"it is {when}", *TIMEPOINTS))

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
        if len(same) > 1 and same.get(frozenset(), {}).get("timepoint") == "baseline":
            same[frozenset()] = {}  # what says no moment was not asked before by that
        said = [same.get(frozenset(each.context)) for each in found]
        if None not in said:
            return [dict(facts or {}) for facts in said]
        others = self._heading_facts_of(found)
        return [
            other if own is None else dict(own) for own, other in zip(said, others, strict=True)
        ]

    def _in_short(self, drafts: list[TomlDraft]) -> list[TomlDraft]:
        """Merge questionnaires with headings of one template and the same coding."""
        facts = self._facts_of(BLOCKS)
        count = len(facts)
        names = {draft.values["instrument"] for draft in drafts[:count]}
        if count < 2 or len(names) > 1:
            return drafts
        if any("items" not in draft.tables for draft in drafts[:count]):
            return [*placed_in_short(drafts[:count]), *drafts[count:]]
        first = drafts[0]
        own = {key: value for key, value in first.values.items() if key not in facts[0]}
        own.pop("answers", None)
        answers: dict[str, int] = {}
        notes = first.tables["items"].comments
        for draft, said in zip(drafts[:count], facts, strict=True):
            rest = {key: value for key, value in draft.values.items() if key not in said}
            words = rest.pop("answers", {})
            answers |= words if isinstance(words, dict) else {}
            alike = set(draft.tables) == {"items"} and draft.tables["items"].comments == notes
            if rest != own or not alike:
                return drafts
        headings = [
            {item: str(text) for item, text in draft.tables["items"].values.items()}
            for draft in drafts[:count]
        ]
        taken = {text for each in headings for text in each.values()}
        others = [text for text in self.table.headings if text not in taken]
        found = template_of(headings, facts, others)
        if found is None:
            return drafts
        for fact, values in found.values.items():
            if any(text != value for text, value in values.items()):
                self.draft.put(fact, {"values": values})
        whole = TomlDraft({"instrument": own.pop("instrument"), "heading": found.heading, **own})
        if answers:
            whole.put("answers", dict(sorted(answers.items(), key=lambda each: each[1])))
        whole.tables["items"] = TomlDraft(dict(found.items), dict(notes))
        shown = "; ".join(f"{fact}: {', '.join(texts)}" for fact, texts in found.values.items())
        whole.note(f"{count} questionnaires in a row: {shown}")
        return [whole, *drafts[count:]]

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
            (e.instrument.name, without_levels(self.table, e, self._vocabulary)) for e in found
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
            if name in _OF_WHAT_WAS_USED:
                own = [*map(_baseline_as_condition, own)] if _only_baselines(own) else own
            for place, said in zip(places, own, strict=True):
                facts[place] = self._spelt(said)
        return facts

    @property
    def _answered(self) -> set[str]:
        """Return the names of the instruments of which the table has the answers."""
        return {each.instrument.name for each in (*self._answers[BLOCKS], *self._answers[LONG])}

    def _score_tables(self) -> None:
        """Draft scores of instruments without answers in the table."""
        drafts = []
        asked: dict[str, list[str]] = {}
        for each, said in zip(self._answers[SCORES], self._facts_of(SCORES), strict=True):
            if each.instrument.name in self._answered:
                self._made |= dict.fromkeys(each.columns, "a score made of the answers")
                continue
            if self._averages(each):
                self._made |= dict.fromkeys(each.columns, "a mean of the others")
                continue
            for kind, part in by_kind(self.table, each).items():
                scales = {scale: self.table.headings[c] for scale, c in part.scales.items()}
                draft = TomlDraft({"instrument": part.instrument.name, **said, "kind": kind})
                if part.where is not None:
                    draft.put("where", {self.table.headings[part.where[0]]: part.where[1]})
                draft.note("The answers are not in the file: scores alone.")
                draft.tables["scales"] = TomlDraft(dict(scales))
                drafts.append(draft)
                what = {"raw_sum": "raw sums", "score": "scores by the published formula"}.get(
                    kind, "scores by another formula"
                )
                of = f"{what} of the {part.instrument.short}"
                names = [*scales.values()] if part.where is None else [part.where[1]]
                asked.setdefault(of, []).extend(names)
        for what, names in asked.items():
            question = f"{', '.join(names)}: are these {what}?"
            self.doubts.append(
                OpenDoubt(question, f"they are {what}; the answers are not there", *SCORE_KIND)
            )
        if drafts:
            self.draft.lists["scores"] = drafts

    def _averages(self, scores: FoundScores) -> bool:
        """Return whether scores are means over conditions, which others are beside."""
        return len(self._answers[SCORES]) > 1 and bool({*scores.context} & self._vocabulary.totals)

    def _covariates(self, exposures: DraftedFacts) -> None:
        if exposures.context.covariates:
            names = {n: self.table.headings[c] for n, c in exposures.context.covariates.items()}
            there = self.draft.values.get("participants", {})
            self.draft.put("participants", {**(there if isinstance(there, dict) else {}), **names})
        if exposures.context.participant is not None:
            self._asked_again(exposures.context.participant)

    def _asked_again(self, column: int) -> None:
        """Take ``5(2)`` beside ``5`` for the second time of one person, and ask."""
        people = texts(self.table, column)
        again = {
            code: code[: -len(mark[0])].strip() for code in people if (mark := _AGAIN.search(code))
        }
        if not again or not {*again.values()} <= {*people}:
            return
        self.draft.put("participant", {"column": self.table.headings[column], "values": again})
        self.draft.put("trial", {"count": True}, "exposures in the order of the rows")
        code, person = next(iter(again.items()))
        question = f"Is {code!r} participant {person!r} at another time?"
        self.doubts.append(OpenDoubt(question, "it is; exposures are numbered", *SAME_PERSON))

    @property
    def known(self) -> bool:
        """Return whether there are answers, or times of leaving."""
        return bool(self._answers) or self._leaving is not None

    @property
    def has_conditions(self) -> bool:
        """Return whether rows, headings or names of files say conditions."""
        said = any("condition" in each for facts in self._facts.values() for each in facts)
        names = (
            self.draft.values.get(key, "") for key in ("file_name", "file_pattern", "sheet_name")
        )
        return said or "condition" in self.draft.values or any("condition" in str(n) for n in names)

    def once_a_person(self) -> list[int]:
        """Return the columns of facts of people among those taken for own questions.

        They are of no condition, where headings say conditions, or ask for a habit; or they stand
        among other facts of people, each of whom has one row.
        """
        facts = self._facts_of(OWN)
        leading = self._facts.get(self._answers.leading or OWN, facts)
        said = any("condition" in each for each in leading)
        pairs = zip(self._answers[OWN], facts, strict=True)
        asked = [(each, "condition" in own) for b, own in pairs for each in b.items.values()]
        left = {each.column: has for each, has in asked if each.how in {"left", "measure"}}
        left = {c: has for c, has in left.items() if c not in self._roles.outcomes}
        who = [] if self.people is None else texts(self.table, self.people)
        if len(who) == len(self.table.rows):
            of_people = {*self._roles.covariates.values()}
            known = {*self._answers.taken} - left.keys()
            between = {c for c in left if _stands_among(c, of_people, known)}
            habits = {c for c in left if self._asks_how_often(c)}
        else:
            between = habits = set()
        return [c for c, has in left.items() if not has and (said or c in between | habits)]

    def _asks_how_often(self, column: int) -> bool:
        """Return whether a question asks for a habit of a person."""
        words = tokens(self.table.headings[column])
        return bool({a + b for a, b in pairwise(words)} & self._vocabulary.asking.others)

    def _say_of_people(self, columns: Collection[int]) -> None:
        """Take columns that nothing else knows for facts of people, and ask."""
        names = self.table.headings
        for column in columns:
            self._roles.forget(column)
            name = covariate_name(names[column])
            there = self._roles.covariates
            there[name if name not in there else f"{name}_{column + 1}"] = column
        if columns:
            shown = ", ".join(repr(names[column]) for column in columns)
            question = (
                f"No rule knows {shown}, said once of each person: are these facts of people?"
            )
            self.doubts.append(OpenDoubt(question, "they are, for participants.csv", *LEFT))

    def _unread(self) -> list[int]:
        """Return the columns that nothing was said of, but for those that no analysis needs."""
        measured = [
            column
            for column in self._roles.metadata
            if {*tokens(self.table.headings[column])} & self._vocabulary.measures
        ]
        sums = self._vocabulary.totals | self._vocabulary.scale_fillers
        return [
            column
            for column in (*self._roles.unknown, *measured)
            if column in self._roles.outcomes
            or (column not in self._made and column not in self._left_out)
            if not sum_of(self.table, column, self._answers[BLOCKS], self._known)
            if not (self._answers.products and {*tokens(self.table.headings[column])} & sums)
        ]

    def _ignore(self, exposures: DraftedFacts) -> None:
        """List every column that nothing was said of, with the reason."""
        rest = [
            column
            for column in (
                *self._roles.metadata,
                *self._roles.unknown,
                *exposures.unused,
                *self._made,
            )
            if column not in exposures.context.used and column not in self._left_out
        ]
        columns = sorted(set(rest))
        if not columns:
            return
        known = {*self._roles.metadata, *self._made}
        asked = [column for column in columns if column not in known]
        reasons, doubts = leftovers(self.table, asked, self._answers[BLOCKS], self._known)
        self.doubts += doubts
        for column in columns:
            name = self.table.headings[column]
            reason = reasons.get(column) or self._made.get(column, "")
            if is_personal(name, self._vocabulary):
                reason = "may tell who the person is"
            if reason:
                self.draft.note(f"{name}: {reason}", "ignore")
        self.draft.put("ignore", [self.table.headings[column] for column in columns])
