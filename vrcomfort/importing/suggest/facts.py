"""Drafts where the participant, the condition and the timepoint come from."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import SequenceMatcher
from itertools import combinations

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.draft import (
    CONDITIONS,
    CURIOUS,
    NAMES_OF_FILES,
    ORDER,
    PEOPLE,
    SAME_CONDITION,
    TIMEPOINTS,
    OpenDoubt,
    Stake,
    TomlDraft,
)
from vrcomfort.importing.suggest.evidence import (
    BASELINE_AMONG_CONDITIONS,
    COUNTS_EXPOSURES,
    GROUPS_PEOPLE,
    MOST_CONDITIONS,
    OTHER_TIMEPOINTS,
    Candidate,
    Context,
    candidates,
    is_numeric,
    texts,
    varies_within,
)
from vrcomfort.importing.suggest.vocabulary import LabVocabulary
from vrcomfort.questionnaire import plain
from vrcomfort.settings import toml_value

_GUESSED_TIMEPOINTS = (BASELINE_AMONG_CONDITIONS, OTHER_TIMEPOINTS)
_STAKES = {"participant": PEOPLE, "condition": CONDITIONS, "timepoint": TIMEPOINTS, "trial": ORDER}
_PART = re.compile(r"([_\-\s.]+)")
MOST_NAMED = 5
_FEWEST_ROWS = 3
LONG_WORD, NEAR, RARER = 6, 0.85, 2
"""Letters in which a misspelling shows, how alike the two words are, and how much rarer one is."""


@dataclass
class DraftedFacts:
    """Where the facts come from.

    Parameters
    ----------
    context
        The decisions on columns.
    unused
        Columns with a heading for a fact that were not taken.
    """

    context: Context
    draft: TomlDraft = field(default_factory=TomlDraft)
    doubts: list[OpenDoubt] = field(default_factory=list)
    unused: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class AnswersFound:
    """The answers of a table, as far as its facts depend on them.

    Parameters
    ----------
    tables
        The single tables, of which the drafted one is made.
    said
        Facts that the headings of the answers say.
    taken
        Columns of answers.
    row_keys
        Columns that tell the rows of one questionnaire apart.
    answered
        Whether there are any.
    """

    tables: Sequence[SourceTable]
    said: set[str]
    taken: set[int]
    row_keys: Sequence[int]
    answered: bool


class FactDraft:
    """Writes down where facts come from; several of them write into one draft."""

    def __init__(
        self, answers: AnswersFound, found: DraftedFacts, named: dict[str, list[str]]
    ) -> None:
        self._answers = answers
        self._context = found.context
        self._table = found.context.table
        self._roles = found.context.roles
        self._vocabulary = found.context.vocabulary
        self._named = named
        self.found = found

    def heading(self, column: int) -> str:
        """Return the heading of a column."""
        return self._table.headings[column]

    def use(self, fact: str, column: int, comment: str = "", **more: object) -> None:
        """Let a fact come from a column."""
        self._context.used.add(column)
        self._context.columns[fact] = (column,)
        self.found.draft.put(fact, {"column": self.heading(column), **more}, comment)

    def doubt(self, question: str, assumed: str, stake: Stake) -> None:
        """Add a question that the files leave open."""
        self.found.doubts.append(OpenDoubt(question, assumed, *stake))

    def doubt_of(self, found: Candidate) -> None:
        """Add the question that a piece of evidence leaves open."""
        question = found.evidence.question.format(heading=self.heading(found.column))
        self.doubt(question, found.evidence.assumed, _STAKES[found.evidence.role])


class Conditions(FactDraft):
    """Finds the condition, or asks."""

    def draft(self) -> None:
        """Draft where the condition comes from, and number repetitions."""
        self._condition()
        self._alike()
        self._repetitions()

    def _condition(self) -> None:
        if "condition" in self._answers.said or "condition" in self._context.columns:
            return
        columns = self._roles.facts.get("condition", [])
        columns = [c for c in columns if texts(self._table, c)]
        if "condition" in self._named and not columns:
            return
        if len(columns) == 1:
            self.use("condition", columns[0])
            if len(texts(self._table, columns[0])) == 1:
                self.found.draft.note("one condition alone", "condition")
        elif columns:
            self._several_conditions(columns)
        else:
            self._guess_condition()

    def _several_conditions(self, columns: list[int]) -> None:
        names = ", ".join(repr(self.heading(c)) for c in columns)
        within = [c for c in columns if varies_within(self._table, c, self._context.participant)]
        chosen = within or columns[:1]
        if len(chosen) == 1:
            self.use("condition", chosen[0])
            chosen_one = repr(self.heading(chosen[0]))
            self.doubt(f"Which of {names} is the condition?", chosen_one, CONDITIONS)
        else:
            self._join_condition(chosen)
            self.doubt(
                f"Are conditions made of {names} together?", "they are, joined by _", CONDITIONS
            )

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
        decided = [c for columns in context.columns.values() for c in columns]
        decided += context.covariates.values()
        columns = (*self._roles.unknown, *self._roles.facts["scene"], *decided)
        found = candidates("condition", columns, context)
        if not found:
            self.found.draft.put("condition", {"constant": "all"})
            question = "No column says the condition: was there but one?"
            self.doubt(question, "one, called `all`", CONDITIONS)
        elif found[0].evidence is COUNTS_EXPOSURES and found[-1].evidence is GROUPS_PEOPLE:
            self._crossover(found[-1].column, found[0].column)
        elif found[0].column in decided:  # it keeps the role that it has
            self.found.draft.put("condition", {"column": self.heading(found[0].column)})
            self.doubt_of(found[0])
        else:
            self.use("condition", found[0].column)
            if found[0].column in self._roles.unknown:
                self._roles.unknown.remove(found[0].column)
            self.doubt_of(found[0])

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
        if len(alike) != 1 or any(len(order) != len(numbers) > 1 for order in orders):
            return False
        if len(numbers) < 2:
            return False
        values = {f"{o}_{n}": letter for o in orders for n, letter in zip(numbers, o, strict=True)}
        names = [self.heading(sequence), self.heading(number)]
        self.found.draft.put("condition", {"columns": names, "values": values})
        a, b = names
        question = f"Does {a!r} name the conditions in the order of {b!r}?"
        shown = ", ".join(f"{key} is {value}" for key, value in values.items())
        self.doubt(question, shown, CONDITIONS)
        return True

    def _repetitions(self) -> None:
        """Draft a count of exposures where a participant has a condition at a timepoint twice."""
        if "trial" in self._context.columns:
            return
        if runs := candidates("trial", self._roles.unknown, self._context):
            self.use("trial", runs[0].column, count=True)
            self.doubt_of(runs[0])
        if self._context.participant is None or self._context.time is not None:
            return  # ratings of one exposure are many rows of one condition
        keys = [self._context.participant, *self._answers.row_keys]
        keys += [c for columns in self._context.columns.values() for c in columns]
        seen: dict[tuple[str, ...], tuple[int, tuple[str, ...]]] = {}
        again: dict[str, list[str]] = {}
        for table in self._answers.tables:
            for number, row in zip(table.numbers, table.rows, strict=True):
                if not any(row[column] for column in self._answers.taken):
                    continue
                key = (table.file.name, table.sheet, *(row[c] for c in dict.fromkeys(keys)))
                who = row[self._context.participant]
                if key in seen and who:
                    first, cells = seen[key]
                    same = [f"row {number} is the same as row {first}"] if cells == row else []
                    again.setdefault(who, []).extend(same)
                seen.setdefault(key, (number, row))
        if again:
            self._count_exposures(again)

    def _count_exposures(self, again: Mapping[str, Sequence[str]]) -> None:
        """Draft a count of exposures, and ask; `again`: participants with several → equal rows."""
        self.found.draft.put("trial", {"count": True}, "exposures in the order of the rows")
        people = ", ".join([*again][:MOST_NAMED])
        more = f" and {len(again) - MOST_NAMED} more" if len(again) > MOST_NAMED else ""
        columns = " (and conditions in a row)" if "condition" in self._answers.said else ""
        question = f"One condition more than once: {people}{more}. Do rows{columns} stand in the "
        assumed = "they do; exposures are numbered so"
        same = [each for found in again.values() for each in found]
        if same:
            assumed += f" (but {same[0]}: leave it out of the file if it was saved twice)"
        self.doubt(f"{question}order of time?", assumed, ORDER)

    def _alike(self) -> None:
        """Ask whether words for conditions that are nearly the same are one."""
        column = self._context.columns.get("condition", ())
        cells = self._table.column(column[0]) if len(column) == 1 else ()
        counts = Counter(filter(None, cells))
        few = len(counts) <= MOST_CONDITIONS
        pairs = [
            sorted(pair, key=lambda word: -counts[word])
            for pair in (combinations(counts, 2) if few else ())
            if _are_alike(counts, *pair)
        ]
        if pairs:
            shown = "; ".join(f"{usual!r} and {rare!r}" for usual, rare in pairs)
            one = {word: word for word in counts} | {rare: usual for usual, rare in pairs}
            said = "they are not; `values` of condition make them one: "
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


def draft_facts(context: Context, answers: AnswersFound) -> DraftedFacts:
    """Draft every fact that the headings of the answers do not say."""
    return _Facts(context, answers).found


class _Facts(FactDraft):
    def __init__(self, context: Context, answers: AnswersFound) -> None:
        super().__init__(answers, DraftedFacts(context), {})
        self._varying: list[int] = []
        self._participant_column()
        self._order()
        self._names_of_files()
        self._participant()
        if context.time is not None:
            context.used.add(context.time)
        for fact in ("session", "period", "block", "trial"):
            self._plain_fact(fact)
        if self._condition_is_named() or not answers.answered:
            self._plain_fact("scene")
        self._timepoint()
        self._covariates()
        if answers.answered:
            Conditions(answers, self.found, self._named).draft()
            if "scene" not in self._context.columns:
                self._plain_fact("scene")
        for column in self._varying:
            if column not in self._context.used:
                question = f"Why has a participant more than one {self.heading(column)!r}?"
                self.doubt(question, "it is ignored", CURIOUS)
        self.found.unused += [
            column
            for columns in self._roles.facts.values()
            for column in columns
            if column not in self._context.used
        ]
        self.found.unused += [
            c for c in self._roles.covariates.values() if c not in self._context.used
        ]

    def _condition_is_named(self) -> bool:
        """Return whether headings, names of files or a column say the condition."""
        columns = self._roles.facts.get("condition", [])
        named = "condition" in self._answers.said or "condition" in self._named
        return named or any(texts(self._table, column) for column in columns)

    def _participant_column(self) -> None:
        columns = self._roles.facts.get("participant", [])
        columns = [c for c in columns if len(texts(self._table, c)) > 1] or columns
        columns = [c for c in columns if not self._has_codes(c)] or columns
        if columns:
            self._context.participant = columns[0]
            columns = [c for c in columns if c in self._roles.alike["participant"]]
            if len(columns) > 1:
                names = ", ".join(repr(self.heading(c)) for c in columns)
                question = f"Which of the columns {names} tells participants apart?"
                self.doubt(question, f"`{self.heading(columns[0])}`", PEOPLE)

    def _has_codes(self, column: int) -> bool:
        """Return whether a column has codes of missing values, such as -66, in place of people."""
        return any(
            re.fullmatch(r"-\d+", text) or text.casefold() in self._vocabulary.missing
            for text in texts(self._table, column)
        )

    def _order(self) -> None:
        """Take an order that differs within participants for the number of the exposure."""
        for found in candidates("trial", [*self._roles.covariates.values()], self._context):
            del self._roles.covariates["sequence"]
            self._roles.facts["trial"].append(found.column)
            self.doubt_of(found)

    def _names_of_files(self) -> None:
        """Take facts from the names of sheets, or of files."""
        answers = self._answers
        wanted = [] if self._context.participant is not None else ["participant"]
        wanted += (
            []
            if "condition" in answers.said or self._roles.facts.get("condition")
            else ["condition"]
        )
        if "timepoint" not in answers.said and not self._roles.facts.get("timepoint"):
            wanted.append("timepoint")
        if not self._roles.facts.get("session"):
            wanted.append("session")
        sheets = list(dict.fromkeys(table.sheet for table in answers.tables))
        stems = list(dict.fromkeys(t.file.name.removesuffix(t.file.suffix) for t in answers.tables))
        ways = (("sheet_name", sheets, "sheets"), ("file_name", stems, "files"))
        for key, names, what in ways:
            left = [fact for fact in wanted if fact not in self._named]
            parts = parts_of_names(names, left, self._vocabulary) if len(names) > 1 else None
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

    def _participant(self) -> None:
        column = self._context.participant
        if "participant" in self._named:
            return
        if column is None:
            columns = (*self._roles.unknown, *self._roles.metadata)
            for found in candidates("participant", columns, self._context)[:1]:
                column = found.column
                self.doubt_of(found)
                if column in self._roles.unknown:
                    self._roles.unknown.remove(column)
        if column is not None:
            self._context.participant = column
            self.use("participant", column)
            return
        self.found.draft.put("participant", {"count": True}, "the number of the row")
        self.doubt(
            "No column tells participants apart: is each row another person?", "it is", PEOPLE
        )

    def _plain_fact(self, fact: str) -> None:
        columns = [c for c in self._roles.facts.get(fact, []) if texts(self._table, c)]
        if not columns or fact in self._answers.said:
            return
        column = next((c for c in columns if c not in self._context.used), None)
        if column is None:
            return
        if self._is_key_of_rows(fact, column):
            self._roles.metadata.append(column)
            return
        if fact == "block" and not is_numeric(self._table, column) and not self._has_condition():
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

    def _has_condition(self) -> bool:
        return "condition" in self._context.columns or self._condition_is_named()

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
        self.doubt(
            f"{question} conditions in a row, stand in the order of time?",
            "they do; exposures are numbered so",
            ORDER,
        )

    def _timepoint(self) -> None:
        if "timepoint" in self._answers.said:
            return
        facts = self._roles.facts
        columns = (*facts["timepoint"], *self._roles.unknown, *facts["condition"])
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
            timepoint = self._vocabulary.timepoint
            words = [text for text in self._named["timepoint"] if text]
            values = {text: timepoint(text) or text for text in words}
            if "" in self._named["timepoint"]:
                values[""] = "post" if "baseline" in values.values() else "baseline"
            self.found.draft.put("timepoint", {"values": values})
        elif self._answers.answered:
            comment = "nothing says when it was asked: after exposure"
            self.found.draft.put("timepoint", {"constant": "post"}, comment)

    def _known_timepoints(self, column: int) -> None:
        said = {word: self._vocabulary.timepoint(word) for word in texts(self._table, column)}
        self.use("timepoint", column, values=said)
        if len(set(said.values())) < len(said):
            shown = ", ".join(f"{a} is {b}" for a, b in said.items())
            self.doubt("Are these timepoints right, though two are one?", shown, TIMEPOINTS)

    def _other_timepoints(self, column: int) -> None:
        """Take texts such as T0 and T1 for timepoints in their alphabetical order, and ask."""
        ordered = sorted(texts(self._table, column))
        names = ["baseline", "post", "recovery", "later_4", "later_5"]
        values = dict(zip(ordered, names, strict=False))
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
        for name, column in self._roles.covariates.items():
            if column in self._context.used:
                continue
            if who is None or not varies_within(self._table, column, who):
                self._context.covariates[name] = column
                self._context.used.add(column)
            else:
                self._varying.append(column)
        for column, _ in candidates("covariate", self._roles.unknown, self._context):
            self._context.covariates[_word(self.heading(column))] = column
            self._context.used.add(column)


def _word(heading: str) -> str:
    """Return a name for a column of participants.csv."""
    return "_".join("".join(c if c.isalnum() else " " for c in heading.casefold()).split()) or "x"


@dataclass(frozen=True)
class NameParts:
    """How names are made.

    Parameters
    ----------
    template
        With ``{condition}`` and the like where they differ, or a regular expression.
    texts
        Fact → the different texts that stand for it; ``""`` where names lack a word.
    expression
        Whether it is a regular expression.
    """

    template: str
    texts: dict[str, list[str]]
    expression: bool = False


def parts_of_names(
    names: Sequence[str], wanted: Sequence[str], vocabulary: LabVocabulary
) -> NameParts | None:
    """Return the parts that differ between names, as facts; None where none differs.

    Timepoints are known by their words, sessions by theirs; of the rest, what differs most is
    the participant, where that is wanted.
    """
    split = [_PART.split(name) for name in names]
    if len(set(names)) < 2 or not wanted:
        return None
    if len({tuple(parts[1::2]) for parts in split}) > 1:  # made in different ways
        return _optional(names, wanted, vocabulary) or _whole(names, wanted)
    columns = list(zip(*split, strict=True))
    differing = [i for i in range(0, len(columns), 2) if len(set(columns[i])) > 1]
    left = list(wanted)
    roles: dict[int, str] = {}
    for i in differing:
        if "timepoint" in left and all(vocabulary.timepoint(text) for text in columns[i]):
            roles[i] = "timepoint"
            left.remove("timepoint")
    for i in differing:
        session = all(re.fullmatch(r"(?i)(ses(sion)?|s|day|visit)\d+", t) for t in columns[i])
        if i not in roles and session and "session" in left and len(differing) > 1:
            roles[i] = "session"
            left.remove("session")
    rest = [i for i in differing if i not in roles]
    if "participant" in left and rest:
        most = max(rest, key=lambda i: len(set(columns[i])))
        roles[most] = "participant"
        left.remove("participant")
        rest.remove(most)
    if "condition" in left and rest:
        roles[rest[0]] = "condition"
        rest = rest[1:]
    return _made(columns, roles)


def _optional(
    names: Sequence[str], wanted: Sequence[str], vocabulary: LabVocabulary
) -> NameParts | None:
    """Return how names are made of which some have a word that others lack: ``P01_SSQ[_PRE]``.

    Words that all names share are anchors; before the first one stands the participant, and after
    the last one words for the timepoint and for the condition.
    """
    split = [_PART.split(name)[::2] for name in names]
    anchors = [word for word in split[0] if all(words.count(word) == 1 for words in split)]
    if not anchors or {"participant", "condition", "timepoint"} - {*wanted}:
        return None
    first = [words.index(anchors[0]) for words in split]
    ends = [words[words.index(anchors[-1]) + 1 :] for words in split]
    middle = {tuple(w[w.index(anchors[0]) : w.index(anchors[-1]) + 1]) for w in split}
    if {*first} != {1} or len(middle) > 1 or max(map(len, ends)) > 2:
        return None
    rest = list(dict.fromkeys(word for words in ends for word in words))
    when = [word for word in rest if vocabulary.timepoint(word)]
    what = [word for word in rest if word not in when]
    texts: dict[str, list[str]] = {"participant": list(dict.fromkeys(w[0] for w in split))}
    slots = [("timepoint", when), ("condition", what)]
    if any(len(words) == 2 and words[0] in what for words in ends):
        slots.reverse()
    sign = r"[_\-\s.]+"
    pattern = rf"(?P<participant>[^_\-\s.]+){sign}" + sign.join(map(re.escape, min(middle)))
    for fact, words in slots:
        if words:
            pattern += rf"(?:{sign}(?P<{fact}>{'|'.join(map(re.escape, words))}))?"
            blank = [""] if any(not {*words} & {*each} for each in ends) else []
            texts[fact] = [*blank, *words]
    if not all(re.fullmatch(pattern, name) for name in names):
        return None
    return NameParts(pattern, texts, expression=True)


def _whole(names: Sequence[str], wanted: Sequence[str]) -> NameParts | None:
    fact = "condition" if "condition" in wanted else wanted[0]
    return NameParts(f"{{{fact}}}", {fact: list(dict.fromkeys(names))})


def _made(columns: Sequence[Sequence[str]], roles: dict[int, str]) -> NameParts | None:
    if not roles:
        return None
    parts = [
        f"{{{roles[i]}}}" if i in roles else column[0] if len(set(column)) == 1 else "{*}"
        for i, column in enumerate(columns)
    ]
    texts = {fact: list(dict.fromkeys(columns[i])) for i, fact in roles.items()}
    return NameParts("".join(parts), texts)
