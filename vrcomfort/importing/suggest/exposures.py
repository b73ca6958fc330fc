"""Drafts where the participant, the condition and the moment come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from vrcomfort.importing.headings import is_number
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.draft import Doubt, Draft
from vrcomfort.importing.suggest.file_names import parts_of_names
from vrcomfort.importing.suggest.roles import (
    MOST_CONDITIONS,
    Roles,
    few_texts,
    is_numeric,
    texts,
    timepoint,
    varies_within,
)


@dataclass(frozen=True)
class Exposures:
    """What is known of a table when its facts are looked for.

    Parameters
    ----------
    said
        Facts that the headings of the answers say.
    taken
        Columns of answers.
    one_row_each
        A row is a person or a questionnaire, and not an answer.
    row_keys
        Columns that tell the rows of one questionnaire apart.
    time
        The column of the seconds of ratings.
    """

    table: SourceTable
    tables: Sequence[SourceTable]
    roles: Roles
    said: set[str]
    taken: set[int]
    one_row_each: bool
    row_keys: Sequence[int]
    answered: bool
    time: int | None


@dataclass
class DraftedFacts:
    """Where the facts come from.

    Parameters
    ----------
    participant
        The column of the participants, if there is one.
    used
        Columns that are taken.
    unused
        Columns that were looked at, and are not.
    """

    draft: Draft = field(default_factory=Draft)
    doubts: list[Doubt] = field(default_factory=list)
    participant: int | None = None
    used: set[int] = field(default_factory=set)
    unused: list[int] = field(default_factory=list)
    covariates: dict[str, int] = field(default_factory=dict)
    columns: dict[str, tuple[int, ...]] = field(default_factory=dict)


def draft_facts(known: Exposures) -> DraftedFacts:
    """Draft every fact that the headings of the answers do not say."""
    return _Facts(known).found


class _Facts:
    def __init__(self, known: Exposures) -> None:
        self._known = known
        self._table = known.table
        self._roles = known.roles
        self.found = DraftedFacts()
        self._named: dict[str, list[str]] = {}
        self._varying: list[int] = []
        self._participant_column()
        self._order()
        self._names_of_files()
        self._participant()
        if known.time is not None:
            self.found.used.add(known.time)
        for fact in ("session", "period", "block", "trial", "scene"):
            self._plain_fact(fact)
        self._timepoint()
        self._covariates()
        if known.answered:
            self._condition()
            self._repetitions()
        for column in self._varying:
            if column not in self.found.used:
                question = f"Why has somebody more than one {self._heading(column)!r}?"
                self._doubt(question, "it is ignored")
        self.found.unused += [
            column
            for columns in self._roles.facts.values()
            for column in columns
            if column not in self.found.used
        ]
        self.found.unused += [
            c for c in self._roles.covariates.values() if c not in self.found.used
        ]

    def _heading(self, column: int) -> str:
        return self._table.headings[column]

    def _use(self, fact: str, column: int, comment: str = "", **more: object) -> None:
        self.found.used.add(column)
        self.found.columns[fact] = (column,)
        self.found.draft.put(fact, {"column": self._heading(column), **more}, comment)

    def _doubt(self, question: str, assumed: str) -> None:
        self.found.doubts.append(Doubt(question, assumed))

    def _participant_column(self) -> None:
        columns = self._roles.facts.get("participant", [])
        columns = [c for c in columns if len(texts(self._table, c)) > 1] or columns
        if columns:
            self.found.participant = columns[0]
            columns = [c for c in columns if c in self._roles.alike["participant"]]
            if len(columns) > 1:
                names = ", ".join(repr(self._heading(c)) for c in columns)
                question = f"Which of the columns {names} tells participants apart?"
                self._doubt(question, f"`{self._heading(columns[0])}`")

    def _order(self) -> None:
        """Take an order that differs within somebody for the number of the exposure."""
        column = self._roles.covariates.get("sequence")
        who = self.found.participant
        if column is None or who is None or not is_numeric(self._table, column):
            return
        if varies_within(self._table, column, who):
            del self._roles.covariates["sequence"]
            self._roles.facts["trial"].append(column)
            question = f"Is {self._heading(column)!r} the place of an exposure in its order?"
            self._doubt(question, "it is, from 1")

    def _names_of_files(self) -> None:
        """Take what differs between the names of sheets, or of files."""
        known = self._known
        wanted = [] if self.found.participant is not None else ["participant"]
        wanted += (
            [] if "condition" in known.said or self._roles.facts.get("condition") else ["condition"]
        )
        if "timepoint" not in known.said and not self._roles.facts.get("timepoint"):
            wanted.append("timepoint")
        if not self._roles.facts.get("session"):
            wanted.append("session")
        sheets = list(dict.fromkeys(table.sheet for table in known.tables))
        stems = list(dict.fromkeys(t.file.name.removesuffix(t.file.suffix) for t in known.tables))
        ways = (("sheet_name", sheets, "sheets"), ("file_name", stems, "files"))
        for key, names, what in ways:
            left = [fact for fact in wanted if fact not in self._named]
            parts = parts_of_names(names, left) if len(names) > 1 else None
            if parts is None:
                continue
            self.found.draft.put(key, parts.template)
            self._named |= parts.texts
            shown = ", ".join(names[:3]) + (" …" if len(names) > 3 else "")
            said = "; ".join(f"{f}: {', '.join(t[:6])}" for f, t in parts.texts.items())
            self._doubt(f"Do the names of the {what} ({shown}) say this?", said)

    def _participant(self) -> None:
        column = self.found.participant
        if "participant" in self._named:
            return
        if column is None:
            column = self._likely_participant()
        if column is not None:
            self.found.participant = column
            self._use("participant", column)
            return
        self.found.draft.put("participant", {"count": True}, "the number of the row")
        self._doubt("No column tells participants apart: is each row another person?", "it is")

    def _likely_participant(self) -> int | None:
        """Return a column without a telling name that holds a different text for each person."""
        rows = len(self._table.rows)
        for column in self._roles.unknown[:4]:
            words = texts(self._table, column)
            whole = len(words) == rows or (
                not self._known.one_row_each and 1 < len(words) <= rows / 4
            )
            reading = self._table.reading
            repeated = not reading.heading_rows and len(words) * 4 >= rows
            repeated = repeated or (reading.transpose and column == 0 and len(words) > 1)
            if words and all(timepoint(word) for word in words):
                continue
            if (whole or repeated) and max(map(len, words), default=99) <= 24:
                heading = self._heading(column)
                self._doubt(f"Does {heading!r} tell participants apart?", "it does")
                self._roles.unknown.remove(column)
                return column
        return None

    def _plain_fact(self, fact: str) -> None:
        columns = [c for c in self._roles.facts.get(fact, []) if texts(self._table, c)]
        if not columns or fact in self._known.said:
            return
        column = columns[0]
        numbers = fact in {"session", "trial", "period", "block"}
        if numbers and not is_numeric(self._table, column):
            what = "numbered in the order of the rows"
            self._use(fact, column, what, count=True)
            question = (
                f"Are the texts of {self._heading(column)!r} {fact}s, in the order of the rows?"
            )
            self._doubt(question, f"they are, {what}")
        else:
            self._use(fact, column)

    def _timepoint(self) -> None:
        columns = self._roles.facts.get("timepoint", [])
        if "timepoint" in self._known.said:
            return
        for column in (*columns, *self._roles.unknown):
            words = texts(self._table, column)
            said = {word: timepoint(word) for word in words}
            named = column in columns
            if (
                1 <= len(words) <= 8
                and all(said.values())
                and (named or len(set(said.values())) > 1)
            ):
                self._use("timepoint", column, values=said)
                if len(set(said.values())) < len(words):
                    shown = ", ".join(f"{a} is {b}" for a, b in said.items())
                    self._doubt("Are these moments right, though two are one?", shown)
                return
        conditions = self._roles.facts.get("condition", [])
        for column in (*columns, *conditions):
            if self._is_mixed(column):
                self._mixed(column)
                return
        for column in columns:
            words = texts(self._table, column)
            if 1 < len(words) <= 5 and column not in self.found.used:
                ordered = sorted(words)
                values = dict(
                    zip(
                        ordered,
                        ["baseline", "post", "recovery", "later_4", "later_5"],
                        strict=False,
                    )
                )
                self._use("timepoint", column, values=values)
                shown = ", ".join(f"{a} {b}" for a, b in values.items())
                self._doubt(f"Which moments are {', '.join(ordered)}?", shown)
                return
        if "timepoint" in self._named:
            values = {text: timepoint(text) or text for text in self._named["timepoint"]}
            self.found.draft.put("timepoint", {"values": values})
        elif self._known.answered:
            comment = "nothing says when it was asked: after exposure"
            self.found.draft.put("timepoint", {"constant": "post"}, comment)

    def _is_mixed(self, column: int) -> bool:
        """Return whether some texts of a column mean before exposure, and others conditions."""
        said = [timepoint(word) for word in texts(self._table, column)]
        mixed = "baseline" in said and None in said and len(said) <= MOST_CONDITIONS
        return mixed and self._known.time is None  # ratings are given during exposure

    def _mixed(self, column: int) -> None:
        """Take both the timepoint and the condition from one column."""
        words = texts(self._table, column)
        when = {word: timepoint(word) or "post" for word in words}
        what = {word: "" if timepoint(word) == "baseline" else word for word in words}
        self._use("timepoint", column, values=when)
        self._use("condition", column, values=what)
        before = ", ".join(repr(word) for word in words if when[word] == "baseline")
        question = f"Is {before} in {self._heading(column)!r} before exposure, of no condition?"
        self._doubt(question, "it is; the others are conditions, asked after exposure")

    def _covariates(self) -> None:
        who = self.found.participant
        if who is None and "participant" in self._named:
            return
        for name, column in self._roles.covariates.items():
            if column in self.found.used:
                continue
            if who is None or not varies_within(self._table, column, who):
                self.found.covariates[name] = column
                self.found.used.add(column)
            else:
                self._varying.append(column)
        if who is None or len(texts(self._table, who)) * 2 > len(self._table.rows):
            return  # in one row each, everything is constant
        for column in self._roles.unknown:
            words = texts(self._table, column)
            known = len(words) > 1 and not varies_within(self._table, column, who)
            if known and (is_numeric(self._table, column) or few_texts(self._table, column)):
                self.found.covariates[_word(self._heading(column))] = column
                self.found.used.add(column)

    def _condition(self) -> None:
        if "condition" in self._known.said or "condition" in self.found.columns:
            return
        columns = self._roles.facts.get("condition", [])
        columns = [c for c in columns if texts(self._table, c)]
        if "condition" in self._named and not columns:
            return
        if len(columns) == 1:
            self._use("condition", columns[0])
            if len(texts(self._table, columns[0])) == 1:
                self.found.draft.note("one condition alone", "condition")
        elif columns:
            self._several_conditions(columns)
        else:
            self._guess_condition()

    def _several_conditions(self, columns: list[int]) -> None:
        names = ", ".join(repr(self._heading(c)) for c in columns)
        within = [c for c in columns if varies_within(self._table, c, self.found.participant)]
        chosen = within or columns[:1]
        if len(chosen) == 1:
            self._use("condition", chosen[0])
            self._doubt(f"Which of {names} is the condition?", repr(self._heading(chosen[0])))
        else:
            self._join_condition(chosen)
            self._doubt(f"Are conditions made of {names} together?", "they are, joined by _")

    def _join_condition(self, columns: Sequence[int]) -> None:
        self.found.used |= set(columns)
        self.found.columns["condition"] = tuple(columns)
        names = [self._heading(c) for c in columns]
        joined = ["_".join(row[c] for c in columns) for row in self._table.rows]
        values = {text: text for text in dict.fromkeys(joined) if all(text.split("_"))}
        self.found.draft.put("condition", {"columns": names, "values": values})

    def _guess_condition(self) -> None:
        """Take a column that varies within participants for the condition, and ask."""
        who, table = self.found.participant, self._table
        counted = [
            self.found.columns[fact][0]
            for fact in ("trial", "session", "period")
            if fact in self.found.columns
        ]
        group = self.found.covariates.get("group", self.found.covariates.get("sequence"))
        open_columns = [
            c
            for c in (*self._roles.unknown, *self._roles.facts.get("scene", []))
            if few_texts(table, c) and c not in self.found.used and not _all_one_each(table, c)
        ]
        within = [c for c in open_columns if who is not None and varies_within(table, c, who)]
        text_first = sorted(within, key=lambda c: is_numeric(table, c))
        if text_first:
            column = text_first[0]
            self._use("condition", column)
            if column in self._roles.unknown:
                self._roles.unknown.remove(column)
            self._doubt(f"Is {self._heading(column)!r} the condition?", "it is")
        elif (
            group is not None
            and counted
            and who is not None
            and varies_within(table, counted[0], who)
        ):
            self._join_condition([group, counted[0]])
            self.found.covariates.setdefault("sequence", group)
            if self._letters(group, counted[0]):
                return
            a, b = self._heading(group), self._heading(counted[0])
            question = f"Which condition did each {a} have in each {b} (a crossover)?"
            assumed = (
                "each combination is a condition of its own; under values, give those that are one "
                "condition one name"
            )
            self._doubt(question, assumed)
        elif counted and who is not None and varies_within(table, counted[0], who):
            column = counted[0]
            self.found.draft.put("condition", {"column": self._heading(column)})
            self._doubt(
                f"Is {self._heading(column)!r} the condition?", "it is, for want of another"
            )
        elif group is not None:
            self.found.draft.put("condition", {"column": self._heading(group)})
            question = f"Is {self._heading(group)!r} the condition, between participants?"
            self._doubt(question, "it is")
        else:
            self.found.draft.put("condition", {"constant": "all"})
            self._doubt("No column says the condition: was there but one?", "one, called `all`")

    def _letters(self, sequence: int, number: int) -> bool:
        """Take letters of sequences such as AB for the conditions, in their order."""
        orders, numbers = texts(self._table, sequence), sorted(texts(self._table, number))
        alike = {tuple(sorted(order)) for order in orders}
        if len(alike) != 1 or any(len(order) != len(numbers) > 1 for order in orders):
            return False
        if len(numbers) < 2:
            return False
        values = {f"{o}_{n}": letter for o in orders for n, letter in zip(numbers, o, strict=True)}
        names = [self._heading(sequence), self._heading(number)]
        self.found.draft.put("condition", {"columns": names, "values": values})
        a, b = names
        question = f"Does {a!r} name the conditions in the order of {b!r}?"
        self._doubt(question, ", ".join(f"{key} is {value}" for key, value in values.items()))
        return True

    def _repetitions(self) -> None:
        """Have exposures numbered where somebody has one condition and moment twice."""
        if self._known.time is not None and "trial" not in self.found.columns:
            runs = [c for c in self._roles.unknown if len(texts(self._table, c)) > 1]
            runs = [c for c in runs if varies_within(self._table, c, self.found.participant)]
            if runs:
                self._use("trial", runs[0], count=True)
                self._doubt(f"Does {self._heading(runs[0])!r} tell exposures apart?", "it does")
                return
        if "trial" in self.found.columns or self.found.participant is None:
            return
        if self._known.time is not None:
            return
        keys = [self.found.participant, *self._known.row_keys]
        keys += [c for columns in self.found.columns.values() for c in columns]
        seen: set[tuple[str, ...]] = set()
        for table in self._known.tables:
            for row in table.rows:
                if not any(row[column] for column in self._known.taken):
                    continue
                key = (table.file.name, table.sheet, *(row[c] for c in dict.fromkeys(keys)))
                if key in seen and row[self.found.participant]:
                    self._count_exposures()
                    return
                seen.add(key)

    def _count_exposures(self) -> None:
        self.found.draft.put("trial", {"count": True}, "exposures in the order of the rows")
        question = "Somebody has one condition more than once: do rows stand in the order of time?"
        self._doubt(question, "they do; exposures are numbered in the order of the rows")


def _all_one_each(table: SourceTable, column: int) -> bool:
    """Return whether a column counts its rows, or holds long texts, as no condition does."""
    words = texts(table, column)
    return any(len(word) > 40 for word in words) or (
        all(map(is_number, words)) and any("." in word or "," in word for word in words)
    )


def _word(heading: str) -> str:
    """Return a name for a column of participants.csv."""
    return "_".join("".join(c if c.isalnum() else " " for c in heading.casefold()).split()) or "x"
