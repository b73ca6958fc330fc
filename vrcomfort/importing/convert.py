"""From a lab's tables and a mapping to answers, scores, ratings and participants."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.importing.courses import sum_up
from vrcomfort.importing.facts import Numbers
from vrcomfort.importing.files import as_table, read_grids
from vrcomfort.importing.mapping import (
    Mapping,
    Table,
)
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suspects import suspects
from vrcomfort.importing.table_import import Made, TableImport
from vrcomfort.importing.unmatched import texts_in, unmatched
from vrcomfort.questionnaire import Instrument, shipped_instruments


def import_files(
    files: Sequence[Path], mapping: Mapping, own: Sequence[Instrument] = ()
) -> Imported:
    """Read files as a mapping says.

    Parameters
    ----------
    own
        Instruments that are not shipped.

    Raises
    ------
    InputError
        If a file has no table in the mapping or a table no file, a column is not said anything
        of, or a cell is not what it should be; with file, row and column.
    """
    imported = Imported()
    numbers = Numbers()
    made = Made()
    known = {**shipped_instruments(), **{each.name: each for each in own}}
    _require_names(files)
    used: set[int] = set()
    seen: list[set[tuple[str, str]]] = [set() for _ in mapping.tables]
    for file in files:
        found = [i for i, each in enumerate(mapping.tables) if _is_of(file, each)]
        if not found:
            raise InputError("no table of the mapping names this file; add it", file=file)
        used.update(found)
        taken = []
        for index in found:
            table = mapping.tables[index]
            for each in _sheets(file, table):
                taken.append(TableImport(each, table, known, imported, numbers, made).run())
                seen[index] |= texts_in(each, table)
        _require_sheets(file, mapping, [sheet for sheet in taken if sheet])
    for index, table in enumerate(mapping.tables):
        if index not in used:
            names = ", ".join(table.files)
            raise InputError(f"the mapping has a table for {names}, which was not given; give it")
    mapping.require_none(unmatched(mapping, seen, known, imported.conditions))
    imported.instruments = {each.name: each for each in own}
    imported.instruments |= {name: each.made() for name, each in made.scores.items()}
    imported.scores = list(made.scores)
    sum_up(imported, made.courses, known)
    _finish(imported)
    return imported


def _require_names(files: Sequence[Path]) -> None:
    twice = [name for name, count in Counter(file.resolve() for file in files).items() if count > 1]
    if twice:
        raise InputError("this file is given twice", file=twice[0])


def _is_of(file: Path, table: Table) -> bool:
    return any(fnmatchcase(file.name, pattern) for pattern in table.files)


def _sheets(file: Path, table: Table) -> list[SourceTable]:
    grids = read_grids(file, table.read.reading)
    kept = [g for g in grids if not g.sheet or any(fnmatchcase(g.sheet, p) for p in table.sheets)]
    return [as_table(grid) for grid in kept]


def _require_sheets(file: Path, mapping: Mapping, taken: Sequence[str]) -> None:
    """Raise `InputError` where a sheet of a workbook is left out without a word."""
    if file.suffix.lower() not in {".xlsx", ".xlsm"}:
        return
    for grid in read_grids(file, mapping.tables[0].read.reading):
        ignored = any(fnmatchcase(grid.sheet, pattern) for pattern in mapping.ignore_sheets)
        if grid.sheet not in taken and not ignored:
            message = f"the sheet {grid.sheet!r} is in no table of the mapping"
            raise InputError(f"{message}; add it, or list it under ignore_sheets", file=file)


def _finish(imported: Imported) -> None:
    """Add who has answers and no covariates, and tell of ids that may be one person."""
    people = [moment.participant for _, moment in imported.sheets]
    people += [rating.moment.participant for rating in imported.ratings]
    answered = dict.fromkeys(people)
    silent = [name for name in imported.participants if name not in answered]
    if silent:
        shown = ", ".join(silent[:5]) + (" …" if len(silent) > 5 else "")
        imported.notes.append(f"{len(silent)} participants have no answers: {shown}")
    for name in answered:
        imported.participants.setdefault(name, {})
    imported.notes += suspects(imported.participants)
