"""Drafts where the participant, the condition and the timepoint come from."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, combinations

from vrcomfort.importing.suggest.cells import (
    MOST_CONDITIONS,
    counts_of_people,
    is_numeric,
    measures,
    texts,
    values_of,
)
from vrcomfort.importing.suggest.conditions import Conditions
from vrcomfort.importing.suggest.draft import (
    CONDITIONS,
    CURIOUS,
    NAMES_OF_FILES,
    ORDER,
    PEOPLE,
    TIMEPOINTS,
)
from vrcomfort.importing.suggest.evidence import (
    BALANCED_WORDS,
    BASELINE_AMONG_CONDITIONS,
    CODES,
    FIRST_COLUMNS,
    OTHER_TIMEPOINTS,
    Context,
    candidates,
    says_no_person,
)
from vrcomfort.importing.suggest.fact_draft import AnswersFound, DraftedFacts
from vrcomfort.importing.suggest.names_of_files import names_with_folders, parts_of_names
from vrcomfort.importing.suggest.people import People
from vrcomfort.importing.suggest.shared_codes import codes_in, is_shown_in_turn
from vrcomfort.importing.suggest.vocabulary import covariate_name, free_name, tokens

_GUESSED_TIMEPOINTS = (BASELINE_AMONG_CONDITIONS, OTHER_TIMEPOINTS)
_FEWEST_ROWS = 3
_FEWEST_OF_FILE = 4
_OF_ROWS = {"condition", "timepoint", "session", "period", "block", "trial", "scene"}
"""Facts that tell the rows of one person apart."""
_NUMBER = re.compile(r"\d")
_MOMENTS_AFTER = 2


def draft_facts(context: Context, answers: AnswersFound) -> DraftedFacts:
    """Draft every fact that the headings of the answers do not say."""
    return _Facts(context, answers).found


class _Facts(People):
    def __init__(self, context: Context, answers: AnswersFound) -> None:
        super().__init__(answers, DraftedFacts(context), {})
        self._varying: list[int] = []
        self._times_under_other_headings()
        self._sessions_under_timepoints()
        self._measures_under_labels()
        self._codes()
        self._participant_column()
        self._order()
        self._names_of_files()
        self._participant()
        if context.time is not None:
            context.used.add(context.time)
        for fact in ("session", "period", "block", "trial"):
            self._plain_fact(fact)
        self._lacking_conditions()
        self._stimuli()
        if self._condition_is_named() or not answers.answered:
            self._plain_fact("scene")
        self._timepoint()
        self._covariates()
        if answers.answered:
            Conditions(self._answers, self.found, self._named).draft()
            if "scene" not in self._context.columns:
                self._plain_fact("scene")
        for column in self._varying:
            if column not in self._context.used:
                question = f"Why has a participant more than one {self.heading(column)!r}?"
                self.doubt(question, "it is ignored", CURIOUS)
        named = chain(*self._roles.facts.values(), self._roles.covariates.values())
        self.found.unused += [column for column in named if column not in self._context.used]

    def _condition_is_named(self) -> bool:
        """Return whether headings, names of files or a column say the condition."""
        columns = self._roles.facts.get("condition", [])
        named = "condition" in self._answers.said or "condition" in self._named
        return named or any(texts(self._table, column) for column in columns)

    def _lacking_conditions(self) -> None:
        """Take columns that lack rows for no conditions, where another lacks none; and ask."""
        named = self._roles.facts["condition"]
        others = (*self._roles.unknown, *self._roles.facts["scene"])
        found = candidates("condition", others, self._context)
        whole = [
            each.column
            for each in found
            if each.evidence is BALANCED_WORDS and not self._lacks_rows(each.column)
        ]
        if not whole or not named or not all(map(self._lacks_rows, named)):
            return
        self._roles.facts["condition"] = []
        self._roles.unknown += named
        names = ", ".join(repr(self.heading(column)) for column in named)
        assumed = f"it is not: {self.heading(whole[0])!r}, which lacks none, is"
        self.doubt(f"{names} lacks rows: is it not the condition?", assumed, CONDITIONS)

    def _stimuli(self) -> None:
        """Take a column of many things that were shown for the scene, and ask."""
        facts = self._roles.facts
        if facts["scene"] or "scene" in self._answers.said or not self._answers.answered:
            return
        columns = [*facts["condition"], *self._roles.unknown]
        columns = [c for c in columns if not self._vocabulary.told(self.heading(c))]
        for column in [c for c in columns if self._tells_stimuli(c)][:1]:
            self._roles.forget(column)
            self.use("scene", column)
            count = len(texts(self._table, column))
            question = f"Does {self.heading(column)!r} say which of {count} things was shown?"
            self.doubt(question, "it does: each is a scene, and no condition", CONDITIONS)

    def _tells_stimuli(self, column: int) -> bool:
        """Return whether a column names many things that were shown, most to several people."""
        table, who = self._table, self._context.participant
        if who is None or not self._context.one_row_each or is_numeric(table, column):
            return False
        words = texts(table, column)
        if len(words) <= MOST_CONDITIONS or measures(table, column):
            return False
        if {*tokens(self.heading(column))} & self._vocabulary.fact_words["condition"]:
            return False
        seen: dict[str, set[str]] = defaultdict(set)
        for row in table.rows:
            seen[row[column]].add(row[who])
        shared = sum(len(seen[word]) > 1 for word in words)
        people = counts_of_people(table, column, who)
        once = sum(max(counts.values()) == 1 for counts in people)
        return shared * 5 >= len(words) * 4 and once * 2 > len(people)

    def _times_under_other_headings(self) -> None:
        """Take texts such as ``Pre-exposure`` for timepoints, though they stand under Session."""
        facts, timepoint = self._roles.facts, self._vocabulary.timepoint
        for fact in ("session", "period", "block", "trial"):
            for column in list(facts[fact]):
                words = texts(self._table, column)
                when = [*map(timepoint, words)]
                if len({*words}) > 1 and all(when):
                    facts[fact].remove(column)
                    facts["timepoint"].append(column)
                elif "baseline" in when and None in when and not any(map(_NUMBER.search, words)):
                    facts[fact].remove(column)
                    facts["condition"].append(column)

    def _sessions_under_timepoints(self) -> None:
        """Take texts such as ``session_1_arm_1`` for sessions, though they are called events."""
        facts = self._roles.facts
        for column in list(facts["timepoint"]):
            words = texts(self._table, column)
            numbered, timepoint = self._vocabulary.numbered, self._vocabulary.timepoint
            said = [[numbered.get(part) for part in tokens(word)] for word in words]
            if words and all("session" in each for each in said) and not any(map(timepoint, words)):
                facts["timepoint"].remove(column)
                facts["session"].append(column)

    def _measures_under_labels(self) -> None:
        """Leave out columns such as the seconds under ``sessionTime``, which number nothing."""
        for fact in ("session", "period", "block", "trial"):
            for column in list(self._roles.facts[fact]):
                if measures(self._table, column) and is_numeric(self._table, column):
                    self._roles.facts[fact].remove(column)
                    self._roles.metadata.append(column)
        people = self._roles.facts["participant"]
        people = [c for c in people if not self._vocabulary.told(self.heading(c))]
        for column in [c for c in people if says_no_person(self._table, c, self._vocabulary)]:
            self._roles.facts["participant"].remove(column)  # participantCanSeeResults
            self._roles.metadata.append(column)

    def _codes(self) -> None:
        """Take participant and timepoint, or condition, from codes that say both."""
        facts = self._roles.facts
        columns = sorted({*facts["participant"], *facts["timepoint"], *self._roles.unknown})
        for column in columns[:FIRST_COLUMNS]:
            codes = codes_in(self._table.column(column), self._vocabulary)
            if codes is None:
                continue
            fact = "timepoint" if codes.timepoints else "condition"
            if any(c != column for c in facts["participant"]):
                return  # a column of keys, made of that of the people
            if fact in self._answers.said or any(c != column for c in facts[fact]):
                return
            self._roles.forget(column)
            facts["participant"].insert(0, column)
            words = {
                code: (self._vocabulary.timepoint(word) or word) if codes.timepoints else word
                for code, word in codes.words.items()
            }
            self._context.participant = column
            self.use(fact, column, values=words)
            self.use("participant", column, values=codes.people)
            code = next(iter(words))
            question = f"Does {code!r} in {self.heading(column)!r} mean two things?"
            self.doubt(question, f"participant {codes.people[code]}, {fact} {words[code]}", PEOPLE)
            return

    def _order(self) -> None:
        """Take an order that differs within participants for the number of the exposure."""
        for found in candidates("trial", [*self._roles.covariates.values()], self._context):
            del self._roles.covariates["sequence"]
            self._roles.facts["trial"].append(found.column)
            self.doubt_of(found)

    def _names_of_files(self) -> None:
        """Take facts from the names of sheets, or of files."""
        answers = self._answers
        wanted = [] if self._coded() is not None else ["participant"]
        known = {*answers.said, *self._context.columns}
        wanted += [
            fact
            for fact in ("condition", "timepoint")
            if fact not in known and not self._roles.facts.get(fact)
        ]
        if not self._roles.facts.get("session"):
            wanted.append("session")
        if self._said_in_files("timepoint") or self._ask_otherwise():
            wanted = [fact for fact in wanted if fact == "participant"]
        elif self._said_in_files("condition"):
            wanted = [fact for fact in wanted if fact != "condition"]
        sheets = [table.sheet for table in answers.tables]
        stems = names_with_folders([table.file for table in answers.tables])
        ways = (("sheet_name", sheets, "sheets"), ("file_name", stems, "files"))
        for key, each, what in ways:
            left = [fact for fact in wanted if fact not in self._named]
            names = list(dict.fromkeys(each))
            people = self._people_of(each)
            parts = parts_of_names(names, left, self._vocabulary, people)
            if parts is not None and self._has_people(parts.texts.get("participant", ())):
                left.remove("participant")
                parts = parts_of_names(names, left, self._vocabulary, people)
            if parts is None:
                continue
            self.found.draft.put("file_pattern" if parts.expression else key, parts.template)
            self._named |= parts.texts
            if "" in parts.texts.get("condition", ()):
                words = [text for text in parts.texts["condition"] if text]
                values = {"": f"without_{words[0]}"} | {word: word for word in words}
                self.found.draft.put("condition", {"values": values})
            shown = ", ".join(names[:3]) + (" …" if len(names) > 3 else "")
            said = "; ".join(
                f"{f}: {', '.join(text or 'nothing' for text in t[:6])}"
                for f, t in parts.texts.items()
            )
            self.doubt(f"Do the names of the {what} ({shown}) say this?", said, NAMES_OF_FILES)

    def _coded(self) -> int | None:
        """Return the column of codes of people, whatever its heading."""
        if self._context.participant is not None:
            return self._context.participant
        others = (*self._roles.unknown, *self._roles.metadata)
        found = candidates("participant", others, self._context)
        return next((each.column for each in found if each.evidence in CODES), None)

    def _said_in_files(self, fact: str) -> bool:
        """Return whether a column says the moment or condition of each file: its name says no more.

        Conditions are words of which nearly everybody has each.
        """
        context = replace(self._context, participant=self._coded())
        found = candidates(fact, self._roles.unknown, context)
        if fact == "condition":
            found = [each for each in found if each.evidence is BALANCED_WORDS]
        if not found or len({table.file for table in self._answers.tables}) < 2:
            return False
        words = {*texts(self._table, found[0].column)}
        said = [{*table.column(found[0].column)} & words for table in self._answers.tables]
        return all(len(each) <= 1 for each in said)

    def _ask_otherwise(self) -> bool:
        """Return whether each file has other questions, a row for each: its name says which."""
        items = [{*t.column(c)} for c in self._answers.row_keys[:1] for t in self._answers.tables]
        return len(items) > 1 and all(not one & two for one, two in combinations(items, 2))

    def _has_people(self, named: Sequence[str]) -> bool:
        """Return whether each of some files, called by words, has the rows of several people.

        Nothing in a row says when it was answered, or about what, as those of one person do.
        """
        roles = {fact for fact, columns in self._roles.facts.items() if columns}
        told = (roles | self._answers.said) & _OF_ROWS or self._context.time is not None
        words = 1 < len(named) <= MOST_CONDITIONS and not any(map(_NUMBER.search, named))
        rows = (len(table.rows) >= _FEWEST_OF_FILE for table in self._answers.tables)
        return words and self._context.one_row_each and not told and all(rows)

    def _people_of(self, names: Sequence[str]) -> list[str]:
        """Return the participant of each name of a table; nothing where one has several."""
        column = self._context.participant
        if column is None or "participant" in self._answers.said:
            return []
        people: dict[str, set[str]] = {}
        for name, table in zip(names, self._answers.tables, strict=True):
            people.setdefault(name, set()).update({*table.column(column)} - {""})
        return (
            [min(p) for p in people.values()] if all(len(p) == 1 for p in people.values()) else []
        )

    def _plain_fact(self, fact: str) -> None:
        columns = [c for c in self._roles.facts.get(fact, []) if texts(self._table, c)]
        if not columns or fact in self._answers.said:
            return
        column = next((c for c in columns if c not in self._context.used), None)
        if column is None:
            return
        if self._is_key_of_rows(fact, column) or (fact == "trial" and self._numbers_pages(column)):
            self._roles.metadata.append(column)
            return
        if fact != "scene" and self._counts_from_none(column):
            self._roles.unknown.append(column)
            return
        said = "condition" in self._context.columns or self._condition_is_named()
        if fact == "block" and not is_numeric(self._table, column) and not said:
            self._roles.unknown.append(column)  # words under Block are what was shown in it
            return
        if fact in {"trial", "period"} and "condition" in self._answers.said:
            self._exposures_of_rows(fact, column)
            return
        numbers = fact in {"session", "trial", "period", "block"}
        if numbers and not is_numeric(self._table, column):
            what = "numbered in the order of the rows"
            self.use(fact, column, what, count=True)
            question = (
                f"Are the texts of {self.heading(column)!r} {fact}s, in the order of the rows?"
            )
            self.doubt(question, f"they are, {what}", ORDER)
        else:
            self.use(fact, column)

    def _counts_from_none(self, column: int) -> bool:
        """Return whether each person has one number, the lowest above 1: a rating of sessions."""
        who = self._context.participant
        once = who is not None and len(texts(self._table, who)) == len(self._table.rows)
        return once and min(values_of(self._table, column), default=0) > 1

    def _numbers_pages(self, column: int) -> bool:
        """Return whether most people have numbers with gaps, as those of a program's pages are.

        Where no column says before and after, they still tell the order of exposures.
        """
        people: dict[str, list[int]] = defaultdict(list)
        for row in self._table.rows:
            if self._context.participant is not None and row[column].isdecimal():
                people[row[self._context.participant]].append(int(row[column]))
        gaps = sum(max(said) - min(said) >= len({*said}) for said in people.values())
        if self._answers.row_keys:  # each answer has its own row
            return bool(people) and all(len({*said}) == len(said) for said in people.values())
        return bool(self._roles.facts["timepoint"]) and gaps * 2 > len(people)

    def _is_key_of_rows(self, fact: str, column: int) -> bool:
        """Return whether a column has another text in each row, as codes of web sessions are."""
        words = texts(self._table, column)
        each_row = len(words) == len(self._table.rows) > _FEWEST_ROWS
        return fact == "session" and each_row and not is_numeric(self._table, column)

    def _exposures_of_rows(self, fact: str, column: int) -> None:
        """Count exposures: the number of a row, which is ignored, is not that of each in it."""
        self._roles.metadata.append(column)
        self._context.columns[fact] = (column,)
        how = "exposures in the order of the rows, and in a row of the conditions"
        self.found.draft.put(fact, {"count": True}, how)
        question = f"{self.heading(column)!r} numbers rows of several conditions each. Do rows, and"
        question = f"{question} conditions in a row, stand in the order of time?"
        self.doubt(question, "they do; exposures are numbered so", ORDER)

    def _timepoint(self) -> None:
        if "timepoint" in self._answers.said or "timepoint" in self._context.columns:
            return
        facts, roles = self._roles.facts, self._roles
        columns = (*facts["timepoint"], *roles.unknown, *facts["condition"], *roles.metadata)
        found = candidates("timepoint", columns, self._context)
        if "timepoint" in self._named:  # names of files say it better than guesses do
            found = [each for each in found if each.evidence not in _GUESSED_TIMEPOINTS]
        if found and found[0].evidence is BASELINE_AMONG_CONDITIONS:
            self._mixed(found[0].column)
        elif found and found[0].evidence is OTHER_TIMEPOINTS:
            self._other_timepoints(found[0].column)
        elif found:
            self._known_timepoints(found[0].column)
        elif "timepoint" in self._named:
            words = [text for text in self._named["timepoint"] if text]
            moments = self._vocabulary.moments(words)
            values = {text: moments[text] or text for text in words}
            if "" in self._named["timepoint"]:
                values[""] = "post" if "baseline" in values.values() else "baseline"
            self.found.draft.put("timepoint", {"values": values})
        elif self._answers.answered:
            comment = "nothing says when it was asked: after exposure"
            self.found.draft.put("timepoint", {"constant": "post"}, comment)

    def _known_timepoints(self, column: int) -> None:
        meant = {w: self._table.meaning(column, w) for w in texts(self._table, column)}
        moments = self._vocabulary.moments([*meant.values()])
        said = {word: moments[meaning] for word, meaning in meant.items()}
        # Two words for after exposure, such as "after" and "after 15 min", are two moments.
        after = sorted((word for word, when in said.items() if when == "post"), key=len)
        if len(after) == _MOMENTS_AFTER and "recovery" not in said.values():
            people = [self._people_with(column, word) for word in after]
            said |= {after[1]: "recovery"} if people[0] & people[1] else {}
        self.use("timepoint", column, values=said)
        if len(set(said.values())) < len(said) or len(after) > 1:
            shown = ", ".join(f"{a} is {b}" for a, b in said.items())
            self.doubt("Are these timepoints right?", shown, TIMEPOINTS)

    def _people_with(self, column: int, text: str) -> set[str]:
        who = self._context.participant
        return {row[who] for row in self._table.rows if who is not None and row[column] == text}

    def _other_timepoints(self, column: int) -> None:
        """Take texts such as T0 and T1 for timepoints in their alphabetical order, and ask."""
        ordered = sorted(texts(self._table, column))
        names = ["baseline", "post", "recovery", "later_4", "later_5"]
        values = dict(zip(ordered, names, strict=False))
        known = {text: self._vocabulary.timepoint(text) for text in ordered}
        if {"baseline", "post"} <= {*known.values()}:  # the others have their own names
            values = {text: when or text for text, when in known.items()}
        self.use("timepoint", column, values=values)
        shown = ", ".join(f"{a} {b}" for a, b in values.items())
        self.doubt(f"Which timepoints are {', '.join(ordered)}?", shown, TIMEPOINTS)

    def _mixed(self, column: int) -> None:
        """Take both the timepoint and the condition from one column."""
        words = texts(self._table, column)
        when = {word: self._vocabulary.timepoint(word) or "post" for word in words}
        what = {word: "" if when[word] == "baseline" else word for word in words}
        self.use("timepoint", column, values=when)
        self.use("condition", column, values=what)
        before = ", ".join(repr(word) for word in words if when[word] == "baseline")
        question = f"Is {before} in {self.heading(column)!r} before exposure, of no condition?"
        self.doubt(question, "it is; the others are conditions, asked after exposure", TIMEPOINTS)

    def _covariates(self) -> None:
        who = self._context.participant
        if who is None and "participant" in self._named:
            return
        for name, column in [*self._roles.covariates.items()]:
            if column in self._context.used:
                continue
            if who is None or not self._varies(column):
                self._context.covariates[name] = column
                self._context.used.add(column)
            elif is_shown_in_turn(self._table, column, who):
                # glasses, of which each person wears two, or how well each was seen
                self._roles.unknown.append(column)
                del self._roles.covariates[name]
            else:
                self._varying.append(column)
        for column, _ in candidates("covariate", self._roles.unknown, self._context):
            there = self._context.covariates
            there[free_name(covariate_name(self.heading(column)), there)] = column
            self._context.used.add(column)
