"""Makes a study of files that are none: through a plan's mapping, or where nothing is doubtful."""

from __future__ import annotations

import shlex
from pathlib import Path

from vrcomfort.cli.terminal import warn
from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError

IMPORTED = "imported"
"""The folder inside the report that holds what was read of such a file, and how."""


def study_of(source: Path, out: Path) -> Path:
    """Return what a report is made from: a folder or tidy file as it is, else its import.

    Parameters
    ----------
    out
        The report's folder, in which the import is kept.

    Raises
    ------
    InputError
        If a mapping is needed, with the command that writes one.
    """
    if not source.is_file() or _is_tidy(source):
        return source
    from vrcomfort.importing import MappingFile, parse_mapping, write_study
    from vrcomfort.importing.suggest import suggest_mapping

    found = suggest_mapping([source])
    if found.doubts or found.imported is None:
        raise InputError(_needs_mapping(source, found.doubts), file=source)
    mapping = parse_mapping(found.text, None)
    file = MappingFile(mapping, Path("suggested.toml"), found.text)
    folder = out / IMPORTED
    write_study(folder, found.imported, file, [source])
    for note in (*found.notes, *found.imported.notes):
        warn(note)
    warn(f"{source}: understood without a mapping; how, {folder / 'mapping.toml'} says")
    return folder


def study_of_plan(plan: str | None, out: Path) -> Path:
    """Return the import of the files that a plan names, kept in the report's folder.

    Raises
    ------
    InputError
        If there is no plan or it names no files, or they are not as their mapping says.
    """
    from vrcomfort.report.plan import data_files
    from vrcomfort.report.plan_files import find_plan

    if plan is None:
        raise InputError("give a study, or a --plan that names files in [data]")
    file = find_plan(plan)
    named = data_files(file)
    if named is None:
        message = "this plan names no files; give the study, or add [data] with files and mapping"
        raise InputError(message, file=file)
    from vrcomfort.importing import import_files, load_mapping, write_study

    files, mapping = named
    loaded = load_mapping(mapping)
    imported = import_files(files, loaded.mapping, loaded.instruments)
    for note in imported.notes:
        warn(note)
    write_study(out / IMPORTED, imported, loaded, files)
    return out / IMPORTED


def _is_tidy(file: Path) -> bool:
    """Return whether a file has the columns of ``questionnaires.csv``, or some of them."""
    try:
        first = next(CsvTable.parts(file, appended=True, most_rows=1))
        header = {name.lower() for name in first.header}
    except InputError:
        return False
    return not header or bool({"item", "response"} & header)


def _needs_mapping(source: Path, doubts: tuple[str, ...]) -> str:
    words = f"vrcomfort import {shlex.quote(str(source))} --suggest --out map.toml"
    if not doubts:
        return f"no questionnaire was found in this file; to say what is in it: {words}"
    others = f" (and {len(doubts) - 1} more)" if len(doubts) > 1 else ""
    return f"this file needs a mapping, for this is doubtful: {doubts[0]}{others} Write it: {words}"
