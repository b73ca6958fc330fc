"""Drafts where the participant, the condition and the moment come from."""

from __future__ import annotations

import re

from vrcomfort.importing.suggest.conditions import Conditions
from vrcomfort.importing.suggest.fact_draft import DraftedFacts, Exposures, FactDraft
from vrcomfort.importing.suggest.file_names import parts_of_names
from vrcomfort.importing.suggest.roles import (
    MOST_CONDITIONS,
    few_texts,
    is_numeric,
    is_personal,
    texts,
    timepoint,
    varies_within,
)

LONGEST_CODE = 24
"""Letters of a participant's code at most."""


def draft_facts(known: Exposures) -> DraftedFacts:
    """Draft every fact that the headings of the answers do not say."""
    return _Facts(known).found


class _Facts(FactDraft):
    def __init__(self, known: Exposures) -> None:
        super().__init__(known, DraftedFacts(), {})
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
            Conditions(known, self.found, self._named).draft()
        for column in self._varying:
            if column not in self.found.used:
                question = f"Why has somebody more than one {self.heading(column)!r}?"
                self.doubt(question, "it is ignored")
        self.found.unused += [
            column
            for columns in self._roles.facts.values()
            for column in columns
            if column not in self.found.used
        ]
        self.found.unused += [
            c for c in self._roles.covariates.values() if c not in self.found.used
        ]

    def _participant_column(self) -> None:
        columns = self._roles.facts.get("participant", [])
        columns = [c for c in columns if len(texts(self._table, c)) > 1] or columns
        if columns:
            self.found.participant = columns[0]
            columns = [c for c in columns if c in self._roles.alike["participant"]]
            if len(columns) > 1:
                names = ", ".join(repr(self.heading(c)) for c in columns)
                question = f"Which of the columns {names} tells participants apart?"
                self.doubt(question, f"`{self.heading(columns[0])}`")

    def _order(self) -> None:
        """Take an order that differs within somebody for the number of the exposure."""
        column = self._roles.covariates.get("sequence")
        who = self.found.participant
        if column is None or who is None or not is_numeric(self._table, column):
            return
        if varies_within(self._table, column, who):
            del self._roles.covariates["sequence"]
            self._roles.facts["trial"].append(column)
            question = f"Is {self.heading(column)!r} the place of an exposure in its order?"
            self.doubt(question, "it is, from 1")

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
            self.doubt(f"Do the names of the {what} ({shown}) say this?", said)

    def _participant(self) -> None:
        column = self.found.participant
        if "participant" in self._named:
            return
        if column is None:
            column = self._likely_participant()
        if column is not None:
            self.found.participant = column
            self.use("participant", column)
            return
        self.found.draft.put("participant", {"count": True}, "the number of the row")
        self.doubt("No column tells participants apart: is each row another person?", "it is")

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
            if (whole or repeated) and max(map(len, words), default=99) <= LONGEST_CODE:
                heading = self.heading(column)
                self.doubt(f"Does {heading!r} tell participants apart?", "it does")
                self._roles.unknown.remove(column)
                return column
        return self._coded_name()

    def _coded_name(self) -> int | None:
        """Return a column that is called name and holds codes, such as s01."""
        for column in self._roles.metadata:
            words = texts(self._table, column)
            codes = all(
                re.fullmatch(r"[\w -]*\d[\w -]*", w) and len(w) <= LONGEST_CODE for w in words
            )
            if is_personal(self.heading(column)) and len(words) > 1 and codes:
                question = f"Does {self.heading(column)!r} tell participants apart?"
                self.doubt(question, "it does; it holds codes, no names of people")
                return column
        return None

    def _plain_fact(self, fact: str) -> None:
        columns = [c for c in self._roles.facts.get(fact, []) if texts(self._table, c)]
        if not columns or fact in self._known.said:
            return
        column = columns[0]
        if fact in {"trial", "period"} and "condition" in self._known.said:
            self._exposures_of_rows(fact, column)
            return
        numbers = fact in {"session", "trial", "period", "block"}
        if numbers and not is_numeric(self._table, column):
            what = "numbered in the order of the rows"
            self.use(fact, column, what, count=True)
            question = (
                f"Are the texts of {self.heading(column)!r} {fact}s, in the order of the rows?"
            )
            self.doubt(question, f"they are, {what}")
        else:
            self.use(fact, column)

    def _exposures_of_rows(self, fact: str, column: int) -> None:
        """Count exposures: the number of a row, which is ignored, is not that of each in it."""
        self._roles.metadata.append(column)
        self.found.columns[fact] = (column,)
        how = "exposures in the order of the rows, and in a row of the conditions"
        self.found.draft.put(fact, {"count": True}, how)
        question = f"{self.heading(column)!r} numbers rows of several conditions each. Do rows, and"
        self.doubt(
            f"{question} conditions in a row, stand in the order of time?",
            "they do; exposures are numbered so",
        )

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
                self.use("timepoint", column, values=said)
                if len(set(said.values())) < len(words):
                    shown = ", ".join(f"{a} is {b}" for a, b in said.items())
                    self.doubt("Are these moments right, though two are one?", shown)
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
                self.use("timepoint", column, values=values)
                shown = ", ".join(f"{a} {b}" for a, b in values.items())
                self.doubt(f"Which moments are {', '.join(ordered)}?", shown)
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
        self.use("timepoint", column, values=when)
        self.use("condition", column, values=what)
        before = ", ".join(repr(word) for word in words if when[word] == "baseline")
        question = f"Is {before} in {self.heading(column)!r} before exposure, of no condition?"
        self.doubt(question, "it is; the others are conditions, asked after exposure")

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
                self.found.covariates[_word(self.heading(column))] = column
                self.found.used.add(column)


def _word(heading: str) -> str:
    """Return a name for a column of participants.csv."""
    return "_".join("".join(c if c.isalnum() else " " for c in heading.casefold()).split()) or "x"
