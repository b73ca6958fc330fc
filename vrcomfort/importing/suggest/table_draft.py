"""Drafts the mapping of one table, or of several that are made alike."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from vrcomfort.importing.answers import number
from vrcomfort.importing.files import is_number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.answer_columns import (
    BLOCKS,
    COURSES,
    LAYOUTS,
    LONG,
    OWN,
    RATINGS,
    SCORES,
)
from vrcomfort.importing.suggest.block_conditions import before_exposures
from vrcomfort.importing.suggest.cells import (
    LONGEST_CONDITION,
    few_texts,
    is_numeric,
    texts,
    varies_within,
)
from vrcomfort.importing.suggest.draft import (
    LEFT,
    LOST,
    NOT_MADE,
    SAME_PERSON,
    SCORE_KIND,
    STAYED,
    TIMEPOINTS,
    WORDS,
    OpenDoubt,
    listed,
    placed_in_short,
)
from vrcomfort.importing.suggest.evidence import Context
from vrcomfort.importing.suggest.fact_draft import AnswersFound, DraftedFacts
from vrcomfort.importing.suggest.facts import draft_facts
from vrcomfort.importing.suggest.found_answers import FoundAnswers
from vrcomfort.importing.suggest.heading_facts import template_of
from vrcomfort.importing.suggest.heading_roles import inner_names, is_personal
from vrcomfort.importing.suggest.left_over import ask_to_leave_out, in_first_person, left_over
from vrcomfort.importing.suggest.own_instruments import TakenFor, ask_about
from vrcomfort.importing.suggest.questionnaires import (
    MADE_OF_ANSWERS,
    is_score_of,
    leftovers,
    sum_of,
)
from vrcomfort.importing.suggest.said_by_headings import OF_WHAT_WAS_USED, SaidByHeadings
from vrcomfort.importing.suggest.scores import FoundScores, by_kind
from vrcomfort.importing.suggest.vocabulary import OUTCOME, Known, covariate_name, free_name, tokens
from vrcomfort.importing.toml_draft import TomlDraft
from vrcomfort.questionnaire import Instrument, plain
from vrcomfort.settings import toml_value

_SHOWN = 8
"""Columns that a doubt lists."""
_FEWEST_STAYED = 3
"""Cells with the longest time, at least half of all times: it is the length of the exposure."""
_AGAIN = re.compile(r" ?\(\d\)$")
"""The mark of a person's second questionnaire."""
_COMPUTED = "an exact sum, or the reverse, of columns before"


class TableDraft(SaidByHeadings):
    """The mapping of tables with the same headings.

    Parameters
    ----------
    tables
        The tables; the first one's reading is written down.
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
        super().__init__(tables, known, left)
        self._answered_otherwise = answered
        self.left: dict[int, TakenFor] = {}
        """Column that nothing in this draft knows → what it may be taken for."""
        self.people: int | None = None
        """The column of the participants, if its heading says so."""
        self.levels: dict[str, dict[str, str]] = {}
        """Condition → factor → level, where conditions are made of crossed factors."""
        self.gives = False
        """Whether there is anything to import."""
        self._say_of_people(of_person)
        for column in self._trial_runs:
            if column not in self._roles.facts.get("participant", ()):
                self._roles.forget(column)
        self._whole = self.table
        """The table with rows of other questions, where each has a row."""
        self._keep_items(self._answers[LONG])
        self.unanswered = self._answers.named(self._whole, known) - self._answers.instruments
        """Instruments that the file names, and to which it has no answers."""
        self.answered = self._answers.instruments
        self._made = {**self._answers.made}
        """Column of a score whose answers are there → why it is ignored."""
        self._write()

    def column_of(self, fact: str) -> str | None:
        """Return the heading of the column that says a fact, if one alone does."""
        said = self.draft.values.get(fact)
        column = said.get("column") if isinstance(said, dict) else None
        return column if isinstance(column, str) else None

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
        named = (*self._roles.facts["participant"], *self._roles.metadata)
        self.people = who if who in named else None  # as participants, or as names
        if not self._answers[LONG]:
            unused = [c for c in self._roles.facts["scene"] if c in exposures.unused]
            self.left, why = left_over(exposures.context, [*self._unread(), *unused])
            self.doubts += ask_to_leave_out(self.table, why)
        self._ignore(exposures)
        self.gives = bool(
            self.draft.lists or self._leaving or self.draft.values.get("participants")
        )

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
            symptoms=not self._answers.instruments - own <= OF_WHAT_WAS_USED or bool(own),
            judged=self._answers.places_of(OF_WHAT_WAS_USED),
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
        columns, heading, unit, stayed = self._leaving
        cells = [row[column] for row in self.table.rows for column in columns]
        times = [value for cell in cells if (value := number(cell, self.table.decimal)) is not None]
        said: dict[str, object] = {"heading": heading, "unit": unit}
        question = f"How long was an exposure that nobody left, of which {heading!r} says nothing?"
        assumed = "of unknown length: who has a time has left, who has none has stayed to the end"
        longest = max(times, default=0.0)
        most = times.count(longest) >= max(_FEWEST_STAYED, len(times) / 2)
        if not stayed and longest > 0 and most:
            said["planned_s"] = longest * (60 if unit == "min" else 1)
            question = f"Was an exposure that nobody left {said['planned_s']:g} s long?"
            assumed = "it was: who has this time, or none, stayed to the end"
        self.draft.put("left_at", {**said, "missing": list(stayed)} if stayed else said)
        self.doubts.append(OpenDoubt(question, assumed, STAYED))

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
        for layout in (BLOCKS, OWN):
            for found, own in zip(self._answers[layout], self._facts_of(layout), strict=True):
                names = [self.table.headings[column] for column in found.columns]
                said = [self._vocabulary.timepoint(name) for name in names]
                when = own.get("timepoint", usual)
                other = [n for n, at in zip(names, said, strict=True) if at and at != when]
                if when and other and (layout is OWN or len({*said}) == 1):
                    question = f"{other[0]!r} seems to say another moment than {when}: is it?"
                    self.doubts.append(OpenDoubt(question, f"it is {when}", TIMEPOINTS))

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

    def _score_tables(self) -> None:
        """Draft scores of instruments without answers in the table."""
        drafts = []
        asked: dict[str, list[str]] = {}
        for found, said in zip(self._answers[SCORES], self._facts_of(SCORES), strict=True):
            beside = found.instrument.name in self._answered
            each = self._unlike_answers(found) if beside else found
            if not beside and self._averages(each):
                self._made |= dict.fromkeys(each.columns, "a mean of the others")
                continue
            for kind, part in by_kind(self.table, each).items() if each.scales else ():
                scales = {scale: self.table.headings[c] for scale, c in part.scales.items()}
                draft = TomlDraft({"instrument": part.instrument.name, **said, "kind": kind})
                if part.where is not None:
                    draft.put("where", {self.table.headings[part.where[0]]: part.where[1]})
                draft.tables["scales"] = TomlDraft(dict(scales))
                drafts.append(draft)
                if beside:
                    continue
                draft.note("The answers are not in the file: scores alone.")
                what = {"raw_sum": "raw sums", "score": "scores by the published formula"}.get(
                    kind, "scores by another formula"
                )
                of = f"{what} of the {part.instrument.short}"
                names = [*scales.values()] if part.where is None else [part.where[1]]
                asked.setdefault(of, []).extend(names)
        for what, names in asked.items():
            question = f"{', '.join(names)}: are these {what}?"
            assumed = f"they are {what}; the answers are not there"
            self.doubts.append(OpenDoubt(question, assumed, SCORE_KIND))
        if drafts:
            self.draft.lists["scores"] = drafts

    def _unlike_answers(self, scores: FoundScores) -> FoundScores:
        """Return the scores that are not in all rows those of the answers, and ask about them.

        The others are ignored.
        """
        blocks = [b for b in self._answers[BLOCKS] if b.instrument == scores.instrument]
        unlike = {}
        for scale, column in scores.scales.items():
            said = is_score_of(self.table, column, blocks, self._known) if blocks else None
            if said is not False:
                self._made[column] = MADE_OF_ANSWERS if said else "its answers are there"
                continue
            unlike[scale] = column
            name = self.table.headings[column]
            question = f"{name!r} is not in all rows the score of the answers beside it: is it one?"
            self.doubts.append(OpenDoubt(question, "it is, and kept as the file has it", NOT_MADE))
        return replace(scores, scales=unlike)

    def _averages(self, scores: FoundScores) -> bool:
        """Return whether scores are means over conditions, which others are beside."""
        return len(self._answers[SCORES]) > 1 and bool({*scores.context} & self._vocabulary.totals)

    def _covariates(self, exposures: DraftedFacts) -> None:
        who, facts = exposures.context.participant, exposures.context.covariates
        for name, column in [*facts.items()] if who is not None else ():
            if column in self._roles.unknown and varies_within(self.every_row, column, who):
                del facts[name]  # in rows without answers, a person has others
                exposures.context.used.discard(column)
        if facts:
            names = {n: self.table.headings[c] for n, c in facts.items()}
            there = self.draft.values.get("participants", {})
            self.draft.put("participants", {**(there if isinstance(there, dict) else {}), **names})
        if who is not None:
            self._asked_again(who)

    def _asked_again(self, column: int) -> None:
        """Ask whether ``5(2)`` is ``5`` again."""
        people = texts(self.table, column)
        again = {
            code: code[: -len(mark[0])].strip() for code in people if (mark := _AGAIN.search(code))
        }
        if not again or not {*again.values()} <= {*people}:
            return
        values = {"column": self.table.headings[column], "values": again}
        assumed = f"it is not; else participant = {toml_value(values)}"
        code, person = next(iter(again.items()))
        question = f"Is {code!r} participant {person!r} at another time?"
        self.doubts.append(OpenDoubt(question, assumed, SAME_PERSON))

    @property
    def known(self) -> bool:
        """Return whether there are answers, or times of leaving."""
        return bool(self._answers) or self._leaving is not None

    @property
    def outcomes(self) -> bool:
        """Return whether the lab calls some of the columns outcomes."""
        return bool(self._roles.outcomes)

    @property
    def has_conditions(self) -> bool:
        """Return whether rows, headings or names of files say conditions."""
        said = any("condition" in each for facts in self._facts.values() for each in facts)
        names = (
            self.draft.values.get(key, "") for key in ("file_name", "file_pattern", "sheet_name")
        )
        return said or "condition" in self.draft.values or any("condition" in str(n) for n in names)

    def with_several_rows(self, people: int) -> list[str]:
        """Return the participants with several rows."""
        counts = Counter(self.table.column(people))
        return [who for who, count in counts.items() if who and count > 1]

    def words_of_people(self) -> list[int]:
        """Return the columns that nothing knows, and that say one of a few texts."""
        columns = [c for c in self._roles.unknown if few_texts(self.table, c)]
        return [c for c in columns if not is_numeric(self.table, c)]

    def of_other_rows(self) -> list[int]:
        """Return the columns of numbers of people that only rows without answers hold.

        Each person has one, as on a form before the first exposure; and they differ.
        """
        if self.people is None or self._answers[LONG]:
            return []
        columns = [c for c in self._roles.unknown if not texts(self.table, c)]
        return [
            c
            for c in columns
            if len(texts(self.every_row, c)) > 1
            if is_numeric(self.every_row, c) and not varies_within(self.every_row, c, self.people)
        ]

    def once_a_person(self) -> list[int]:
        """Return the columns of facts of people among those taken for own questions.

        They are of no condition, where headings say conditions; or ask for a habit, where each
        person has one row.
        """
        facts = self._facts_of(OWN)
        leading = self._facts.get(self._answers.leading or OWN, facts)
        said = any("condition" in each for each in leading)
        pairs = zip(self._answers[OWN], facts, strict=True)
        asked = [(each, "condition" in own) for b, own in pairs for each in b.items.values()]
        left = {each.column: has for each, has in asked if each.how in {"left", "measure"}}
        said_of = {c: (self.table.headings[c], *inner_names(self.table.headings[c])) for c in left}
        told = {c: {*map(self._vocabulary.told, names)} for c, names in said_of.items()}
        left = {c: has for c, has in left.items() if OUTCOME not in told[c]}
        if self.people is not None:
            left = {
                c: has for c, has in left.items() if not varies_within(self.table, c, self.people)
            }
        who = [] if self.people is None else texts(self.table, self.people)
        if len(who) == len(self.table.rows):
            names = self.table.headings
            habits = {c for c in left if self._vocabulary.asks_of_habits(tokens(names[c]))}
        else:
            habits = set()
        return [c for c, has in left.items() if not has and (said or c in habits)]

    def _say_of_people(self, columns: Collection[int]) -> None:
        """Take columns that nothing else knows for facts of people, and ask."""
        names = self.table.headings
        for column in columns:
            self._roles.forget(column)
            there = self._roles.covariates
            there[free_name(covariate_name(names[column]), there)] = column
        if columns:
            shown = ", ".join(repr(names[column]) for column in columns)
            question = (
                f"No rule knows {shown}, said once of each person: are these facts of people?"
            )
            self.doubts.append(OpenDoubt(question, "they are, for participants.csv", LEFT))

    def _unread(self) -> list[int]:
        """Return the columns that nothing was said of, but for those that no analysis needs."""
        measured = [
            column
            for column in self._roles.metadata
            if {*tokens(self.table.headings[column])} & self._vocabulary.measures
            or in_first_person(self.table.headings[column], self._vocabulary)
        ]
        sums = self._vocabulary.totals | self._vocabulary.scale_fillers
        return [
            column
            for column in (*self._roles.unknown, *measured)
            if column in self._roles.outcomes
            or not (
                column in self._made
                or column in self._left_out
                or sum_of(self.table, column, self._answers[BLOCKS], self._known)
                or (self._answers.has_products and {*tokens(self.table.headings[column])} & sums)
            )
        ]

    def _ask_about_words(self, columns: Sequence[int]) -> None:
        """Ask whether columns of short texts, of which nothing was said, may be left out."""
        words = []
        for column in columns:
            said = [t for t in texts(self.table, column) if number(t, self.table.decimal) is None]
            short = sorted(map(len, said))[len(said) // 2 :][:1]
            if len(said) > 1 and short and short[0] <= LONGEST_CONDITION:
                words.append(repr(self.table.headings[column]))
        if words:
            what = f"{len(words)} columns of words" if words[1:] else "a column of words"
            question = f"May {what} be left out: {listed(words, _SHOWN)}?"
            self.doubts.append(OpenDoubt(question, "yes: they stand under ignore", WORDS))

    def _ignore(self, exposures: DraftedFacts) -> None:
        """List every column that nothing was said of, with the reason."""
        rest = {*self._roles.metadata, *self._roles.unknown, *exposures.unused, *self._made}
        columns = sorted(rest - exposures.context.used - self._left_out.keys())
        if not columns:
            return
        known = {*self._roles.metadata, *self._made}
        asked = [column for column in columns if column not in known]
        reasons, doubts = leftovers(self.table, asked, self._answers[BLOCKS], self._known)
        made = self._answers.computed & {*columns} - {*reasons} - {*self._made}
        self.doubts += doubts + ask_to_leave_out(self.table, dict.fromkeys(sorted(made), _COMPUTED))
        self._ask_about_words([c for c in asked if c not in reasons])
        for column in (c for c in asked if reasons.get(c) == "empty" and texts(self.every_row, c)):
            reasons[column] = "filled in rows without answers alone"
        for column in columns:
            heading, cells = self.table.headings[column], self.every_row.column(column)
            count = sum(map(is_number, cells))
            if plain(heading) in self._vocabulary.response_labels and count * 20 > len(cells):
                question = f"Are {count} numbers in {heading!r} no answers, as they are ignored?"
                self.doubts.append(OpenDoubt(question, "they are none", LOST))
        for column in columns:
            name = self.table.headings[column]
            reason = reasons.get(column) or self._made.get(column, "")
            if (
                not reason
                and self._answers.has_products
                and is_score_of(self.table, column, self._answers[BLOCKS], self._known)
            ):
                reason = MADE_OF_ANSWERS
            if is_personal(name, self._vocabulary):
                reason = "may tell who the person is"
            if reason:
                self.draft.note(f"{name}: {reason}", "ignore")
        self.draft.put("ignore", [self.table.headings[column] for column in columns])
