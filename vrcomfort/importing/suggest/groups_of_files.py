"""Finds the conditions of people whom other files, which give no answers, list group by group."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import combinations

from vrcomfort.importing.mapping import template_pattern
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.cells import MOST_CONDITIONS, few_texts, texts
from vrcomfort.importing.suggest.draft import CONDITIONS, TIMEPOINTS, OpenDoubt
from vrcomfort.importing.suggest.heading_roles import roles_of
from vrcomfort.importing.suggest.names_of_files import parts_of_names
from vrcomfort.importing.suggest.table_draft import TableDraft
from vrcomfort.importing.suggest.vocabulary import LabVocabulary, tokens

_BESIDE_A_WORD = re.compile(r"[^{]*\w[^{]*\{condition\}|\{condition\}[^{]*\w{3}[^{]*$")
_FEWEST = 2
"""People of a group."""


def say_names_of_files(drafts: Sequence[TableDraft]) -> None:
    """Let the name of a file say its condition, where it is made as those of others are.

    A word stands beside the condition: others may have any name.
    """
    templates = dict.fromkeys(
        template
        for draft in drafts
        if isinstance(template := draft.draft.values.get("file_name"), str)
        if _BESIDE_A_WORD.match(template) and "/" not in template
    )
    for draft in drafts:
        if draft.draft.values.get("condition") != _ALL or "file_name" in draft.draft.values:
            continue
        stems = [table.file.stem for table in draft.tables]
        for template in templates:
            if all(map(template_pattern(template).fullmatch, stems)):
                draft.draft.put("file_name", template)
                del draft.draft.values["condition"]
                draft.doubts = [d for d in draft.doubts if not d.question.startswith(_ONE)]


def say_groups(
    drafts: Sequence[TableDraft], others: Sequence[TableDraft], vocabulary: LabVocabulary
) -> None:
    """Let files that list other people each say the condition of drafts that have none; and ask.

    So does a table with a row for each person, and a column for the condition or the group.
    """
    for draft in drafts:
        column = draft.column_of("participant")
        if draft.draft.values.get("condition") != _ALL or column is None:
            continue
        people = _people(draft)
        for other in (*others, *drafts):
            groups = {} if other is draft else _groups(other.tables, column)
            groups = groups or _groups_in(other.table, column, vocabulary)
            if groups and people <= {person for group in groups.values() for person in group}:
                values = {p: name for name, group in groups.items() for p in group if p in people}
                draft.draft.put("condition", {"column": column, "values": values})
                draft.doubts = [d for d in draft.doubts if not d.question.startswith(_ONE)]
                shown = "; ".join(f"{name}: {', '.join(g[:3])} …" for name, g in groups.items())
                question = f"Are people's conditions those of other tables ({shown})?"
                draft.doubts.append(OpenDoubt(question, "they are, between people", CONDITIONS))
                break


_ONE = "No column says the condition"


def _groups_in(table: SourceTable, heading: str, vocabulary: LabVocabulary) -> dict[str, list[str]]:
    """Return condition → its people, of a table with a row for each person."""
    if heading not in table.headings:
        return {}
    people = table.column(table.headings.index(heading))
    roles = roles_of(table, range(len(table.headings)), vocabulary)
    columns = [*roles.facts.get("condition", ()), *filter(None, [roles.covariates.get("group")])]
    columns = [c for c in columns if few_texts(table, c)]
    crossed = any({*texts(table, c)} == {*texts(table, columns[0])} for c in columns[1:])
    if not columns or crossed or len({*people}) < len(people):
        return {}
    groups: dict[str, list[str]] = {}
    for person, text in zip(people, table.column(columns[0]), strict=True):
        if name := table.meaning(columns[0], text):
            groups.setdefault(name, []).append(person)
    return groups


def say_moments_of_files(drafts: Sequence[TableDraft], vocabulary: LabVocabulary) -> None:
    """Let names such as ``pre_study`` and ``post_study`` of files say the moment; and ask."""
    said: dict[str, str] = {}
    silent: list[tuple[TableDraft, str]] = []
    others = []
    for draft in [draft for draft in drafts if not draft.table.sheet]:
        stems = [table.file.stem for table in draft.tables]
        moments = {stem: when for stem in stems if (when := vocabulary.timepoint(stem))}
        if draft.draft.values.get("timepoint") != _AFTER:
            continue
        if len({*moments.values()}) == 1:
            silent.append((draft, next(iter(moments.values()))))
            said |= moments
        else:
            others.append((draft, stems))
    after = {_without_moment(s, vocabulary) for s, when in said.items() if when == "post"}
    for draft, stems in others:  # answers_post beside answers
        if {_without_moment(stem, vocabulary) for stem in stems} <= after:
            silent.append((draft, "baseline"))
            said |= dict.fromkeys(stems, "baseline")
    if len({*said.values()}) < 2:
        return
    for draft, when in silent:
        del draft.draft.comments["timepoint"]
        draft.draft.put("timepoint", {"constant": when})
    question = f"Do the names of the files say the moment ({', '.join(said)})?"
    assumed = ", ".join(f"{stem} is {when}" for stem, when in said.items())
    silent[0][0].doubts.append(OpenDoubt(question, f"they do: {assumed}", TIMEPOINTS))


def say_conditions_of_files(drafts: Sequence[TableDraft], vocabulary: LabVocabulary) -> None:
    """Let files that ask the same people some of the same say the condition by their names; ask."""
    silent = [d for d in drafts if d.draft.values.get("condition") == _ALL]
    alone = [d for d in silent if len(d.files) == 1]
    alike = [d for d in alone if any(_ask_the_same(d, other) for other in alone if other is not d)]
    stems = [draft.table.file.stem for draft in alike]
    parts = parts_of_names(stems, ["condition"], vocabulary) if len(alike) > 1 else None
    if parts is None or len({*stems}) < len(stems):
        return
    for draft in alike:
        draft.draft.put("file_name", parts.template)
        del draft.draft.values["condition"]
        draft.doubts = [d for d in draft.doubts if not d.question.startswith(_ONE)]
    question = f"Do the names of the files say the condition ({', '.join(stems)})?"
    assumed = f"they do: {', '.join(parts.texts['condition'])}"
    alike[0].doubts.append(OpenDoubt(question, assumed, CONDITIONS))


def _people(draft: TableDraft) -> set[str]:
    """Return the codes of people in a draft's table; nothing where no column has them."""
    column = draft.column_of("participant")
    return {*texts(draft.table, draft.table.headings.index(column))} if column else set()


def _ask_the_same(one: TableDraft, other: TableDraft) -> bool:
    """Return whether two drafts have items in common, and people who answer them."""
    asked = [
        {
            (q.values["instrument"], item)
            for q in draft.draft.lists.get("questionnaires", ())
            for item in (q.tables["items"].values if "items" in q.tables else ())
        }
        for draft in (one, other)
    ]
    when = one.draft.values.get("timepoint") == other.draft.values.get("timepoint")
    return bool(_people(one) & _people(other)) and when and len(asked[0] & asked[1]) > 1


def _without_moment(stem: str, vocabulary: LabVocabulary) -> tuple[str, ...]:
    return tuple(word for word in tokens(stem) if word not in vocabulary.timepoints)


_AFTER = {"constant": "post"}


def say_baselines(drafts: Sequence[TableDraft]) -> None:
    """Let baselines in a file of their own be of no condition, where other files have some."""
    for draft in drafts:
        when = draft.draft.values.get("timepoint")
        whole = when.get("constant") if isinstance(when, dict) else None
        each = [part for parts in draft.draft.lists.values() for part in parts]
        before = all(part.values.get("timepoint", whole) == "baseline" for part in each)
        others = [d for d in drafts if d is not draft and d.draft.values.get("condition") != _ALL]
        if before and others and draft.draft.values.get("condition") == _ALL:
            del draft.draft.values["condition"]
            draft.doubts = [d for d in draft.doubts if not d.question.startswith(_ONE)]


_ALL = {"constant": "all"}


def _groups(tables: Sequence[SourceTable], heading: str) -> dict[str, list[str]]:
    """Return name of the file or sheet → its people; nothing where two share some."""
    if not 1 < len(tables) <= MOST_CONDITIONS or heading not in tables[0].headings:
        return {}
    column = tables[0].headings.index(heading)
    files = {table.file for table in tables}
    groups = {
        (each.file.stem if len(files) == len(tables) else each.sheet): texts(each, column)
        for each in tables
    }
    apart = all(not {*one} & {*other} for one, other in combinations(groups.values(), 2))
    several = all(len(group) >= _FEWEST for group in groups.values())
    return groups if apart and several and len(groups) == len(tables) else {}
