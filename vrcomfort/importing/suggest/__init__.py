"""Writes a mapping from a lab's files, with the doubts that they leave."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.importing.convert import import_files
from vrcomfort.importing.files import (
    as_table,
    is_number,
    marked_runs,
    numbers_in,
    read_grids,
    repeated_runs,
)
from vrcomfort.importing.mapping import parse_mapping
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.sections import sections
from vrcomfort.importing.source import Grid, Reading, SourceTable
from vrcomfort.importing.suggest.codebooks import is_codebook, with_codebooks
from vrcomfort.importing.suggest.draft import (
    CONDITIONS,
    LOST,
    NO_LABEL,
    REFUSED,
    ROWS,
    OpenDoubt,
    listed,
    pattern_of,
    write_doubts,
)
from vrcomfort.importing.suggest.found_answers import mentions
from vrcomfort.importing.suggest.groups_of_files import (
    say_baselines,
    say_conditions_of_files,
    say_groups,
    say_moments_of_files,
    say_names_of_files,
)
from vrcomfort.importing.suggest.heading_roles import names_fact
from vrcomfort.importing.suggest.joined_tables import joined
from vrcomfort.importing.suggest.left_over import ask_to_leave_out
from vrcomfort.importing.suggest.left_over_drafts import with_left_over
from vrcomfort.importing.suggest.long_tables import stands_on_its_side
from vrcomfort.importing.suggest.names_of_files import excluded_files
from vrcomfort.importing.suggest.own_instruments import AnswerRange, declaration, questions_of
from vrcomfort.importing.suggest.same_conditions import say_same_conditions
from vrcomfort.importing.suggest.same_people import (
    count_exposures,
    say_contradictions,
    say_others,
    say_same_people,
    without_unnamed_people,
)
from vrcomfort.importing.suggest.summary_rows import means_below
from vrcomfort.importing.suggest.table_draft import TableDraft
from vrcomfort.importing.suggest.vocabulary import (
    Known,
    LabVocabulary,
    read_vocabulary,
    shipped_vocabulary,
)
from vrcomfort.importing.toml_draft import TomlDraft
from vrcomfort.json_text import escape_surrogates
from vrcomfort.questionnaire import Instrument, usual_instruments

_TOP = (
    "What the columns of these files mean, as `vrcomfort import --suggest` understood them.",
    "Read it, mend what is wrong, and write an answer in each [[doubts]] below: while one is",
    "open, the import is refused. Where an assumption is wrong, write what `instead` says: here,",
    "or into words.toml, and suggest anew with --vocabulary words.toml (`vrcomfort docs import`).",
    "Every key: `vrcomfort docs import_mapping`.",
)


_REFUSED_WITH = "with such columns as outcomes the import refuses the files"
_REFUSAL = "As it stands, the import refuses the files; mend this:"


@dataclass(frozen=True)
class Suggestion:
    """A mapping that is to be read by a person.

    Parameters
    ----------
    text
        TOML.
    doubts
        The weightiest questions that it leaves open, with what it takes for granted.
    guesses
        How many others there are, answered by a guess.
    notes
        What was found out while reading.
    imported
        What the mapping makes of the files as it stands; None where it is refused.
    """

    text: str
    doubts: tuple[str, ...]
    guesses: int
    notes: tuple[str, ...]
    imported: Imported | None


def suggest_mapping(
    files: Sequence[Path],
    own: Mapping[str, Instrument] | None = None,
    vocabularies: Sequence[Path] = (),
) -> Suggestion:
    """Write a mapping from files.

    Parameters
    ----------
    own
        File → instrument that is not shipped, and may be meant as well.
    vocabularies
        A lab's own vocabulary files, which win over the shipped ones.

    Raises
    ------
    InputError
        If a file cannot be read, or a vocabulary is wrong; with line and column.
    """
    words = LabVocabulary([*map(read_vocabulary, vocabularies)]) if vocabularies else None
    known = Known((*(own or {}).values(), *usual_instruments()), words or shipped_vocabulary())
    read = with_codebooks([table for file in files for table in _tables(file, known)])
    taken = _suggested(files, own or {}, known, read)
    if taken.imported is None:
        without = _suggested(files, own or {}, known, read, left_over=False)
        return taken if without.imported is None else without
    return taken


def _suggested(
    files: Sequence[Path],
    own: Mapping[str, Instrument],
    known: Known,
    read: Sequence[SourceTable],
    *,
    left_over: bool = True,
) -> Suggestion:
    """Write a mapping, with the columns that no rule knows or without them."""
    excluded, left_out = excluded_files(read, known.vocabulary)
    read = [table for table in read if table.file not in excluded]
    drafts = joined([TableDraft(tables, known) for tables in _alike(read)], known)
    alone = len(drafts) == 1 or all(draft.people is None for draft in drafts)
    if left_over:
        drafts = [with_left_over(draft, known, alone=alone) for draft in drafts]
    books = [d for d in drafts if is_codebook(d.table, read, people=d.people is not None)]
    useful = without_unnamed_people([d for d in drafts if d.gives and d not in books] or drafts)
    say_names_of_files(useful)
    say_groups(useful, [d for d in drafts if d not in useful], known.vocabulary)
    say_moments_of_files(useful, known.vocabulary)
    say_conditions_of_files(useful, known.vocabulary)
    say_baselines(useful)
    say_others(useful)
    top = _top(files, own, useful)
    ignored: list[OpenDoubt] = []

    def tried() -> tuple[Imported, None] | tuple[None, InputError]:
        """Import the files by the mapping as it is; return the import, or its refusal."""
        ignored[:] = _ignored_sheets(top, drafts, useful, excluded)
        top.lists["tables"] = [draft.draft for draft in useful]
        try:
            mapping = parse_mapping(top.text(), None)
            return import_files(files, mapping, [*own.values()]), None
        except InputError as error:
            return None, error

    imported, refusal = tried()
    if refusal is not None and (say_contradictions(useful) or count_exposures(useful, refusal)):
        imported, refusal = tried()
    if again := _said_again(useful, imported):
        useful[:] = [draft for draft in useful if draft not in again]
        imported, refusal = tried()
    for say_same in (say_same_conditions, say_same_people):
        if imported is not None and say_same(useful, imported):
            imported, refusal = tried()
    levels = {name: said for draft in useful for name, said in draft.levels.items()}
    crossed = len({frozenset(said) for said in levels.values()}) == 1
    if crossed and imported is not None and {*imported.conditions} == levels.keys():
        top.tables["condition_levels"] = TomlDraft(dict(levels))
    doubts = list(dict.fromkeys(doubt for draft in useful for doubt in draft.doubts))
    doubts += [*ignored, *left_out, *_unanswered(drafts, known)]
    for draft in useful if not left_over else ():
        doubts += ask_to_leave_out(draft.table, dict.fromkeys(draft.left, _REFUSED_WITH))
    if unused := known.vocabulary.without_use(read):
        names = listed([*map(repr, unused)], _SHOWN)
        question = f"No column is called {names}, as words.toml says: is it in other files?"
        doubts.append(OpenDoubt(question, "it is: nothing is changed by it", NO_LABEL))
    doubts += _ask_of_lost(imported) if imported is not None else ()
    if refusal is not None:
        # The user has the files, and not the lines of a mapping that is not written yet.
        message = refusal.message if refusal.file is None else str(refusal)
        doubts.append(OpenDoubt(_REFUSAL, message, REFUSED))
    asked = write_doubts(top, doubts)
    notes = tuple(dict.fromkeys(note for table in read for note in table.notes))
    return Suggestion(
        escape_surrogates(top.text()),
        tuple(doubt.words for doubt in asked),
        len(top.lists.get("guesses", ())),
        notes,
        imported,
    )


def _alike(tables: Sequence[SourceTable]) -> list[list[SourceTable]]:
    """Return the tables of the same headings in the same rows together."""
    groups: dict[tuple[object, ...], list[SourceTable]] = {}
    for table in tables:
        rows = None if table.reading.sections else table.reading.heading_rows
        groups.setdefault((table.headings, rows, table.reading.skip_rows), []).append(table)
    return [*groups.values()]


def _top(files: Sequence[Path], own: Collection[str], drafts: Sequence[TableDraft]) -> TomlDraft:
    """Draft what the mapping says before its tables."""
    top = TomlDraft({"format_version": 1, "name": files[0].stem})
    if own:
        top.put("instruments", list(own))
    labels = {name: label for draft in drafts for name, label in draft.labels.items()}
    if any(name != label for name, label in labels.items()):
        top.put("condition_labels", labels)
    for line in _TOP:
        top.note(line, "format_version")
    _declare(top, drafts)
    return top


def _ask_of_lost(imported: Imported) -> Iterator[OpenDoubt]:
    """Ask about rows and people without answers, if not a few, and answers of no condition."""
    lost = [each for each in imported.lost if each.rows * _FEW_IN > each.of]
    if lost:
        texts = [*dict.fromkeys(text for each in lost for text in each.texts)]
        names = [each.table for each in lost]
        rows, of = sum(each.rows for each in lost), sum(each.of for each in lost)
        shown = listed([*map(repr, texts)], _SHOWN)
        what = f"{rows} of {of} rows of {listed(names, _SHOWN)} ({shown})"
        question = f"May {what} be left out? They are in no questionnaire."
        yield OpenDoubt(question, "yes", LOST)
    said = {name for name, m in imported.responses if m.condition}
    after = ((name, m) for name, m in imported.responses if m.timepoint != "baseline")
    blank = [m.participant for name, m in after if name in said and not m.condition]
    if blank:
        who = listed([*dict.fromkeys(blank)], _SHOWN)
        question = f"Of which condition are {len(blank)} questionnaires after exposure ({who})?"
        yield OpenDoubt(question, "of none, as nothing says it: no comparison has them", CONDITIONS)
    if len(imported.silent) * _FEW_IN > len(imported.participants):
        who = f"{len(imported.silent)} of {len(imported.participants)} participants"
        question = f"Have {who} no answers ({listed(imported.silent, _SHOWN)})?"
        yield OpenDoubt(question, "they have none", LOST)


_FEW_IN, _SHOWN = 20, 5


def _declare(top: TomlDraft, drafts: Sequence[TableDraft]) -> None:
    """Declare the lab's own questions; those of several tables together if they are the same.

    A table may lack some of another's questions, where these have words.
    """
    declared: dict[str, dict[str, tuple[str, AnswerRange]]] = {}
    for draft in drafts:
        for each in draft.own:
            said = questions_of(each)
            names = (each.name, *(f"{each.name}_{n}" for n in range(2, 10_000)))
            name = next(n for n in names if n not in declared or _are_same(declared[n], said))
            if name != each.name:
                draft.rename(each.name, name)
            there = declared.setdefault(name, {})
            for item, (text, scale) in said.items():
                there[item] = (text, there[item][1] | scale if item in there else scale)
    for draft in drafts:
        for name, items in declared.items():
            draft.lack(name, [*items])
    tables = [
        declaration(name, [(item, *said) for item, said in items.items()])
        for name, items in declared.items()
    ]
    files = top.values.pop("instruments", None)
    if isinstance(files, list):
        own = [{**t.values, "items": [i.values for i in t.lists["items"]]} for t in tables]
        top.put("instruments", [*files, *own])
    elif tables:
        top.lists["instruments"] = tables


def _are_same(one: Collection[str], two: Collection[str]) -> bool:
    """Return whether the items are those of a declared instrument, or some, told by words."""
    a, b = {*one}, {*two}
    worded = not any(name[-1].isdecimal() for name in a | b)
    return a == b or (worded and len(a & b) > 1 and (a < b or b < a))


def _unanswered(drafts: Sequence[TableDraft], known: Known) -> list[OpenDoubt]:
    """Ask about instruments that files name, but to which no answers were found."""
    answered = {name for draft in drafts for name in draft.answered}
    named = {name for draft in drafts for name in draft.unanswered} - answered
    return [
        OpenDoubt(
            f"The files name the {each.short}, but no answers to it were found: are there none?",
            "there are none; else say under tables.questionnaires which columns hold them",
            ROWS,
        )
        for each in known.instruments
        if each.name in named
    ]


def _tables(file: Path, known: Known) -> list[SourceTable]:
    grids = [grid for grid in read_grids(file, Reading()) if grid.rows]
    grids = [grid for grid in grids if len(grid.rows) > 1] or grids  # a legend is no table
    parts = [sections(grid) for grid in grids]
    if any(len(each) > 1 for each in parts):
        grids = [replace(g, reading=g.reading._replace(sections=True)) for p in parts for g in p]
    return [_table(grid, known) for grid in grids]


def _table(grid: Grid, known: Known) -> SourceTable:
    """Read a sheet, on its side or stacked where people stand so."""
    reading = grid.reading._replace(transpose=stands_on_its_side(grid, known))
    table = as_table(replace(grid, reading=reading))
    if marked_runs(table.headings, table.rows):
        reading = reading._replace(marked=True)
        table = as_table(replace(grid, reading=reading))
    if (lists := _lists_of_answers(table, known)) and not any(table.labels):
        reading = reading._replace(spread=lists)
        table = as_table(replace(grid, reading=reading))
    bare = [re.sub(r" \(\d+\)$|^column \d+$", "", heading) for heading in table.headings]
    named = any(names_fact(heading, "participant", known.vocabulary) for heading in bare)
    if not named and (below := means_below(table)):
        reading = table.reading._replace(skip_rows=(*table.reading.skip_rows, *below))
        table = as_table(replace(grid, reading=reading))
    starts = repeated_runs(bare)
    if len(starts) > 1 and (
        names_fact(bare[0], "participant", known.vocabulary) or _name_runs(table, starts)
    ):
        return as_table(replace(grid, reading=reading._replace(stack=True)))
    return table


def _name_runs(table: SourceTable, starts: Sequence[int]) -> bool:
    """Return whether the first column of each run of headings has one word, another for each."""
    said = [{*table.column(start)} - {""} for start in starts]
    words = {text for each in said for text in each if not is_number(text)}
    return len(words) == len(said) and all(len(each) == 1 for each in said)


def _lists_of_answers(table: SourceTable, known: Known) -> tuple[str, ...]:
    """Return columns called after a questionnaire, with a number for each item in every cell.

    None are where rows repeat them, as those of a list inside a record do.
    """
    found = []
    for heading, texts in zip(table.headings, table.texts, strict=True):
        named = mentions(heading, known.instruments) if texts and numbers_in(texts[0]) else ()
        items = {len(each.asked) for each in known.instruments if each.name in named}
        if len(items) == 1 and {len(numbers_in(text)) for text in texts} == items:
            if 2 * len(texts) < len(table.rows):
                return ()
            found.append(heading)
    return tuple(found)


def _said_again(useful: Sequence[TableDraft], imported: Imported | None) -> list[TableDraft]:
    """Return the drafts of sheets that say the answers of another again: recoded, or as scores."""
    said: dict[tuple[str, str], dict[str, Counter[object]]] = {}
    answered = {*imported.responses} if imported else set()
    scored: dict[tuple[str, str], list[bool]] = {}
    for (instrument, m), response in (imported.responses if imported else {}).items():
        place = response.place.file, response.place.sheet
        of_sheet = said.setdefault(place, {})
        of_sheet.setdefault(instrument, Counter()).update(response.answers.items())
        base = _MADE_OF.sub("", instrument)
        scored.setdefault(place, []).append(base != instrument and (base, m) in answered)
    again: list[TableDraft] = []
    earlier: list[dict[str, Counter[object]]] = []
    for draft in useful:
        places = {(table.file.name, table.sheet) for table in draft.tables}
        mine: dict[str, Counter[object]] = {}
        for place in places:
            for name, counts in said.get(place, {}).items():
                mine.setdefault(name, Counter()).update(counts)
        repeats = (
            sum(counts.values()) >= _FEWEST_ALIKE and any(e.get(name) == counts for e in earlier)
            for name, counts in mine.items()
        )
        made = [each for place in places for each in scored.get(place, ())]
        only = "participants" not in draft.draft.values and made and all(made)
        if (draft.table.sheet and mine and all(repeats)) or only:
            again.append(draft)
        earlier.append(mine)
    return again


_MADE_OF = re.compile("_(scores|raw_sums|other_scores)$")
"""What an instrument of scores has behind the name of the one that they are of."""
_FEWEST_ALIKE = 24
"""Answers to an instrument, in two sheets, that are equally often there by no chance."""


def _ignored_sheets(
    top: TomlDraft, drafts: list[TableDraft], useful: list[TableDraft], excluded: Sequence[Path]
) -> list[OpenDoubt]:
    """List sheets and files without answers or people, and ask about them."""
    if excluded:
        top.put("ignore_files", [pattern_of(file.name) for file in excluded])
    doubts = []
    rest = [draft for draft in drafts if draft not in useful]
    used = {name for draft in useful for name in draft.files}
    there = {table.sheet for draft in useful for table in draft.tables}
    sheets = [d.table.sheet for d in rest if d.table.sheet and d.table.sheet not in there]
    files = [name for draft in rest for name in draft.files if name not in used]
    for what, others in (("sheets", sheets), ("files", files)):
        if others:
            names = [*others, *(file.name for file in excluded if what == "files")]
            top.put(f"ignore_{what}", [*map(pattern_of, dict.fromkeys(names))])
            shown = ", ".join(dict.fromkeys(others))
            question = f"May the {what} {shown} be left out? No answers were understood in them."
            doubts.append(OpenDoubt(question, "yes", ROWS))
    return doubts
