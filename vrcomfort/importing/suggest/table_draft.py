"""Drafts the mapping of one table, or of several that are made alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vrcomfort.importing.rows import alike
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.draft import OpenDoubt, TomlDraft
from vrcomfort.importing.suggest.evidence import (
    Context,
    is_personal,
    roles_of,
    texts,
    total_rows,
)
from vrcomfort.importing.suggest.facts import AnswersFound, DraftedFacts, draft_facts
from vrcomfort.importing.suggest.items import Found, find_blocks
from vrcomfort.importing.suggest.layouts import (
    FoundRating,
    FoundScores,
    Long,
    courses_of,
    find_long,
    find_ratings,
    find_scores,
    kind_of,
)
from vrcomfort.importing.suggest.moments import moments, template_of
from vrcomfort.importing.suggest.questionnaires import (
    draft_block,
    draft_course,
    draft_long,
    draft_rating,
    leftovers,
    mend_items,
)
from vrcomfort.importing.suggest.vocabulary import Known, words_of
from vrcomfort.settings import toml_value


def _row_keys(longs: Sequence[Long]) -> list[int]:
    """Return the columns that tell the answers of one moment apart."""
    columns = [long.item_column for long in longs[:1]]
    return columns + [long.instrument_column[0] for long in longs[:1] if long.instrument_column]


class TableDraft:
    """The mapping of tables with the same headings.

    Parameters
    ----------
    tables
        The tables; the first one's reading is written down.
    known
        Instruments that may be meant, and the words of other labs' files.
    """

    def __init__(self, tables: Sequence[SourceTable], known: Known) -> None:
        self._tables = tables
        self._known = known
        self._vocabulary = known.vocabulary
        rows = tuple(row for table in tables for row in table.rows)
        self.table = replace(tables[0], rows=rows)
        self.draft = TomlDraft()
        self.doubts: list[OpenDoubt] = []
        self.labels: dict[str, str] = {}
        """Condition that headings say → how they write it."""
        self._totals = self._total_rows()
        self._fill_down()
        self.gives = False
        """Whether there is anything to import."""
        self._files()
        self._longs = find_long(self.table, known)
        self._blocks = [] if self._longs else find_blocks(self.table, known)
        taken = self._answer_columns()
        self._ratings = find_ratings(
            self.table, [c for c in self._columns() if c not in taken], known
        )
        taken |= {rating.column for rating in self._ratings}
        self._courses = courses_of(self._ratings)
        self._ratings = [r for r in self._ratings if r not in [x for c in self._courses for x in c]]
        self._scores = find_scores(
            self.table, [c for c in self._columns() if c not in taken], known
        )
        taken |= {c for each in self._scores for c in each.scales.values()}
        self._taken = taken
        self._roles = roles_of(
            self.table, [c for c in self._columns() if c not in taken], self._vocabulary
        )
        self._write()

    def _columns(self) -> range:
        return range(len(self.table.headings))

    def _answer_columns(self) -> set[int]:
        taken = {column for block in self._blocks for column in block.columns}
        for long in self._longs:
            taken |= {long.item_column, long.response_column}
            taken |= {long.instrument_column[0]} if long.instrument_column else set()
        return taken

    def _files(self) -> None:
        names = list(dict.fromkeys(table.file.name for table in self._tables))
        self.draft.put("files", names)
        sheets = list(dict.fromkeys(table.sheet for table in self._tables if table.sheet))
        if sheets:
            self.draft.put("sheets", sheets)
        read = self.table.reading
        values: dict[str, object] = {}
        alike_read = all(
            (t.reading.encoding, t.reading.separator) == (read.encoding, read.separator)
            for t in self._tables
        )
        if read.encoding is not None and alike_read and read.separator is not None:
            values["encoding"] = read.encoding.replace("utf-8-sig", "utf-8")
            values["separator"] = read.separator
        if read.decimal == ",":
            values["decimal"] = ","
        if self.table.file.suffix.lower() not in {".json", ".jsonl", ".ndjson"}:
            values["heading_rows"] = list(read.heading_rows or ())
        if read.skip_rows:
            values["skip_rows"] = list(read.skip_rows)
        if read.transpose:
            values["transpose"] = True
            question = "Do participants stand side by side, and items one below the other?"
            self.doubts.append(OpenDoubt(question, "they do; columns are read as rows"))
        if values:
            self.draft.put("read", values)
        if not read.heading_rows and "heading_rows" in values:
            question = f"{self.table.file.name} seems to have no headings: is its first row data?"
            self.doubts.append(
                OpenDoubt(question, "it is; columns are called column 1, column 2 …")
            )

    def _write(self) -> None:
        facts = self._moments()
        when = self._roles.facts.get("timepoint", [])
        if len(facts) == 1 and any(len(texts(self.table, column)) > 1 for column in when):
            facts[0].pop("timepoint", None)  # a column says it better
        self._course_facts = self._moments_of(
            [self._context_of(course) for course in self._courses]
        )
        said = {name for each in (*facts, *self._course_facts) for name in each}
        context, answers = self._context(), self._found_answers(said)
        exposures = draft_facts(context, answers)
        self.draft.values |= exposures.draft.values
        self.draft.comments |= exposures.draft.comments
        self.doubts += exposures.doubts
        self._leave_out(context.participant)
        self._questionnaires(facts)
        self._covariates(exposures)
        self._ignore(exposures)
        self.gives = bool(self.draft.lists or self.draft.values.get("participants"))

    def _moments(self) -> list[dict[str, str]]:
        """Return what the headings say of each block of answers (or, without any, of scores).

        Questionnaires of one instrument are told apart by their words, each instrument by itself.
        """
        found: Sequence[Found | FoundScores | FoundRating] = (
            self._blocks or self._scores or self._ratings
        )
        return self._moments_of([(each.instrument.name, each.context) for each in found])

    def _numbers(self) -> str:
        """Return what numbers in headings are: a column may say the condition already."""
        return "trial" if self._roles.facts.get("condition") else "condition"

    def _spelt(self, facts: dict[str, str]) -> dict[str, str]:
        """Return conditions with the capital letters that the headings have."""
        said = facts.get("condition", "")
        words = {
            word.casefold(): word
            for text in (*self.table.labels, *self.table.headings)
            for word in words_of(text)
        }
        parts = [words.get(word, word) for word in said.split("_")]
        if not said:
            return facts
        self.labels["_".join(parts)] = " ".join(parts)
        return {**facts, "condition": "_".join(parts)}

    def _context_of(self, course: Sequence[FoundRating]) -> tuple[str, tuple[str, ...]]:
        """Return the instrument of a rating time course, and the words of all its headings."""
        first, units = course[0], self._vocabulary.units
        words = tuple(word for word in first.context if not word.isdecimal() and word not in units)
        return first.instrument.name, words

    def _context(self) -> Context:
        time = next((r.time for r in self._ratings if r.time is not None), None)
        return Context(
            self.table, self._vocabulary, self._roles, one_row_each=not self._longs, time=time
        )

    def _found_answers(self, said: set[str]) -> AnswersFound:
        answered = any((self._blocks, self._longs, self._scores, self._ratings, self._courses))
        return AnswersFound(self._tables, said, self._taken, _row_keys(self._longs), answered)

    def _total_rows(self) -> dict[int, list[str]]:
        """Take rows of means and sums out of the table; return column → their texts."""
        for column in range(min(4, len(self.table.headings))):
            found = [
                text
                for table in self._tables
                for text in total_rows(table, column, self._vocabulary.totals)
            ]
            if found:
                rows = tuple(row for row in self.table.rows if row[column] not in found)
                self.table = replace(self.table, rows=rows)
                return {column: list(dict.fromkeys(found))}
        return {}

    def _fill_down(self) -> None:
        """Let blank cells of a column of participants mean the one above, where they are many."""
        first = range(min(4, len(self.table.headings)))
        columns = roles_of(self.table, first, self._vocabulary).facts.get("participant", [])
        for column in columns or ([0] if self.table.reading.transpose else []):
            cells = self.table.column(column)
            if cells[0] and cells.count("") * 4 >= len(cells):
                name, above, rows = self.table.headings[column], "", []
                for row in self.table.rows:
                    above = row[column] or above
                    rows.append((*row[:column], above, *row[column + 1 :]))
                self.table = replace(self.table, rows=tuple(rows))
                self.draft.put("fill_down", [name])
                question = f"Do the blank cells of {name!r} mean the participant above them?"
                self.doubts.append(OpenDoubt(question, "they do"))
                return

    def _leave_out(self, participant: int | None) -> None:
        out = dict(self._totals)
        if participant is not None and not all(self.table.column(participant)):
            out[participant] = [*out.get(participant, []), ""]
        if not out:
            return
        names = self.table.headings
        self.draft.put("leave_out", {names[c]: found for c, found in out.items()})
        for column, found in out.items():
            shown = ", ".join(repr(text) if text else "nothing" for text in found)
            question = (
                f"May the rows with {shown} in {names[column]!r} be left out, as no person's?"
            )
            self.doubts.append(OpenDoubt(question, "they are left out"))

    def _questionnaires(self, facts: Sequence[dict[str, str]]) -> None:
        drafts: list[TomlDraft] = []
        for block, own in zip(self._blocks, facts, strict=False):
            mended, doubts = mend_items(self.table, block, self._roles, self._vocabulary)
            self.doubts += doubts
            draft, doubts = draft_block(self.table, mended, own, self._known)
            drafts.append(draft)
            self.doubts += doubts
        for long in self._longs:
            draft, doubts = draft_long(self.table, long, self._known)
            drafts.append(draft)
            self.doubts += doubts
        rated = facts if not self._blocks and not self._scores else self._moments_of_ratings()
        for rating, own in zip(self._ratings, rated, strict=True):
            draft, doubts = draft_rating(self.table, rating, own, self._vocabulary)
            drafts.append(draft)
            self.doubts += doubts
        for course, own in zip(self._courses, self._course_facts, strict=True):
            draft, doubts = draft_course(self.table, course, own, self._vocabulary)
            drafts.append(draft)
            self.doubts += doubts
        self.doubts[:] = list(dict.fromkeys(self.doubts))
        if drafts:
            self.draft.lists["questionnaires"] = self._in_short(drafts, facts)
        self._score_tables([] if self._blocks else facts)

    def _in_short(
        self, drafts: list[TomlDraft], facts: Sequence[dict[str, str]]
    ) -> list[TomlDraft]:
        """Say questionnaires in one whose headings are made alike, and whose answers are."""
        count = len(self._blocks)
        names = {draft.values["instrument"] for draft in drafts[:count]}
        if count < 2 or len(names) > 1:
            return drafts
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

    def _moments_of_ratings(self) -> list[dict[str, str]]:
        """Return what the headings of ratings say, beside questionnaires that say their own."""
        return self._moments_of([(each.instrument.name, each.context) for each in self._ratings])

    def _moments_of(self, named: Sequence[tuple[str, tuple[str, ...]]]) -> list[dict[str, str]]:
        """Return what the words of headings say, of each instrument by itself."""
        facts: list[dict[str, str]] = [{} for _ in named]
        for name in dict.fromkeys(name for name, _ in named):
            places = [i for i, (other, _) in enumerate(named) if other == name]
            own, doubts = moments(
                [named[i][1] for i in places], self._vocabulary, numbers=self._numbers()
            )
            self.doubts += doubts
            for place, said in zip(places, own, strict=True):
                facts[place] = self._spelt(said)
        return facts

    def _score_tables(self, facts: Sequence[dict[str, str]]) -> None:
        """Keep scores of instruments whose answers are not there."""
        answered = {block.instrument.name for block in self._blocks}
        answered |= {long.instrument.name for long in self._longs}
        kept = [each for each in self._scores if each.instrument.name not in answered]
        self._made = [each for each in self._scores if each.instrument.name in answered]
        drafts = []
        asked: dict[str, list[str]] = {}
        own = list(facts) if facts else [{} for _ in kept]
        for each, said in zip(kept, own, strict=False):
            kind = kind_of(self.table, each)
            scales = {scale: self.table.headings[c] for scale, c in each.scales.items()}
            draft = TomlDraft({"instrument": each.instrument.name, **said, "kind": kind})
            draft.note("The answers are not in the file: scores alone.")
            draft.tables["scales"] = TomlDraft(dict(scales))
            drafts.append(draft)
            what = {"raw_sum": "raw sums", "score": "scores by the published formula"}.get(
                kind, "scores by another formula"
            )
            asked.setdefault(f"{what} of the {each.instrument.short}", []).extend(scales.values())
        for what, names in asked.items():
            question = f"{', '.join(names)}: are these {what}?"
            self.doubts.append(OpenDoubt(question, f"they are {what}; the answers are not there"))
        if drafts:
            self.draft.lists["scores"] = drafts

    def _covariates(self, exposures: DraftedFacts) -> None:
        if exposures.context.covariates:
            names = {n: self.table.headings[c] for n, c in exposures.context.covariates.items()}
            self.draft.put("participants", names)
        if exposures.context.participant is not None:
            groups = alike(dict.fromkeys(self.table.column(exposures.context.participant)))
            if groups:
                shown = "; ".join(" and ".join(map(repr, group)) for group in groups)
                one = {other: group[0] for group in groups for other in group[1:]}
                said = "they are not; `values` of participant make them one: "
                question = f"Are these participants one person each: {shown}?"
                self.doubts.append(OpenDoubt(question, f"{said}values = {toml_value(one)}"))

    def _ignore(self, exposures: DraftedFacts) -> None:
        """List every column that nothing was said of, with the reason."""
        made = {c: "a score made of the answers" for e in self._made for c in e.scales.values()}
        rest = [
            column
            for column in (*self._roles.metadata, *self._roles.unknown, *exposures.unused, *made)
            if column not in exposures.context.used
        ]
        columns = sorted(set(rest))
        if not columns:
            return
        asked = [column for column in columns if column not in self._roles.metadata]
        reasons, doubts = leftovers(self.table, asked, self._blocks, self._vocabulary)
        self.doubts += doubts
        for column in columns:
            name = self.table.headings[column]
            reason = reasons.get(column) or made.get(column, "")
            if is_personal(name, self._vocabulary):
                reason = "may tell who the person is"
            if reason:
                self.draft.note(f"{name}: {reason}", "ignore")
        self.draft.put("ignore", [self.table.headings[column] for column in columns])
